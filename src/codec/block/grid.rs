//! Blocks of 4x4 pixels and the grid that covers an image (formats/blocks.md 2).

pub const SIDE: usize = 4;
pub const TEXELS: usize = SIDE * SIDE;

/// Columns and rows of blocks that cover `width` x `height` pixels; the last column and row may extend past the edge.
pub fn grid(width: usize, height: usize) -> [usize; 2] {
    [width.div_ceil(SIDE), height.div_ceil(SIDE)]
}

pub trait BlockFormat {
    type Texel: Copy + Default + PartialEq + Send + Sync + std::fmt::Debug + 'static;
    const BYTES: usize;
    /// Decodes the first [`Self::BYTES`] of `block` into its pixels, row by row. A shorter slice leaves `out` unchanged.
    fn decode_block(block: &[u8], out: &mut [Self::Texel; TEXELS]);
}
