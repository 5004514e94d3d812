use super::*;
use crate::report::tradeoff::findings::Verdict;
use crate::report::tradeoff::kind::Value;
use crate::report::tradeoff::tests::sample;

fn judge_all(results: &Results) -> Vec<Finding> {
    judge(results, Some(&sample::tiles()))
}

fn verdict(results: &Results, name: &str) -> Verdict {
    let findings = judge_all(results);
    findings.iter().find(|finding| finding.name == name).expect(name).verdict
}

fn with_runs(results: &Results, of: impl Fn(&Measured) -> Vec<f64>) -> Results {
    let mut results = results.clone();
    for point in &mut results.measured {
        let runs = of(point);
        point.set("decode_runs", Value::Runs(runs));
    }
    results
}

const TIMED: [&str; 3] = ["short_windows_decoding", "cells_time_over_size", "functions_faster_than_codes"];

#[test]
fn what_is_so_is_found_and_what_is_not_is_not() {
    use Verdict::{Found, NotFound, NotMeasured};
    let results = sample::paper();
    let findings = judge_all(&results);
    assert!(findings.iter().all(|finding| finding.verdict == Found), "{findings:#?}");
    let nothing = Results { measured: vec![], ..results.clone() };
    assert!(judge(&nothing, None).iter().all(|finding| finding.verdict == NotMeasured));

    // The same results with bytes and times inverted.
    let mut turned =
        with_runs(&results, |point| point.runs("decode_runs").iter().map(|seconds| 0.01 / seconds).collect());
    for point in &mut turned.measured {
        point.set("bytes_container", Value::Count(100_000_000_000 / point.count("bytes_container")));
    }
    for finding in judge_all(&turned).iter().filter(|finding| finding.name != "bc4w_few_bad_few_perfect") {
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
        let median = point.number("decode_seconds").unwrap_or(1.0);
        vec![median / 100.0, median, median * 100.0]
    });
    assert_eq!(verdict(&noisy, "short_windows_decoding"), Verdict::NotFound);
    assert_eq!(verdict(&noisy, "functions_faster_than_codes"), Verdict::NotFound);
    // A single run has no range.
    let single = with_runs(&results, |point| point.runs("decode_runs")[..1].to_vec());
    assert_eq!(verdict(&single, "short_windows_decoding"), Verdict::NotFound);
    assert_eq!(verdict(&single, "functions_faster_than_codes"), Verdict::NotFound);
    assert_eq!(verdict(&single, "cells_time_over_size"), Verdict::NotMeasured);
    let overlapping = judge_all(&noisy).iter().any(|finding| finding.rests_on.contains("fewer than 3 runs: 5."));
    assert!(overlapping, "{:#?}", judge_all(&noisy));
}

#[test]
fn what_curves_upwards_need_not_be_exponential() {
    let mut results = sample::paper();
    for point in results.measured.iter_mut().filter(|point| point.point.stream == Some(StreamKind::Color)) {
        // The size jumps at 45 dB.
        let psnr: f64 = point.point.value("psnr").unwrap().parse().unwrap();
        let bytes = if psnr < 45.0 { 1000 } else { (psnr * 1000.0) as u64 };
        point.set("bytes_container", Value::Count(bytes));
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
    let findings = judge_all(&sample::paper());
    let finding = findings.iter().find(|finding| finding.name == "bc4w_few_bad_few_perfect").unwrap();
    assert_eq!(finding.verdict, Verdict::Found, "{finding:#?}");
    assert!(finding.rests_on.contains("bc4w 0 %"), "{finding:#?}");
}
