//! Colour cells: coded in time as keyframes and weights (CALF 5.1), or with a transform in space and time (formats/color.md).
//!
//! Two sample formats: 8 bits after an exposure and a transfer function, for footage that is displayed as it is; half floats
//! for linear light, interpolated as integers in the order of their values, which is close to interpolating logarithms. Every
//! frame of every cell reaches the quality target, measured on decoded samples.

pub mod blend;
pub mod cells;
pub mod chunk;
pub mod keyframe_blocks;
#[cfg(feature = "encode")]
pub mod keyframes;
pub mod quality;
#[cfg(feature = "encode")]
pub mod temporal;
pub mod transform;

pub use blend::{HalfKey, Sample};
pub use cells::{CellChunk, CellFormat};
pub use chunk::{ChunkFormat, ColorChunk};
pub use keyframe_blocks::KeyframeBlocks;
pub use quality::{Quality, SearchSettings, Target};
#[cfg(feature = "encode")]
pub use temporal::CellEncoder;
