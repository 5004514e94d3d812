//! A parsed chunk of any stream.

use crate::color::{ColorChunk, HalfKey};
use crate::container::{ChunkEntry, Index, Payload};
use crate::depth::TemporalChunk;
use crate::depth::predictive::PredictiveChunk;
use crate::error::Result;
use crate::streams::depth_chunk::DepthChunk;
use crate::streams::header::{CodecHeader, ColorFormat, ColorHeader};
use crate::streams::info::StreamInfo;
use crate::streams::picture_chunk::PictureChunk;

#[derive(Debug)]
pub enum StreamChunk {
    Depth(DepthChunk),
    Material(TemporalChunk<[u8; 3]>),
    Alpha(Box<PredictiveChunk>),
    Color8(ColorChunk<u8>),
    ColorHalf(ColorChunk<HalfKey>),
}

impl StreamChunk {
    pub fn parse(stream: &StreamInfo, index: &Index, chunk: &ChunkEntry, payload: Payload) -> Result<StreamChunk> {
        let (area, frames) = (stream.unit_area(chunk.key.unit), chunk.key.frame_count);
        let size = area.size();
        Ok(match &stream.header {
            CodecHeader::Depth(header) => StreamChunk::Depth(DepthChunk::parse(header, payload, area, frames)?),
            CodecHeader::Material(header) => StreamChunk::Material(PictureChunk::parse(header, payload, area, frames)?),
            CodecHeader::Alpha(header) => {
                StreamChunk::Alpha(Box::new(PictureChunk::parse(header, payload, area, frames)?))
            }
            CodecHeader::Color(header @ ColorHeader { format: ColorFormat::EightBit(_), .. }) => {
                StreamChunk::Color8(header.chunks_of_bytes(size).parse(payload, frames, index.place(chunk))?)
            }
            CodecHeader::Color(header) => {
                StreamChunk::ColorHalf(header.chunks_of_halves(size).parse(payload, frames, index.place(chunk))?)
            }
        })
    }

    pub fn check_window(&self, stream: &StreamInfo, frames: u32) -> Result<()> {
        match (self, &stream.header) {
            (StreamChunk::Depth(chunk), CodecHeader::Depth(header)) => chunk.check_window(header.window(), frames),
            (StreamChunk::Material(chunk), CodecHeader::Material(header)) => {
                chunk.check_window(header.temporal.window, frames)
            }
            (StreamChunk::Alpha(chunk), _) => chunk.check(),
            _ => Ok(()),
        }
    }
}
