//! Joins containers without decoding them, and packs quadtrees at an error bound.

#![doc(hidden)]

mod flatten;
mod join;

pub use flatten::FlattenSettings;
pub use join::{PackReport, PackSettings, PackSummary, Repack, pack};
