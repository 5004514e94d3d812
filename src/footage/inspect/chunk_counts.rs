//! Per-frame counts of one chunk: keyframes, boxes, nodes, pixels, bytes.

use codec::color::transform::region::{Content, Region};
use codec::color::transform::{Keyed, TransformChunk};
use codec::color::{CellChunk, ColorChunk, Sample};
use codec::depth::Texel;
use codec::depth::block_chunk::BlockChunk;
use codec::depth::block_tiles::{BlockTileCount, Layout};
use codec::depth::mode_statistics::ModeStatistics;
use codec::depth::node_chunk::{NodeChunk, NodeRecord};
use codec::depth::predictive::PredictiveChunk;
use codec::depth::predictive::chunk::FrameBlocks;
use codec::depth::predictive::modes::BlockCoding;
use codec::depth::records::{Body, Record, TemporalChunk};
use codec::depth::tree_chunk::TreeChunk;
use codec::error::Result;
use codec::streams::{DepthChunk, StreamChunk};

#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct FrameCost {
    pub keyframe_units: u64,
    pub aabbs: u64,
    /// Number of quadtree nodes and BC4w blocks.
    pub nodes: u64,
    pub updated_pixels: u64,
    /// Payload bytes of the keyframes, records and weights of the frame, before compression; shared chunks count each time.
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

/// Colour keyframes, and block tiles of depth or material, by storage.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct BlockCount {
    pub keyframes: BlockTileCount,
    /// Block tiles of whole units and of boxes.
    pub pieces: BlockTileCount,
}

impl BlockCount {
    pub fn add(&mut self, other: BlockCount) {
        self.keyframes.add(other.keyframes);
        self.pieces.add(other.pieces);
    }
}

/// Counts of chunks and blocks of streams of the transform codec.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct TransformCount {
    pub transform_chunks: u64,
    /// Number of chunks of keyframes and weights in a stream of the transform codec.
    pub cells_chunks: u64,
    /// Number of transform blocks of 4, 8, 16 and 32 pixels square.
    pub blocks: [u64; 4],
    pub palette_blocks: u64,
}

impl TransformCount {
    pub fn add(&mut self, other: TransformCount) {
        self.transform_chunks += other.transform_chunks;
        self.cells_chunks += other.cells_chunks;
        self.palette_blocks += other.palette_blocks;
        self.blocks.iter_mut().zip(other.blocks).for_each(|(sum, blocks)| *sum += blocks);
    }
}

/// Counts of predictive blocks with one [`BlockCoding`].
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct PredictedShare {
    pub blocks: u64,
    pub pixels: u64,
    /// Bits of the symbols of these blocks.
    pub bits: f64,
}

/// Predictive blocks of all frames, in the order of [`BlockCoding::ALL`]. Frames coded as equal to the previous one have no
/// blocks.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct PredictiveCount {
    shares: [PredictedShare; BlockCoding::ALL.len()],
}

impl PredictiveCount {
    pub fn share(&self, coding: BlockCoding) -> PredictedShare {
        self.shares[coding as usize]
    }

    pub fn add(&mut self, other: &PredictiveCount) {
        for (share, other) in self.shares.iter_mut().zip(&other.shares) {
            share.blocks += other.blocks;
            share.pixels += other.pixels;
            share.bits += other.bits;
        }
    }

    fn add_frame(&mut self, frame: &FrameBlocks<'_>) {
        for block in &frame.blocks {
            let share = &mut self.shares[block.coding as usize];
            share.blocks += 1;
            share.pixels += (block.area.width * block.area.height) as u64;
            share.bits += block.bits;
        }
    }
}

#[derive(Debug, Clone, Copy)]
pub(super) struct Event {
    /// Frame number relative to the first frame of the chunk; [`crate::inspect::inspect`] adds the number of that frame.
    pub frame: u32,
    pub cost: FrameCost,
}

#[derive(Default)]
pub(super) struct ChunkMeasure {
    pub events: Vec<Event>,
    /// True if every record fills the unit with one value.
    pub constant: bool,
    pub modes: ModeStatistics,
    pub blocks: BlockCount,
    pub transform: TransformCount,
    pub predictive: PredictiveCount,
}

pub(super) fn count_chunk(chunk: &StreamChunk, pixels: u64, frames: u32) -> Result<ChunkMeasure> {
    Ok(match chunk {
        StreamChunk::Depth(DepthChunk::Boxes(chunk)) => count_records(chunk),
        StreamChunk::Depth(DepthChunk::Nodes(chunk)) => count_nodes(chunk),
        StreamChunk::Depth(DepthChunk::Tree(chunk)) => count_tree(chunk),
        StreamChunk::Depth(DepthChunk::Blocks(chunk)) => count_blocks(chunk, pixels, frames),
        StreamChunk::Depth(DepthChunk::Predictive(chunk)) => count_predictive(chunk)?,
        StreamChunk::Material(chunk) => count_records(chunk),
        StreamChunk::Alpha(chunk) => count_predictive(chunk)?,
        StreamChunk::Color8(chunk) => count_color(chunk, frames),
        StreamChunk::ColorHalf(chunk) => count_color(chunk, frames),
    })
}

fn count_predictive(chunk: &PredictiveChunk) -> Result<ChunkMeasure> {
    let mut measure = ChunkMeasure { constant: true, ..ChunkMeasure::default() };
    let mut bytes_before = 0;
    let mut bits = 0.0;
    chunk.for_each_frame(|frame| {
        measure.predictive.add_frame(frame);
        measure.constant &= frame.picture.iter().all(|code| *code == frame.picture[0]);
        bits += frame.bits;
        // Fractions of a byte count for the frame that completes the byte; bytes of the chunk that no frame accounts for are
        // added to the first frame. The bits of a frame may be slightly negative: a word that the coder state takes in counts as
        // 16 bits, and can be worth more.
        let bytes_until = ((bits / 8.0) as u64).max(bytes_before);
        let (keyframe_units, bytes) = (u64::from(frame.frame == 0), bytes_until - bytes_before);
        let cost = FrameCost { keyframe_units, bytes, updated_pixels: frame.updated_pixels, ..FrameCost::default() };
        measure.events.push(Event { frame: frame.frame, cost });
        bytes_before = bytes_until;
        Ok(())
    })?;
    Ok(measure)
}

fn count_color<S: Keyed>(chunk: &ColorChunk<S>, frames: u32) -> ChunkMeasure {
    match chunk {
        ColorChunk::Cells(chunk) => {
            let mut measure = count_blends(chunk, frames);
            measure.transform.cells_chunks = 1;
            measure
        }
        ColorChunk::Transform(chunk) => count_transform(chunk, frames),
    }
}

/// Counts a transform chunk. All bytes count for the first frame, with which the chunk is read.
fn count_transform(chunk: &TransformChunk, frames: u32) -> ChunkMeasure {
    let mut count = TransformCount { transform_chunks: 1, ..TransformCount::default() };
    for leaf in chunk.regions().iter().flat_map(Region::leaves) {
        match leaf.content {
            Content::Transform { .. } => count.blocks[leaf.block().shape.level] += 1,
            Content::Palette(_) => count.palette_blocks += 1,
        }
    }
    let event = |frame: u32| {
        let updated_pixels = chunk.updated_pixels(frame as usize, frame.checked_sub(1).map(|before| before as usize));
        let cost = FrameCost { keyframe_units: u64::from(frame == 0), updated_pixels, ..FrameCost::default() };
        Event { frame, cost }
    };
    ChunkMeasure { events: (0..frames).map(event).collect(), transform: count, ..ChunkMeasure::default() }
}

fn count_records<T: Texel>(chunk: &TemporalChunk<T>) -> ChunkMeasure {
    let event = |record: &Record| Event {
        frame: record.frame,
        cost: FrameCost {
            keyframe_units: u64::from(!matches!(record.body, Body::Boxes { .. })),
            aabbs: chunk.boxes(record.body).len() as u64,
            updated_pixels: chunk.updated_pixels(record.body),
            bytes: record.bytes,
            ..FrameCost::default()
        },
    };
    let records = &chunk.records;
    let mut blocks = BlockCount::default();
    if chunk.layout == Layout::BlockTiles {
        for (size, bytes) in records.iter().flat_map(|record| chunk.rectangles(record.body)) {
            blocks.pieces.add(BlockTileCount::of_rectangle(bytes, size));
        }
    }
    ChunkMeasure {
        events: records.iter().map(event).collect(),
        constant: records.iter().all(|record| matches!(record.body, Body::Constant(_))),
        blocks,
        ..ChunkMeasure::default()
    }
}

fn node_event(record: &NodeRecord, is_keyframe: bool) -> Event {
    let NodeRecord { frame, updated_pixels, bytes, nodes, .. } = *record;
    Event { frame, cost: FrameCost { keyframe_units: u64::from(is_keyframe), aabbs: 0, nodes, updated_pixels, bytes } }
}

fn count_nodes(chunk: &NodeChunk) -> ChunkMeasure {
    ChunkMeasure {
        events: chunk.records.iter().map(|record| node_event(record, record.complete)).collect(),
        constant: chunk.is_constant(),
        modes: chunk.mode_statistics(),
        ..ChunkMeasure::default()
    }
}

fn count_tree(chunk: &TreeChunk) -> ChunkMeasure {
    let events = chunk.leaves.records.iter().enumerate().map(|(at, record)| node_event(record, at == 0)).collect();
    ChunkMeasure { events, modes: chunk.mode_statistics(), ..ChunkMeasure::default() }
}

fn count_blocks(chunk: &BlockChunk, pixels: u64, frame_count: u32) -> ChunkMeasure {
    let nodes = chunk.blocks_of_frame();
    let cost = FrameCost { keyframe_units: 1, aabbs: 0, nodes, updated_pixels: pixels, bytes: 32 * nodes };
    let events = (0..frame_count).map(|frame| Event { frame, cost }).collect();
    ChunkMeasure { events, modes: chunk.mode_statistics(), ..ChunkMeasure::default() }
}

fn count_blends<S: Sample>(chunk: &CellChunk<S>, frame_count: u32) -> ChunkMeasure {
    let format = &chunk.format;
    // After the last weight, only keyframes change the picture.
    let mut frames: Vec<u32> = (0..frame_count.min(chunk.weight_count().saturating_add(1))).collect();
    frames.extend_from_slice(&chunk.keyframes);
    frames.sort_unstable();
    frames.dedup();
    let mut measure = ChunkMeasure::default();
    if format.blocks.is_some() {
        let in_blocks = (0..chunk.keyframes.len()).filter(|&at| chunk.in_blocks(at)).count() as u64;
        measure.blocks.keyframes = BlockTileCount { blocks: in_blocks, raw: chunk.keyframes.len() as u64 - in_blocks };
    }
    let mut shown = None;
    for frame in frames {
        let blend = chunk.blend(frame);
        let keyframe = shown.is_none_or(|(keyframe, _)| keyframe != blend.keyframe);
        let written = shown.replace((blend.keyframe, blend.weight)) != Some((blend.keyframe, blend.weight));
        let weight_bytes = u64::from(frame < chunk.weight_count());
        let cost = FrameCost {
            keyframe_units: u64::from(keyframe),
            updated_pixels: if written { format.pixels() as u64 } else { 0 },
            bytes: weight_bytes + if keyframe { chunk.keyframe_bytes(blend.keyframe) } else { 0 },
            ..FrameCost::default()
        };
        measure.events.push(Event { frame, cost });
    }
    measure
}
