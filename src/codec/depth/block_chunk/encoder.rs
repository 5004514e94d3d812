//! Encodes units as plain BC4w blocks (depth.md 12).

use crate::container::EncodedChunk;
use crate::depth::bc4w::search;
use crate::depth::block::{Accuracy, Block};
use crate::depth::block_chunk::{LEVEL, corners};
use crate::depth::nodes::Grid;
use crate::effort::Effort;

/// Size in bytes at which a chunk is closed early, so that it can be stored for any keyframe interval.
const CLOSE_AT_BYTES: usize = 256 << 20;

/// Appends the blocks of a picture; returns the accuracy of each block, row by row.
pub fn encode_picture(picture: &[u16], grid: Grid, effort: Effort, out: &mut Vec<u8>) -> Vec<Accuracy> {
    let encode = |place| {
        let (block, accuracy) = search::encode(&Block::of(picture, grid.width as usize, LEVEL, place), effort);
        out.extend_from_slice(block.as_bytes());
        accuracy
    };
    corners(grid).map(encode).collect()
}

#[derive(Debug)]
pub struct BlockEncoder {
    grid: Grid,
    effort: Effort,
    keyframe_interval: u32,
    open: Vec<u8>,
    chunk_first: u32,
    next_frame: u32,
}

impl BlockEncoder {
    pub fn new(grid: Grid, effort: Effort, keyframe_interval: u32) -> BlockEncoder {
        BlockEncoder { grid, effort, keyframe_interval, open: Vec::new(), chunk_first: 0, next_frame: 0 }
    }

    pub fn push(&mut self, source: &[u16]) -> Option<EncodedChunk> {
        let full = self.next_frame - self.chunk_first >= self.keyframe_interval || self.open.len() >= CLOSE_AT_BYTES;
        let finished = if full { self.finish() } else { None };
        encode_picture(source, self.grid, self.effort, &mut self.open);
        self.next_frame += 1;
        finished
    }

    pub fn finish(&mut self) -> Option<EncodedChunk> {
        let (first_frame, frame_count) = (self.chunk_first, self.next_frame - self.chunk_first);
        self.chunk_first = self.next_frame;
        let payload = std::mem::take(&mut self.open);
        (frame_count > 0).then_some(EncodedChunk { first_frame, frame_count, payload })
    }
}
