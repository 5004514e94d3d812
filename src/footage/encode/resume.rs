//! Resumes an interrupted encode: the notes that the encoder writes to its journal, and how they are used.
//!
//! The unfinished container is `.NAME.partial` and its journal `.NAME.journal` ([`codec::container::Journal`]), both next to
//! `NAME`. Chunks are written in an order that depends only on footage and settings, and an encoder carries no state from one
//! chunk to the next except the initial state of its search, which the journal records. The complete chunks are therefore a
//! prefix of the file, each unit resumes after its last chunk with a new encoder, and the result has the same bytes as an
//! uninterrupted encode. A journal, rather than a new index after each batch, records which chunks are complete: with an index,
//! the bytes would depend on when the encode was interrupted, and a container could not be written to a pipe.
//!
//! The configuration ([`crate::encode::configuration`]) must be equal; the number of threads is not part of it. A file that was
//! read for a complete chunk must have the same size and modification time. Other files may have changed, for example a broken
//! frame that was rendered again, unless the change alters near or far of the probe, or the distances that are coded as levels of
//! predictive depth.

use std::collections::HashMap;
use std::path::Path;
use std::time::UNIX_EPOCH;

use serde::{Deserialize, Serialize};

use crate::dataset::SourceGroup;
use crate::encode::configuration;
use crate::encode::depth_range;
use crate::encode::plan::{GroupPlan, Plan};
use crate::encode::scan::Scan;
use crate::encode::source::{FrameSource, name_frame};
use crate::encode::unit::Closed;
use crate::fingerprint::Fingerprint;
use codec::color::transform::encode::Start;
use codec::container::{ChunkKey, Recovered};
use codec::error::{Error, Result};
use codec::monitor::Monitor;

/// Sizes and modification times of the files of a frame, to detect changes; zeros for frames in memory.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Stamp([FileStamp; 2]);

#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
struct FileStamp {
    bytes: u64,
    /// Nanoseconds since 1970; 0 if the file system does not report the time.
    modified: i64,
}

impl Stamp {
    pub fn of(source: &dyn FrameSource, group: &SourceGroup, frame: u32) -> Result<Stamp> {
        let mut stamp = Stamp::default();
        for (of_file, path) in stamp.0.iter_mut().zip(source.files(group, frame)?) {
            *of_file = FileStamp::of(&path)?;
        }
        Ok(stamp)
    }
}

impl FileStamp {
    fn of(path: &Path) -> Result<FileStamp> {
        let metadata = std::fs::metadata(path).map_err(|error| Error::io(path, error))?;
        let modified = match metadata.modified().map(|time| time.duration_since(UNIX_EPOCH)) {
            Ok(Ok(after)) => i64::try_from(after.as_nanos()).unwrap_or(i64::MAX),
            Ok(Err(before)) => -i64::try_from(before.duration().as_nanos()).unwrap_or(i64::MAX),
            Err(_) => 0,
        };
        Ok(FileStamp { bytes: metadata.len(), modified })
    }
}

#[derive(Serialize, Deserialize)]
pub(super) enum Note {
    /// Frames of a group, from `first` on.
    Frames { group: usize, first: u32, notes: Vec<FrameNote> },
    /// Scan of a probe and stamps of the files that it read, by group index and frame.
    Scan { probe: usize, scan: Scan, files: Vec<((usize, u32), Stamp)> },
    /// Search states after the chunks that were written.
    Searches(Vec<SearchNote>),
}

/// State of the search of a unit after a chunk. It depends on the chunks before it.
#[derive(Serialize, Deserialize)]
pub(super) struct SearchNote {
    stream: u32,
    unit: u32,
    /// The frame after the last frame of the chunk.
    frame: u32,
    start: Start,
}

impl SearchNote {
    pub fn of(closed: &Closed) -> Option<SearchNote> {
        let ChunkKey { stream, unit, first_frame, frame_count } = closed.chunk.key();
        closed.search.map(|start| SearchNote { stream, unit, frame: first_frame + frame_count, start })
    }
}

#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub(super) struct FrameNote {
    /// Stamp of the files before they were read.
    pub stamp: Stamp,
    /// Number of colour pixels clipped to 8 bits, or of depth pixels outside near and far.
    pub beyond: u64,
}

#[derive(Debug, Clone, Default)]
pub(super) struct ScanNote {
    pub scan: Scan,
    /// Stamps of the files, by group index and frame.
    pub files: HashMap<(usize, u32), Stamp>,
}

impl ScanNote {
    pub fn to_bytes(&self, probe: usize) -> Result<Vec<u8>> {
        let files = self.files.iter().map(|(&file, &stamp)| (file, stamp)).collect();
        configuration::to_bytes(&Note::Scan { probe, scan: self.scan.clone(), files })
    }
}

pub(super) fn stamps(source: &dyn FrameSource, groups: &[GroupPlan<'_>]) -> Result<HashMap<(usize, u32), Stamp>> {
    let frames = groups.iter().flat_map(|&group| group.group.frames.iter().map(move |frame| (group, frame)));
    frames.map(|(GroupPlan { at, group, .. }, frame)| Ok(((at, frame), Stamp::of(source, group, frame)?))).collect()
}

#[derive(Debug, Default)]
pub(super) struct Completed {
    /// The frame after the last complete chunk, by stream and unit.
    ends: HashMap<(u32, u32), u32>,
    /// The last frame that a complete chunk depends on, by stream.
    last_frames: HashMap<u32, u32>,
    /// Notes by group index and frame. For a frame that was read twice, the note of the second read.
    frames: HashMap<(usize, u32), FrameNote>,
    /// Search states by stream, unit and the frame after a chunk.
    searches: HashMap<(u32, u32, u32), Start>,
    pub scans: HashMap<usize, ScanNote>,
    pub chunks: u64,
}

impl Completed {
    /// Reads the work of an earlier run. Fails if it has another configuration than the plan.
    pub fn of(plan: &Plan<'_>, recovered: &Recovered) -> Result<Completed> {
        let now = configuration::of(plan.source, plan.settings);
        let of_old = |_| configuration::other("it was started by another version of lightfold");
        let begun = serde_json::from_slice(&recovered.head).map_err(of_old)?;
        if let Some(difference) = Fingerprint(begun).difference(&now) {
            return Err(configuration::other(&difference));
        }
        let mut completed = Completed { chunks: recovered.chunks.len() as u64, ..Completed::default() };
        for note in &recovered.notes {
            match serde_json::from_slice(note).map_err(|_| broken())? {
                Note::Frames { group, first, notes } => {
                    completed.frames.extend((first..=u32::MAX).zip(notes).map(|(frame, note)| ((group, frame), note)));
                }
                Note::Scan { probe, scan, files } => {
                    completed.scans.insert(probe, ScanNote { scan, files: files.into_iter().collect() });
                }
                Note::Searches(searches) => {
                    let sets = plan.settings.tables().sets().len();
                    if searches.iter().any(|note| !note.start.is_possible(sets)) {
                        return Err(broken());
                    }
                    let by_place = |note: SearchNote| ((note.stream, note.unit, note.frame), note.start);
                    completed.searches.extend(searches.into_iter().map(by_place));
                }
            }
        }
        for chunk in &recovered.chunks {
            let ChunkKey { stream, unit, first_frame, frame_count } = chunk.entry.key;
            let (group, _) = plan.stream(stream).ok_or_else(broken)?;
            let end = first_frame + frame_count;
            let before = completed.ends.insert((stream, unit), end).unwrap_or(group.frames.first);
            if before != first_frame || !group.frames.contains(end - 1) {
                return Err(broken());
            }
            let last = completed.last_frames.entry(stream).or_default();
            *last = chunk.last_frame.max(*last);
        }
        Ok(completed)
    }

    /// Returns the first frame of a unit that is not yet encoded.
    pub fn start(&self, stream: u32, unit: u32, first_frame: u32) -> u32 {
        self.ends.get(&(stream, unit)).copied().unwrap_or(first_frame)
    }

    /// Returns the search state after the last complete chunk of a unit.
    pub fn search(&self, stream: u32, unit: u32) -> Option<Start> {
        let end = *self.ends.get(&(stream, unit))?;
        self.searches.get(&(stream, unit, end)).copied()
    }

    /// Returns the number of colour pixels of a frame that were clipped to 8 bits, or of depth pixels outside near and far.
    pub fn beyond(&self, group: usize, frame: u32) -> u64 {
        self.frames.get(&(group, frame)).map_or(0, |note| note.beyond)
    }

    /// Returns the last frame that a complete chunk of these streams depends on.
    pub fn last_frame(&self, streams: impl Iterator<Item = u32>) -> Option<u32> {
        streams.filter_map(|stream| self.last_frames.get(&stream).copied()).max()
    }

    /// Fails if the files of a frame that complete chunks depend on have changed.
    pub fn check_file(
        &self,
        source: &dyn FrameSource,
        GroupPlan { at, group, .. }: GroupPlan<'_>,
        frame: u32,
        now: Stamp,
    ) -> Result<()> {
        let note = self.frames.get(&(at, frame)).ok_or_else(broken)?;
        if note.stamp == now {
            return Ok(());
        }
        let mut files: Vec<String> =
            source.files(group, frame)?.iter().map(|file| file.display().to_string()).collect();
        files.dedup();
        let name = name_frame(source, group, frame);
        Err(Error::Usage(format!(
            "cannot resume the unfinished encode: {} ({name}) has changed since: leave out `resume` to start over",
            files.join(" or ")
        )))
    }

    /// Fails if files that complete chunks depend on have changed. Drops scans of changed files that no chunk depends on.
    pub fn check_files(&mut self, plan: &Plan<'_>, monitor: &dyn Monitor) -> Result<()> {
        let source = plan.source;
        for &planned in &plan.groups {
            let Some(last) = self.last_frame(planned.streams()) else { continue };
            for frame in planned.group.frames.iter().take_while(|&frame| frame <= last) {
                self.check_file(source, planned, frame, Stamp::of(source, planned.group, frame)?)?;
            }
        }
        if !plan.finds_range() {
            return Ok(());
        }
        let probes: Vec<usize> = self.scans.keys().copied().collect();
        for probe in probes {
            self.check_scan(plan, probe, monitor)?;
        }
        Ok(())
    }

    /// Fails if complete chunks depend on the scan of a probe, and its files have changed so that a new scan has other results.
    fn check_scan(&mut self, plan: &Plan<'_>, probe: usize, monitor: &dyn Monitor) -> Result<()> {
        let groups = plan.depth_of(probe);
        let files = stamps(plan.source, &groups)?;
        if self.scans.get(&probe).is_some_and(|scan| scan.files == files) {
            return Ok(());
        }
        let before = self.scans.remove(&probe).unwrap_or_default();
        let mut streams = groups.iter().flat_map(GroupPlan::streams);
        if !streams.any(|stream| self.last_frames.contains_key(&stream)) {
            return Ok(());
        }
        let scan = depth_range::scan_in_stage(plan, &groups, monitor)?.found.scan();
        if !scan.is_as_good_as(&before.scan) {
            let has_other_range = scan.limits() != before.scan.limits();
            let changed = if has_other_range { "the nearest or the farthest surface" } else { "the few distances" };
            let name = plan.source.probes().get(probe).map_or("", |probe| probe.name.as_str());
            return Err(configuration::other(&format!(
                "files have changed since, which changes {changed} of probe {name}"
            )));
        }
        self.scans.insert(probe, ScanNote { scan, files });
        Ok(())
    }
}

fn broken() -> Error {
    configuration::other("its journal is inconsistent")
}
