//! How far a decoded cell is from its source, as an exact integer (color.md 5).
//!
//! 8-bit colour: the squared error of the samples, peak 255. Half floats: the squared error of their PU21 encoding in
//! 64ths, peak 256 (CALF 5.1 asks for another metric for HDR and names none; PU21 counts what is visible, from
//! candle light to daylight, where a PSNR of linear values would see only the highlights).

use half::f16;

use crate::color::blend::{HalfKey, Sample};
use crate::error::{Error, Result};
use crate::metrics::psnr::{U8_PEAK, psnr_to_max_sse};
use crate::metrics::pu21::{PU21_PEAK, PuTable};

pub const PU_STEPS: f64 = 64.0;
/// Samples whose squared errors are summed in 32 bits before they are carried over.
const BLOCK: usize = 2048;

pub trait Quality<S: Sample>: Sync {
    fn peak(&self) -> f64;

    /// Σ (shown − source)² of what the decoder shows for `weight` between `a` and `b`. May stop early, with any value
    /// above `limit`, once the sum has passed it.
    fn squared_error(&self, a: &[S], b: &[S], weight: u8, source: &[S], limit: u64) -> u64;

    fn max_squared_error(&self, db: f64, samples: usize) -> u64 {
        psnr_to_max_sse(db, samples as u64, self.peak())
    }

    /// Whether one step of a sample's key is one step of the metric, so that sums over keys bound it.
    const KEYS_ARE_STEPS: bool;
}

#[derive(Debug, Clone, Copy, Default)]
pub struct EightBit;

impl Quality<u8> for EightBit {
    const KEYS_ARE_STEPS: bool = true;

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
    /// PU21 in 64ths for every key.
    steps: Vec<u16>,
}

impl Pu21 {
    /// The metric for footage whose value 1.0 is shown at `white_cd_m2`.
    pub fn new(white_cd_m2: f64) -> Result<Pu21> {
        Self::check_white(white_cd_m2)?;
        let table = PuTable::new(white_cd_m2)?;
        let step = |key| (f64::from(table.encode(HalfKey(key).to_half())) * PU_STEPS).round() as u16;
        Ok(Pu21 { steps: (0..=u16::MAX).map(step).collect() })
    }

    pub fn check_white(white_cd_m2: f64) -> Result<()> {
        if white_cd_m2.is_finite() && white_cd_m2 > 0.0 {
            Ok(())
        } else {
            Err(Error::invalid(format!("a white of {white_cd_m2} cd/m² is not positive and finite")))
        }
    }

    fn step(&self, key: HalfKey) -> i32 {
        i32::from(self.steps[usize::from(key.0)])
    }

    /// The PU21 encoding of a sample in steps of 1/64, as all errors of this metric are counted.
    pub fn steps(&self, value: f16) -> u16 {
        self.steps[usize::from(HalfKey::from_bits(value.to_bits()).0)]
    }

    pub fn between(&self, a: &[f16], b: &[f16]) -> u64 {
        let step = |value: &f16| i32::from(self.steps(*value));
        a.iter().zip(b).map(|(a, b)| u64::from(step(a).abs_diff(step(b))).pow(2)).sum()
    }
}

impl Quality<HalfKey> for Pu21 {
    const KEYS_ARE_STEPS: bool = false;

    fn peak(&self) -> f64 {
        PU21_PEAK * PU_STEPS
    }

    fn squared_error(&self, a: &[HalfKey], b: &[HalfKey], weight: u8, source: &[HalfKey], limit: u64) -> u64 {
        let mut total = 0;
        for ((a, b), source) in a.chunks(BLOCK).zip(b.chunks(BLOCK)).zip(source.chunks(BLOCK)) {
            for ((&a, &b), &source) in a.iter().zip(b).zip(source) {
                let error = self.step(HalfKey::lerp(a, b, weight)).abs_diff(self.step(source));
                total += u64::from(error) * u64::from(error);
            }
            if total > limit {
                break;
            }
        }
        total
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

    #[test]
    fn a_visible_step_counts_more_than_one_in_the_dark() {
        let metric = Pu21::new(100.0).unwrap();
        let key = |value: f32| HalfKey::from_bits(f16::from_f32(value).to_bits());
        let error = |a: f32, b: f32| metric.squared_error(&[key(a)], &[key(a)], 0, &[key(b)], u64::MAX);
        assert_eq!(error(0.5, 0.5), 0);
        assert_eq!(error(-1.0, 0.0), 0);
        assert!(error(0.5, 0.6) > error(10.0, 10.1));
        assert!(error(100.0, 90.0) > 0);
    }
}
