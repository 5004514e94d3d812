//! Errors of colour, material and alpha between two images, counted per pixel.

use half::f16;
use serde::Serialize;

use crate::compare::side::Values;
use crate::metrics::depth_error::{Spot, finite_or_nan};
use crate::metrics::{EyeScores, HvsError};
use codec::color::quality::Pu21;
use codec::error::{Error, Result};
use codec::image::{ColorPlane, Plane};
use codec::metrics::visible::{quality_of, visible_error};
use codec::metrics::{SquaredError, U8_PEAK};

pub trait Level: Copy + PartialEq {
    fn steps(self) -> i32;
}

impl Level for u8 {
    fn steps(self) -> i32 {
        i32::from(self)
    }
}

/// Codes that extend beyond 8 bits.
impl Level for i32 {
    fn steps(self) -> i32 {
        self
    }
}

/// A half float and its PU21 code in 64ths. Halves with equal codes may differ in bits, which counts as an error of one step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct HalfLevel {
    bits: u16,
    steps: i32,
}

impl Level for HalfLevel {
    fn steps(self) -> i32 {
        self.steps
    }
}

pub fn half_levels(plane: &ColorPlane, metric: &Pu21) -> Plane<[HalfLevel; 3]> {
    let level = |value: f16| HalfLevel { bits: value.to_bits(), steps: metric.steps(value) };
    plane.map(|pixel| pixel.map(level))
}

/// The minimum PSNR or quality over frames, or over cells in single frames.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lowest {
    /// PSNR in dB, +inf if all samples are equal; or quality.
    pub value: f64,
    /// Frame, and upper left corner of the cell.
    pub spot: Spot,
}

#[derive(Debug, Clone, PartialEq)]
pub struct SampleErrors {
    /// Maximum error of a sample in steps of the metric: 8-bit codes, or 64ths of PU21.
    pub max_error: u32,
    pub error: SquaredError,
    /// The first pixel with the maximum error; `None` if all are equal.
    pub worst: Option<Spot>,
    pub differing_pixels: u64,
    pub lowest_frame: Option<Lowest>,
    /// Minimum PSNR of a cell in one frame.
    pub lowest_cell: Option<Lowest>,
    /// Minimum quality of a cell in one frame; colour only.
    pub lowest_quality: Option<Lowest>,
    pub ssim_sum: f64,
    pub ssim_frames: u64,
    /// PSNR-HVS-M of the same frames.
    pub hvs: HvsError,
    /// SSIMULACRA2 and butteraugli of the same frames in 8-bit sRGB; empty unless requested.
    pub eye: EyeScores,
    /// Number of pixels that 8 bits clip, summed over both sides.
    pub clipped_pixels: u64,
    /// True if values differ. Bits are compared for colour of two files, and for all kinds with
    /// [`crate::compare::Measure::Bits`].
    pub has_other_bits: bool,
}

impl SampleErrors {
    pub fn ssim(&self) -> Option<f64> {
        (self.ssim_frames > 0).then(|| self.ssim_sum / self.ssim_frames as f64)
    }

    /// Returns the PSNR in dB; `+inf` if all are equal, NaN if codes are equal but bits differ.
    pub fn psnr_db(&self) -> f64 {
        finite_or_nan(self.error.psnr_db(), self.has_other_bits)
    }

    /// Returns the minimum PSNR of a frame, and the minimum PSNR and quality of a cell in one frame, with NaN as in
    /// [`Self::psnr_db`].
    pub fn lowest(&self) -> [Option<Lowest>; 3] {
        let known = |lowest: Lowest| Lowest { value: finite_or_nan(lowest.value, self.has_other_bits), ..lowest };
        [self.lowest_frame, self.lowest_cell, self.lowest_quality].map(|lowest| lowest.map(known))
    }

    pub fn empty(peak: f64) -> SampleErrors {
        SampleErrors {
            max_error: 0,
            error: SquaredError::empty(peak),
            worst: None,
            differing_pixels: 0,
            lowest_frame: None,
            lowest_cell: None,
            lowest_quality: None,
            ssim_sum: 0.0,
            ssim_frames: 0,
            hvs: HvsError::default(),
            eye: EyeScores::default(),
            clipped_pixels: 0,
            has_other_bits: false,
        }
    }

    /// Adds a frame, measured in cells of `cell`×`cell` pixels.
    pub fn add<T: Level>(&mut self, frame: u32, a: &Plane<[T; 3]>, b: &Plane<[T; 3]>, cell: u32) {
        let peak = self.error.peak;
        let samples = |pixels: u64| SquaredError { samples: 3 * pixels, ..SquaredError::empty(peak) };
        let mut total = samples(a.data().len() as u64);
        for [left, top, width, height] in cells(a, cell) {
            let columns = left as usize..(left + width) as usize;
            let mut of_cell = samples(u64::from(width) * u64::from(height));
            for y in top..top + height {
                let (row_a, row_b) = (&a.row(y)[columns.clone()], &b.row(y)[columns.clone()]);
                if row_a != row_b {
                    of_cell.sum += self.add_run(Spot { frame, x: left, y }, row_a, row_b);
                }
            }
            total.sum += of_cell.sum;
            let spot = Spot { frame, x: left, y: top };
            keep_lowest(&mut self.lowest_cell, Lowest { value: of_cell.psnr_db(), spot });
        }
        keep_lowest(&mut self.lowest_frame, Lowest { value: total.psnr_db(), spot: Spot { frame, x: 0, y: 0 } });
        self.error.sum += total.sum;
        self.error.samples += total.samples;
    }

    /// Measures the quality of the cells of a frame; `a` is the source.
    pub fn add_quality<T: Level>(&mut self, frame: u32, [a, b]: [&Plane<[T; 3]>; 2], cell: u32) {
        let unit = (self.error.peak / U8_PEAK).round().max(1.0) as f32;
        for [left, top, width, height] in cells(a, cell) {
            let codes = |plane: &Plane<[T; 3]>, x: usize, y: usize| {
                plane.row(top + y as u32)[left as usize + x].map(|level| level.steps() as f32 / unit)
            };
            let error =
                visible_error([width, height].map(|side| side as usize), |x, y| [b, a].map(|plane| codes(plane, x, y)));
            let spot = Spot { frame, x: left, y: top };
            keep_lowest(&mut self.lowest_quality, Lowest { value: quality_of(error), spot });
        }
    }

    /// Adds a run of pixels from `start` on; returns its sum of squared errors.
    fn add_run<T: Level>(&mut self, start: Spot, a: &[[T; 3]], b: &[[T; 3]]) -> u128 {
        let mut sum = 0;
        for (offset, (a, b)) in a.iter().zip(b).enumerate() {
            if a == b {
                continue;
            }
            self.differing_pixels += 1;
            let SampleError { squared, largest } = sample_error(a, b);
            sum += squared;
            let spot = Spot { x: start.x + offset as u32, ..start };
            // Cells are not visited in row order; of equal errors in a frame, the first in row order is kept.
            let earlier = |worst: Spot| worst.frame == spot.frame && (spot.y, spot.x) < (worst.y, worst.x);
            let ties = largest == self.max_error && self.worst.is_none_or(earlier);
            if largest > self.max_error || ties {
                self.max_error = largest;
                self.worst = Some(spot);
            }
        }
        u128::from(sum)
    }
}

/// Returns left, top, width and height of the cells of an image, in row order.
pub(super) fn cells<T>(image: &Plane<T>, cell: u32) -> impl Iterator<Item = [u32; 4]> {
    let (width, height, side) = (image.width(), image.height(), cell.max(1));
    let starts = move |size: u32| (0..size).step_by(side as usize);
    let rect = move |left: u32, top: u32| [left, top, side.min(width - left), side.min(height - top)];
    starts(height).flat_map(move |top| starts(width).map(move |left| rect(left, top)))
}

#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct SampleError {
    pub squared: u64,
    pub largest: u32,
}

pub(super) fn sample_error<T: Level>(a: &[T; 3], b: &[T; 3]) -> SampleError {
    let errors = a.iter().zip(b).map(|(a, b)| a.steps().abs_diff(b.steps()).max(u32::from(a != b)));
    errors.fold(SampleError::default(), |SampleError { squared, largest }, error| SampleError {
        squared: squared + u64::from(error) * u64::from(error),
        largest: largest.max(error),
    })
}

fn keep_lowest(lowest: &mut Option<Lowest>, other: Lowest) {
    if lowest.is_none_or(|lowest| other.value < lowest.value) {
        *lowest = Some(other);
    }
}

#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct BitErrors {
    pub differing_pixels: u64,
    pub first: Option<Spot>,
}

impl BitErrors {
    pub fn add(&mut self, frame: u32, a: &Values, b: &Values) -> Result<()> {
        match (a, b) {
            (Values::Metres(a), Values::Metres(b)) => self.compare(frame, a, b, |z| z.to_bits()),
            (Values::Light(a), Values::Light(b)) => self.compare(frame, a, b, |pixel| pixel.map(f16::to_bits)),
            (Values::Weights(a), Values::Weights(b)) => self.compare(frame, a, b, |pixel| pixel.map(f32::to_bits)),
            (Values::Alpha(a), Values::Alpha(b)) => self.compare(frame, a, b, |alpha| alpha.to_bits()),
            _ => return Err(Error::invalid("images of two kinds cannot be compared")),
        }
        Ok(())
    }

    fn compare<T: Copy, B: PartialEq>(&mut self, frame: u32, a: &Plane<T>, b: &Plane<T>, bits: fn(T) -> B) {
        for (index, (&x, &y)) in a.data().iter().zip(b.data()).enumerate() {
            if bits(x) != bits(y) {
                self.differing_pixels += 1;
                self.first = self.first.or_else(|| Some(Spot::at(frame, index, a.width())));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use codec::color::quality::Quality;

    #[test]
    fn cells_and_frames_have_their_own_psnr() {
        let a = Plane::filled(5, 5, [10u8; 3]);
        let mut b = a.clone();
        b.row_mut(4)[4] = [10, 14, 10];
        b.row_mut(1)[3] = [14, 10, 10];
        let mut errors = SampleErrors::empty(255.0);
        errors.add(0, &a, &a, 4);
        assert_eq!(errors.lowest_cell.unwrap().value, f64::INFINITY);
        errors.add(1, &a, &b, 4);
        let db = |sum: f64, samples: f64| 10.0 * (255.0 * 255.0 * samples / sum).log10();
        let (frame, cell) = (errors.lowest_frame.unwrap(), errors.lowest_cell.unwrap());
        assert!((frame.value - db(32.0, 75.0)).abs() < 1e-9);
        assert!((cell.value - db(16.0, 3.0)).abs() < 1e-9);
        assert_eq!(cell.spot, Spot { frame: 1, x: 4, y: 4 });
        assert_eq!((errors.max_error, errors.differing_pixels), (4, 2));
        assert_eq!(errors.worst, Some(Spot { frame: 1, x: 3, y: 1 }));
    }

    #[test]
    fn halves_of_other_bits_have_a_finite_psnr() {
        let metric = Pu21::new(100.0).unwrap();
        let plane = |value: f32| half_levels(&Plane::filled(1, 1, [f16::from_f32(value); 3]), &metric);
        let of = |a: f32, b: f32| {
            let mut errors = SampleErrors::empty(metric.peak());
            errors.add(0, &plane(a), &plane(b), 64);
            errors
        };
        for (a, b) in
            [(-0.0, 0.0), (6e-8, 1.2e-7), (1e-5, 1.1e-5), (-1.0, 0.0), (200.0, 60_000.0), (64_000.0, 65_504.0)]
        {
            let errors = of(a, b);
            assert!(errors.error.psnr_db().is_finite() && errors.max_error > 0, "{a} as {b}: {errors:?}");
            assert_eq!((errors.differing_pixels, errors.worst), (1, Some(Spot { frame: 0, x: 0, y: 0 })));
        }
        assert_eq!(of(200.0, 200.0).error.psnr_db(), f64::INFINITY);
    }
}
