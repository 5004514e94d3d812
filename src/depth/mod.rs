//! Depth: 16-bit log codes and their coding in time (CALF 5.2, 5.3; formats/depth.md).
//!
//! Enters: metres. Leaves: chunk payloads whose decoding is within the promised bound in every pixel.

pub mod biquadratic;
pub mod block;
pub mod boxes;
pub mod domain;
mod least_squares;
pub mod limit;
mod line;
pub mod platelet;
pub mod precision;
pub mod quantise;
pub mod records;
pub mod temporal;
pub mod texel;
pub mod window;

pub use boxes::PixelBox;
pub use quantise::{BACKGROUND_CODE, CodeTable, DepthRange, Quantiser};
pub use records::TemporalChunk;
pub use temporal::{TemporalEncoder, TemporalSettings};
pub use texel::Texel;
