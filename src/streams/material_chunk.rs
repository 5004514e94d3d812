//! A material chunk of either codec.

use crate::container::Payload;
use crate::depth::block_tiles::BlockTiles;
use crate::depth::records::TemporalChunk;
use crate::depth::window_check::check_window;
use crate::error::Result;
use crate::streams::header::MaterialHeader;
use crate::streams::picture_chunk::PictureChunk;

#[derive(Debug, Clone)]
pub enum MaterialChunk {
    Boxes(TemporalChunk<[u8; 3]>),
    BoxesInBlocks(TemporalChunk<[u8; 3], BlockTiles>),
}

impl PictureChunk for MaterialChunk {
    type Pixel = [u8; 3];
    type Header = MaterialHeader;

    fn parse(header: &MaterialHeader, payload: Payload, size: [u32; 2], frames: u32) -> Result<MaterialChunk> {
        Ok(if header.in_blocks {
            MaterialChunk::BoxesInBlocks(TemporalChunk::parse(payload, size, frames)?)
        } else {
            MaterialChunk::Boxes(TemporalChunk::parse(payload, size, frames)?)
        })
    }

    fn advance(&self, picture: &mut [[u8; 3]], at: Option<u32>, target: u32, window: u8) -> u64 {
        match self {
            MaterialChunk::Boxes(chunk) => chunk.advance(picture, at, target, window),
            MaterialChunk::BoxesInBlocks(chunk) => chunk.advance(picture, at, target, window),
        }
    }

    fn check_window(&self, window: u8, frames: u32) -> Result<()> {
        match self {
            MaterialChunk::Boxes(chunk) => check_window(chunk, window, frames),
            MaterialChunk::BoxesInBlocks(chunk) => check_window(chunk, window, frames),
        }
    }

    fn into_spare(self) -> Vec<u8> {
        match self {
            MaterialChunk::Boxes(chunk) => chunk.into_spare(),
            MaterialChunk::BoxesInBlocks(chunk) => chunk.into_spare(),
        }
    }
}
