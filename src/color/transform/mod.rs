//! Colour by a transform in space and time, for each cell and chunk (color.md 6).
//!
//! A chunk of a cell is decodable alone. It is cut into regions of 32×32 pixels, each with a substream of its own; a region is a
//! tree of blocks in space and time; a block has integer cosine coefficients, quantised with one step for the whole cell, or
//! a palette. Nothing is predicted from decoded pixels, so that no error travels.
//!
//! Based on: block transforms and partitions of HEVC (ITU-T H.265), palettes of its screen content extensions, static
//! entropy tables in place of adaptation.

#[cfg(feature = "gpu")]
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
pub mod tables;

pub use domain::{Domain, Keyed};
pub use reconstruct::TransformChunk;
pub use tables::Tables;

#[cfg(test)]
mod tests;
