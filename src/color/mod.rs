//! Colour: cells of an image, coded in time as keyframes and weights (CALF 5.1; formats/color.md).
//!
//! Enters: 8-bit samples or half floats. Leaves: chunk payloads in which every frame of every cell reaches the PSNR
//! asked for, as measured on what the decoder makes of them.

pub mod blend;
pub mod cells;
pub mod keyframe_blocks;
#[cfg(feature = "encode")]
pub mod keyframes;
pub mod quality;
pub mod settings;
#[cfg(feature = "encode")]
pub mod temporal;

pub use blend::{HalfKey, Sample};
pub use cells::{CellChunk, CellFormat};
pub use keyframe_blocks::KeyframeBlocks;
pub use quality::Quality;
pub use settings::SearchSettings;
#[cfg(feature = "encode")]
pub use temporal::CellEncoder;
