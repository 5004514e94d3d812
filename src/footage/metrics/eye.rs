//! SSIMULACRA2 and butteraugli of 8-bit sRGB images, computed by the crates `fast-ssim2` and `butteraugli`.
//!
//! Based on: J. Sneyers, "SSIMULACRA 2", <https://github.com/cloudinary/ssimulacra2>; J. Alakuijala, R. Obryk, O. Stoliarchuk,
//! Z. Szabadka, L. Vandevenne and J. Wassenberg, "Guetzli: perceptually guided JPEG encoder", arXiv 1703.04421, 2017.

use butteraugli::{ButteraugliParams, Img, RGB8, butteraugli};
use fast_ssim2::{PixelDescriptor, PixelSlice, compute_ssimulacra2};

use super::ssim::common_size;
use codec::error::{Error, Result};
use codec::image::Plane;

/// Minimum side that is scored without mirroring. SSIMULACRA2 weights six scales and is invalid with fewer, so images with
/// shorter sides are mirrored.
const MIN_SIDE: u32 = 256;
/// Measured memory of scoring, in bytes per pixel of a pair of images.
const PIXEL_BYTES: u64 = 160;

/// Scores accumulated over images.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct EyeScores {
    /// SSIMULACRA2 of each image; 100 for equal images.
    ssimulacra2: Vec<f64>,
    /// Sum of the butteraugli 3-norms of all images; 0 for equal images.
    butteraugli: f64,
}

impl EyeScores {
    /// Adds the scores of an image; images without pixels are ignored.
    pub fn add(&mut self, source: &Plane<[u8; 3]>, shown: &Plane<[u8; 3]>) -> Result<()> {
        let size = common_size([source, shown])?;
        if size.contains(&0) {
            return Ok(());
        }
        let [ssimulacra2, butteraugli] = if source == shown { [100.0, 0.0] } else { scores([source, shown])? };
        self.ssimulacra2.push(ssimulacra2);
        self.butteraugli += butteraugli;
        Ok(())
    }

    /// Adds the scores of other images. The last bits of the sum depend on the order.
    pub fn merge(&mut self, other: &EyeScores) {
        self.ssimulacra2.extend(&other.ssimulacra2);
        self.butteraugli += other.butteraugli;
    }

    pub fn pictures(&self) -> u64 {
        self.ssimulacra2.len() as u64
    }

    /// Returns the mean SSIMULACRA2 of all images; `None` without images.
    pub fn ssimulacra2(&self) -> Option<f64> {
        self.mean(self.ssimulacra2.iter().sum())
    }

    /// Returns the 10th percentile of SSIMULACRA2 over images, interpolated linearly between two of them.
    pub fn ssimulacra2_p10(&self) -> Option<f64> {
        let mut sorted = self.ssimulacra2.clone();
        sorted.sort_by(f64::total_cmp);
        let place = 0.1 * (sorted.len().checked_sub(1)?) as f64;
        let (below, above) = (sorted[place.floor() as usize], sorted[place.ceil() as usize]);
        Some(below + (above - below) * place.fract())
    }

    /// Returns the mean butteraugli 3-norm of all images; `None` without images.
    pub fn butteraugli_3norm(&self) -> Option<f64> {
        self.mean(self.butteraugli)
    }

    fn mean(&self, sum: f64) -> Option<f64> {
        (!self.ssimulacra2.is_empty()).then(|| sum / self.ssimulacra2.len() as f64)
    }
}

/// Returns the bytes of memory that scoring a pair of images takes.
pub fn scoring_bytes(size: [u32; 2]) -> u64 {
    let [width, height] = size.map(|side| u64::from(side * copies(side)));
    width * height * PIXEL_BYTES
}

/// Returns SSIMULACRA2 and the 3-norm of butteraugli.
fn scores(pictures: [&Plane<[u8; 3]>; 2]) -> Result<[f64; 2]> {
    let pictures = pictures.map(mirrored);
    Ok([ssimulacra2(&pictures)?, butteraugli_3norm(&pictures)?])
}

fn ssimulacra2(pictures: &[Plane<[u8; 3]>; 2]) -> Result<f64> {
    let failed = |error: &dyn std::fmt::Display| Error::invalid(format!("SSIMULACRA2: {error}"));
    let [source, shown] = pictures.each_ref().map(|picture| {
        let [width, height] = [picture.width(), picture.height()];
        let bytes = picture.data().as_flattened();
        PixelSlice::new(bytes, width, height, 3 * width as usize, PixelDescriptor::RGB8_SRGB)
    });
    let (source, shown) = (source.map_err(|error| failed(&error))?, shown.map_err(|error| failed(&error))?);
    compute_ssimulacra2(&source, &shown).map_err(|error| failed(&error))
}

fn butteraugli_3norm(pictures: &[Plane<[u8; 3]>; 2]) -> Result<f64> {
    let [source, shown] = pictures.each_ref().map(|picture| {
        let pixels: Vec<RGB8> = picture.data().iter().map(|&[r, g, b]| RGB8 { r, g, b }).collect();
        Img::new(pixels, picture.width() as usize, picture.height() as usize)
    });
    let found = butteraugli(source.as_ref(), shown.as_ref(), &ButteraugliParams::default());
    found.map(|found| found.pnorm_3).map_err(|error| Error::invalid(format!("butteraugli: {error}")))
}

/// Returns the number of times that a side is repeated, a power of two.
fn copies(side: u32) -> u32 {
    MIN_SIDE.div_ceil(side.max(1)).next_power_of_two()
}

/// Tiles an image with its mirror images until both sides are at least [`MIN_SIDE`].
fn mirrored(picture: &Plane<[u8; 3]>) -> Plane<[u8; 3]> {
    let [width, height] = [picture.width(), picture.height()];
    let place = |at: u32, side: u32| if (at / side).is_multiple_of(2) { at % side } else { side - 1 - at % side };
    Plane::from_fn(width * copies(width), height * copies(height), |x, y| {
        picture.get(place(x, width), place(y, height))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(side: u32) -> Plane<[u8; 3]> {
        Plane::from_fn(side, side, |x, y| {
            let wave = (x * x / 3 + 5 * y) % 97;
            [(x / 2 + wave / 3) as u8, (y / 2 + 40 + wave / 4) as u8, ((x + y) / 4 + 2 * (wave / 8)) as u8]
        })
    }

    fn coarse(picture: &Plane<[u8; 3]>, step: u8) -> Plane<[u8; 3]> {
        picture.map(|pixel| pixel.map(|value| value / step * step + step / 2))
    }

    fn of(source: &Plane<[u8; 3]>, shown: &Plane<[u8; 3]>) -> EyeScores {
        let mut found = EyeScores::default();
        found.add(source, shown).unwrap();
        found
    }

    #[test]
    fn scores_are_near_those_of_another_program() {
        // Reference values of `ssimulacra2` 0.3.0 from PyPI, whose Gaussian treats borders differently; its input of the smaller
        // image was mirrored to 384 pixels.
        for (side, step, wanted) in [(256, 6, 91.445), (96, 6, 90.755), (256, 3, 96.024)] {
            let found = of(&picture(side), &coarse(&picture(side), step)).ssimulacra2().unwrap();
            assert!((found - wanted).abs() < 0.5, "{side} {step}: {found}");
        }
        let found = of(&picture(256), &coarse(&picture(256), 6)).butteraugli_3norm().unwrap();
        assert!((found - 0.661).abs() < 0.005, "{found}");
    }

    #[test]
    fn equal_pictures_have_no_loss_and_none_has_no_score() {
        let found = of(&picture(9), &picture(9));
        assert_eq!((found.ssimulacra2(), found.butteraugli_3norm(), found.pictures()), (Some(100.0), Some(0.0), 1));
        for none in [EyeScores::default(), of(&picture(0), &picture(0))] {
            assert_eq!((none.ssimulacra2(), none.ssimulacra2_p10(), none.butteraugli_3norm()), (None, None, None));
        }
        assert!(EyeScores::default().add(&picture(8), &picture(9)).is_err());
    }

    #[test]
    fn means_and_percentiles_are_of_all_pictures() {
        let mut all = EyeScores { ssimulacra2: vec![90.0, 70.0, 80.0], butteraugli: 6.0 };
        all.merge(&EyeScores { ssimulacra2: (0..8).map(|at| 60.0 - f64::from(at)).collect(), butteraugli: 5.0 });
        assert_eq!((all.ssimulacra2_p10(), all.butteraugli_3norm()), (Some(54.0), Some(1.0)));
        all.merge(&EyeScores { ssimulacra2: vec![100.0], butteraugli: 0.0 });
        assert!((all.ssimulacra2_p10().unwrap() - 54.1).abs() < 1e-9);
    }

    #[test]
    fn small_pictures_are_mirrored_to_six_scales() {
        let found = mirrored(&Plane::from_fn(96, 300, |x, y| [x as u8, (y / 2) as u8, 0]));
        assert_eq!((found.width(), found.height(), scoring_bytes([96, 300])), (384, 300, 384 * 300 * PIXEL_BYTES));
        let row: Vec<u8> = found.row(7).iter().map(|pixel| pixel[0]).collect();
        let (first, second): (Vec<u8>, Vec<u8>) = ((0..96).collect(), (0..96).rev().collect());
        assert_eq!(row, [first.clone(), second.clone(), first, second].concat());
    }
}
