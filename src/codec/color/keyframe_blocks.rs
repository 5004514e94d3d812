//! Keyframes in blocks of a texture format (CALF 5.3; color.md 4): the properties of a format that a cell needs.

#[cfg(feature = "encode")]
pub mod encode;

use crate::block::{self, Bc1, Bc6h, Bc7, BlockFormat, SIDE};
use crate::color::blend::HalfKey;

#[derive(Debug, Clone, Copy)]
pub struct KeyframeBlocks<S> {
    pub bytes: usize,
    /// Decodes rows of blocks into the samples of an image of this width and height; samples outside are dropped.
    pub decode: fn(&[u8], [usize; 2], &mut [S]),
    #[cfg(feature = "encode")]
    pub encoder: encode::KeyframeEncoder<S>,
}

impl<S> KeyframeBlocks<S> {
    pub fn image_bytes(&self, [width, height]: [usize; 2]) -> usize {
        let [columns, rows] = block::grid(width, height);
        columns * rows * self.bytes
    }
}

impl KeyframeBlocks<u8> {
    pub const BC1: Self = KeyframeBlocks {
        bytes: Bc1::BYTES,
        decode: decode_bytes::<Bc1>,
        #[cfg(feature = "encode")]
        encoder: encode::BC1,
    };
    pub const BC7: Self = KeyframeBlocks {
        bytes: Bc7::BYTES,
        decode: decode_bytes::<Bc7>,
        #[cfg(feature = "encode")]
        encoder: encode::BC7,
    };
}

impl KeyframeBlocks<HalfKey> {
    /// BC6H, for half floats of at least 0.
    pub const BC6H: Self = KeyframeBlocks {
        bytes: Bc6h::BYTES,
        decode: decode_halves,
        #[cfg(feature = "encode")]
        encoder: encode::BC6H,
    };
}

fn decode_bytes<F: BlockFormat<Texel = [u8; 3]>>(blocks: &[u8], [width, height]: [usize; 2], out: &mut [u8]) {
    block::decode_image::<F>(blocks, width, height, out.as_chunks_mut().0);
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
