use std::cell::RefCell;

use serde_json::json;

use super::*;
use crate::report::tradeoff::findings::{Verdict, judge};
use crate::report::tradeoff::kind::{INTERPOLATION, PLACEMENT, RENDERING, SIMPLIFICATION};
use crate::report::tradeoff::plan::{Sweep, grid};
use crate::report::tradeoff::schedule::{Extent, Lab, Schedule, measure};
use crate::report::tradeoff::store::Store;
use crate::report::tradeoff::study::{Results, Study, Weights};
use codec::monitor::Silent;

#[test]
fn a_report_without_a_number_is_refused() {
    let value = json!({ "a": { "b": null, "c": null, "c_is": "inf" }, "d": [7, 8], "e": 4 });
    let report = Report { value, command: "lightfold x".to_owned() };
    assert_eq!(report.number("a/c").unwrap(), f64::INFINITY);
    assert!(report.number("a/b").unwrap_err().to_string().contains("lightfold x: its report has no number a.b"));
    assert_eq!((report.count("d").unwrap(), report.count("d/1").unwrap()), (2, 8));
    assert_eq!(report.number("12 / e").unwrap(), 3.0);
}

/// Runner that answers command lines, and records them.
struct Told<F> {
    lines: RefCell<Vec<String>>,
    answer: F,
}

impl<F: Fn(&str, usize) -> Result<Json>> Runner for Told<F> {
    fn run(&self, words: &[OsString]) -> Result<Json> {
        let line = words.iter().map(|word| word.to_string_lossy()).collect::<Vec<_>>().join(" ");
        let answer = (self.answer)(&line, self.lines.borrow().len());
        self.lines.borrow_mut().push(line);
        answer
    }

    fn now_seconds(&self) -> f64 {
        0.0
    }
}

struct Outcome {
    done: Result<Schedule>,
    lines: Vec<String>,
    csv: String,
    rows: Vec<Measured>,
    study: Study,
}

fn bench(kind: &'static SweepKind, variables: &[(&'static str, &[&str])]) -> CommandBench {
    let words = |words: &[&str]| words.iter().map(|word| (*word).to_owned()).collect();
    let variables = variables.iter().map(|(name, all)| (*name, words(all))).collect();
    CommandBench { kind, work: "work".into(), variables }
}

fn run(
    mut bench: CommandBench,
    sweeps: &[&str],
    repeats: u32,
    answer: impl Fn(&str, usize) -> Result<Json>,
) -> Outcome {
    let sweeps: Vec<Sweep> = sweeps.iter().map(|text| Sweep::parse(text).unwrap()).collect();
    let study = grid(bench.kind, &sweeps).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let kind = bench.kind;
    let mut store = Store::new(kind, folder.path(), study.axes.iter().map(|axis| axis.knob).collect());
    let told = Told { lines: RefCell::new(Vec::new()), answer };
    let lab = Lab { runner: &told, bench: &mut bench, store: &mut store };
    let extent = Extent { repeats, budget_seconds: None };
    let done = measure(std::slice::from_ref(&study), extent, lab, &Silent);
    let csv = std::fs::read_to_string(folder.path().join(kind.csv_name())).unwrap_or_default();
    let rows = store.rows.iter().map(|row| row.measured.clone()).collect();
    Outcome { done, lines: told.lines.into_inner(), csv, rows, study }
}

/// Places cameras, with reports like those of `place`, at most `answers` times.
fn placed(sweep: &str, answers: usize, repeats: u32) -> Outcome {
    let region = "--region=0,0,0,1,1,1";
    let bench = bench(&PLACEMENT, &[("input", &["a.glb"]), ("fixed", &[region, "--cameras=2"]), ("kept", &[region])]);
    run(bench, &[sweep], repeats, |line, count| {
        if count == answers {
            return Err(Error::Interrupted);
        }
        let seconds = if line.contains("--effort=fast") { 0.5 } else { 4.0 } + count as f64 * 1e-3;
        let coverage = if line.contains("--start") { 0.75 } else { 0.875 };
        Ok(json!({ "seconds": seconds, "coverage": coverage, "objective_calls": 12, "cameras": [1, 2] }))
    })
}

#[test]
fn each_point_is_placed_in_rounds_and_judged_once_by_one_ruler() {
    let Outcome { done, lines, csv, .. } = placed("effort=fast,normal", 100, 3);
    done.unwrap();
    assert_eq!(lines.len(), 2 * (3 + 1));
    // The default is first, and every other round is in reverse order.
    assert_eq!(lines[0], "place a.glb --region=0,0,0,1,1,1 --cameras=2 --effort=normal --json -o work/cameras.json");
    assert_eq!(
        lines[1],
        "place a.glb --region=0,0,0,1,1,1 --candidates=256 --surface-samples=32768 --cameras=0 --start \
         work/cameras.json --json -o work/judged.json"
    );
    assert!(lines[2].contains("--effort=fast") && lines[4].contains("--effort=fast"), "{lines:?}");
    assert_eq!(csv.lines().next(), Some("settings_effort,cameras,objective_calls,own_coverage,coverage,seconds"));
    assert!(csv.contains("\nfast,2,12,0.875,0.75,0.504\n"), "{csv}");
}

#[test]
fn what_was_measured_is_kept_where_a_later_command_fails() {
    let Outcome { done, csv, .. } = placed("k=0.5,1", 3, 1);
    assert!(matches!(done, Err(Error::Interrupted)));
    assert!(csv.lines().count() == 2 && csv.contains("\n0.5,2,12,"), "{csv}");
}

#[test]
fn one_container_serves_all_points_and_each_is_rendered_in_every_round() {
    let bench = bench(
        &RENDERING,
        &[("input", &["set"]), ("reference-probe", &["00"]), ("frames", &["0"]), ("fixed", &["--refine=4"])],
    );
    let examples = bench.clone();
    // Reports like those of `encode` and `render`.
    let Outcome { done, lines, csv, study, .. } = run(bench, &["views=8", "steps=64,256"], 2, |line, _| {
        let few = line.contains("--steps=64");
        let (psnr_db, is) = if few { (json!(31.5), json!(null)) } else { (json!(null), json!("inf")) };
        Ok(json!({
            "megapixels_per_second": if few { 2.0 } else { 0.5 },
            "march_steps": if few { 6_400 } else { 25_600 }, "primary_rays": 100, "bytes_read": 9_000,
            "pacing": { "update_ms": { "mean_ms": 1.5 } },
            "reference": { "mean_psnr_db": psnr_db, "mean_psnr_db_is": is, "ssim": null, "hole_percent": 0.25 },
        }))
    });
    done.unwrap();
    assert_eq!(lines[0], "encode set --frames=0 --clip -o work/field.lfold --json");
    assert_eq!(
        lines[1],
        "render work/field.lfold --reference set --reference-probe=00 --exclude-probe=00 --frames=0 --refine=4 \
         --views=8 --steps=64 --null --stats --json"
    );
    assert_eq!(lines.len(), 1 + 2 * 2);
    assert!(lines[3].contains("--steps=256") && lines[4].contains("--steps=64"), "{lines:?}");
    assert_eq!(
        csv,
        "settings_views,settings_steps,psnr_db,ssim,hole_percent,steps_per_ray,bytes_read,ms_per_megapixel,update_ms\n\
         8,64,31.5,,0.25,64.0,9000,500.0,1.5\n8,256,inf,,0.25,256.0,9000,2000.0,1.5\n"
    );
    let examples = examples.examples(&study.points());
    assert!(examples[1].1.starts_with("lightfold render field.lfold --reference set"), "{examples:?}");
}

/// Simplifies, with reports like those of `simplify`. The point with the fewest triangles fails.
fn simplified(failure: &'static str) -> Outcome {
    let bench = bench(&SIMPLIFICATION, &[("input", &["set"]), ("fixed", &["--frames=2"])]);
    run(bench, &["effort=fast", "triangles=4,96"], 2, |line, _| match line.contains("--triangles=4 ") {
        true => Err(Error::invalid(failure)),
        false => Ok(json!({
            "seconds": 1.5, "psnr_db": 31.25, "ssim": 0.5, "psnr_hvs_m_db": null, "psnr_hvs_m_db_is": "inf", "crack_pixels": 3,
            "translucent_pixels": 40, "triangles": 96, "tiles": 40, "projected_area": 1.5, "overdraw_mean": 1.25,
            "peak_overdraw": 2.5, "peak_overdraw_measured": 2.75, "atlas_texels": 4096, "atlas_occupancy": 0.5,
            "selection": { "gap": -1e-18 }, "files": [{ "bytes": 9000 }],
        })),
    })
}

#[test]
fn budgets_that_cannot_be_kept_are_told_and_the_others_are_measured() {
    let infeasible = "no selection of tiles meets the budget of triangles: the minimum is 12";
    let Outcome { done, lines, csv, .. } = simplified(infeasible);
    let done = done.unwrap();
    assert_eq!(lines[1], "simplify set --frames=2 --triangles=96 --effort=fast --json -o work/scene.glb");
    assert_eq!(lines.len(), 1 + 2, "what is infeasible is not tried in later rounds: {lines:?}");
    assert!(done.failed.len() == 1 && done.failed[0].is_infeasible && done.failed[0].error.contains("is 12"));
    assert_eq!(
        csv,
        "settings_effort,settings_triangles,psnr_db,ssim,psnr_hvs_m_db,held_out_psnr_db,held_out_ssim,crack_pixels,translucent_pixels,triangles,tiles,\
         projected_area,overdraw_mean,peak_overdraw,peak_overdraw_measured,atlas_texels,atlas_occupancy,gap,bytes,seconds\n\
         fast,96,31.25,0.5,inf,,,3,40,96,40,1.5,1.25,2.5,2.75,4096,0.5,0.0,9000,1.5\n"
    );
    let done = simplified("a file cannot be read").done.unwrap();
    assert!(done.failed.len() == 1 && !done.failed[0].is_infeasible, "{done:?}");
}

#[test]
fn points_are_timed_without_the_truth_and_compared_once() {
    let bench = bench(&INTERPOLATION, &[("input", &["a.glb"]), ("fixed", &["--baseline=0.5"])]);
    // Reports like those of `interpolate`: one second, and a hundredth of a second per view.
    let Outcome { done, lines, rows, study, .. } = run(bench, &["views=10,50,100", "coalesce=0,1"], 2, |line, _| {
        let after = |name: &str| line.split(name).nth(1).and_then(|rest| rest.split(' ').next().map(str::to_owned));
        let views: f64 = after("--views=").and_then(|text| text.parse().ok()).unwrap_or(10.0);
        let coalesced = after("--coalesce=").is_some_and(|text| text != "0");
        let seconds = 1.0 + views * if coalesced { 0.004 } else { 0.01 };
        let spread = json!({ "mean": 36.5, "min": 35.0, "max": null, "max_is": "inf" });
        Ok(json!({
            "seconds": seconds,
            "stages": {
                "acquire": 0.5, "mask": 0.25, "filter": 0.0625, "interpolate": 0.0625, "light": 0, "fill": 0.125
            },
            "counters": { "source_views": 2, "lines": 100, "fragments": 900 }, "holes_percent": 0.5,
            "memory_model_bytes": 1000, "speedup": 0.5 * views / seconds,
            "quality": { "psnr_db": spread, "ssim": { "mean": 0.96 }, "psnr_hvs_m_db": spread },
            "quality_without_fill": { "psnr_db": spread },
        }))
    });
    done.unwrap();
    // Two timed runs, and one with the comparison.
    assert_eq!(lines.len(), 6 * 3, "{lines:?}");
    assert_eq!(lines[0], "interpolate a.glb --baseline=0.5 --views=10 --coalesce=0 --null --json");
    assert_eq!(lines.iter().filter(|line| line.ends_with("--compare")).count(), 6);
    assert_eq!(rows[0].number("brute_force_seconds"), Some(5.0));
    let results = Results {
        sweep: &INTERPOLATION,
        input: String::new(),
        about: String::new(),
        command_line: String::new(),
        machine: String::new(),
        measured: rows,
        point_commands: Vec::new(),
        studies: vec![study],
        left_out: Vec::new(),
        weights: Weights::default(),
        commands: Vec::new(),
    };
    let found = |name: &str| judge(&results, None).into_iter().find(|finding| finding.name == name).unwrap();
    assert_eq!(found("time_grows_little").verdict, Verdict::Found);
    assert_eq!(found("coalescing_helps").verdict, Verdict::Found);
    assert_eq!(found("baselines_cost_quality").verdict, Verdict::NotMeasured);
}
