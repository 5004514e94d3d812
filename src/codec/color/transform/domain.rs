//! Lossless conversion between samples and channels (color.md 6.2): YCoCg-R of keys, with chroma predicted from luma.
//!
//! Based on: Malvar and Sullivan, *YCoCg-R: A color space with RGB reversibility and low dynamic range*, 2003.

use crate::color::blend::{HalfKey, Sample};
pub use crate::color::transform::steps::CHANNELS;
use crate::color::transform::steps::{StepTable, step_table};

/// Parameters that differ between 8-bit samples and half floats.
#[derive(Debug, Clone, Copy)]
pub struct Domain {
    /// Fraction bits of coefficients and means.
    pub fraction_bits: u32,
    /// Fraction bits of the channels of pixels with frequency offsets ([`Domain::pixel_fraction`]).
    fine_bits: u32,
    /// Bits of a key.
    pub key_bits: u32,
    /// Key whose luma is 0.
    pub middle: i32,
    /// Minimum and maximum key of the output of transformed blocks: those of finite samples.
    pub shown: [i32; 2],
    /// Steps of coefficients.
    pub steps: &'static StepTable,
}

static STEPS_OF_BYTES: StepTable = step_table(6);
static STEPS_OF_HALVES: StepTable = step_table(0);

impl Domain {
    pub const BYTES: Domain =
        Domain { fraction_bits: 6, fine_bits: 4, key_bits: 8, middle: 128, shown: [0, 255], steps: &STEPS_OF_BYTES };
    /// Keys of half floats. The middle is the key of 1.0; the output is limited to the keys of -65504 to 65504.
    pub const HALVES: Domain = Domain {
        fraction_bits: 0,
        fine_bits: 0,
        key_bits: 16,
        middle: 0xbc00,
        shown: [0x0400, 0xfbff],
        steps: &STEPS_OF_HALVES,
    };

    /// Fraction bits of the channels of pixels with a set of frequency offsets. Without offsets, keys are lossless. With
    /// offsets, samples are rounded once, instead of after a rounding of luma and chroma.
    pub fn pixel_fraction(&self, offset_set: usize) -> u32 {
        if offset_set > 0 { self.fine_bits } else { 0 }
    }
}

/// Samples that the transform codec codes by their keys.
pub trait Keyed: Sample {
    const DOMAIN: Domain;

    /// Returns the sample of a key of `key_bits` bits.
    fn from_key(key: i32) -> Self;
}

impl Keyed for u8 {
    const DOMAIN: Domain = Domain::BYTES;

    #[inline(always)]
    fn from_key(key: i32) -> u8 {
        key as u8
    }
}

impl Keyed for HalfKey {
    const DOMAIN: Domain = Domain::HALVES;

    #[inline(always)]
    fn from_key(key: i32) -> HalfKey {
        HalfKey(key as u16)
    }
}

/// Slopes of chroma that is predicted from luma, in 16ths.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct ChromaSlopes {
    pub green: i8,
    pub orange: i8,
}

impl ChromaSlopes {
    #[inline(always)]
    fn predict(slope: i8, luma: i32) -> i32 {
        i32::from(slope).wrapping_mul(luma).wrapping_add(8) >> 4
    }
}

/// Converts the keys of red, green and blue to channels.
#[inline(always)]
pub fn forward([red, green, blue]: [i32; 3], slopes: ChromaSlopes, domain: &Domain) -> [i32; CHANNELS] {
    let orange = red - blue;
    let middle = blue + (orange >> 1);
    let chroma_green = green - middle;
    let luma = middle + (chroma_green >> 1) - domain.middle;
    [
        luma,
        chroma_green - ChromaSlopes::predict(slopes.green, luma),
        orange - ChromaSlopes::predict(slopes.orange, luma),
    ]
}

/// Converts keys to the channels that an encoder aims at if samples are rounded once: without the rounding of [`forward`].
#[inline(always)]
pub fn forward_fine(keys: [i32; 3], slopes: ChromaSlopes, domain: &Domain) -> [f32; CHANNELS] {
    let [red, green, blue] = keys.map(|key| key as f32);
    let middle = 0.5 * (red + blue);
    let luma = 0.5 * (middle + green) - domain.middle as f32;
    let [of_green, of_orange] = [slopes.green, slopes.orange].map(|slope| f32::from(slope) / 16.0 * luma);
    [luma, green - middle - of_green, red - blue - of_orange]
}

/// Inverse of [`forward`], with channels in units of 2^-`fraction`. Returns keys in these units.
#[inline(always)]
pub fn inverse(
    [luma, green, orange]: [i32; CHANNELS],
    slopes: ChromaSlopes,
    domain: &Domain,
    fraction: u32,
) -> [i32; 3] {
    let chroma_green = green.wrapping_add(ChromaSlopes::predict(slopes.green, luma));
    let orange = orange.wrapping_add(ChromaSlopes::predict(slopes.orange, luma));
    let middle = luma.wrapping_add(domain.middle << fraction).wrapping_sub(chroma_green >> 1);
    let green = chroma_green.wrapping_add(middle);
    let blue = middle.wrapping_sub(orange >> 1);
    [blue.wrapping_add(orange), green, blue]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn channels_are_lossless() {
        for domain in [Domain::BYTES, Domain::HALVES] {
            let most = (1 << domain.key_bits) - 1;
            for at in 0..20_000i32 {
                let keys = [7919, 104_729, 1_299_709].map(|prime| at.wrapping_mul(prime) & most);
                for slopes in [(0, 0), (5, -3), (-128, 127)].map(|(green, orange)| ChromaSlopes { green, orange }) {
                    assert_eq!(inverse(forward(keys, slopes, &domain), slopes, &domain, 0), keys);
                    let fine = forward_fine(keys, slopes, &domain).map(|value| (16.0 * value).round() as i32);
                    let keys_again = inverse(fine, slopes, &domain, 4).map(|key| (key + 8) >> 4);
                    assert!(domain.key_bits > 8 || keys_again == keys, "{keys:?}: {keys_again:?}");
                }
            }
        }
    }
}
