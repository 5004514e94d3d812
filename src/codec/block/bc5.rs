//! BC5: two channels of 8 bits, 16 pixels in 16 bytes (formats/blocks.md 5).
//!
//! Takes a block, which consists of two [`bc4`] blocks, and returns red and green of its 16 pixels, row by row.

use super::{TEXELS, bc4};

pub fn decode(block: &[u8; 16]) -> [[u8; 2]; TEXELS] {
    let half = |at: usize| bc4::decode(&std::array::from_fn(|byte| block[at + byte]));
    let [red, green] = [half(0), half(8)];
    std::array::from_fn(|texel| [red[texel], green[texel]])
}
