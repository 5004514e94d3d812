//! The decoder's interpolation between two keyframes, in integer arithmetic (color.md 3).
//!
//! Based on: CALF 5.1, equation 8, with the weight t in 255ths.

use half::f16;

pub trait Sample: Copy + Eq + Default + Send + Sync + std::fmt::Debug + 'static {
    const BYTES: usize;

    /// Interpolates from `a` to `b` by `weight`/255, rounded to nearest: (a·(255 − w) + b·w + 127) div 255.
    fn lerp(a: Self, b: Self, weight: u8) -> Self;

    fn key(self) -> i32;

    fn put(self, out: &mut Vec<u8>);

    /// Reads as many samples as `out` has; `bytes` must have exactly their size.
    fn get_row(out: &mut [Self], bytes: &[u8]);
}

pub fn lerp_all<S: Sample>(a: &[S], b: &[S], weight: u8, out: &mut [S]) {
    for ((out, &a), &b) in out.iter_mut().zip(a).zip(b) {
        *out = S::lerp(a, b, weight);
    }
}

impl Sample for u8 {
    const BYTES: usize = 1;

    #[inline(always)]
    fn lerp(a: u8, b: u8, weight: u8) -> u8 {
        // (x + 127) div 255 for x ≤ 255², in 16-bit arithmetic; equal to the definition for all inputs.
        let v = u16::from(a) * u16::from(255 - weight) + u16::from(b) * u16::from(weight) + 128;
        ((v + (v >> 8)) >> 8) as u8
    }

    #[inline(always)]
    fn key(self) -> i32 {
        i32::from(self)
    }

    fn put(self, out: &mut Vec<u8>) {
        out.push(self);
    }

    #[inline]
    fn get_row(out: &mut [u8], bytes: &[u8]) {
        out.copy_from_slice(bytes);
    }
}

/// A half float as an integer that ascends with its value: negative values are mirrored below 0x8000, positive ones start at
/// 0x8000. Interpolating keys is close to interpolating logarithms, which suits an HDR signal.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, PartialOrd, Ord, Hash)]
pub struct HalfKey(pub u16);

impl HalfKey {
    #[inline(always)]
    pub fn from_bits(bits: u16) -> HalfKey {
        // All ones for negative values, only the sign bit for others.
        let flip = ((bits as i16 >> 15) as u16) | 0x8000;
        HalfKey(bits ^ flip)
    }

    #[inline(always)]
    pub fn to_bits(self) -> u16 {
        let flip = ((!self.0 as i16 >> 15) as u16) | 0x8000;
        self.0 ^ flip
    }

    #[inline(always)]
    pub fn to_half(self) -> f16 {
        f16::from_bits(self.to_bits())
    }
}

impl Sample for HalfKey {
    const BYTES: usize = 2;

    #[inline(always)]
    fn lerp(a: HalfKey, b: HalfKey, weight: u8) -> HalfKey {
        let weight = u32::from(weight);
        HalfKey(((u32::from(a.0) * (255 - weight) + u32::from(b.0) * weight + 127) / 255) as u16)
    }

    #[inline(always)]
    fn key(self) -> i32 {
        i32::from(self.0)
    }

    fn put(self, out: &mut Vec<u8>) {
        out.extend_from_slice(&self.to_bits().to_le_bytes());
    }

    #[inline]
    fn get_row(out: &mut [HalfKey], bytes: &[u8]) {
        for (sample, bytes) in out.iter_mut().zip(bytes.as_chunks::<2>().0) {
            *sample = HalfKey::from_bits(u16::from_le_bytes(*bytes));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn eight_bits_follow_the_definition_for_all_inputs() {
        for a in 0..=255u8 {
            for b in 0..=255u8 {
                for weight in 0..=255u8 {
                    let (x, y, w) = (u32::from(a), u32::from(b), u32::from(weight));
                    let defined = (x * (255 - w) + y * w + 127) / 255;
                    assert_eq!(u32::from(u8::lerp(a, b, weight)), defined);
                }
            }
        }
    }

    #[test]
    fn half_keys_grow_with_the_value_and_come_back() {
        for bits in 0..=u16::MAX {
            assert_eq!(HalfKey::from_bits(bits).to_bits(), bits);
        }
        let values = [-65504.0, -1.0, -6e-8, -0.0, 0.0, 6e-8, 1.0, 65504.0].map(f16::from_f64);
        assert!(values.windows(2).all(|w| HalfKey::from_bits(w[0].to_bits()) < HalfKey::from_bits(w[1].to_bits())));
    }

    #[test]
    fn the_ends_of_an_interpolation_are_exact_and_it_stays_between() {
        let keys: Vec<HalfKey> = (0..=u16::MAX).step_by(97).chain([u16::MAX]).map(HalfKey).collect();
        for &a in &keys {
            let b = keys[(usize::from(a.0) * 7 + 13) % keys.len()];
            assert_eq!((HalfKey::lerp(a, b, 0), HalfKey::lerp(a, b, 255)), (a, b));
            for weight in [1, 127, 128, 254] {
                let between = HalfKey::lerp(a, b, weight);
                assert!(between >= a.min(b) && between <= a.max(b));
            }
        }
    }
}
