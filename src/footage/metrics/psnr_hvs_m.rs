//! PSNR-HVS-M of 8-bit images, computed by the `iqa` crate: DCT coefficient errors below the visibility threshold have reduced or
//! zero weight.
//!
//! Based on: N. Ponomarenko, F. Silvestri, K. Egiazarian, M. Carli, J. Astola and V. Lukin, "On between-coefficient contrast
//! masking of DCT basis functions", Third International Workshop on Video Processing and Quality Metrics (VPQM), 2007.

use super::ssim::common_size;
use codec::error::{Error, Result};
use codec::image::Plane;

/// Side of a DCT block. Smaller images have no PSNR-HVS-M; columns and rows beyond the last whole block are ignored.
pub const HVS_BLOCK: u32 = 8;
/// Number of rows measured at once, in whole blocks: images of the crate take 25 bytes per pixel.
const BAND_ROWS: u32 = 64 * HVS_BLOCK;

/// Returns the PSNR-HVS-M in dB of the Rec. 709 luma of two display-referred RGB images; `+inf` if they are equal, `None` if a
/// side is shorter than [`HVS_BLOCK`]. Fails if the sizes differ.
pub fn psnr_hvs_m_rgb8(reference: &Plane<[u8; 3]>, distorted: &Plane<[u8; 3]>) -> Result<Option<f64>> {
    let size = common_size([reference, distorted])?;
    if size[0].min(size[1]) < HVS_BLOCK {
        return Ok(None);
    }
    let rows = size[1] - size[1] % HVS_BLOCK;
    if rows <= BAND_ROWS {
        return band_db([reference, distorted], [0, size[1]]).map(Some);
    }
    let mut sum = 0.0;
    for first in (0..rows).step_by(BAND_ROWS as usize) {
        let count = BAND_ROWS.min(rows - first);
        let db = band_db([reference, distorted], [first, count])?;
        sum += f64::from(count) * 10f64.powf(-db / 10.0);
    }
    Ok(Some(if sum == 0.0 { f64::INFINITY } else { -10.0 * (sum / f64::from(rows)).log10() }))
}

/// Returns the PSNR-HVS-M in dB of `count` rows of two images, from row `first` on.
fn band_db(planes: [&Plane<[u8; 3]>; 2], [first, count]: [u32; 2]) -> Result<f64> {
    let failed = |error: iqa::Error| Error::invalid(format!("PSNR-HVS-M: {error}"));
    let width = planes[0].width();
    let image = |plane: &Plane<[u8; 3]>| {
        let rows = first as usize * width as usize..(first + count) as usize * width as usize;
        iqa::Image::srgb8(width, count, plane.data()[rows].as_flattened().to_vec()).map_err(failed)
    };
    let options = iqa::PsnrHvsOptions { mode: iqa::PsnrHvsMode::Luma709 };
    iqa::psnr_hvs_m(&image(planes[0])?, &image(planes[1])?, options).map_err(failed)
}

/// Perceptual squared error summed over images, for their common PSNR-HVS-M.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct HvsError {
    /// Number of pixels of the images that are large enough.
    pub pixels: u64,
    /// Perceptual squared error divided by the squared peak, summed over these pixels.
    pub sum: f64,
}

impl HvsError {
    pub fn of_rgb8(reference: &Plane<[u8; 3]>, distorted: &Plane<[u8; 3]>) -> Result<HvsError> {
        let Some(db) = psnr_hvs_m_rgb8(reference, distorted)? else { return Ok(HvsError::default()) };
        let pixels = reference.data().len() as u64;
        Ok(HvsError { pixels, sum: pixels as f64 * 10f64.powf(-db / 10.0) })
    }

    /// Adds the errors of other images. The last bits of the sum depend on the order.
    pub fn merge(&mut self, other: &HvsError) {
        self.pixels += other.pixels;
        self.sum += other.sum;
    }

    /// Returns the PSNR-HVS-M in dB over all images; `+inf` if all are equal, `None` if all are too small.
    pub fn psnr_db(&self) -> Option<f64> {
        (self.pixels > 0)
            .then(|| if self.sum == 0.0 { f64::INFINITY } else { -10.0 * (self.sum / self.pixels as f64).log10() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Contrast sensitivity of the DC coefficient in the authors' table.
    const DC_SENSITIVITY: f64 = 1.608_443;

    #[test]
    fn a_constant_error_matches_hand_computation() {
        // Only DC coefficients differ, and masking does not apply to them: the perceptual MSE is (sensitivity · error)².
        let (a, b) = (Plane::filled(16, 24, [100; 3]), Plane::filled(16, 24, [103; 3]));
        let expected = 20.0 * (255.0 / (DC_SENSITIVITY * 3.0)).log10();
        let found = psnr_hvs_m_rgb8(&a, &b).unwrap().unwrap();
        assert!((found - expected).abs() < 1e-6, "{found} {expected}");
        assert_eq!(psnr_hvs_m_rgb8(&a, &a).unwrap(), Some(f64::INFINITY));
    }

    #[test]
    fn errors_of_images_are_pooled_by_their_pixels() {
        let of = |width, error: u8| {
            HvsError::of_rgb8(&Plane::filled(width, 16, [100; 3]), &Plane::filled(width, 16, [100 + error; 3])).unwrap()
        };
        let (mut all, exact) = (of(16, 3), of(32, 0));
        let alone = all.psnr_db().unwrap();
        all.merge(&exact);
        assert!((all.psnr_db().unwrap() - (alone + 10.0 * 3f64.log10())).abs() < 1e-9);
        assert_eq!((exact.psnr_db(), of(7, 3).psnr_db()), (Some(f64::INFINITY), None));
    }

    #[test]
    fn texture_masks_noise() {
        let noisy = |plane: &Plane<[u8; 3]>| {
            let noise = |x: u32, y: u32| (x * 7 + y * 13 + x * y) % 5;
            Plane::from_fn(64, 64, |x, y| plane.get(x, y).map(|value| value + noise(x, y) as u8 - 2))
        };
        let flat = Plane::filled(64, 64, [100; 3]);
        let textured = Plane::from_fn(64, 64, |x, y| [(40 + (x * 53 + y * 97 + x * y * 31) % 160) as u8; 3]);
        let db = |plane: &Plane<[u8; 3]>| psnr_hvs_m_rgb8(plane, &noisy(plane)).unwrap().unwrap();
        assert!(db(&textured) > db(&flat), "{} {}", db(&textured), db(&flat));
    }

    #[test]
    fn small_or_unequal_sizes() {
        let plane = |width, height| Plane::filled(width, height, [0; 3]);
        assert_eq!(psnr_hvs_m_rgb8(&plane(7, 40), &plane(7, 40)).unwrap(), None);
        assert!(psnr_hvs_m_rgb8(&plane(8, 9), &plane(9, 8)).is_err());
    }
}
