//! Depth: 16-bit log codes and their coding in time (CALF 5.2, 5.3; formats/depth.md).
//!
//! Enters: metres. Leaves: chunk payloads whose decoding is within the promised bound in every pixel.

pub mod bc4w;
pub mod biquadratic;
pub mod bits;
pub mod block;
pub mod block_chunk;
pub mod block_temporal;
pub mod boxes;
pub mod census;
mod coefficients;
pub mod domain;
pub(crate) mod least_squares;
pub mod limit;
mod line;
pub mod mode_decision;
pub mod node_chunk;
pub mod node_encoder;
pub mod nodes;
pub mod pieces;
pub mod platelet;
pub mod precision;
pub mod quadtree;
pub mod quantise;
pub mod record_table;
pub mod records;
pub mod runtime;
pub mod storage;
pub mod temporal;
pub mod texel;
pub mod tile_psnr;
pub mod tree_chunk;
pub mod window;

pub use boxes::PixelBox;
pub use coefficients::DomainParts;
pub use quantise::{BACKGROUND_CODE, CodeTable, DepthRange, Quantiser};
pub use records::TemporalChunk;
pub use temporal::{TemporalEncoder, TemporalSettings};
pub use texel::Texel;
