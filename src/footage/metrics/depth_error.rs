//! Depth errors in 16-bit codes and in metres, and the pixel with the largest error.
//!
//! Takes two images in codes and metres and returns [`DepthErrors`], which are merged over faces and frames.

use serde::Serialize;
use serde::ser::{SerializeStruct, Serializer};

use crate::json::Number;
use codec::metrics::BACKGROUND_CODE;
use codec::metrics::psnr::{SquaredError, U16_PEAK};

pub const OUTSIDE: i32 = -1;

/// A pixel of a frame of a stream.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Spot {
    /// Frame number; that of the first side if the sides number frames differently.
    pub frame: u32,
    pub x: u32,
    pub y: u32,
}

impl Spot {
    pub fn at(frame: u32, index: usize, width: u32) -> Spot {
        let width = width.max(1) as usize;
        Spot { frame, x: (index % width) as u32, y: (index / width) as u32 }
    }
}

#[derive(Debug, Clone, PartialEq)]
pub struct DepthPicture {
    pub width: u32,
    /// Codes; [`OUTSIDE`] for depth outside the range of the codes.
    pub codes: Vec<i32>,
    /// Metres, as exact as the side stores them; +inf for background.
    pub metres: Vec<f32>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DepthErrors {
    /// Maximum error in codes; 65535 if one side has background and the other a surface, or if one side has no code for its
    /// depth.
    pub max_error_codes: u16,
    /// Maximum error in metres; +inf if one side has background and the other a surface.
    pub max_error_m: f64,
    pub error: SquaredError,
    /// The first pixel with the maximum error in codes; `None` if all codes are equal.
    pub worst: Option<Spot>,
    pub differing_pixels: u64,
    pub background_mismatches: u64,
    /// Number of pixels outside the range of the codes on either side.
    pub outside_pixels: u64,
    /// True if bits were compared and differ.
    pub has_other_bits: bool,
}

impl Serialize for DepthErrors {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut fields = serializer.serialize_struct("DepthErrors", 6)?;
        fields.serialize_field("max_error_codes", &self.max_error_codes)?;
        fields.serialize_field("max_error_m", &Number(self.max_error_m))?;
        fields.serialize_field("psnr_db", &Number(self.psnr_db()))?;
        fields.serialize_field("differing_pixels", &self.differing_pixels)?;
        fields.serialize_field("background_mismatches", &self.background_mismatches)?;
        fields.serialize_field("outside_pixels", &self.outside_pixels)?;
        fields.end()
    }
}

impl Default for DepthErrors {
    fn default() -> Self {
        DepthErrors {
            max_error_codes: 0,
            max_error_m: 0.0,
            error: SquaredError::empty(U16_PEAK),
            worst: None,
            differing_pixels: 0,
            background_mismatches: 0,
            outside_pixels: 0,
            has_other_bits: false,
        }
    }
}

impl DepthErrors {
    /// Returns the PSNR of codes in dB; `+inf` if all codes are equal, NaN if they are equal but bits differ.
    pub fn psnr_db(&self) -> f64 {
        finite_or_nan(self.error.psnr_db(), self.has_other_bits)
    }

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

    /// Adds the errors of another stream. Returns true if the worst pixel is now that of the other stream.
    pub fn merge(&mut self, other: &DepthErrors) -> bool {
        self.max_error_m = self.max_error_m.max(other.max_error_m);
        self.error.sum += other.error.sum;
        self.error.samples += other.error.samples;
        self.differing_pixels += other.differing_pixels;
        self.background_mismatches += other.background_mismatches;
        self.outside_pixels += other.outside_pixels;
        self.has_other_bits |= other.has_other_bits;
        let worse = other.max_error_codes > self.max_error_codes;
        if worse {
            self.max_error_codes = other.max_error_codes;
            self.worst = other.worst;
        }
        worse
    }
}

/// Returns the PSNR of codes, with NaN in place of +inf if values differ that have equal codes.
pub fn finite_or_nan(psnr_db: f64, has_other_bits: bool) -> f64 {
    if has_other_bits && psnr_db == f64::INFINITY { f64::NAN } else { psnr_db }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PixelError {
    /// Error in codes or steps of the metric; 0 if the pixels are equal.
    Steps(u32),
    /// One side has background and the other a surface.
    Background,
    /// One side has a depth outside the range of the codes.
    Outside,
}

impl PixelError {
    /// Returns the error of depth in codes; 65535 for [`PixelError::Background`] and [`PixelError::Outside`].
    pub fn codes(self) -> u16 {
        match self {
            PixelError::Steps(steps) => u16::try_from(steps).unwrap_or(u16::MAX),
            PixelError::Background | PixelError::Outside => u16::MAX,
        }
    }
}

/// Returns the error between two codes. Two [`OUTSIDE`] codes stand for different depths, since callers test for equal depths
/// first.
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

/// Returns the error of each pixel in row order, as [`DepthErrors`] counts it.
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
}
