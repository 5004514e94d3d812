//! Boxes of pixels that a record replaces (depth.md 4).

#[cfg(feature = "encode")]
pub mod cover;

pub const MAX_BOXES: u16 = 256;

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct PixelBox {
    pub x: u16,
    pub y: u16,
    pub width: u16,
    pub height: u16,
}

impl PixelBox {
    pub fn area(self) -> u32 {
        u32::from(self.width) * u32::from(self.height)
    }

    /// Returns left, top, width and height.
    pub fn rect(self) -> [usize; 4] {
        [self.x, self.y, self.width, self.height].map(usize::from)
    }

    pub fn overlaps(self, other: PixelBox) -> bool {
        let apart = |a: u16, a_size: u16, b: u16, b_size: u16| {
            u32::from(a) + u32::from(a_size) <= u32::from(b) || u32::from(b) + u32::from(b_size) <= u32::from(a)
        };
        !apart(self.x, self.width, other.x, other.width) && !apart(self.y, self.height, other.y, other.height)
    }
}
