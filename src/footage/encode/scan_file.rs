//! `scan.json`: depth statistics of a dataset's images and digests of the files of all kinds, computed before an encode by one
//! machine or by several.

use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::dataset::SourceGroup;
use crate::encode::budget::ScanLimits;
use crate::encode::depth_range::scan_probe;
use crate::encode::footage::{Footage, FrameDigest, KnownFiles};
use crate::encode::plan::{GroupPlan, Plan};
use crate::encode::scan::{FoundDepth, Scans};
use crate::encode::shard::{Segment, Shard, segments_of_shard};
use crate::encode::source::FrameSource;
use crate::encode::{DepthCodec, EncodeSettings};
use crate::files::{open_regular, write_whole};
use crate::fingerprint::{Fingerprint, digest};
use crate::json;
use codec::error::{Error, Result};
use codec::image::StreamKind;
use codec::monitor::{Monitor, Uncounted};

const VERSION: u32 = 3;
/// Frames per part. A part that was interrupted is scanned again from its first frame.
const PART_FRAMES: u32 = 16;

/// Results of a scan, divided into parts of one image sequence each.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ScanFile {
    lightfold_scan: u32,
    /// Digest of everything that the parts depend on, except the files.
    footage: String,
    /// All image sequences of the footage, scanned or not.
    whole: Vec<Sequence>,
    /// True while a scan is running, or if it was interrupted before its shard was complete.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    is_unfinished: bool,
    parts: Vec<ScannedFrames>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Sequence {
    /// Name of the stream kind.
    kind: String,
    probe: String,
    /// Names of the faces, separated by commas.
    faces: String,
    /// First and last frame, inclusive.
    frames: [u32; 2],
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct ScannedFrames {
    /// Name of the stream kind.
    kind: String,
    probe: String,
    /// Names of the faces, separated by commas.
    faces: String,
    /// First and last frame, inclusive.
    frames: [u32; 2],
    /// Digest of each frame.
    digests: Vec<FrameDigest>,
    /// Depth statistics; only for depth.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    found: Option<FoundDepth>,
}

impl ScannedFrames {
    fn place(&self) -> (&str, &str, u32, &str) {
        (&self.probe, &self.faces, self.frames[0], &self.kind)
    }

    /// Returns true if the frames belong to this sequence.
    fn is_of(&self, sequence: &Sequence) -> bool {
        (&self.kind, &self.probe, &self.faces) == (&sequence.kind, &sequence.probe, &sequence.faces)
    }
}

impl ScanFile {
    /// Creates a scan without scanned frames.
    pub fn new(source: &dyn FrameSource) -> ScanFile {
        let (footage, whole) = (footage(source), sequences(source));
        ScanFile { lightfold_scan: VERSION, footage, whole, is_unfinished: false, parts: Vec::new() }
    }

    /// # Errors
    /// Fails if the file cannot be read, is no scan, or has another version; the error names the file.
    pub fn read(path: &Path) -> Result<ScanFile> {
        let file = open_regular(path)?;
        let scan: ScanFile = serde_json::from_reader(std::io::BufReader::new(file))
            .map_err(|error| Error::invalid(format!("this is not a scan: {error}")).in_file(path))?;
        let ascends = |pair: &[ScannedFrames]| pair[0].place() < pair[1].place();
        let message = match scan.lightfold_scan {
            VERSION if scan.parts.windows(2).all(ascends) => return Ok(scan),
            VERSION => "the parts of this scan repeat or are out of order: scan again".into(),
            other => format!("a scan of version {other}, this program reads version {VERSION}"),
        };
        Err(Error::invalid(message).in_file(path))
    }

    pub fn write(&self, path: &Path) -> Result<()> {
        write_whole(path, self.to_json()?.as_bytes())
    }

    pub fn to_json(&self) -> Result<String> {
        json::pretty(self)
    }

    /// Returns true if the scan is of this footage, read in the same way.
    pub fn is_of(&self, source: &dyn FrameSource) -> bool {
        self.footage == footage(source)
    }

    /// Number of images that a scan of a shard covers; `None` scans all.
    pub fn images(source: &dyn FrameSource, settings: &EncodeSettings, shard: Option<Shard>) -> Result<u64> {
        let settings = of_all_kinds(settings);
        let plan = Plan::new(source, &settings);
        let faces = |segment: &Segment| plan.groups[segment.ordered].group.faces.len() as u64;
        Ok(segments(&plan, shard)?.iter().map(|segment| segment.frames.count() * faces(segment)).sum())
    }

    /// Scans the parts of a shard that are missing, and calls `save` after each. Returns the number of images read. The monitor
    /// advances by one per image of the shard.
    pub fn scan(
        &mut self,
        source: &dyn FrameSource,
        settings: &EncodeSettings,
        shard: Option<Shard>,
        monitor: &dyn Monitor,
        save: &mut dyn FnMut(&ScanFile) -> Result<()>,
    ) -> Result<u64> {
        self.is_unfinished = true;
        let (mut read, mut known_files) = (0, KnownFiles::default());
        let settings = of_all_kinds(settings);
        let plan = Plan::new(source, &settings);
        for Segment { ordered, frames, .. } in segments(&plan, shard)? {
            let GroupPlan { group, .. } = plan.groups[ordered];
            let part = SourceGroup { frames, ..group.clone() };
            let Sequence { kind, probe, faces, .. } = sequence(source, group);
            let images = frames.count() * group.faces.len() as u64;
            let place = (probe.as_str(), faces.as_str(), frames.first, kind.as_str());
            let Err(behind) = self.parts.binary_search_by(|known| known.place().cmp(&place)) else {
                monitor.advance(images);
                continue;
            };
            // `scan_probe` reports depth images to the monitor; do not count them twice.
            let uncounted = Uncounted(monitor);
            let is_depth = group.kind == StreamKind::Depth;
            let digests = known_files.read(source, &part, if is_depth { &uncounted } else { monitor })?;
            let found = match group.kind {
                StreamKind::Depth => {
                    let groups = [GroupPlan { group: &part, need: plan.need(&part), ..plan.groups[ordered] }];
                    let limits = ScanLimits { keep_bytes: 0, ..plan.scan_limits(&groups)? };
                    Some(scan_probe(source, &groups, limits, monitor)?.found)
                }
                _ => None,
            };
            let frames = [frames.first, frames.last];
            self.parts.insert(behind, ScannedFrames { kind, probe, faces, frames, digests, found });
            read += images;
            save(self)?;
        }
        self.is_unfinished = false;
        Ok(read)
    }

    /// Returns true while the scan of a shard is running, or if it was interrupted.
    pub fn is_unfinished(&self) -> bool {
        self.is_unfinished
    }

    /// Describes the frames that are not scanned; `None` if all are.
    pub fn missing(&self) -> Option<String> {
        let of_sequence = |sequence: &Sequence| {
            let runs: Vec<String> = self.gaps(sequence).map(|[first, last]| format!("{first}-{last}")).collect();
            let Sequence { kind, probe, faces, .. } = sequence;
            (!runs.is_empty()).then(|| format!("frames {} of {kind} of probe {probe}, face {faces}", few(&runs)))
        };
        let sequences: Vec<String> = self.whole.iter().filter_map(of_sequence).collect();
        (!sequences.is_empty()).then(|| few(&sequences))
    }

    /// Parts of a sequence, sorted by frame.
    fn parts_of<'a>(&'a self, sequence: &'a Sequence) -> impl Iterator<Item = &'a ScannedFrames> {
        self.parts.iter().filter(|part| part.is_of(sequence))
    }

    /// Ranges of frames that no part covers, first and last inclusive.
    fn gaps<'a>(&'a self, sequence: &'a Sequence) -> impl Iterator<Item = [u32; 2]> {
        let [first, last] = sequence.frames.map(u64::from);
        let ends = self.parts_of(sequence).map(|part| part.frames.map(u64::from)).chain([[last + 1; 2]]);
        let gaps = ends.scan(first, |next, [from, to]| {
            let gap = [*next, from];
            *next = to + 1;
            Some(gap)
        });
        gaps.filter(|[from, end]| from < end).map(|[from, end]| [from as u32, (end - 1) as u32])
    }

    /// Adds the parts of another scan of the same footage.
    ///
    /// # Errors
    /// [`Error::Invalid`] for other footage, and for parts that cover the same frames but differ.
    pub fn merge(&mut self, other: ScanFile) -> Result<()> {
        if self.footage != other.footage {
            return Err(Error::invalid("a scan of different footage or with different settings than the first one"));
        }
        self.is_unfinished = false;
        for part in other.parts {
            match self.parts.binary_search_by(|known| known.place().cmp(&part.place())) {
                Err(at) => self.parts.insert(at, part),
                Ok(at) if self.parts[at] == part => {}
                Ok(_) => {
                    let ScannedFrames { kind, probe, faces, frames: [first, last], .. } = part;
                    return Err(Error::invalid(format!(
                        "it holds another scan of frames {first}-{last} of {kind} of probe {probe}, face {faces}, than an \
                         earlier file: the images changed in between, so scan them again"
                    )));
                }
            }
        }
        Ok(())
    }

    /// Returns the scans of all probes and the digests of all frames.
    ///
    /// # Errors
    /// [`Error::Invalid`] for other footage, and if frames are missing.
    pub fn scans(&self, source: &dyn FrameSource) -> Result<(Scans, Footage)> {
        if !self.is_of(source) {
            return Err(Error::invalid(
                "a scan of other footage, or made with other settings or by another version of lightfold: scan again",
            ));
        }
        if let Some(missing) = self.missing() {
            let instead = match self.is_unfinished {
                true => "run the same scan with `resume`",
                false => "scan the missing shards, and merge them",
            };
            return Err(Error::invalid(format!("the scan lacks {missing}: {instead}")));
        }
        let mut found: BTreeMap<usize, FoundDepth> = BTreeMap::new();
        let mut footage = Footage::empty("the scan");
        for group in source.groups() {
            let sequence = sequence(source, group);
            let mut digests = Vec::new();
            for part in self.parts_of(&sequence) {
                digests.extend_from_slice(&part.digests);
                if let (StreamKind::Depth, Some(more)) = (group.kind, &part.found) {
                    let of_probe = found.entry(group.probe).or_insert_with(FoundDepth::nothing);
                    *of_probe = std::mem::replace(of_probe, FoundDepth::nothing()).union(more);
                }
            }
            if digests.len() as u64 != group.frames.count() {
                let Sequence { kind, probe, faces, .. } = sequence;
                let message = format!(
                    "it has {} digests of the {} frames of {kind} of probe {probe}, face {faces}: scan again",
                    digests.len(),
                    group.frames.count()
                );
                return Err(Error::invalid(message));
            }
            footage.insert(group, digests);
        }
        Ok((found.into_iter().map(|(probe, found)| (probe, found.scan())).collect(), footage))
    }
}

/// Number of images that [`scan_probes`] reads.
pub fn probe_images(source: &dyn FrameSource, settings: &EncodeSettings, probes: &[usize]) -> u64 {
    let settings = of_depth(settings);
    let plan = Plan::new(source, &settings);
    if !plan.finds_range() {
        return 0;
    }
    plan.groups.iter().filter(|planned| probes.contains(&planned.group.probe)).map(GroupPlan::images).sum()
}

/// Scans all frames of the given probes, for an encode of some of these frames. Returns no scans if near and far are given. The
/// monitor advances by one per image.
pub fn scan_probes(
    source: &dyn FrameSource,
    settings: &EncodeSettings,
    probes: &[usize],
    monitor: &dyn Monitor,
) -> Result<Scans> {
    let mut scans = Scans::new();
    let plan = Plan::new(source, settings);
    if !plan.finds_range() {
        return Ok(scans);
    }
    for &probe in probes {
        let groups = plan.depth_of(probe);
        let limits = ScanLimits { keep_bytes: 0, ..plan.scan_limits(&groups)? };
        scans.insert(probe, scan_probe(source, &groups, limits, monitor)?.found.scan());
    }
    Ok(scans)
}

/// Settings restricted to depth, with a codec that searches for levels, so that the scan serves every codec.
fn of_depth(settings: &EncodeSettings) -> EncodeSettings {
    let mut settings = EncodeSettings { kinds: vec![StreamKind::Depth], ..settings.clone() };
    (settings.depth.codec, settings.temporal.epsilon) = (DepthCodec::Predictive, 0);
    settings
}

/// As `of_depth`, with all kinds, because digests cover all files.
fn of_all_kinds(settings: &EncodeSettings) -> EncodeSettings {
    EncodeSettings { kinds: StreamKind::ALL.to_vec(), ..of_depth(settings) }
}

fn segments(plan: &Plan<'_>, shard: Option<Shard>) -> Result<Vec<Segment>> {
    segments_of_shard(plan, PART_FRAMES, shard.unwrap_or(Shard { number: 1, count: 1 }))
}

fn sequence(source: &dyn FrameSource, group: &SourceGroup) -> Sequence {
    let probe = source.probes()[group.probe].name.clone();
    let faces = group.faces.iter().map(|face| face.name()).collect::<Vec<_>>().join(",");
    Sequence { kind: group.kind.name().to_owned(), probe, faces, frames: [group.frames.first, group.frames.last] }
}

fn sequences(source: &dyn FrameSource) -> Vec<Sequence> {
    source.groups().iter().map(|group| sequence(source, group)).collect()
}

/// Joins the first `MAX_NAMED` words; an ellipsis marks that more follow.
fn few(words: &[String]) -> String {
    const MAX_NAMED: usize = 4;
    let more = if words.len() > MAX_NAMED { ", …" } else { "" };
    words.iter().take(MAX_NAMED).cloned().collect::<Vec<_>>().join(", ") + more
}

fn footage(source: &dyn FrameSource) -> String {
    let program = Fingerprint::of_program(&[codec::SOURCES, crate::SOURCES]);
    digest(format!("{program:?} {:?} {:?}", source.configuration(), sequences(source)).as_bytes())
}
