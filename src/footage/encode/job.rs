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
use crate::encode::depth_range::{ProbeDepth, depth_of_probe};
use crate::encode::group::{Coded, GroupCoder, timed};
use crate::encode::part::OF_FOOTAGE;
use crate::encode::plan::{GroupPlan, Plan};
use crate::encode::precision::ProbePrecision;
use crate::encode::resume::{Completed, FrameNote, Note, ScanNote, SearchNote, Stamp, stamps};
use crate::encode::source::{FrameSource, missing_frames};
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

/// Error of an encode that failed, and the work that it keeps.
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

pub struct Resumable<W> {
    /// The container: empty, or truncated to the intact bytes that were recovered. Output is appended.
    pub out: W,
    /// The journal, likewise; `None` for an encode that cannot be resumed.
    pub journal: Option<Box<dyn Write + Send>>,
    /// Work recovered from an earlier run; `None` to start from the beginning.
    pub recovered: Option<Recovered>,
}

/// Encodes the streams of `source` into `out`, front to back. The monitor advances by one per image.
pub fn encode<W: Write>(
    source: &dyn FrameSource,
    settings: &EncodeSettings,
    out: W,
    monitor: &dyn Monitor,
) -> Result<(W, EncodeSummary)> {
    Plan::new(source, settings).encode(out, monitor)
}

impl Plan<'_> {
    /// Encodes all streams into `out`, front to back. The monitor advances by one per image.
    pub fn encode<W: Write>(&self, out: W, monitor: &dyn Monitor) -> Result<(W, EncodeSummary)> {
        let plain = Resumable { out, journal: None, recovered: None };
        self.encode_resumable(plain, monitor).map_err(|stopped| stopped.error)
    }

    /// Fails if an interrupted encode has other settings or footage than this one.
    pub fn check_recovered(&self, recovered: &Recovered) -> Result<()> {
        Completed::of(self, recovered).map(|_| ())
    }

    /// Returns true if an interrupted encode of a shard has the same settings as this one, but its footage has changed since.
    pub fn is_of_changed_footage(&self, recovered: &Recovered, monitor: &dyn Monitor) -> Result<bool> {
        let now = configuration::of(self.source, self.settings);
        let begun = serde_json::from_slice(&recovered.head).map(Fingerprint).unwrap_or_else(|_| now.clone());
        let differing = begun.differing(&now);
        if !differing.is_empty() {
            return Ok(differing.iter().all(|name| OF_FOOTAGE.contains(name)));
        }
        match self.prepare(Some(recovered), monitor) {
            Err(Error::Usage(_)) => Ok(true),
            prepared => prepared.map(|_| false),
        }
    }

    /// As [`Self::encode`], with a journal: an encode that was interrupted at any time resumes after the last complete chunk, and
    /// the container has the same bytes as that of an uninterrupted encode.
    pub fn encode_resumable<W: Write>(
        &self,
        resumable: Resumable<W>,
        monitor: &dyn Monitor,
    ) -> Result<(W, EncodeSummary), Stopped> {
        let recovered = resumable.recovered.as_ref();
        let kept = |safe| self.describe(safe).map_or(Kept::Nothing, Kept::Chunks);
        let before = recovered.map(Recovered::safe).unwrap_or_default();
        let continues = recovered.is_some();
        let completed = self.prepare(recovered, monitor).map_err(|error| {
            let kept = match (&error, continues) {
                (_, false) => Kept::Nothing,
                (Error::Usage(_), true) => Kept::Unchanged,
                (_, true) => kept(before),
            };
            Stopped { error, kept }
        })?;
        let summary = EncodeSummary { resumed_chunks: completed.chunks, ..EncodeSummary::default() };
        let writer = self.open(resumable).map_err(|error| Stopped { error, kept: kept(before) })?;
        let mut job = Job { plan: self, writer, monitor, completed, summary, footage: FootageInfo::default() };
        let ran = job.run();
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
    fn prepare(&self, recovered: Option<&Recovered>, monitor: &dyn Monitor) -> Result<Completed> {
        self.check()?;
        let Some(recovered) = recovered else { return Ok(Completed::default()) };
        let mut completed = Completed::of(self, recovered)?;
        completed.check_files(self, monitor)?;
        Ok(completed)
    }

    /// Opens a writer at the start of the container, or after the recovered chunks, and adds the probes.
    fn open<W: Write>(&self, to: Resumable<W>) -> Result<Writer<W>> {
        let source = self.source;
        let projection = u8::from(source.projection() == Projection::Perspective);
        let (name, fps) = (source.name(), source.fps());
        let mut writer = match (to.journal, to.recovered) {
            (Some(journal), Some(recovered)) => {
                let journal = Journal::go_on(journal, &recovered);
                Writer::go_on(to.out, name, fps, projection, (recovered, journal))
            }
            (Some(journal), None) => {
                let head = configuration::to_bytes(&configuration::of(source, self.settings).0)?;
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
}

struct Job<'a, W: Write> {
    plan: &'a Plan<'a>,
    writer: Writer<W>,
    monitor: &'a dyn Monitor,
    completed: Completed,
    summary: EncodeSummary,
    footage: FootageInfo,
}

/// Depth images that a scan kept, and stamps of their files, by group index and frame.
#[derive(Default)]
struct KeptDepth {
    planes: HashMap<(usize, u32), Vec<DepthPlane>>,
    stamps: HashMap<(usize, u32), Stamp>,
}

impl KeptDepth {
    fn take(&mut self, group: usize, frame: u32) -> Option<(Stamp, Vec<DepthPlane>)> {
        let planes = self.planes.remove(&(group, frame))?;
        Some((*self.stamps.get(&(group, frame))?, planes))
    }
}

/// Works on units in parallel, and returns their results in the order of units.
fn each_unit<R: Send>(
    coder: &GroupCoder<'_>,
    units: &mut [UnitJob<'_>],
    work: impl Fn(&mut UnitJob<'_>) -> Result<Vec<R>> + Sync,
) -> Result<Vec<R>> {
    let code = |unit: &mut UnitJob<'_>| timed(&coder.times.coding, || work(unit));
    let done = try_map_at_once(units.iter_mut().collect(), coder.planned.need.units_at_once, code)?;
    Ok(done.into_iter().flatten().collect())
}

/// Returns the last frame that a chunk depends on. A colour cell looks ahead to the frame that closed the chunk; chunks of other
/// kinds depend only on their own frames.
fn last_frame(kind: StreamKind, chunk: &PackedChunk, closed_by: u32) -> u32 {
    match kind {
        StreamKind::Color => closed_by,
        StreamKind::Depth | StreamKind::Material | StreamKind::Alpha => chunk.key().last_frame(),
    }
}

/// Number of frames of a group that an earlier run has coded in all units.
fn complete_frames(places: &[UnitPlace]) -> u32 {
    places.iter().map(|place| place.start).min().unwrap_or(0)
}

impl<W: Write> Job<'_, W> {
    fn run(&mut self) -> Result<()> {
        let (plan, settings) = (self.plan, self.plan.settings);
        for groups in plan.groups.chunk_by(|a, b| (a.group.probe, a.group.kind) == (b.group.probe, b.group.kind)) {
            let header = match groups[0].group.kind {
                StreamKind::Depth => {
                    self.encode_depth(groups)?;
                    continue;
                }
                StreamKind::Color => CodecHeader::Color(settings.color_header()),
                StreamKind::Material => CodecHeader::Material(settings.material_header()),
                StreamKind::Alpha => CodecHeader::Alpha(settings.alpha_header()),
            };
            for &planned in groups {
                let Some(places) = self.begin(planned, &header)? else { continue };
                let coder = GroupCoder::new(plan, planned, header.clone())?;
                self.encode_group(&coder, &places, &mut KeptDepth::default())?;
            }
        }
        Ok(())
    }

    /// Encodes the depth groups of a probe.
    fn encode_depth(&mut self, groups: &[GroupPlan<'_>]) -> Result<()> {
        let (plan, probe) = (self.plan, groups[0].group.probe);
        let (ProbeDepth { range, levels, strays, .. }, mut kept) = self.find_range(groups)?;
        let mut quantiser = None;
        for &planned in groups {
            let coding = plan.settings.depth_coding(range, self.shape_of(planned.group), &levels);
            let header = DepthHeader {
                range,
                background: presented_background(plan.source.background(), range),
                kind: plan.source.depth_kind(),
                coding: coding.map_err(|error| error.context(format!("probe {}", plan.source.probes()[probe].name)))?,
            };
            if planned.at == groups[0].at {
                self.summary.depth.push(ProbePrecision::new(plan.source, probe, &header, strays.as_ref()));
            }
            let header = CodecHeader::Depth(header);
            let Some(places) = self.begin(planned, &header)? else { continue };
            let mut coder = GroupCoder::new(plan, planned, header)?;
            coder.quantiser = Some(Arc::clone(quantiser.get_or_insert_with(|| Arc::new(Quantiser::new(range)))));
            self.encode_group(&coder, &places, &mut kept)?;
        }
        Ok(())
    }

    /// Determines near and far of a probe, and notes a scan of its images in the journal.
    fn find_range(&mut self, groups: &[GroupPlan<'_>]) -> Result<(ProbeDepth, KeptDepth)> {
        let (plan, probe) = (self.plan, groups[0].group.probe);
        let noted = || self.completed.scans.get(&probe).map(|note| note.scan.clone());
        let known = plan.source.scans().and_then(|scans| scans.get(&probe).cloned()).or_else(noted);
        // Stamps must be taken before the files are read.
        let scans = known.is_none() && plan.finds_range();
        let stamps = if scans { stamps(plan.source, groups)? } else { HashMap::new() };
        let mut found = depth_of_probe(plan, groups, known.as_ref(), self.monitor)?;
        let Some(scanned) = found.scanned.take() else { return Ok((found, KeptDepth::default())) };
        let note = ScanNote { scan: scanned.found.scan(), files: stamps };
        self.writer.note(&note.to_bytes(probe)?);
        self.writer.checkpoint()?;
        self.summary.reading += scanned.reading;
        self.summary.scanning += scanned.scanning;
        Ok((found, KeptDepth { planes: scanned.kept, stamps: note.files }))
    }

    /// Relation of a pixel's depth to the viewing axis; unknown for the distances of a perspective view.
    fn shape_of(&self, group: &SourceGroup) -> Shape {
        match (self.plan.source.depth_kind(), group.faces == [Face::View]) {
            (DepthKind::Planar, _) => Shape::Planar,
            (DepthKind::Distance, false) if group.width == group.height => Shape::CubeDistance,
            _ => Shape::None,
        }
    }

    /// Declares the streams of a group. Returns its units face by face; `None` if an earlier run has completed them.
    fn begin(&mut self, planned: GroupPlan<'_>, header: &CodecHeader) -> Result<Option<Vec<UnitPlace>>> {
        let GroupPlan { at, group, .. } = planned;
        let first = group.frames.first;
        let mut places = Vec::new();
        for (face, (stream, entry)) in self.declare_streams(group, header)?.into_iter().enumerate() {
            places.extend((0..entry.unit_count()).map(|unit| UnitPlace {
                face,
                stream,
                unit,
                rect: entry.unit_rect(unit),
                start: self.completed.start(stream, unit, first) - first,
                search: self.completed.search(stream, unit),
            }));
        }
        let complete = complete_frames(&places);
        let before = group.frames.iter().take(complete as usize);
        let beyond = before.map(|frame| self.completed.beyond(at, frame)).sum();
        self.count_beyond(group.kind, beyond);
        if u64::from(complete) < group.frames.count() {
            return Ok(Some(places));
        }
        self.monitor.advance(planned.images());
        self.monitor.check().map(|()| None)
    }

    fn count_beyond(&mut self, kind: StreamKind, pixels: u64) {
        match kind {
            StreamKind::Depth => self.summary.outside_pixels += pixels,
            _ => self.summary.clipped_pixels += pixels,
        }
    }

    /// Encodes the frames of a group that are left, in batches.
    fn encode_group(&mut self, coder: &GroupCoder<'_>, places: &[UnitPlace], kept: &mut KeptDepth) -> Result<()> {
        let GroupPlan { group, need, .. } = coder.planned;
        let mut units = places.iter().map(|&place| UnitJob::new(coder, place)).collect::<Result<Vec<_>>>()?;
        let batch_frames = need.batch_frames(self.plan.settings.memory, "encoding")?;
        let pace = Pace::new(self.monitor, units.len(), group.faces.len());
        pace.advance(places.iter().map(|place| u64::from(place.start)).sum());
        let frames: Vec<u32> = group.frames.iter().skip(complete_frames(places) as usize).collect();
        for frames in frames.chunks(batch_frames) {
            let pictures = self.read_batch(coder, frames, kept)?;
            let batch = Batch { first: frames[0] - group.frames.first, pictures };
            let closed = each_unit(coder, &mut units, |unit| unit.push(&batch, &pace))?;
            self.write_batch(closed, group.kind, frames)?;
        }
        for units in units.chunks_mut(FINISH_UNITS) {
            self.monitor.check()?;
            for chunk in each_unit(coder, units, |unit| unit.finish())? {
                self.writer.push_after(&chunk, last_frame(group.kind, &chunk, group.frames.last))?;
            }
            self.writer.checkpoint()?;
        }
        let [reading, coding] = coder.times.durations();
        self.summary.reading += reading;
        self.summary.coding += coding;
        Ok(())
    }

    /// Reads frames of a group, notes their files in the journal, and returns their pictures by frame, then by face.
    fn read_batch(&mut self, coder: &GroupCoder<'_>, frames: &[u32], kept: &mut KeptDepth) -> Result<Vec<Vec<Coded>>> {
        let (source, planned) = (self.plan.source, coder.planned);
        let last_used = self.completed.last_frame(planned.streams());
        let inputs: Vec<_> = frames.iter().map(|&frame| (frame, kept.take(planned.at, frame))).collect();
        let read = try_map_ordered(inputs, |(frame, kept)| {
            self.monitor.check()?;
            let (stamp, kept) = match kept {
                Some((stamp, planes)) => (stamp, Some(planes)),
                None => (Stamp::of(source, planned.group, frame)?, None),
            };
            if last_used.is_some_and(|last| frame <= last) {
                self.completed.check_file(source, planned, frame, stamp)?;
            }
            let (picture, beyond) = coder.read(frame, kept)?;
            Ok((FrameNote { stamp, beyond }, picture))
        })?;
        let (notes, pictures): (Vec<FrameNote>, Vec<_>) = read.into_iter().unzip();
        self.count_beyond(planned.group.kind, notes.iter().map(|note| note.beyond).sum());
        self.writer.note(&configuration::to_bytes(&Note::Frames { group: planned.at, first: frames[0], notes })?);
        Ok(pictures)
    }

    /// Writes the chunks that the frames of a batch closed. They are sorted by frame, then by unit, so that their order does not
    /// depend on the size of the batch.
    fn write_batch(&mut self, mut closed: Vec<Closed>, kind: StreamKind, frames: &[u32]) -> Result<()> {
        closed.sort_by_key(|closed| closed.by);
        let searches: Vec<_> = closed.iter().filter_map(SearchNote::of).collect();
        if !searches.is_empty() {
            self.writer.note(&configuration::to_bytes(&Note::Searches(searches))?);
        }
        for Closed { by, chunk, .. } in &closed {
            self.writer.push_after(chunk, last_frame(kind, chunk, frames[*by]))?;
        }
        self.writer.checkpoint()
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
        let [unit_width, unit_height] = self.plan.settings.unit_size(group.kind, [group.width, group.height]);
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
        self.footage.view = self.plan.source.view();
        if group.kind == StreamKind::Color {
            self.footage.primaries = self.plan.source.primaries();
        }
        let ProbeInfo { name: probe, poses, .. } = &self.plan.source.probes()[group.probe];
        let poses = poses.iter().filter(|pose| group.frames.contains(pose.frame));
        self.footage.poses.extend(poses.map(|&Pose { frame, position, orientation }| FramePose {
            probe: probe.clone(),
            frame,
            position,
            orientation,
        }));
        self.footage.missing_frames.extend(missing_frames(self.plan.source, group));
    }
}

/// Returns the background value that decoders output: the value of the source files, or +inf if that value lies between near and
/// far and could be taken for a surface. (The value is in the unit of the files, near and far are in metres.)
fn presented_background(value: f32, range: DepthRange) -> f32 {
    if (range.near_m()..=range.far_m()).contains(&value) { f32::INFINITY } else { value }
}
