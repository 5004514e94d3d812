//! How each pixel of a unit is coded in a frame: the node, box or block that it belongs to, and its kind.
//!
//! The patches are those of `lightfold inspect --plot`. Pixels that a frame does not write show the last patch that wrote them.

use codec::container::Payload;
use codec::depth::nodes::Function;
use codec::depth::predictive::PredictiveChunk;
use codec::depth::predictive::modes::BlockCoding;
use codec::error::{Error, Result};
use codec::streams::{CodecHeader, DepthChunk, PictureChunk, StreamChunk};

use crate::chunk_decoder::{Frames, Shown};
use crate::stream::{ChunkArea, Stream};
use codec::unit_map::unit_map;
use codec::unit_map::{Patch, Writing};

/// Bit of pixels that an earlier frame of the chunk wrote.
const KEPT: u8 = 0x40;
/// Bit of pixels at the left or upper edge of a patch's part, or of the unit.
const BORDER: u8 = 0x80;

/// Returns the number of a kind of coding: its place in `CODINGS` of viewer/src/player/coding_colors.ts.
fn number_of(writing: Writing) -> u8 {
    match writing {
        Writing::Function(Function::Raw) => 1,
        Writing::Function(Function::Biquadratic) => 2,
        Writing::Function(Function::Platelet) => 3,
        Writing::Function(Function::Bc4w) => 4,
        Writing::Values => 5,
        Writing::OneValue => 6,
        Writing::Blocks => 7,
        // A block equals the frame before the first, which is background.
        Writing::Predicted(BlockCoding::Background | BlockCoding::Same) => 8,
        Writing::Predicted(BlockCoding::Plane) => 9,
        Writing::Predicted(BlockCoding::ChangedPlane) => 10,
        Writing::Predicted(BlockCoding::Quarters) => 11,
        Writing::Predicted(BlockCoding::Pixels) => 12,
        Writing::Blend | Writing::Transform | Writing::Palette => 0,
    }
}

/// The coding maps of a chunk's frames, as [`Frames`] of one byte per pixel.
pub struct CodingMaps {
    chunk: StreamChunk,
    /// Patches of all frames of predictive coding, which is decoded once.
    predicted: Vec<Vec<Patch>>,
    size: [u32; 2],
    at: Option<u32>,
    numbers: Vec<u8>,
    /// Part that each pixel belongs to, counted over all frames, and the first part of the frame.
    parts: Vec<u32>,
    first_part: u32,
    next_part: u32,
    map: Vec<u8>,
}

impl CodingMaps {
    /// Returns the maps of a chunk, whose payload is checked here.
    pub fn open(stream: &Stream, payload: Payload, area: ChunkArea) -> Result<CodingMaps> {
        let unit = stream.unit_area(area.unit);
        let chunk = match &stream.header {
            CodecHeader::Depth(header) => StreamChunk::Depth(DepthChunk::parse(header, payload, unit, area.frames)?),
            CodecHeader::Material(header) => {
                StreamChunk::Material(PictureChunk::parse(header, payload, unit, area.frames)?)
            }
            CodecHeader::Alpha(header) => {
                StreamChunk::Alpha(Box::new(PictureChunk::parse(header, payload, unit, area.frames)?))
            }
            CodecHeader::Color(_) => {
                return Err(Error::unsupported("there are no maps of how the pixels of colors are coded"));
            }
        };
        let predicted = match &chunk {
            StreamChunk::Depth(DepthChunk::Predictive(chunk)) => predicted(chunk)?,
            StreamChunk::Alpha(chunk) => predicted(chunk)?,
            _ => Vec::new(),
        };
        let pixels = unit.size().iter().map(|&side| side as usize).product();
        Ok(CodingMaps {
            chunk,
            predicted,
            size: unit.size(),
            at: None,
            numbers: vec![0; pixels],
            parts: vec![0; pixels],
            first_part: 1,
            next_part: 1,
            map: vec![0; pixels],
        })
    }

    /// True if each frame is complete in itself.
    fn is_complete(&self) -> bool {
        matches!(self.chunk, StreamChunk::Depth(DepthChunk::Blocks(_)))
    }

    fn paint(&mut self, frame: u32) -> Result<()> {
        let new;
        let patches = match self.predicted.get(frame as usize) {
            Some(patches) => patches,
            None => {
                new = unit_map(&self.chunk, self.size, frame)?.patches;
                &new
            }
        };
        if frame == 0 || self.is_complete() {
            self.next_part = 1;
        }
        self.first_part = self.next_part;
        for Patch { rect: [left, top, width, height], writing, part } in patches {
            let part = self.first_part + part;
            self.next_part = self.next_part.max(part + 1);
            for y in *top..top + height {
                let row = (y * self.size[0] + left) as usize..(y * self.size[0] + left + width) as usize;
                self.numbers[row.clone()].fill(number_of(*writing));
                self.parts[row].fill(part);
            }
        }
        Ok(())
    }
}

impl Frames for CodingMaps {
    fn show(&mut self, frame: u32) -> Result<Shown> {
        let first = match self.at {
            _ if self.is_complete() => frame,
            Some(at) if at <= frame => at + 1,
            _ => 0,
        };
        self.at = None;
        for frame in first..=frame {
            self.paint(frame)?;
        }
        self.at = Some(frame);
        let width = self.size[0] as usize;
        // Nothing is painted where the frame was shown before: its parts are still the first.
        for (at, byte) in self.map.iter_mut().enumerate() {
            let part = self.parts[at];
            let is_border =
                at % width == 0 || at < width || self.parts[at - 1] != part || self.parts[at - width] != part;
            let kept = if part < self.first_part { KEPT } else { 0 };
            *byte = self.numbers[at] | kept | if is_border { BORDER } else { 0 };
        }
        Ok(Shown::Frame)
    }

    fn picture(&self) -> (*const u8, usize) {
        (self.map.as_ptr(), self.map.len())
    }
}

/// Returns the blocks that differ from the previous frame, of all frames; for the first frame all blocks, or the whole unit as
/// background.
fn predicted(chunk: &PredictiveChunk) -> Result<Vec<Vec<Patch>>> {
    let mut all = Vec::new();
    chunk.for_each_frame(|frame| {
        let is_first = frame.frame == 0;
        let written = frame.blocks.iter().filter(|block| is_first || block.coding != BlockCoding::Same);
        let coded = written.map(|block| (block.area.rect(), block.coding));
        let whole = ([0, 0, frame.size[0], frame.size[1]], BlockCoding::Background);
        let background = (is_first && frame.blocks.is_empty()).then_some(whole);
        let rects = coded.chain(background).zip(0..);
        all.push(
            rects.map(|((rect, coding), part)| Patch { rect, writing: Writing::Predicted(coding), part }).collect(),
        );
        Ok(())
    })?;
    Ok(all)
}
