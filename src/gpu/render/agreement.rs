//! Differences between pictures rendered on a device and on the CPU, and their tolerances.

use codec::error::Result;
use codec::image::ToneMap;
use codec::metrics::SquaredError;
use evaluate::similarity::difference;
use footage::metrics::ssim_rgb8;
use render::march::Rendered;
use render::rendered_image::RenderedImage;

/// Tolerance of a pixel's channels, in 8-bit codes.
pub const CODES: u8 = 2;
/// Fraction of pixels that may exceed the tolerances, in colour or in alpha. For a ray that grazes a surface, the last bit of a
/// float decides between hit and miss.
pub const PIXELS: f64 = 1e-3;
/// Tolerance of a pixel's alpha: half a code. A hit or miss changes alpha by more.
pub const ALPHA: f32 = 0.5 / 255.0;
/// Minimum PSNR in dB, of 8-bit sRGB codes.
pub const PSNR_DB: f64 = 50.0;
/// Minimum SSIM.
pub const SSIM: f64 = 0.999;
/// Tolerance of the number of marching steps or fragments, as a fraction.
pub const STEPS: f64 = 0.01;

/// Differences between two pictures of the same camera.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Agreement {
    pub pixels: u64,
    /// Pixels whose codes differ by more than [`CODES`].
    pub differing: u64,
    /// Pixels whose alpha differs by more than [`ALPHA`].
    pub holes_differing: u64,
    /// Pixels of the device's picture with a channel that is not finite.
    pub not_finite: u64,
    /// PSNR in dB; infinite if all codes are equal.
    pub psnr_db: f64,
    /// SSIM; 1 if the pictures are too small for it.
    pub ssim: f64,
    /// Ratio of marching steps or fragments, device to CPU; 1 if both are 0.
    pub steps_ratio: f64,
}

impl Agreement {
    pub fn of(on_device: &Rendered, on_cpu: &Rendered) -> Result<Agreement> {
        let steps = [on_device, on_cpu].map(|picture| picture.counters.march_steps);
        Agreement::of_images(&on_device.image, &on_cpu.image, steps)
    }

    /// Compares two pictures and the numbers of marching steps or fragments that they took.
    pub fn of_images(on_device: &RenderedImage, on_cpu: &RenderedImage, steps: [u64; 2]) -> Result<Agreement> {
        let [found, expected] = [on_device, on_cpu].map(|image| image.codes(ToneMap::default()));
        let error = SquaredError::of_u8(found.data().as_flattened(), expected.data().as_flattened())?;
        let differences = difference(&found, &expected)?;
        let alphas = on_device.alpha.data().iter().zip(on_cpu.alpha.data());
        let steps = steps.map(|steps| steps as f64);
        Ok(Agreement {
            pixels: found.data().len() as u64,
            differing: differences.data().iter().filter(|codes| **codes > CODES).count() as u64,
            holes_differing: alphas.filter(|(a, b)| (*a - *b).abs() > ALPHA).count() as u64,
            not_finite: on_device.color.data().iter().filter(|pixel| !pixel.iter().all(|c| c.is_finite())).count()
                as u64,
            psnr_db: error.psnr_db(),
            ssim: ssim_rgb8(&found, &expected)?.unwrap_or(1.0),
            steps_ratio: if steps == [0.0; 2] { 1.0 } else { steps[0] / steps[1] },
        })
    }

    /// Returns 0 if the pictures agree; otherwise the largest count of pixels that exceeds its tolerance. If PSNR, SSIM or steps
    /// disagree, the result is at least `differing` and at least 1.
    pub fn mismatches(&self) -> u64 {
        let allowed = (PIXELS * self.pixels as f64).ceil() as u64;
        let beyond = |count: u64| if count > allowed { count } else { 0 };
        let alike = self.psnr_db >= PSNR_DB && self.ssim >= SSIM && (self.steps_ratio - 1.0).abs() <= STEPS;
        let count = beyond(self.differing).max(beyond(self.holes_differing)).max(self.not_finite);
        if alike { count } else { count.max(self.differing).max(1) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use codec::image::plane::Plane;
    use render::march::counters::Counters;

    fn picture() -> Rendered {
        let color = Plane::from_fn(64, 64, |x, y| [x as f32 / 64.0, y as f32 / 64.0, 0.5]);
        let image = RenderedImage::new(color, Plane::filled(64, 64, 1.0));
        Rendered { image, counters: Counters { march_steps: 1000, ..Counters::default() } }
    }

    #[test]
    fn what_differs_is_counted() {
        let same = Agreement::of(&picture(), &picture()).unwrap();
        assert_eq!((same.mismatches(), same.psnr_db), (0, f64::INFINITY));
        let mut other = picture();
        other.image.color.data_mut()[7] = [f32::NAN; 3];
        assert_eq!(Agreement::of(&other, &picture()).unwrap().mismatches(), 1);
        let mut other = picture();
        // Five pixels of 4096 may exceed the tolerance, six may not.
        for count in 1..=6 {
            other.image.color.data_mut()[80 * count][2] = 0.53;
            assert_eq!(Agreement::of(&other, &picture()).unwrap().mismatches(), if count <= 5 { 0 } else { 6 });
        }
        let mut other = picture();
        other.image.alpha.data_mut()[..6].fill(0.0);
        assert_eq!(Agreement::of(&other, &picture()).unwrap().mismatches(), 6);
        let mut other = picture();
        other.counters.march_steps = 1011;
        assert_eq!(Agreement::of(&other, &picture()).unwrap().mismatches(), 1);
        let mut other = picture();
        other.image.color.data_mut()[99] = [1.0; 3];
        assert!(Agreement::of(&other, &picture()).unwrap().mismatches() > 0);
    }
}
