//! Findings of the papers, each tested on this footage by a stated rule.

use super::runs::in_boxes;
use crate::report::plot::number::short;
use crate::report::tradeoff::findings::{Finding, Judged, Test};
use crate::report::tradeoff::kind::Measured;
use crate::report::tradeoff::runs::{self, Run};
use crate::report::tradeoff::study::Results;
use codec::depth::tile_psnr::{BIN_DB, PsnrDistribution, TileModel, TilePsnr};
use codec::image::StreamKind;

const BAD_DB: usize = 60;
/// PSNR in dB from which a tile counts as exact: GDC 6.4 says that BC4w hardly exceeds it.
const PERFECT_DB: usize = 85;
/// Minimum number of runs to distinguish a difference in time from noise.
const MIN_RUNS: usize = 3;
/// Minimum R² of a line fit. Many curves that bend upwards are not exponential.
const FITS: f64 = 0.95;

type CodingTest = Test<fn(&Results, &TilePsnr) -> Option<Judged>>;

const TESTS: [CodingTest; 7] = [
    Test {
        name: "aabbs_decaying",
        sentence: "More AABBs compress better, with decaying effect (CALF figure 7).",
        rule: "In most rows of points that differ in the limit alone, the largest limit has the fewest bytes of both \
               ends, and a doubling saves more at the beginning than at the end.",
        needs: "Needs depth at three or more values of --max-aabbs.",
        judge: |results, _| boxes_compress_less_and_less(results),
    },
    Test {
        name: "short_windows_bytes",
        sentence: "Short windows have fewer bytes (CALF figure 7).",
        rule: "In most rows of points that differ in the window alone, the shortest window has fewer bytes than the \
               longest.",
        needs: "Needs depth at two or more values of --depth-window.",
        judge: |results, _| short_windows_are_smaller(results),
    },
    Test {
        name: "short_windows_decoding",
        sentence: "Short windows decode faster (CALF figure 7).",
        rule: "In most rows of points that differ in the window alone, every run of the shortest window is faster than \
               every run of the longest, of at least 3 runs.",
        needs: "Needs depth at two or more values of --depth-window, with decoding timed.",
        judge: |results, _| short_windows_decode_faster(results),
    },
    Test {
        name: "psnr_exponential",
        sentence: "Bytes grow exponentially with the PSNR threshold (CALF figure 8).",
        rule: "In most rows of points that differ in the threshold alone, bytes grow and a line fits their logarithms \
               better than themselves, with an R² of at least 0.95.",
        needs: "Needs colour at three or more values of --psnr.",
        judge: |results, _| thresholds_grow_exponentially(results),
    },
    Test {
        name: "cells_time_over_size",
        sentence: "Cell size matters more for decoding time than for bytes, and larger cells decode faster (CALF section 7).",
        rule: "Of points that differ in the cell size alone, the time of the smallest cell over that of the largest exceeds \
               the largest over the least bytes, in the geometric mean.",
        needs: "Needs colour at two or more values of --color-cell, with decoding timed in 3 or more runs.",
        judge: |results, _| cells_cost_time_more_than_bytes(results),
    },
    Test {
        name: "bc4w_few_bad_few_perfect",
        sentence: "BC4w has few bad tiles and few perfect ones (GDC figure 6).",
        rule: "Of the three modelling functions, BC4w has the least share of tiles below 60 dB, and the least share of \
               tiles that are exact or above 85 dB.",
        needs: "Needs depth, and --preset paper.",
        judge: |_, tiles| bc4w_is_rarely_bad_and_rarely_perfect(tiles),
    },
    Test {
        name: "functions_faster_than_codes",
        sentence: "Depth in modelling functions decodes faster than codes as they are (GDC figure 8).",
        rule: "At every bound, every run of modelling functions is faster than every run of boxes of codes, of at least 3 \
               runs.",
        needs: "Needs depth at values of --max-error with --depth-codec quadtree, and the same with aabb, with decoding timed.",
        judge: |results, _| functions_decode_faster_than_codes(results),
    },
];

pub fn judge(results: &Results, tiles: Option<&TilePsnr>) -> Vec<Finding> {
    let no_tiles = TilePsnr::default();
    TESTS.iter().map(|test| test.finding((test.judge)(results, tiles.unwrap_or(&no_tiles)))).collect()
}

fn container(point: &Measured) -> f64 {
    point.count("bytes_container") as f64
}

fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0u32), |(sum, count), value| (sum + value, count + 1));
    sum / f64::from(count.max(1))
}

fn geometric_mean(values: impl Iterator<Item = f64>) -> f64 {
    mean(values.map(|value| value.max(f64::MIN_POSITIVE).ln())).exp()
}

fn range(values: impl Iterator<Item = f64>) -> [f64; 2] {
    values.fold([f64::INFINITY, 0.0], |[low, high], of| [low.min(of), high.max(of)])
}

fn boxes_compress_less_and_less(results: &Results) -> Option<Judged> {
    struct Saving {
        first_doubling: f64,
        last_doubling: f64,
        whole: f64,
    }
    let mut runs = runs::along(results, Some(StreamKind::Depth), "max-aabbs", 3);
    runs.retain(|run| run.points.iter().all(|(limit, _)| *limit >= 1.0));
    let saving = |run: &Run<'_>| {
        let doubling = |from: usize| {
            let ((low, before), (high, after)) = (run.points[from], run.points[from + 1]);
            100.0 * (1.0 - (container(after) / container(before)).powf(1.0 / (high / low).log2()))
        };
        let last = run.points.len() - 1;
        let whole = 100.0 * (1.0 - container(run.points[last].1) / container(run.points[0].1));
        Saving { first_doubling: doubling(0), last_doubling: doubling(last - 1), whole }
    };
    let rows: Vec<Saving> = runs.iter().map(saving).collect();
    let count = rows.len();
    Judged::majority(
        &rows,
        |of| of.whole > 0.0 && of.first_doubling > of.last_doubling,
        |kept| {
            let of = |value: fn(&Saving) -> f64| short(mean(rows.iter().map(value)));
            format!(
                "From the least limit to the largest, bytes shrink by {} % in the mean of {count} rows of points; the first \
             doubling saves {} %, a doubling at the end {} %. {kept} of {count} rows keep the rule.",
                of(|row| row.whole),
                of(|row| row.first_doubling),
                of(|row| row.last_doubling)
            )
        },
    )
}

/// Returns the points of the longest and the shortest window for each row along `depth-window` with at least two
/// points.
fn windows(results: &Results) -> Vec<[&Measured; 2]> {
    let runs = runs::along(results, Some(StreamKind::Depth), "depth-window", 2);
    runs.iter().filter_map(|run| Some([run.points.last()?.1, run.points.first()?.1])).collect()
}

fn short_windows_are_smaller(results: &Results) -> Option<Judged> {
    let rows = windows(results);
    let ratio = |[long, short]: &[&Measured; 2]| container(long) / container(short).max(1.0);
    let count = rows.len();
    Judged::majority(
        &rows,
        |row| ratio(row) > 1.0,
        |kept| {
            format!(
                "The longest window has {} times the bytes of the shortest, in the geometric mean of {count} rows of points. \
             {kept} of {count} rows keep the rule.",
                short(geometric_mean(rows.iter().map(ratio))),
            )
        },
    )
}

fn short_windows_decode_faster(results: &Results) -> Option<Judged> {
    let timed = windows(results).into_iter().filter_map(|[long, short]| TimeRatio::of(long, short));
    let rows: Vec<TimeRatio> = timed.collect();
    let count = rows.len();
    Judged::majority(
        &rows,
        |row| row.is_slower,
        |kept| {
            format!(
                "Decoding with the longest window takes {} times as long as with the shortest, in the geometric mean of {count} \
             rows of points. {kept} of {count} rows keep the rule; rows whose spreads overlap, or with fewer than \
             {MIN_RUNS} runs: {}.",
                short(geometric_mean(rows.iter().map(|row| row.ratio))),
                rows.iter().filter(|row| row.is_within_spread).count()
            )
        },
    )
}

fn thresholds_grow_exponentially(results: &Results) -> Option<Judged> {
    struct Growth {
        /// R² of a line fit to the logarithms of the bytes, and to the bytes.
        logarithmic: f64,
        linear: f64,
        factor: f64,
    }
    let growth = |run: &Run<'_>| {
        let places: Vec<f64> = run.points.iter().map(|(threshold, _)| *threshold).collect();
        let bytes: Vec<f64> = run.points.iter().map(|(_, point)| container(point).max(1.0)).collect();
        let logs: Vec<f64> = bytes.iter().map(|bytes| bytes.ln()).collect();
        let (slope, logarithmic) = line_fit(&places, &logs);
        Growth { logarithmic, linear: line_fit(&places, &bytes).1, factor: (10.0 * slope).exp() }
    };
    let rows: Vec<Growth> = runs::along(results, Some(StreamKind::Color), "psnr", 3).iter().map(growth).collect();
    let count = rows.len();
    let keeps = |of: &Growth| of.logarithmic > of.linear && of.logarithmic >= FITS && of.factor > 1.0;
    Judged::majority(&rows, keeps, |kept| {
        format!(
            "Bytes grow by a factor of {} for each 10 dB. R² of a line through their logarithms is {:.3}, through \
             themselves {:.3}, in the mean of {count} rows of points. {kept} of {count} rows keep the rule.",
            short(geometric_mean(rows.iter().map(|row| row.factor))),
            mean(rows.iter().map(|row| row.logarithmic)),
            mean(rows.iter().map(|row| row.linear)),
        )
    })
}

fn cells_cost_time_more_than_bytes(results: &Results) -> Option<Judged> {
    let mut runs = runs::along(results, Some(StreamKind::Color), "color-cell", 2);
    runs.retain(|run| run.points.iter().all(|(_, point)| point.runs("decode_runs").len() >= MIN_RUNS));
    let ratios = runs.iter().filter_map(|run| {
        let [low, high] = range(run.points.iter().map(|(_, point)| container(point).max(1.0)));
        Some((TimeRatio::of(run.points.first()?.1, run.points.last()?.1)?.ratio, high / low))
    });
    let ratios: Vec<(f64, f64)> = ratios.collect();
    let time = geometric_mean(ratios.iter().map(|ratio| ratio.0));
    let size = geometric_mean(ratios.iter().map(|ratio| ratio.1));
    let rests_on = format!(
        "The smallest cell takes {} times as long to decode as the largest, and bytes differ by a factor of {} between \
         the best and the worst size, in the geometric mean of {} rows of points.",
        short(time),
        short(size),
        ratios.len()
    );
    (!ratios.is_empty()).then(|| Judged::new(time > size, rests_on))
}

fn functions_decode_faster_than_codes(results: &Results) -> Option<Judged> {
    let runs = runs::along(results, Some(StreamKind::Depth), "max-error", 1);
    let of_functions = runs.iter().filter(|run| run.others.contains(&("depth-codec", "quadtree".to_owned())));
    let beside = of_functions.filter_map(|run| Some((run, in_boxes(results, &run.others)?)));
    let bounds = beside.flat_map(|(run, boxes)| run.points.iter().filter_map(move |(_, of)| TimeRatio::of(of, boxes)));
    let bounds: Vec<TimeRatio> = bounds.collect();
    let kept = bounds.iter().filter(|of| of.is_faster).count();
    let [low, high] = range(bounds.iter().map(|of| of.ratio));
    let rests_on = format!(
        "Modelling functions take {} to {} times as long to decode as boxes of codes. At {kept} of {} bounds they \
         keep the rule. (The paper counts the transfer to a graphics processor, which decoding on a CPU has not.)",
        short(low),
        short(high),
        bounds.len()
    );
    (!bounds.is_empty()).then(|| Judged::new(kept == bounds.len(), rests_on))
}

struct TimeRatio {
    ratio: f64,
    /// True if every run is faster, and both points have at least [`MIN_RUNS`] runs.
    is_faster: bool,
    is_slower: bool,
    /// True if the ranges of the runs overlap, or there are too few runs.
    is_within_spread: bool,
}

impl TimeRatio {
    fn of(point: &Measured, other: &Measured) -> Option<TimeRatio> {
        let ratio = point.number("decode_seconds")? / other.number("decode_seconds")?.max(1e-9);
        let (own, others) = (point.spread("decode_seconds")?, other.spread("decode_seconds")?);
        let runs = point.runs("decode_runs").len().min(other.runs("decode_runs").len());
        let is_faster = runs >= MIN_RUNS && own.high < others.low;
        let is_slower = runs >= MIN_RUNS && own.low > others.high;
        Some(TimeRatio { ratio, is_faster, is_slower, is_within_spread: !is_faster && !is_slower })
    }
}

fn bc4w_is_rarely_bad_and_rarely_perfect(tiles: &TilePsnr) -> Option<Judged> {
    let functions = [TileModel::Bc4w, TileModel::Platelet, TileModel::Biquadratic];
    let shares = functions.map(|model| shares(tiles.of(model)));
    let least = |at: usize| shares[1..].iter().all(|other| shares[0][at] < other[at]);
    let of = functions.iter().zip(shares).map(|(model, of)| {
        let [bad, perfect] = of.map(|share| short(100.0 * share));
        format!("{} {bad} % and {perfect} %", model.name())
    });
    let rests_on = format!(
        "Of {} tiles of 8x8 pixels, those below {BAD_DB} dB and those that are exact or above {PERFECT_DB} dB: {}.",
        tiles.tiles(),
        of.collect::<Vec<_>>().join("; ")
    );
    (tiles.tiles() > 0).then(|| Judged::new(least(0) && least(1), rests_on))
}

/// Returns the share of tiles below [`BAD_DB`], and the share of those that are exact or reach [`PERFECT_DB`].
fn shares(psnr: &PsnrDistribution) -> [f64; 2] {
    let bins = psnr.histogram();
    let bad: u64 = bins.iter().take(BAD_DB / BIN_DB).sum();
    let good: u64 = bins.iter().skip(PERFECT_DB / BIN_DB).sum();
    [bad, good + psnr.exact].map(|count| count as f64 / psnr.tiles.max(1) as f64)
}

/// Least-squares line through points: returns its slope and R², the share of the variance that the line explains. R² is
/// 1 if all y are equal.
fn line_fit(x: &[f64], y: &[f64]) -> (f64, f64) {
    let (mean_x, mean_y) = (mean(x.iter().copied()), mean(y.iter().copied()));
    let sum =
        |of: &dyn Fn(f64, f64) -> f64| -> f64 { x.iter().zip(y).map(|(&x, &y)| of(x - mean_x, y - mean_y)).sum() };
    let (xx, xy, yy) = (sum(&|x, _| x * x), sum(&|x, y| x * y), sum(&|_, y| y * y));
    let slope = if xx > 0.0 { xy / xx } else { 0.0 };
    let explained = if yy > 0.0 { slope * xy / yy } else { 1.0 };
    (slope, explained)
}

#[cfg(test)]
mod tests;
