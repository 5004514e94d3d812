//! A chunk of one cell in either codec: keyframes and weights, or a transform in space and time.

use crate::color::blend::Sample;
use crate::color::cells::{CellChunk, CellFormat};
use crate::color::transform::payload::{SECTION, check_frames, holds_cells};
use crate::color::transform::{Keyed, Tables, TransformChunk};
use crate::container::{ChunkPlace, Payload};
use crate::error::{Error, Result};

/// Parameters for parsing the chunks of a cell.
#[derive(Debug, Clone)]
pub struct ChunkFormat<S> {
    pub cell: CellFormat<S>,
    /// Entropy tables of the transform codec; `None` if all chunks are keyframes and weights.
    pub tables: Option<Tables>,
}

#[derive(Debug)]
pub enum ColorChunk<S> {
    Cells(CellChunk<S>),
    Transform(TransformChunk),
}

impl<S: Keyed> ChunkFormat<S> {
    pub fn parse(&self, payload: Payload, frames: u32, place: ChunkPlace) -> Result<ColorChunk<S>> {
        let Some(tables) = &self.tables else {
            return Ok(ColorChunk::Cells(CellChunk::parse_at(payload, self.cell, frames, place)?));
        };
        if !holds_cells(&payload) {
            let chunk = TransformChunk::parse::<S>(&payload, self.cell.size, frames, tables)?;
            return Ok(ColorChunk::Transform(chunk));
        }
        check_frames(frames)?;
        let chunk = CellChunk::parse(payload.skip(1), self.cell, frames)?;
        if chunk.closed_by_next {
            let message = "keyframes in a chunk of the transform codec are closed by the next chunk";
            return Err(Error::invalid_at(SECTION, 0, message));
        }
        Ok(ColorChunk::Cells(chunk))
    }
}

impl<S: Sample> ColorChunk<S> {
    /// True if two frames are coded as the same picture.
    pub fn is_same(&self, frame: u32, other: u32) -> bool {
        match self {
            ColorChunk::Cells(chunk) => chunk.blend(frame) == chunk.blend(other),
            ColorChunk::Transform(chunk) => chunk.changed_leaves(frame as usize, Some(other as usize)).next().is_none(),
        }
    }

    /// Returns memory for reuse by the next payload.
    pub fn into_spare(self) -> Vec<u8> {
        match self {
            ColorChunk::Cells(chunk) => chunk.into_spare(),
            ColorChunk::Transform(_) => Vec::new(),
        }
    }
}

impl<S: Sample> CellChunk<S> {
    /// Writes a frame between keyframes of this chunk, three samples per pixel, unless it equals frame `shown`, whose samples
    /// are in `out`. Returns the number of pixels written.
    pub fn show(&self, frame: u32, shown: Option<u32>, out: &mut [S], scratch: &mut Vec<S>) -> u64 {
        let blend = self.blend(frame);
        if shown.is_some_and(|shown| self.blend(shown) == blend) {
            return 0;
        }
        self.read_keyframe(blend.keyframe, out);
        if blend.weight > 0 && !self.is_last(blend.keyframe) {
            scratch.resize(out.len(), S::default());
            self.read_keyframe(blend.keyframe + 1, scratch);
            for (sample, &next) in out.iter_mut().zip(scratch.iter()) {
                *sample = S::lerp(*sample, next, blend.weight);
            }
        }
        self.format.pixels() as u64
    }
}
