//! Settings of the temporal coding of boxes, which the header of a stream repeats (depth.md 3).

use crate::depth::boxes::MAX_BOXES;
use crate::error::{Error, Result};

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
