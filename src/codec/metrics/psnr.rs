//! Peak signal-to-noise ratio, from exact sums of squared differences.
//!
//! Takes two slices of integer samples of equal length and returns [`SquaredError`], which gives decibels. Sums are integers, so
//! merged results do not depend on how an image is divided into tiles.

use crate::error::{Error, Result};

pub const U8_PEAK: f64 = 255.0;
pub const U16_PEAK: f64 = 65_535.0;

/// Depth code of the background.
pub const BACKGROUND_CODE: u16 = u16::MAX;

/// Number of 8-bit squares summed in i32 before they are widened: 32,768 · 255² is below 2³¹.
const U8_RUN: usize = 1 << 15;

/// Sum of squared differences, number of samples, and peak of the PSNR.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SquaredError {
    /// Σ (a − b)², in squared sample units.
    pub sum: u128,
    /// Number of samples compared; an RGB pixel has three.
    pub samples: u64,
    /// Peak signal in sample units, such as 255 or 65,535.
    pub peak: f64,
}

impl SquaredError {
    pub fn empty(peak: f64) -> Self {
        SquaredError { sum: 0, samples: 0, peak }
    }

    pub fn merge(&mut self, other: &Self) -> Result<()> {
        if self.peak != other.peak {
            let message = format!("squared errors of peak {} and {} cannot be merged", self.peak, other.peak);
            return Err(Error::invalid(message));
        }
        self.sum += other.sum;
        self.samples += other.samples;
        Ok(())
    }

    /// Returns the mean of the squares; 0 without samples.
    pub fn mse(&self) -> f64 {
        self.sum as f64 / self.samples.max(1) as f64
    }

    /// Returns 10·log₁₀(peak² / mse) in dB; `+inf` if all samples are equal or none were compared.
    pub fn psnr_db(&self) -> f64 {
        psnr_of_sum(self.sum as f64, self.samples, self.peak)
    }

    pub fn of_u8(a: &[u8], b: &[u8]) -> Result<SquaredError> {
        if a.len() != b.len() {
            let message = format!("two images of different size were compared: {} and {} samples", a.len(), b.len());
            return Err(Error::invalid(message));
        }
        let runs = a.chunks(U8_RUN).zip(b.chunks(U8_RUN));
        let sum = runs.map(|(a, b)| u128::from(sum_u8(a, b))).sum();
        Ok(SquaredError { sum, samples: a.len() as u64, peak: U8_PEAK })
    }
}

/// Returns the largest integer sum of squared differences whose PSNR, exactly as [`SquaredError::psnr_db`] computes it, is at
/// least `db`: `sse <= psnr_to_max_sse(db, samples, peak)` implies `psnr_db() >= db`.
///
/// Up to 2³⁸ the result is exactly the largest such sum. Beyond that, neighbouring sums are closer than the logarithm resolves,
/// and the result is rounded down by a relative 1e-12. NaN and `+inf` give 0 (only equal samples reach them), `−inf` and 0
/// samples give `u64::MAX`.
pub fn psnr_to_max_sse(db: f64, samples: u64, peak: f64) -> u64 {
    /// Below this bound one step of the sum changes the PSNR by more than 1e-11 dB, thousands of times the error of `log10`, so
    /// the function searched below is monotone on every platform.
    const EXACT_BELOW: f64 = (1_u64 << 38) as f64;

    if samples == 0 || db == f64::NEG_INFINITY {
        return u64::MAX;
    }
    let estimate = peak * peak * samples as f64 * libm::pow(10.0, -db / 10.0);
    // NaN, an overflowing `db`, or a target so high that even an error of 1 misses it.
    if estimate.is_nan() || estimate < 0.5 {
        return 0;
    }
    if estimate >= EXACT_BELOW {
        // The margin of 4e-12 dB covers the rounding of `pow` in the estimate and of `log10` in the PSNR; the cast saturates.
        return (estimate * (1.0 - 1e-12)) as u64;
    }
    let reaches = |sse: u64| psnr_of_sum(sse as f64, samples, peak) >= db;
    let mut sse = estimate as u64;
    while sse > 0 && !reaches(sse) {
        sse -= 1;
    }
    while reaches(sse + 1) {
        sse += 1;
    }
    sse
}

/// Converts a sum of squares to dB; all PSNRs use this function.
fn psnr_of_sum(sum: f64, samples: u64, peak: f64) -> f64 {
    if samples == 0 || sum == 0.0 {
        return f64::INFINITY;
    }
    // libm gives the same bits on every machine, which the decisions of encoders need.
    10.0 * libm::log10(peak * peak / (sum / samples as f64))
}

/// Returns the sum of squared differences of at most [`U8_RUN`] samples. Differences in i16 and sums in i32 compile to one SIMD
/// instruction.
fn sum_u8(a: &[u8], b: &[u8]) -> u32 {
    let squares = a.iter().zip(b).map(|(&a, &b)| {
        let d = i16::from(a) - i16::from(b);
        i32::from(d) * i32::from(d)
    });
    squares.sum::<i32>().unsigned_abs()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn u8_matches_hand_computation() {
        // Differences 1, 2, 3, 255: sum 1 + 4 + 9 + 65025.
        let error = SquaredError::of_u8(&[10, 20, 30, 0], &[11, 18, 33, 255]).unwrap();
        assert_eq!((error.sum, error.samples), (65_039, 4));
        let expected = 10.0 * (255.0 * 255.0 * 4.0 / 65_039.0_f64).log10();
        assert!((error.psnr_db() - expected).abs() < 1e-12);
        // An error of exactly one code in each sample: 20 log10(255).
        let one = SquaredError::of_u8(&[0; 100], &[1; 100]).unwrap();
        assert!((one.psnr_db() - 48.130_803_608_679_1).abs() < 1e-9, "{}", one.psnr_db());
    }

    #[test]
    fn decibels_have_the_same_bits_on_every_machine() {
        let bits = |sum: u128, samples, peak| SquaredError { sum, samples, peak }.psnr_db().to_bits();
        let found =
            [bits(1, 3, U8_PEAK), bits(65_039, 4, U8_PEAK), bits(7, 12_288, 16_384.0), bits(1 << 40, 9, U16_PEAK)];
        assert_eq!(
            found.map(|bits| format!("{bits:016x}")),
            ["404a737543f0f996", "401814230dcd12f0", "405d2edcdcf2dd06", "c02d1488ead26814"]
        );
    }

    #[test]
    fn extremes_do_not_overflow() {
        let n = U8_RUN * 2 + 7;
        let error = SquaredError::of_u8(&vec![0; n], &vec![255; n]).unwrap();
        assert_eq!(error.sum, n as u128 * 65_025);
        assert_eq!(error.psnr_db(), 0.0);
        let mut error = SquaredError { sum: u128::from(u64::MAX), ..error };
        error.merge(&error.clone()).unwrap();
        assert_eq!(error.sum, 2 * u128::from(u64::MAX));
    }

    #[test]
    fn equal_or_empty_is_infinite() {
        assert_eq!(SquaredError::of_u8(&[1, 2, 3], &[1, 2, 3]).unwrap().psnr_db(), f64::INFINITY);
        assert_eq!(SquaredError::empty(255.0).psnr_db(), f64::INFINITY);
        assert!(SquaredError::of_u8(&[1], &[]).is_err());
        assert!(SquaredError::empty(255.0).merge(&SquaredError::empty(65_535.0)).is_err());
    }

    #[test]
    fn tiles_merge_to_the_whole() {
        let a: Vec<u8> = (0..20_000_u32).map(|i| (i * 7919 % 256) as u8).collect();
        let b: Vec<u8> = (0..20_000_u32).map(|i| (i * 104_729 % 255) as u8).collect();
        let whole = SquaredError::of_u8(&a, &b).unwrap();
        let mut parts = SquaredError::empty(U8_PEAK);
        for (a, b) in a.chunks(613).zip(b.chunks(613)).rev() {
            parts.merge(&SquaredError::of_u8(a, b).unwrap()).unwrap();
        }
        assert_eq!(parts, whole);
    }

    #[test]
    fn inverse_is_the_boundary() {
        let cases = [(255.0, 48_u64), (255.0, 3 * 64 * 64), (65_535.0, 256), (256.0, 1)];
        for (peak, samples) in cases {
            let psnr = |sum: u64| SquaredError { sum: u128::from(sum), samples, peak }.psnr_db();
            for db in (0..1300).map(|i| f64::from(i) * 0.1) {
                let max = psnr_to_max_sse(db, samples, peak);
                assert!(psnr(max) >= db, "{db} dB, {samples} samples: {max}");
                if max < 1 << 38 {
                    assert!(psnr(max + 1) < db, "{db} dB, {samples} samples: {max} is not the largest");
                }
            }
            // The PSNR of a sum maps back to that sum.
            for sum in (0..40).chain([1000, 4095, 65_537, 1_000_003]) {
                assert_eq!(psnr_to_max_sse(psnr(sum), samples, peak), sum);
            }
        }
    }

    #[test]
    fn inverse_is_safe_for_huge_sums_and_odd_targets() {
        let (samples, peak) = (1_u64 << 33, 65_535.0);
        for db in [-3.0, 1.0, 17.3, 33.333, 60.0] {
            let max = psnr_to_max_sse(db, samples, peak);
            for sse in [max, max - 1, max / 2] {
                assert!(SquaredError { sum: u128::from(sse), samples, peak }.psnr_db() >= db);
            }
        }
        assert_eq!(psnr_to_max_sse(f64::INFINITY, 48, 255.0), 0);
        assert_eq!(psnr_to_max_sse(f64::NAN, 48, 255.0), 0);
        assert_eq!(psnr_to_max_sse(f64::NEG_INFINITY, 48, 255.0), u64::MAX);
        assert_eq!(psnr_to_max_sse(-5000.0, 48, 255.0), u64::MAX);
        assert_eq!(psnr_to_max_sse(50.0, 0, 255.0), u64::MAX);
    }
}
