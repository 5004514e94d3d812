//! Peak signal-to-noise ratio, from sums of squared differences that merge without loss.
//!
//! Enters: two slices of samples of equal length. Leaves: [`SquaredError`], and from it decibels.
//! Integer samples are summed exactly (u128), so a sum does not depend on how an image was cut into tiles; float
//! samples are summed in f64 in a fixed pairwise order.

use std::ops::Add;

use crate::error::{Error, Result};

/// Largest value of an 8-bit sample, the peak of its PSNR.
pub const U8_PEAK: f64 = 255.0;
/// Largest value of a 16-bit sample, the peak of its PSNR.
pub const U16_PEAK: f64 = 65_535.0;

/// 8-bit squares summed in i32 before they are widened: 32,768 · 255² is below 2³¹.
const U8_RUN: usize = 1 << 15;
/// 16-bit squares summed in u64 before they are widened: 2²⁰ · 65,535² is far below 2⁶⁴.
const U16_RUN: usize = 1 << 20;
/// Float squares summed in one pass by [`LANES`] running sums; longer inputs are halved.
const REAL_RUN: usize = 1 << 10;
/// Running sums of a pass over floats. Fixed, because it is part of the order of summation.
const LANES: usize = 8;

/// A sum of squared differences: `u128` for integer samples, where it is exact, `f64` for float samples.
pub trait ErrorSum: Copy + Default + Add<Output = Self> {
    /// The sum as a float, rounded to nearest.
    fn to_f64(self) -> f64;
}

impl ErrorSum for u128 {
    fn to_f64(self) -> f64 {
        self as f64
    }
}

impl ErrorSum for f64 {
    fn to_f64(self) -> f64 {
        self
    }
}

/// Sum of squared differences of a number of samples, and the peak that its PSNR refers to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SquaredError<S> {
    /// Σ (a − b)², in squared sample units.
    pub sum: S,
    /// Samples compared (an RGB pixel is three).
    pub samples: u64,
    /// The peak signal in sample units: 255, 65,535, or what a float metric defines.
    pub peak: f64,
}

/// Squared error of integer samples, exact.
pub type CodeError = SquaredError<u128>;
/// Squared error of float samples.
pub type RealError = SquaredError<f64>;

impl<S: ErrorSum> SquaredError<S> {
    /// Nothing compared yet.
    pub fn empty(peak: f64) -> Self {
        SquaredError { sum: S::default(), samples: 0, peak }
    }

    /// Adds what another accumulator of the same peak has seen.
    ///
    /// Integer sums may be merged in any order; float sums must be merged in a fixed one (frame by frame, face by
    /// face) for the last bits to be the same on every run.
    ///
    /// # Errors
    /// If the peaks differ: decibels of different signals do not add.
    pub fn merge(&mut self, other: &Self) -> Result<()> {
        if self.peak != other.peak {
            return Err(Error::invalid(format!(
                "squared errors of peak {} and {} cannot be merged",
                self.peak, other.peak
            )));
        }
        self.sum = self.sum + other.sum;
        self.samples += other.samples;
        Ok(())
    }

    /// Mean squared error; 0 when nothing was compared.
    pub fn mse(&self) -> f64 {
        if self.samples == 0 { 0.0 } else { self.sum.to_f64() / self.samples as f64 }
    }

    /// 10·log₁₀(peak² / mse), in dB.
    ///
    /// `+inf` when the samples are equal or none was compared, `−inf` for an infinite sum, NaN for a NaN sum.
    pub fn psnr_db(&self) -> f64 {
        psnr_of_sum(self.sum.to_f64(), self.samples, self.peak)
    }
}

impl CodeError {
    /// Squared error of 8-bit samples.
    ///
    /// # Errors
    /// If the lengths differ.
    pub fn of_u8(a: &[u8], b: &[u8]) -> Result<CodeError> {
        check_lengths(a.len(), b.len())?;
        let runs = a.chunks(U8_RUN).zip(b.chunks(U8_RUN));
        let sum = runs.map(|(a, b)| u128::from(sum_u8(a, b))).sum();
        Ok(SquaredError { sum, samples: a.len() as u64, peak: U8_PEAK })
    }

    /// Squared error of 16-bit codes.
    ///
    /// # Errors
    /// If the lengths differ.
    pub fn of_u16(a: &[u16], b: &[u16]) -> Result<CodeError> {
        check_lengths(a.len(), b.len())?;
        let runs = a.chunks(U16_RUN).zip(b.chunks(U16_RUN));
        let sum = runs.map(|(a, b)| u128::from(sum_u16(a, b))).sum();
        Ok(SquaredError { sum, samples: a.len() as u64, peak: U16_PEAK })
    }
}

impl RealError {
    /// Squared error of float samples against `peak`, in the samples' own unit.
    ///
    /// Two equal samples count 0, also when both are the same infinity or the same NaN. Infinity against anything
    /// else makes the sum `+inf`; a NaN against anything else makes it NaN, so that it cannot hide.
    ///
    /// # Errors
    /// If the lengths differ.
    pub fn of_f32(a: &[f32], b: &[f32], peak: f64) -> Result<RealError> {
        check_lengths(a.len(), b.len())?;
        let sum = sum_squares(a.len(), &|i| {
            let (a, b) = (a[i], b[i]);
            if a == b || a.to_bits() == b.to_bits() { 0.0 } else { f64::from(a) - f64::from(b) }
        });
        Ok(SquaredError { sum, samples: a.len() as u64, peak })
    }
}

/// The largest integer sum of squared differences whose PSNR, exactly as [`SquaredError::psnr_db`] computes it, is
/// still at least `db`: `sse <= psnr_to_max_sse(db, samples, peak)` implies `psnr_db() >= db`.
///
/// Up to 2³⁸ the answer is also the largest such sum. Beyond, neighbouring sums are closer than the logarithm
/// resolves and the answer is rounded down by a relative 1e-12. NaN and `+inf` give 0 (only equality satisfies
/// them), `−inf` gives `u64::MAX`.
pub fn psnr_to_max_sse(db: f64, samples: u64, peak: f64) -> u64 {
    /// Below this bound one step of the sum moves the decibels by more than 1e-11, thousands of times the error of
    /// `log10`, so that the search below meets a monotone function on every platform.
    const EXACT_BELOW: f64 = (1_u64 << 38) as f64;

    if samples == 0 || db == f64::NEG_INFINITY {
        return u64::MAX;
    }
    let estimate = peak * peak * samples as f64 * 10_f64.powf(-db / 10.0);
    // NaN, an overflowing db, or a target so high that not even an error of 1 fits.
    if estimate.is_nan() || estimate < 0.5 {
        return 0;
    }
    if estimate >= EXACT_BELOW {
        // The margin of 4e-12 dB covers the rounding of powf here and of log10 there; the cast saturates.
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

/// The one place where a sum becomes decibels.
fn psnr_of_sum(sum: f64, samples: u64, peak: f64) -> f64 {
    if samples == 0 || sum == 0.0 {
        return f64::INFINITY;
    }
    10.0 * (peak * peak / (sum / samples as f64)).log10()
}

/// Refuses slices of different lengths.
pub(super) fn check_lengths(a: usize, b: usize) -> Result<()> {
    if a == b {
        Ok(())
    } else {
        Err(Error::invalid(format!("two images of different size were compared: {a} and {b} samples")))
    }
}

/// Σ difference(i)² over `0..len` in f64: runs of [`REAL_RUN`] in [`LANES`] interleaved sums, joined pairwise.
pub(super) fn sum_squares(len: usize, difference: &impl Fn(usize) -> f64) -> f64 {
    pairwise(0, len, difference)
}

fn pairwise(start: usize, end: usize, difference: &impl Fn(usize) -> f64) -> f64 {
    let len = end - start;
    if len <= REAL_RUN {
        let mut lanes = [0.0_f64; LANES];
        for (k, i) in (start..end).enumerate() {
            let d = difference(i);
            lanes[k % LANES] += d * d;
        }
        let [a, b, c, d, e, f, g, h] = lanes;
        return ((a + e) + (c + g)) + ((b + f) + (d + h));
    }
    // Cutting at a multiple of the run keeps the order a function of the length alone.
    let middle = start + len.div_ceil(2).next_multiple_of(REAL_RUN).min(len);
    pairwise(start, middle, difference) + pairwise(middle, end, difference)
}

/// At most [`U8_RUN`] samples. Differences in i16 and sums in i32, because processors have one instruction for that.
fn sum_u8(a: &[u8], b: &[u8]) -> u32 {
    let squares = a.iter().zip(b).map(|(&a, &b)| {
        let d = i16::from(a) - i16::from(b);
        i32::from(d) * i32::from(d)
    });
    squares.sum::<i32>().unsigned_abs()
}

/// At most [`U16_RUN`] samples.
fn sum_u16(a: &[u16], b: &[u16]) -> u64 {
    a.iter()
        .zip(b)
        .map(|(&a, &b)| {
            let d = u32::from(a.abs_diff(b));
            u64::from(d * d)
        })
        .sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn u8_matches_hand_computation() {
        // Differences 1, 2, 3, 255: sum 1 + 4 + 9 + 65025.
        let error = CodeError::of_u8(&[10, 20, 30, 0], &[11, 18, 33, 255]).unwrap();
        assert_eq!((error.sum, error.samples), (65_039, 4));
        let expected = 10.0 * (255.0 * 255.0 * 4.0 / 65_039.0_f64).log10();
        assert!((error.psnr_db() - expected).abs() < 1e-12);
        // An error of exactly one code everywhere: 20 log10(255).
        let one = CodeError::of_u8(&[0; 100], &[1; 100]).unwrap();
        assert!((one.psnr_db() - 48.130_803_608_679_1).abs() < 1e-9, "{}", one.psnr_db());
    }

    #[test]
    fn extremes_do_not_overflow() {
        let n = U8_RUN * 2 + 7;
        let error = CodeError::of_u8(&vec![0; n], &vec![255; n]).unwrap();
        assert_eq!(error.sum, n as u128 * 65_025);
        assert_eq!(error.psnr_db(), 0.0);
        let n = U16_RUN * 2 + 3;
        let mut error = CodeError::of_u16(&vec![0; n], &vec![65_535; n]).unwrap();
        assert_eq!(error.sum, n as u128 * 65_535 * 65_535);
        assert_eq!(error.psnr_db(), 0.0);
        error.sum = u128::from(u64::MAX);
        error.merge(&error.clone()).unwrap();
        assert_eq!(error.sum, 2 * u128::from(u64::MAX));
    }

    #[test]
    fn equal_or_empty_is_infinite() {
        assert_eq!(CodeError::of_u8(&[1, 2, 3], &[1, 2, 3]).unwrap().psnr_db(), f64::INFINITY);
        assert_eq!(CodeError::of_u16(&[], &[]).unwrap().psnr_db(), f64::INFINITY);
        assert_eq!(CodeError::empty(255.0).mse(), 0.0);
        assert!(CodeError::of_u8(&[1], &[]).is_err());
        assert!(CodeError::empty(255.0).merge(&CodeError::empty(65_535.0)).is_err());
    }

    #[test]
    fn tiles_merge_to_the_whole() {
        let a: Vec<u16> = (0..10_000_u32).map(|i| (i * 7919 % 65_536) as u16).collect();
        let b: Vec<u16> = (0..10_000_u32).map(|i| (i * 104_729 % 65_536) as u16).collect();
        let whole = CodeError::of_u16(&a, &b).unwrap();
        let mut parts = CodeError::empty(U16_PEAK);
        for (a, b) in a.chunks(613).zip(b.chunks(613)).rev() {
            parts.merge(&CodeError::of_u16(a, b).unwrap()).unwrap();
        }
        assert_eq!(parts, whole);
    }

    #[test]
    fn floats_keep_small_errors_and_show_bad_ones() {
        // In f32, or added one by one to a large sum, the millionth part would be lost.
        let n = 1_000_003;
        let a = vec![1000.0_f32; n];
        let mut b = vec![1000.0_f32 + 0.000_061_035_156; n];
        b[0] = 2000.0;
        let error = RealError::of_f32(&a, &b, 1.0).unwrap();
        let d = f64::from(b[1]) - 1000.0;
        let expected = 1e6 + (n - 1) as f64 * d * d;
        assert!((error.sum - expected).abs() <= expected * 1e-15, "{} {expected}", error.sum);

        let inf = f32::INFINITY;
        assert_eq!(RealError::of_f32(&[inf, f32::NAN, 1.0], &[inf, f32::NAN, 1.0], 1.0).unwrap().sum, 0.0);
        assert_eq!(RealError::of_f32(&[inf], &[1.0], 1.0).unwrap().psnr_db(), f64::NEG_INFINITY);
        assert!(RealError::of_f32(&[f32::NAN, 0.0], &[1.0, 0.0], 1.0).unwrap().psnr_db().is_nan());
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
            // The decibels of a sum lead back to that very sum.
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
