//! How wrong decoded depth is: in 16-bit codes, in metres, and at which pixel most.
//!
//! Enters: a plane of reference codes and a plane of decoded codes, and for metres a table or the original depth.
//! Leaves: [`DepthErrorStats`], which merge over faces and frames; the caller keeps the labels.

use super::psnr::{CodeError, U16_PEAK};
use crate::error::{Error, Result};
use crate::image::{DepthPlane, Plane};

/// The code of a pixel that sees nothing.
pub const BACKGROUND_CODE: u16 = u16::MAX;
/// Peak of the depth PSNR, in codes.
pub const DEPTH_CODE_PEAK: f64 = U16_PEAK;
/// Number of 16-bit codes, the length of a code → metres table.
const CODE_COUNT: usize = 1 << 16;

/// Where the metres of a comparison come from.
#[derive(Debug, Clone, Copy)]
pub enum DepthMetres<'a> {
    /// Nowhere: errors are measured in codes alone.
    CodesOnly,
    /// Both sides through one table of 65,536 distances in metres: the error of coding, without quantisation.
    Table(&'a [f32]),
    /// The reference as it was before quantisation, the decoded side through the table: the whole error.
    Original {
        /// Depth in metres, `+inf` (or anything not finite) where there is nothing.
        reference: &'a DepthPlane,
        /// 65,536 distances in metres.
        table: &'a [f32],
    },
}

/// Depth error of any number of pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DepthErrorStats {
    /// Largest |reference − decoded| in codes; 65,535 as soon as a surface was taken for background or the reverse.
    pub max_error_codes: u16,
    /// Largest error in metres: `None` when not measured, `+inf` as soon as a surface was taken for background or the
    /// reverse.
    pub max_error_m: Option<f32>,
    /// Pixels that are background on one side only. Each also counts 65,535 codes in `squared_error`.
    pub background_mismatches: u64,
    /// Squared error in codes, peak 65,535.
    pub squared_error: CodeError,
    /// (x, y) of the first pixel in row order that has `max_error_codes`; `None` when all pixels are equal.
    pub worst: Option<(u32, u32)>,
}

impl Default for DepthErrorStats {
    fn default() -> Self {
        DepthErrorStats {
            max_error_codes: 0,
            max_error_m: None,
            background_mismatches: 0,
            squared_error: CodeError::empty(DEPTH_CODE_PEAK),
            worst: None,
        }
    }
}

impl DepthErrorStats {
    /// Compares one plane.
    ///
    /// # Errors
    /// If the planes differ in size or a table has not 65,536 entries.
    pub fn compare(reference: &Plane<u16>, decoded: &Plane<u16>, metres: DepthMetres<'_>) -> Result<Self> {
        same_size("decoded depth", (reference.width(), reference.height()), (decoded.width(), decoded.height()))?;
        let mut stats = DepthErrorStats::default();
        let mut background_sum = 0;
        let (codes_a, codes_b) = (reference.data(), decoded.data());
        for (i, (&a, &b)) in codes_a.iter().zip(codes_b).enumerate() {
            // Rows of equal codes are the common case; only what differs is looked at.
            if a == b {
                continue;
            }
            let mut error = a.abs_diff(b);
            if (a == BACKGROUND_CODE) != (b == BACKGROUND_CODE) {
                stats.background_mismatches += 1;
                background_sum += square(BACKGROUND_CODE) - square(error);
                error = BACKGROUND_CODE;
            }
            if error > stats.max_error_codes {
                stats.max_error_codes = error;
                let width = reference.width() as usize;
                stats.worst = Some(((i % width) as u32, (i / width) as u32));
            }
        }
        stats.squared_error = CodeError::of_u16(codes_a, codes_b)?;
        stats.squared_error.sum += background_sum;
        stats.max_error_m = max_error_m(reference, decoded, metres)?;
        Ok(stats)
    }

    /// Adds what another comparison has seen. Returns whether `worst` is now the other's, so that the caller can
    /// note its frame and face; at equal errors the earlier one stays.
    pub fn merge(&mut self, other: &DepthErrorStats) -> bool {
        self.squared_error.sum += other.squared_error.sum;
        self.squared_error.samples += other.squared_error.samples;
        self.background_mismatches += other.background_mismatches;
        self.max_error_m = match (self.max_error_m, other.max_error_m) {
            (Some(a), Some(b)) => Some(a.max(b)),
            (a, b) => a.or(b),
        };
        let worse = other.max_error_codes > self.max_error_codes;
        if worse {
            self.max_error_codes = other.max_error_codes;
            self.worst = other.worst;
        }
        worse
    }

    /// PSNR of the codes with peak 65,535, in dB; `+inf` when all are equal.
    pub fn psnr_db(&self) -> f64 {
        self.squared_error.psnr_db()
    }
}

/// The largest distance between the two sides, `None` without metres.
fn max_error_m(reference: &Plane<u16>, decoded: &Plane<u16>, metres: DepthMetres<'_>) -> Result<Option<f32>> {
    let pairs = reference.data().iter().zip(decoded.data());
    let max = match metres {
        DepthMetres::CodesOnly => return Ok(None),
        DepthMetres::Table(table) => {
            check_table(table)?;
            pairs
                .filter(|(a, b)| a != b)
                .map(|(&a, &b)| distance_error_m(metres_of(table, a), metres_of(table, b)))
                .fold(0.0, f32::max)
        }
        DepthMetres::Original { reference: original, table } => {
            check_table(table)?;
            let size = (original.width(), original.height());
            same_size("original depth", (reference.width(), reference.height()), size)?;
            let sides = original.data().iter().zip(decoded.data());
            sides.map(|(&a, &b)| distance_error_m(a, metres_of(table, b))).fold(0.0, f32::max)
        }
    };
    Ok(Some(max))
}

/// The table's distance, `+inf` for background whatever the table says there.
fn metres_of(table: &[f32], code: u16) -> f32 {
    if code == BACKGROUND_CODE { f32::INFINITY } else { table[usize::from(code)] }
}

/// |a − b|; anything not finite is background, which is 0 from background and `+inf` from a surface.
fn distance_error_m(a: f32, b: f32) -> f32 {
    match (a.is_finite(), b.is_finite()) {
        (true, true) => (a - b).abs(),
        (false, false) => 0.0,
        _ => f32::INFINITY,
    }
}

fn square(error: u16) -> u128 {
    u128::from(error) * u128::from(error)
}

fn check_table(table: &[f32]) -> Result<()> {
    if table.len() == CODE_COUNT {
        Ok(())
    } else {
        Err(Error::invalid(format!("a depth table has {} entries, expected {CODE_COUNT}", table.len())))
    }
}

fn same_size(what: &str, expected: (u32, u32), found: (u32, u32)) -> Result<()> {
    if expected == found {
        Ok(())
    } else {
        Err(Error::invalid(format!(
            "the {what} has {}x{} pixels, the reference {}x{}",
            found.0, found.1, expected.0, expected.1
        )))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Code c lies at c millimetres.
    fn millimetres() -> Vec<f32> {
        (0..=u16::MAX).map(|code| f32::from(code) / 1000.0).collect()
    }

    fn codes(width: u32, data: &[u16]) -> Plane<u16> {
        Plane::new(width, data.len() as u32 / width, data.to_vec()).unwrap()
    }

    #[test]
    fn codes_metres_and_worst_pixel() {
        let reference = codes(3, &[10, 20, 30, 40, 50, BACKGROUND_CODE]);
        let decoded = codes(3, &[10, 22, 30, 40, 45, BACKGROUND_CODE]);
        let table = millimetres();
        let stats = DepthErrorStats::compare(&reference, &decoded, DepthMetres::Table(&table)).unwrap();
        assert_eq!(stats.max_error_codes, 5);
        assert!((stats.max_error_m.unwrap() - 0.005).abs() < 1e-6);
        assert_eq!(stats.worst, Some((1, 1)));
        assert_eq!(stats.background_mismatches, 0);
        assert_eq!((stats.squared_error.sum, stats.squared_error.samples), (29, 6));
        let expected = 10.0 * (65_535.0_f64 * 65_535.0 * 6.0 / 29.0).log10();
        assert!((stats.psnr_db() - expected).abs() < 1e-9);
    }

    #[test]
    fn background_mismatch_is_the_worst_error() {
        let reference = codes(2, &[65_534, BACKGROUND_CODE, 7, 100]);
        let decoded = codes(2, &[BACKGROUND_CODE, 3, 7, 130]);
        let table = millimetres();
        let stats = DepthErrorStats::compare(&reference, &decoded, DepthMetres::Table(&table)).unwrap();
        // One code apart, and yet as wrong as can be.
        assert_eq!(stats.max_error_codes, 65_535);
        assert_eq!(stats.worst, Some((0, 0)));
        assert_eq!(stats.background_mismatches, 2);
        assert_eq!(stats.max_error_m, Some(f32::INFINITY));
        assert_eq!(stats.squared_error.sum, 2 * 65_535 * 65_535 + 900);
    }

    #[test]
    fn equal_planes() {
        let plane = codes(2, &[1, 2, BACKGROUND_CODE, 4]);
        let table = millimetres();
        let stats = DepthErrorStats::compare(&plane, &plane, DepthMetres::Table(&table)).unwrap();
        assert_eq!((stats.max_error_codes, stats.max_error_m, stats.worst), (0, Some(0.0), None));
        assert_eq!(stats.psnr_db(), f64::INFINITY);
        let bare = DepthErrorStats::compare(&plane, &plane, DepthMetres::CodesOnly).unwrap();
        assert_eq!(bare.max_error_m, None);
    }

    #[test]
    fn original_depth_includes_quantisation() {
        let reference = codes(3, &[10, 20, BACKGROUND_CODE]);
        let table = millimetres();
        let original = Plane::new(3, 1, vec![0.0104, 0.0197, f32::INFINITY]).unwrap();
        let metres = DepthMetres::Original { reference: &original, table: &table };
        let stats = DepthErrorStats::compare(&reference, &reference, metres).unwrap();
        assert_eq!(stats.max_error_codes, 0);
        assert!((stats.max_error_m.unwrap() - 0.0004).abs() < 1e-6);
        let lost = codes(3, &[10, 20, 21]);
        assert_eq!(DepthErrorStats::compare(&reference, &lost, metres).unwrap().max_error_m, Some(f32::INFINITY));
    }

    #[test]
    fn merge_tells_whose_pixel_is_worst() {
        let a = DepthErrorStats::compare(&codes(1, &[5, 9]), &codes(1, &[5, 12]), DepthMetres::CodesOnly).unwrap();
        let b = DepthErrorStats::compare(&codes(1, &[5, 9]), &codes(1, &[9, 9]), DepthMetres::CodesOnly).unwrap();
        let mut all = DepthErrorStats::default();
        assert!(all.merge(&a));
        assert!(all.merge(&b));
        assert!(!all.merge(&a));
        assert!(!all.merge(&b));
        assert_eq!((all.max_error_codes, all.worst), (4, Some((0, 0))));
        assert_eq!((all.squared_error.sum, all.squared_error.samples), (2 * (9 + 16), 8));
    }

    #[test]
    fn sizes_are_checked() {
        let (a, b) = (codes(2, &[1, 2]), codes(1, &[1, 2]));
        assert!(DepthErrorStats::compare(&a, &b, DepthMetres::CodesOnly).is_err());
        assert!(DepthErrorStats::compare(&a, &a, DepthMetres::Table(&[0.0; 10])).is_err());
        let (table, original) = (millimetres(), Plane::filled(1, 1, 1.0_f32));
        let metres = DepthMetres::Original { reference: &original, table: &table };
        assert!(DepthErrorStats::compare(&a, &a, metres).is_err());
    }
}
