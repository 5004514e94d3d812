//! Frame numbers, and file names that carry them.

use std::fmt;

/// Frames `first..=last`. Never empty.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct FrameRange {
    /// First frame.
    pub first: u32,
    /// Last frame, inclusive, not below `first`.
    pub last: u32,
}

impl FrameRange {
    /// Number of frames, at least 1 (u64: the range 0..=u32::MAX has 2^32).
    pub fn count(self) -> u64 {
        u64::from(self.last) - u64::from(self.first) + 1
    }

    /// Whether `frame` lies inside.
    pub fn contains(self, frame: u32) -> bool {
        (self.first..=self.last).contains(&frame)
    }

    /// The frames that both have, if any.
    pub fn intersect(self, other: FrameRange) -> Option<FrameRange> {
        let first = self.first.max(other.first);
        let last = self.last.min(other.last);
        (first <= last).then_some(FrameRange { first, last })
    }

    /// All frames in order.
    pub fn iter(self) -> impl Iterator<Item = u32> {
        self.first..=self.last
    }
}

impl fmt::Display for FrameRange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}-{}", self.first, self.last)
    }
}
