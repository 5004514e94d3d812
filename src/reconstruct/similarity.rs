//! How far a rendered picture is from the truth (CALF 7.2): PSNR and SSIM of display codes, and where the error lies.
//!
//! Enters: rendered pictures with what should be there. Leaves: sums that merge over images, in a fixed order.

use crate::error::{Error, Result};
use crate::image::plane::{MaterialPlane, Plane};
use crate::image::transfer::{EncodeTable, ToneMap};
use crate::metrics::psnr::{CodeError, U8_PEAK};
use crate::metrics::ssim_rgb8;
use crate::reconstruct::reference::Truth;
use crate::reconstruct::render::Rendered;
use crate::video::convert::color_codes;

/// How far one picture, or several, are from what they should be, in 8-bit display codes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Similarity {
    /// All pixels; holes count as what they show.
    pub all: CodeError,
    /// Pixels that are no holes.
    pub seen: CodeError,
    /// Pixels whose true material reflects or refracts at all.
    pub effects: CodeError,
    /// Of those, the ones that only reflect: mirrors.
    pub mirrors: CodeError,
    /// Of those, the ones that refract: glass.
    pub glass: CodeError,
    /// Whether the truth had material, so that the three are known.
    pub has_material: bool,
    /// Pixels in which no ray ended in anything that a view saw.
    pub hole_pixels: u64,
    /// Pictures that have an SSIM: those that are no smaller than its window.
    pub ssim_images: u64,
    /// Sum of their SSIM.
    pub ssim_sum: f64,
    /// Sum of the PSNR of each picture in dB; infinite where one of them is exact.
    pub psnr_db_sum: f64,
    /// Pictures.
    pub images: u64,
}

impl Similarity {
    /// Nothing compared yet.
    pub fn empty() -> Similarity {
        let none = CodeError::empty(U8_PEAK);
        Similarity {
            all: none,
            seen: none,
            effects: none,
            mirrors: none,
            glass: none,
            has_material: false,
            hole_pixels: 0,
            ssim_images: 0,
            ssim_sum: 0.0,
            psnr_db_sum: 0.0,
            images: 0,
        }
    }

    /// Compares a picture with what should be there, both as codes of `tone`.
    ///
    /// # Errors
    /// When they differ in size.
    pub fn of(rendered: &Rendered, truth: &Truth, tone: ToneMap) -> Result<Similarity> {
        let sizes = [(rendered.color.width(), rendered.color.height()), (truth.color.width(), truth.color.height())];
        if sizes[0] != sizes[1] {
            return Err(Error::invalid(format!(
                "a picture of {:?} pixels cannot be compared with one of {:?}: render it in the size of the reference",
                sizes[0], sizes[1]
            )));
        }
        let [shown, wanted] = [rendered.codes(tone), truth_codes(truth, tone)];
        let all = CodeError::of_u8(shown.data().as_flattened(), wanted.data().as_flattened())?;
        let ssim = ssim_rgb8(&shown, &wanted)?;
        let mut sum = Similarity {
            all,
            has_material: truth.material.is_some(),
            hole_pixels: rendered.alpha.data().iter().filter(|alpha| **alpha <= 0.0).count() as u64,
            ssim_images: u64::from(ssim.is_some()),
            ssim_sum: ssim.unwrap_or(0.0),
            psnr_db_sum: all.psnr_db(),
            images: 1,
            ..Similarity::empty()
        };
        let weights = |material: &MaterialPlane, at: usize| {
            let [reflect, refract, _] = material.data()[at];
            [reflect > 0.0, refract > 0.0]
        };
        for (at, (shown, wanted)) in shown.data().iter().zip(wanted.data()).enumerate() {
            let squares = shown.iter().zip(wanted).map(|(&a, &b)| u128::from(a.abs_diff(b)).pow(2)).sum::<u128>();
            let add = |error: &mut CodeError| {
                error.sum += squares;
                error.samples += 3;
            };
            if rendered.alpha.data()[at] > 0.0 {
                add(&mut sum.seen);
            }
            if let Some(material) = &truth.material {
                let [reflects, refracts] = weights(material, at);
                if reflects || refracts {
                    add(&mut sum.effects);
                    add(if refracts { &mut sum.glass } else { &mut sum.mirrors });
                }
            }
        }
        Ok(sum)
    }

    /// Adds other pictures; in a fixed order, for the last bits to be the same on every run.
    ///
    /// # Errors
    /// None that pictures of this module can cause: peaks are all 255.
    pub fn merge(&mut self, other: &Similarity) -> Result<()> {
        self.all.merge(&other.all)?;
        self.seen.merge(&other.seen)?;
        self.effects.merge(&other.effects)?;
        self.mirrors.merge(&other.mirrors)?;
        self.glass.merge(&other.glass)?;
        self.has_material |= other.has_material;
        self.hole_pixels += other.hole_pixels;
        self.ssim_images += other.ssim_images;
        self.ssim_sum += other.ssim_sum;
        self.psnr_db_sum += other.psnr_db_sum;
        self.images += other.images;
        Ok(())
    }

    /// Mean over pictures of their PSNR in dB; `+inf` where one of them is exact, and of none.
    pub fn mean_psnr_db(&self) -> f64 {
        if self.images == 0 { f64::INFINITY } else { self.psnr_db_sum / self.images as f64 }
    }

    /// Mean over pictures of their SSIM; none where all of them are too small.
    pub fn ssim(&self) -> Option<f64> {
        (self.ssim_images > 0).then(|| self.ssim_sum / self.ssim_images as f64)
    }

    /// Holes, in parts of a hundred of all pixels.
    pub fn hole_percent(&self) -> f64 {
        100.0 * self.hole_pixels as f64 / (self.all.samples / 3).max(1) as f64
    }

    /// PSNR in dB of the pixels that reflect or refract; none where there are no such pixels.
    pub fn effects_psnr_db(&self) -> Option<f64> {
        some_psnr(&self.effects)
    }

    /// PSNR in dB of mirrors; none where there are no such pixels.
    pub fn mirrors_psnr_db(&self) -> Option<f64> {
        some_psnr(&self.mirrors)
    }

    /// PSNR in dB of glass; none where there are no such pixels.
    pub fn glass_psnr_db(&self) -> Option<f64> {
        some_psnr(&self.glass)
    }
}

fn some_psnr(error: &CodeError) -> Option<f64> {
    (error.samples > 0).then(|| error.psnr_db())
}

/// The truth as display codes, as `encode` makes them of a dataset's colours.
pub fn truth_codes(truth: &Truth, tone: ToneMap) -> Plane<[u8; 3]> {
    color_codes(&truth.color, &EncodeTable::new(&tone)).0
}

/// The largest difference of the three samples of each pixel, in display codes.
///
/// # Errors
/// When the two differ in size.
pub fn difference(shown: &Plane<[u8; 3]>, wanted: &Plane<[u8; 3]>) -> Result<Plane<u8>> {
    let largest = |(a, b): (&[u8; 3], &[u8; 3])| (0..3).map(|at| a[at].abs_diff(b[at])).fold(0, u8::max);
    if (shown.width(), shown.height()) != (wanted.width(), wanted.height()) {
        return Err(Error::invalid("pictures of different sizes have no differences by pixel"));
    }
    Plane::new(shown.width(), shown.height(), shown.data().iter().zip(wanted.data()).map(largest).collect())
}
