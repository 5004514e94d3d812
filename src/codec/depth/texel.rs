//! Pixel types of the temporal coder: depth codes and material triples (depth.md 3).

use crate::block::{Bc1, Bc5, BlockFormat, TEXELS};
use crate::depth::quantise::BACKGROUND_CODE;

/// A pixel value, which is stored directly or in blocks of a texture format.
pub trait Texel: Copy + Eq + Default + Send + Sync + std::fmt::Debug + 'static {
    const BYTES: usize;
    type Format: BlockFormat;

    fn put(self, out: &mut Vec<u8>);

    /// Reads as many values as fit into `out`; `bytes` must have exactly their size.
    fn get_row(out: &mut [Self], bytes: &[u8]);

    /// Returns true if a decoder may show `held` where the source is `source`: the bound that `--update-threshold` sets.
    fn within(held: Self, source: Self, epsilon: u16) -> bool;

    /// Converts a decoded pixel of a block to a value.
    fn of_block(texel: <Self::Format as BlockFormat>::Texel) -> Self;

    fn decode(block: &[u8]) -> [Self; TEXELS] {
        let mut texels = [<Self::Format as BlockFormat>::Texel::default(); TEXELS];
        Self::Format::decode_block(block, &mut texels);
        texels.map(Self::of_block)
    }
}

/// A depth code. Background is never within any epsilon of a surface. In BC5 blocks the high byte is red and the low byte is
/// green.
impl Texel for u16 {
    const BYTES: usize = 2;
    type Format = Bc5;

    fn put(self, out: &mut Vec<u8>) {
        out.extend_from_slice(&self.to_le_bytes());
    }

    #[inline]
    fn get_row(out: &mut [Self], bytes: &[u8]) {
        for (value, bytes) in out.iter_mut().zip(bytes.as_chunks::<2>().0) {
            *value = u16::from_le_bytes(*bytes);
        }
    }

    #[inline]
    fn within(held: Self, source: Self, epsilon: u16) -> bool {
        held.abs_diff(source) <= epsilon && (held == BACKGROUND_CODE) == (source == BACKGROUND_CODE)
    }

    fn of_block(texel: [u8; 2]) -> u16 {
        u16::from_be_bytes(texel)
    }
}

/// Reflection weight, refraction weight and index of refraction, 8 bits each; epsilon bounds each of them. In BC1 blocks they are
/// red, green and blue.
impl Texel for [u8; 3] {
    const BYTES: usize = 3;
    type Format = Bc1;

    fn put(self, out: &mut Vec<u8>) {
        out.extend_from_slice(&self);
    }

    #[inline]
    fn get_row(out: &mut [Self], bytes: &[u8]) {
        out.copy_from_slice(bytes.as_chunks::<3>().0);
    }

    #[inline]
    fn within(held: Self, source: Self, epsilon: u16) -> bool {
        (0..3).all(|i| u16::from(held[i].abs_diff(source[i])) <= epsilon)
    }

    fn of_block(texel: [u8; 3]) -> [u8; 3] {
        texel
    }
}
