//! Similarity of rendered images and reference images (CALF 7.2): PSNR, PSNR-HVS-M and SSIM of display codes.

use serde::Serialize;

use crate::reference::Truth;
use codec::error::{Error, Result};
use codec::image::{EncodeTable, MaterialPlane, Plane, ToneMap};
use codec::metrics::{SquaredError, U8_PEAK};
use codec::streams::convert::color_codes;
use footage::json::Number;
use footage::metrics::{HvsError, ssim_rgb8};
use render::rendered_image::RenderedImage;

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Similarity {
    pub all: SquaredError,
    pub seen: SquaredError,
    /// Pixels whose reference material reflects or refracts.
    pub effects: SquaredError,
    /// Pixels of `effects` that only reflect.
    pub mirrors: SquaredError,
    /// Pixels of `effects` that refract.
    pub glass: SquaredError,
    /// True if the reference has material, so that `effects`, `mirrors` and `glass` are known.
    pub has_material: bool,
    /// Pixels near silhouettes of views. This and `elsewhere`, all other pixels, are empty if silhouettes are unknown.
    pub near_silhouettes: SquaredError,
    pub elsewhere: SquaredError,
    /// Number of pixels with alpha 0.
    pub hole_pixels: u64,
    /// Number of images that are large enough for SSIM.
    pub ssim_images: u64,
    /// Sum of the SSIM of these images.
    pub ssim_sum: f64,
    pub hvs: HvsError,
    /// Sum of the PSNR in dB of the images that are not exact.
    pub psnr_db_sum: f64,
    /// Number of images that are not exact.
    pub inexact_images: u64,
    pub images: u64,
}

/// Metrics of a report; metrics without pixels or images are omitted.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SimilarityReport {
    psnr_db: Number,
    psnr_db_seen: Number,
    ssim: Option<f64>,
    hole_percent: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    ghost_ratio: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    psnr_hvs_m_db: Option<Number>,
    #[serde(skip_serializing_if = "Option::is_none")]
    psnr_db_effects: Option<Number>,
    #[serde(skip_serializing_if = "Option::is_none")]
    psnr_db_mirrors: Option<Number>,
    #[serde(skip_serializing_if = "Option::is_none")]
    psnr_db_glass: Option<Number>,
}

impl Similarity {
    pub fn report(&self) -> SimilarityReport {
        SimilarityReport {
            psnr_db: Number(self.all.psnr_db()),
            psnr_db_seen: Number(self.seen.psnr_db()),
            ssim: self.ssim(),
            hole_percent: self.hole_percent(),
            ghost_ratio: self.ghost_ratio(),
            psnr_hvs_m_db: self.hvs.psnr_db().map(Number),
            psnr_db_effects: some_psnr(&self.effects).map(Number),
            psnr_db_mirrors: some_psnr(&self.mirrors).map(Number),
            psnr_db_glass: some_psnr(&self.glass).map(Number),
        }
    }

    pub fn empty() -> Similarity {
        let none = SquaredError::empty(U8_PEAK);
        Similarity {
            all: none,
            seen: none,
            effects: none,
            mirrors: none,
            glass: none,
            near_silhouettes: none,
            elsewhere: none,
            has_material: false,
            hole_pixels: 0,
            ssim_images: 0,
            ssim_sum: 0.0,
            hvs: HvsError::default(),
            psnr_db_sum: 0.0,
            inexact_images: 0,
            images: 0,
        }
    }

    /// Compares an image with its reference, both as codes of `tone`.
    pub fn of(rendered: &RenderedImage, truth: &Truth, tone: ToneMap) -> Result<Similarity> {
        let sizes = [(rendered.color.width(), rendered.color.height()), (truth.color.width(), truth.color.height())];
        if sizes[0] != sizes[1] {
            return Err(Error::invalid(format!(
                "a picture of {:?} pixels cannot be compared with one of {:?}: render it at the size of the reference",
                sizes[0], sizes[1]
            )));
        }
        let codes = [rendered.codes(tone), truth_codes(truth, tone)];
        Similarity::of_codes([&codes[0], &codes[1]], &rendered.alpha, truth.material.as_ref())
    }

    /// Compares the codes of an image with those of its reference. `alpha` is that of the image, `material` that of the
    /// reference, all of the same size.
    pub fn of_codes(
        [shown, wanted]: [&Plane<[u8; 3]>; 2],
        alpha: &Plane<f32>,
        material: Option<&MaterialPlane>,
    ) -> Result<Similarity> {
        let all = SquaredError::of_u8(shown.data().as_flattened(), wanted.data().as_flattened())?;
        let ssim = ssim_rgb8(shown, wanted)?;
        let mut sum = Similarity {
            all,
            has_material: material.is_some(),
            hole_pixels: alpha.data().iter().filter(|alpha| **alpha <= 0.0).count() as u64,
            ssim_images: u64::from(ssim.is_some()),
            ssim_sum: ssim.unwrap_or(0.0),
            hvs: HvsError::of_rgb8(wanted, shown)?,
            psnr_db_sum: if all.sum > 0 { all.psnr_db() } else { 0.0 },
            inexact_images: u64::from(all.sum > 0),
            images: 1,
            ..Similarity::empty()
        };
        let weights = |material: &MaterialPlane, at: usize| {
            let [reflect, refract, _] = material.data()[at];
            [reflect > 0.0, refract > 0.0]
        };
        for (at, (shown, wanted)) in shown.data().iter().zip(wanted.data()).enumerate() {
            let squares = shown.iter().zip(wanted).map(|(&a, &b)| u128::from(a.abs_diff(b)).pow(2)).sum::<u128>();
            let add = |error: &mut SquaredError| {
                error.sum += squares;
                error.samples += 3;
            };
            if alpha.data()[at] > 0.0 {
                add(&mut sum.seen);
            }
            if let Some(material) = material {
                let [reflects, refracts] = weights(material, at);
                if reflects || refracts {
                    add(&mut sum.effects);
                    add(if refracts { &mut sum.glass } else { &mut sum.mirrors });
                }
            }
        }
        Ok(sum)
    }

    /// Adds the errors of an image, divided by whether pixels are near silhouettes of views.
    pub fn add_silhouettes(&mut self, [shown, wanted]: [&Plane<[u8; 3]>; 2], near: &Plane<bool>) {
        for ((shown, wanted), &is_near) in shown.data().iter().zip(wanted.data()).zip(near.data()) {
            let error = if is_near { &mut self.near_silhouettes } else { &mut self.elsewhere };
            error.sum += shown.iter().zip(wanted).map(|(&a, &b)| u128::from(a.abs_diff(b)).pow(2)).sum::<u128>();
            error.samples += 3;
        }
    }

    /// Returns the RMS error of pixels near silhouettes of views divided by that of all other pixels; ghosting at edges increases
    /// it. `None` if there are no pixels near silhouettes, or if all others are exact.
    pub fn ghost_ratio(&self) -> Option<f64> {
        let mean = |error: &SquaredError| error.sum as f64 / error.samples as f64;
        let ratio = (mean(&self.near_silhouettes) / mean(&self.elsewhere)).sqrt();
        ratio.is_finite().then_some(ratio)
    }

    /// Adds the results of other images. The last bits of sums depend on the order.
    pub fn merge(&mut self, other: &Similarity) -> Result<()> {
        self.all.merge(&other.all)?;
        self.seen.merge(&other.seen)?;
        self.effects.merge(&other.effects)?;
        self.mirrors.merge(&other.mirrors)?;
        self.glass.merge(&other.glass)?;
        self.near_silhouettes.merge(&other.near_silhouettes)?;
        self.elsewhere.merge(&other.elsewhere)?;
        self.has_material |= other.has_material;
        self.hole_pixels += other.hole_pixels;
        self.ssim_images += other.ssim_images;
        self.ssim_sum += other.ssim_sum;
        self.hvs.merge(&other.hvs);
        self.psnr_db_sum += other.psnr_db_sum;
        self.inexact_images += other.inexact_images;
        self.images += other.images;
        Ok(())
    }

    /// Returns the mean PSNR in dB of the images that are not exact; `+inf` if all are exact.
    pub fn mean_psnr_db(&self) -> f64 {
        if self.inexact_images == 0 { f64::INFINITY } else { self.psnr_db_sum / self.inexact_images as f64 }
    }

    /// Returns the mean SSIM; `None` if all images are too small.
    pub fn ssim(&self) -> Option<f64> {
        (self.ssim_images > 0).then(|| self.ssim_sum / self.ssim_images as f64)
    }

    /// Returns the holes in percent of all pixels.
    pub fn hole_percent(&self) -> f64 {
        100.0 * self.hole_pixels as f64 / (self.all.samples / 3).max(1) as f64
    }
}

/// Returns the PSNR in dB; `None` without pixels.
pub fn some_psnr(error: &SquaredError) -> Option<f64> {
    (error.samples > 0).then(|| error.psnr_db())
}

/// Returns the display codes of a reference, as `encode` computes them.
pub fn truth_codes(truth: &Truth, tone: ToneMap) -> Plane<[u8; 3]> {
    color_codes(&truth.color, &EncodeTable::new(&tone)).0
}

/// Returns the maximum difference of the three samples of each pixel, in display codes.
pub fn difference(shown: &Plane<[u8; 3]>, wanted: &Plane<[u8; 3]>) -> Result<Plane<u8>> {
    let largest = |(a, b): (&[u8; 3], &[u8; 3])| (0..3).map(|at| a[at].abs_diff(b[at])).fold(0, u8::max);
    if (shown.width(), shown.height()) != (wanted.width(), wanted.height()) {
        return Err(Error::invalid("pictures of different sizes have no differences by pixel"));
    }
    Plane::new(shown.width(), shown.height(), shown.data().iter().zip(wanted.data()).map(largest).collect())
}

#[cfg(test)]
mod tests {
    use half::f16;

    use super::*;
    use codec::image::transfer::Transfer;

    const LINEAR: ToneMap = ToneMap { transfer: Transfer::Linear, exposure_ev: 0.0 };

    /// Returns a gray image of 12x12 pixels of code `shown`, of which the first `holes` are holes, and its reference of code
    /// `wanted` with material.
    fn pair(shown: u8, wanted: u8, holes: usize, material: &[[f32; 3]]) -> (RenderedImage, Truth) {
        let plane = |code: u8| Plane::filled(12, 12, [f32::from(code) / 255.0; 3]);
        let mut alpha = Plane::filled(12, 12, 1.0);
        alpha.data_mut()[..holes].fill(0.0);
        let mut weights = Plane::filled(12, 12, [0.0, 0.0, 1.0]);
        weights.data_mut()[..material.len()].copy_from_slice(material);
        let truth = Truth {
            color: plane(wanted).map(|light| light.map(f16::from_f32)),
            material: (!material.is_empty()).then_some(weights),
        };
        (RenderedImage::new(plane(shown), alpha), truth)
    }

    #[test]
    fn figures_are_those_of_a_hand() {
        let (mut rendered, truth) = pair(10, 12, 3, &[[1.0, 0.0, 1.0], [0.2, 0.8, 1.5], [0.0, 0.5, 1.5]]);
        // One hole has a larger error, and one pixel of glass is exact.
        rendered.color.data_mut()[0] = [22.0 / 255.0; 3];
        rendered.color.data_mut()[2] = [12.0 / 255.0; 3];
        let one = Similarity::of(&rendered, &truth, LINEAR).unwrap();
        assert_eq!((one.all.sum, one.all.samples), (3 * (100 + 142 * 4), 3 * 144));
        assert_eq!((one.seen.sum, one.seen.samples), (3 * 141 * 4, 3 * 141));
        assert_eq!((one.mirrors.sum, one.mirrors.samples), (300, 3));
        assert_eq!((one.glass.sum, one.glass.samples), (12, 6));
        assert_eq!((one.effects.sum, one.effects.samples), (312, 9));
        assert!((one.hole_percent() - 300.0 / 144.0).abs() < 1e-12);
        assert!(one.ssim().is_some_and(|ssim| ssim < 1.0));
        assert!(one.hvs.psnr_db().is_some_and(|db| db > 20.0 && db < 60.0));
        let (exact, same) = pair(12, 12, 0, &[]);
        let other = Similarity::of(&exact, &same, LINEAR).unwrap();
        assert_eq!((other.all.psnr_db(), other.ssim()), (f64::INFINITY, Some(1.0)));
        assert_eq!((some_psnr(&other.effects), other.has_material), (None, false));
        assert_eq!(other.hvs.psnr_db(), Some(f64::INFINITY));
        let mut both = one;
        both.merge(&other).unwrap();
        assert_eq!((both.images, both.all.samples, both.has_material), (2, 6 * 144, true));
        assert_eq!(both.all.sum, one.all.sum);
        assert_eq!((both.mean_psnr_db(), other.mean_psnr_db()), (one.all.psnr_db(), f64::INFINITY));
        both = one;
        both.merge(&one).unwrap();
        assert_eq!((both.mean_psnr_db(), both.ssim()), (one.all.psnr_db(), one.ssim()));
    }

    #[test]
    fn sizes_must_agree_and_nan_is_black() {
        let (mut rendered, truth) = pair(0, 0, 0, &[]);
        rendered.color.data_mut()[5] = [f32::NAN; 3];
        assert_eq!(Similarity::of(&rendered, &truth, LINEAR).unwrap().all.sum, 0);
        rendered.color = Plane::filled(11, 12, [0.0; 3]);
        assert!(Similarity::of(&rendered, &truth, LINEAR).unwrap_err().to_string().contains("(11, 12)"));
        assert!(difference(&Plane::filled(1, 2, [0; 3]), &Plane::filled(2, 1, [0; 3])).is_err());
        let largest = difference(&Plane::filled(1, 1, [9, 200, 3]), &Plane::filled(1, 1, [10, 190, 7])).unwrap();
        assert_eq!(largest.data(), [10]);
    }
}
