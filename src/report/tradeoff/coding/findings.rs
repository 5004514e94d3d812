//! Findings of the papers, tested on this footage. Each has a rule, which its function states.

use super::runs::{self, Run};
use crate::depth::tile_psnr::{BIN_DB, PsnrDistribution, TileModel, TilePsnr};
use crate::image::StreamKind;
use crate::report::plot::number;
use crate::report::tradeoff::findings::{Finding, Verdict};
use crate::report::tradeoff::kind::Measured;
use crate::report::tradeoff::study::Results;

/// PSNR in dB below which a tile is modelled badly.
const BAD_DB: usize = 60;
/// Runs without which a difference of times is not told from noise.
const LEAST_RUNS: usize = 3;
/// R² from which on a line is said to fit.
const FITS: f64 = 0.95;
/// PSNR in dB from which on a tile is as good as exact: what GDC 6.4 says that BC4w hardly exceeds.
const PERFECT_DB: usize = 85;

/// Judges all findings.
pub fn judge(results: &Results, tiles: Option<&TilePsnr>) -> Vec<Finding> {
    vec![
        boxes_compress_less_and_less(results),
        short_windows_are_smaller(results),
        short_windows_decode_faster(results),
        thresholds_grow_exponentially(results),
        cells_cost_time_more_than_bytes(results),
        bc4w_is_rarely_bad_and_rarely_perfect(tiles),
        functions_decode_faster_than_codes(results),
    ]
}

fn container(point: &Measured) -> f64 {
    point.count("bytes_container") as f64
}

/// Found where most of the things that a rule was tried on keep it.
fn majority(kept: usize, tried: usize) -> Verdict {
    match tried {
        0 => Verdict::NotMeasured,
        _ if 2 * kept > tried => Verdict::Found,
        _ => Verdict::NotFound,
    }
}

fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0u32), |(sum, count), value| (sum + value, count + 1));
    sum / f64::from(count.max(1))
}

fn geometric_mean(values: impl Iterator<Item = f64>) -> f64 {
    mean(values.map(|value| value.max(f64::MIN_POSITIVE).ln())).exp()
}

/// CALF figure 7, first half. Runs along `max-aabbs` with at least three limits from 1 on. A run keeps the rule when the
/// largest limit has fewer bytes than the least one, and a doubling of the limit saves a larger part of the bytes at the
/// least limits (from the first to the second) than at the largest (from the last but one to the last).
fn boxes_compress_less_and_less(results: &Results) -> Finding {
    let mut runs = runs::along(results, StreamKind::Depth, "max-aabbs", 3);
    runs.retain(|run| run.points.iter().all(|(limit, _)| *limit >= 1.0));
    let saving = |run: &Run<'_>, from: usize, to: usize| {
        let ((low, before), (high, after)) = (run.points[from], run.points[to]);
        let doublings = (high / low).log2();
        100.0 * (1.0 - (container(after) / container(before)).powf(1.0 / doublings))
    };
    let steps: Vec<[f64; 3]> = runs
        .iter()
        .map(|run| {
            let last = run.points.len() - 1;
            let whole = 100.0 * (1.0 - container(run.points[last].1) / container(run.points[0].1));
            [saving(run, 0, 1), saving(run, last - 1, last), whole]
        })
        .collect();
    let kept = steps.iter().filter(|[first, last, whole]| *whole > 0.0 && first > last).count();
    let rests_on = if steps.is_empty() {
        "Needs depth at three or more values of --max-aabbs.".to_owned()
    } else {
        let of = |at: usize| number::short(mean(steps.iter().map(|step| step[at])));
        format!(
            "From the least limit to the largest, bytes shrink by {} % in the mean of {} rows of points; the first \
             doubling saves {} %, a doubling at the end {} %. {kept} of {} rows keep the rule.",
            of(2),
            steps.len(),
            of(0),
            of(1),
            steps.len()
        )
    };
    Finding {
        name: "aabbs_decaying",
        sentence: "More AABBs compress better, with decaying effect (CALF figure 7).",
        verdict: majority(kept, steps.len()),
        rule: "In most rows of points that differ in the limit alone, the largest limit has the fewest bytes of both \
               ends, and a doubling saves more at the beginning than at the end.",
        rests_on,
    }
}

/// The longest and the shortest window of every row of points along `depth-window` that has at least two.
fn windows(results: &Results) -> Vec<[&Measured; 2]> {
    let runs = runs::along(results, StreamKind::Depth, "depth-window", 2);
    runs.iter().filter_map(|run| Some([run.points.last()?.1, run.points.first()?.1])).collect()
}

/// CALF figure 7. A row keeps the rule when the shortest window has fewer bytes than the longest.
fn short_windows_are_smaller(results: &Results) -> Finding {
    let ratios: Vec<f64> =
        windows(results).iter().map(|[long, short]| container(long) / container(short).max(1.0)).collect();
    let kept = ratios.iter().filter(|ratio| **ratio > 1.0).count();
    let rests_on = if ratios.is_empty() {
        "Needs depth at two or more values of --depth-window.".to_owned()
    } else {
        format!(
            "The longest window has {} times the bytes of the shortest, in the geometric mean of {} rows of points. \
             {kept} of {} rows keep the rule.",
            number::short(geometric_mean(ratios.iter().copied())),
            ratios.len(),
            ratios.len()
        )
    };
    Finding {
        name: "short_windows_bytes",
        sentence: "Short windows have fewer bytes (CALF figure 7).",
        verdict: majority(kept, ratios.len()),
        rule: "In most rows of points that differ in the window alone, the shortest window has fewer bytes than the \
               longest.",
        rests_on,
    }
}

/// CALF figure 7. A row keeps the rule when the slowest run of the shortest window takes less time than the fastest run of
/// the longest, so that noise is no finding.
fn short_windows_decode_faster(results: &Results) -> Finding {
    let timed: Vec<(f64, Faster)> = windows(results)
        .iter()
        .filter_map(|[long, short]| Some((time_ratio(long, short)?, faster(short, long)?)))
        .collect();
    let count = |wanted: Faster| timed.iter().filter(|(_, found)| *found == wanted).count();
    let rests_on = if timed.is_empty() {
        "Needs depth at two or more values of --depth-window, with decoding timed.".to_owned()
    } else {
        format!(
            "Decoding with the longest window takes {} times as long as with the shortest, in the geometric mean of {} \
             rows of points. {} of {} rows keep the rule; rows whose spreads overlap, or with fewer than {LEAST_RUNS} runs: {}.",
            number::short(geometric_mean(timed.iter().map(|row| row.0))),
            timed.len(),
            count(Faster::Yes),
            timed.len(),
            count(Faster::WithinSpread)
        )
    };
    Finding {
        name: "short_windows_decoding",
        sentence: "Short windows decode faster (CALF figure 7).",
        verdict: majority(count(Faster::Yes), timed.len()),
        rule: "In most rows of points that differ in the window alone, every run of the shortest window is faster than \
               every run of the longest, of at least 3 runs.",
        rests_on,
    }
}

/// CALF figure 8 and section 7. Runs along `psnr` with at least three thresholds. A run keeps the rule when bytes grow
/// from the least threshold to the largest, a straight line fits the logarithm of the bytes better (by R²) than it fits
/// the bytes, and with an R² of at least [`FITS`]: much that curves upwards is not exponential.
fn thresholds_grow_exponentially(results: &Results) -> Finding {
    let runs = runs::along(results, StreamKind::Color, "psnr", 3);
    let fits: Vec<[f64; 3]> = runs
        .iter()
        .map(|run| {
            let places: Vec<f64> = run.points.iter().map(|(threshold, _)| *threshold).collect();
            let bytes: Vec<f64> = run.points.iter().map(|(_, point)| container(point).max(1.0)).collect();
            let logs: Vec<f64> = bytes.iter().map(|bytes| bytes.ln()).collect();
            let slope = line_fit(&places, &logs).0;
            [line_fit(&places, &logs).1, line_fit(&places, &bytes).1, (10.0 * slope).exp()]
        })
        .collect();
    let kept = fits.iter().filter(|[log, linear, growth]| log > linear && *log >= FITS && *growth > 1.0).count();
    let rests_on = if fits.is_empty() {
        "Needs colour at three or more values of --psnr.".to_owned()
    } else {
        format!(
            "Bytes grow by a factor of {} for each 10 dB. R² of a line through their logarithms is {:.3}, through \
             themselves {:.3}, in the mean of {} rows of points. {kept} of {} rows keep the rule.",
            number::short(geometric_mean(fits.iter().map(|fit| fit[2]))),
            mean(fits.iter().map(|fit| fit[0])),
            mean(fits.iter().map(|fit| fit[1])),
            fits.len(),
            fits.len()
        )
    };
    Finding {
        name: "psnr_exponential",
        sentence: "Bytes grow exponentially with the PSNR threshold (CALF figure 8).",
        verdict: majority(kept, fits.len()),
        rule: "In most rows of points that differ in the threshold alone, bytes grow and a line fits their logarithms \
               better than themselves, with an R² of at least 0.95.",
        rests_on,
    }
}

/// CALF section 7. Rows along `color-cell` with at least two sizes, decoding timed. In each, the decoding time of the smallest
/// cell over that of the largest, and the largest over the least bytes of any size; found when the geometric mean of the
/// first is larger.
fn cells_cost_time_more_than_bytes(results: &Results) -> Finding {
    let runs = runs::along(results, StreamKind::Color, "color-cell", 2);
    let ratios: Vec<(f64, f64)> = runs
        .iter()
        .filter(|run| run.points.iter().all(|(_, point)| point.runs("decode_runs").len() >= LEAST_RUNS))
        .filter_map(|run| {
            let bytes = run.points.iter().map(|(_, point)| container(point).max(1.0));
            let (low, high) = bytes.fold((f64::INFINITY, 0.0f64), |(low, high), of| (low.min(of), high.max(of)));
            Some((time_ratio(run.points.first()?.1, run.points.last()?.1)?, high / low))
        })
        .collect();
    let time = geometric_mean(ratios.iter().map(|ratio| ratio.0));
    let size = geometric_mean(ratios.iter().map(|ratio| ratio.1));
    let rests_on = if ratios.is_empty() {
        format!("Needs colour at two or more values of --color-cell, with decoding timed in {LEAST_RUNS} or more runs.")
    } else {
        format!(
            "The smallest cell takes {} times as long to decode as the largest, and bytes differ by a factor of {} between \
             the best and the worst size, in the geometric mean of {} rows of points.",
            number::short(time),
            number::short(size),
            ratios.len()
        )
    };
    Finding {
        name: "cells_time_over_size",
        sentence: "Cell size matters more for decoding time than for bytes, and larger cells decode faster (CALF section 7).",
        verdict: majority(usize::from(time > size), ratios.len().min(1)),
        rule: "Of points that differ in the cell size alone, the time of the smallest cell over that of the largest exceeds \
               the largest over the least bytes, in the geometric mean.",
        rests_on,
    }
}

/// GDC 6.3 and figure 8. Found when at every bound E of modelling functions every run is faster than every run of boxes of
/// codes with the same settings otherwise.
fn functions_decode_faster_than_codes(results: &Results) -> Finding {
    let bounds: Vec<(f64, Faster)> = runs::along(results, StreamKind::Depth, "max-error", 1)
        .iter()
        .filter_map(|run| Some((run, runs::in_boxes(results, &run.others)?)))
        .flat_map(|(run, boxes)| {
            let of = move |point: &Measured| Some((time_ratio(point, boxes)?, faster(point, boxes)?));
            run.points.iter().filter_map(move |(_, point)| of(point)).collect::<Vec<_>>()
        })
        .collect();
    let kept = bounds.iter().filter(|(_, found)| *found == Faster::Yes).count();
    let rests_on = if bounds.is_empty() {
        "Needs depth at values of --max-error, and the same in boxes (--depth-codec aabb), with decoding timed."
            .to_owned()
    } else {
        let (low, high) =
            bounds.iter().fold((f64::INFINITY, 0.0f64), |(low, high), (ratio, _)| (low.min(*ratio), high.max(*ratio)));
        format!(
            "Modelling functions take {} to {} times as long to decode as boxes of codes. At {kept} of {} bounds they \
             keep the rule. (The paper counts the transfer to a graphics processor, which decoding on a CPU has not.)",
            number::short(low),
            number::short(high),
            bounds.len()
        )
    };
    Finding {
        name: "functions_faster_than_codes",
        sentence: "Depth in modelling functions decodes faster than codes as they are (GDC figure 8).",
        verdict: majority(usize::from(kept == bounds.len()), bounds.len().min(1)),
        rule: "At every bound, every run of modelling functions is faster than every run of boxes of codes, of at least 3 \
               runs.",
        rests_on,
    }
}

/// Whether one point decodes faster than another.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Faster {
    /// In every run.
    Yes,
    /// Runs of both overlap, or there are fewer than [`LEAST_RUNS`].
    WithinSpread,
    /// It is slower in every run.
    No,
}

/// Whether `point` decodes faster than `other`; none where either was not timed.
fn faster(point: &Measured, other: &Measured) -> Option<Faster> {
    let (own, others) = (point.spread("decode_seconds")?, other.spread("decode_seconds")?);
    let runs = point.runs("decode_runs").len().min(other.runs("decode_runs").len());
    Some(match () {
        () if runs < LEAST_RUNS => Faster::WithinSpread,
        () if own.high < others.low => Faster::Yes,
        () if own.low > others.high => Faster::No,
        () => Faster::WithinSpread,
    })
}

/// Decoding time of a point in parts of another's; none where either was not timed.
fn time_ratio(point: &Measured, other: &Measured) -> Option<f64> {
    Some(point.number("decode_seconds")? / other.number("decode_seconds")?.max(1e-9))
}

/// GDC 6.2 and figure 6. Found when of the three functions BC4w has the least share of tiles below [`BAD_DB`] and the least
/// share of tiles that are exact or above [`PERFECT_DB`].
fn bc4w_is_rarely_bad_and_rarely_perfect(tiles: Option<&TilePsnr>) -> Finding {
    let tiles = tiles.filter(|tiles| tiles.tiles() > 0);
    let functions = [TileModel::Bc4w, TileModel::Platelet, TileModel::Biquadratic];
    let verdict = tiles.map_or(Verdict::NotMeasured, |tiles| {
        let [bc4w, platelet, biquadratic] = functions.map(|model| shares(tiles.of(model)));
        let least = |at: usize| bc4w[at] < platelet[at] && bc4w[at] < biquadratic[at];
        if least(0) && least(1) { Verdict::Found } else { Verdict::NotFound }
    });
    let rests_on = tiles.map_or_else(
        || "Needs depth, and --preset paper.".to_owned(),
        |tiles| {
            let percent = |share: f64| number::short(100.0 * share);
            let of = functions.map(|model| {
                let [bad, perfect] = shares(tiles.of(model));
                format!("{} {} % and {} %", model.name(), percent(bad), percent(perfect))
            });
            format!(
                "Of {} tiles of 8x8 pixels, those below {BAD_DB} dB and those that are exact or above {PERFECT_DB} dB: \
                 {}.",
                tiles.tiles(),
                of.join("; ")
            )
        },
    );
    Finding {
        name: "bc4w_few_bad_few_perfect",
        sentence: "BC4w has few bad tiles and few perfect ones (GDC figure 6).",
        verdict,
        rule: "Of the three modelling functions, BC4w has the least share of tiles below 60 dB, and the least share of \
               tiles that are exact or above 85 dB.",
        rests_on,
    }
}

/// Shares of tiles below [`BAD_DB`], and exact or from [`PERFECT_DB`] on.
fn shares(psnr: &PsnrDistribution) -> [f64; 2] {
    let bins = psnr.histogram();
    let bad: u64 = bins.iter().take(BAD_DB / BIN_DB).sum();
    let good: u64 = bins.iter().skip(PERFECT_DB / BIN_DB).sum();
    [bad, good + psnr.exact].map(|count| count as f64 / psnr.tiles.max(1) as f64)
}

/// The straight line of least squares through points: its slope, and R², the part of the variance that it explains. R² is
/// 1 where all y are equal, as nothing is left to explain.
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
