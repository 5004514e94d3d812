//! Going on with an encode that was stopped: what it says to its journal, and what that comes to afterwards.
//!
//! Chunks are written in an order that follows from footage and settings alone, and an encoder that begins at the start of a
//! chunk makes of it, and of all that follow, what one that came from the start of the unit makes. So what is complete is
//! the beginning of the file, and each unit begins anew behind its last complete chunk. A frame that had a part in a complete
//! chunk must not have changed since; one that had none may have.

use std::collections::HashMap;
use std::path::Path;
use std::time::UNIX_EPOCH;

use crate::container::fields::{Fields, PutFields};
use crate::container::{ChunkKey, Recovered, SafeChunks};
use crate::dataset::source::{Source, SourceGroup};
use crate::dataset::stream::StreamKind;
use crate::encode::dataset::{EncodeSettings, given_range, selected_groups};
use crate::encode::fingerprint;
use crate::encode::memory;
use crate::encode::scan::{self, ProbeScan, ScanLimits};
use crate::error::{Error, Result};
use crate::fingerprint::Fingerprint;
use crate::image::Face;
use crate::monitor::Monitor;

const FRAMES: u8 = 0;
const SCAN: u8 = 1;
/// Bytes of what is noted of a frame.
const FRAME_NOTE_BYTES: usize = 24;
const STAMP_BYTES: usize = 16;

/// An encode that ended early.
#[derive(Debug)]
pub struct Stopped {
    /// Why.
    pub error: Error,
    /// What there is to go on with.
    pub left: Left,
}

/// What an encode that ended early leaves behind.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Left {
    /// Nothing worth keeping.
    Nothing,
    /// What there is: it would not go on with it.
    AsItWas,
    /// Complete chunks, in words: how many, and what the last of them holds.
    Chunks(String),
}

/// By what a change of a file is told.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Stamp {
    bytes: u64,
    /// Nanoseconds since 1970.
    modified: i64,
}

impl Stamp {
    /// The stamp that a file has now.
    pub(super) fn of(path: &Path) -> Result<Stamp> {
        let metadata = std::fs::metadata(path).map_err(|error| Error::io(path, error))?;
        let modified = match metadata.modified().map(|time| time.duration_since(UNIX_EPOCH)) {
            Ok(Ok(after)) => i64::try_from(after.as_nanos()).unwrap_or(i64::MAX),
            Ok(Err(before)) => -i64::try_from(before.duration().as_nanos()).unwrap_or(i64::MAX),
            // Not every system tells.
            Err(_) => 0,
        };
        Ok(Stamp { bytes: metadata.len(), modified })
    }

    fn write(self, out: &mut Vec<u8>) {
        out.put_u64(self.bytes);
        out.put_u64(self.modified as u64);
    }

    fn read(fields: &mut Fields<'_>) -> Result<Stamp> {
        Ok(Stamp { bytes: fields.u64()?, modified: fields.u64()? as i64 })
    }
}

/// What is noted of a frame of a group that was read.
#[derive(Debug, Clone, Copy)]
pub(super) struct FrameNote {
    /// The file as it was before it was read.
    pub(super) stamp: Stamp,
    /// Colour pixels that did not fit 8 bits.
    pub(super) clipped: u64,
}

/// The note of frames of group `group` from `first` on.
pub(super) fn note_of_frames(group: usize, first: u32, frames: &[FrameNote]) -> Vec<u8> {
    let mut note = vec![FRAMES];
    note.put_u32(group as u32);
    note.put_u32(first);
    for frame in frames {
        frame.stamp.write(&mut note);
        note.put_u64(frame.clipped);
    }
    note
}

/// What a scan of a probe's depth found, and the files that it read.
#[derive(Debug, Clone, Default)]
pub(super) struct ScanNote {
    /// Nearest and farthest surface, if there is any.
    pub(super) extent: Option<(f32, f32)>,
    /// Whether there are invalid readings that are to be taken as near.
    pub(super) taken_as_near: bool,
    /// By index of the group and frame.
    pub(super) files: HashMap<(usize, u32), Stamp>,
}

impl ScanNote {
    /// Scans; also answers the images that were kept.
    pub(super) fn make(
        source: &Source,
        groups: &[(usize, &SourceGroup)],
        limits: ScanLimits,
        monitor: &dyn Monitor,
    ) -> Result<(ScanNote, ProbeScan)> {
        let files = stamps(source, groups)?;
        let found = scan::scan_probe(source, groups, limits, monitor)?;
        let extent = found.range.map(|range| (range.near_m(), range.far_m()));
        Ok((ScanNote { extent, taken_as_near: found.taken_as_near, files }, found))
    }

    /// As a note.
    pub(super) fn write(&self, probe: usize) -> Vec<u8> {
        let mut note = vec![SCAN, u8::from(self.extent.is_some()), u8::from(self.taken_as_near)];
        note.put_u32(probe as u32);
        let (near, far) = self.extent.unwrap_or_default();
        note.put_f32(near);
        note.put_f32(far);
        for (&(group, frame), stamp) in &self.files {
            note.put_u32(group as u32);
            note.put_u32(frame);
            stamp.write(&mut note);
        }
        note
    }

    /// Whether the files are still those that were scanned.
    fn still_holds(&self, source: &Source, groups: &[(usize, &SourceGroup)]) -> Result<bool> {
        Ok(stamps(source, groups)? == self.files)
    }
}

fn stamps(source: &Source, groups: &[(usize, &SourceGroup)]) -> Result<HashMap<(usize, u32), Stamp>> {
    let frames = groups.iter().flat_map(|&(at, group)| group.frames.iter().map(move |frame| (at, group, frame)));
    frames.map(|(at, group, frame)| Ok(((at, frame), Stamp::of(&source.file(group, frame)?)?))).collect()
}

/// The groups in the order in which they are encoded, each with the index of its first stream.
pub(super) struct Order<'a>(Vec<(usize, &'a SourceGroup, u32)>);

impl<'a> Order<'a> {
    /// The order for a source: by probe, then by kind.
    pub(super) fn of(source: &'a Source, settings: &EncodeSettings) -> Order<'a> {
        let mut groups = selected_groups(source, settings);
        groups.sort_by_key(|(_, group)| (group.probe, group.kind));
        let mut stream = 0;
        let numbered = groups.into_iter().map(|(at, group)| {
            let first = stream;
            stream += group.faces.len() as u32;
            (at, group, first)
        });
        Order(numbered.collect())
    }

    /// The group and the face that a stream shows.
    fn stream(&self, stream: u32) -> Option<(&'a SourceGroup, Face)> {
        let &(_, group, first) = self.0.iter().rfind(|(_, _, first)| *first <= stream)?;
        Some((group, *group.faces.get((stream - first) as usize)?))
    }

    /// What is safe, in words; `None` where nothing is.
    pub(super) fn describe(&self, source: &Source, safe: SafeChunks) -> Option<String> {
        let SafeChunks { count, last: Some(ChunkKey { stream, first_frame, frame_count, .. }) } = safe else {
            return None;
        };
        let (group, face) = self.stream(stream)?;
        let probe = &source.probes()[group.probe].name;
        let chunks = if count == 1 { "1 chunk".to_owned() } else { format!("{count} chunks, the last") };
        let (kind, last_frame) = (group.kind.name(), first_frame + (frame_count - 1));
        Some(format!("{chunks} of frames {first_frame}-{last_frame} of probe {probe}, {kind} {}", face.name()))
    }
}

/// What an earlier run has done.
#[derive(Debug, Default)]
pub(super) struct Done {
    /// The frame behind the last complete chunk, by stream and unit.
    ends: HashMap<(u32, u32), u32>,
    /// The last frame that had a part in a complete chunk, by stream.
    last_frames: HashMap<u32, u32>,
    /// By index of the group and frame; of frames that were read twice, what was found the second time.
    frames: HashMap<(usize, u32), FrameNote>,
    /// By probe.
    pub(super) scans: HashMap<usize, ScanNote>,
    /// Complete chunks.
    pub(super) chunks: u64,
}

impl Done {
    /// What was recovered of an encode that must be the same one.
    ///
    /// # Errors
    /// [`Error::Usage`] where it is another one, or input that complete chunks were made of has changed.
    pub(super) fn of(recovered: &Recovered, now: &Fingerprint, order: &Order<'_>) -> Result<Done> {
        let begun = fingerprint::read(recovered.head()).map_err(|_| broken())?;
        if let Some(difference) = begun.difference(now) {
            return Err(fingerprint::other(&difference));
        }
        let mut done = Done { chunks: recovered.chunks().len() as u64, ..Done::default() };
        for note in recovered.notes() {
            done.take_note(note).map_err(|_| broken())?;
        }
        for chunk in recovered.chunks() {
            let ChunkKey { stream, unit, first_frame, frame_count } = chunk.entry.key;
            let (group, _) = order.stream(stream).ok_or_else(broken)?;
            let end = first_frame + frame_count;
            let before = done.ends.insert((stream, unit), end).unwrap_or(group.frames.first);
            if before != first_frame || !group.frames.contains(end - 1) {
                return Err(broken());
            }
            let last = done.last_frames.entry(stream).or_default();
            *last = chunk.last_frame.max(*last);
        }
        Ok(done)
    }

    fn take_note(&mut self, note: &[u8]) -> Result<()> {
        let mut fields = Fields::new(note, 0, "");
        match fields.u8()? {
            FRAMES => {
                let (group, first) = (fields.u32()? as usize, fields.u32()?);
                let count = (fields.remaining() / FRAME_NOTE_BYTES) as u32;
                for frame in 0..count {
                    let note = FrameNote { stamp: Stamp::read(&mut fields)?, clipped: fields.u64()? };
                    self.frames.insert((group, first.saturating_add(frame)), note);
                }
            }
            SCAN => {
                let (has_extent, taken_as_near) = (fields.u8()? != 0, fields.u8()? != 0);
                let probe = fields.u32()? as usize;
                let extent = (fields.f32()?, fields.f32()?);
                let mut files = HashMap::new();
                for _ in 0..fields.remaining() / (8 + STAMP_BYTES) {
                    let file = (fields.u32()? as usize, fields.u32()?);
                    files.insert(file, Stamp::read(&mut fields)?);
                }
                self.scans.insert(probe, ScanNote { extent: has_extent.then_some(extent), taken_as_near, files });
            }
            kind => return Err(fields.error(format!("a note of kind {kind}"))),
        }
        fields.finish()
    }

    /// The first frame of a unit that is still to be encoded.
    pub(super) fn start(&self, stream: u32, unit: u32, first_frame: u32) -> u32 {
        self.ends.get(&(stream, unit)).copied().unwrap_or(first_frame)
    }

    /// Colour pixels of a frame that did not fit 8 bits.
    pub(super) fn clipped(&self, group: usize, frame: u32) -> u64 {
        self.frames.get(&(group, frame)).map_or(0, |note| note.clipped)
    }

    /// The last frame that had a part in a complete chunk of these streams, which are those of a group.
    pub(super) fn last_frame(&self, streams: impl Iterator<Item = u32>) -> Option<u32> {
        streams.filter_map(|stream| self.last_frames.get(&stream).copied()).max()
    }

    /// Refuses a file that complete chunks were made of when it was another one; of its group the index is given, too.
    ///
    /// # Errors
    /// [`Error::Usage`].
    pub(super) fn check_file(
        &self,
        source: &Source,
        (at, group, frame): (usize, &SourceGroup, u32),
        now: Stamp,
    ) -> Result<()> {
        let note = self.frames.get(&(at, frame)).ok_or_else(broken)?;
        if note.stamp == now {
            return Ok(());
        }
        let (file, name) = (source.file(group, frame)?, crate::encode::settings::name_frame(source, group, frame));
        Err(fingerprint::other(&format!("{} ({name}) has changed since", file.display())))
    }

    /// Refuses to go on where files have changed that complete chunks were made of. Forgets scans that no longer hold and
    /// that no chunk rests on.
    ///
    /// # Errors
    /// [`Error::Usage`] for such a change; others where files cannot be read.
    pub(super) fn check_files(
        &mut self,
        source: &Source,
        settings: &EncodeSettings,
        order: &Order<'_>,
        monitor: &dyn Monitor,
    ) -> Result<()> {
        for &(at, group, first_stream) in &order.0 {
            let streams = first_stream..first_stream + group.faces.len() as u32;
            let Some(last) = self.last_frame(streams) else { continue };
            for frame in group.frames.iter().take_while(|&frame| frame <= last) {
                self.check_file(source, (at, group, frame), Stamp::of(&source.file(group, frame)?)?)?;
            }
        }
        if given_range(source, settings).iter().all(Option::is_some) {
            return Ok(());
        }
        let probes: Vec<usize> = self.scans.keys().copied().collect();
        for probe in probes {
            let of_probe = |group: &SourceGroup| group.probe == probe && group.kind == StreamKind::Depth;
            let groups: Vec<_> = order.0.iter().filter(|(_, group, _)| of_probe(group)).collect();
            let mut streams = groups.iter().flat_map(|(_, group, first)| *first..*first + group.faces.len() as u32);
            let rests = streams.any(|stream| self.last_frames.contains_key(&stream));
            let groups: Vec<_> = groups.iter().map(|&&(at, group, _)| (at, group)).collect();
            if let Some(scan) = self.scans.get(&probe)
                && scan.still_holds(source, &groups)?
            {
                continue;
            }
            let before = self.scans.remove(&probe).unwrap_or_default();
            if rests {
                let limits = memory::scan_limits(source, settings, &groups)?;
                let (found, _) = ScanNote::make(source, &groups, limits, monitor)?;
                if (found.extent, found.taken_as_near) != (before.extent, before.taken_as_near) {
                    let name = source.probes().get(probe).map_or("", |probe| probe.name.as_str());
                    return Err(fingerprint::other(&format!(
                        "files have changed since, and with them the nearest or the farthest surface of probe {name}"
                    )));
                }
                self.scans.insert(probe, found);
            }
        }
        Ok(())
    }
}

/// Records that no encode of this version makes.
fn broken() -> Error {
    fingerprint::other("its journal contradicts itself")
}
