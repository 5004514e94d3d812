//! What the temporal coder is generic over: depth codes and material triples (depth.md 3).

use crate::depth::quantise::BACKGROUND_CODE;

/// A pixel value that is stored as it is.
pub trait Texel: Copy + Eq + Default + Send + Sync + std::fmt::Debug + 'static {
    const BYTES: usize;

    fn put(self, out: &mut Vec<u8>);

    /// Reads as many values as fit into `out`; `bytes` has exactly their size.
    fn get_row(out: &mut [Self], bytes: &[u8]);

    /// Whether a decoder may show `held` where the source has `source`: the promise behind `--update-threshold`.
    fn within(held: Self, source: Self, epsilon: u16) -> bool;
}

/// A depth code. The background is never taken for a surface, nor a surface for it, at any epsilon.
impl Texel for u16 {
    const BYTES: usize = 2;

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
}

/// Reflection weight, refraction weight and index of refraction, 8 bits each; epsilon bounds each of them.
impl Texel for [u8; 3] {
    const BYTES: usize = 3;

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
}
