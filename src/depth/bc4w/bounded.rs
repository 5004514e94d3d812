//! The normal search.

use crate::depth::bc4w::tile::{Solution, Tile};

/// placeholder
pub fn search(tile: &Tile) -> Option<Solution> {
    crate::depth::bc4w::quick::search(tile)
}
