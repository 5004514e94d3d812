//! What one chunk holds and changes, frame by frame: keyframes, boxes, pixels, bytes.

use crate::color::blend::Sample;
use crate::color::cells::{CellChunk, CellFormat};
use crate::container::ChunkPlace;
use crate::depth::block_chunk::BlockChunk;
use crate::depth::block_tiles::{BlockTexel, BlockTileCount, BlockTiles};
use crate::depth::mode_statistics::ModeStatistics;
use crate::depth::node_chunk::{NodeChunk, NodeRecord};
use crate::depth::records::{Body, Layout, Record, TemporalChunk};
use crate::depth::texel::Texel;
use crate::depth::tree_chunk::TreeChunk;
use crate::error::Result;
use crate::streams::{CodecHeader, ColorFormat, ColorHeader, DepthChunk, MaterialChunk, PictureChunk};

/// What becomes of damaged chunks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Check {
    /// The first one is an error.
    #[default]
    StopAtFirst,
    /// All are listed. Two independent decoders must agree on chunks of LZMA2, and chunks must keep the window rule (depth.md 4).
    ListAll,
}

/// What a frame holds and changes.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct FrameCost {
    /// Units that have a keyframe here.
    pub keyframe_units: u64,
    /// Boxes.
    pub aabbs: u64,
    /// Nodes of a quadtree, and BC4w blocks.
    pub nodes: u64,
    /// Pixels written.
    pub updated_pixels: u64,
    /// Payload of the frame's keyframes, records and weights, before LZMA2, counted for every chunk.
    pub bytes: u64,
}

impl FrameCost {
    pub(super) fn add(&mut self, other: FrameCost) {
        self.keyframe_units += other.keyframe_units;
        self.aabbs += other.aabbs;
        self.nodes += other.nodes;
        self.updated_pixels += other.updated_pixels;
        self.bytes += other.bytes;
    }
}

/// Keyframes of colour, and pieces of depth or material, by how they are stored.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct BlockCount {
    /// Keyframes of colour.
    pub keyframes: BlockTileCount,
    /// Pieces of whole units and of boxes.
    pub pieces: BlockTileCount,
}

impl BlockCount {
    /// Adds another count.
    pub fn add(&mut self, other: BlockCount) {
        self.keyframes.add(other.keyframes);
        self.pieces.add(other.pieces);
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
    /// Nodes of all frames.
    pub census: ModeStatistics,
    /// What is in blocks, in codecs that have them.
    pub blocks: BlockCount,
}

/// Parses and counts a payload, which stands at `place` in its unit of `size` (width, height) pixels.
pub(super) fn count_chunk(
    header: &CodecHeader,
    payload: Vec<u8>,
    size: [u32; 2],
    frames: u32,
    place: ChunkPlace,
    check: Check,
) -> Result<ChunkMeasure> {
    let pixels = u64::from(size[0]) * u64::from(size[1]);
    Ok(match header {
        CodecHeader::Depth(header) => {
            let chunk = DepthChunk::parse(header, payload.into(), size, frames)?;
            if check == Check::ListAll {
                chunk.check_window(header.window(), frames)?;
            }
            match chunk {
                DepthChunk::Boxes(chunk) => count_records(&chunk),
                DepthChunk::BoxesInBlocks(chunk) => count_pieces(&chunk),
                DepthChunk::Nodes(chunk) => count_nodes(&chunk),
                DepthChunk::Tree(chunk) => count_tree(&chunk),
                DepthChunk::Blocks(chunk) => count_blocks(&chunk, pixels, frames),
            }
        }
        CodecHeader::Material(header) => {
            let chunk = MaterialChunk::parse(header, payload.into(), size, frames)?;
            if check == Check::ListAll {
                chunk.check_window(header.temporal.window, frames)?;
            }
            match chunk {
                MaterialChunk::Boxes(chunk) => count_records(&chunk),
                MaterialChunk::BoxesInBlocks(chunk) => count_pieces(&chunk),
            }
        }
        CodecHeader::Color(header @ ColorHeader { format: ColorFormat::EightBit(_), .. }) => {
            let format = header.cell_of_bytes(size);
            count_blends(&CellChunk::parse_at(payload, format, frames, place)?, format, frames)
        }
        CodecHeader::Color(header) => {
            let format = header.cell_of_halves(size);
            count_blends(&CellChunk::parse_at(payload, format, frames, place)?, format, frames)
        }
    })
}

fn count_records<T: Texel, L: Layout<T>>(chunk: &TemporalChunk<T, L>) -> ChunkMeasure {
    let event = |record: &Record| Event {
        frame: record.frame,
        cost: FrameCost {
            keyframe_units: u64::from(!matches!(record.body, Body::Boxes { .. })),
            aabbs: chunk.boxes(record.body).len() as u64,
            nodes: 0,
            updated_pixels: chunk.updated_pixels(record.body),
            bytes: record.bytes,
        },
    };
    let records = chunk.records();
    ChunkMeasure {
        events: records.iter().map(event).collect(),
        constant: records.iter().all(|record| matches!(record.body, Body::Constant(_))),
        census: ModeStatistics::default(),
        blocks: BlockCount::default(),
    }
}

fn count_pieces<T: BlockTexel>(chunk: &TemporalChunk<T, BlockTiles>) -> ChunkMeasure {
    let mut measure = count_records(chunk);
    for (size, bytes) in chunk.records().iter().flat_map(|record| chunk.rectangles(record.body)) {
        measure.blocks.pieces.add(BlockTileCount::of_rectangle(bytes, size));
    }
    measure
}

fn count_nodes(chunk: &NodeChunk) -> ChunkMeasure {
    let event = |record: NodeRecord| Event {
        frame: record.frame,
        cost: FrameCost {
            keyframe_units: u64::from(record.complete),
            aabbs: 0,
            nodes: record.nodes,
            updated_pixels: record.updated_pixels,
            bytes: record.bytes,
        },
    };
    ChunkMeasure {
        events: chunk.records().map(event).collect(),
        constant: chunk.is_constant(),
        census: chunk.mode_statistics(),
        blocks: BlockCount::default(),
    }
}

fn count_tree(chunk: &TreeChunk) -> ChunkMeasure {
    let event = |(at, record): (usize, NodeRecord)| Event {
        frame: record.frame,
        cost: FrameCost {
            keyframe_units: u64::from(at == 0),
            aabbs: 0,
            nodes: record.nodes,
            updated_pixels: record.updated_pixels,
            bytes: record.bytes,
        },
    };
    let events = chunk.records().enumerate().map(event).collect();
    ChunkMeasure { events, constant: false, census: chunk.mode_statistics(), blocks: BlockCount::default() }
}

fn count_blocks(chunk: &BlockChunk, pixels: u64, frame_count: u32) -> ChunkMeasure {
    let census = chunk.mode_statistics();
    let nodes = chunk.blocks_of_frame();
    let cost = FrameCost { keyframe_units: 1, aabbs: 0, nodes, updated_pixels: pixels, bytes: 32 * nodes };
    let events = (0..frame_count).map(|frame| Event { frame, cost }).collect();
    ChunkMeasure { events, constant: false, census, blocks: BlockCount::default() }
}

fn count_blends<S: Sample>(chunk: &CellChunk<S>, format: CellFormat<S>, frame_count: u32) -> ChunkMeasure {
    // Behind the weights nothing changes but at keyframes.
    let mut frames: Vec<u32> = (0..frame_count.min(chunk.weight_count().saturating_add(1))).collect();
    frames.extend_from_slice(chunk.keyframes());
    frames.sort_unstable();
    frames.dedup();
    let mut measure = ChunkMeasure {
        events: Vec::with_capacity(frames.len()),
        constant: false,
        census: ModeStatistics::default(),
        blocks: BlockCount::default(),
    };
    if format.blocks.is_some() {
        let in_blocks = (0..chunk.keyframes().len()).filter(|&at| chunk.in_blocks(at)).count() as u64;
        measure.blocks.keyframes =
            BlockTileCount { blocks: in_blocks, raw: chunk.keyframes().len() as u64 - in_blocks };
    }
    let mut shown = None;
    for frame in frames {
        let blend = chunk.blend(frame);
        let keyframe = shown.is_none_or(|(keyframe, _)| keyframe != blend.keyframe);
        let written = shown.replace((blend.keyframe, blend.weight)) != Some((blend.keyframe, blend.weight));
        let weight_bytes = u64::from(frame < chunk.weight_count());
        measure.events.push(Event {
            frame,
            cost: FrameCost {
                keyframe_units: u64::from(keyframe),
                aabbs: 0,
                nodes: 0,
                updated_pixels: if written { format.pixels() as u64 } else { 0 },
                bytes: weight_bytes + if keyframe { chunk.keyframe_bytes(blend.keyframe) } else { 0 },
            },
        });
    }
    measure
}
