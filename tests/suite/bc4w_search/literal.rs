//! The literal search: every bipartition with every pair of endpoints (GDC, algorithm 1, without its coarse level).
//!
//! Kept simple because it is the reference for the other efforts. Pairs are the outer loop, as in the paper, because the cost of
//! a pair in each pixel is the same for all lines.

use codec::depth::bc4w::Pair;
use codec::depth::bc4w::bipartitions::bipartitions;
use codec::depth::bc4w::tile::{Solution, Tile, surface_codes};
use codec::depth::quantise::BACKGROUND_CODE;

/// A cost above any sum of squared differences, which is at most 64 · 65535².
const IMPOSSIBLE: u64 = 1 << 40;

/// Best pair of one side so far.
#[derive(Debug, Clone, Copy)]
struct Best {
    cost: u64,
    pair: Pair,
}

/// Returns the first solution with the lowest squared error within the tile's bound.
pub fn search(tile: &Tile) -> Option<Solution> {
    let none = Best { cost: IMPOSSIBLE, pair: Pair { e0: 0, e1: 0 } };
    let lines = bipartitions();
    let rows: Vec<[u8; 8]> = lines.iter().map(|parted| parted.side_b.to_le_bytes()).collect();
    let mut best = vec![[none; 2]; lines.len()];
    let ranges: Vec<_> =
        lines.iter().map(|parted| [!parted.side_b, parted.side_b].map(|side| tile.endpoints(side))).collect();
    for e0 in tile.endpoints(u64::MAX) {
        for e1 in tile.endpoints(u64::MAX) {
            let pair = Pair { e0, e1 };
            let sums = row_sums(&pixel_costs(tile, pair));
            let total: u64 = sums.iter().map(|row| row[0xff]).sum();
            for ((best, rows), ranges) in best.iter_mut().zip(&rows).zip(&ranges) {
                let b: u64 = (0..8).map(|y| sums[y][usize::from(rows[y])]).sum();
                for ((best, cost), range) in best.iter_mut().zip([total - b, b]).zip(ranges) {
                    if cost < best.cost && range.contains(&e0) && range.contains(&e1) {
                        *best = Best { cost, pair };
                    }
                }
            }
        }
    }
    let (line, best) = lines.iter().zip(best).min_by_key(|(_, [a, b])| a.cost + b.cost)?;
    let [a, b] = best;
    (a.cost + b.cost < IMPOSSIBLE).then_some(Solution { line: line.line, pairs: [a.pair, b.pair] })
}

/// Returns the cost of a pair in each pixel.
fn pixel_costs(tile: &Tile, pair: Pair) -> [u64; 64] {
    let palette = pair.palette();
    let levels = surface_codes(palette);
    let background = if palette.contains(&BACKGROUND_CODE) { 0 } else { IMPOSSIBLE };
    let mut costs = [0; 64];
    for (pixel, cost) in costs.iter_mut().enumerate() {
        if tile.background >> pixel & 1 != 0 {
            *cost = background;
        } else if tile.surfaces >> pixel & 1 != 0 {
            let error = levels.iter().fold(u16::MAX, |least, level| least.min(level.abs_diff(tile.codes[pixel])));
            *cost = if error <= tile.bound { u64::from(error) * u64::from(error) } else { IMPOSSIBLE };
        }
    }
    costs
}

/// Returns, for each row, the sum over each mask of pixels that occurs in a side of a line: runs that start at one end of the
/// row.
fn row_sums(costs: &[u64; 64]) -> [[u64; 256]; 8] {
    let mut sums = [[0; 256]; 8];
    for (sums, costs) in sums.iter_mut().zip(costs.chunks_exact(8)) {
        let (mut left, mut right) = (0, 0);
        for x in 0..8 {
            left += costs[x];
            right += costs[7 - x];
            sums[0xff >> (7 - x)] = left;
            sums[0xff << (7 - x) & 0xff] = right;
        }
    }
    sums
}
