use super::*;
use crate::report::tradeoff::sample;

fn verdict(results: &Results, name: &str) -> Verdict {
    let findings = judge(results);
    findings.iter().find(|finding| finding.name == name).expect(name).verdict
}

fn with_runs(results: &Results, of: impl Fn(&Measured) -> Vec<f64>) -> Results {
    let mut results = results.clone();
    results.measured.iter_mut().for_each(|point| point.decode.runs = of(point));
    results
}

const TIMED: [&str; 3] = ["short_windows_decoding", "cells_time_over_size", "functions_faster_than_codes"];

#[test]
fn what_is_so_is_found_and_what_is_not_is_not() {
    use Verdict::{Found, NotFound, NotMeasured};
    let results = sample::paper();
    let findings = judge(&results);
    assert!(findings.iter().all(|finding| finding.verdict == Found), "{findings:#?}");
    let nothing = Results { measured: vec![], tiles: None, ..results.clone() };
    assert!(judge(&nothing).iter().all(|finding| finding.verdict == NotMeasured));

    // The same with bytes and times turned round.
    let mut turned = with_runs(&results, |point| point.decode.runs.iter().map(|seconds| 0.01 / seconds).collect());
    for point in &mut turned.measured {
        point.sizes.container = 100_000_000_000 / point.sizes.container;
    }
    for finding in judge(&turned).iter().filter(|finding| finding.name != "bc4w_few_bad_few_perfect") {
        assert_eq!(finding.verdict, NotFound, "{finding:#?}");
    }
    for name in TIMED {
        assert_eq!(verdict(&with_runs(&results, |_| vec![0.01; 3]), name), NotFound, "{name}");
        assert_eq!(verdict(&with_runs(&results, |_| vec![]), name), NotMeasured, "{name}");
    }
}

#[test]
fn a_difference_within_the_spread_is_no_finding() {
    let results = sample::paper();
    let noisy = with_runs(&results, |point| {
        let median = point.decode.median().unwrap_or(1.0);
        vec![median / 100.0, median, median * 100.0]
    });
    assert_eq!(verdict(&noisy, "short_windows_decoding"), Verdict::NotFound);
    assert_eq!(verdict(&noisy, "functions_faster_than_codes"), Verdict::NotFound);
    // One run has no spread to tell.
    let single = with_runs(&results, |point| point.decode.runs[..1].to_vec());
    assert_eq!(verdict(&single, "short_windows_decoding"), Verdict::NotFound);
    assert_eq!(verdict(&single, "functions_faster_than_codes"), Verdict::NotFound);
    assert_eq!(verdict(&single, "cells_time_over_size"), Verdict::NotMeasured);
    let overlapping = judge(&noisy).iter().any(|finding| finding.rests_on.contains("fewer than 3 runs: 5."));
    assert!(overlapping, "{:#?}", judge(&noisy));
}

#[test]
fn what_curves_upwards_need_not_be_exponential() {
    let mut results = sample::paper();
    for point in results.measured.iter_mut().filter(|point| point.point.kind == StreamKind::Color) {
        // It jumps at 45 dB.
        let psnr: f64 = point.point.value("psnr").unwrap().parse().unwrap();
        point.sizes.container = if psnr < 45.0 { 1000 } else { (psnr * 1000.0) as u64 };
    }
    assert_eq!(verdict(&results, "psnr_exponential"), Verdict::NotFound);
}

#[test]
fn straight_lines_are_fitted() {
    let (slope, explained) = line_fit(&[1.0, 2.0, 3.0], &[3.0, 5.0, 7.0]);
    assert!((slope - 2.0).abs() < 1e-12 && (explained - 1.0).abs() < 1e-12);
    let (slope, explained) = line_fit(&[1.0, 2.0, 3.0], &[1.0, 0.0, 1.0]);
    assert!(slope.abs() < 1e-12 && explained.abs() < 1e-12);
    assert_eq!(line_fit(&[1.0, 2.0], &[4.0, 4.0]), (0.0, 1.0));
    assert_eq!(line_fit(&[2.0, 2.0], &[1.0, 4.0]), (0.0, 0.0));
}

#[test]
fn tiles_are_judged_by_both_ends() {
    let tiles = sample::tiles();
    let finding = bc4w_is_rarely_bad_and_rarely_perfect(Some(&tiles));
    assert_eq!(finding.verdict, Verdict::Found, "{finding:#?}");
    assert!(finding.rests_on.contains("bc4w 0 %"), "{finding:#?}");
}
