//! PSNR-HVS-M of 8-bit images, over the `iqa` crate: errors of DCT coefficients that the eye cannot see count less or not at all.
//!
//! Based on: N. Ponomarenko, F. Silvestri, K. Egiazarian, M. Carli, J. Astola and V. Lukin, "On between-coefficient contrast
//! masking of DCT basis functions", Third International Workshop on Video Processing and Quality Metrics (VPQM), 2007.

use super::ssim::iqa_images;
use crate::error::{Error, Result};
use crate::image::Plane;

/// Side of a DCT block. A smaller image has no PSNR-HVS-M; columns and rows beyond the last whole block do not count.
pub const HVS_BLOCK: u32 = 8;

/// PSNR-HVS-M in dB of the Rec. 709 luma of two display-referred RGB images; `+inf` for equal ones.
/// `None` when a side is shorter than [`HVS_BLOCK`].
pub fn psnr_hvs_m_rgb8(reference: &Plane<[u8; 3]>, distorted: &Plane<[u8; 3]>) -> Result<Option<f64>> {
    let Some([reference, distorted]) = iqa_images([reference, distorted], HVS_BLOCK)? else { return Ok(None) };
    let options = iqa::PsnrHvsOptions { mode: iqa::PsnrHvsMode::Luma709 };
    let db = iqa::psnr_hvs_m(&reference, &distorted, options);
    db.map(Some).map_err(|error| Error::invalid(format!("PSNR-HVS-M: {error}")))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Contrast sensitivity of the DC coefficient in the authors' table.
    const DC_SENSITIVITY: f64 = 1.608_443;

    #[test]
    fn a_constant_error_matches_hand_computation() {
        // Only DC coefficients differ, which nothing masks: the perceptual MSE is (sensitivity · error)².
        let (a, b) = (Plane::filled(16, 24, [100; 3]), Plane::filled(16, 24, [103; 3]));
        let expected = 20.0 * (255.0 / (DC_SENSITIVITY * 3.0)).log10();
        let found = psnr_hvs_m_rgb8(&a, &b).unwrap().unwrap();
        assert!((found - expected).abs() < 1e-6, "{found} {expected}");
        assert_eq!(psnr_hvs_m_rgb8(&a, &a).unwrap(), Some(f64::INFINITY));
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
