//! Joins containers without decoding them, and packs quadtrees at an error bound.

#![doc(hidden)]

pub mod flatten;
pub mod merge;
