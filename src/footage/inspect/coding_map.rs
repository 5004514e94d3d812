//! Coding maps: the rectangles that the records of a frame write, and how they are coded. Also the keyframes and bytes of each
//! colour cell.
//!
//! Chunks are parsed but not decoded to pixels.

use std::collections::BTreeMap;

use codec::container::ChunkEntry;
use codec::decode::{Decoder, StreamInfo};
use codec::error::{Error, Result};
use codec::image::StreamKind;
use codec::monitor::Monitor;
use codec::ordered::try_map_ordered;
use codec::streams::StreamChunk;
use codec::unit_map::{Patch, Writing};
use codec::unit_map::{survey_chunk, unit_map};

#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Extent {
    pub parts: u64,
    pub pixels: u64,
}

/// The coding map of a frame: the rectangles that its records write (GDC figure 1b).
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CodingMap {
    pub frame: u32,
    /// Patches in unit order, without overlap. Together they are the pixels that a decoder of consecutive frames writes.
    pub patches: Vec<Patch>,
    /// Number of nodes, boxes or units that the patches belong to.
    pub parts: u32,
    pub written_units: u32,
    /// Number of units whose record is the first of a chunk, or a colour keyframe.
    pub keyframe_units: u32,
}

impl CodingMap {
    pub fn updated_pixels(&self) -> u64 {
        self.patches.iter().map(Patch::pixels).sum()
    }

    pub fn extents(&self) -> BTreeMap<Writing, Extent> {
        let mut extents: BTreeMap<Writing, (Extent, Option<u32>)> = BTreeMap::new();
        for patch in &self.patches {
            let (extent, last) = extents.entry(patch.writing).or_default();
            // Patches of one part are consecutive.
            extent.parts += u64::from(last.replace(patch.part) != Some(patch.part));
            extent.pixels += patch.pixels();
        }
        extents.into_iter().map(|(writing, (extent, _))| (writing, extent)).collect()
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CellCoding {
    /// Left, top, width and height in the image.
    pub rect: [u32; 4],
    /// Number of keyframes stored in blocks of a texture format.
    pub blocks: u64,
    /// Number of keyframes stored as samples.
    pub samples: u64,
    /// Number of first frames of chunks of the transform codec.
    pub transformed: u64,
    /// Stored bytes, summed over all chunks.
    pub bytes: u64,
}

impl CellCoding {
    pub fn keyframes(&self) -> u64 {
        self.blocks + self.samples + self.transformed
    }
}

/// Changes of a stream over all frames.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Survey {
    /// The first frame with the most pixels in records other than the first of their chunk. For colour, the first frame with the
    /// most pixels between keyframes or, without any, with the most keyframe pixels. `None` if nothing changes.
    pub busiest: Option<u32>,
    /// Colour cells in unit order; empty for other kinds.
    pub cells: Vec<CellCoding>,
}

/// Parses all chunks of a stream, units in parallel. The monitor advances by one for each chunk.
pub fn survey(decoder: &Decoder, stream: &StreamInfo, monitor: &dyn Monitor) -> Result<Survey> {
    let index = decoder.reader().index();
    let surveyed = try_map_ordered((0..stream.entry.unit_count()).collect(), |unit| {
        let rect = stream.entry.unit_rect(unit);
        let mut cell = CellCoding { rect, blocks: 0, samples: 0, transformed: 0, bytes: 0 };
        let (mut changed, mut keyframes) = (Frames::new(), Frames::new());
        for chunk in index.unit_chunks(stream.index, unit) {
            monitor.check()?;
            let counted = survey_chunk(&parsed(decoder, stream, chunk)?, chunk.key.frame_count)?;
            cell.blocks += counted.keyframes_in_blocks;
            cell.samples += counted.keyframes_in_samples;
            cell.transformed += counted.transformed_keyframes;
            cell.bytes += u64::from(chunk.stored_bytes);
            add(&mut changed, chunk.key.first_frame, counted.changed);
            add(&mut keyframes, chunk.key.first_frame, counted.later_keyframes);
            monitor.advance(1);
        }
        Ok((cell, changed, keyframes))
    })?;
    let (mut changed, mut keyframes, mut cells) = (Frames::new(), Frames::new(), Vec::new());
    for (cell, changed_in_unit, keyframes_of_unit) in surveyed {
        cells.extend((stream.kind == StreamKind::Color).then_some(cell));
        add(&mut changed, 0, changed_in_unit);
        add(&mut keyframes, 0, keyframes_of_unit);
    }
    Ok(Survey { busiest: busiest(&changed).or_else(|| busiest(&keyframes)), cells })
}

type Frames = BTreeMap<u32, u64>;

fn add(frames: &mut Frames, first: u32, others: impl IntoIterator<Item = (u32, u64)>) {
    others.into_iter().for_each(|(frame, pixels)| *frames.entry(first + frame).or_insert(0) += pixels);
}

/// Returns the first frame with the most pixels; `None` if all have 0.
fn busiest(frames: &Frames) -> Option<u32> {
    let most = frames.values().copied().max().filter(|&most| most > 0)?;
    frames.iter().find(|(_, pixels)| **pixels == most).map(|(&frame, _)| frame)
}

fn parsed(decoder: &Decoder, stream: &StreamInfo, chunk: &ChunkEntry) -> Result<StreamChunk> {
    let reader = decoder.reader();
    let parsed = reader.fetch(chunk).and_then(|payload| StreamChunk::parse(stream, reader.index(), chunk, payload));
    parsed.map_err(|error| reader.blame(chunk, error))
}

pub fn coding_map(decoder: &Decoder, stream: &StreamInfo, frame: u32) -> Result<CodingMap> {
    let units = try_map_ordered((0..stream.entry.unit_count()).collect(), |unit| {
        let rect = stream.entry.unit_rect(unit);
        let chunk = chunk_of(decoder.reader().index().unit_chunks(stream.index, unit), frame)
            .ok_or_else(|| Error::Usage(format!("frame {frame} is not one of the stream's frames")))?;
        let at = frame - chunk.key.first_frame;
        Ok((rect, unit_map(&parsed(decoder, stream, chunk)?, [rect[2], rect[3]], at)?))
    })?;
    let mut map = CodingMap { frame, patches: vec![], parts: 0, written_units: 0, keyframe_units: 0 };
    for ([left, top, _, _], unit) in units {
        let parts = unit.patches.iter().map(|patch| patch.part + 1).max().unwrap_or(0);
        map.written_units += u32::from(parts > 0);
        map.keyframe_units += u32::from(unit.keyframe);
        map.patches.extend(unit.patches.into_iter().map(|patch| {
            let [x, y, width, height] = patch.rect;
            Patch { rect: [left + x, top + y, width, height], part: map.parts + patch.part, ..patch }
        }));
        map.parts += parts;
    }
    Ok(map)
}

fn chunk_of(chunks: &[ChunkEntry], frame: u32) -> Option<&ChunkEntry> {
    let at = chunks.partition_point(|chunk| chunk.key.first_frame <= frame);
    chunks.get(at.checked_sub(1)?).filter(|chunk| frame - chunk.key.first_frame < chunk.key.frame_count)
}
