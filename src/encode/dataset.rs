//! Encodes a dataset: reads frames, feeds the unit encoders, writes chunks.
//!
//! The order of chunks in the file, and so its bytes, depend on nothing but input and options: frames are read in
//! batches, units of a batch are coded in parallel, and chunks are written in the order of the frames that closed them,
//! those of one frame by unit.

use std::collections::HashMap;
use std::io::Write;
use std::sync::Arc;
use std::sync::atomic::AtomicU64;
use std::time::Duration;

use rayon::prelude::*;

use crate::container::index::MAX_SIZE;
use crate::container::{Journal, PackedChunk, ProbeEntry, Recovered, StreamEntry, Writer};
use crate::dataset::source::{Source, SourceGroup};
use crate::dataset::stream::{Projection, StreamKind};
use crate::depth::block::MAX_TILE;
use crate::depth::quantise::{DepthRange, Quantiser};
use crate::encode::scan;
use crate::error::{Error, Result};
use crate::image::plane::DepthPlane;
use crate::monitor::Monitor;
use crate::ordered::try_map_ordered;
use crate::streams;
use crate::streams::{CodecHeader, ColorFormat, ColorHeader, DepthHeader};

use crate::encode::resume::{Done, FrameNote, Order, ScanNote, Stamp, note_of_frames};
pub use crate::encode::resume::{Left, Stopped};
pub use crate::encode::settings::{
    ColorBlockSettings, DepthCodec, DepthSettings, EncodeSettings, ErrorBound, MaterialSettings, TileSize,
};
use crate::encode::unit::{Batch, ColorMemory, GroupCoder, Pace, UnitJob, timed};

/// Frames read and coded together. The file does not depend on it.
pub(crate) const BATCH_FRAMES: usize = 16;
/// Pixels that a batch may hold, so that large faces do not multiply: batches shrink instead.
pub(crate) const BATCH_PIXELS: usize = 64 << 20;
/// Units whose last chunks are made together, so that a process that is killed then loses no more.
const FINISH_UNITS: usize = 64;

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
    /// Chunks that an earlier run had completed. All other figures but times are of the whole encode.
    pub resumed_chunks: u64,
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
    run(source, settings, Sink::Plain(out), monitor).map_err(|stopped| stopped.error)
}

/// Where an encode that may be stopped writes to.
pub struct Resumable<W> {
    /// The container: empty, or the sound part of what was recovered, behind which it is appended to.
    pub out: W,
    /// The journal, likewise.
    pub journal: Box<dyn Write + Send>,
    /// What an earlier run has left; `None` to start anew.
    pub recovered: Option<Recovered>,
}

/// The same with a journal, by which an encode that was stopped at any moment goes on at the last complete chunk. The
/// container comes to the same bytes as one that was written in one go.
///
/// # Errors
/// [`Stopped`] tells why, and whether there is something to go on with.
pub fn encode_resumable<W: Write>(
    source: &Source,
    settings: &EncodeSettings,
    resumable: Resumable<W>,
    monitor: &dyn Monitor,
) -> Result<(W, EncodeSummary), Stopped> {
    run(source, settings, Sink::Resumable(resumable), monitor)
}

/// Refuses settings that no encoder could follow, and a source without what they ask for.
///
/// # Errors
/// [`Error::Usage`].
pub fn check(source: &Source, settings: &EncodeSettings) -> Result<()> {
    settings.check()?;
    let groups = selected_groups(source, settings);
    if groups.is_empty() {
        return Err(Error::Usage(format!("'{}' has no stream of the kinds asked for", source.name())));
    }
    crate::encode::memory::check(source, settings, &groups)
}

/// Refuses to go on with what was recovered where it is of another encode.
///
/// # Errors
/// [`Error::Usage`] tells what differs.
pub fn check_recovered(source: &Source, settings: &EncodeSettings, recovered: &Recovered) -> Result<()> {
    Done::of(recovered, &crate::encode::fingerprint::of(source, settings), &Order::of(source, settings)).map(|_| ())
}

/// What of an unfinished encode is safe, in words; `None` where nothing is.
pub fn describe_recovered(source: &Source, settings: &EncodeSettings, recovered: &Recovered) -> Option<String> {
    Order::of(source, settings).describe(source, recovered.safe())
}

enum Sink<W> {
    Plain(W),
    Resumable(Resumable<W>),
}

fn run<W: Write>(
    source: &Source,
    settings: &EncodeSettings,
    sink: Sink<W>,
    monitor: &dyn Monitor,
) -> Result<(W, EncodeSummary), Stopped> {
    let order = Order::of(source, settings);
    let recovered = match &sink {
        Sink::Resumable(Resumable { recovered, .. }) => recovered.as_ref(),
        Sink::Plain(_) => None,
    };
    let before = recovered.map(Recovered::safe).unwrap_or_default();
    let goes_on = recovered.is_some();
    let begun = prepare(source, settings, recovered, &order, monitor);
    let done = begun.map_err(|error| {
        let left = match (&error, recovered) {
            (_, None) => Left::Nothing,
            (Error::Usage(_), Some(_)) => Left::AsItWas,
            (_, Some(_)) => left_of(order.describe(source, before)),
        };
        Stopped { error, left }
    })?;
    let resumed_chunks = done.chunks;
    let writer = open(source, settings, sink)
        .map_err(|error| Stopped { error, left: left_of(order.describe(source, before)) })?;
    let summary = EncodeSummary { resumed_chunks, ..EncodeSummary::default() };
    let mut job = Job { source, settings, writer, monitor, done, summary };
    let ran = job.run(&selected_groups(source, settings));
    let Job { writer, mut summary, .. } = job;
    let left = left_of(order.describe(source, writer.safe()));
    match ran.and_then(|()| writer.finish_checked(streams::check_written)) {
        Ok((out, bytes)) => {
            summary.bytes = bytes;
            Ok((out, summary))
        }
        // The same command would be refused again.
        Err(error @ Error::Usage(_)) if goes_on => Err(Stopped { error, left: Left::AsItWas }),
        Err(error) => Err(Stopped { error, left }),
    }
}

fn left_of(safe: Option<String>) -> Left {
    safe.map_or(Left::Nothing, Left::Chunks)
}

/// Checks everything that can be checked before anything is written.
fn prepare(
    source: &Source,
    settings: &EncodeSettings,
    recovered: Option<&Recovered>,
    order: &Order<'_>,
    monitor: &dyn Monitor,
) -> Result<Done> {
    check(source, settings)?;
    let Some(recovered) = recovered else { return Ok(Done::default()) };
    let mut done = Done::of(recovered, &crate::encode::fingerprint::of(source, settings), order)?;
    done.check_files(source, settings, order, monitor)?;
    Ok(done)
}

/// A writer at the start of the container, or behind what was recovered, that knows the probes.
fn open<W: Write>(source: &Source, settings: &EncodeSettings, sink: Sink<W>) -> Result<Writer<W>> {
    let projection = u8::from(source.projection() == Projection::Perspective);
    let (name, fps) = (source.name(), source.fps());
    let mut writer = match sink {
        Sink::Plain(out) => Writer::new(out, name, fps, projection)?,
        Sink::Resumable(Resumable { out, journal, recovered: Some(recovered) }) => {
            let journal = Journal::go_on(journal, &recovered);
            Writer::go_on(out, name, fps, projection, (recovered, journal))
        }
        Sink::Resumable(Resumable { out, journal, recovered: None }) => {
            let head = crate::encode::fingerprint::write(&crate::encode::fingerprint::of(source, settings))?;
            Writer::new(out, name, fps, projection)?.with_journal(Journal::start(journal, &head))
        }
    };
    for probe in source.probes() {
        writer.add_probe(ProbeEntry {
            name: probe.name.clone(),
            position: probe.position,
            orientation: probe.orientation,
            frames: [probe.frames.first, probe.frames.last],
            intrinsics: probe.intrinsics.unwrap_or_default(),
        })?;
    }
    Ok(writer)
}

struct Job<'a, W: Write> {
    source: &'a Source,
    settings: &'a EncodeSettings,
    writer: Writer<W>,
    monitor: &'a dyn Monitor,
    done: Done,
    summary: EncodeSummary,
}

/// What is to be done of a group.
struct Part {
    /// Index of the group.
    at: usize,
    /// The streams of its faces.
    streams: Vec<(u32, StreamEntry)>,
    /// Frames of each unit that were done before, face by face.
    starts: Vec<u32>,
}

impl<W: Write> Job<'_, W> {
    fn run(&mut self, groups: &[(usize, &SourceGroup)]) -> Result<()> {
        for probe in 0..self.source.probes().len() {
            let of = |kind: StreamKind| {
                groups.iter().copied().filter(move |(_, group)| group.probe == probe && group.kind == kind)
            };
            for (at, group) in of(StreamKind::Color) {
                let header = CodecHeader::Color(self.settings.color_header());
                let Some(part) = self.begin((at, group), &header)? else { continue };
                self.encode_group(part, GroupCoder::new(group, header, self.settings)?, |_| None)?;
            }
            let depth: Vec<_> = of(StreamKind::Depth).collect();
            self.encode_depth(&depth)?;
            for (at, group) in of(StreamKind::Material) {
                let header = CodecHeader::Material(self.settings.material_header());
                let Some(part) = self.begin((at, group), &header)? else { continue };
                self.encode_group(part, GroupCoder::new(group, header, self.settings)?, |_| None)?;
            }
        }
        Ok(())
    }

    fn encode_depth(&mut self, groups: &[(usize, &SourceGroup)]) -> Result<()> {
        let Some((_, first)) = groups.first() else { return Ok(()) };
        let known = self.done.scans.get(&first.probe);
        let found = depth_known(self.source, self.settings, groups, (known, self.monitor))?;
        let ProbeDepth { range, mut kept, reading, scanning, scan } = found;
        if let Some(scan) = &scan {
            self.writer.note(&scan.write(first.probe));
            self.writer.checkpoint()?;
        }
        self.summary.reading += reading;
        self.summary.scanning += scanning;
        let mut quantiser = None;
        for &(at, group) in groups {
            let header = CodecHeader::Depth(DepthHeader {
                range,
                background: presented_background(self.source.background(), range),
                kind: self.source.depth_stored(),
                coding: self.settings.depth_coding(range)?,
            });
            let Some(part) = self.begin((at, group), &header)? else { continue };
            let mut coder = GroupCoder::new(group, header, self.settings)?;
            coder.quantiser = Some(Arc::clone(quantiser.get_or_insert_with(|| Arc::new(Quantiser::new(range)))));
            self.encode_group(part, coder, |frame| {
                let planes = kept.remove(&(at, frame))?;
                Some((*scan.as_ref()?.files.get(&(at, frame))?, planes))
            })?;
        }
        Ok(())
    }

    /// Declares the streams of a group; `None` where an earlier run has done all of it.
    fn begin(&mut self, (at, group): (usize, &SourceGroup), header: &CodecHeader) -> Result<Option<Part>> {
        let streams = self.declare_streams(group, header)?;
        let first = group.frames.first;
        let units = streams.iter().flat_map(|(stream, entry)| (0..entry.unit_count()).map(move |unit| (*stream, unit)));
        let starts: Vec<u32> = units.map(|(stream, unit)| self.done.start(stream, unit, first) - first).collect();
        let whole = starts.iter().min().copied().unwrap_or(0);
        let before = group.frames.iter().take(whole as usize);
        self.summary.clipped_pixels += before.map(|frame| self.done.clipped(at, frame)).sum::<u64>();
        if u64::from(whole) < group.frames.count() {
            return Ok(Some(Part { at, streams, starts }));
        }
        self.monitor.advance(group.frames.count() * group.faces.len() as u64);
        self.monitor.check().map(|()| None)
    }

    fn encode_group(
        &mut self,
        Part { at, streams, starts }: Part,
        coder: GroupCoder<'_>,
        mut kept: impl FnMut(u32) -> Option<(Stamp, Vec<DepthPlane>)>,
    ) -> Result<()> {
        let group = coder.group;
        let unit_count = streams.iter().map(|(_, entry)| entry.unit_count()).sum();
        let color_memory = ColorMemory::new(group, &coder.header, self.settings.search, unit_count);
        let mut units = Vec::new();
        let mut before = starts.iter().copied();
        for (face, (stream, entry)) in streams.iter().enumerate() {
            for (unit, start) in (0..entry.unit_count()).zip(&mut before) {
                let rect = entry.unit_rect(unit);
                let job = UnitJob::new(&coder, &color_memory, [face as u32, *stream, unit], rect)?;
                units.push(job.starting_at(start));
            }
        }
        let batch = crate::encode::memory::batch_frames(self.source, self.settings, group)?;
        let whole = starts.iter().min().copied().unwrap_or(0);
        let frames: Vec<u32> = group.frames.iter().skip(whole as usize).collect();
        let rests = self.done.last_frame(streams.iter().map(|(stream, _)| *stream));
        let (reading, coding) = (AtomicU64::new(0), AtomicU64::new(0));
        let pace = Pace::new(self.monitor, units.len(), group.faces.len());
        pace.skip(starts.iter().copied().map(u64::from).sum());
        // A colour cell is searched ahead; other chunks depend on none but their own frames.
        let last_frame = |chunk: &PackedChunk, closed_by: u32| match group.kind {
            StreamKind::Color => closed_by,
            StreamKind::Depth | StreamKind::Material => chunk.key.first_frame + (chunk.key.frame_count - 1),
        };
        for frames in frames.chunks(batch) {
            let inputs: Vec<_> = frames.iter().map(|&frame| (frame, kept(frame))).collect();
            let read = try_map_ordered(inputs, |(frame, kept)| {
                self.monitor.check()?;
                let (stamp, kept) = match kept {
                    Some((stamp, planes)) => (stamp, Some(planes)),
                    None => (Stamp::of(&self.source.file(group, frame)?)?, None),
                };
                if rests.is_some_and(|last| frame <= last) {
                    self.done.check_file(self.source, (at, group, frame), stamp)?;
                }
                let (picture, clipped) = coder.read(self.source, frame, kept, &reading, &coding)?;
                Ok((FrameNote { stamp, clipped }, picture))
            })?;
            let (notes, pictures): (Vec<_>, Vec<_>) = read.into_iter().unzip();
            self.writer.note(&note_of_frames(at, frames[0], &notes));
            self.summary.clipped_pixels += notes.iter().map(|note| note.clipped).sum::<u64>();
            let batch = Batch { first: frames[0] - group.frames.first, pictures };
            let packed = units
                .par_iter_mut()
                .map(|job| timed(&coding, || job.push(&batch, &coder, &pace)))
                .collect::<Result<Vec<_>>>()?;
            // By frame, then by unit: the same order whatever fits a batch.
            let mut packed: Vec<_> = packed.into_iter().flatten().collect();
            packed.sort_by_key(|(closed_by, _)| *closed_by);
            let push = |(closed_by, chunk): &(usize, PackedChunk)| {
                self.writer.push_after(chunk, last_frame(chunk, frames[*closed_by]))
            };
            packed.iter().try_for_each(push)?;
            self.writer.checkpoint()?;
        }
        for units in units.chunks_mut(FINISH_UNITS) {
            self.monitor.check()?;
            let packed =
                units.par_iter_mut().map(|job| timed(&coding, || job.finish(&coder))).collect::<Result<Vec<_>>>()?;
            let push = |chunk: &PackedChunk| self.writer.push_after(chunk, last_frame(chunk, group.frames.last));
            packed.iter().flatten().try_for_each(push)?;
            self.writer.checkpoint()?;
        }
        self.summary.reading += Duration::from_nanos(reading.into_inner());
        self.summary.coding += Duration::from_nanos(coding.into_inner());
        Ok(())
    }

    fn declare_streams(&mut self, group: &SourceGroup, header: &CodecHeader) -> Result<Vec<(u32, StreamEntry)>> {
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
                self.settings.tiles.side(side, u32::MAX)
            }
            (StreamKind::Depth, _) => self.settings.tiles.side(side, MAX_TILE),
        };
        let (unit_width, unit_height) = (unit(group.width), unit(group.height));
        let mut streams = Vec::new();
        for &face in &group.faces {
            let entry = StreamEntry {
                kind: group.kind as u8,
                face: face as u8,
                probe: group.probe as u16,
                codec: header.codec(),
                width: group.width,
                height: group.height,
                first_frame: group.frames.first,
                frame_count,
                unit_width,
                unit_height,
                codec_header: header.write(),
            };
            let images = u64::from(frame_count);
            let pixels = images * u64::from(group.width) * u64::from(group.height);
            self.summary.frames += images;
            self.summary.raw_bytes += pixels * raw_pixel_bytes(header);
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
    /// What was found, where nobody knew before.
    scan: Option<ScanNote>,
}

/// Near and far as the settings or the manifest say.
pub(super) fn given_range(source: &Source, settings: &EncodeSettings) -> [Option<f32>; 2] {
    let manifest = source.manifest().and_then(|manifest| manifest.depth.as_ref());
    let near = settings.near_m.or_else(|| manifest.and_then(|depth| depth.near).map(|near| near as f32));
    let far = settings.far_m.or_else(|| manifest.and_then(|depth| depth.far).map(|far| far as f32));
    [near, far]
}

/// Near and far of a probe, all of whose depth `groups` (with their indices) are given: as the settings or the manifest
/// say, else as found in the images.
pub(super) fn depth_of_probe(
    source: &Source,
    settings: &EncodeSettings,
    groups: &[(usize, &SourceGroup)],
    monitor: &dyn Monitor,
) -> Result<ProbeDepth> {
    depth_known(source, settings, groups, (None, monitor))
}

/// The same where an earlier run may have looked at the images.
fn depth_known(
    source: &Source,
    settings: &EncodeSettings,
    groups: &[(usize, &SourceGroup)],
    (known, monitor): (Option<&ScanNote>, &dyn Monitor),
) -> Result<ProbeDepth> {
    let given = given_range(source, settings);
    let (reading, scanning) = (Duration::ZERO, Duration::ZERO);
    if let [Some(near), Some(far)] = given {
        let (range, kept) = (DepthRange::new(near, far)?, HashMap::new());
        return Ok(ProbeDepth { range, kept, reading, scanning, scan: None });
    }
    let probe = groups.first().map_or("", |(_, group)| source.probes()[group.probe].name.as_str());
    if let Some(known) = known {
        let (range, kept) = (found_range(probe, given, known)?, HashMap::new());
        return Ok(ProbeDepth { range, kept, reading, scanning, scan: None });
    }
    let (scan, found) =
        ScanNote::make(source, groups, crate::encode::memory::scan_limits(source, settings, groups)?, monitor)?;
    let range = found_range(probe, given, &scan)?;
    let scan::ProbeScan { kept, reading, scanning, .. } = found;
    Ok(ProbeDepth { range, kept, reading, scanning, scan: Some(scan) })
}

/// The range of a probe from what was given and what was found; at most one of near and far is given.
fn found_range(probe: &str, given: [Option<f32>; 2], found: &ScanNote) -> Result<DepthRange> {
    let Some((nearest, farthest)) = found.extent else {
        return match given[0].or(given[1]) {
            Some(bound) => DepthRange::new(bound, bound),
            None if found.taken_as_near => Err(Error::invalid(format!(
                "probe {probe} has no valid depth at all, so that invalid ones cannot be taken as its nearest: give `near`"
            ))),
            None => Ok(DepthRange::empty()),
        };
    };
    let (near, far) = (given[0].unwrap_or(nearest), given[1].unwrap_or(farthest));
    DepthRange::new(near, far).map_err(|_| {
        Error::Usage(format!(
            "probe {probe}: near {near} m and far {far} m hold no depth; what was not given was found in the footage, \
             whose surfaces lie from {nearest} m to {farthest} m"
        ))
    })
}

/// What a decoder writes where nothing is: the value that the source files had there, unless it could be taken for a
/// surface. (It is in the files' unit, surfaces are in metres.)
fn presented_background(value: f32, range: DepthRange) -> f32 {
    if (range.near_m()..=range.far_m()).contains(&value) { f32::INFINITY } else { value }
}
