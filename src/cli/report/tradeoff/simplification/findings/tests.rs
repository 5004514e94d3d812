use super::*;
use crate::report::tradeoff::findings::Verdict::{self, Found, NotFound, NotMeasured};
use crate::report::tradeoff::kind::Value;
use crate::report::tradeoff::plan::{Sweep, grid};
use crate::report::tradeoff::simplification::SIMPLIFICATION;
use crate::report::tradeoff::study::Weights;

/// Measured values of a point, by measure name. `None` if the point is infeasible.
type Measures = Option<Vec<(&'static str, Value)>>;

/// Results of a grid whose points have the values that `measure` returns for their settings.
fn results(sweeps: &[&str], measure: impl Fn(&Point) -> Measures) -> Results {
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
        studies: vec![study],
        left_out: Vec::new(),
        weights: Weights::default(),
        commands: Vec::new(),
    }
}

fn verdict(results: &Results, name: &str) -> Verdict {
    judge(results).into_iter().find(|finding| finding.name == name).unwrap().verdict
}

fn value(point: &Point, knob: &str) -> f64 {
    point.value(knob).and_then(knob::number).unwrap()
}

#[test]
fn cracks_are_judged_by_the_ends_of_rows() {
    let of = |sweep: &str, cracks: fn(f64) -> u64| {
        let knob = if sweep.starts_with("area") { "area" } else { "triangles" };
        results(&[sweep], |point| Some(vec![("crack_pixels", Value::Count(cracks(value(point, knob))))]))
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
        results(&["peak-overdraw=3,100"], |point| {
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
        results(&["tiling=quadtree,uniform", "area=1.25,3"], move |point| {
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
        results(&["sizing=adaptive,uniform", "atlas=256,512,1024"], move |point| {
            let texels = value(point, "atlas").powi(2);
            let worse = if point.value("sizing") == Some("uniform") { times.log2() } else { 0.0 };
            let psnr_db = texels.log2() - worse;
            Some(vec![("psnr_db", Value::Number(psnr_db)), ("atlas_texels", Value::Count(texels as u64))])
        })
    };
    assert_eq!(verdict(&of(1.5), "adaptive_sizes_save_texels"), Found);
    assert_eq!(verdict(&of(1.1), "adaptive_sizes_save_texels"), NotFound);
    let said = judge(&of(2.0)).into_iter().find(|of| of.name == "adaptive_sizes_save_texels").unwrap().rests_on;
    assert!(said.contains("0.5 to 0.5 times the texels"), "{said}");
}

#[test]
fn a_gap_of_one_point_is_enough_to_say_that_selection_has_not_converged() {
    let of = |gap: f64| results(&["effort=fast,normal"], move |_| Some(vec![("gap", Value::Number(gap))]));
    assert_eq!(verdict(&of(0.009), "selection_converges"), Found);
    assert_eq!(verdict(&of(0.02), "selection_converges"), NotFound);
    let nothing = results(&["effort=fast"], |_| None);
    assert!(judge(&nothing).iter().all(|finding| finding.verdict == NotMeasured));
}
