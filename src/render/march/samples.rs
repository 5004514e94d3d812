//! Adaptive supersampling: a few rays per pixel at first, and all rays if the first ones show an edge.
//!
//! Takes the results of a pixel's rays. Returns the colour and alpha of the pixel, and whether it needs more rays.

use glam::{Vec3, Vec4};

use crate::rendered_image::HoleFill;

/// Minimum contrast of an edge: a pixel has an edge if the range of a channel over its rays exceeds this fraction of the sum of
/// the minimum and the maximum.
pub const EDGE_CONTRAST: f32 = 0.1;
/// Added to the minimum and the maximum, so that noise in dark pixels is not an edge.
pub const EDGE_BLACK: f32 = 0.02;

/// Rays of a pixel, by their row-major indices in a square grid.
#[derive(Debug, Clone)]
pub(crate) struct SampleGrid {
    /// Rays at the corners and the middle; all rays of a grid of at most two rows.
    pub(crate) first: Vec<usize>,
    pub(crate) rest: Vec<usize>,
}

impl SampleGrid {
    /// Creates a grid of `side` rows and columns, at least 1.
    pub(crate) fn new(side: usize) -> SampleGrid {
        let is_end = |at: usize| at == 0 || at + 1 == side;
        let is_first = |at: &usize| {
            let place = [at % side, at / side];
            side <= 2 || place.map(is_end) == [true; 2] || place == [side / 2; 2]
        };
        let (first, rest) = (0..side * side).partition(is_first);
        SampleGrid { first, rest }
    }
}

/// Result of one ray.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct RaySample {
    /// Linear RGB times [`RaySample::share`].
    pub(crate) light: Vec3,
    /// Fraction of the ray that has a colour.
    pub(crate) share: f32,
    /// True if the ray first meets a surface that no view saw, or ends without a known colour.
    pub(crate) is_hole: bool,
}

/// Accumulated rays of a pixel.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PixelSum {
    /// Sum of RGB and alpha.
    sum: Vec4,
    /// Minimum and maximum of RGB and alpha over the rays.
    least: Vec4,
    greatest: Vec4,
    share: f32,
    rays: u32,
    holes: u32,
}

impl Default for PixelSum {
    fn default() -> PixelSum {
        PixelSum { sum: Vec4::ZERO, least: Vec4::INFINITY, greatest: Vec4::NEG_INFINITY, share: 0.0, rays: 0, holes: 0 }
    }
}

impl PixelSum {
    pub(crate) fn add(&mut self, sample: RaySample, fill: HoleFill) {
        let RaySample { light, share, is_hole } = sample;
        self.rays += 1;
        self.holes += u32::from(is_hole);
        let (light, share) = if is_hole && fill == HoleFill::Blank { (Vec3::ZERO, 0.0) } else { (light, share) };
        let alpha = if is_hole && fill != HoleFill::Behind { 0.0 } else { share };
        let shown = light.extend(alpha);
        self.sum += shown;
        self.least = self.least.min(shown);
        self.greatest = self.greatest.max(shown);
        self.share += share;
    }

    /// True if the RGB or the alpha of the rays differ enough for an edge.
    pub(crate) fn has_edge(&self) -> bool {
        let (least, greatest) = (self.least, self.greatest);
        (greatest - least).cmpgt(EDGE_CONTRAST * (least + greatest + 2.0 * EDGE_BLACK)).any()
    }

    pub(crate) fn holes(&self) -> u32 {
        self.holes
    }

    /// Returns linear RGB, not multiplied by alpha, and alpha.
    pub(crate) fn color_and_alpha(&self) -> ([f32; 3], f32) {
        let light = self.sum.truncate();
        let color = if self.share > 0.0 { light / self.share } else { Vec3::ZERO };
        (color.to_array(), self.sum.w / self.rays.max(1) as f32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn first_rays_are_those_of_corners_and_middle() {
        for (side, first) in
            [(1, vec![0]), (2, vec![0, 1, 2, 3]), (3, vec![0, 2, 4, 6, 8]), (4, vec![0, 3, 10, 12, 15])]
        {
            let grid = SampleGrid::new(side);
            assert_eq!(grid.first, first, "{side}");
            let mut all = [grid.first, grid.rest].concat();
            all.sort_unstable();
            assert!(all.into_iter().eq(0..side * side));
        }
    }

    #[test]
    fn pixels_are_means_of_what_has_a_colour() {
        let ray = |light: f32, share: f32, is_hole| RaySample { light: Vec3::splat(share * light), share, is_hole };
        let of = |rays: &[RaySample], fill| {
            let mut sum = PixelSum::default();
            rays.iter().for_each(|&ray| sum.add(ray, fill));
            let ([red, ..], alpha) = sum.color_and_alpha();
            (red, alpha, sum.has_edge())
        };
        let (lit, half, hole) = (ray(0.5, 1.0, false), ray(0.5, 0.5, false), ray(1.0, 1.0, true));
        assert_eq!(of(&[lit, lit], HoleFill::Behind), (0.5, 1.0, false));
        assert_eq!(of(&[lit, hole], HoleFill::Behind), (0.75, 1.0, true));
        assert_eq!(of(&[lit, hole], HoleFill::Nearest), (0.75, 0.5, true));
        assert_eq!(of(&[lit, hole], HoleFill::Blank), (0.5, 0.5, true));
        // A transparent background does not change the colour.
        assert_eq!(of(&[lit, half], HoleFill::Behind), (0.5, 0.75, true));
        assert_eq!(of(&[ray(0.0, 0.0, false); 2], HoleFill::Behind), (0.0, 0.0, false));
        assert!(!of(&[lit, ray(0.55, 1.0, false)], HoleFill::Behind).2);
    }
}
