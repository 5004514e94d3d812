//! Images on triangles.
//!
//! Enters: texture coordinates. Leaves: linear Rec. 709 light and alpha.

use glam::{DVec2, DVec3};

/// What lies beyond the edge of an image.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Wrap {
    /// The image again.
    #[default]
    Repeat,
    /// The image mirrored, and again.
    Mirror,
    /// The pixel at the edge.
    Clamp,
}

/// An image of 8-bit sRGB codes and alpha.
#[derive(Debug, Clone)]
pub struct ImageTexture {
    /// Width in pixels, at least 1.
    pub width: u32,
    /// Height in pixels, at least 1.
    pub height: u32,
    /// Red, green, blue as sRGB codes, and alpha; row by row from the top.
    pub pixels: Vec<[u8; 4]>,
    /// Beyond the left and right, and beyond the top and bottom edge.
    pub wrap: [Wrap; 2],
}

impl ImageTexture {
    /// Colour and alpha at texture coordinates, (0, 0) the top left corner of the image.
    pub fn sample(&self, _uv: DVec2) -> (DVec3, f64) {
        (DVec3::ONE, 1.0)
    }
}
