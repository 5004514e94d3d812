//! Divides the frames of a unit into chunks, each of which starts with a keyframe.

use crate::container::EncodedChunk;
use crate::depth::record_table::TableBuilder;
use crate::error::Result;

/// Returns the size in bytes at which the chunk of a unit is closed early. A keyframe is a small part of it, and memory is
/// limited for every keyframe interval.
pub fn close_at_bytes(pixels: usize) -> usize {
    (16 * pixels).max(256 << 10)
}

#[derive(Debug)]
pub struct OpenChunk {
    keyframe_interval: u32,
    records: TableBuilder,
    first_frame: u32,
    next_frame: u32,
}

impl OpenChunk {
    pub fn new(keyframe_interval: u32) -> OpenChunk {
        OpenChunk { keyframe_interval, records: TableBuilder::default(), first_frame: 0, next_frame: 0 }
    }

    /// Counts the next frame, of `pixels` pixels. Returns the previous chunk if this frame starts a new one.
    pub fn count_frame(&mut self, pixels: usize) -> Result<Option<EncodedChunk>> {
        let is_full = self.frame_count() >= self.keyframe_interval || self.records.bytes() >= close_at_bytes(pixels);
        let finished = if is_full { self.finish()? } else { None };
        self.next_frame += 1;
        Ok(finished)
    }

    fn frame_count(&self) -> u32 {
        self.next_frame - self.first_frame
    }

    /// Returns the number of the last counted frame, from 0 at the keyframe.
    pub fn frame(&self) -> u32 {
        self.frame_count() - 1
    }

    pub fn records(&mut self) -> &mut TableBuilder {
        &mut self.records
    }

    pub fn record(&mut self) -> &mut Vec<u8> {
        self.records.begin(self.next_frame - 1 - self.first_frame)
    }

    pub fn finish(&mut self) -> Result<Option<EncodedChunk>> {
        let (first_frame, frame_count) = (self.first_frame, self.frame_count());
        self.first_frame = self.next_frame;
        let records = std::mem::take(&mut self.records);
        if frame_count == 0 {
            return Ok(None);
        }
        Ok(Some(EncodedChunk { first_frame, frame_count, payload: records.finish()? }))
    }
}
