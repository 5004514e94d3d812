//! Depth: 16-bit log codes and their coding in space (GDC) and time (CALF 5.2, 5.3); formats/depth.md.
//!
//! Decoders use integers only: floating point differs between devices, and compilers reorder it. Encoders search in
//! floating point and measure with the decoder's own functions, so a stated bound is exact.

pub mod bc4w;
pub mod biquadratic;
pub mod bits;
pub mod block;
pub mod block_chunk;
#[cfg(feature = "encode")]
pub mod block_temporal;
pub mod block_tiles;
pub mod boxes;
pub mod domain;
#[cfg(feature = "encode")]
pub mod least_squares;
#[cfg(feature = "encode")]
pub mod limit;
#[cfg(feature = "encode")]
pub mod mode_decision;
pub mod mode_statistics;
pub mod node_chunk;
#[cfg(feature = "encode")]
pub mod node_encoder;
pub mod nodes;
#[cfg(feature = "encode")]
pub mod open_chunk;
pub mod platelet;
pub mod predictive;
#[cfg(feature = "encode")]
pub mod quadtree;
pub mod quantise;
pub mod record_table;
pub mod records;
pub mod runtime;
#[cfg(feature = "encode")]
pub mod spread;
pub mod storage;
#[cfg(feature = "encode")]
pub mod temporal;
pub mod texel;
#[cfg(feature = "encode")]
pub mod tile_psnr;
pub mod tree_chunk;
pub mod window_check;

pub use boxes::{PixelBox, TemporalSettings};
pub use domain::DomainParts;
pub use quantise::{BACKGROUND_CODE, CodeTable, DepthRange, Quantiser};
pub use records::TemporalChunk;
#[cfg(feature = "encode")]
pub use temporal::TemporalEncoder;
pub use texel::Texel;
