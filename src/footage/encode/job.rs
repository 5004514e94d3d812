//! Encodes the groups of a source one after the other: reads frames in batches, codes the units of a batch in parallel, and
//! writes chunks ordered by the frame that closed them, then by unit.
//!
//! A batch has as many frames as fit into memory. Chunks are written in the order that batches of one frame would give, so that
//! the bytes depend on neither memory nor threads.

use std::collections::HashMap;
use std::io::Write;
use std::sync::Arc;
use std::time::Duration;

use serde::Serialize;

use crate::dataset::manifest::Pose;
use crate::dataset::{ProbeInfo, SourceGroup};
use crate::encode::budget::{self, ColorMemory};
use crate::encode::depth_range::{ProbeDepth, depth_of_probe, given_range};
use crate::encode::group::{GroupCoder, Times};
use crate::encode::order::Order;
use crate::encode::part::OF_FOOTAGE;
use crate::encode::precision::ProbePrecision;
use crate::encode::resume::{Completed, FrameNote, Note, ScanNote, SearchNote, Stamp, stamps};
use crate::encode::source::{FrameSource, GroupRef, missing_frames, selected_groups};
use crate::encode::unit::{Batch, Closed, Pace, UnitJob, UnitPlace};
use crate::encode::{EncodeSettings, configuration};
use crate::fingerprint::Fingerprint;
use crate::json;
use codec::container::index::{MAX_FRAME, MAX_SIZE};
use codec::container::{Journal, PackedChunk, ProbeEntry, Recovered, StreamEntry, Writer};
use codec::depth::predictive::projection::Shape;
use codec::depth::{DepthRange, Quantiser};
use codec::error::{Error, Result};
use codec::image::{DepthKind, DepthPlane, Face, Projection, StreamKind};
use codec::monitor::Monitor;
use codec::ordered::{try_map_at_once, try_map_ordered};
use codec::streams::{self, CodecHeader, DepthHeader, FootageInfo, FramePose};

/// Units whose last chunks are finished together, with a checkpoint after each such set; a killed process loses at most one set.
const FINISH_UNITS: usize = 64;

/// Statistics of an encode.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct EncodeSummary {
    /// Size of the container in bytes.
    pub bytes: u64,
    /// Uncompressed size in bytes of the same footage, as CALF table 1 counts it (`CodecHeader::raw_pixel_bytes`).
    pub raw_bytes: u64,
    /// Number of images: frames, summed over all streams.
    pub frames: u64,
    /// Number of streams.
    pub streams: usize,
    /// Number of colour pixels that were clipped to 8 bits.
    pub clipped_pixels: u64,
    /// Number of colour pixels.
    pub color_pixels: u64,
    /// Number of depth pixels outside a given near and far, which were replaced.
    pub outside_pixels: u64,
    /// Depth range and error bound of each probe.
    pub depth: Vec<ProbePrecision>,
    /// Number of chunks taken from an earlier run. All other figures except times cover the whole encode.
    pub resumed_chunks: u64,
    /// Total time over all threads of reading and decompressing source files.
    #[serde(rename = "reading_thread_seconds", serialize_with = "json::seconds")]
    pub reading: Duration,
    /// Total time over all threads of reading images only to find near and far.
    #[serde(rename = "scanning_thread_seconds", serialize_with = "json::seconds")]
    pub scanning: Duration,
    /// Total time over all threads of converting, coding and compressing.
    #[serde(rename = "coding_thread_seconds", serialize_with = "json::seconds")]
    pub coding: Duration,
}

impl EncodeSummary {
    pub(super) fn count(&mut self, stream: &StreamEntry, header: &CodecHeader) {
        let frames = u64::from(stream.frame_count);
        let pixels = frames * u64::from(stream.width) * u64::from(stream.height);
        self.frames += frames;
        self.raw_bytes += pixels * header.raw_pixel_bytes();
        self.color_pixels += if stream.kind == StreamKind::Color as u8 { pixels } else { 0 };
        self.streams += 1;
    }
}

#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct EncodeReport {
    #[serde(flatten)]
    pub summary: EncodeSummary,
    /// Equal to `frames` of the summary, under the name that text reports use.
    pub images: u64,
    /// Container size in percent of `raw_bytes`.
    pub ratio_percent: f64,
    pub seconds: f64,
}

impl EncodeReport {
    pub fn new(summary: EncodeSummary, seconds: f64) -> EncodeReport {
        let ratio_percent = 100.0 * summary.bytes as f64 / summary.raw_bytes as f64;
        EncodeReport { images: summary.frames, summary, ratio_percent, seconds }
    }
}

#[derive(Debug)]
pub struct Stopped {
    pub error: Error,
    pub kept: Kept,
}

/// Work that an interrupted encode keeps for a later run to resume.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Kept {
    Nothing,
    /// The unchanged work of an earlier run, which this encode cannot resume.
    Unchanged,
    /// Complete chunks: a description of their number and of the position of the last one.
    Chunks(String),
}

/// Encodes the streams of `source` into `out`, front to back. The monitor advances by one per image.
pub fn encode<W: Write>(
    source: &dyn FrameSource,
    settings: &EncodeSettings,
    out: W,
    monitor: &dyn Monitor,
) -> Result<(W, EncodeSummary)> {
    let plain = Resumable { out, journal: None, recovered: None };
    encode_resumable(source, settings, plain, monitor).map_err(|stopped| stopped.error)
}

pub struct Resumable<W> {
    /// The container: empty, or truncated to the intact bytes that were recovered. Output is appended.
    pub out: W,
    /// The journal, likewise; `None` for an encode that cannot be resumed.
    pub journal: Option<Box<dyn Write + Send>>,
    /// Work recovered from an earlier run; `None` to start from the beginning.
    pub recovered: Option<Recovered>,
}

/// Fails if settings are out of range, the source lacks the requested streams, or the memory budget is too small.
pub fn check(source: &dyn FrameSource, settings: &EncodeSettings) -> Result<()> {
    settings.check()?;
    let groups = selected_groups(source, settings);
    if groups.is_empty() {
        return Err(Error::Usage(format!("'{}' has no stream of the selected kinds", source.name())));
    }
    budget::check(source, settings, &groups)
}

pub fn check_recovered(source: &dyn FrameSource, settings: &EncodeSettings, recovered: &Recovered) -> Result<()> {
    let order = Order::of(source, settings);
    Completed::of(recovered, &configuration::of(source, settings), &order, settings).map(|_| ())
}

/// Returns true if an interrupted encode of a shard has the same settings as this one, but its footage has changed since.
pub fn is_of_changed_footage(
    source: &dyn FrameSource,
    settings: &EncodeSettings,
    recovered: &Recovered,
    monitor: &dyn Monitor,
) -> Result<bool> {
    let now = configuration::of(source, settings);
    let begun = serde_json::from_slice(&recovered.head).map(Fingerprint).unwrap_or_else(|_| now.clone());
    let differing = begun.differing(&now);
    if !differing.is_empty() {
        return Ok(differing.iter().all(|name| OF_FOOTAGE.contains(name)));
    }
    match prepare(source, settings, Some(recovered), &Order::of(source, settings), monitor) {
        Err(Error::Usage(_)) => Ok(true),
        prepared => prepared.map(|_| false),
    }
}

/// Describes the complete chunks of an interrupted encode; `None` if there are none.
pub fn describe_recovered(
    source: &dyn FrameSource,
    settings: &EncodeSettings,
    recovered: &Recovered,
) -> Option<String> {
    Order::of(source, settings).describe(source, recovered.safe())
}

/// As [`encode`], with a journal: an encode that was interrupted at any time resumes after the last complete chunk, and the
/// container has the same bytes as that of an uninterrupted encode.
pub fn encode_resumable<W: Write>(
    source: &dyn FrameSource,
    settings: &EncodeSettings,
    resumable: Resumable<W>,
    monitor: &dyn Monitor,
) -> Result<(W, EncodeSummary), Stopped> {
    let order = Order::of(source, settings);
    let recovered = resumable.recovered.as_ref();
    let kept = |safe| order.describe(source, safe).map_or(Kept::Nothing, Kept::Chunks);
    let before = recovered.map(Recovered::safe).unwrap_or_default();
    let continues = recovered.is_some();
    let completed = prepare(source, settings, recovered, &order, monitor).map_err(|error| {
        let kept = match (&error, continues) {
            (_, false) => Kept::Nothing,
            (Error::Usage(_), true) => Kept::Unchanged,
            (_, true) => kept(before),
        };
        Stopped { error, kept }
    })?;
    let summary = EncodeSummary { resumed_chunks: completed.chunks, ..EncodeSummary::default() };
    let writer = open(source, settings, resumable).map_err(|error| Stopped { error, kept: kept(before) })?;
    let mut job = Job { source, settings, writer, monitor, completed, summary, footage: FootageInfo::default() };
    let ran = job.run(&selected_groups(source, settings));
    let Job { mut writer, mut summary, mut footage, .. } = job;
    footage.clipped_pixels = Some(summary.clipped_pixels).filter(|count| *count > 0);
    for (name, value) in footage.to_values() {
        writer.set_attribute(name, value);
    }
    let written = kept(writer.safe());
    match ran.and_then(|()| writer.finish_checked(streams::check_written)) {
        Ok((out, bytes)) => {
            summary.bytes = bytes;
            Ok((out, summary))
        }
        // Running the same command again would fail in the same way.
        Err(error @ Error::Usage(_)) if continues => Err(Stopped { error, kept: Kept::Unchanged }),
        Err(error) => Err(Stopped { error, kept: written }),
    }
}

/// Runs all checks that are possible before anything is written.
fn prepare(
    source: &dyn FrameSource,
    settings: &EncodeSettings,
    recovered: Option<&Recovered>,
    order: &Order<'_>,
    monitor: &dyn Monitor,
) -> Result<Completed> {
    check(source, settings)?;
    let Some(recovered) = recovered else { return Ok(Completed::default()) };
    let mut completed = Completed::of(recovered, &configuration::of(source, settings), order, settings)?;
    completed.check_files(source, settings, order, monitor)?;
    Ok(completed)
}

/// Opens a writer at the start of the container, or after the recovered chunks, and adds the probes.
fn open<W: Write>(source: &dyn FrameSource, settings: &EncodeSettings, to: Resumable<W>) -> Result<Writer<W>> {
    let projection = u8::from(source.projection() == Projection::Perspective);
    let (name, fps) = (source.name(), source.fps());
    let mut writer = match (to.journal, to.recovered) {
        (Some(journal), Some(recovered)) => {
            let journal = Journal::go_on(journal, &recovered);
            Writer::go_on(to.out, name, fps, projection, (recovered, journal))
        }
        (Some(journal), None) => {
            let head = configuration::to_bytes(&configuration::of(source, settings).0)?;
            Writer::new(to.out, name, fps, projection)?.with_journal(Journal::start(journal, &head))
        }
        (None, _) => Writer::new(to.out, name, fps, projection)?,
    };
    for (name, value) in source.attributes().iter() {
        writer.set_attribute(name, value.to_vec());
    }
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
    source: &'a dyn FrameSource,
    settings: &'a EncodeSettings,
    writer: Writer<W>,
    monitor: &'a dyn Monitor,
    completed: Completed,
    summary: EncodeSummary,
    footage: FootageInfo,
}

/// The streams of a group, and the frames at which their units resume.
struct Part {
    at: usize,
    /// One stream per face, with its number.
    streams: Vec<(u32, StreamEntry)>,
    /// Number of frames of each unit that an earlier run has coded, face by face.
    starts: Vec<u32>,
}

impl Part {
    /// Number of frames that an earlier run has coded in all units.
    fn complete_frames(&self) -> u32 {
        self.starts.iter().min().copied().unwrap_or(0)
    }
}

impl<W: Write> Job<'_, W> {
    fn run(&mut self, groups: &[GroupRef<'_>]) -> Result<()> {
        for probe in 0..self.source.probes().len() {
            for kind in StreamKind::ALL {
                let is_next = |group: &&GroupRef<'_>| group.group.probe == probe && group.group.kind == kind;
                let groups: Vec<GroupRef<'_>> = groups.iter().filter(is_next).copied().collect();
                match kind {
                    StreamKind::Depth => self.encode_depth(&groups)?,
                    StreamKind::Color => {
                        self.encode_others(&groups, CodecHeader::Color(self.settings.color_header()))?
                    }
                    StreamKind::Material => {
                        self.encode_others(&groups, CodecHeader::Material(self.settings.material_header()))?;
                    }
                    StreamKind::Alpha => {
                        self.encode_others(&groups, CodecHeader::Alpha(self.settings.alpha_header()))?;
                    }
                }
            }
        }
        Ok(())
    }

    fn encode_others(&mut self, groups: &[GroupRef<'_>], header: CodecHeader) -> Result<()> {
        for &group in groups {
            let Some(part) = self.begin(group, &header)? else { continue };
            self.encode_group(&part, &GroupCoder::new(group.group, header.clone(), self.settings)?, |_| None)?;
        }
        Ok(())
    }

    fn encode_depth(&mut self, groups: &[GroupRef<'_>]) -> Result<()> {
        let Some(first) = groups.first() else { return Ok(()) };
        let probe = first.group.probe;
        let noted = || self.completed.scans.get(&probe).map(|note| note.scan.clone());
        let known = self.source.scans().and_then(|scans| scans.get(&probe).cloned()).or_else(noted);
        // Stamps must be taken before the files are read.
        let scans = known.is_none() && given_range(self.source, self.settings).contains(&None);
        let files = if scans { stamps(self.source, groups)? } else { HashMap::new() };
        let ProbeDepth { range, levels, strays, scanned } =
            depth_of_probe(self.source, self.settings, groups, known.as_ref(), self.monitor)?;
        let (mut kept, mut note) = (HashMap::new(), None);
        if let Some(scanned) = scanned {
            let scan_note = ScanNote { scan: scanned.found.scan(), files };
            self.writer.note(&scan_note.to_bytes(probe)?);
            self.writer.checkpoint()?;
            self.summary.reading += scanned.reading;
            self.summary.scanning += scanned.scanning;
            (kept, note) = (scanned.kept, Some(scan_note));
        }
        let mut quantiser = None;
        for &group in groups {
            let header = CodecHeader::Depth(DepthHeader {
                range,
                background: presented_background(self.source.background(), range),
                kind: self.source.depth_kind(),
                coding: self
                    .settings
                    .depth_coding(range, self.shape_of(group.group), &levels)
                    .map_err(|error| error.context(format!("probe {}", self.source.probes()[probe].name)))?,
            });
            if group.at == first.at
                && let CodecHeader::Depth(header) = &header
            {
                self.summary.depth.push(ProbePrecision::new(self.source, probe, header, strays.as_ref()));
            }
            let Some(part) = self.begin(group, &header)? else { continue };
            let mut coder = GroupCoder::new(group.group, header, self.settings)?;
            coder.quantiser = Some(Arc::clone(quantiser.get_or_insert_with(|| Arc::new(Quantiser::new(range)))));
            self.encode_group(&part, &coder, |frame| {
                let planes = kept.remove(&(group.at, frame))?;
                Some((*note.as_ref()?.files.get(&(group.at, frame))?, planes))
            })?;
        }
        Ok(())
    }

    /// Relation of a pixel's depth to the viewing axis; unknown for the distances of a perspective view.
    fn shape_of(&self, group: &SourceGroup) -> Shape {
        match (self.source.depth_kind(), group.faces == [Face::View]) {
            (DepthKind::Planar, _) => Shape::Planar,
            (DepthKind::Distance, false) if group.width == group.height => Shape::CubeDistance,
            _ => Shape::None,
        }
    }

    /// Declares the streams of a group; returns `None` if an earlier run has completed it.
    fn begin(&mut self, group_ref: GroupRef<'_>, header: &CodecHeader) -> Result<Option<Part>> {
        let GroupRef { at, group } = group_ref;
        let streams = self.declare_streams(group, header)?;
        let first = group.frames.first;
        let units = streams.iter().flat_map(|(stream, entry)| (0..entry.unit_count()).map(move |unit| (*stream, unit)));
        let starts = units.map(|(stream, unit)| self.completed.start(stream, unit, first) - first).collect();
        let part = Part { at, streams, starts };
        let complete = part.complete_frames();
        let before = group.frames.iter().take(complete as usize);
        let beyond = before.map(|frame| self.completed.beyond(at, frame)).sum();
        self.count_beyond(group.kind, beyond);
        if u64::from(complete) < group.frames.count() {
            return Ok(Some(part));
        }
        self.monitor.advance(group_ref.images());
        self.monitor.check().map(|()| None)
    }

    fn count_beyond(&mut self, kind: StreamKind, pixels: u64) {
        match kind {
            StreamKind::Depth => self.summary.outside_pixels += pixels,
            _ => self.summary.clipped_pixels += pixels,
        }
    }

    fn encode_group(
        &mut self,
        part: &Part,
        coder: &GroupCoder<'_>,
        mut kept: impl FnMut(u32) -> Option<(Stamp, Vec<DepthPlane>)>,
    ) -> Result<()> {
        let group = coder.group;
        let mut units = self.unit_jobs(part, coder)?;
        let batches = budget::batches(self.source, self.settings, group)?;
        let frames: Vec<u32> = group.frames.iter().skip(part.complete_frames() as usize).collect();
        let last_used = self.completed.last_frame(part.streams.iter().map(|(stream, _)| *stream));
        let times = Times::default();
        let pace = Pace::new(self.monitor, units.len(), group.faces.len());
        pace.advance(part.starts.iter().copied().map(u64::from).sum());
        // A colour cell looks ahead; chunks of other kinds depend only on their own frames.
        let last_frame = |chunk: &PackedChunk, closed_by: u32| match group.kind {
            StreamKind::Color => closed_by,
            StreamKind::Depth | StreamKind::Material | StreamKind::Alpha => chunk.key().last_frame(),
        };
        for frames in frames.chunks(batches.frames) {
            let inputs: Vec<_> = frames.iter().map(|&frame| (frame, kept(frame))).collect();
            let read = try_map_ordered(inputs, |(frame, kept)| {
                self.monitor.check()?;
                let (stamp, kept) = match kept {
                    Some((stamp, planes)) => (stamp, Some(planes)),
                    None => (Stamp::of(self.source, group, frame)?, None),
                };
                if last_used.is_some_and(|last| frame <= last) {
                    self.completed.check_file(self.source, GroupRef { at: part.at, group }, frame, stamp)?;
                }
                let (picture, beyond) = coder.read(self.source, frame, kept, &times)?;
                Ok((FrameNote { stamp, beyond }, picture))
            })?;
            let (notes, pictures): (Vec<_>, Vec<_>) = read.into_iter().unzip();
            self.count_beyond(group.kind, notes.iter().map(|note| note.beyond).sum());
            self.writer.note(&configuration::to_bytes(&Note::Frames { group: part.at, first: frames[0], notes })?);
            let batch = Batch { first: frames[0] - group.frames.first, pictures };
            let packed = try_map_at_once(units.iter_mut().collect(), batches.units_at_once, |unit: &mut UnitJob| {
                times.code(|| unit.push(&batch, coder, &pace))
            })?;
            // Sort by frame, then by unit, so that the order does not depend on the size of the batch.
            let mut packed: Vec<_> = packed.into_iter().flatten().collect();
            packed.sort_by_key(|closed| closed.by);
            let searches: Vec<_> = packed.iter().filter_map(SearchNote::of).collect();
            if !searches.is_empty() {
                self.writer.note(&configuration::to_bytes(&Note::Searches(searches))?);
            }
            let push =
                |closed: &Closed| self.writer.push_after(&closed.chunk, last_frame(&closed.chunk, frames[closed.by]));
            packed.iter().try_for_each(push)?;
            self.writer.checkpoint()?;
        }
        for units in units.chunks_mut(FINISH_UNITS) {
            self.monitor.check()?;
            let finish = |unit: &mut UnitJob| times.code(|| unit.finish(coder));
            let packed = try_map_at_once(units.iter_mut().collect(), batches.units_at_once, finish)?;
            let push = |chunk: &PackedChunk| self.writer.push_after(chunk, last_frame(chunk, group.frames.last));
            packed.iter().flatten().try_for_each(push)?;
            self.writer.checkpoint()?;
        }
        let [reading, coding] = times.into_durations();
        self.summary.reading += reading;
        self.summary.coding += coding;
        Ok(())
    }

    fn unit_jobs(&self, part: &Part, coder: &GroupCoder<'_>) -> Result<Vec<UnitJob>> {
        let unit_count = part.streams.iter().map(|(_, entry)| entry.unit_count()).sum();
        let memory = ColorMemory::new(coder.group, &coder.header, self.settings.search, unit_count);
        let units = part.streams.iter().enumerate().flat_map(|(face, (stream, entry))| {
            (0..entry.unit_count()).map(move |unit| (face, *stream, unit, entry.unit_rect(unit)))
        });
        units
            .zip(&part.starts)
            .map(|((face, stream, unit, rect), &start)| {
                let search = self.completed.search(stream, unit);
                UnitJob::new(coder, memory, UnitPlace { face, stream, unit, rect, start, search })
            })
            .collect()
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
            .filter(|_| group.frames.last < MAX_FRAME)
            .ok_or_else(|| Error::unsupported(format!("frames {}: numbers must be below 2^31", group.frames)))?;
        let [unit_width, unit_height] = self.settings.unit_size(group.kind, [group.width, group.height]);
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
                codec_header: header.write().into(),
            };
            self.summary.count(&entry, header);
            streams.push((self.writer.add_stream(entry.clone()), entry));
        }
        self.note_footage(group);
        Ok(streams)
    }

    fn note_footage(&mut self, group: &SourceGroup) {
        if group.kind == StreamKind::Color {
            self.footage.primaries = self.source.primaries();
        }
        let ProbeInfo { name: probe, poses, .. } = &self.source.probes()[group.probe];
        let poses = poses.iter().filter(|pose| group.frames.contains(pose.frame));
        self.footage.poses.extend(poses.map(|&Pose { frame, position, orientation }| FramePose {
            probe: probe.clone(),
            frame,
            position,
            orientation,
        }));
        self.footage.missing_frames.extend(missing_frames(self.source, group));
    }
}

/// Returns the background value that decoders output: the value of the source files, or +inf if that value lies between near and
/// far and could be taken for a surface. (The value is in the unit of the files, near and far are in metres.)
fn presented_background(value: f32, range: DepthRange) -> f32 {
    if (range.near_m()..=range.far_m()).contains(&value) { f32::INFINITY } else { value }
}
