//! What one frame of a stream is made of: which rectangles its record writes, and with what (GDC figure 1b); and where in
//! the image a stream of colour spends its keyframes.
//!
//! Enters: an open container, one of its streams, a frame. Leaves: rectangles in pixels of the image, which do not overlap
//! and together are the pixels that a decoder writes that shows all frames in order. Nothing is decoded into pixels here.

mod units;

use std::collections::BTreeMap;

use crate::container::ChunkEntry;
use crate::decode::{Decoder, StreamInfo};
use crate::depth::nodes::Function;
use crate::error::Result;
use crate::monitor::Monitor;
use crate::ordered::try_map_ordered;

/// With what the pixels of a rectangle are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Writing {
    /// A node with a modelling function, or a BC4w block.
    Function(Function),
    /// One value for all of them.
    OneValue,
    /// Values as they are: of a whole unit, of a box, of a piece, or a keyframe in samples.
    Values,
    /// Blocks of a texture format.
    Blocks,
    /// A picture between two keyframes.
    Blend,
}

/// Pixels that are written in one way.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Patch {
    /// Left, top, width and height in the image.
    pub rect: [u32; 4],
    /// How they are written.
    pub writing: Writing,
    /// The node, box or unit that it belongs to, counted from 0 in the frame. A box or unit in pieces has several patches,
    /// as has a function of an intermediate form, whose patches are its leaves.
    pub part: u32,
}

/// How much is written in one way.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Extent {
    /// Nodes, boxes or units that have pixels written like that.
    pub parts: u64,
    /// Pixels.
    pub pixels: u64,
}

/// What a frame's records write.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FrameAnatomy {
    /// The frame, numbered as in the source.
    pub frame: u32,
    /// Rectangles, unit by unit; none overlap.
    pub patches: Vec<Patch>,
    /// Nodes, boxes or units that they belong to.
    pub parts: u32,
    /// Units that have a record in this frame.
    pub written_units: u32,
    /// Those among them whose record is complete in itself: the first one of a chunk, or a keyframe of colour.
    pub keyframe_units: u32,
}

impl FrameAnatomy {
    /// Pixels that the frame writes.
    pub fn updated_pixels(&self) -> u64 {
        self.patches.iter().map(Patch::pixels).sum()
    }

    /// What is written in which way.
    pub fn extents(&self) -> BTreeMap<Writing, Extent> {
        let mut extents: BTreeMap<Writing, (Extent, Option<u32>)> = BTreeMap::new();
        for patch in &self.patches {
            let (extent, last) = extents.entry(patch.writing).or_default();
            // Patches of one part follow each other.
            extent.parts += u64::from(last.replace(patch.part) != Some(patch.part));
            extent.pixels += patch.pixels();
        }
        extents.into_iter().map(|(writing, (extent, _))| (writing, extent)).collect()
    }
}

impl Patch {
    /// Pixels of the rectangle.
    pub fn pixels(&self) -> u64 {
        u64::from(self.rect[2]) * u64::from(self.rect[3])
    }
}

/// Keyframes of a cell of colour, over all frames.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CellKeyframes {
    /// Left, top, width and height in the image.
    pub rect: [u32; 4],
    /// Keyframes in blocks of a texture format.
    pub blocks: u64,
    /// Keyframes in samples as they are.
    pub samples: u64,
}

impl CellKeyframes {
    /// All of them.
    pub fn count(&self) -> u64 {
        self.blocks + self.samples
    }
}

/// What is found by going through all chunks of a stream.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Survey {
    /// The frame with most pixels written by records that are not the first one of their chunk; of colour, with most pixels
    /// between keyframes, or where there are none, with most pixels of keyframes. The earliest, where several have as many;
    /// none, where nothing ever changes.
    pub busiest: Option<u32>,
    /// Cells of colour, in the order of units; empty for depth and material.
    pub cells: Vec<CellKeyframes>,
}

/// Steps that [`survey`] advances its monitor by: one for each chunk.
pub fn survey_steps(decoder: &Decoder, stream: &StreamInfo) -> u64 {
    decoder.reader().index().stream_chunks(stream.index).len() as u64
}

/// Goes through all chunks of a stream, units in parallel.
///
/// # Errors
/// A chunk is damaged; the error names it.
pub fn survey(decoder: &Decoder, stream: &StreamInfo, monitor: &dyn Monitor) -> Result<Survey> {
    let (reader, index) = (decoder.reader(), decoder.reader().index());
    let surveyed = try_map_ordered((0..stream.entry.unit_count()).collect(), |unit| {
        let rect = stream.entry.unit_rect(unit);
        let mut cell = CellKeyframes { rect, blocks: 0, samples: 0 };
        let (mut changed, mut keyframes) = (Frames::new(), Frames::new());
        for chunk in index.unit_chunks(stream.index, unit) {
            monitor.check()?;
            let counted = reader.fetch(chunk).and_then(|payload| {
                let size = [rect[2], rect[3]];
                units::survey_chunk(&stream.header, payload, size, chunk.key.frame_count, index.place(chunk))
            });
            let counted = counted.map_err(|error| reader.blame(chunk, error))?;
            cell.blocks += counted.keyframes_in_blocks;
            cell.samples += counted.keyframes_in_samples;
            add(&mut changed, chunk.key.first_frame, counted.changed);
            add(&mut keyframes, chunk.key.first_frame, counted.later_keyframes);
            monitor.advance(1);
        }
        Ok((cell, changed, keyframes))
    })?;
    let (mut changed, mut keyframes, mut cells) = (Frames::new(), Frames::new(), Vec::new());
    for (cell, changed_in_unit, keyframes_of_unit) in surveyed {
        cells.extend((cell.count() > 0).then_some(cell));
        add(&mut changed, 0, changed_in_unit);
        add(&mut keyframes, 0, keyframes_of_unit);
    }
    Ok(Survey { busiest: busiest(&changed).or_else(|| busiest(&keyframes)), cells })
}

/// Pixels by frame.
type Frames = BTreeMap<u32, u64>;

/// Adds pixels of frames that are counted from `first`.
fn add(frames: &mut Frames, first: u32, others: impl IntoIterator<Item = (u32, u64)>) {
    others.into_iter().for_each(|(frame, pixels)| *frames.entry(first + frame).or_insert(0) += pixels);
}

/// The earliest frame with most pixels, where any has some.
fn busiest(frames: &Frames) -> Option<u32> {
    let most = frames.values().copied().max().filter(|&most| most > 0)?;
    frames.iter().find(|(_, pixels)| **pixels == most).map(|(&frame, _)| frame)
}

/// What a frame's records write.
///
/// # Errors
/// The stream has no such frame, or a chunk is damaged; the error names it.
pub fn frame_anatomy(decoder: &Decoder, stream: &StreamInfo, frame: u32) -> Result<FrameAnatomy> {
    let reader = decoder.reader();
    let units = try_map_ordered((0..stream.entry.unit_count()).collect(), |unit| {
        let rect = stream.entry.unit_rect(unit);
        let chunk = chunk_of(reader.index().unit_chunks(stream.index, unit), frame)
            .ok_or_else(|| crate::error::Error::Usage(format!("frame {frame} is not one of the stream's frames")))?;
        let at = frame - chunk.key.first_frame;
        let written = reader.fetch(chunk).and_then(|payload| {
            let (size, frames, place) = ([rect[2], rect[3]], (at, chunk.key.frame_count), reader.index().place(chunk));
            units::unit_anatomy(&stream.header, payload, size, frames, place)
        });
        written.map(|written| (rect, written)).map_err(|error| reader.blame(chunk, error))
    })?;
    let mut anatomy = FrameAnatomy { frame, patches: vec![], parts: 0, written_units: 0, keyframe_units: 0 };
    for ([left, top, _, _], unit) in units {
        let parts = unit.patches.iter().map(|patch| patch.part + 1).max().unwrap_or(0);
        anatomy.written_units += u32::from(parts > 0);
        anatomy.keyframe_units += u32::from(unit.keyframe);
        anatomy.patches.extend(unit.patches.into_iter().map(|patch| {
            let [x, y, width, height] = patch.rect;
            Patch { rect: [left + x, top + y, width, height], part: anatomy.parts + patch.part, ..patch }
        }));
        anatomy.parts += parts;
    }
    Ok(anatomy)
}

/// The chunk that holds a frame.
fn chunk_of(chunks: &[ChunkEntry], frame: u32) -> Option<&ChunkEntry> {
    let at = chunks.partition_point(|chunk| chunk.key.first_frame <= frame);
    chunks.get(at.checked_sub(1)?).filter(|chunk| frame - chunk.key.first_frame < chunk.key.frame_count)
}
