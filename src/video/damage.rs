//! What is damaged in a container, and which images are not to be had because of it.

use crate::container::ChunkEntry;
use crate::error::Error;
use crate::image::sequence::FrameRange;

/// A chunk that cannot be decoded.
#[derive(Debug, Clone, PartialEq)]
pub struct DamagedChunk {
    /// Its row of the chunk table.
    pub chunk: ChunkEntry,
    /// What is wrong with it, without a word about where.
    pub reason: String,
}

impl DamagedChunk {
    /// A chunk and what reading it came to.
    pub fn new(chunk: &ChunkEntry, error: &Error) -> DamagedChunk {
        let reason = match error {
            Error::Io { source, .. } => source.to_string(),
            other => other.to_string(),
        };
        DamagedChunk { chunk: *chunk, reason }
    }

    /// The frames that it holds.
    pub fn frames(&self) -> FrameRange {
        let key = self.chunk.key;
        FrameRange { first: key.first_frame, last: key.first_frame + (key.frame_count - 1) }
    }
}

/// Images of one stream that damaged chunks are needed for.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MissingImages {
    /// Index of the stream.
    pub stream: u32,
    /// The frames, in order; no two ranges touch.
    pub frames: Vec<FrameRange>,
}

impl MissingImages {
    /// Frames of a stream, in any order and also more than once; none where there are no frames.
    pub fn new(stream: u32, mut frames: Vec<u32>) -> Option<MissingImages> {
        frames.sort_unstable();
        frames.dedup();
        let mut ranges: Vec<FrameRange> = Vec::new();
        for frame in frames {
            match ranges.last_mut() {
                Some(range) if range.last + 1 == frame => range.last = frame,
                _ => ranges.push(FrameRange { first: frame, last: frame }),
            }
        }
        (!ranges.is_empty()).then_some(MissingImages { stream, frames: ranges })
    }

    /// How many images.
    pub fn count(&self) -> u64 {
        self.frames.iter().map(|range| range.count()).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_become_ranges() {
        let missing = MissingImages::new(4, vec![9, 3, 4, 5, 3, 7]).unwrap();
        let range = |first, last| FrameRange { first, last };
        assert_eq!(missing.frames, [range(3, 5), range(7, 7), range(9, 9)]);
        assert_eq!((missing.stream, missing.count()), (4, 5));
        assert_eq!(MissingImages::new(4, vec![]), None);
    }
}
