//! Samples of a capture (Seurat 3): rays from inside the viewing region, with the surface that each ray meets and its colour.
//!
//! Takes the rays of the images of a capture, one image at a time, and returns samples relative to the centre of the region.

use glam::DVec3;

use super::capture::{Capture, ImageRays};
use super::image_measures::{borders, contrasts};
use super::region::ViewingRegion;
use codec::error::{Error, Result};
use codec::monitor::Monitor;
use footage::dataset::seurat::CaptureRay;

/// A ray: its origin and its end, relative to the centre of the region in metres, and linear RGB.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// Index of the pixel, in row-major order.
    pub pixel: u32,
    pub origin: DVec3,
    pub end: DVec3,
    pub color: [f32; 3],
    /// True if there is a surface at the end. A ray to a transparent background only determines which space is empty.
    pub is_surface: bool,
    /// Weight of the colour: below 1 where the pixel shows more than one surface.
    pub weight: f32,
}

/// Weight of the colour of pixels at the border of a surface. They decide only where no other pixel does; else what is bright leaves
/// sparkles on surfaces behind it.
const BORDER_WEIGHT: f32 = 1e-3;

/// Standard deviation, in degrees, of the angle to rays from the centre in the weights of [`BakedLight::Center`].
const DIRECTION_DEVIATION_DEG: f64 = 5.0;
/// Least weight of the colour of a direction, which is more than that of border pixels.
const MIN_DIRECTION_WEIGHT: f64 = 0.01;

/// Meaning of pixels at infinite distance.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Background {
    /// A surface on a cube around the region.
    #[default]
    Sky,
    /// No surface.
    Transparent,
}

/// Treatment of samples in the viewing region.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Inside {
    /// They are an error.
    #[default]
    Refuse,
    /// They are left out and counted.
    Drop,
}

/// Light that is baked into textures where cameras see different light of the same place.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum BakedLight {
    /// Mean of all cameras.
    #[default]
    Mean,
    /// That towards the centre of the region: cameras weigh less the more their rays turn away from those of the centre.
    Center,
}

impl BakedLight {
    /// Returns the weight of a sample.
    fn weight(self, sample: &Sample) -> f32 {
        match self {
            BakedLight::Mean => 1.0,
            BakedLight::Center => {
                let along = sample.end - sample.origin;
                let angle = along.angle_between(sample.end);
                let turns = angle / DIRECTION_DEVIATION_DEG.to_radians();
                ((-0.5 * turns * turns).exp() + MIN_DIRECTION_WEIGHT) as f32
            }
        }
    }
}

/// Choice of the pixels of an image that are sampled.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PixelChoice<'a> {
    /// Pixels of every n-th column and row.
    Every(u32),
    /// Pixels with these row-major indices, in ascending order.
    Listed(&'a [u32]),
}

impl PixelChoice<'_> {
    fn contains(&self, [column, row]: [u32; 2], width: u32) -> bool {
        match self {
            PixelChoice::Every(step) => *step == 1 || column.is_multiple_of(*step) && row.is_multiple_of(*step),
            PixelChoice::Listed(pixels) => pixels.binary_search(&(row * width + column)).is_ok(),
        }
    }
}

/// Rules that convert rays to samples.
#[derive(Debug, Clone, Copy)]
pub struct SampleRules<'a> {
    pub region: &'a ViewingRegion,
    pub background: Background,
    pub inside: Inside,
    pub baked: BakedLight,
}

impl SampleRules<'_> {
    /// Passes the samples of each image in turn to `take`, with the number of samples left out. The next image is read in
    /// parallel.
    pub fn of_all_images(
        &self,
        capture: &mut Capture,
        pixels: PixelChoice<'_>,
        monitor: &dyn Monitor,
        mut take: impl FnMut(Vec<Sample>, u64) + Send,
    ) -> Result<()> {
        let read = |capture: &mut Capture, image| self.samples(capture, image, pixels);
        overlapped(capture, monitor, read, |(samples, left_out)| take(samples, left_out))
    }

    /// Passes the ends of the samples with surfaces of each image in turn to `take`, each with the contrast around it, and the
    /// number of samples left out.
    pub fn ends_of_all_images(
        &self,
        capture: &mut Capture,
        monitor: &dyn Monitor,
        mut take: impl FnMut(Vec<(DVec3, f32)>, u64) + Send,
    ) -> Result<()> {
        let read = |capture: &mut Capture, image: usize| {
            let rays = capture.rays(image)?;
            let contrasts = contrasts(&rays, capture.images[image].size);
            let mut ends = Vec::with_capacity(capture.images[image].pixels());
            let left_out = self.each(capture, image, rays.iter(), |sample| {
                if sample.is_surface {
                    ends.push((sample.end, contrasts[sample.pixel as usize]));
                }
            })?;
            Ok((ends, left_out))
        };
        overlapped(capture, monitor, read, |(ends, left_out)| take(ends, left_out))
    }

    /// Returns the samples of the chosen pixels of one image, in row-major order, and the number of samples left out.
    pub fn samples(&self, capture: &mut Capture, image: usize, pixels: PixelChoice<'_>) -> Result<(Vec<Sample>, u64)> {
        let rays = capture.rays(image)?;
        self.of_rays(capture, image, &rays, pixels)
    }

    /// Returns the samples of rays that have already been read; otherwise as [`Self::samples`].
    pub fn of_rays(
        &self,
        capture: &Capture,
        image: usize,
        rays: &ImageRays,
        pixels: PixelChoice<'_>,
    ) -> Result<(Vec<Sample>, u64)> {
        let size @ [width, height] = capture.images[image].size;
        let borders = borders(rays, size);
        let most = match pixels {
            PixelChoice::Every(step) => width.div_ceil(step) as usize * height.div_ceil(step) as usize,
            PixelChoice::Listed(pixels) => pixels.len(),
        };
        let mut samples = Vec::with_capacity(most);
        let wanted = rays.of_pixels(|pixel| pixels.contains(pixel, width));
        let left_out = self.each(capture, image, wanted, |sample| {
            let weight = if borders[sample.pixel as usize] { BORDER_WEIGHT } else { 1.0 };
            samples.push(Sample { weight: weight * self.baked.weight(&sample), ..sample });
        })?;
        Ok((samples, left_out))
    }

    /// Calls `take` for the sample of each ray, and returns the number of samples left out.
    fn each(
        &self,
        capture: &Capture,
        image: usize,
        rays: impl Iterator<Item = CaptureRay>,
        mut take: impl FnMut(Sample),
    ) -> Result<u64> {
        let (width, min_m) = (capture.images[image].size[0], self.region.min_m());
        let mut left_out = 0;
        // Values of the last origin, which is the only one in most images.
        let (mut eye, mut before_sky) = (DVec3::NAN, 0.0);
        for ray in rays {
            let origin = ray.origin - self.region.middle;
            if origin != eye {
                (eye, before_sky) = (origin, self.region.before_sky(origin));
            }
            // Two descriptions of one camera may differ in the last bits of 64-bit floats; single precision gives the same
            // samples for both.
            let direction = ray.direction.as_vec3().as_dvec3();
            if before_sky <= 0.0 {
                let error = Error::Usage(format!(
                    "{}: the camera is outside the sky, a cube of 400 times the size of the viewing region: set a \
                    larger `region`, or remove the camera",
                    capture.images[image].name
                ));
                return Err(capture.in_file(image, error));
            }
            let distance_m = match ray.distance_m <= before_sky {
                true => ray.distance_m,
                false => ray.distance_m.min(self.region.to_sky(origin, direction)),
            };
            let end = origin + distance_m * direction;
            if self.region.contains(end) || end.length() < min_m {
                if self.inside == Inside::Drop {
                    left_out += 1;
                    continue;
                }
                let ([column, row], metres) = (ray.pixel, ray.distance_m);
                let error = Error::Usage(format!(
                    "{}, pixel ({column}, {row}): a surface at {metres:.3} m lies in the viewing region: set a \
                    smaller `region` without surfaces, or set `inside` to drop",
                    capture.images[image].name
                ));
                return Err(capture.in_file(image, error));
            }
            take(Sample {
                pixel: ray.pixel[1] * width + ray.pixel[0],
                origin,
                end,
                color: ray.light,
                is_surface: self.background == Background::Sky || ray.distance_m.is_finite(),
                weight: 1.0,
            });
        }
        Ok(left_out)
    }
}

/// Passes the result of `read` for each image in turn to `take`. The next image is read in parallel.
fn overlapped<T: Send>(
    capture: &mut Capture,
    monitor: &dyn Monitor,
    read: impl Fn(&mut Capture, usize) -> Result<T> + Sync,
    mut take: impl FnMut(T) + Send,
) -> Result<()> {
    let mut read = |image: usize| (image < capture.images.len()).then(|| read(capture, image)).transpose();
    let (mut image, mut next) = (0, read(0)?);
    while let Some(found) = next {
        monitor.check()?;
        let ((), following) = rayon::join(|| take(found), || read(image + 1));
        monitor.advance(1);
        next = following?;
        image += 1;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn light_towards_the_centre_weighs_most_and_none_vanishes() {
        let sample = |origin: DVec3| Sample {
            pixel: 0,
            origin,
            end: DVec3::new(0.0, 0.0, -4.0),
            color: [1.0; 3],
            is_surface: true,
            weight: 1.0,
        };
        let weights = [0.0, 0.1, 0.35, 4.0].map(|x| BakedLight::Center.weight(&sample(DVec3::new(x, 0.0, 0.0))));
        assert!(weights.is_sorted_by(|a, b| a > b) && weights[3] > 2.0 * BORDER_WEIGHT, "{weights:?}");
        // 5 degrees: one standard deviation.
        assert!((weights[2] - (-0.5f32).exp() - 0.01).abs() < 1e-2, "{weights:?}");
        // Along the ray of the centre nothing changes.
        assert_eq!(BakedLight::Center.weight(&sample(DVec3::new(0.0, 0.0, -2.0))), weights[0]);
        assert_eq!(BakedLight::Mean.weight(&sample(DVec3::X)), 1.0);
    }
}
