use super::Verdict::{Found, NotFound, NotMeasured};
use super::*;
use crate::report::tradeoff::kind::SIMPLIFICATION;
use crate::report::tradeoff::plan::{Sweep, grid};
use crate::report::tradeoff::point::{Value, number};
use crate::report::tradeoff::study::Weights;
use crate::report::tradeoff::tests::sample;

fn judge_all(results: &Results) -> Vec<Finding> {
    judge(results, Some(&sample::tiles()))
}

fn verdict(results: &Results, name: &str) -> Verdict {
    judge_all(results).iter().find(|finding| finding.name == name).expect(name).verdict
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
    let results = sample::paper();
    let findings = judge_all(&results);
    assert!(findings.iter().all(|finding| finding.verdict == Found), "{findings:#?}");
    let nothing = Results { measured: vec![], ..results.clone() };
    assert!(judge(&nothing, None).iter().all(|finding| finding.verdict == NotMeasured));

    // Results with bytes and times inverted.
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
fn tiles_are_judged_by_both_ends() {
    let findings = judge_all(&sample::paper());
    let finding = findings.iter().find(|finding| finding.name == "bc4w_few_bad_few_perfect").unwrap();
    assert_eq!(finding.verdict, Verdict::Found, "{finding:#?}");
    assert!(finding.rests_on.contains("bc4w 0 %"), "{finding:#?}");
}

/// Measured values of a point, by measure name. `None` if the point is infeasible.
type Measures = Option<Vec<(&'static str, Value)>>;

/// Results of a grid whose points have the values that `measure` returns for their settings.
fn simplified(sweeps: &[&str], measure: impl Fn(&Point) -> Measures) -> Results {
    let sweeps: Vec<Sweep> = sweeps.iter().map(|text| Sweep::parse(text).unwrap()).collect();
    let study = grid(&SIMPLIFICATION, &sweeps).unwrap();
    let measured = study.points().into_iter().filter_map(|point| {
        let mut measured = Measured::new(&SIMPLIFICATION, point.clone());
        measure(&point)?.into_iter().for_each(|(name, value)| measured.set(name, value));
        Some(measured)
    });
    Results {
        sweep: &SIMPLIFICATION,
        input: String::new(),
        about: String::new(),
        command_line: String::new(),
        machine: String::new(),
        measured: measured.collect(),
        point_commands: Vec::new(),
        studies: vec![study],
        left_out: Vec::new(),
        weights: Weights::default(),
        commands: Vec::new(),
    }
}

fn value(point: &Point, knob: &str) -> f64 {
    point.value(knob).and_then(number).unwrap()
}

#[test]
fn cracks_are_judged_by_the_ends_of_rows() {
    let of = |sweep: &str, cracks: fn(f64) -> u64| {
        let knob = if sweep.starts_with("area") { "area" } else { "triangles" };
        simplified(&[sweep], |point| Some(vec![("crack_pixels", Value::Count(cracks(value(point, knob))))]))
    };
    let fewer = |of: f64| if of > 2500.0 { 9 } else { 100 };
    assert_eq!(verdict(&of("triangles=500,3000", fewer), "triangles_close_cracks"), Found);
    assert_eq!(verdict(&of("triangles=500,3000", |_| 0), "triangles_close_cracks"), NotFound);
    assert_eq!(verdict(&of("triangles=500", fewer), "triangles_close_cracks"), NotMeasured);
    assert_eq!(verdict(&of("area=1.5,3", |area| if area < 3.0 { 40 } else { 4 }), "area_closes_cracks"), Found);
    assert_eq!(verdict(&of("area=3,4", |_| 40), "area_closes_cracks"), NotMeasured);
}

#[test]
fn peaks_are_compared_with_their_budgets() {
    let of = |peaks: fn(f64) -> f64| {
        simplified(&["peak-overdraw=3,100"], |point| {
            Some(vec![("peak_overdraw_measured", Value::Number(peaks(value(point, "peak-overdraw"))))])
        })
    };
    let limited = of(|budget| budget.min(6.0) * 1.1);
    assert_eq!(verdict(&limited, "peak_budget_limits_views"), Found);
    assert_eq!(verdict(&limited, "peak_budget_kept_nearly"), Found);
    let broken = of(|_| 4.0);
    assert_eq!(verdict(&broken, "peak_budget_limits_views"), NotFound);
    assert_eq!(verdict(&broken, "peak_budget_kept_nearly"), NotFound);
}

#[test]
fn trees_are_compared_with_grids_where_both_are_feasible() {
    let of = |least_area_of_grids: f64, tree: f64| {
        simplified(&["tiling=quadtree,uniform", "area=1.25,3"], move |point| {
            let is_grid = point.value("tiling") == Some("uniform");
            let area = value(point, "area");
            let ssim = if is_grid { 0.5 } else { tree } + 0.1 * area;
            (!is_grid || area >= least_area_of_grids).then(|| vec![("ssim", Value::Number(ssim))])
        })
    };
    let better = of(2.0, 0.6);
    for name in ["quadtree_beats_grid", "grid_needs_area", "area_improves_ssim"] {
        assert_eq!(verdict(&better, name), Found, "{name}");
    }
    let worse = of(1.0, 0.4);
    assert_eq!(verdict(&worse, "quadtree_beats_grid"), NotFound);
    assert_eq!(verdict(&worse, "grid_needs_area"), NotFound);
}

#[test]
fn texels_are_compared_at_equal_quality() {
    // Uniform sizes need `times` as many texels for the same PSNR.
    let of = |times: f64| {
        simplified(&["sizing=adaptive,uniform", "atlas=256,512,1024"], move |point| {
            let texels = value(point, "atlas").powi(2);
            let worse = if point.value("sizing") == Some("uniform") { times.log2() } else { 0.0 };
            let psnr_db = texels.log2() - worse;
            Some(vec![("psnr_db", Value::Number(psnr_db)), ("atlas_texels", Value::Count(texels as u64))])
        })
    };
    assert_eq!(verdict(&of(1.5), "adaptive_sizes_save_texels"), Found);
    assert_eq!(verdict(&of(1.1), "adaptive_sizes_save_texels"), NotFound);
    let said = judge_all(&of(2.0)).into_iter().find(|of| of.name == "adaptive_sizes_save_texels").unwrap().rests_on;
    assert!(said.contains("0.5 to 0.5 times the texels"), "{said}");
}

#[test]
fn a_gap_of_one_point_is_enough_to_say_that_selection_has_not_converged() {
    let of = |gap: f64| simplified(&["effort=fast,normal"], move |_| Some(vec![("gap", Value::Number(gap))]));
    assert_eq!(verdict(&of(0.009), "selection_converges"), Found);
    assert_eq!(verdict(&of(0.02), "selection_converges"), NotFound);
    let nothing = simplified(&["effort=fast"], |_| None);
    assert!(judge_all(&nothing).iter().all(|finding| finding.verdict == NotMeasured));
}
