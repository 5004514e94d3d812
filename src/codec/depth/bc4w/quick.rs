//! Heuristic searches: the most promising lines, with endpoints around a least-squares fit.

use crate::depth::bc4w::bipartitions::bipartitions;
use crate::depth::bc4w::fit::{Polish, best_pair};
use crate::depth::bc4w::sums::{Greatest, Plan, Quantity};
use crate::depth::bc4w::tile::{Solution, Tile};

#[derive(Debug, Clone, Copy)]
pub struct Trials {
    pub fitted: usize,
    pub polished: usize,
}

pub const FAST: Trials = Trials { fitted: 6, polished: 1 };
pub const NORMAL: Trials = Trials { fitted: 48, polished: 8 };

pub fn best_of(tile: &Tile, trials: Trials) -> Option<(u64, Solution)> {
    let rough = |line: usize| {
        let side_b = bipartitions()[line].side_b;
        let cost = |side| best_pair(tile, side, Polish::None).map_or(f32::INFINITY, |(cost, _)| cost);
        (cost(!side_b) + cost(side_b), line)
    };
    let mut lines: Vec<(f32, usize)> = ranked(tile, trials.fitted).into_iter().map(rough).collect();
    lines.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let mut best: Option<(u64, Solution)> = None;
    for &(_, line) in lines.iter().take(trials.polished) {
        let found = solve(tile, line);
        if found.is_some_and(|(cost, _)| best.is_none_or(|(least, _)| cost < least)) {
            best = found;
        }
    }
    best
}

/// Returns a good solution for the line at this index of the bipartitions, with its squared error.
pub fn solve(tile: &Tile, line: usize) -> Option<(u64, Solution)> {
    let parted = bipartitions()[line];
    let solve = |side: u64| {
        let (_, pair) = best_pair(tile, side, Polish::Neighbours)?;
        Some((tile.cost(side, pair)?, pair))
    };
    let (cost_a, a) = solve(!parted.side_b)?;
    let (cost_b, b) = solve(parted.side_b)?;
    Some((cost_a + cost_b, Solution { line: parted.line, pairs: [a, b] }))
}

/// Returns the most promising lines: half of `count` leave the lowest variance, half the lowest squared range. The first
/// bipartition, which does not divide the block, is always included.
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
    let left = |[n, sum, square, _]: [f32; 4]| if n > 0.0 { square - sum * sum / n } else { 0.0 };
    let mut min_variance = Least::new(count / 2);
    let mut counts = Vec::with_capacity(Plan::all().len());
    Plan::all().for_each_line(&moments, &mut Vec::new(), |line, a, b| {
        min_variance.offer(left(a) + left(b), line);
        counts.push([a[0], b[0]]);
    });
    let range = |[high, low]: [Greatest; 2]| if high.0 + low.0 > 0.0 { high.0 + low.0 } else { 0.0 };
    let mut min_range = Least::new(count / 2);
    Plan::all().for_each_line(&extremes, &mut Vec::new(), |line, a, b| {
        let [of_a, of_b] = counts[line];
        min_range.offer(of_a * range(a) * range(a) + of_b * range(b) * range(b), line);
    });
    let mut chosen = vec![0];
    chosen.extend(min_variance.best.iter().chain(&min_range.best).map(|&(_, line)| line));
    chosen.sort_unstable();
    chosen.dedup();
    chosen
}

struct Least {
    count: usize,
    best: Vec<(f32, usize)>,
}

impl Least {
    fn new(count: usize) -> Least {
        Least { count, best: Vec::with_capacity(count + 1) }
    }

    #[inline]
    fn offer(&mut self, score: f32, line: usize) {
        if self.best.len() < self.count || self.best.last().is_some_and(|&(worst, _)| score < worst) {
            let at = self.best.partition_point(|&(other, _)| other <= score);
            self.best.insert(at, (score, line));
            self.best.truncate(self.count);
        }
    }
}
