//! Boxes of pixels that a record replaces (depth.md 4), and the settings of their coding.

#[cfg(feature = "encode")]
pub mod cover;

use crate::error::{Error, Result};

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

/// Settings of the coding of boxes in time, which the header of a stream repeats (depth.md 3).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TemporalSettings {
    /// W, 1 to 255: a decoder may step over up to W − 1 frames.
    pub window: u8,
    /// Maximum difference, in codes, between a decoded pixel and its source.
    pub epsilon: u16,
    /// Maximum number of boxes in one frame of one unit, 1 to 256.
    pub max_aabbs: u16,
    pub keyframe_interval: u32,
}

impl Default for TemporalSettings {
    fn default() -> Self {
        TemporalSettings { window: 2, epsilon: 0, max_aabbs: 8, keyframe_interval: 64 }
    }
}

impl TemporalSettings {
    pub fn check(&self) -> Result<()> {
        let wrong = |what: &str| Err(Error::Usage(what.to_owned()));
        match self {
            TemporalSettings { window: 0, .. } => wrong("the depth window must be 1 to 255 frames"),
            TemporalSettings { max_aabbs, .. } if !(1..=MAX_BOXES).contains(max_aabbs) => {
                wrong("the number of boxes must be 1 to 256")
            }
            TemporalSettings { keyframe_interval: 0, .. } => wrong("the keyframe interval must be at least 1 frame"),
            _ => Ok(()),
        }
    }
}
