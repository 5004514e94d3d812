//! Detects shards that an earlier run has encoded completely, so that a repeated command can skip them.

use std::collections::BTreeSet;
use std::path::Path;
use std::time::SystemTime;

use crate::dataset::SourceGroup;
use crate::encode::job::EncodeSummary;
use crate::encode::part::Part;
use crate::encode::precision::ProbePrecision;
use crate::encode::source::missing_frames;
use codec::container::Reader;
use codec::image::StreamKind;
use codec::streams::shard::SHARD;
use codec::streams::{CodecHeader, FootageInfo};

/// Returns the summary of the shard in a container, or `None` unless the container holds this shard, complete, with the same
/// settings and missing frames, and is newer than all files that the shard depends on. The modification time of a container is
/// set to the time before its first source file was read ([`crate::files::OutputFile::commit_as_of`]).
pub fn complete_shard(part: &Part<'_>, container: &Path) -> Option<EncodeSummary> {
    // Neither a pipe nor standard input can be checked.
    let read_from = std::fs::metadata(container).ok().filter(std::fs::Metadata::is_file)?.modified().ok()?;
    let reader = Reader::open(container).ok()?;
    let index = reader.index();
    if index.attributes.get(SHARD)? != part.shard.as_ref()?.entry.write() {
        return None;
    }
    let wanted = part.groups.iter().flat_map(|SourceGroup { kind, probe, faces, frames, .. }| {
        faces.iter().map(move |&face| (*kind as u8, *probe as u16, face as u8, frames.first, frames.count()))
    });
    let there = index.streams.iter();
    let there = there.map(|of| (of.kind, of.probe, of.face, of.first_frame, u64::from(of.frame_count)));
    if there.collect::<BTreeSet<_>>() != wanted.collect() || has_newer_files(part, read_from) {
        return None;
    }
    let footage = FootageInfo::read(index).ok()?;
    let missing: BTreeSet<_> = part.groups.iter().flat_map(|group| missing_frames(part, group)).collect();
    if !footage.missing_frames.iter().eq(&missing) {
        return None;
    }
    let mut summary = EncodeSummary {
        bytes: reader.file_bytes,
        clipped_pixels: footage.clipped_pixels.unwrap_or(0),
        resumed_chunks: index.chunks.len() as u64,
        ..EncodeSummary::default()
    };
    for stream in &index.streams {
        let header = CodecHeader::read(stream).ok()?;
        summary.count(stream, &header);
        if let CodecHeader::Depth(header) = &header
            && summary.depth.last().is_none_or(|known| known.probe != index.probes[usize::from(stream.probe)].name)
        {
            summary.depth.push(ProbePrecision::new(part, usize::from(stream.probe), header, None));
        }
    }
    Some(summary)
}

/// Returns true if a file was modified at or after `read_from`, or if its metadata cannot be read. Checks the files of the part,
/// and the depth images of its probes in all frames, because near and far are derived from them.
fn has_newer_files(part: &Part<'_>, read_from: SystemTime) -> bool {
    let probes = part.probes_of_depth();
    let depth = part.source.groups().iter();
    let depth = depth.filter(|group| group.kind == StreamKind::Depth && probes.contains(&group.probe));
    let mut files =
        part.groups.iter().chain(depth).flat_map(|group| group.frames.iter().map(move |frame| (group, frame)));
    let modified = |path: &Path| std::fs::metadata(path).and_then(|meta| meta.modified());
    files.any(|(group, frame)| match part.source.files(group, frame) {
        Ok(paths) => paths.iter().any(|path| modified(path).map_or(true, |time| time >= read_from)),
        Err(_) => true,
    })
}
