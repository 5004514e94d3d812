//! A material chunk of either codec, checked and ready to be shown.

use crate::container::Payload;
use crate::depth::pieces::Pieces;
use crate::depth::records::TemporalChunk;
use crate::error::Result;
use crate::streams::header::MaterialHeader;

/// A payload by its codec.
#[derive(Debug, Clone)]
pub enum MaterialChunk {
    /// Triples in boxes.
    Boxes(TemporalChunk<[u8; 3]>),
    /// Triples in boxes, pieces of them in BC1 blocks.
    BoxesInBlocks(TemporalChunk<[u8; 3], Pieces>),
}

impl MaterialChunk {
    /// Checks a payload for a unit of `size` (width, height) pixels and `frames` frames.
    pub fn parse(header: &MaterialHeader, payload: Payload, size: [u32; 2], frames: u32) -> Result<MaterialChunk> {
        Ok(if header.in_blocks {
            MaterialChunk::BoxesInBlocks(TemporalChunk::parse(payload, size, frames)?)
        } else {
            MaterialChunk::Boxes(TemporalChunk::parse(payload, size, frames)?)
        })
    }

    /// Brings `picture`, which shows frame `at` of this chunk (`None`: nothing yet), to frame `target` in steps of at
    /// most `window` frames; answers how many pixels were written.
    pub fn advance(&self, picture: &mut [[u8; 3]], at: Option<u32>, target: u32, window: u8) -> u64 {
        match self {
            MaterialChunk::Boxes(chunk) => chunk.advance(picture, at, target, window),
            MaterialChunk::BoxesInBlocks(chunk) => chunk.advance(picture, at, target, window),
        }
    }

    /// The payload's memory, for the next chunk.
    pub fn into_spare(self) -> Vec<u8> {
        match self {
            MaterialChunk::Boxes(chunk) => chunk.into_spare(),
            MaterialChunk::BoxesInBlocks(chunk) => chunk.into_spare(),
        }
    }
}
