//! Block-compressed images: 4x4 pixels in 8 or 16 bytes, in the texture formats of GPUs.
//!
//! Decoding a block is part of the file format. The decoders are therefore our own, use integers (formats/blocks.md), and are
//! compared with an independent decoder in every mode. The encoders are external libraries behind a trait.

pub mod bc6h;
pub mod bc7;
mod bptc;
#[cfg(feature = "encode")]
mod encode;
mod formats;
mod grid;

#[cfg(feature = "encode")]
pub use encode::BlockEncoder;
pub use formats::{Bc1, Bc4, Bc5, Bc6h, Bc7, Bc7Rgba, decode_bc1, decode_bc4, decode_bc5, decode_image};
pub use grid::{BlockFormat, SIDE, TEXELS, grid};

#[cfg(feature = "encode")]
#[cfg(test)]
mod tests;
