//! Rectangles of an image, and how they are coded.

use crate::depth::nodes::Function;
use crate::depth::predictive::modes::BlockCoding;

#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Writing {
    /// A node with a modelling function, or a BC4w block.
    Function(Function),
    OneValue,
    /// Plain values of a unit, a box or a block tile, or a keyframe stored as samples.
    Values,
    /// Blocks of a texture format.
    Blocks,
    /// Interpolation between two keyframes.
    Blend,
    /// A transform block of colour.
    Transform,
    /// A palette block of colour.
    Palette,
    /// A block of predictive coding.
    Predicted(BlockCoding),
}

/// A rectangle of pixels with the same coding.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Patch {
    /// Left, top, width and height in the image.
    pub rect: [u32; 4],
    pub writing: Writing,
    /// Index, counted from 0 in the frame, of the node, box or unit that the patch belongs to. A box or unit of block tiles has
    /// several patches, and a function of the intermediate form has one per leaf.
    pub part: u32,
}

impl Patch {
    pub fn pixels(&self) -> u64 {
        u64::from(self.rect[2]) * u64::from(self.rect[3])
    }
}
