//! The searches for every day: the most promising lines, endpoints around a least-squares fit.

use crate::depth::bc4w::fit::best_pair;
use crate::depth::bc4w::lines::bipartitions;
use crate::depth::bc4w::sums::{Greatest, Plan, Quantity};
use crate::depth::bc4w::tile::{Solution, Tile};

/// Lines that `Fast` tries.
pub const FEW_LINES: usize = 6;
/// Lines that `Normal` tries.
pub const MANY_LINES: usize = 28;

/// The best solution found within the tile's bound.
pub fn search(tile: &Tile, lines: usize) -> Option<Solution> {
    best_of(tile, lines).map(|(_, solution)| solution)
}

/// The best solution with one of the most promising lines, and its squared error.
pub fn best_of(tile: &Tile, lines: usize) -> Option<(u64, Solution)> {
    let mut best: Option<(u64, Solution)> = None;
    for line in ranked(tile, lines) {
        let found = solve(tile, line);
        if found.is_some_and(|(cost, _)| best.is_none_or(|(least, _)| cost < least)) {
            best = found;
        }
    }
    best
}

/// A good solution with the line of this place, and its squared error.
pub fn solve(tile: &Tile, line: usize) -> Option<(u64, Solution)> {
    let parted = bipartitions()[line];
    let solve = |side: u64| {
        let pair = best_pair(tile, side)?;
        Some((tile.cost(side, pair)?, pair))
    };
    let (cost_a, a) = solve(!parted.side_b)?;
    let (cost_b, b) = solve(parted.side_b)?;
    Some((cost_a + cost_b, Solution { line: parted.line, pairs: [a, b] }))
}

/// The `count` most promising lines: half of them leave the least variance, half the least squared range.
fn ranked(tile: &Tile, count: usize) -> Vec<usize> {
    let [low, high] = tile.extremes.unwrap_or_default().map(f32::from);
    let middle = (low + high) / 2.0;
    let mut moments = [[0.0f32; 4]; 64];
    let mut extremes = [[Greatest::ZERO; 2]; 64];
    for pixel in (0..64).filter(|pixel| tile.surfaces >> pixel & 1 != 0) {
        let value = f32::from(tile.codes[pixel]) - middle;
        moments[pixel] = [1.0, value, value * value, 0.0];
        extremes[pixel] = [Greatest(value), Greatest(-value)];
    }
    let mut variances = Vec::with_capacity(Plan::all().len());
    let left = |[n, sum, square, _]: [f32; 4]| if n > 0.0 { square - sum * sum / n } else { 0.0 };
    let mut counts = Vec::with_capacity(Plan::all().len());
    Plan::all().for_each_line(&moments, &mut Vec::new(), |line, a, b| {
        variances.push((left(a) + left(b), line));
        counts.push([a[0], b[0]]);
    });
    let mut ranges = Vec::with_capacity(Plan::all().len());
    let range = |[high, low]: [Greatest; 2]| if high.0 + low.0 > 0.0 { high.0 + low.0 } else { 0.0 };
    Plan::all().for_each_line(&extremes, &mut Vec::new(), |line, a, b| {
        let [of_a, of_b] = counts[line];
        ranges.push((of_a * range(a) * range(a) + of_b * range(b) * range(b), line));
    });
    let mut chosen = vec![0];
    for mut scores in [variances, ranges] {
        scores.select_nth_unstable_by(count / 2, |a, b| a.0.total_cmp(&b.0));
        chosen.extend(scores[..count / 2].iter().map(|&(_, line)| line));
    }
    chosen.sort_unstable();
    chosen.dedup();
    chosen
}
