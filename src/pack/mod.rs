//! Joins containers without decoding them, and packs quadtrees at an error bound.

pub mod flatten;
pub mod merge;
