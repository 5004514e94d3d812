//! Finds the line, endpoints and indices of a block.
//!
//! What a search may choose: every bipartition that a line makes ([`bipartitions`](crate::depth::bc4w::bipartitions)); for
//! each side, both endpoints among the 13-bit endpoints within [`PAD`](crate::depth::bc4w::tile::PAD) of the side's
//! surfaces, in both modes. Tests try all of it (`literal`). `Exhaustive` finds the same squared error by branch and bound
//! (`bounded`, which says where that is not proven). `Normal` and `Fast` take the most promising lines, many or few, and
//! the endpoints around a least-squares fit (`quick`): the exact search takes milliseconds a block, and the last tenths of
//! a decibel are seldom worth it.

use crate::depth::bc4w::tile::{Solution, Tile};
use crate::depth::bc4w::{Bc4w, bounded, quick};
use crate::depth::block::{Accuracy, Block};
use crate::effort::Effort;

/// The block with the lowest squared error that the effort finds. The background is exact.
pub fn encode(block: &Block<'_>, effort: Effort) -> (Bc4w, Accuracy) {
    let tile = Tile::new(block, u16::MAX);
    // Without a bound there is always a solution: palettes of the second mode hold the background and code 0.
    let solution = search(&tile, effort).unwrap_or(Solution::FLAT);
    tile.finish(solution)
}

/// The block with the lowest squared error that the effort finds among those with no difference above `bound` codes.
pub fn encode_within(block: &Block<'_>, bound: u16, effort: Effort) -> Option<(Bc4w, Accuracy)> {
    let tile = Tile::new(block, bound);
    search(&tile, effort).map(|solution| tile.finish(solution))
}

fn search(tile: &Tile, effort: Effort) -> Option<Solution> {
    if tile.surfaces == 0 {
        return Some(Solution::FLAT);
    }
    match effort {
        Effort::Fast => quick::best_of(tile, quick::FAST).map(|(_, solution)| solution),
        Effort::Normal => quick::best_of(tile, quick::NORMAL).map(|(_, solution)| solution),
        Effort::Exhaustive => bounded::search(tile),
    }
}

#[cfg(test)]
mod tests;
