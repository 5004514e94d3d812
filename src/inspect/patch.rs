//! Rectangles of an image, and how they are coded.

use crate::depth::nodes::Function;
use crate::depth::predictive::modes::BlockCoding;

#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Writing {
    /// A node with a modelling function, or a BC4w block.
    Function(Function),
    OneValue,
    /// Values: of a unit, a box or a block tile, or a keyframe in samples.
    Values,
    /// Blocks of a texture format.
    Blocks,
    /// Between two keyframes.
    Blend,
    /// A transformed block of colour.
    Transform,
    /// A block of colour with a palette.
    Palette,
    /// A block of predictive coding.
    Predicted(BlockCoding),
}

/// A rectangle of pixels that are coded alike.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Patch {
    /// Left, top, width and height in the image.
    pub rect: [u32; 4],
    pub writing: Writing,
    /// The node, box or unit that it belongs to, counted from 0 in the frame. A box or unit of block tiles has several
    /// patches, and a function of an intermediate form one for each leaf.
    pub part: u32,
}

impl Patch {
    pub fn pixels(&self) -> u64 {
        u64::from(self.rect[2]) * u64::from(self.rect[3])
    }
}
