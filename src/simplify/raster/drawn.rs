//! A picture that was drawn.

use glam::Vec4;

use crate::error::Result;
use crate::evaluate::RenderedImage;

/// What was drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct Drawn {
    /// Linear light multiplied by alpha, and alpha: means of the samples of a pixel.
    pub pixels: Vec<[f32; 4]>,
    /// Triangles over each sample, whether they show or not, in all.
    pub fragments: u64,
    /// Triangles over a sample, at most.
    pub most_fragments: u32,
}

impl Drawn {
    pub(super) fn of_rows(rows: Vec<(Vec<Vec4>, Vec<u32>)>) -> Drawn {
        let counts = || rows.iter().flat_map(|(_, counts)| counts);
        Drawn {
            fragments: counts().map(|&count| u64::from(count)).sum(),
            most_fragments: counts().copied().max().unwrap_or(0),
            pixels: rows.iter().flat_map(|(pixels, _)| pixels.iter().map(|pixel| pixel.to_array())).collect(),
        }
    }

    /// The picture; colour is not multiplied by alpha.
    pub fn image(&self, size: [u32; 2]) -> Result<RenderedImage> {
        let straight = |&[r, g, b, alpha]: &[f32; 4]| {
            let factor = if alpha > 0.0 { alpha.recip() } else { 0.0 };
            [r * factor, g * factor, b * factor, alpha]
        };
        RenderedImage::of_pixels(size, self.pixels.iter().map(straight))
    }

    /// The picture over black, as it is compared.
    pub fn over_black(&self, size: [u32; 2]) -> Result<RenderedImage> {
        RenderedImage::of_pixels(size, self.pixels.iter().copied())
    }
}
