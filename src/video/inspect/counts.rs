//! What one chunk holds and changes, frame by frame: keyframes, boxes, pixels, bytes.

use crate::color::blend::{HalfKey, Sample};
use crate::color::cells::CellChunk;
use crate::depth::records::{Body, TemporalChunk};
use crate::depth::texel::Texel;
use crate::error::Result;
use crate::video::codec::{CodecHeader, ColorFormat, ColorHeader};

/// What a frame holds and changes.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct FrameCost {
    /// Units that have a keyframe here.
    pub keyframe_units: u64,
    /// Boxes.
    pub aabbs: u64,
    /// Pixels written.
    pub updated_pixels: u64,
    /// Payload of the frame's keyframes, records and weights, before LZMA2, counted for every chunk.
    pub bytes: u64,
}

impl FrameCost {
    pub(super) fn add(&mut self, other: FrameCost) {
        self.keyframe_units += other.keyframe_units;
        self.aabbs += other.aabbs;
        self.updated_pixels += other.updated_pixels;
        self.bytes += other.bytes;
    }
}

/// What a chunk holds at one of its frames.
#[derive(Debug, Clone, Copy)]
pub(super) struct Event {
    /// The frame, counted as streams count.
    pub frame: u32,
    /// What it holds and changes.
    pub cost: FrameCost,
}

/// A parsed chunk, counted.
pub(super) struct ChunkMeasure {
    /// By frame, at least one.
    pub events: Vec<Event>,
    /// Every record fills the unit with one value.
    pub constant: bool,
    /// The last frames need the next chunk's first keyframe.
    pub leads_on: bool,
}

/// Parses and counts a payload of a unit of `size` (width, height) pixels.
pub(super) fn count_chunk(header: &CodecHeader, payload: Vec<u8>, size: [u32; 2], frames: u32) -> Result<ChunkMeasure> {
    let pixels = size[0] as usize * size[1] as usize;
    Ok(match header {
        CodecHeader::Depth(_) => count_records(&TemporalChunk::<u16>::parse(payload, size, frames)?),
        CodecHeader::Material(_) => count_records(&TemporalChunk::<[u8; 3]>::parse(payload, size, frames)?),
        CodecHeader::Color(ColorHeader { format: ColorFormat::EightBit(_), .. }) => {
            count_blends(&CellChunk::<u8>::parse(payload, pixels, frames)?, pixels, frames)
        }
        CodecHeader::Color(_) => count_blends(&CellChunk::<HalfKey>::parse(payload, pixels, frames)?, pixels, frames),
    })
}

fn count_records<T: Texel>(chunk: &TemporalChunk<T>) -> ChunkMeasure {
    let event = |frame: u32, body: Body| Event {
        frame,
        cost: FrameCost {
            keyframe_units: u64::from(!matches!(body, Body::Boxes { .. })),
            aabbs: chunk.boxes(body).len() as u64,
            updated_pixels: chunk.updated_pixels(body),
            bytes: chunk.record_bytes(body),
        },
    };
    let records = chunk.records();
    ChunkMeasure {
        events: records.iter().map(|record| event(record.frame, record.body)).collect(),
        constant: records.iter().all(|record| matches!(record.body, Body::Constant(_))),
        leads_on: false,
    }
}

fn count_blends<S: Sample>(chunk: &CellChunk<S>, pixels: usize, frame_count: u32) -> ChunkMeasure {
    // Behind the weights nothing changes but at keyframes.
    let mut frames: Vec<u32> = (0..frame_count.min(chunk.weight_count().saturating_add(1))).collect();
    frames.extend_from_slice(chunk.keyframes());
    frames.sort_unstable();
    frames.dedup();
    let mut measure = ChunkMeasure { events: Vec::with_capacity(frames.len()), constant: false, leads_on: false };
    let mut shown = None;
    for frame in frames {
        let blend = chunk.blend(frame);
        let keyframe = shown.is_none_or(|(keyframe, _)| keyframe != blend.keyframe);
        let written = shown.replace((blend.keyframe, blend.weight)) != Some((blend.keyframe, blend.weight));
        let weight_bytes = u64::from(frame < chunk.weight_count());
        measure.leads_on |= blend.weight != 0 && chunk.is_last(blend.keyframe);
        measure.events.push(Event {
            frame,
            cost: FrameCost {
                keyframe_units: u64::from(keyframe),
                aabbs: 0,
                updated_pixels: if written { pixels as u64 } else { 0 },
                bytes: weight_bytes + if keyframe { chunk.keyframe_bytes() } else { 0 },
            },
        });
    }
    measure
}
