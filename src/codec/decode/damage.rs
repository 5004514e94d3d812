//! Damaged chunks and the images that depend on them.
//!
//! Each chunk has a CRC-32, so damage affects only the images with a tile or cell that needs the damaged chunk. With
//! [`OnDamage::KeepGoing`] an image with a damaged unit is omitted as a whole: a partly decoded image could be mistaken for
//! footage. A colour cell may need the first keyframe of the next chunk, so the frames after the last keyframe before a damaged
//! chunk are lost too. A container with a damaged index is rejected.

use crate::container::ChunkEntry;
use crate::error::Error;
use crate::image::sequence::FrameRange;

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum OnDamage {
    #[default]
    Stop,
    /// Reports damaged chunks and decodes all images that need none of them.
    KeepGoing,
}

#[derive(Debug, Clone, PartialEq)]
pub struct DamagedChunk {
    pub chunk: ChunkEntry,
    /// Error message without the names of the chunk and the file.
    pub reason: String,
}

impl DamagedChunk {
    pub fn new(chunk: &ChunkEntry, error: &Error) -> DamagedChunk {
        let reason = match error {
            Error::Io { source, .. } => source.to_string(),
            other => other.to_string(),
        };
        DamagedChunk { chunk: *chunk, reason }
    }

    pub fn frames(&self) -> FrameRange {
        FrameRange { first: self.chunk.key.first_frame, last: self.chunk.key.last_frame() }
    }
}

#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct FrameRanges {
    /// Ascending ranges, neither overlapping nor adjacent.
    ranges: Vec<FrameRange>,
}

impl FrameRanges {
    /// Appends a frame that is above all others.
    pub fn push(&mut self, frame: u32) {
        self.append(FrameRange { first: frame, last: frame });
    }

    /// Appends a range whose first frame is at least that of the last range.
    fn append(&mut self, range: FrameRange) {
        match self.ranges.last_mut() {
            Some(last) if range.first <= last.last.saturating_add(1) => last.last = last.last.max(range.last),
            _ => self.ranges.push(range),
        }
    }

    pub fn join(&mut self, other: FrameRanges) {
        if other.ranges.is_empty() {
            return;
        }
        let mut both = std::mem::take(&mut self.ranges);
        both.extend(other.ranges);
        both.sort_unstable_by_key(|range| range.first);
        both.into_iter().for_each(|range| self.append(range));
    }

    pub fn count(&self) -> u64 {
        self.ranges.iter().map(|range| range.count()).sum()
    }
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MissingImages {
    /// Index in the stream table.
    pub stream: u32,
    /// Missing frames as ascending ranges, neither overlapping nor adjacent.
    pub frames: Vec<FrameRange>,
}

impl MissingImages {
    pub fn new(stream: u32, frames: FrameRanges) -> Option<MissingImages> {
        (!frames.ranges.is_empty()).then_some(MissingImages { stream, frames: frames.ranges })
    }

    pub fn count(&self) -> u64 {
        self.frames.iter().map(|range| range.count()).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ranges(frames: &[u32]) -> FrameRanges {
        let mut ranges = FrameRanges::default();
        frames.iter().for_each(|&frame| ranges.push(frame));
        ranges
    }

    #[test]
    fn frames_become_ranges() {
        let missing = MissingImages::new(4, ranges(&[3, 4, 5, 7, 9])).unwrap();
        let range = |first, last| FrameRange { first, last };
        assert_eq!(missing.frames, [range(3, 5), range(7, 7), range(9, 9)]);
        assert_eq!((missing.stream, missing.count()), (4, 5));
        assert_eq!(MissingImages::new(4, FrameRanges::default()), None);
    }

    #[test]
    fn sets_are_joined_in_any_order() {
        // All pairs of subsets of frames 0 to 5.
        let set = |bits: u32| (0..6).filter(|frame| bits >> frame & 1 == 1).collect::<Vec<u32>>();
        for (one, other) in (0..64).flat_map(|one| (0..64).map(move |other| (one, other))) {
            let mut joined = ranges(&set(one));
            joined.join(ranges(&set(other)));
            assert_eq!(joined, ranges(&set(one | other)), "{one:b} and {other:b}");
            assert_eq!(joined.count(), u64::from((one | other).count_ones()));
        }
    }

    #[test]
    fn many_frames_in_a_row_are_one_range() {
        let mut frames = FrameRanges { ranges: vec![FrameRange { first: 0, last: u32::MAX - 2 }] };
        (u32::MAX - 1..=u32::MAX).for_each(|frame| frames.push(frame));
        frames.join(ranges(&[7, u32::MAX]));
        assert_eq!((frames.ranges.len(), frames.count()), (1, 1 << 32));
    }
}
