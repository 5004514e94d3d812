//! The four texels around a position in an image.

use crate::views::FaceTexels;

/// Four texels around a position in an image, with the weights of bilinear interpolation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Taps {
    /// Indices into the image.
    pub texels: [usize; 4],
    /// Sum to 1.
    pub weights: [f32; 4],
}

impl Taps {
    /// Returns the texels around a position, clamped to the image.
    pub fn around(at: [f32; 2], face: &FaceTexels) -> Taps {
        let [x, y] = at.map(|at| at - 0.5);
        let (left, top) = (x.floor(), y.floor());
        let (across, down) = (x - left, y - top);
        let clamp = |at: f32, size: u32| at.clamp(0.0, size.saturating_sub(1) as f32) as usize;
        let columns = [clamp(left, face.size[0]), clamp(left + 1.0, face.size[0])];
        let rows = [clamp(top, face.size[1]), clamp(top + 1.0, face.size[1])].map(|row| row * face.size[0] as usize);
        Taps {
            texels: [rows[0] + columns[0], rows[0] + columns[1], rows[1] + columns[0], rows[1] + columns[1]],
            weights: [(1.0 - across) * (1.0 - down), across * (1.0 - down), (1.0 - across) * down, across * down],
        }
    }
}
