//! The fast search: few lines, endpoints by least squares.

use crate::depth::bc4w::fit::best_pair;
use crate::depth::bc4w::lines::bipartitions;
use crate::depth::bc4w::sums::Plan;
use crate::depth::bc4w::tile::{Solution, Tile};

/// Lines that are tried.
const LINES: usize = 6;

/// The best solution found within the tile's bound.
pub fn search(tile: &Tile) -> Option<Solution> {
    best_of(tile, LINES).map(|(_, solution)| solution)
}

/// The best solution with one of the most promising lines, and its squared error.
pub fn best_of(tile: &Tile, lines: usize) -> Option<(u64, Solution)> {
    let mut best: Option<(u64, Solution)> = None;
    for line in ranked(tile, lines) {
        let parted = bipartitions()[line];
        let solve = |side: u64| {
            let pair = best_pair(tile, side)?;
            Some((tile.cost(side, pair)?, pair))
        };
        let Some((cost_a, a)) = solve(!parted.side_b) else { continue };
        let Some((cost_b, b)) = solve(parted.side_b) else { continue };
        if best.is_none_or(|(cost, _)| cost_a + cost_b < cost) {
            best = Some((cost_a + cost_b, Solution { line: parted.line, pairs: [a, b] }));
        }
    }
    best
}

/// The `count` lines that leave the least variance.
fn ranked(tile: &Tile, count: usize) -> Vec<usize> {
    let [low, high] = tile.extremes.unwrap_or_default().map(f32::from);
    let middle = (low + high) / 2.0;
    let mut pixels = [[0.0f32; 4]; 64];
    for (pixel, sums) in pixels.iter_mut().enumerate() {
        if tile.surfaces >> pixel & 1 != 0 {
            let value = f32::from(tile.codes[pixel]) - middle;
            *sums = [1.0, value, value * value, 0.0];
        }
    }
    let left = |[n, sum, square, _]: [f32; 4]| if n > 0.0 { square - sum * sum / n } else { 0.0 };
    let mut scores = Vec::with_capacity(Plan::all().len());
    Plan::all().for_each_line(&pixels, &mut Vec::new(), |line, a, b| scores.push((left(a) + left(b), line)));
    let count = count.min(scores.len() - 1);
    scores.select_nth_unstable_by(count, |a, b| a.0.total_cmp(&b.0));
    scores.truncate(count);
    scores.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
    scores.into_iter().map(|(_, line)| line).collect()
}
