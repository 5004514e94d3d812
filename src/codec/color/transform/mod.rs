//! Colour codec with a transform in space and time, for each cell and chunk (color.md 6).
//!
//! A chunk of a cell is decoded alone. It is cut into regions of 32×32 pixels, each with its own substream. A region is a
//! tree of blocks in space and time. A block has integer cosine coefficients, quantised with steps that depend on channel,
//! frequency and region, or a palette. Nothing is predicted from decoded pixels, so errors do not propagate.
//!
//! Based on: block transforms and partitions of HEVC (ITU-T H.265), palettes of its screen content extensions, and static
//! entropy tables instead of adaptive ones.

#[cfg(feature = "encode")]
pub mod authored;
pub mod basis;
pub mod blocks;
pub mod coder;
pub mod contexts;
pub mod domain;
#[cfg(feature = "encode")]
pub mod encode;
pub mod levels;
pub mod means;
pub mod palette;
pub mod payload;
pub mod reconstruct;
pub mod region;
pub mod scan;
pub mod steps;

pub use contexts::{TableSet, Tables, Transform};
pub use domain::{Domain, Keyed};
pub use reconstruct::TransformChunk;

#[cfg(test)]
mod tests;
