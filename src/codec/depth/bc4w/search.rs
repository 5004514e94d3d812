//! Finds the line, endpoints and indices of a block.
//!
//! The search space is every bipartition by a line ([`bipartitions`](crate::depth::bc4w::bipartitions)) and, for each side and in
//! both modes, all pairs of 13-bit endpoints within [`PAD`](crate::depth::bc4w::tile::PAD) of the side's surfaces. Tests search
//! all of it (`literal`). `Exhaustive` finds the same squared error by branch and bound (`bounded`, which states where that is
//! not proven). `Normal` and `Fast` try the most promising lines, many or few, with endpoints around a least-squares fit
//! (`quick`): the exact search takes milliseconds per block, and its last tenths of a decibel are seldom worth the time.

use crate::depth::bc4w::tile::{Solution, Tile};
use crate::depth::bc4w::{Bc4w, bounded, quick};
use crate::depth::block::{Accuracy, Block};
use crate::effort::Effort;

/// Returns the block with the lowest squared error found at this effort. The background is exact.
pub fn encode(block: &Block<'_>, effort: Effort) -> (Bc4w, Accuracy) {
    let tile = Tile::new(block, u16::MAX);
    // Without a bound there is always a solution: palettes of the second mode contain the background and code 0.
    let solution = search(&tile, effort).unwrap_or(Solution::FLAT);
    tile.finish(solution)
}

/// Returns the block with the lowest squared error found at this effort among those with no difference above `bound` codes;
/// `None` if no such block was found.
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
