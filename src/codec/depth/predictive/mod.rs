//! Near-lossless predictive coding of depth: error-bounded prediction of log codes, in a closed loop in space and time (depth.md
//! 15).
//!
//! A unit is coded in blocks of 8x8 pixels: unchanged from the frame before, background, a plane continued from the left or from
//! above, four blocks of 4x4 pixels, or pixel by pixel. Pixels are predicted with slopes, which each residual corrects; residuals
//! are in steps of 2E + 1 codes. The decoder state excludes the curvature that the projection gives to planes ([`projection`]).
//! Symbols have static distributions, selected by contexts of symbols that are already decoded. If only few codes occur, their
//! numbers are coded instead ([`levels`]).
//!
//! Based on: M. J. Weinberger, G. Seroussi, G. Sapiro, *The LOCO-I Lossless Image Compression Algorithm*, 2000, for near-lossless
//! residuals and contexts.

pub mod chunk;
pub mod contexts;
#[cfg(feature = "encode")]
pub mod encoder;
#[cfg(feature = "encode")]
mod fit;
pub mod levels;
pub mod modes;
pub mod pixel;
pub mod plane;
#[cfg(feature = "encode")]
mod price;
pub mod projection;
#[cfg(feature = "encode")]
mod search;
mod source;
#[cfg(all(test, feature = "encode"))]
mod tests;
pub mod tile;

pub use chunk::PredictiveChunk;
pub use contexts::{Predictive, TableSet, Tables};
pub use levels::Levels;
pub use projection::UnitArea;
pub use tile::PredictiveHeader;
