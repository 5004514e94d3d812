//! Measures of the pixels of a captured image: contrast, and whether a pixel lies at the border of a surface.

use super::capture::ImageRays;

/// Contrast below which displacement counts as much as at this contrast: two codes of 8 bits in each channel.
const MIN_CONTRAST: f32 = 3.0 * (2.0 / 255.0) * (2.0 / 255.0);
/// Radius in pixels of the mean of contrasts.
const CONTRAST_RADIUS: usize = 2;
/// Relative second difference of inverse distances above which a pixel lies at the border of a surface.
const BORDER: f32 = 0.1;

/// Positions of pixels in a row-major image.
#[derive(Debug, Clone, Copy)]
struct Grid {
    width: usize,
    height: usize,
}

impl Grid {
    fn new([width, height]: [u32; 2]) -> Grid {
        Grid { width: width as usize, height: height as usize }
    }

    fn count(self) -> usize {
        self.width * self.height
    }

    /// Returns the place along an axis, the length of the axis, and the distance of neighbours along it.
    fn along(self, axis: usize, at: usize) -> (usize, usize, usize) {
        match axis {
            0 => (at % self.width, self.width, 1),
            _ => (at / self.width, self.height, self.width),
        }
    }

    /// Returns the mean of the values within [`CONTRAST_RADIUS`] of each pixel along an axis.
    fn smoothed(self, axis: usize, values: &[f32]) -> Vec<f32> {
        let mean = |at: usize| {
            let (place, length, step) = self.along(axis, at);
            let first = at - place.min(CONTRAST_RADIUS) * step;
            let last = at + (length - 1 - place).min(CONTRAST_RADIUS) * step;
            let sum: f32 = (first..=last).step_by(step).map(|at| values[at]).sum();
            sum / ((last - first) / step + 1) as f32
        };
        (0..self.count()).map(mean).collect()
    }
}

/// Returns the contrast around each pixel: the mean of the squared differences of display values between neighbours, summed over
/// the channels.
pub fn contrasts(rays: &ImageRays, size: [u32; 2]) -> Vec<f32> {
    let grid = Grid::new(size);
    let mut shown: Vec<Option<[f32; 3]>> = vec![None; grid.count()];
    for ray in rays.iter() {
        let at = ray.pixel[1] as usize * grid.width + ray.pixel[0] as usize;
        shown[at] = Some(ray.light.map(|light| light.clamp(0.0, 1.0).sqrt()));
    }
    let to_next = |axis: usize, at: usize| -> f32 {
        let (place, length, step) = grid.along(axis, at);
        if place + 1 == length {
            return 0.0;
        }
        let (Some(here), Some(next)) = (shown[at], shown[at + step]) else { return 0.0 };
        (0..3).map(|channel| (here[channel] - next[channel]).powi(2)).sum()
    };
    let squares: Vec<f32> = (0..grid.count()).map(|at| 0.5 * (to_next(0, at) + to_next(1, at))).collect();
    let smoothed = grid.smoothed(1, &grid.smoothed(0, &squares));
    smoothed.into_iter().map(|square| square.max(MIN_CONTRAST)).collect()
}

/// Returns true for each pixel at the border of a surface. Its colour is the mean of all that the pixel shows, its distance that of
/// one surface. Along a plane inverse depth is linear in pixels, so that only borders and creases have a second difference.
pub fn borders(rays: &ImageRays, size: [u32; 2]) -> Vec<bool> {
    let grid = Grid::new(size);
    let mut inverse: Vec<f32> = vec![f32::NAN; grid.count()];
    for ray in rays.iter() {
        inverse[ray.pixel[1] as usize * grid.width + ray.pixel[0] as usize] = ray.distance_m.recip() as f32;
    }
    let is_border = |at: usize| {
        [0, 1].into_iter().any(|axis| {
            let (place, length, step) = grid.along(axis, at);
            if place == 0 || place + 1 >= length {
                return false;
            }
            let (before, here, after) = (inverse[at - step], inverse[at], inverse[at + step]);
            (2.0 * here - before - after).abs() > BORDER * before.max(here).max(after)
        })
    };
    (0..grid.count()).map(is_border).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::capture::Capture;
    use crate::capture::CaptureImage;
    use footage::dataset::seurat::CaptureRay;
    use glam::DVec3;

    /// Returns rays of an 8x8 image: a floor that recedes upwards, and a post of two columns before it.
    fn floor_with_post() -> ImageRays {
        let ray = |at: u32| {
            let pixel = [at % 8, at / 8];
            let is_post = (3..5).contains(&pixel[0]);
            let distance_m = if is_post { 1.0 } else { 20.0 / (1.0 + f64::from(pixel[1])) };
            let light = [if is_post { 1.0 } else { 0.25 }; 3];
            CaptureRay { pixel, origin: DVec3::ZERO, direction: DVec3::NEG_Z, distance_m, light, alpha: 1.0 }
        };
        let image = CaptureImage { name: "a".into(), eye: DVec3::ZERO, size: [8, 8], camera: None };
        Capture::of_rays([(image, (0..64).map(ray).collect())]).rays(0).unwrap()
    }

    #[test]
    fn only_the_border_of_the_post_is_a_border() {
        let found = borders(&floor_with_post(), [8, 8]);
        for (at, is_border) in found.into_iter().enumerate() {
            // The columns on both sides of each edge, where the floor is farther away than the post.
            let expected = (2..6).contains(&(at % 8));
            assert_eq!(is_border, expected, "{at}");
        }
    }

    #[test]
    fn contrast_is_that_of_display_values_nearby() {
        let found = contrasts(&floor_with_post(), [8, 8]);
        // The difference between the display values 0.5 and 1, squared in three channels, halved for the axis without a
        // difference, in the mean over five columns of which one or two have it.
        assert!((found[0] - 0.375 / 3.0).abs() < 1e-6, "{}", found[0]);
        assert!((found[3] - 2.0 * 0.375 / 5.0).abs() < 1e-6, "{}", found[3]);
        let dark = contrasts(&floor_with_post(), [8, 8])[7];
        assert!(dark >= MIN_CONTRAST, "{dark}");
    }
}
