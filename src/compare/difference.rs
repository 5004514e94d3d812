//! What is counted pixel by pixel when two images are compared.

use half::f16;
use serde::{Serialize, Serializer};

use crate::color::quality::{Pu21, Quality};
use crate::compare::domain::{DepthPicture, OUTSIDE, Values};
use crate::depth::quantise::BACKGROUND_CODE;
use crate::error::{Error, Result};
use crate::image::plane::{ColorPlane, Plane};
use crate::json::{self, Number};
use crate::metrics::depth_error::DEPTH_CODE_PEAK;
use crate::metrics::psnr::{CodeError, U8_PEAK};

/// A pixel of a frame of a stream.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Spot {
    /// Frame number, of the first side where they differ.
    pub frame: u32,
    /// Column.
    pub x: u32,
    /// Row.
    pub y: u32,
}

impl Spot {
    fn at(frame: u32, index: usize, width: u32) -> Spot {
        let width = width.max(1) as usize;
        Spot { frame, x: (index % width) as u32, y: (index / width) as u32 }
    }
}

/// Errors of depth.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct DepthErrors {
    /// Largest error in codes: 65535 where one side sees background and the other does not, or where one side has no
    /// code for what it sees.
    pub max_error_codes: u16,
    /// Largest error in metres, +inf where one side sees background and the other does not.
    #[serde(serialize_with = "json::number")]
    pub max_error_m: f64,
    /// Squared error in codes.
    #[serde(rename = "psnr_db", serialize_with = "psnr_db")]
    pub error: CodeError,
    /// The first pixel that has the largest error in codes; `None` where all are equal.
    #[serde(skip)]
    pub worst: Option<Spot>,
    /// Pixels whose codes differ.
    pub differing_pixels: u64,
    /// Pixels that are background on one side only.
    pub background_mismatches: u64,
    /// Pixels that the range of the codes leaves out, on either side.
    pub outside_pixels: u64,
}

fn psnr_db<S: Serializer>(error: &CodeError, serializer: S) -> Result<S::Ok, S::Error> {
    Number(error.psnr_db()).serialize(serializer)
}

impl Default for DepthErrors {
    fn default() -> Self {
        DepthErrors {
            max_error_codes: 0,
            max_error_m: 0.0,
            error: CodeError::empty(DEPTH_CODE_PEAK),
            worst: None,
            differing_pixels: 0,
            background_mismatches: 0,
            outside_pixels: 0,
        }
    }
}

impl DepthErrors {
    /// Adds a frame.
    pub fn add(&mut self, frame: u32, a: &DepthPicture, b: &DepthPicture) {
        let codes = a.codes.iter().zip(&b.codes);
        let metres = a.metres.iter().zip(&b.metres);
        for (index, ((&code_a, &code_b), (&m_a, &m_b))) in codes.zip(metres).enumerate() {
            self.outside_pixels += u64::from(code_a == OUTSIDE || code_b == OUTSIDE);
            if code_a == code_b && m_a == m_b {
                continue;
            }
            self.max_error_m = self.max_error_m.max(error_m(m_a, m_b));
            let found = error_codes(code_a, code_b);
            let error = found.codes();
            if error == 0 {
                continue;
            }
            self.differing_pixels += 1;
            self.background_mismatches += u64::from(found == PixelError::Background);
            self.error.sum += u128::from(error).pow(2);
            if error > self.max_error_codes {
                self.max_error_codes = error;
                self.worst = Some(Spot::at(frame, index, a.width));
            }
        }
        self.error.samples += a.codes.len() as u64;
    }

    /// Adds what another stream has; answers whether the worst pixel is now the other's.
    pub fn merge(&mut self, other: &DepthErrors) -> bool {
        self.max_error_m = self.max_error_m.max(other.max_error_m);
        self.error.sum += other.error.sum;
        self.error.samples += other.error.samples;
        self.differing_pixels += other.differing_pixels;
        self.background_mismatches += other.background_mismatches;
        self.outside_pixels += other.outside_pixels;
        let worse = other.max_error_codes > self.max_error_codes;
        if worse {
            self.max_error_codes = other.max_error_codes;
            self.worst = other.worst;
        }
        worse
    }
}

/// The error of one pixel of depth.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PixelError {
    /// So many codes or steps of the metric; 0 where nothing differs.
    Steps(u32),
    /// One side has background where the other has a surface.
    Background,
    /// A side sees a depth that the range of the codes leaves out.
    Outside,
}

impl PixelError {
    /// The error of depth in codes; what is no matter of codes is the largest.
    pub fn codes(self) -> u16 {
        match self {
            PixelError::Steps(steps) => u16::try_from(steps).unwrap_or(u16::MAX),
            PixelError::Background | PixelError::Outside => u16::MAX,
        }
    }
}

/// The error between two codes. Codes that are both missing stand for two different depths: where the depths are equal
/// nobody asks.
fn error_codes(a: i32, b: i32) -> PixelError {
    let background = i32::from(BACKGROUND_CODE);
    if (a == background) != (b == background) {
        PixelError::Background
    } else if a == OUTSIDE || b == OUTSIDE {
        PixelError::Outside
    } else {
        PixelError::Steps(a.abs_diff(b))
    }
}

/// The error of each pixel, row by row, as [`DepthErrors`] counts it.
pub fn depth_errors(a: &DepthPicture, b: &DepthPicture) -> Vec<PixelError> {
    let codes = a.codes.iter().zip(&b.codes);
    let metres = a.metres.iter().zip(&b.metres);
    let error = |((&code_a, &code_b), (m_a, m_b))| match code_a == code_b && m_a == m_b {
        true => PixelError::Steps(0),
        false => error_codes(code_a, code_b),
    };
    codes.zip(metres).map(error).collect()
}

fn error_m(a: f32, b: f32) -> f64 {
    match (a.is_finite(), b.is_finite()) {
        (true, true) => (f64::from(a) - f64::from(b)).abs(),
        (false, false) => 0.0,
        _ => f64::INFINITY,
    }
}

/// A sample of colour or material, as its metric sees it.
pub trait Level: Copy + PartialEq {
    /// The sample in steps of the metric.
    fn steps(self) -> i32;
}

impl Level for u8 {
    fn steps(self) -> i32 {
        i32::from(self)
    }
}

/// A half float and its PU21 encoding; two that look alike may differ in bits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct HalfLevel {
    bits: u16,
    steps: u16,
}

impl Level for HalfLevel {
    fn steps(self) -> i32 {
        i32::from(self.steps)
    }
}

/// The samples of half-float colour in the steps of its metric.
pub fn half_levels(plane: &ColorPlane, metric: &Pu21) -> Plane<[HalfLevel; 3]> {
    let level = |value: f16| HalfLevel { bits: value.to_bits(), steps: metric.steps(value) };
    plane.map(|pixel| pixel.map(level))
}

/// Peak of a metric over half-float colour, in its steps.
pub fn half_peak(metric: &Pu21) -> f64 {
    metric.peak()
}

/// The lowest PSNR of a frame, or of a frame of a cell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lowest {
    /// Its PSNR, +inf where all are equal.
    pub psnr_db: f64,
    /// The frame, and the upper left corner of the cell.
    pub spot: Spot,
}

/// Errors of colour and material.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SampleErrors {
    /// Largest error of a sample in the metric's steps: 8-bit codes, or 64ths of PU21.
    pub max_error: u32,
    /// Squared error in steps.
    pub error: CodeError,
    /// The first pixel that has the largest error; `None` where all are equal.
    pub worst: Option<Spot>,
    /// Pixels that differ.
    pub differing_pixels: u64,
    /// The frame of lowest PSNR.
    pub lowest_frame: Option<Lowest>,
    /// The cell and frame of lowest PSNR.
    pub lowest_cell: Option<Lowest>,
    /// Sum of the SSIM of some frames.
    pub ssim_sum: f64,
    /// Their number.
    pub ssim_frames: u64,
    /// Pixels that were clipped on their way into 8 bits, on both sides together.
    pub clipped_pixels: u64,
}

impl SampleErrors {
    /// Mean SSIM of the frames that it was computed for.
    pub fn ssim(&self) -> Option<f64> {
        (self.ssim_frames > 0).then(|| self.ssim_sum / self.ssim_frames as f64)
    }

    /// Nothing compared yet, with a metric of that peak.
    pub fn empty(peak: f64) -> SampleErrors {
        SampleErrors {
            max_error: 0,
            error: CodeError::empty(peak),
            worst: None,
            differing_pixels: 0,
            lowest_frame: None,
            lowest_cell: None,
            ssim_sum: 0.0,
            ssim_frames: 0,
            clipped_pixels: 0,
        }
    }

    /// Nothing compared yet, in 8 bits.
    pub fn empty_8bit() -> SampleErrors {
        SampleErrors::empty(U8_PEAK)
    }

    /// Adds a frame, measured in cells of `cell` pixels.
    pub fn add<T: Level>(&mut self, frame: u32, a: &Plane<[T; 3]>, b: &Plane<[T; 3]>, cell: u32) {
        let (width, height) = (a.width(), a.height());
        let [mut total, mut cells] = [CodeError::empty(self.error.peak), CodeError::empty(self.error.peak)];
        total.samples = a.data().len() as u64 * 3;
        for top in (0..height).step_by(cell.max(1) as usize) {
            let rows = top..height.min(top.saturating_add(cell));
            for left in (0..width).step_by(cell.max(1) as usize) {
                let columns = left as usize..width.min(left.saturating_add(cell)) as usize;
                cells.sum = 0;
                cells.samples = 3 * (columns.len() * rows.len()) as u64;
                for y in rows.clone() {
                    let (row_a, row_b) = (&a.row(y)[columns.clone()], &b.row(y)[columns.clone()]);
                    if row_a != row_b {
                        cells.sum += self.add_run(Spot { frame, x: left, y }, row_a, row_b);
                    }
                }
                total.sum += cells.sum;
                keep_lowest(
                    &mut self.lowest_cell,
                    Lowest { psnr_db: cells.psnr_db(), spot: Spot { frame, x: left, y: top } },
                );
            }
        }
        keep_lowest(&mut self.lowest_frame, Lowest { psnr_db: total.psnr_db(), spot: Spot { frame, x: 0, y: 0 } });
        self.error.sum += total.sum;
        self.error.samples += total.samples;
    }

    /// Adds a run of pixels that starts at a spot; answers its squared error.
    fn add_run<T: Level>(&mut self, start: Spot, a: &[[T; 3]], b: &[[T; 3]]) -> u128 {
        let mut sum = 0;
        for (offset, (a, b)) in a.iter().zip(b).enumerate() {
            if a == b {
                continue;
            }
            self.differing_pixels += 1;
            let (squares, largest) = sample_error(a, b);
            sum += squares;
            let spot = Spot { x: start.x + offset as u32, ..start };
            // Cells are not in row order: of equal errors in a frame, the first in row order is kept.
            let earlier = |worst: Spot| worst.frame == spot.frame && (spot.y, spot.x) < (worst.y, worst.x);
            let ties = largest == self.max_error && self.worst.is_none_or(earlier);
            if largest > self.max_error || ties {
                self.max_error = largest;
                self.worst = Some(spot);
            }
        }
        u128::from(sum)
    }

    /// The PSNR of everything compared.
    pub fn psnr_db(&self) -> f64 {
        self.error.psnr_db()
    }
}

/// The squared error of a pixel's samples, and the largest error of one of them, in steps.
pub fn sample_error<T: Level>(a: &[T; 3], b: &[T; 3]) -> (u64, u32) {
    let errors = a.iter().zip(b).map(|(a, b)| a.steps().abs_diff(b.steps()));
    errors.fold((0, 0), |(sum, largest), error| (sum + u64::from(error) * u64::from(error), largest.max(error)))
}

fn keep_lowest(lowest: &mut Option<Lowest>, other: Lowest) {
    if lowest.is_none_or(|lowest| other.psnr_db < lowest.psnr_db) {
        *lowest = Some(other);
    }
}

/// Differences in bits.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct BitErrors {
    /// Pixels that differ.
    pub differing_pixels: u64,
    /// The first of them.
    pub first: Option<Spot>,
}

impl BitErrors {
    /// Adds a frame of values as files hold them.
    pub fn add(&mut self, frame: u32, a: &Values, b: &Values) -> Result<()> {
        match (a, b) {
            (Values::Metres(a), Values::Metres(b)) => self.compare(frame, a, b, |z| z.to_bits()),
            (Values::Light(a), Values::Light(b)) => self.compare(frame, a, b, |pixel| pixel.map(f16::to_bits)),
            (Values::Weights(a), Values::Weights(b)) => self.compare(frame, a, b, |pixel| pixel.map(f32::to_bits)),
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

    #[test]
    fn depth_errors_name_the_first_worst_pixel() {
        let picture =
            |codes: &[i32], metres: &[f32]| DepthPicture { width: 2, codes: codes.to_vec(), metres: metres.to_vec() };
        let a = picture(&[5, 9, 65535, OUTSIDE], &[1.0, 2.0, f32::INFINITY, 99.0]);
        let mut errors = DepthErrors::default();
        errors.add(3, &a, &a);
        assert_eq!((errors.differing_pixels, errors.outside_pixels, errors.worst), (0, 1, None));
        errors.add(4, &a, &picture(&[5, 12, 65535, OUTSIDE], &[1.0, 2.5, f32::INFINITY, 99.0]));
        assert_eq!((errors.max_error_codes, errors.max_error_m), (3, 0.5));
        assert_eq!(errors.worst, Some(Spot { frame: 4, x: 1, y: 0 }));
        errors.add(5, &a, &picture(&[5, 9, 65534, OUTSIDE], &[1.0, 2.0, 7.0, 98.0]));
        assert_eq!((errors.max_error_codes, errors.background_mismatches), (65535, 1));
        assert_eq!((errors.max_error_m, errors.differing_pixels), (f64::INFINITY, 3));
        assert_eq!(errors.worst, Some(Spot { frame: 5, x: 0, y: 1 }));
    }

    #[test]
    fn cells_and_frames_have_their_own_psnr() {
        let a = Plane::filled(5, 5, [10u8; 3]);
        let mut b = a.clone();
        b.row_mut(4)[4] = [10, 14, 10];
        b.row_mut(1)[3] = [14, 10, 10];
        let mut errors = SampleErrors::empty_8bit();
        errors.add(0, &a, &a, 4);
        assert_eq!(errors.lowest_cell.unwrap().psnr_db, f64::INFINITY);
        errors.add(1, &a, &b, 4);
        let db = |sum: f64, samples: f64| 10.0 * (255.0 * 255.0 * samples / sum).log10();
        let (frame, cell) = (errors.lowest_frame.unwrap(), errors.lowest_cell.unwrap());
        assert!((frame.psnr_db - db(32.0, 75.0)).abs() < 1e-9);
        assert!((cell.psnr_db - db(16.0, 3.0)).abs() < 1e-9);
        assert_eq!(cell.spot, Spot { frame: 1, x: 4, y: 4 });
        assert_eq!((errors.max_error, errors.differing_pixels), (4, 2));
        assert_eq!(errors.worst, Some(Spot { frame: 1, x: 3, y: 1 }));
    }

    #[test]
    fn halves_that_look_alike_differ_all_the_same() {
        let metric = Pu21::new(100.0).unwrap();
        let plane = |value: f32| Plane::filled(1, 1, [f16::from_f32(value); 3]);
        let mut errors = SampleErrors::empty(half_peak(&metric));
        errors.add(0, &half_levels(&plane(-1.0), &metric), &half_levels(&plane(0.0), &metric), 64);
        assert_eq!((errors.max_error, errors.differing_pixels), (0, 1));
        assert_eq!((errors.worst, errors.psnr_db()), (Some(Spot { frame: 0, x: 0, y: 0 }), f64::INFINITY));
    }
}
