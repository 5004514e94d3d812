//! The units of a group at work: images become codes, codes become chunks.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use crate::color::blend::{HalfKey, Sample};
use crate::color::cells::CellFormat;
use crate::color::keyframes::SearchSettings;
use crate::color::quality::{EightBit, Pu21};
use crate::color::temporal::{BlockStage, CLOSE_AT_BYTES, CellEncoder};
use crate::container::{ChunkKey, EncodedChunk, PackedChunk};
use crate::dataset::source::{Source, SourceGroup};
use crate::dataset::stream::StreamKind;
use crate::depth::block_chunk::BlockEncoder;
use crate::depth::block_temporal::HeldBlocks;
use crate::depth::domain::Domain;
use crate::depth::node_encoder::NodeEncoder;
use crate::depth::nodes::Grid;
use crate::depth::quantise::Quantiser;
use crate::depth::temporal::TemporalEncoder;
use crate::depth::tree_chunk::TreeEncoder;
use crate::encode::dataset::{EncodeSettings, raw_pixel_bytes};
use crate::error::{Error, Result};
use crate::image::plane::{DepthPlane, Plane};
use crate::image::transfer::EncodeTable;
use crate::monitor::Monitor;
use crate::streams::{CodecHeader, ColorFormat, ColorHeader, DepthCoding, DepthHeader, MaterialHeader, convert};

/// Pictures that the cells of a group may wait for their next keyframe with: bounds how far it may lie.
const PENDING_BYTES: u64 = 768 << 20;
/// Keyframes that the open chunks of a group may hold.
const OPEN_BYTES: usize = 384 << 20;

/// The encoder of one unit, whatever its stream holds.
enum Unit {
    Depth(TemporalEncoder<u16>),
    DepthInBlocks(TemporalEncoder<u16, HeldBlocks<u16>>),
    DepthNodes(Box<NodeEncoder>),
    DepthTree(Box<TreeEncoder>),
    DepthBlocks(BlockEncoder),
    Material(TemporalEncoder<[u8; 3]>),
    MaterialInBlocks(TemporalEncoder<[u8; 3], HeldBlocks<[u8; 3]>>),
    Color8(CellEncoder<u8>),
    ColorHalf(CellEncoder<HalfKey>),
}

/// An image in the domain of its codec.
pub(super) enum Coded {
    Depth(Plane<u16>),
    Bytes(Plane<[u8; 3]>),
    Half(Plane<[HalfKey; 3]>),
}

/// What turns the images of a group into codes and codes into chunks.
pub(super) struct GroupCoder<'a> {
    pub(super) group: &'a SourceGroup,
    pub(super) header: CodecHeader,
    pub(super) settings: &'a EncodeSettings,
    pub(super) quantiser: Option<Arc<Quantiser>>,
    table: Option<EncodeTable>,
    pu21: Option<Pu21>,
}

/// What the encoders of a group's colour cells may hold, so that large groups stay within memory. It follows from the
/// footage and the settings alone, because the file depends on it.
pub(super) struct ColorMemory {
    search: SearchSettings,
    close_at_bytes: usize,
}

impl ColorMemory {
    pub(super) fn new(
        group: &SourceGroup,
        header: &CodecHeader,
        search: SearchSettings,
        unit_count: u32,
    ) -> ColorMemory {
        let faces = group.faces.len() as u64;
        let picture = u64::from(group.width) * u64::from(group.height) * faces * raw_pixel_bytes(header);
        let reach = (PENDING_BYTES / picture.max(1)).clamp(1, u64::from(search.reach)) as u32;
        let close_at_bytes = CLOSE_AT_BYTES.min(OPEN_BYTES / unit_count.max(1) as usize);
        ColorMemory { search: SearchSettings { reach, ..search }, close_at_bytes }
    }

    /// Distinct pictures that may wait for their next keyframe.
    pub(super) fn reach(&self) -> u32 {
        self.search.reach
    }

    /// Where the chunk of a cell is closed.
    pub(super) fn close_at_bytes(&self) -> usize {
        self.close_at_bytes
    }

    /// The encoder of a cell; with blocks, frames then reach `final_psnr_db`.
    fn encoder<S: Sample>(&self, CellFormat { size, blocks }: CellFormat<S>, final_psnr_db: f64) -> CellEncoder<S> {
        let encoder = CellEncoder::new(self.search, self.close_at_bytes);
        match blocks {
            Some(blocks) => encoder.with_blocks(BlockStage { blocks, size, final_psnr_db }),
            None => encoder,
        }
    }
}

impl<'a> GroupCoder<'a> {
    pub(super) fn new(
        group: &'a SourceGroup,
        header: CodecHeader,
        settings: &'a EncodeSettings,
    ) -> Result<GroupCoder<'a>> {
        let mut coder = GroupCoder { group, header, settings, quantiser: None, table: None, pu21: None };
        match header {
            // The tables take longer than a small frame; all faces of a probe share one.
            CodecHeader::Depth(_) => {}
            CodecHeader::Color(ColorHeader { format: ColorFormat::EightBit(tone), .. }) => {
                coder.table = Some(EncodeTable::new(&tone));
            }
            CodecHeader::Color(ColorHeader { format: ColorFormat::Half { white_cd_m2 }, .. }) => {
                coder.pu21 = Some(Pu21::new(white_cd_m2)?);
            }
            CodecHeader::Material(_) => {}
        }
        Ok(coder)
    }

    fn unit_encoder(&self, [_, _, width, height]: [u32; 4], memory: &ColorMemory) -> Result<Unit> {
        let size = [width, height];
        Ok(match self.header {
            CodecHeader::Depth(header) => self.depth_encoder(&header, Grid { width, height })?,
            CodecHeader::Material(MaterialHeader { temporal, in_blocks: false }) => {
                Unit::Material(TemporalEncoder::new(width, temporal))
            }
            CodecHeader::Material(MaterialHeader { temporal, in_blocks: true }) => {
                Unit::MaterialInBlocks(TemporalEncoder::in_blocks(size, temporal, self.settings.depth.effort))
            }
            CodecHeader::Color(header @ ColorHeader { format: ColorFormat::EightBit(_), .. }) => {
                Unit::Color8(memory.encoder(header.cell_of_bytes(size), header.min_psnr_db))
            }
            CodecHeader::Color(header) => {
                Unit::ColorHalf(memory.encoder(header.cell_of_halves(size), header.min_psnr_db))
            }
        })
    }

    fn depth_encoder(&self, header: &DepthHeader, grid: Grid) -> Result<Unit> {
        let settings = self.settings;
        Ok(match header.coding {
            DepthCoding::Boxes(temporal) => Unit::Depth(TemporalEncoder::new(grid.width, temporal)),
            DepthCoding::BoxesInBlocks(temporal) => {
                let size = [grid.width, grid.height];
                Unit::DepthInBlocks(TemporalEncoder::in_blocks(size, temporal, settings.depth.effort))
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
        })
    }

    /// Reads one frame of all faces and brings it into the codec's domain; also answers how many of its pixels did not fit
    /// 8 bits.
    pub(super) fn read(
        &self,
        source: &Source,
        frame: u32,
        kept: Option<Vec<DepthPlane>>,
        reading: &AtomicU64,
        coding: &AtomicU64,
    ) -> Result<(Vec<Coded>, u64)> {
        let named = |error: Error| {
            let error = error.context(crate::encode::settings::name_frame(source, self.group, frame));
            match source.file(self.group, frame) {
                Ok(file) => error.in_file(file),
                Err(_) => error,
            }
        };
        match self.group.kind {
            StreamKind::Depth => {
                let Some(quantiser) = &self.quantiser else { return Ok((Vec::new(), 0)) };
                let planes = match kept {
                    Some(planes) => planes,
                    None => timed(reading, || source.read_depth(self.group, frame))?,
                };
                timed(coding, || {
                    planes
                        .iter()
                        .map(|plane| convert::depth_codes(plane, quantiser).map(Coded::Depth))
                        .collect::<Result<_>>()
                })
                .map(|coded| (coded, 0))
                .map_err(named)
            }
            StreamKind::Color => {
                let planes = timed(reading, || source.read_color(self.group, frame))?;
                timed(coding, || {
                    let mut clipped = 0;
                    let code = |plane| match &self.table {
                        Some(table) => {
                            let (codes, of_plane) = convert::color_codes(plane, table);
                            clipped += of_plane;
                            Coded::Bytes(codes)
                        }
                        None => Coded::Half(plane.map(|pixel| pixel.map(|value| HalfKey::from_bits(value.to_bits())))),
                    };
                    let coded = planes.iter().map(code).collect();
                    Ok((coded, clipped))
                })
            }
            StreamKind::Material => {
                let planes = timed(reading, || source.read_material(self.group, frame))?;
                timed(coding, || {
                    planes.iter().map(|plane| convert::material_codes(plane).map(Coded::Bytes)).collect::<Result<_>>()
                })
                .map(|coded| (coded, 0))
                .map_err(named)
            }
        }
    }
}

/// Tells the monitor of images, whose units are done in any order.
pub(super) struct Pace<'a> {
    monitor: &'a dyn Monitor,
    /// Units of all faces, and faces.
    units: u64,
    faces: u64,
    done: AtomicU64,
}

impl<'a> Pace<'a> {
    pub(super) fn new(monitor: &'a dyn Monitor, units: usize, faces: usize) -> Pace<'a> {
        Pace { monitor, units: units.max(1) as u64, faces: faces as u64, done: AtomicU64::new(0) }
    }

    /// So many units of images were done before.
    pub(super) fn skip(&self, units: u64) {
        let before = self.done.fetch_add(units, Ordering::Relaxed);
        self.monitor.advance(self.images(before + units) - self.images(before));
    }

    /// One unit of one image is done: images are counted as if units were done evenly.
    fn step(&self) {
        self.skip(1);
    }

    fn images(&self, units: u64) -> u64 {
        units * self.faces / self.units
    }
}

/// Frames that are coded together.
pub(super) struct Batch {
    /// Frames of the group before them.
    pub(super) first: u32,
    /// By frame, then by face.
    pub(super) pictures: Vec<Vec<Coded>>,
}

/// One unit of one stream at work.
pub(super) struct UnitJob {
    /// Index among the faces of the group.
    face: usize,
    stream: u32,
    unit: u32,
    rect: [u32; 4],
    /// Frames of the group before the first that the encoder gets: an earlier run has coded them.
    start: u32,
    encoder: Unit,
}

impl UnitJob {
    /// The unit `unit` of `stream`, which shows face number `face` of the group.
    pub(super) fn new(
        coder: &GroupCoder<'_>,
        memory: &ColorMemory,
        [face, stream, unit]: [u32; 3],
        rect: [u32; 4],
    ) -> Result<UnitJob> {
        Ok(UnitJob { face: face as usize, stream, unit, rect, start: 0, encoder: coder.unit_encoder(rect, memory)? })
    }

    /// The same without the first `start` frames of the group.
    pub(super) fn starting_at(self, start: u32) -> UnitJob {
        UnitJob { start, ..self }
    }

    /// Codes this unit of each picture; answers the chunks that were closed, each with the index of the picture that
    /// closed it.
    pub(super) fn push(
        &mut self,
        batch: &Batch,
        coder: &GroupCoder<'_>,
        pace: &Pace<'_>,
    ) -> Result<Vec<(usize, PackedChunk)>> {
        let mut packed = Vec::new();
        let skipped = self.start.saturating_sub(batch.first) as usize;
        for (at, picture) in batch.pictures.iter().enumerate().skip(skipped) {
            pace.monitor.check()?;
            if let Some(chunk) = self.encoder.push(&picture[self.face], self.rect, coder)? {
                packed.push((at, self.pack(chunk, coder)?));
            }
            pace.step();
        }
        Ok(packed)
    }

    /// The chunks that are still open.
    pub(super) fn finish(&mut self, coder: &GroupCoder<'_>) -> Result<Vec<PackedChunk>> {
        let chunks = self.encoder.finish(coder)?;
        chunks.into_iter().map(|chunk| self.pack(chunk, coder)).collect()
    }

    fn pack(&self, chunk: EncodedChunk, coder: &GroupCoder<'_>) -> Result<PackedChunk> {
        let first_frame = coder.group.frames.first + self.start + chunk.first_frame;
        let key = ChunkKey { stream: self.stream, unit: self.unit, first_frame, frame_count: chunk.frame_count };
        PackedChunk::new(key, chunk.payload, coder.settings.lzma2)
    }
}

impl Unit {
    fn push(&mut self, picture: &Coded, rect: [u32; 4], coder: &GroupCoder<'_>) -> Result<Option<EncodedChunk>> {
        match (self, picture) {
            (Unit::Depth(encoder), Coded::Depth(plane)) => encoder.push(&cut(plane, rect)),
            (Unit::DepthInBlocks(encoder), Coded::Depth(plane)) => encoder.push(&cut(plane, rect)),
            (Unit::DepthNodes(encoder), Coded::Depth(plane)) => encoder.push(&cut(plane, rect), None),
            (Unit::DepthTree(encoder), Coded::Depth(plane)) => encoder.push(&cut(plane, rect)),
            (Unit::DepthBlocks(encoder), Coded::Depth(plane)) => Ok(encoder.push(&cut(plane, rect))),
            (Unit::Material(encoder), Coded::Bytes(plane)) => encoder.push(&cut(plane, rect)),
            (Unit::MaterialInBlocks(encoder), Coded::Bytes(plane)) => encoder.push(&cut(plane, rect)),
            (Unit::Color8(encoder), Coded::Bytes(plane)) => encoder.push(cut(plane, rect).as_flattened(), &EightBit),
            (Unit::ColorHalf(encoder), Coded::Half(plane)) => match &coder.pu21 {
                Some(pu21) => encoder.push(cut(plane, rect).as_flattened(), pu21),
                None => Ok(None),
            },
            // A group's images and units are made from one header.
            _ => Err(Error::invalid("a picture of another kind than its unit")),
        }
    }

    fn finish(&mut self, coder: &GroupCoder<'_>) -> Result<Vec<EncodedChunk>> {
        match self {
            Unit::Depth(encoder) => Ok(encoder.finish()?.into_iter().collect()),
            Unit::DepthInBlocks(encoder) => Ok(encoder.finish()?.into_iter().collect()),
            Unit::DepthNodes(encoder) => Ok(encoder.finish()?.into_iter().collect()),
            Unit::DepthTree(encoder) => Ok(encoder.finish()?.into_iter().collect()),
            Unit::DepthBlocks(encoder) => Ok(encoder.finish().into_iter().collect()),
            Unit::Material(encoder) => Ok(encoder.finish()?.into_iter().collect()),
            Unit::MaterialInBlocks(encoder) => Ok(encoder.finish()?.into_iter().collect()),
            Unit::Color8(encoder) => encoder.finish(&EightBit),
            Unit::ColorHalf(encoder) => coder.pu21.as_ref().map_or(Ok(Vec::new()), |pu21| encoder.finish(pu21)),
        }
    }
}

/// The pixels of a rectangle (left, top, width, height), row-major.
fn cut<T: Copy>(plane: &Plane<T>, [left, top, width, height]: [u32; 4]) -> Vec<T> {
    let mut pixels = Vec::with_capacity(width as usize * height as usize);
    for y in top..top + height {
        pixels.extend_from_slice(&plane.row(y)[left as usize..(left + width) as usize]);
    }
    pixels
}

pub(super) fn timed<T>(nanos: &AtomicU64, work: impl FnOnce() -> T) -> T {
    let start = Instant::now();
    let done = work();
    nanos.fetch_add(start.elapsed().as_nanos() as u64, Ordering::Relaxed);
    done
}
