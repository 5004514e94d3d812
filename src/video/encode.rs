//! Encodes a dataset: reads frames, feeds the unit encoders, writes chunks.
//!
//! The order of chunks in the file, and so its bytes, depend on nothing but input and options: frames are read in
//! batches, units of a batch are coded in parallel, and chunks are written in the order of the frames that closed them,
//! those of one frame by unit.

mod memory;
mod settings;
mod unit;

use std::collections::HashMap;
use std::io::Write;
use std::sync::Arc;
use std::sync::atomic::AtomicU64;
use std::time::Duration;

use rayon::prelude::*;

use crate::container::index::MAX_SIZE;
use crate::container::{ProbeEntry, StreamEntry, Writer};
use crate::dataset::source::{Source, SourceGroup};
use crate::dataset::stream::{Projection, StreamKind};
use crate::depth::block::MAX_TILE;
use crate::depth::quantise::{DepthRange, Quantiser};
use crate::error::{Error, Result};
use crate::image::plane::DepthPlane;
use crate::monitor::Monitor;
use crate::ordered::try_map_ordered;
use crate::video::codec::{CodecHeader, ColorFormat, ColorHeader, DepthHeader};
use crate::video::scan;

pub use settings::{ColorBlockSettings, DepthCodec, DepthSettings, EncodeSettings, ErrorBound, MaterialSettings};
use unit::{ColorMemory, GroupCoder, Pace, UnitJob, timed};

/// Frames read and coded together. The file does not depend on it.
const BATCH_FRAMES: usize = 16;
/// Pixels that a batch may hold, so that large faces do not multiply: batches shrink instead.
const BATCH_PIXELS: usize = 64 << 20;
/// Tiles are a multiple of this, so that later stages can split them in halves down to blocks.
const TILE_ALIGN: u32 = 8;

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
    settings.check()?;
    let groups = selected_groups(source, settings);
    if groups.is_empty() {
        return Err(Error::Usage(format!("'{}' has no stream of the kinds asked for", source.name())));
    }
    memory::check(source, settings, &groups)?;
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

impl<W: Write> Job<'_, W> {
    fn run(&mut self, groups: &[(usize, &SourceGroup)]) -> Result<()> {
        for probe in 0..self.source.probes().len() {
            let of = |kind: StreamKind| {
                groups.iter().copied().filter(move |(_, group)| group.probe == probe && group.kind == kind)
            };
            for (_, group) in of(StreamKind::Color) {
                let header = CodecHeader::Color(self.settings.color_header());
                self.encode_group(GroupCoder::new(group, header, self.settings)?, |_| None)?;
            }
            let depth: Vec<_> = of(StreamKind::Depth).collect();
            self.encode_depth(&depth)?;
            for (_, group) in of(StreamKind::Material) {
                let header = CodecHeader::Material(self.settings.material_header());
                self.encode_group(GroupCoder::new(group, header, self.settings)?, |_| None)?;
            }
        }
        Ok(())
    }

    fn encode_depth(&mut self, groups: &[(usize, &SourceGroup)]) -> Result<()> {
        if groups.is_empty() {
            return Ok(());
        }
        let found = depth_of_probe(self.source, self.settings, groups, self.monitor)?;
        let ProbeDepth { range, mut kept, reading, scanning } = found;
        self.summary.reading += reading;
        self.summary.scanning += scanning;
        let quantiser = Arc::new(Quantiser::new(range));
        for &(at, group) in groups {
            let header = CodecHeader::Depth(DepthHeader {
                range,
                background: presented_background(self.source.background(), range),
                kind: self.source.depth_stored(),
                coding: self.settings.depth_coding(range)?,
            });
            let mut coder = GroupCoder::new(group, header, self.settings)?;
            coder.quantiser = Some(Arc::clone(&quantiser));
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
        let color_memory = ColorMemory::new(group, &coder.header, self.settings.search, unit_count);
        let mut units = Vec::new();
        for (face, (stream, entry)) in streams.iter().enumerate() {
            for unit in 0..entry.unit_count() {
                let rect = entry.unit_rect(unit);
                units.push(UnitJob::new(&coder, &color_memory, [face as u32, *stream, unit], rect)?);
            }
        }
        let batch = memory::batch_frames(self.source, self.settings, group)?;
        let frames: Vec<u32> = group.frames.iter().collect();
        let (reading, coding) = (AtomicU64::new(0), AtomicU64::new(0));
        let pace = Pace::new(self.monitor, units.len(), group.faces.len());
        for batch in frames.chunks(batch) {
            let inputs: Vec<_> = batch.iter().map(|&frame| (frame, kept(frame))).collect();
            let pictures = try_map_ordered(inputs, |(frame, kept)| {
                self.monitor.check()?;
                coder.read(self.source, frame, kept, &reading, &coding)
            })?;
            let packed = units
                .par_iter_mut()
                .map(|job| timed(&coding, || job.push(&pictures, &coder, &pace)))
                .collect::<Result<Vec<_>>>()?;
            // By frame, then by unit: the same order whatever fits a batch.
            let mut packed: Vec<_> = packed.into_iter().flatten().collect();
            packed.sort_by_key(|(closed_by, _)| *closed_by);
            packed.iter().try_for_each(|(_, chunk)| self.writer.push(chunk))?;
        }
        let packed =
            units.par_iter_mut().map(|job| timed(&coding, || job.finish(&coder))).collect::<Result<Vec<_>>>()?;
        packed.iter().flatten().try_for_each(|chunk| self.writer.push(chunk))?;
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
        let unit = |side: u32| match (group.kind, self.settings.depth.codec) {
            (StreamKind::Color, _) => self.settings.cell.min(MAX_SIZE),
            (StreamKind::Material, _) | (_, DepthCodec::Boxes | DepthCodec::BoxesInBlocks) => {
                tile_side(side, self.settings.tiles)
            }
            (StreamKind::Depth, _) => tile_side(side, self.settings.tiles.max(side.div_ceil(MAX_TILE))),
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
}

/// What is known of a probe's depth before it is coded.
#[derive(Debug)]
pub(super) struct ProbeDepth {
    /// Near and far.
    pub range: DepthRange,
    /// Images that were read to find them, by index of the group and frame.
    pub kept: HashMap<(usize, u32), Vec<DepthPlane>>,
    /// Time that threads spent reading these.
    reading: Duration,
    /// Time that threads spent reading images that were not kept.
    scanning: Duration,
}

/// Near and far of a probe, all of whose depth `groups` (with their indices) are given: as the settings or the manifest
/// say, else as found in the images.
pub(super) fn depth_of_probe(
    source: &Source,
    settings: &EncodeSettings,
    groups: &[(usize, &SourceGroup)],
    monitor: &dyn Monitor,
) -> Result<ProbeDepth> {
    let manifest = source.manifest().and_then(|manifest| manifest.depth.as_ref());
    let near = settings.near_m.or_else(|| manifest.and_then(|depth| depth.near).map(|near| near as f32));
    let far = settings.far_m.or_else(|| manifest.and_then(|depth| depth.far).map(|far| far as f32));
    if let (Some(near), Some(far)) = (near, far) {
        let (range, kept) = (DepthRange::new(near, far)?, HashMap::new());
        return Ok(ProbeDepth { range, kept, reading: Duration::ZERO, scanning: Duration::ZERO });
    }
    let found = scan::scan_probe(source, groups, memory::scan_limits(source, settings, groups)?, monitor)?;
    let probe = groups.first().map_or("", |(_, group)| source.probes()[group.probe].name.as_str());
    let range = found_range(probe, [near, far], &found)?;
    Ok(ProbeDepth { range, kept: found.kept, reading: found.reading, scanning: found.scanning })
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

/// The side of tiles, so that there are at most `tiles` along `side` pixels.
fn tile_side(side: u32, tiles: u32) -> u32 {
    side.div_ceil(tiles).next_multiple_of(TILE_ALIGN)
}
