//! Structural similarity of 8-bit images, over the `iqa` crate.
//!
//! Based on: Z. Wang, A. C. Bovik, H. R. Sheikh and E. P. Simoncelli, "Image quality assessment: from error visibility
//! to structural similarity", IEEE Transactions on Image Processing 13(4), 2004.

use crate::error::{Error, Result};
use crate::image::Plane;

/// Side of the Gaussian window (σ = 1.5 pixels). A smaller image has no SSIM.
pub const SSIM_WINDOW: u32 = 11;

/// Mean SSIM of two display-referred RGB images, in −1..=1; exactly 1 for equal images.
/// Each of R, G and B is compared for itself and the three means averaged; only windows that lie wholly inside
/// count. `None` when a side is shorter than [`SSIM_WINDOW`]: padding would invent the answer.
pub fn ssim_rgb8(a: &Plane<[u8; 3]>, b: &Plane<[u8; 3]>) -> Result<Option<f64>> {
    let Some([a, b]) = iqa_images([a, b], SSIM_WINDOW)? else { return Ok(None) };
    let options = iqa::SsimOptions { mode: iqa::SsimMode::RgbAveraged };
    iqa::ssim(&a, &b, options).map(Some).map_err(|error| Error::invalid(format!("SSIM: {error}")))
}

/// Two images of one size for `iqa`; None when a side is shorter than `least`.
pub(super) fn iqa_images(planes: [&Plane<[u8; 3]>; 2], least: u32) -> Result<Option<[iqa::Image<iqa::Srgb8>; 2]>> {
    let [size, other] = planes.map(|plane| [plane.width(), plane.height()]);
    if size != other {
        let message = format!("images of {size:?} and {other:?} pixels cannot be compared");
        return Err(Error::invalid(message));
    }
    if size[0].min(size[1]) < least {
        return Ok(None);
    }
    let image = |plane: &Plane<[u8; 3]>| {
        iqa::Image::srgb8(size[0], size[1], plane.data().as_flattened().to_vec())
            .map_err(|error| Error::invalid(format!("image measures: {error}")))
    };
    Ok(Some([image(planes[0])?, image(planes[1])?]))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texture(width: u32, height: u32) -> Plane<[u8; 3]> {
        Plane::from_fn(width, height, |x, y| {
            [(x * 37 % 256) as u8, ((x * y) % 251) as u8, if (x / 4 + y / 4) % 2 == 0 { 30 } else { 220 }]
        })
    }

    #[test]
    fn equal_is_one_and_order_does_not_matter() {
        let a = texture(40, 24);
        assert_eq!(ssim_rgb8(&a, &a).unwrap(), Some(1.0));
        let b = a.map(|p| p.map(|v| v.saturating_add(9) & 0xf0));
        let (ab, ba) = (ssim_rgb8(&a, &b).unwrap().unwrap(), ssim_rgb8(&b, &a).unwrap().unwrap());
        assert!(ab > 0.5 && ab < 1.0, "{ab}");
        assert_eq!(ab, ba);
    }

    #[test]
    fn constant_images_match_hand_computation() {
        // No variance: only the luminance term (2ab + C1)/(a² + b² + C1) is left, C1 = (0.01·255)².
        let (a, b) = (Plane::filled(11, 11, [100; 3]), Plane::filled(11, 11, [120; 3]));
        let c1 = 2.55_f64 * 2.55;
        let expected = (2.0 * 100.0 * 120.0 + c1) / (100.0 * 100.0 + 120.0 * 120.0 + c1);
        assert!((ssim_rgb8(&a, &b).unwrap().unwrap() - expected).abs() < 1e-12);
    }

    #[test]
    fn structure_counts_more_than_level() {
        let a = texture(64, 64);
        let brighter = a.map(|p| p.map(|v| v / 2 + 40));
        let turned = Plane::from_fn(64, 64, |x, y| a.get(y, x));
        assert!(ssim_rgb8(&a, &brighter).unwrap() > ssim_rgb8(&a, &turned).unwrap());
    }

    #[test]
    fn small_or_unequal_sizes() {
        assert_eq!(ssim_rgb8(&texture(10, 40), &texture(10, 40)).unwrap(), None);
        assert_eq!(ssim_rgb8(&texture(0, 0), &texture(0, 0)).unwrap(), None);
        assert!(ssim_rgb8(&texture(12, 11), &texture(11, 12)).is_err());
    }
}
