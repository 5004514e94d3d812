//! Units of a group (tiles or cells). Each unit has an encoder that turns its rectangle of every frame into chunks.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use crate::encode::budget::ColorMemory;
use crate::encode::group::{Coded, GroupCoder};
use crate::encode::{DepthSettings, EncodeSettings};
use codec::color::quality::EightBit;
use codec::color::temporal::BlockStage;
use codec::color::transform::Keyed;
use codec::color::transform::encode::{PricedTables, Start, TransformEncoder};
use codec::color::{CellEncoder, CellFormat, HalfKey, Sample};
use codec::container::{ChunkKey, EncodedChunk, PackedChunk};
use codec::depth::TemporalEncoder;
use codec::depth::block_chunk::encoder::BlockEncoder;
use codec::depth::domain::Domain;
use codec::depth::node_encoder::NodeEncoder;
use codec::depth::nodes::Grid;
use codec::depth::predictive::encoder::PredictiveEncoder;
use codec::depth::predictive::{PredictiveHeader, UnitArea};
use codec::depth::tree_chunk::encoder::TreeEncoder;
use codec::error::{Error, Result};
use codec::image::Plane;
use codec::monitor::Monitor;
use codec::streams::{CodecHeader, DepthCoding, DepthHeader, MaterialHeader};

enum Unit {
    Depth(TemporalEncoder<u16>),
    DepthNodes(Box<NodeEncoder>),
    DepthTree(Box<TreeEncoder>),
    DepthBlocks(BlockEncoder),
    Predictive(Box<PredictiveEncoder>),
    Material(TemporalEncoder<[u8; 3]>),
    Color8(CellEncoder<u8>),
    ColorHalf(CellEncoder<HalfKey>),
    Transform8(TransformEncoder<u8>),
    TransformHalf(TransformEncoder<HalfKey>),
}

/// Progress in images, computed from the number of coded units. Units complete in any order.
pub(super) struct Pace<'a> {
    monitor: &'a dyn Monitor,
    units: u64,
    faces: u64,
    done: AtomicU64,
}

impl<'a> Pace<'a> {
    pub fn new(monitor: &'a dyn Monitor, units: usize, faces: usize) -> Pace<'a> {
        Pace { monitor, units: units.max(1) as u64, faces: faces as u64, done: AtomicU64::new(0) }
    }

    pub fn advance(&self, units: u64) {
        let before = self.done.fetch_add(units, Ordering::Relaxed);
        self.monitor.advance(self.images(before + units) - self.images(before));
    }

    /// Number of complete images if `units` coded units were spread evenly over the images.
    fn images(&self, units: u64) -> u64 {
        units * self.faces / self.units
    }
}

pub(super) struct Batch {
    /// First frame, relative to the first frame of the group.
    pub first: u32,
    /// Pictures by frame, then by face.
    pub pictures: Vec<Vec<Coded>>,
}

#[derive(Debug, Clone, Copy)]
pub(super) struct UnitPlace {
    /// Index among the faces of the group.
    pub face: usize,
    pub stream: u32,
    pub unit: u32,
    /// Left, top, width and height in pixels of the face.
    pub rect: [u32; 4],
    /// Number of frames of the group before the first frame of the encoder; initially, those that an earlier run has coded.
    pub start: u32,
    /// Initial state of the search, saved by the earlier run after its last complete chunk.
    pub search: Option<Start>,
}

pub(super) struct Closed {
    /// Index within the batch of the picture that closed the chunk.
    pub by: usize,
    pub chunk: PackedChunk,
    /// Initial state of the search for the next chunk.
    pub search: Option<Start>,
}

pub(super) struct UnitJob {
    place: UnitPlace,
    encoder: Unit,
    memory: ColorMemory,
}

impl UnitJob {
    pub fn new(coder: &GroupCoder<'_>, memory: ColorMemory, place: UnitPlace) -> Result<UnitJob> {
        let mut encoder = Unit::new(coder, place.rect, &memory)?;
        match &mut encoder {
            Unit::Transform8(encoder) => encoder.start = place.search,
            Unit::TransformHalf(encoder) => encoder.start = place.search,
            _ => {}
        }
        Ok(UnitJob { place, encoder, memory })
    }

    /// Codes this unit of each picture and returns the chunks that were closed.
    pub fn push(&mut self, batch: &Batch, coder: &GroupCoder<'_>, pace: &Pace<'_>) -> Result<Vec<Closed>> {
        let mut closed = Vec::new();
        let segment_frames = coder.settings.segment_frames(coder.group.kind);
        let skipped = self.place.start.saturating_sub(batch.first) as usize;
        for (at, picture) in batch.pictures.iter().enumerate().skip(skipped) {
            pace.monitor.check()?;
            let chunk = self.encoder.push(&picture[self.place.face], self.place.rect, coder)?;
            let frames = batch.first + at as u32 + 1;
            if frames.is_multiple_of(segment_frames) {
                for chunk in chunk.into_iter().chain(self.encoder.finish(coder)?) {
                    closed.push(Closed { by: at, chunk: self.pack(chunk, coder)?, search: None });
                }
                self.encoder = Unit::new(coder, self.place.rect, &self.memory)?;
                self.place.start = frames;
            } else if let Some(chunk) = chunk {
                closed.push(Closed { by: at, chunk: self.pack(chunk, coder)?, search: self.encoder.search() });
            }
            pace.advance(1);
        }
        Ok(closed)
    }

    pub fn finish(&mut self, coder: &GroupCoder<'_>) -> Result<Vec<PackedChunk>> {
        let chunks = self.encoder.finish(coder)?;
        chunks.into_iter().map(|chunk| self.pack(chunk, coder)).collect()
    }

    fn pack(&self, chunk: EncodedChunk, coder: &GroupCoder<'_>) -> Result<PackedChunk> {
        let UnitPlace { stream, unit, start, .. } = self.place;
        let first_frame = coder.group.frames.first + start + chunk.first_frame;
        let key = ChunkKey { stream, unit, first_frame, frame_count: chunk.frame_count };
        PackedChunk::new(key, chunk.payload, (coder.settings.compression, coder.header.payload_kind()))
    }
}

impl Unit {
    fn new(coder: &GroupCoder<'_>, rect: [u32; 4], memory: &ColorMemory) -> Result<Unit> {
        let [_, _, width, height] = rect;
        let (size, area) = ([width, height], UnitArea { rect, image: [coder.group.width, coder.group.height] });
        Ok(match &coder.header {
            CodecHeader::Depth(header) => Unit::of_depth(header, area, coder.settings)?,
            CodecHeader::Material(MaterialHeader { temporal, in_blocks: false }) => {
                Unit::Material(TemporalEncoder::new(width, *temporal))
            }
            CodecHeader::Material(MaterialHeader { temporal, in_blocks: true }) => {
                Unit::Material(TemporalEncoder::in_blocks(size, *temporal, coder.settings.depth.effort))
            }
            CodecHeader::Alpha(header) => predictive(&header.predictive(), area, coder.settings)?,
            CodecHeader::Color(header) => match (header.is_half(), &coder.tables) {
                (false, None) => Unit::Color8(cell_encoder(memory, header.cell_of_bytes(size), header.min_psnr_db)),
                (true, None) => Unit::ColorHalf(cell_encoder(memory, header.cell_of_halves(size), header.min_psnr_db)),
                (false, Some(tables)) => {
                    Unit::Transform8(transform_encoder(coder.settings, header.cell_of_bytes(size), tables))
                }
                (true, Some(tables)) => {
                    Unit::TransformHalf(transform_encoder(coder.settings, header.cell_of_halves(size), tables))
                }
            },
        })
    }

    fn of_depth(header: &DepthHeader, area: UnitArea, settings: &EncodeSettings) -> Result<Unit> {
        let [width, height] = area.size();
        let grid = Grid { width, height };
        Ok(match &header.coding {
            &DepthCoding::Boxes(temporal) => Unit::Depth(TemporalEncoder::new(grid.width, temporal)),
            &DepthCoding::BoxesInBlocks(temporal) => {
                let size = [grid.width, grid.height];
                Unit::Depth(TemporalEncoder::in_blocks(size, temporal, settings.depth.effort))
            }
            DepthCoding::Nodes(nodes) => {
                let domain = Domain::new(nodes.domain.kind, header.range)?;
                Unit::DepthNodes(Box::new(NodeEncoder::new(grid, domain, settings.nodes(nodes.bound))))
            }
            DepthCoding::Tree(nodes) => {
                let domain = Domain::new(nodes.domain.kind, header.range)?;
                Unit::DepthTree(Box::new(TreeEncoder::new(grid, domain, settings.nodes(nodes.bound))))
            }
            DepthCoding::Blocks => {
                let interval = settings.temporal.keyframe_interval;
                Unit::DepthBlocks(BlockEncoder::new(grid, settings.depth.effort, interval))
            }
            DepthCoding::Predictive(header) => predictive(header, area, settings)?,
        })
    }

    fn push(&mut self, picture: &Coded, rect: [u32; 4], coder: &GroupCoder<'_>) -> Result<Option<EncodedChunk>> {
        match (self, picture) {
            (Unit::Depth(encoder), Coded::Codes(plane)) => encoder.push(&cut(plane, rect)),
            (Unit::DepthNodes(encoder), Coded::Codes(plane)) => encoder.push(&cut(plane, rect), None),
            (Unit::DepthTree(encoder), Coded::Codes(plane)) => encoder.push(&cut(plane, rect)),
            (Unit::DepthBlocks(encoder), Coded::Codes(plane)) => Ok(encoder.push(&cut(plane, rect))),
            (Unit::Predictive(encoder), Coded::Codes(plane)) => Ok(encoder.push(&cut(plane, rect))),
            (Unit::Material(encoder), Coded::Bytes(plane)) => encoder.push(&cut(plane, rect)),
            (Unit::Color8(encoder), Coded::Bytes(plane)) => encoder.push(cut(plane, rect).as_flattened(), &EightBit),
            (Unit::ColorHalf(encoder), Coded::Half(plane)) => {
                encoder.push(cut(plane, rect).as_flattened(), coder.pu21()?)
            }
            (Unit::Transform8(encoder), Coded::Bytes(plane)) => {
                encoder.push(cut(plane, rect).as_flattened(), &EightBit)
            }
            (Unit::TransformHalf(encoder), Coded::Half(plane)) => {
                encoder.push(cut(plane, rect).as_flattened(), coder.pu21()?)
            }
            // Pictures and units of a group are built from the same header, so this does not occur.
            _ => Err(Error::invalid("a picture of another kind than its unit")),
        }
    }

    fn finish(&mut self, coder: &GroupCoder<'_>) -> Result<Vec<EncodedChunk>> {
        match self {
            Unit::Depth(encoder) => Ok(encoder.finish()?.into_iter().collect()),
            Unit::DepthNodes(encoder) => Ok(encoder.finish()?.into_iter().collect()),
            Unit::DepthTree(encoder) => Ok(encoder.finish()?.into_iter().collect()),
            Unit::DepthBlocks(encoder) => Ok(encoder.finish().into_iter().collect()),
            Unit::Predictive(encoder) => Ok(encoder.finish().into_iter().collect()),
            Unit::Material(encoder) => Ok(encoder.finish()?.into_iter().collect()),
            Unit::Color8(encoder) => encoder.finish(&EightBit),
            Unit::ColorHalf(encoder) => encoder.finish(coder.pu21()?),
            Unit::Transform8(encoder) => Ok(encoder.finish(&EightBit)?.into_iter().collect()),
            Unit::TransformHalf(encoder) => Ok(encoder.finish(coder.pu21()?)?.into_iter().collect()),
        }
    }

    fn search(&self) -> Option<Start> {
        match self {
            Unit::Transform8(encoder) => encoder.start,
            Unit::TransformHalf(encoder) => encoder.start,
            _ => None,
        }
    }
}

fn predictive(header: &PredictiveHeader, area: UnitArea, settings: &EncodeSettings) -> Result<Unit> {
    let DepthSettings { decide, effort, .. } = settings.depth;
    Ok(Unit::Predictive(Box::new(PredictiveEncoder::new(header, area, decide, effort)?)))
}

fn cell_encoder<S: Sample>(
    memory: &ColorMemory,
    CellFormat { size, blocks }: CellFormat<S>,
    final_psnr_db: f64,
) -> CellEncoder<S> {
    let encoder = CellEncoder::new(memory.search, memory.close_at_bytes);
    match blocks {
        Some(blocks) => encoder.with_blocks(BlockStage { blocks, size, final_psnr_db }),
        None => encoder,
    }
}

fn transform_encoder<S: Keyed>(
    settings: &EncodeSettings,
    format: CellFormat<S>,
    tables: &Arc<PricedTables>,
) -> TransformEncoder<S> {
    TransformEncoder::new(format, settings.search, settings.color_chunk, Arc::clone(tables))
}

/// Returns the pixels of a rectangle (left, top, width, height), row-major.
fn cut<T: Copy>(plane: &Plane<T>, [left, top, width, height]: [u32; 4]) -> Vec<T> {
    let mut pixels = Vec::with_capacity(width as usize * height as usize);
    for y in top..top + height {
        pixels.extend_from_slice(&plane.row(y)[left as usize..(left + width) as usize]);
    }
    pixels
}
