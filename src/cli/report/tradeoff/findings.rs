//! Findings of papers, each tested on the points of a sweep by a stated rule.

use serde::Serialize;

use super::kind::{Claim, Limit, RowTest, fill};
use super::point::{Measured, Point, Setting, compute};
use super::study::{Results, all_points};
use crate::report::plot::number::short;
use crate::report::statistics::{geometric_mean, line_fit, mean, range};
use codec::depth::tile_psnr::{BIN_DB, PsnrDistribution, TileModel, TilePsnr};
use codec::image::StreamKind;

#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub enum Verdict {
    #[serde(rename = "found")]
    Found,
    #[serde(rename = "not found")]
    NotFound,
    /// The points do not allow a verdict.
    #[serde(rename = "not measured")]
    NotMeasured,
}

impl Verdict {
    pub fn name(self) -> &'static str {
        match self {
            Verdict::Found => "found",
            Verdict::NotFound => "not found",
            Verdict::NotMeasured => "not measured",
        }
    }
}

#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Finding {
    pub name: &'static str,
    /// Claim of the paper, with its location.
    pub sentence: &'static str,
    pub verdict: Verdict,
    pub rule: &'static str,
    /// Sentence with the values on which the verdict rests, or with what would have to be measured.
    pub rests_on: String,
}

/// Values of a claim's sentence, by their names in braces.
type Values = Vec<(&'static str, String)>;

/// Verdict of a test, before it is attached to its claim: true if the claim holds, and on which values this rests.
type Judged = (bool, Values);

/// Tests all claims of a kind of sweep. `tiles` are statistics of depth tiles.
pub fn judge(results: &Results, tiles: Option<&TilePsnr>) -> Vec<Finding> {
    let finding = |claim: &Claim| {
        let judged = match (&claim.rows, claim.most) {
            (Some(test), _) => test_rows(results, test),
            (None, Some((formula, limit))) => test_most(results, formula, limit),
            (None, None) => test_by_function(results, claim.name, tiles),
        };
        let (verdict, rests_on) = match judged {
            Some((true, values)) => (Verdict::Found, fill(claim.rests_on, &values)),
            Some((false, values)) => (Verdict::NotFound, fill(claim.rests_on, &values)),
            None => (Verdict::NotMeasured, claim.needs.to_owned()),
        };
        Finding { name: claim.name, sentence: claim.sentence, verdict, rule: claim.rule, rests_on }
    };
    results.sweep.findings.iter().map(finding).collect()
}

/// Tests a claim that is more than a comparison of the ends of rows.
fn test_by_function(results: &Results, name: &str, tiles: Option<&TilePsnr>) -> Option<Judged> {
    match name {
        "aabbs_decaying" => boxes_compress_less_and_less(results),
        "short_windows_decoding" => short_windows_decode_faster(results),
        "psnr_exponential" => thresholds_grow_exponentially(results),
        "cells_time_over_size" => cells_cost_time_more_than_bytes(results),
        "bc4w_few_bad_few_perfect" => bc4w_is_rarely_bad_and_rarely_perfect(tiles?),
        "functions_faster_than_codes" => functions_decode_faster_than_codes(results),
        "time_is_linear" => time_is_linear(results),
        "area_improves_ssim" => area_improves_ssim(results),
        "quadtree_beats_grid" => quadtree_beats_grid(results),
        "grid_needs_area" => grid_needs_area(results),
        "adaptive_sizes_save_texels" => adaptive_sizes_save_texels(results),
        _ => None,
    }
}

/// Points that have all settings but one in common.
#[derive(Debug, Clone)]
pub struct Run<'a> {
    pub others: Vec<Setting>,
    /// Value of the knob and the measured point, by increasing value.
    pub points: Vec<(f64, &'a Measured)>,
}

impl<'a> Run<'a> {
    /// Returns the first and the last point. A run has at least one.
    fn ends(&self) -> [(f64, &'a Measured); 2] {
        [self.points[0], self.points[self.points.len() - 1]]
    }
}

/// Returns all runs along a knob with at least `least` different values.
pub fn along<'a>(results: &'a Results, stream: Option<StreamKind>, name: &str, least: usize) -> Vec<Run<'a>> {
    let mut runs: Vec<Run<'a>> = Vec::new();
    for measured in results.measured.iter().filter(|measured| measured.point.stream == stream) {
        let Some(number) = measured.point.number(name) else { continue };
        let others = measured.point.without(name);
        match runs.iter_mut().find(|run| run.others == others) {
            Some(run) => run.points.push((number, measured)),
            None => runs.push(Run { others, points: vec![(number, measured)] }),
        }
    }
    for run in &mut runs {
        run.points.sort_by(|a, b| a.0.total_cmp(&b.0));
    }
    runs.retain(|run| run.points.len() >= least);
    runs
}

/// Returns the points with two values of a knob whose other settings are the same.
fn pairs<'a>(results: &'a Results, knob: &str, values: [&str; 2]) -> Vec<[&'a Measured; 2]> {
    let [first, last] =
        values.map(|value| results.measured.iter().filter(move |of| of.point.value(knob) == Some(value)));
    let pair =
        |of: &'a Measured| Some([of, last.clone().find(|other| other.point.without(knob) == of.point.without(knob))?]);
    first.filter_map(pair).collect()
}

/// Returns the depth point coded in boxes, without modelling functions, whose other settings are `others`.
pub fn in_boxes<'a>(results: &'a Results, others: &[Setting]) -> Option<&'a Measured> {
    let others = others.iter().filter(|(name, _)| *name != "depth-codec").cloned();
    let settings = others.chain([("depth-codec", "aabb".to_owned())]).collect();
    results.of(&Point::new(results.sweep, Some(StreamKind::Depth), settings))
}

/// Returns true if most rows keep a rule, and the values with the number of rows and of those that do. `None` without
/// rows.
fn majority<T>(rows: &[T], keeps: impl Fn(&T) -> bool, values: Values) -> Option<Judged> {
    let kept = rows.iter().filter(|row| keeps(row)).count();
    let counts = [("rows", rows.len().to_string()), ("kept", kept.to_string())];
    (!rows.is_empty()).then(|| (2 * kept > rows.len(), values.into_iter().chain(counts).collect()))
}

/// Returns the mean of each column of rows.
fn means<const N: usize>(rows: &[[f64; N]]) -> [f64; N] {
    std::array::from_fn(|at| mean(rows.iter().map(|row| row[at])))
}

fn test_rows(results: &Results, test: &RowTest) -> Option<Judged> {
    let is_across = |run: &&Run<'_>| {
        let [(first, _), (last, _)] = run.ends();
        test.across.is_none_or(|at| first < at && last >= at)
    };
    let ends: Vec<[(f64, &Measured); 2]> = match test.pair {
        Some(values) => pairs(results, test.along, values).into_iter().map(|pair| pair.map(|of| (0.0, of))).collect(),
        None => {
            let stream = results.sweep.knob(test.along)?.streams.first().copied();
            along(results, stream, test.along, 2).iter().filter(is_across).map(Run::ends).collect()
        }
    };
    let row = |[(from, low), (to, high)]: [(f64, &Measured); 2]| {
        // Exact pictures have no finite PSNR.
        let number = |of: &Measured| of.number(test.measure).filter(|number| number.is_finite());
        let (first, last) = (number(low)?, number(high)?);
        let value = |name: &str| match name {
            "first" => Some(first),
            "last" => Some(last),
            "span" => Some(to - from),
            "value" => Some(to),
            _ => high.number(name),
        };
        Some([first, last, compute(test.row, value)?])
    };
    let rows: Vec<[f64; 3]> = ends.into_iter().filter_map(row).collect();
    let (limit, bound) = test.keeps;
    let keeps = |[_, _, row]: &[f64; 3]| match limit {
        Limit::Above => *row > bound,
        Limit::From => *row >= bound,
        Limit::Below => *row < bound,
        Limit::To => *row <= bound,
    };
    let column = |at: usize| rows.iter().map(move |row| row[at]);
    let values = vec![
        ("mean", short(mean(column(2)))),
        ("geometric mean", short(geometric_mean(column(2)))),
        ("first sum", column(0).sum::<f64>().to_string()),
        ("last sum", column(1).sum::<f64>().to_string()),
        ("first max", short(column(0).fold(0.0, f64::max))),
        ("last max", short(column(1).fold(0.0, f64::max))),
    ];
    majority(&rows, keeps, values)
}

fn test_most(results: &Results, formula: &str, limit: f64) -> Option<Judged> {
    let value = |of: &Measured| compute(formula, |name| of.number(name).or_else(|| of.point.number(name)));
    let most = results.measured.iter().filter_map(value).reduce(f64::max)?;
    Some((most <= limit, vec![("most", short(most))]))
}

fn container(point: &Measured) -> f64 {
    point.count("bytes_container") as f64
}

fn boxes_compress_less_and_less(results: &Results) -> Option<Judged> {
    let mut runs = along(results, Some(StreamKind::Depth), "max-aabbs", 3);
    runs.retain(|run| run.points.iter().all(|(limit, _)| *limit >= 1.0));
    // Savings of the whole row, of the first doubling, and of the last, in percent.
    let savings = |run: &Run<'_>| {
        let doubling = |from: usize| {
            let ((low, before), (high, after)) = (run.points[from], run.points[from + 1]);
            100.0 * (1.0 - (container(after) / container(before)).powf(1.0 / (high / low).log2()))
        };
        let [(_, first), (_, last)] = run.ends();
        [100.0 * (1.0 - container(last) / container(first)), doubling(0), doubling(run.points.len() - 2)]
    };
    let rows: Vec<[f64; 3]> = runs.iter().map(savings).collect();
    let [whole, first, last] = means(&rows).map(short);
    let values = vec![("whole", whole), ("first", first), ("last", last)];
    majority(&rows, |[whole, first, last]| *whole > 0.0 && first > last, values)
}

/// Minimum number of runs to distinguish a difference in time from noise.
const MIN_RUNS: usize = 3;

struct TimeRatio {
    ratio: f64,
    /// True if every run is faster, and both points have at least [`MIN_RUNS`] runs.
    is_faster: bool,
    is_slower: bool,
}

impl TimeRatio {
    fn of(point: &Measured, other: &Measured) -> Option<TimeRatio> {
        let ratio = point.number("decode_seconds")? / other.number("decode_seconds")?.max(1e-9);
        let (own, others) = (point.spread("decode_seconds")?, other.spread("decode_seconds")?);
        let is_timed = [point, other].iter().all(|of| of.runs("decode_runs").len() >= MIN_RUNS);
        let (is_faster, is_slower) = (is_timed && own.high < others.low, is_timed && own.low > others.high);
        Some(TimeRatio { ratio, is_faster, is_slower })
    }
}

fn short_windows_decode_faster(results: &Results) -> Option<Judged> {
    let runs = along(results, Some(StreamKind::Depth), "depth-window", 2);
    let rows = runs.iter().map(Run::ends).filter_map(|[(_, short), (_, long)]| TimeRatio::of(long, short));
    let rows: Vec<TimeRatio> = rows.collect();
    let unclear = rows.iter().filter(|row| !row.is_faster && !row.is_slower).count();
    let ratio = short(geometric_mean(rows.iter().map(|row| row.ratio)));
    majority(&rows, |row| row.is_slower, vec![("ratio", ratio), ("unclear", unclear.to_string())])
}

/// Minimum R² of a line fit. Many curves that bend upwards are not exponential.
const FITS: f64 = 0.95;

fn thresholds_grow_exponentially(results: &Results) -> Option<Judged> {
    // R² of a line fit to the logarithms of the bytes, and to the bytes, and the growth in 10 dB.
    let growth = |run: &Run<'_>| {
        let places: Vec<f64> = run.points.iter().map(|(threshold, _)| *threshold).collect();
        let bytes: Vec<f64> = run.points.iter().map(|(_, point)| container(point).max(1.0)).collect();
        let logs: Vec<f64> = bytes.iter().map(|bytes| bytes.ln()).collect();
        let (slope, logarithmic) = line_fit(&places, &logs);
        [logarithmic, line_fit(&places, &bytes).1, (10.0 * slope).exp()]
    };
    let rows: Vec<[f64; 3]> = along(results, Some(StreamKind::Color), "psnr", 3).iter().map(growth).collect();
    let keeps = |&[logarithmic, linear, factor]: &[f64; 3]| logarithmic > linear && logarithmic >= FITS && factor > 1.0;
    let [logarithmic, linear, _] = means(&rows).map(|value| format!("{value:.3}"));
    let factor = short(geometric_mean(rows.iter().map(|row| row[2])));
    majority(&rows, keeps, vec![("factor", factor), ("logarithmic", logarithmic), ("linear", linear)])
}

fn cells_cost_time_more_than_bytes(results: &Results) -> Option<Judged> {
    let mut runs = along(results, Some(StreamKind::Color), "color-cell", 2);
    runs.retain(|run| run.points.iter().all(|(_, point)| point.runs("decode_runs").len() >= MIN_RUNS));
    let ratios = runs.iter().filter_map(|run| {
        let [low, high] = range(run.points.iter().map(|(_, point)| container(point).max(1.0)));
        let [(_, first), (_, last)] = run.ends();
        Some([TimeRatio::of(first, last)?.ratio, high / low])
    });
    let ratios: Vec<[f64; 2]> = ratios.collect();
    let [time, size] = [0, 1].map(|at| geometric_mean(ratios.iter().map(|ratio| ratio[at])));
    let values = vec![("time", short(time)), ("size", short(size)), ("rows", ratios.len().to_string())];
    (!ratios.is_empty()).then_some((time > size, values))
}

fn functions_decode_faster_than_codes(results: &Results) -> Option<Judged> {
    let mut runs = along(results, Some(StreamKind::Depth), "max-error", 1);
    runs.retain(|run| run.others.contains(&("depth-codec", "quadtree".to_owned())));
    let bounds = runs.iter().filter_map(|run| Some((run, in_boxes(results, &run.others)?)));
    let bounds = bounds.flat_map(|(run, boxes)| run.points.iter().filter_map(move |(_, of)| TimeRatio::of(of, boxes)));
    let bounds: Vec<TimeRatio> = bounds.collect();
    let kept = bounds.iter().filter(|of| of.is_faster).count();
    let [low, high] = range(bounds.iter().map(|of| of.ratio)).map(short);
    let counts = [("kept", kept.to_string()), ("rows", bounds.len().to_string())];
    let values = [("low", low), ("high", high)].into_iter().chain(counts).collect();
    (!bounds.is_empty()).then_some((kept == bounds.len(), values))
}

const BAD_DB: usize = 60;
/// PSNR in dB from which a tile counts as exact: GDC 6.4 says that BC4w hardly exceeds it.
const PERFECT_DB: usize = 85;

fn bc4w_is_rarely_bad_and_rarely_perfect(tiles: &TilePsnr) -> Option<Judged> {
    let functions = [TileModel::Bc4w, TileModel::Platelet, TileModel::Biquadratic];
    let shares = functions.map(|model| shares(tiles.of(model)));
    let least = |at: usize| shares[1..].iter().all(|other| shares[0][at] < other[at]);
    let of = functions.iter().zip(shares).map(|(model, of)| {
        let [bad, perfect] = of.map(|share| short(100.0 * share));
        format!("{} {bad} % and {perfect} %", model.name())
    });
    let values = vec![("tiles", tiles.tiles().to_string()), ("shares", of.collect::<Vec<_>>().join("; "))];
    (tiles.tiles() > 0).then(|| (least(0) && least(1), values))
}

/// Returns the share of tiles below [`BAD_DB`], and the share of those that are exact or reach [`PERFECT_DB`].
fn shares(psnr: &PsnrDistribution) -> [f64; 2] {
    let bins = psnr.histogram();
    let bad: u64 = bins.iter().take(BAD_DB / BIN_DB).sum();
    let good: u64 = bins.iter().skip(PERFECT_DB / BIN_DB).sum();
    [bad, good + psnr.exact].map(|count| count as f64 / psnr.tiles.max(1) as f64)
}

/// Maximum relative deviation of the slopes of the first and the last half of a row from their mean for time to count
/// as linear.
const STRAIGHT: f64 = 0.5;

/// Returns the additional seconds per view between two points of a run.
fn slope(run: &Run<'_>, [from, to]: [usize; 2]) -> Option<f64> {
    let [(few, first), (many, last)] = [run.points[from], run.points[to]];
    Some((last.number("seconds")? - first.number("seconds")?) / (many - few))
}

fn time_is_linear(results: &Results) -> Option<Judged> {
    let runs = along(results, None, "views", 3);
    let halves = runs.iter().filter_map(|run| {
        let (middle, last) = (run.points.len() / 2, run.points.len() - 1);
        Some([slope(run, [0, middle])?, slope(run, [middle, last])?])
    });
    let rows: Vec<[f64; 2]> = halves.collect();
    let is_straight = |[first, last]: &[f64; 2]| {
        let mean = 0.5 * (first + last);
        (first - mean).abs() <= STRAIGHT * mean.abs()
    };
    let [first, last] = means(&rows).map(|seconds| short(1e3 * seconds));
    majority(&rows, is_straight, vec![("first", first), ("last", last)])
}

fn area_improves_ssim(results: &Results) -> Option<Judged> {
    let runs = along(results, None, "area", 2);
    let series = runs.iter().map(|run| run.points.iter().filter_map(|(_, point)| point.number("ssim")).collect());
    let rows: Vec<Vec<f64>> = series.filter(|row: &Vec<f64>| row.len() > 1).collect();
    let rises = |row: &Vec<f64>| row[1..].iter().copied().fold(f64::INFINITY, f64::min) - row[0] > 0.0;
    let first = mean(rows.iter().map(|row| row[0]));
    let best = mean(rows.iter().map(|row| row.iter().copied().fold(0.0, f64::max)));
    majority(&rows, rises, vec![("first", format!("{first:.4}")), ("best", format!("{best:.4}"))])
}

fn quadtree_beats_grid(results: &Results) -> Option<Judged> {
    let pairs = pairs(results, "tiling", ["quadtree", "uniform"]);
    let gain = |[tree, grid]: &[&Measured; 2]| Some(tree.number("ssim")? - grid.number("ssim")?);
    let gains: Vec<f64> = pairs.iter().filter_map(gain).collect();
    let least = gains.iter().copied().reduce(f64::min)?;
    let by = match least < 0.0 {
        true => format!("lower by up to {:.4}", -least),
        false => format!("higher by at least {least:.4}, at {} pairs of points", gains.len()),
    };
    Some((least > 0.0, vec![("by", by)]))
}

/// Projected area at which the paper's uniform grid is infeasible (figure 13).
const TOO_SMALL: f64 = 1.25;

fn grid_needs_area(results: &Results) -> Option<Judged> {
    let is_small = |point: &Point| {
        point.value("tiling") == Some("uniform") && point.number("area").is_some_and(|area| area <= TOO_SMALL)
    };
    let points: Vec<Point> = all_points(&results.studies).into_iter().filter(is_small).collect();
    let feasible = points.iter().filter(|point| results.of(point).is_some()).count();
    let values = vec![("feasible", feasible.to_string()), ("rows", points.len().to_string())];
    (!points.is_empty()).then_some((feasible == 0, values))
}

/// Minimum fraction of texels that adaptive sizes save (figure 14).
const MIN_SAVING: f64 = 0.18;

fn adaptive_sizes_save_texels(results: &Results) -> Option<Judged> {
    let runs = along(results, None, "atlas", 1);
    let curve = |run: &Run<'_>| -> Vec<[f64; 2]> {
        let spots = run.points.iter().filter_map(|(_, of)| Some([of.number("psnr_db")?, of.number("atlas_texels")?]));
        spots.filter(|[psnr_db, _]| psnr_db.is_finite()).collect()
    };
    let with =
        |run: &Run<'_>, sizing: &str| run.others.iter().any(|(name, value)| *name == "sizing" && value == sizing);
    let others = |run: &Run<'_>| run.others.iter().filter(|(name, _)| *name != "sizing").cloned().collect::<Vec<_>>();
    let mut ratios = Vec::new();
    for uniform in runs.iter().filter(|run| with(run, "uniform")) {
        let adaptive = runs.iter().filter(|run| with(run, "adaptive") && others(run) == others(uniform));
        let adaptive: Vec<[f64; 2]> = adaptive.flat_map(curve).collect();
        // An atlas that holds all textures at full resolution has the same texels with both sizings.
        let is_full = |spot: &[f64; 2]| adaptive.contains(spot);
        for spot in curve(uniform).into_iter().filter(|spot| !is_full(spot)) {
            ratios.extend(texels_at(&adaptive, spot[0]).map(|texels| texels / spot[1]));
        }
    }
    let most = ratios.iter().copied().reduce(f64::max)?;
    let least = ratios.iter().copied().fold(most, f64::min);
    let values = vec![("least", short(least)), ("most", short(most)), ("rows", ratios.len().to_string())];
    Some((most <= 1.0 - MIN_SAVING, values))
}

/// Returns the texels at which a curve of (PSNR, texels) reaches a PSNR, by interpolating the logarithm of the texels.
/// `None` outside the curve.
fn texels_at(curve: &[[f64; 2]], psnr_db: f64) -> Option<f64> {
    curve.windows(2).find_map(|pair| {
        let [[low, few], [high, many]] = [pair[0], pair[1]];
        let part = (psnr_db - low) / (high - low);
        (0.0..=1.0).contains(&part).then(|| (few.ln() + part * (many / few).ln()).exp())
    })
}

#[cfg(test)]
mod tests;
