//! Claims of the thesis about its figures and tables of chapter 4, tested on this scene.

use crate::report::plot::number::short;
use crate::report::tradeoff::findings::{Finding, Judged, Test};
use crate::report::tradeoff::kind::Measured;
use crate::report::tradeoff::runs::{self, Run};
use crate::report::tradeoff::study::Results;

/// Maximum cost of a further view, as a fraction of ray casting one view.
const SMALL_SLOPE: f64 = 0.1;
/// Maximum relative deviation of the slopes of the first and the last half of a row from their mean for time to count
/// as linear.
const STRAIGHT: f64 = 0.5;
/// Relative difference in time below which two times count as equal.
const NO_DIFFERENCE: f64 = 0.05;

type InterpolationTest = Test<fn(&Results) -> Option<Judged>>;

const TESTS: [InterpolationTest; 8] = [
    Test {
        name: "time_grows_little",
        sentence: "Time grows linearly with the views, by a small part of what rendering a view takes (Epipolar 4.1).",
        rule: "In most rows of points that differ in the views alone, a further view costs at most a tenth of ray casting one.",
        needs: "Needs two or more values of --views.",
        judge: time_grows_little,
    },
    Test {
        name: "time_is_linear",
        sentence: "Time is linear in the number of views (Epipolar figures 4.2 to 4.18).",
        rule: "In most rows of points that differ in the views alone, the slopes of the first and the last half differ by no more \
               than their mean.",
        needs: "Needs three or more values of --views.",
        judge: time_is_linear,
    },
    Test {
        name: "coalescing_helps",
        sentence: "Primitive coalescing shortens the time most of all optimisations (Epipolar 5.1).",
        rule: "In most rows of points that differ in coalescing alone, the largest threshold takes less time than none, by more \
               than 5%.",
        needs: "Needs --sweep coalesce with 0 and another value.",
        judge: |results| faster(results, "coalesce", "coalescing"),
    },
    Test {
        name: "layers_cost_little",
        sentence: "Leaving out layers changes the time little (Epipolar 5.1).",
        rule: "In most rows of points that differ in the layers alone, the fewest take no more than 5% less time than the most.",
        needs: "Needs two or more values of --layers.",
        judge: layers_cost_little,
    },
    Test {
        name: "masks_help_dual",
        sentence: "Visibility masks shorten the time of a dual acquisition (Epipolar figure 4.12).",
        rule: "At most pairs of points that differ in the culling alone, full culling takes less time than the depth offset alone.",
        needs: "Needs --sweep culling=full,offset.",
        judge: masks_help,
    },
    Test {
        name: "highlights_cost_nothing",
        sentence: "Highlights have hardly any influence on the time (Epipolar 5.1).",
        rule: "In most rows of points that differ in the splits alone, the most splits take at most 5% longer than the fewest.",
        needs: "Needs two or more values of --splits.",
        judge: highlights_cost_nothing,
    },
    Test {
        name: "baselines_cost_quality",
        sentence: "Wide baselines lose quality (Epipolar 5.2).",
        rule: "In most rows of points that differ in the baseline alone, the widest has a lower PSNR than the narrowest.",
        needs: "Needs two or more values of --baseline.",
        judge: baselines_cost_quality,
    },
    Test {
        name: "dual_beats_hierarchical",
        sentence: "A dual acquisition has a higher PSNR than a hierarchical one (Epipolar tables 4.5 and 4.6).",
        rule: "At most pairs of points that differ in the acquisition alone, dual has the higher PSNR.",
        needs: "Needs --sweep acquire=dual,hierarchical.",
        judge: dual_beats_hierarchical,
    },
];

pub fn judge(results: &Results) -> Vec<Finding> {
    TESTS.iter().map(|test| test.finding((test.judge)(results))).collect()
}

/// Returns the additional seconds per view between two points of a run.
fn slope(run: &Run<'_>, [from, to]: [usize; 2]) -> Option<f64> {
    let [(few, first), (many, last)] = [run.points[from], run.points[to]];
    Some((last.number("seconds")? - first.number("seconds")?) / (many - few))
}

fn time_grows_little(results: &Results) -> Option<Judged> {
    let runs = runs::along(results, None, "views", 2);
    let parts = runs.iter().filter_map(|run| {
        let (views, last) = run.points[run.points.len() - 1];
        Some(slope(run, [0, run.points.len() - 1])? / (last.number("brute_force_seconds")? / views))
    });
    let rows: Vec<f64> = parts.collect();
    Judged::majority(
        &rows,
        |part| *part <= SMALL_SLOPE,
        |kept| {
            let mean = rows.iter().sum::<f64>() / rows.len() as f64;
            format!(
                "A further view costs {} of ray casting it, in the mean of {} rows of points. {kept} of them keep the rule.",
                short(mean),
                rows.len()
            )
        },
    )
}

fn time_is_linear(results: &Results) -> Option<Judged> {
    let runs = runs::along(results, None, "views", 3);
    let halves = runs.iter().filter_map(|run| {
        let (middle, last) = (run.points.len() / 2, run.points.len() - 1);
        Some([slope(run, [0, middle])?, slope(run, [middle, last])?])
    });
    let rows: Vec<[f64; 2]> = halves.collect();
    let is_straight = |[first, last]: &[f64; 2]| {
        let mean = 0.5 * (first + last);
        (first - mean).abs() <= STRAIGHT * mean.abs()
    };
    Judged::majority(&rows, is_straight, |kept| {
        let milliseconds = |half: usize| short(1e3 * rows.iter().map(|row| row[half]).sum::<f64>() / rows.len() as f64);
        format!(
            "A further view takes {} ms in the first half of the rows and {} ms in the last. {kept} of {} rows keep the rule.",
            milliseconds(0),
            milliseconds(1),
            rows.len()
        )
    })
}

/// Returns for each run along a knob the time of its last point divided by that of its first.
fn last_over_first(results: &Results, knob: &str) -> Vec<f64> {
    let runs = runs::along(results, None, knob, 2);
    let ratio = |run: &Run<'_>| {
        let [first, last] = [run.points[0].1, run.points[run.points.len() - 1].1].map(|of| of.number("seconds"));
        Some(last? / first?)
    };
    runs.iter().filter_map(ratio).collect()
}

fn ratios(rows: &[f64], kept: usize, what: &str) -> String {
    let mean = rows.iter().sum::<f64>() / rows.len() as f64;
    format!(
        "{what} take {} times as long, in the mean of {} rows of points. {kept} of them keep the rule.",
        short(mean),
        rows.len()
    )
}

fn faster(results: &Results, knob: &str, what: &str) -> Option<Judged> {
    let rows = last_over_first(results, knob);
    Judged::majority(
        &rows,
        |ratio| *ratio < 1.0 - NO_DIFFERENCE,
        |kept| ratios(&rows, kept, &format!("Points with the most {what}")),
    )
}

fn layers_cost_little(results: &Results) -> Option<Judged> {
    let rows = last_over_first(results, "layers");
    Judged::majority(
        &rows,
        |ratio| *ratio <= 1.0 / (1.0 - NO_DIFFERENCE),
        |kept| ratios(&rows, kept, "The most layers"),
    )
}

fn highlights_cost_nothing(results: &Results) -> Option<Judged> {
    let rows = last_over_first(results, "splits");
    Judged::majority(&rows, |ratio| *ratio <= 1.0 + NO_DIFFERENCE, |kept| ratios(&rows, kept, "The most splits"))
}

fn masks_help(results: &Results) -> Option<Judged> {
    let rows = pairs(results, "culling", ["full", "offset"], "seconds");
    Judged::majority(
        &rows,
        |[full, offset]| full < offset,
        |kept| {
            let mean = rows.iter().map(|[full, offset]| full / offset).sum::<f64>() / rows.len() as f64;
            format!(
                "Full culling takes {} times as long, in the mean of {} pairs. {kept} of them keep the rule.",
                short(mean),
                rows.len()
            )
        },
    )
}

fn baselines_cost_quality(results: &Results) -> Option<Judged> {
    let runs = runs::along(results, None, "baseline", 2);
    let ends = runs.iter().filter_map(|run| {
        let [first, last] = [run.points[0].1, run.points[run.points.len() - 1].1].map(|of| of.number("psnr_db"));
        Some([first?, last?]).filter(|ends| ends.iter().all(|number| number.is_finite()))
    });
    let rows: Vec<[f64; 2]> = ends.collect();
    Judged::majority(
        &rows,
        |[narrow, wide]| wide < narrow,
        |kept| {
            let mean = rows.iter().map(|[narrow, wide]| narrow - wide).sum::<f64>() / rows.len() as f64;
            format!(
                "The widest baseline loses {} dB, in the mean of {} rows of points. {kept} of them keep the rule.",
                short(mean),
                rows.len()
            )
        },
    )
}

fn dual_beats_hierarchical(results: &Results) -> Option<Judged> {
    let rows = pairs(results, "acquire", ["dual", "hierarchical"], "psnr_db");
    Judged::majority(
        &rows,
        |[dual, hierarchical]| dual > hierarchical,
        |kept| {
            let mean = rows.iter().map(|[dual, hierarchical]| dual - hierarchical).sum::<f64>() / rows.len() as f64;
            format!(
                "Dual has {} dB more, in the mean of {} pairs. {kept} of them keep the rule.",
                short(mean),
                rows.len()
            )
        },
    )
}

/// Returns a measure of points that differ only in one knob, for pairs in which both values were measured.
fn pairs(results: &Results, knob: &'static str, values: [&str; 2], measure: &str) -> Vec<[f64; 2]> {
    let with = |value: &str| results.measured.iter().filter(move |of| of.point.value(knob) == Some(value)).collect();
    let [first, last]: [Vec<&Measured>; 2] = values.map(with);
    let pair = |of: &&Measured| {
        let other = last.iter().find(|other| other.point.without(knob) == of.point.without(knob))?;
        let pair = [of.number(measure)?, other.number(measure)?];
        // Views that coincide with source views are exact and have no finite PSNR.
        pair.iter().all(|number| number.is_finite()).then_some(pair)
    };
    first.iter().filter_map(pair).collect()
}
