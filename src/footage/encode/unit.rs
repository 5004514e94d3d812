//! Units of a group (tiles or cells). Each unit has an encoder that turns its rectangle of every frame into chunks.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use crate::encode::group::{Coded, CodedPixel, GroupCoder};
use crate::encode::{ColorBlockSettings, DepthSettings, EncodeSettings};
use codec::color::quality::{EightBit, Quality};
use codec::color::temporal::BlockStage;
use codec::color::transform::Keyed;
use codec::color::transform::encode::{Start, TransformEncoder};
use codec::color::{CellEncoder, CellFormat, Sample};
use codec::container::{ChunkKey, EncodedChunk, PackedChunk};
use codec::depth::block_chunk::encoder::BlockEncoder;
use codec::depth::domain::Domain;
use codec::depth::node_encoder::NodeEncoder;
use codec::depth::nodes::Grid;
use codec::depth::predictive::encoder::PredictiveEncoder;
use codec::depth::predictive::{PredictiveHeader, UnitArea};
use codec::depth::tree_chunk::encoder::TreeEncoder;
use codec::depth::{TemporalEncoder, Texel};
use codec::error::{Error, Result};
use codec::monitor::Monitor;
use codec::streams::{CodecHeader, DepthCoding, DepthHeader, MaterialHeader};

/// Encoder of one unit in a stream of one codec.
trait UnitEncoder: Send {
    /// Codes the next frame. Returns the chunk that this closed.
    fn push(&mut self, picture: UnitPicture<'_>) -> Result<Option<EncodedChunk>>;

    /// Closes all open chunks.
    fn finish(&mut self) -> Result<Vec<EncodedChunk>>;

    /// Initial state of the search for the next chunk, of codecs that have one.
    fn search(&self) -> Option<Start> {
        None
    }
}

/// The rectangle of a unit (left, top, width, height) in a picture of its stream.
struct UnitPicture<'a> {
    picture: &'a Coded,
    rect: [u32; 4],
}

impl UnitPicture<'_> {
    /// Returns the pixels, row-major.
    fn pixels<T: CodedPixel>(&self) -> Result<Vec<T>> {
        // Does not occur: pictures and units of a group are built from the same header.
        let other = || Error::invalid("a picture of another kind than its unit");
        let plane = T::plane_of(self.picture).ok_or_else(other)?;
        let [left, top, width, height] = self.rect;
        let mut pixels = Vec::with_capacity(width as usize * height as usize);
        for y in top..top + height {
            pixels.extend_from_slice(&plane.row(y)[left as usize..(left + width) as usize]);
        }
        Ok(pixels)
    }
}

impl<T: Texel + CodedPixel> UnitEncoder for TemporalEncoder<T> {
    fn push(&mut self, picture: UnitPicture<'_>) -> Result<Option<EncodedChunk>> {
        self.push(&picture.pixels()?)
    }

    fn finish(&mut self) -> Result<Vec<EncodedChunk>> {
        Ok(self.finish()?.into_iter().collect())
    }
}

impl UnitEncoder for NodeEncoder {
    fn push(&mut self, picture: UnitPicture<'_>) -> Result<Option<EncodedChunk>> {
        self.push(&picture.pixels()?, None)
    }

    fn finish(&mut self) -> Result<Vec<EncodedChunk>> {
        Ok(self.finish()?.into_iter().collect())
    }
}

impl UnitEncoder for TreeEncoder {
    fn push(&mut self, picture: UnitPicture<'_>) -> Result<Option<EncodedChunk>> {
        self.push(&picture.pixels()?)
    }

    fn finish(&mut self) -> Result<Vec<EncodedChunk>> {
        Ok(self.finish()?.into_iter().collect())
    }
}

impl UnitEncoder for BlockEncoder {
    fn push(&mut self, picture: UnitPicture<'_>) -> Result<Option<EncodedChunk>> {
        Ok(self.push(&picture.pixels()?))
    }

    fn finish(&mut self) -> Result<Vec<EncodedChunk>> {
        Ok(self.finish().into_iter().collect())
    }
}

impl UnitEncoder for PredictiveEncoder {
    fn push(&mut self, picture: UnitPicture<'_>) -> Result<Option<EncodedChunk>> {
        Ok(self.push(&picture.pixels()?))
    }

    fn finish(&mut self) -> Result<Vec<EncodedChunk>> {
        Ok(self.finish().into_iter().collect())
    }
}

/// Encoder of colour with the measure of its quality.
struct Measured<'a, E, Q> {
    encoder: E,
    quality: &'a Q,
}

impl<S: Sample, Q: Quality<S>> UnitEncoder for Measured<'_, CellEncoder<S>, Q>
where
    [S; 3]: CodedPixel,
{
    fn push(&mut self, picture: UnitPicture<'_>) -> Result<Option<EncodedChunk>> {
        self.encoder.push(picture.pixels::<[S; 3]>()?.as_flattened(), self.quality)
    }

    fn finish(&mut self) -> Result<Vec<EncodedChunk>> {
        self.encoder.finish(self.quality)
    }
}

impl<S: Keyed, Q: Quality<S>> UnitEncoder for Measured<'_, TransformEncoder<S>, Q>
where
    [S; 3]: CodedPixel,
{
    fn push(&mut self, picture: UnitPicture<'_>) -> Result<Option<EncodedChunk>> {
        self.encoder.push(picture.pixels::<[S; 3]>()?.as_flattened(), self.quality)
    }

    fn finish(&mut self) -> Result<Vec<EncodedChunk>> {
        Ok(self.encoder.finish(self.quality)?.into_iter().collect())
    }

    fn search(&self) -> Option<Start> {
        self.encoder.start
    }
}

type BoxedEncoder<'a> = Box<dyn UnitEncoder + 'a>;

/// Chooses the encoder of a unit by the codec of its stream. `start` is the initial state of the search.
fn unit_encoder<'a>(coder: &'a GroupCoder<'_>, rect: [u32; 4], start: Option<Start>) -> Result<BoxedEncoder<'a>> {
    let ([_, _, width, height], group) = (rect, coder.planned.group);
    let (size, area) = ([width, height], UnitArea { rect, image: [group.width, group.height] });
    Ok(match &coder.header {
        CodecHeader::Depth(header) => return depth_encoder(coder, header, area),
        CodecHeader::Alpha(header) => predictive(coder, &header.predictive(), area)?,
        &CodecHeader::Material(MaterialHeader { temporal, in_blocks }) => Box::new(match in_blocks {
            true => TemporalEncoder::<[u8; 3]>::in_blocks(size, temporal, coder.plan.settings.depth.effort),
            false => TemporalEncoder::new(width, temporal),
        }),
        CodecHeader::Color(header) => match header.is_half() {
            true => color_encoder(coder, header.cell_of_halves(size), coder.pu21()?, start),
            false => color_encoder(coder, header.cell_of_bytes(size), &EightBit, start),
        },
    })
}

fn depth_encoder<'a>(coder: &'a GroupCoder<'_>, header: &DepthHeader, area: UnitArea) -> Result<BoxedEncoder<'a>> {
    let ([width, height], settings) = (area.size(), coder.plan.settings);
    let grid = Grid { width, height };
    Ok(match &header.coding {
        &DepthCoding::Boxes(temporal) => Box::new(TemporalEncoder::<u16>::new(width, temporal)),
        &DepthCoding::BoxesInBlocks(temporal) => {
            Box::new(TemporalEncoder::<u16>::in_blocks([width, height], temporal, settings.depth.effort))
        }
        DepthCoding::Nodes(nodes) => {
            let domain = Domain::new(nodes.domain.kind, header.range)?;
            Box::new(NodeEncoder::new(grid, domain, settings.nodes(nodes.bound)))
        }
        DepthCoding::Tree(nodes) => {
            let domain = Domain::new(nodes.domain.kind, header.range)?;
            Box::new(TreeEncoder::new(grid, domain, settings.nodes(nodes.bound)))
        }
        DepthCoding::Blocks => {
            Box::new(BlockEncoder::new(grid, settings.depth.effort, settings.temporal.keyframe_interval))
        }
        DepthCoding::Predictive(header) => predictive(coder, header, area)?,
    })
}

fn predictive<'a>(coder: &GroupCoder<'_>, header: &PredictiveHeader, area: UnitArea) -> Result<BoxedEncoder<'a>> {
    let DepthSettings { decide, effort, .. } = coder.plan.settings.depth;
    Ok(Box::new(PredictiveEncoder::new(header, area, decide, effort)?))
}

fn color_encoder<'a, S: Keyed, Q: Quality<S>>(
    coder: &'a GroupCoder<'_>,
    CellFormat { size, blocks }: CellFormat<S>,
    quality: &'a Q,
    start: Option<Start>,
) -> BoxedEncoder<'a>
where
    [S; 3]: CodedPixel,
{
    let EncodeSettings { search, color_chunk, color_blocks, .. } = coder.plan.settings;
    if let Some(tables) = &coder.tables {
        let format = CellFormat { size, blocks };
        let mut encoder = TransformEncoder::new(format, *search, *color_chunk, Arc::clone(tables));
        encoder.start = start;
        return Box::new(Measured { encoder, quality });
    }
    let mut encoder = CellEncoder::new(coder.color_memory.search, coder.color_memory.close_at_bytes);
    if let (Some(blocks), &Some(ColorBlockSettings { final_psnr_db, .. })) = (blocks, color_blocks) {
        encoder = encoder.with_blocks(BlockStage { blocks, size, final_psnr_db });
    }
    Box::new(Measured { encoder, quality })
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

pub(super) struct UnitJob<'a> {
    coder: &'a GroupCoder<'a>,
    place: UnitPlace,
    encoder: BoxedEncoder<'a>,
}

impl<'a> UnitJob<'a> {
    pub fn new(coder: &'a GroupCoder<'a>, place: UnitPlace) -> Result<UnitJob<'a>> {
        Ok(UnitJob { coder, place, encoder: unit_encoder(coder, place.rect, place.search)? })
    }

    /// Codes this unit of each picture and returns the chunks that were closed.
    pub fn push(&mut self, batch: &Batch, pace: &Pace<'_>) -> Result<Vec<Closed>> {
        let mut closed = Vec::new();
        let UnitPlace { face, rect, start, .. } = self.place;
        let segment_frames = self.coder.plan.settings.segment_frames(self.coder.planned.group.kind);
        let skipped = start.saturating_sub(batch.first) as usize;
        for (by, picture) in batch.pictures.iter().enumerate().skip(skipped) {
            pace.monitor.check()?;
            let chunk = self.encoder.push(UnitPicture { picture: &picture[face], rect })?;
            let frames = batch.first + by as u32 + 1;
            if frames.is_multiple_of(segment_frames) {
                for chunk in chunk.into_iter().chain(self.encoder.finish()?) {
                    closed.push(Closed { by, chunk: self.pack(chunk)?, search: None });
                }
                self.encoder = unit_encoder(self.coder, rect, None)?;
                self.place.start = frames;
            } else if let Some(chunk) = chunk {
                closed.push(Closed { by, chunk: self.pack(chunk)?, search: self.encoder.search() });
            }
            pace.advance(1);
        }
        Ok(closed)
    }

    pub fn finish(&mut self) -> Result<Vec<PackedChunk>> {
        let chunks = self.encoder.finish()?;
        chunks.into_iter().map(|chunk| self.pack(chunk)).collect()
    }

    fn pack(&self, chunk: EncodedChunk) -> Result<PackedChunk> {
        let (UnitPlace { stream, unit, start, .. }, GroupCoder { plan, planned, header, .. }) =
            (self.place, self.coder);
        let first_frame = planned.group.frames.first + start + chunk.first_frame;
        let key = ChunkKey { stream, unit, first_frame, frame_count: chunk.frame_count };
        PackedChunk::new(key, chunk.payload, (plan.settings.compression, header.payload_kind()))
    }
}
