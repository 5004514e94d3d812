//! Keyframes as blocks of a texture format (CALF 5.3; color.md 4): what a cell needs to know of a format.

use crate::block::{self, Bc1, Bc6h, Bc7, BlockEncoder, BlockFormat, SIDE};
use crate::color::blend::HalfKey;
use crate::effort::Effort;

/// How keyframes of one kind of samples become blocks, and blocks samples.
#[derive(Debug, Clone, Copy)]
pub struct KeyframeBlocks<S> {
    /// Bytes of a block of 4x4 pixels.
    pub bytes: usize,
    /// Decodes rows of blocks into the samples of an image of this width and height; what lies outside is dropped.
    pub decode: fn(&[u8], [usize; 2], &mut [S]),
    /// Encodes the samples of an image of this width and height.
    pub encode: fn(&[S], [usize; 2], Effort) -> Vec<u8>,
    /// Efforts that `Effort::Fast` tries in turn before blocks are given up.
    pub fast: &'static [Effort],
}

/// Where each effort takes ten times as long as the one before.
const ONE_HARDER: &[Effort] = &[Effort::Fast, Effort::Normal];
/// Where the normal effort is the fast one.
const HARDEST: &[Effort] = &[Effort::Fast, Effort::Exhaustive];

impl<S> KeyframeBlocks<S> {
    /// Efforts that are tried in turn before blocks are given up.
    pub fn tries(&self, effort: Effort) -> &'static [Effort] {
        match effort {
            Effort::Fast => self.fast,
            Effort::Normal => &[Effort::Normal, Effort::Exhaustive],
            Effort::Exhaustive => &[Effort::Exhaustive],
        }
    }

    /// Bytes of an image of this width and height.
    pub fn image_bytes(&self, [width, height]: [usize; 2]) -> usize {
        let [columns, rows] = block::grid(width, height);
        columns * rows * self.bytes
    }
}

impl KeyframeBlocks<u8> {
    /// BC1.
    pub const BC1: Self =
        KeyframeBlocks { bytes: Bc1::BYTES, decode: decode_bytes::<Bc1>, encode: encode_bytes::<Bc1>, fast: HARDEST };
    /// BC7.
    pub const BC7: Self = KeyframeBlocks {
        bytes: Bc7::BYTES,
        decode: decode_bytes::<Bc7>,
        encode: encode_bytes::<Bc7>,
        fast: ONE_HARDER,
    };
}

impl KeyframeBlocks<HalfKey> {
    /// BC6H, of half floats from 0 on: negative ones become 0.
    pub const BC6H: Self =
        KeyframeBlocks { bytes: Bc6h::BYTES, decode: decode_halves, encode: encode_halves, fast: ONE_HARDER };
}

fn decode_bytes<F: BlockFormat<Texel = [u8; 3]>>(blocks: &[u8], [width, height]: [usize; 2], out: &mut [u8]) {
    block::decode_image::<F>(blocks, width, height, out.as_chunks_mut().0);
}

fn encode_bytes<F: BlockEncoder<Texel = [u8; 3]> + Default>(
    samples: &[u8],
    [width, height]: [usize; 2],
    effort: Effort,
) -> Vec<u8> {
    F::default().encode(samples.as_chunks().0, width, height, effort)
}

fn decode_halves(blocks: &[u8], [width, _]: [usize; 2], out: &mut [HalfKey]) {
    let mut bits = vec![[0; 3]; width * SIDE];
    for (line, out) in blocks.chunks(block::grid(width, 1)[0] * Bc6h::BYTES).zip(out.chunks_mut(3 * SIDE * width)) {
        let rows = out.len() / (3 * width);
        block::decode_image::<Bc6h>(line, width, rows, &mut bits);
        for (key, bits) in out.iter_mut().zip(bits.as_flattened()) {
            *key = HalfKey::from_bits(*bits);
        }
    }
}

fn encode_halves(samples: &[HalfKey], [width, height]: [usize; 2], effort: Effort) -> Vec<u8> {
    let bits: Vec<[u16; 3]> =
        samples.as_chunks().0.iter().map(|pixel: &[HalfKey; 3]| pixel.map(HalfKey::to_bits)).collect();
    Bc6h.encode(&bits, width, height, effort)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn images_of_any_size_come_back_from_blocks() {
        for (width, height) in [(1, 1), (3, 5), (4, 4), (9, 6), (16, 16)] {
            let flat: Vec<u8> = (0..width * height).flat_map(|_| [200, 100, 50]).collect();
            for blocks in [KeyframeBlocks::BC1, KeyframeBlocks::BC7] {
                let stored = (blocks.encode)(&flat, [width, height], Effort::Fast);
                assert_eq!(stored.len(), blocks.image_bytes([width, height]));
                let mut shown = vec![0; flat.len()];
                (blocks.decode)(&stored, [width, height], &mut shown);
                assert!(shown.iter().zip(&flat).all(|(a, b)| a.abs_diff(*b) <= 4), "{width}x{height}: {shown:?}");
            }
            let keys: Vec<HalfKey> = (0..3 * width * height).map(|_| HalfKey::from_bits(0x3C00)).collect();
            let stored = (KeyframeBlocks::BC6H.encode)(&keys, [width, height], Effort::Fast);
            assert_eq!(stored.len(), KeyframeBlocks::BC6H.image_bytes([width, height]));
            let mut shown = vec![HalfKey::default(); keys.len()];
            (KeyframeBlocks::BC6H.decode)(&stored, [width, height], &mut shown);
            assert!(shown.iter().zip(&keys).all(|(a, b)| a.0.abs_diff(b.0) <= 40), "{width}x{height}: {shown:?}");
        }
    }
}
