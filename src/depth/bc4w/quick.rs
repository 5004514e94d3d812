//! The fast search: few lines, endpoints by least squares.

use crate::depth::bc4w::lines::{Bipartition, bipartitions};
use crate::depth::bc4w::tile::{Solution, Tile};
use crate::depth::bc4w::{MAX_ENDPOINT, Pair};

/// The best solution found within the tile's bound.
pub fn search(tile: &Tile) -> Option<Solution> {
    best_of(tile, ranked(tile).iter().take(8))
}

/// The best solution with one of these lines.
pub fn best_of<'a>(tile: &Tile, lines: impl Iterator<Item = &'a Bipartition>) -> Option<Solution> {
    lines
        .filter_map(|parted| {
            let [a, b] = [!parted.side_b, parted.side_b].map(|side| best_pair(tile, side));
            let ((a, cost_a), (b, cost_b)) = (a?, b?);
            Some((cost_a + cost_b, Solution { line: parted.line, pairs: [a, b] }))
        })
        .min_by_key(|&(cost, _)| cost)
        .map(|(_, solution)| solution)
}

/// Lines by the variance that they leave, the least first.
fn ranked(tile: &Tile) -> Vec<Bipartition> {
    let score = |side: u64| {
        let (mut n, mut sum, mut square) = (0.0, 0.0, 0.0);
        let mut rest = tile.surfaces & side;
        while rest != 0 {
            let v = f64::from(tile.codes[rest.trailing_zeros() as usize]);
            n += 1.0;
            sum += v;
            square += v * v;
            rest &= rest - 1;
        }
        if n > 0.0 { square - sum * sum / n } else { 0.0 }
    };
    let mut scored: Vec<_> =
        bipartitions().iter().map(|parted| (score(parted.side_b) + score(!parted.side_b), *parted)).collect();
    scored.sort_by(|a, b| a.0.total_cmp(&b.0));
    scored.into_iter().map(|(_, parted)| parted).collect()
}

/// A good pair for the pixels of a side, and its cost; none where none was found within the bound.
fn best_pair(tile: &Tile, side: u64) -> Option<(Pair, u64)> {
    let mut rest = tile.surfaces & side;
    let (mut low, mut high) = (u16::MAX, 0);
    while rest != 0 {
        let code = tile.codes[rest.trailing_zeros() as usize];
        (low, high) = (low.min(code), high.max(code));
        rest &= rest - 1;
    }
    if low > high {
        (low, high) = (0, 0);
    }
    let (low, high) = (low >> 3, high >> 3);
    let near = |at: u16| at.saturating_sub(1)..=(at + 1).min(MAX_ENDPOINT);
    near(low)
        .flat_map(|low| near(high).flat_map(move |high| [Pair { e0: high, e1: low }, Pair { e0: low, e1: high }]))
        .filter_map(|pair| Some((pair, tile.cost(side, pair)?)))
        .min_by_key(|&(_, cost)| cost)
}
