//! Error of a decoded cell relative to its source, as an exact integer (color.md 5), and the quality that an encoder aims at.
//!
//! 8-bit colour: the squared error of the samples, peak 255. Half floats: the squared error of their PU21 encoding in 64ths,
//! peak 256. CALF 5.1 asks for another metric for HDR and names none; PU21 weighs visible differences from candlelight to
//! daylight, while a PSNR of linear values would measure only the highlights. Samples outside the range of PU21 have an
//! additional bound, because a mean over a cell does not limit the error of a lamp of few pixels.

use half::f16;

use crate::color::blend::{HalfKey, Sample};
use crate::effort::Effort;
use crate::error::{Error, Result};
use crate::metrics::psnr::{U8_PEAK, psnr_to_max_sse};
use crate::metrics::pu21::{PU21_MAX_CD_M2, PU21_MIN_CD_M2, PU21_PEAK, PuTable};

/// Perceptual quality of equal pictures (color.md 5.2).
pub const MAX_QUALITY: f64 = 100.0;

pub const PU_STEPS: f64 = 64.0;
/// Maximum error of a sample outside the range of PU21, in multiples of the RMS error at the minimum PSNR.
pub const MAX_OUTSIDE_RMS: u64 = 4;
/// Samples per block, within which squared errors are summed in 32 bits.
const BLOCK: usize = 2048;

/// Maximum error in codes of a sample outside the range of PU21, at a perceptual quality (color.md 5.2).
pub fn outside_codes(quality: f64) -> f64 {
    (MAX_QUALITY - quality) * 0.4
}

/// Quality target of encoded colour (color.md 5).
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Target {
    /// Minimum perceptual quality of every frame of every cell, 0 to 100 (color.md 5.2). Transform codec only.
    Quality(f64),
    /// Minimum PSNR of every frame of every cell, in dB, 0 to 200.
    Psnr(f64),
    /// No quality target: a step index for all cells, 0 to 240. Transform codec only.
    Step(u8),
}

impl Target {
    /// Minimum PSNR in dB; 0 for other targets.
    pub fn min_psnr_db(self) -> f64 {
        if let Target::Psnr(db) = self { db } else { 0.0 }
    }

    /// Minimum perceptual quality; 0 for other targets.
    pub fn min_quality(self) -> f64 {
        if let Target::Quality(quality) = self { quality } else { 0.0 }
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SearchSettings {
    pub target: Target,
    /// Search effort. Fast doubles the distance, then bisects. Normal doubles the distance, then tries every distance between
    /// the last that sufficed and the first that did not. Exhaustive tries every distance, the farthest first, and so finds
    /// the maximum of equation 12 within the lookahead.
    pub effort: Effort,
    /// Maximum number of distinct pictures between one keyframe and the next, at least 1; limits memory and time. Repeats of
    /// the previous picture do not count.
    pub lookahead: u32,
}

impl Default for SearchSettings {
    fn default() -> Self {
        SearchSettings { target: Target::Psnr(50.0), effort: Effort::Normal, lookahead: 64 }
    }
}

pub trait Quality<S: Sample>: Sync {
    fn peak(&self) -> f64;

    /// Returns Σ (shown − source)² of the decoder's interpolation between `a` and `b` with `weight`. The result is larger
    /// where the bound on single samples requires it, so that both bounds hold up to [`Self::max_squared_error`]. May return
    /// early, with any value above `limit`, once the sum exceeds it.
    fn squared_error(&self, a: &[S], b: &[S], weight: u8, source: &[S], limit: u64) -> u64;

    fn max_squared_error(&self, db: f64, samples: usize) -> u64 {
        psnr_to_max_sse(db, samples as u64, self.peak())
    }

    /// True if one step of a sample's key is one step of the metric, so that sums over keys bound it.
    const KEYS_ARE_STEPS: bool;

    /// Code of a sample; the peak is 255 or 256.
    fn code(&self, sample: S) -> f32;

    /// Change of a sample's code per key, or per 16 keys of half floats.
    fn codes_a_key(&self, sample: S) -> f32;

    /// Maximum error in codes of the samples to which the bound on single samples applies; 0 if there are none.
    fn largest_outside(&self, shown: &[S], source: &[S]) -> f32;
}

#[derive(Debug, Clone, Copy, Default)]
pub struct EightBit;

impl Quality<u8> for EightBit {
    const KEYS_ARE_STEPS: bool = true;

    #[inline(always)]
    fn code(&self, sample: u8) -> f32 {
        f32::from(sample)
    }

    #[inline(always)]
    fn codes_a_key(&self, _sample: u8) -> f32 {
        1.0
    }

    fn largest_outside(&self, _shown: &[u8], _source: &[u8]) -> f32 {
        0.0
    }

    fn peak(&self) -> f64 {
        U8_PEAK
    }

    fn squared_error(&self, a: &[u8], b: &[u8], weight: u8, source: &[u8], limit: u64) -> u64 {
        let mut total = 0;
        for ((a, b), source) in a.chunks(BLOCK).zip(b.chunks(BLOCK)).zip(source.chunks(BLOCK)) {
            let mut sum = 0u32;
            for ((&a, &b), &source) in a.iter().zip(b).zip(source) {
                let error = i32::from(u8::lerp(a, b, weight)) - i32::from(source);
                sum += (error * error) as u32;
            }
            total += u64::from(sum);
            if total > limit {
                break;
            }
        }
        total
    }
}

#[derive(Debug, Clone)]
pub struct Pu21 {
    /// PU21 encoding of every key, in 64ths.
    steps: Vec<i32>,
    /// First and last key in the range of PU21.
    range: [HalfKey; 2],
}

impl Pu21 {
    /// Creates the metric for footage whose value 1.0 is displayed at `white_cd_m2`.
    pub fn new(white_cd_m2: f64) -> Result<Pu21> {
        Self::check_white(white_cd_m2)?;
        let table = PuTable::new(white_cd_m2)?;
        let step = |code: f32| (f64::from(code) * PU_STEPS).round() as i32;
        let steps = (0..=u16::MAX).map(|key| step(table.encode(HalfKey(key).to_half()))).collect();
        let key = |value: f16| HalfKey::from_bits(value.to_bits());
        let luminance = |key: u16| HalfKey(key).to_half().to_f64() * white_cd_m2;
        // Keys of finite values ascend with the value.
        let finite = key(f16::MIN).0..=key(f16::MAX).0;
        let first = finite.clone().find(|&key| luminance(key) >= PU21_MIN_CD_M2).unwrap_or(u16::MAX);
        let last = finite.rev().find(|&key| luminance(key) <= PU21_MAX_CD_M2).unwrap_or(0);
        let range = [first, last].map(HalfKey);
        Ok(Pu21 { steps, range })
    }

    pub fn check_white(white_cd_m2: f64) -> Result<()> {
        if white_cd_m2.is_finite() && white_cd_m2 > 0.0 {
            Ok(())
        } else {
            Err(Error::invalid(format!("a white of {white_cd_m2} cd/m² is not positive and finite")))
        }
    }

    fn step(&self, key: HalfKey) -> i32 {
        self.steps[usize::from(key.0)]
    }

    /// Returns the PU21 encoding of a sample in steps of 1/64, the unit of all errors of this metric.
    pub fn steps(&self, value: f16) -> i32 {
        self.step(HalfKey::from_bits(value.to_bits()))
    }

    /// Returns the error of a sample in steps, and the same error if either value is outside the range of PU21, else 0.
    #[inline(always)]
    fn errors(&self, shown: HalfKey, source: HalfKey) -> [u32; 2] {
        let [a, b] = [shown, source].map(|key| self.step(key));
        // Dark half floats share codes; different bits still count as an error.
        let error = a.abs_diff(b).max(u32::from(shown != source));
        let [first, last] = self.range;
        [error, if shown.min(source) < first || shown.max(source) > last { error } else { 0 }]
    }

    /// Returns Σ of squared errors, and the maximum error of samples of which either value is outside the range of PU21, in
    /// steps.
    pub fn between(&self, a: &[f16], b: &[f16]) -> (u64, u32) {
        let key = |value: &f16| HalfKey::from_bits(value.to_bits());
        let errors = a.iter().zip(b).map(|(a, b)| self.errors(key(a), key(b)));
        errors.fold((0, 0), |(sum, largest), [error, outside]| (sum + u64::from(error).pow(2), largest.max(outside)))
    }
}

/// Sum of squared errors of `samples` samples that is as bad as this error of one sample outside the range.
fn as_sum(outside: u32, samples: usize) -> u64 {
    let squared = u64::from(outside).pow(2);
    let sum = (u128::from(squared) * samples as u128).div_ceil(u128::from(MAX_OUTSIDE_RMS.pow(2)));
    u64::try_from(sum).unwrap_or(u64::MAX)
}

impl Quality<HalfKey> for Pu21 {
    const KEYS_ARE_STEPS: bool = false;

    #[inline(always)]
    fn code(&self, sample: HalfKey) -> f32 {
        self.step(sample) as f32 / PU_STEPS as f32
    }

    #[inline]
    fn codes_a_key(&self, sample: HalfKey) -> f32 {
        let [below, above] = [sample.0.saturating_sub(8), sample.0.saturating_add(8)].map(HalfKey);
        (self.code(above) - self.code(below)).abs()
    }

    fn largest_outside(&self, shown: &[HalfKey], source: &[HalfKey]) -> f32 {
        let largest = shown.iter().zip(source).map(|(&shown, &source)| self.errors(shown, source)[1]).max();
        largest.unwrap_or(0) as f32 / PU_STEPS as f32
    }

    fn peak(&self) -> f64 {
        PU21_PEAK * PU_STEPS
    }

    fn squared_error(&self, a: &[HalfKey], b: &[HalfKey], weight: u8, source: &[HalfKey], limit: u64) -> u64 {
        let (mut total, mut largest) = (0, 0);
        for ((a, b), source_block) in a.chunks(BLOCK).zip(b.chunks(BLOCK)).zip(source.chunks(BLOCK)) {
            for ((&a, &b), &source) in a.iter().zip(b).zip(source_block) {
                let [error, outside] = self.errors(HalfKey::lerp(a, b, weight), source);
                total += u64::from(error) * u64::from(error);
                largest = largest.max(outside);
            }
            if total.max(as_sum(largest, source.len())) > limit {
                break;
            }
        }
        total.max(as_sum(largest, source.len()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn squared_errors_are_those_of_the_decoded_samples() {
        let a: Vec<u8> = (0..6000).map(|i| (i * 7 % 256) as u8).collect();
        let b: Vec<u8> = (0..6000).map(|i| (i * 13 % 251) as u8).collect();
        let source: Vec<u8> = (0..6000).map(|i| (i % 256) as u8).collect();
        for weight in [0, 1, 100, 255] {
            let plain: u64 =
                (0..6000).map(|i| u64::from(u8::lerp(a[i], b[i], weight).abs_diff(source[i])).pow(2)).sum();
            assert_eq!(EightBit.squared_error(&a, &b, weight, &source, u64::MAX), plain);
            assert!(EightBit.squared_error(&a, &b, weight, &source, 5) > 5);
        }
    }

    fn key(value: f32) -> HalfKey {
        HalfKey::from_bits(f16::from_f32(value).to_bits())
    }

    #[test]
    fn visible_steps_count_more_than_dark_ones() {
        let metric = Pu21::new(100.0).unwrap();
        let error = |a: f32, b: f32| metric.squared_error(&[key(a)], &[key(a)], 0, &[key(b)], u64::MAX);
        assert_eq!(error(0.5, 0.5), 0);
        assert!(error(0.5, 0.6) > error(10.0, 10.1));
        assert!(error(100.0, 90.0) > 0);
    }

    #[test]
    fn every_other_half_is_an_error() {
        let metric = Pu21::new(100.0).unwrap();
        for bits in 0..=u16::MAX {
            let [one, next] = [bits, bits.wrapping_add(1)].map(HalfKey::from_bits);
            assert_eq!(metric.squared_error(&[one], &[one], 0, &[one], u64::MAX), 0);
            assert!(metric.squared_error(&[one], &[one], 0, &[next], u64::MAX) > 0, "{bits:#06x}");
        }
        assert_eq!(metric.max_squared_error(200.0, 3 << 28), 0);
    }

    #[test]
    fn samples_outside_the_range_have_a_bound_of_their_own() {
        let metric = Pu21::new(100.0).unwrap();
        let count = 3 * 64 * 64;
        for db in [20.0, 40.0, 60.0] {
            let limit = metric.max_squared_error(db, count);
            let most = MAX_OUTSIDE_RMS as f64 * metric.peak() * 10f64.powf(-db / 20.0);
            // One sample (a lamp) that differs among many exact ones, with many pairs of values.
            let kept = |lamp: f32, shown: f32| {
                let mut pictures = [vec![key(0.5); count], vec![key(0.5); count]];
                (pictures[0][7], pictures[1][7]) = (key(lamp), key(shown));
                let [source, shown] = pictures;
                metric.squared_error(&shown, &shown, 0, &source, u64::MAX) <= limit
            };
            for lamp in [-60_000.0, -1.24, -0.0011, 0.0, 1e-7, 4e-5, 101.0, 121.0, 60_000.0] {
                for shown in [-65_504.0, -5.0, -0.0011, -1e-6, 0.0, 3e-5, 0.001, 0.1, 99.0, 140.0, 63_072.0] {
                    let error = metric.step(key(lamp)).abs_diff(metric.step(key(shown)));
                    assert_eq!(kept(lamp, shown), f64::from(error) <= most, "{lamp} as {shown} at {db} dB");
                    assert_eq!(kept(shown, lamp), kept(lamp, shown));
                }
            }
        }
    }
}
