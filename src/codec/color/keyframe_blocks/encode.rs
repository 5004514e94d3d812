//! Encodes keyframes in blocks of a texture format.

use crate::block::{Bc1, Bc6h, Bc7, BlockEncoder};
use crate::color::blend::HalfKey;
use crate::effort::Effort;

#[derive(Debug, Clone, Copy)]
pub struct KeyframeEncoder<S> {
    pub encode: fn(&[S], [usize; 2], Effort) -> Vec<u8>,
    /// Efforts that [`Effort::Fast`] tries in turn before it stores samples.
    pub fast: &'static [Effort],
}

/// For formats whose efforts each take ten times as long as the one before.
const ONE_HARDER: &[Effort] = &[Effort::Fast, Effort::Normal];
/// For formats whose normal effort is the same as fast.
const HARDEST: &[Effort] = &[Effort::Fast, Effort::Exhaustive];

impl<S> KeyframeEncoder<S> {
    pub fn tries(&self, effort: Effort) -> &'static [Effort] {
        match effort {
            Effort::Fast => self.fast,
            Effort::Normal => &[Effort::Normal, Effort::Exhaustive],
            Effort::Exhaustive => &[Effort::Exhaustive],
        }
    }
}

pub const BC1: KeyframeEncoder<u8> = KeyframeEncoder { encode: encode_bytes::<Bc1>, fast: HARDEST };
pub const BC7: KeyframeEncoder<u8> = KeyframeEncoder { encode: encode_bytes::<Bc7>, fast: ONE_HARDER };
/// BC6H: negative samples become 0.
pub const BC6H: KeyframeEncoder<HalfKey> = KeyframeEncoder { encode: encode_halves, fast: ONE_HARDER };

fn encode_bytes<F: BlockEncoder<Texel = [u8; 3]> + Default>(
    samples: &[u8],
    [width, height]: [usize; 2],
    effort: Effort,
) -> Vec<u8> {
    F::default().encode(samples.as_chunks().0, width, height, effort)
}

fn encode_halves(samples: &[HalfKey], [width, height]: [usize; 2], effort: Effort) -> Vec<u8> {
    let bits: Vec<[u16; 3]> =
        samples.as_chunks().0.iter().map(|pixel: &[HalfKey; 3]| pixel.map(HalfKey::to_bits)).collect();
    Bc6h.encode(&bits, width, height, effort)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::keyframe_blocks::KeyframeBlocks;

    #[test]
    fn images_of_any_size_come_back_from_blocks() {
        for (width, height) in [(1, 1), (3, 5), (4, 4), (9, 6), (16, 16)] {
            let flat: Vec<u8> = (0..width * height).flat_map(|_| [200, 100, 50]).collect();
            for blocks in [KeyframeBlocks::BC1, KeyframeBlocks::BC7] {
                let stored = (blocks.encoder.encode)(&flat, [width, height], Effort::Fast);
                assert_eq!(stored.len(), blocks.image_bytes([width, height]));
                let mut shown = vec![0; flat.len()];
                (blocks.decode)(&stored, [width, height], &mut shown);
                assert!(shown.iter().zip(&flat).all(|(a, b)| a.abs_diff(*b) <= 4), "{width}x{height}: {shown:?}");
            }
            let keys: Vec<HalfKey> = (0..3 * width * height).map(|_| HalfKey::from_bits(0x3C00)).collect();
            let stored = (KeyframeBlocks::BC6H.encoder.encode)(&keys, [width, height], Effort::Fast);
            assert_eq!(stored.len(), KeyframeBlocks::BC6H.image_bytes([width, height]));
            let mut shown = vec![HalfKey::default(); keys.len()];
            (KeyframeBlocks::BC6H.decode)(&stored, [width, height], &mut shown);
            assert!(shown.iter().zip(&keys).all(|(a, b)| a.0.abs_diff(b.0) <= 40), "{width}x{height}: {shown:?}");
        }
    }
}
