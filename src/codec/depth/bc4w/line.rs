//! Lines of a BC4w block, and the sides into which they divide its 64 pixels (depth.md 8).
//!
//! Bit 8y + x of a mask is pixel (x, y).

use std::sync::LazyLock;

/// A line through two pixels, in 12 bits: x0, y0, x1, y1 from the lowest bit on, three bits each.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Line(u16);

static SIDES: LazyLock<Vec<u64>> = LazyLock::new(|| (0..4096).map(|bits| Line(bits).by_cross_product()).collect());

impl Line {
    /// The line that does not divide the block: all pixels are on side A.
    pub const NONE: Line = Line(0);

    pub fn from_bits(bits: u16) -> Line {
        Line(bits & 0xfff)
    }

    pub fn bits(self) -> u16 {
        self.0
    }

    pub fn points(self) -> [[u8; 2]; 2] {
        let at = |shift: u32| (self.0 >> shift & 7) as u8;
        [[at(0), at(3)], [at(6), at(9)]]
    }

    pub fn side_b(self) -> u64 {
        SIDES[usize::from(self.0)]
    }

    /// Returns the mask of side B: the pixels with (x1 − x0)(y − y0) − (y1 − y0)(x − x0) > 0. The two points themselves are on
    /// side A.
    fn by_cross_product(self) -> u64 {
        let [[x0, y0], [x1, y1]] = self.points().map(|point| point.map(i32::from));
        (0..64).fold(0, |mask, pixel| {
            let (x, y) = (pixel & 7, pixel >> 3);
            let cross = (x1 - x0) * (y - y0) - (y1 - y0) * (x - x0);
            mask | u64::from(cross > 0) << pixel
        })
    }
}
