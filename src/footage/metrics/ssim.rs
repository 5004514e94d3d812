//! Structural similarity of 8-bit images, equal to that of the `iqa` crate but with a separable Gaussian window.
//!
//! Based on: Z. Wang, A. C. Bovik, H. R. Sheikh and E. P. Simoncelli, "Image quality assessment: from error visibility
//! to structural similarity", IEEE Transactions on Image Processing 13(4), 2004.

use std::collections::VecDeque;

use codec::error::{Error, Result};
use codec::image::Plane;

/// Side of the Gaussian window (σ = 1.5 pixels). Smaller images have no SSIM.
pub const SSIM_WINDOW: u32 = 11;

/// Standard deviation of the window, in pixels.
const SIGMA: f64 = 1.5;
/// Constants C1 and C2 of SSIM for a peak of 255.
const STABILISERS: [f64; 2] = [2.55 * 2.55, 7.65 * 7.65];

/// Returns the mean SSIM of two display-referred RGB images, in −1..=1; exactly 1 for equal images. SSIM is computed for R, G and
/// B separately and averaged; only windows that lie wholly inside the image count. Returns `None` if a side is shorter than
/// [`SSIM_WINDOW`], since padding would determine the result. Fails if the sizes differ.
pub fn ssim_rgb8(a: &Plane<[u8; 3]>, b: &Plane<[u8; 3]>) -> Result<Option<f64>> {
    let size = common_size([a, b])?;
    if size[0].min(size[1]) < SSIM_WINDOW {
        return Ok(None);
    }
    let means = (0..3).map(|channel| mean_of_channel([a, b], channel));
    Ok(Some(means.sum::<f64>() / 3.0))
}

/// Returns the mean SSIM of a channel over all windows inside the image.
fn mean_of_channel([a, b]: [&Plane<[u8; 3]>; 2], channel: usize) -> f64 {
    let weights = window();
    let [width, height] = [a.width() as usize, a.height() as usize];
    let products = |(a, b): (&[u8; 3], &[u8; 3])| {
        let [a, b] = [a, b].map(|pixel| f64::from(pixel[channel]));
        [a, b, a * a + b * b, a * b]
    };
    let products_of =
        |y: usize| -> Vec<[f64; 4]> { a.row(y as u32).iter().zip(b.row(y as u32)).map(products).collect() };
    // The rows of the current window; the next row replaces the first.
    let mut rows: VecDeque<Vec<[f64; 4]>> = (0..weights.len() - 1).map(products_of).collect();
    let mut columns = vec![[0.0; 4]; width];
    let mut sum = 0.0;
    for last in weights.len() - 1..height {
        rows.push_back(products_of(last));
        columns.fill([0.0; 4]);
        for (row, weight) in rows.iter().zip(weights) {
            for (column, products) in columns.iter_mut().zip(row) {
                (0..4).for_each(|at| column[at] += weight * products[at]);
            }
        }
        rows.pop_front();
        for columns in columns.windows(weights.len()) {
            let mut means = [0.0; 4];
            for (column, weight) in columns.iter().zip(weights) {
                (0..4).for_each(|at| means[at] += weight * column[at]);
            }
            sum += of_means(means);
        }
    }
    sum / ((width + 1 - weights.len()) * (height + 1 - weights.len())) as f64
}

/// Returns the SSIM of a window from the weighted means of a, b, a² + b² and a·b.
fn of_means([a, b, squares, product]: [f64; 4]) -> f64 {
    let [c1, c2] = STABILISERS;
    let (squared_means, product_of_means) = (a * a + b * b, a * b);
    let covariance = product - product_of_means;
    let shared = (2.0 * product_of_means + c1) * (2.0 * covariance + c2);
    shared / ((squared_means + c1) * (squares - squared_means + c2))
}

/// Returns the weights of a row of the window; they sum to 1.
fn window() -> [f64; SSIM_WINDOW as usize] {
    let middle = f64::from(SSIM_WINDOW / 2);
    let weights: [f64; SSIM_WINDOW as usize] =
        std::array::from_fn(|at| (-(at as f64 - middle).powi(2) / (2.0 * SIGMA * SIGMA)).exp());
    let sum: f64 = weights.iter().sum();
    weights.map(|weight| weight / sum)
}

/// Returns the common width and height of two images. Fails if they differ.
pub(super) fn common_size(planes: [&Plane<[u8; 3]>; 2]) -> Result<[u32; 2]> {
    let [size, other] = planes.map(|plane| [plane.width(), plane.height()]);
    match size == other {
        true => Ok(size),
        false => Err(Error::invalid(format!("images of {size:?} and {other:?} pixels cannot be compared"))),
    }
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
    fn windows_of_columns_and_rows_are_those_of_the_crate() {
        let plain = |a: &Plane<[u8; 3]>, b: &Plane<[u8; 3]>| {
            let [a, b] = [a, b]
                .map(|plane| iqa::Image::srgb8(a.width(), a.height(), plane.data().as_flattened().to_vec()).unwrap());
            iqa::ssim(&a, &b, iqa::SsimOptions { mode: iqa::SsimMode::RgbAveraged }).unwrap()
        };
        for (width, height) in [(11, 11), (12, 40), (64, 33)] {
            let a = texture(width, height);
            let flat = Plane::filled(width, height, [255; 3]);
            let noisy =
                Plane::from_fn(width, height, |x, y| a.get(x, y).map(|value| value ^ ((x * 7 + y * 5) % 32) as u8));
            for b in [&noisy, &flat, &a.map(|pixel| pixel.map(|value| 255 - value))] {
                let (found, wanted) = (ssim_rgb8(&a, b).unwrap().unwrap(), plain(&a, b));
                assert!((found - wanted).abs() < 1e-10, "{width}x{height}: {found} {wanted}");
            }
        }
    }

    #[test]
    fn constant_images_match_hand_computation() {
        // Without variance only the luminance term (2ab + C1)/(a² + b² + C1) remains, C1 = (0.01·255)².
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
