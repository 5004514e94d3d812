//! Position of a unit in its image (depth.md 15.3).

/// Rectangle of a unit and size of its image.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct UnitArea {
    /// Left, top, width and height in pixels.
    pub rect: [u32; 4],
    /// Width and height of the image.
    pub image: [u32; 2],
}

impl UnitArea {
    /// Returns the area of a unit that is its whole image.
    pub fn whole(size: [u32; 2]) -> UnitArea {
        UnitArea { rect: [0, 0, size[0], size[1]], image: size }
    }

    pub fn size(&self) -> [u32; 2] {
        [self.rect[2], self.rect[3]]
    }
}
