//! Encodes a dataset: reads frames, feeds the unit encoders, writes chunks.
//!
//! The order of chunks in the file, and so its bytes, depend on nothing but input and options: frames are read in
//! batches of a fixed size, units of a batch are coded in parallel and written in order.

use std::io::Write;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use rayon::prelude::*;

use crate::color::blend::HalfKey;
use crate::color::keyframes::SearchSettings;
use crate::color::quality::{EightBit, Pu21};
use crate::color::temporal::{CLOSE_AT_BYTES, CellEncoder};
use crate::container::index::MAX_SIZE;
use crate::container::{ChunkKey, EncodedChunk, PackedChunk, ProbeEntry, StreamEntry, Writer};
use crate::dataset::source::{Source, SourceGroup};
use crate::dataset::stream::{Projection, StreamKind};
use crate::depth::quantise::{DepthRange, Quantiser};
use crate::depth::temporal::{TemporalEncoder, TemporalSettings};
use crate::error::{Error, Result};
use crate::image::plane::{DepthPlane, Plane};
use crate::image::transfer::EncodeTable;
use crate::monitor::Monitor;
use crate::ordered::try_map_ordered;
use crate::video::codec::{CodecHeader, ColorFormat, ColorHeader, DepthHeader, MaterialHeader};
use crate::video::{convert, scan};

/// Frames read and coded together. Fixed, because the file's order depends on it.
const BATCH_FRAMES: usize = 16;
/// Pixels that a batch may hold, so that large faces do not multiply: batches shrink instead.
const BATCH_PIXELS: usize = 64 << 20;
/// Pictures that the cells of a group may wait for their next keyframe with: bounds how far it may lie.
const PENDING_BYTES: u64 = 768 << 20;
/// Keyframes that the open chunks of a group may hold.
const OPEN_BYTES: usize = 384 << 20;
/// Tiles are a multiple of this, so that later stages can split them in halves down to blocks.
const TILE_ALIGN: u32 = 8;

/// How a dataset is encoded.
#[derive(Debug, Clone)]
pub struct EncodeSettings {
    /// Depth in time; material follows it, with an epsilon of 0.
    pub temporal: TemporalSettings,
    /// Depth and material tiles along each side of a face.
    pub tiles: u32,
    /// Nearest surface in metres; found where not given.
    pub near_m: Option<f32>,
    /// Farthest surface in metres; found where not given.
    pub far_m: Option<f32>,
    /// Colour cells are this many pixels wide and high.
    pub cell: u32,
    /// The domain of colour.
    pub color: ColorFormat,
    /// Colour in time.
    pub search: SearchSettings,
    /// LZMA2 preset for chunks that it makes smaller.
    pub lzma2: Option<u32>,
    /// Kinds of streams to encode.
    pub kinds: Vec<StreamKind>,
}

impl Default for EncodeSettings {
    fn default() -> Self {
        EncodeSettings {
            temporal: TemporalSettings::default(),
            tiles: 2,
            near_m: None,
            far_m: None,
            cell: 64,
            color: ColorFormat::EightBit(crate::image::transfer::ToneMap::default()),
            search: SearchSettings::default(),
            lzma2: None,
            kinds: StreamKind::ALL.to_vec(),
        }
    }
}

/// What an encode did.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct EncodeSummary {
    /// Size of the container.
    pub bytes: u64,
    /// Size of the same footage as CALF's table 1 counts it ([`raw_pixel_bytes`]).
    pub raw_bytes: u64,
    /// Images encoded: frames of all streams.
    pub frames: u64,
    /// Streams written.
    pub streams: usize,
    /// Colour pixels that did not fit 8 bits.
    pub clipped_pixels: u64,
    /// Colour pixels in all.
    pub color_pixels: u64,
    /// Time that threads spent reading and decompressing source files, added up.
    pub reading: Duration,
    /// Time that threads spent reading images only to find near and far, which encoding then had to read again.
    pub scanning: Duration,
    /// Time that threads spent converting, coding and compressing, added up.
    pub coding: Duration,
}

/// Bytes of an uncompressed pixel as CALF's table 1 counts it: 32-bit depth, 24-bit colour, three 8-bit materials; and
/// 48 bits for half-float colour, which the table does not have.
pub fn raw_pixel_bytes(header: &CodecHeader) -> u64 {
    match header {
        CodecHeader::Depth(_) => 4,
        CodecHeader::Color(ColorHeader { format: ColorFormat::Half { .. }, .. }) => 6,
        CodecHeader::Color(_) | CodecHeader::Material(_) => 3,
    }
}

/// The groups of a source that the settings ask for.
pub fn selected_groups<'a>(source: &'a Source, settings: &EncodeSettings) -> Vec<(usize, &'a SourceGroup)> {
    source.groups().iter().enumerate().filter(|(_, group)| settings.kinds.contains(&group.kind)).collect()
}

/// Encodes the streams of `source` into `out`, which is written front to back.
///
/// The monitor advances by one for every image of every stream.
pub fn encode<W: Write>(
    source: &Source,
    settings: &EncodeSettings,
    out: W,
    monitor: &dyn Monitor,
) -> Result<(W, EncodeSummary)> {
    settings.temporal.check()?;
    if settings.tiles == 0 || settings.cell == 0 || settings.search.reach == 0 {
        return Err(Error::Usage("tiles, cell size and keyframe reach must be at least 1".into()));
    }
    let groups = selected_groups(source, settings);
    if groups.is_empty() {
        return Err(Error::Usage(format!("'{}' has no stream of the kinds asked for", source.name())));
    }
    let projection = u8::from(source.projection() == Projection::Perspective);
    let mut writer = Writer::new(out, source.name(), source.fps(), projection)?;
    for probe in source.probes() {
        writer.add_probe(ProbeEntry {
            name: probe.name.clone(),
            position: probe.position,
            orientation: probe.orientation,
            frames: [probe.frames.first, probe.frames.last],
            intrinsics: probe.intrinsics.unwrap_or_default(),
        })?;
    }
    let mut job = Job { source, settings, writer, monitor, summary: EncodeSummary::default() };
    job.run(&groups)?;
    let Job { writer, mut summary, .. } = job;
    let (out, bytes) = writer.finish()?;
    summary.bytes = bytes;
    Ok((out, summary))
}

struct Job<'a, W: Write> {
    source: &'a Source,
    settings: &'a EncodeSettings,
    writer: Writer<W>,
    monitor: &'a dyn Monitor,
    summary: EncodeSummary,
}

/// The encoder of one unit, whatever its stream holds.
enum Unit {
    Depth(TemporalEncoder<u16>),
    Material(TemporalEncoder<[u8; 3]>),
    Color8(CellEncoder<u8>),
    ColorHalf(CellEncoder<HalfKey>),
}

/// An image in the domain of its codec.
enum Coded {
    Depth(Plane<u16>),
    Bytes(Plane<[u8; 3]>),
    Half(Plane<[HalfKey; 3]>),
}

/// What turns the images of a group into codes and codes into chunks.
struct GroupCoder<'a> {
    group: &'a SourceGroup,
    header: CodecHeader,
    quantiser: Option<Arc<Quantiser>>,
    table: Option<EncodeTable>,
    pu21: Option<Pu21>,
    clipped: AtomicU64,
}

impl<W: Write> Job<'_, W> {
    fn run(&mut self, groups: &[(usize, &SourceGroup)]) -> Result<()> {
        for probe in 0..self.source.probes().len() {
            let of = |kind: StreamKind| {
                groups.iter().copied().filter(move |(_, group)| group.probe == probe && group.kind == kind)
            };
            for (_, group) in of(StreamKind::Color) {
                let header = CodecHeader::Color(ColorHeader::new(self.settings.color, &self.settings.search));
                self.encode_group(GroupCoder::new(group, header)?, |_| None)?;
            }
            let depth: Vec<_> = of(StreamKind::Depth).collect();
            self.encode_depth(&depth)?;
            for (_, group) in of(StreamKind::Material) {
                let temporal = TemporalSettings { epsilon: 0, ..self.settings.temporal };
                let header = CodecHeader::Material(MaterialHeader { temporal });
                self.encode_group(GroupCoder::new(group, header)?, |_| None)?;
            }
        }
        Ok(())
    }

    fn encode_depth(&mut self, groups: &[(usize, &SourceGroup)]) -> Result<()> {
        if groups.is_empty() {
            return Ok(());
        }
        let manifest = self.source.manifest().and_then(|manifest| manifest.depth.as_ref());
        let near = self.settings.near_m.or_else(|| manifest.and_then(|depth| depth.near).map(|near| near as f32));
        let far = self.settings.far_m.or_else(|| manifest.and_then(|depth| depth.far).map(|far| far as f32));
        let (range, mut kept) = match (near, far) {
            (Some(near), Some(far)) => (DepthRange::new(near, far)?, Default::default()),
            _ => {
                let found = scan::scan_probe(self.source, groups, self.monitor)?;
                self.summary.reading += found.reading;
                self.summary.scanning += found.scanning;
                let probe = &self.source.probes()[groups[0].1.probe].name;
                (found_range(probe, [near, far], &found)?, found.kept)
            }
        };
        let quantiser = Arc::new(Quantiser::new(range));
        for &(at, group) in groups {
            let header = CodecHeader::Depth(DepthHeader {
                range,
                background: presented_background(self.source.background(), range),
                kind: self.source.depth_stored(),
                temporal: self.settings.temporal,
            });
            let coder = GroupCoder { quantiser: Some(Arc::clone(&quantiser)), ..GroupCoder::new(group, header)? };
            self.encode_group(coder, |frame| kept.remove(&(at, frame)))?;
        }
        Ok(())
    }

    fn encode_group(
        &mut self,
        coder: GroupCoder<'_>,
        mut kept: impl FnMut(u32) -> Option<Vec<DepthPlane>>,
    ) -> Result<()> {
        let group = coder.group;
        let streams = self.declare_streams(&coder)?;
        let unit_count = streams.iter().map(|(_, entry)| entry.unit_count()).sum();
        let memory = ColorMemory::new(group, &coder.header, self.settings.search, unit_count);
        let mut units = Vec::new();
        for (face, (stream, entry)) in streams.iter().enumerate() {
            for unit in 0..entry.unit_count() {
                let rect = entry.unit_rect(unit);
                units.push(UnitJob { face, stream: *stream, unit, rect, encoder: coder.unit_encoder(rect, &memory) });
            }
        }
        let face_pixels = group.width as usize * group.height as usize * group.faces.len();
        let batch = (BATCH_PIXELS / face_pixels.max(1)).clamp(1, BATCH_FRAMES);
        let frames: Vec<u32> = group.frames.iter().collect();
        let (reading, coding) = (AtomicU64::new(0), AtomicU64::new(0));
        let level = self.settings.lzma2;
        for batch in frames.chunks(batch) {
            let inputs: Vec<_> = batch.iter().map(|&frame| (frame, kept(frame))).collect();
            let pictures = try_map_ordered(inputs, |(frame, kept)| {
                self.monitor.check()?;
                let coded = coder.read(self.source, frame, kept, &reading, &coding)?;
                self.monitor.advance(coded.len() as u64);
                Ok(coded)
            })?;
            let packed = units
                .par_iter_mut()
                .map(|job| timed(&coding, || job.push(&pictures, &coder, level)))
                .collect::<Result<Vec<_>>>()?;
            self.write(packed)?;
        }
        let packed =
            units.par_iter_mut().map(|job| timed(&coding, || job.finish(&coder, level))).collect::<Result<Vec<_>>>()?;
        self.write(packed)?;
        self.summary.reading += Duration::from_nanos(reading.into_inner());
        self.summary.coding += Duration::from_nanos(coding.into_inner());
        self.summary.clipped_pixels += coder.clipped.into_inner();
        Ok(())
    }

    fn declare_streams(&mut self, coder: &GroupCoder<'_>) -> Result<Vec<(u32, StreamEntry)>> {
        let group = coder.group;
        if group.width > MAX_SIZE || group.height > MAX_SIZE {
            return Err(Error::unsupported(format!(
                "faces of {}x{} pixels: at most {MAX_SIZE}x{MAX_SIZE} fit a container",
                group.width, group.height
            )));
        }
        let frame_count = u32::try_from(group.frames.count())
            .ok()
            .filter(|_| group.frames.last < crate::container::index::MAX_FRAME)
            .ok_or_else(|| Error::unsupported(format!("frames {}: numbers must be below 2^31", group.frames)))?;
        let unit = |side: u32| match group.kind {
            StreamKind::Color => self.settings.cell.min(MAX_SIZE),
            _ => side.div_ceil(self.settings.tiles).next_multiple_of(TILE_ALIGN),
        };
        let (unit_width, unit_height) = (unit(group.width), unit(group.height));
        let mut streams = Vec::new();
        for &face in &group.faces {
            let entry = StreamEntry {
                kind: group.kind as u8,
                face: face as u8,
                probe: group.probe as u16,
                codec: coder.header.codec(),
                width: group.width,
                height: group.height,
                first_frame: group.frames.first,
                frame_count,
                unit_width,
                unit_height,
                codec_header: coder.header.write(),
            };
            let images = u64::from(frame_count);
            let pixels = images * u64::from(group.width) * u64::from(group.height);
            self.summary.frames += images;
            self.summary.raw_bytes += pixels * raw_pixel_bytes(&coder.header);
            self.summary.color_pixels += if group.kind == StreamKind::Color { pixels } else { 0 };
            self.summary.streams += 1;
            streams.push((self.writer.add_stream(entry.clone()), entry));
        }
        Ok(streams)
    }

    fn write(&mut self, packed: Vec<Vec<PackedChunk>>) -> Result<()> {
        packed.iter().flatten().try_for_each(|chunk| self.writer.push(chunk))
    }
}

/// What the encoders of a group's colour cells may hold, so that large groups stay within memory. It follows from the
/// footage and the settings alone, because the file depends on it.
struct ColorMemory {
    search: SearchSettings,
    close_at_bytes: usize,
}

impl ColorMemory {
    fn new(group: &SourceGroup, header: &CodecHeader, search: SearchSettings, unit_count: u32) -> ColorMemory {
        let faces = group.faces.len() as u64;
        let picture = u64::from(group.width) * u64::from(group.height) * faces * raw_pixel_bytes(header);
        let reach = (PENDING_BYTES / picture.max(1)).clamp(1, u64::from(search.reach)) as u32;
        let close_at_bytes = CLOSE_AT_BYTES.min(OPEN_BYTES / unit_count.max(1) as usize);
        ColorMemory { search: SearchSettings { reach, ..search }, close_at_bytes }
    }
}

impl<'a> GroupCoder<'a> {
    fn new(group: &'a SourceGroup, header: CodecHeader) -> Result<GroupCoder<'a>> {
        let mut coder =
            GroupCoder { group, header, quantiser: None, table: None, pu21: None, clipped: AtomicU64::new(0) };
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

    fn unit_encoder(&self, rect: [u32; 4], memory: &ColorMemory) -> Unit {
        match self.header {
            CodecHeader::Depth(header) => Unit::Depth(TemporalEncoder::new(rect[2], header.temporal)),
            CodecHeader::Material(header) => Unit::Material(TemporalEncoder::new(rect[2], header.temporal)),
            CodecHeader::Color(ColorHeader { format: ColorFormat::EightBit(_), .. }) => {
                Unit::Color8(CellEncoder::new(memory.search, memory.close_at_bytes))
            }
            CodecHeader::Color(_) => Unit::ColorHalf(CellEncoder::new(memory.search, memory.close_at_bytes)),
        }
    }

    /// Reads one frame of all faces and brings it into the codec's domain.
    fn read(
        &self,
        source: &Source,
        frame: u32,
        kept: Option<Vec<DepthPlane>>,
        reading: &AtomicU64,
        coding: &AtomicU64,
    ) -> Result<Vec<Coded>> {
        let named = |error: Error| {
            let error = error.context(convert::name_frame(source, self.group, frame));
            match source.file(self.group, frame) {
                Ok(file) => error.in_file(file),
                Err(_) => error,
            }
        };
        match self.group.kind {
            StreamKind::Depth => {
                let Some(quantiser) = &self.quantiser else { return Ok(Vec::new()) };
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
                .map_err(named)
            }
            StreamKind::Color => {
                let planes = timed(reading, || source.read_color(self.group, frame))?;
                timed(coding, || {
                    let code = |plane| match &self.table {
                        Some(table) => {
                            let (codes, clipped) = convert::color_codes(plane, table);
                            self.clipped.fetch_add(clipped, Ordering::Relaxed);
                            Coded::Bytes(codes)
                        }
                        None => Coded::Half(plane.map(|pixel| pixel.map(|value| HalfKey::from_bits(value.to_bits())))),
                    };
                    Ok(planes.iter().map(code).collect())
                })
            }
            StreamKind::Material => {
                let planes = timed(reading, || source.read_material(self.group, frame))?;
                timed(coding, || {
                    planes.iter().map(|plane| convert::material_codes(plane).map(Coded::Bytes)).collect::<Result<_>>()
                })
                .map_err(named)
            }
        }
    }
}

/// One unit of one stream at work.
struct UnitJob {
    /// Index among the faces of the group.
    face: usize,
    stream: u32,
    unit: u32,
    rect: [u32; 4],
    encoder: Unit,
}

impl UnitJob {
    /// Codes this unit of each picture (by frame, by face); answers the chunks that were closed.
    fn push(
        &mut self,
        pictures: &[Vec<Coded>],
        coder: &GroupCoder<'_>,
        level: Option<u32>,
    ) -> Result<Vec<PackedChunk>> {
        let mut packed = Vec::new();
        for picture in pictures {
            let chunk = self.encoder.push(&picture[self.face], self.rect, coder)?;
            packed.extend(chunk.map(|chunk| self.pack(chunk, coder, level)).transpose()?);
        }
        Ok(packed)
    }

    fn finish(&mut self, coder: &GroupCoder<'_>, level: Option<u32>) -> Result<Vec<PackedChunk>> {
        let chunks = self.encoder.finish(coder)?;
        chunks.into_iter().map(|chunk| self.pack(chunk, coder, level)).collect()
    }

    fn pack(&self, chunk: EncodedChunk, coder: &GroupCoder<'_>, level: Option<u32>) -> Result<PackedChunk> {
        let first_frame = coder.group.frames.first + chunk.first_frame;
        let key = ChunkKey { stream: self.stream, unit: self.unit, first_frame, frame_count: chunk.frame_count };
        PackedChunk::new(key, chunk.payload, level)
    }
}

impl Unit {
    fn push(&mut self, picture: &Coded, rect: [u32; 4], coder: &GroupCoder<'_>) -> Result<Option<EncodedChunk>> {
        match (self, picture) {
            (Unit::Depth(encoder), Coded::Depth(plane)) => encoder.push(&cut(plane, rect)),
            (Unit::Material(encoder), Coded::Bytes(plane)) => encoder.push(&cut(plane, rect)),
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
            Unit::Material(encoder) => Ok(encoder.finish()?.into_iter().collect()),
            Unit::Color8(encoder) => encoder.finish(&EightBit),
            Unit::ColorHalf(encoder) => coder.pu21.as_ref().map_or(Ok(Vec::new()), |pu21| encoder.finish(pu21)),
        }
    }
}

/// The range of a probe from what was given and what was found; at most one of near and far is given.
fn found_range(probe: &str, given: [Option<f32>; 2], found: &scan::ProbeScan) -> Result<DepthRange> {
    let Some(range) = found.range else {
        return match given[0].or(given[1]) {
            Some(bound) => DepthRange::new(bound, bound),
            None if found.taken_as_near => Err(Error::invalid(format!(
                "probe {probe} has no valid depth at all, so that invalid ones cannot be taken as its nearest: give --near"
            ))),
            None => Ok(DepthRange::empty()),
        };
    };
    let (near, far) = (given[0].unwrap_or(range.near_m()), given[1].unwrap_or(range.far_m()));
    DepthRange::new(near, far).map_err(|_| {
        Error::Usage(format!(
            "probe {probe}: near {near} m and far {far} m hold no depth; what was not given was found in the footage, \
             whose surfaces lie from {} m to {} m",
            range.near_m(),
            range.far_m()
        ))
    })
}

/// What a decoder writes where nothing is: the value that the source files had there, unless it could be taken for a
/// surface. (It is in the files' unit, surfaces are in metres.)
fn presented_background(value: f32, range: DepthRange) -> f32 {
    if (range.near_m()..=range.far_m()).contains(&value) { f32::INFINITY } else { value }
}

/// The pixels of a rectangle (left, top, width, height), row-major.
fn cut<T: Copy>(plane: &Plane<T>, [left, top, width, height]: [u32; 4]) -> Vec<T> {
    let mut pixels = Vec::with_capacity(width as usize * height as usize);
    for y in top..top + height {
        pixels.extend_from_slice(&plane.row(y)[left as usize..(left + width) as usize]);
    }
    pixels
}

fn timed<T>(nanos: &AtomicU64, work: impl FnOnce() -> T) -> T {
    let start = Instant::now();
    let done = work();
    nanos.fetch_add(start.elapsed().as_nanos() as u64, Ordering::Relaxed);
    done
}
