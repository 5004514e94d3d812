//! Result of drawing a picture.

use glam::Vec4;

use codec::error::Result;
use render::rendered_image::RenderedImage;

/// Pixels of a picture, and counts of triangles.
#[derive(Debug, Clone, PartialEq)]
pub struct Drawn {
    /// Linear RGB multiplied by alpha, and alpha: means over the samples of a pixel.
    pub pixels: Vec<[f32; 4]>,
    /// Total number of triangles over all samples, visible or not.
    pub fragments: u64,
    /// Maximum number of triangles over a sample.
    pub max_fragments: u32,
}

impl Drawn {
    pub(super) fn of_rows(rows: Vec<(Vec<Vec4>, Vec<u32>)>) -> Drawn {
        let counts = || rows.iter().flat_map(|(_, counts)| counts);
        Drawn {
            fragments: counts().map(|&count| u64::from(count)).sum(),
            max_fragments: counts().copied().max().unwrap_or(0),
            pixels: rows.iter().flat_map(|(pixels, _)| pixels.iter().map(|pixel| pixel.to_array())).collect(),
        }
    }

    /// Returns the picture with straight colour, not multiplied by alpha.
    pub fn image(&self, size: [u32; 2]) -> Result<RenderedImage> {
        let straight = |&[r, g, b, alpha]: &[f32; 4]| {
            let factor = if alpha > 0.0 { alpha.recip() } else { 0.0 };
            [r * factor, g * factor, b * factor, alpha]
        };
        RenderedImage::of_pixels(size, self.pixels.iter().map(straight))
    }

    /// Returns the picture over black, as used in comparisons.
    pub fn over_black(&self, size: [u32; 2]) -> Result<RenderedImage> {
        RenderedImage::of_pixels(size, self.pixels.iter().copied())
    }
}
