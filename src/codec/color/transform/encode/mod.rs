//! Encodes chunks of a cell in as few bytes as the quality target allows, measured on decoded frames (color.md 6, 9).
//!
//! Input: the samples of a cell, frame by frame. Output: payloads of [`crate::color::transform::payload`].

mod activity;
mod estimate;
mod quantise;
mod rate;
mod search;
mod source;
mod target;
mod training;
mod tree;
mod weights;

use std::sync::Arc;

use crate::color::CellFormat;
use crate::color::quality::{Quality, SearchSettings, Target};
use crate::color::temporal::CellEncoder;
use crate::color::transform::Keyed;
use crate::color::transform::encode::source::CellSource;
use crate::color::transform::encode::target::{Encoded, encode_chunk};
use crate::color::transform::payload::CELLS;
use crate::container::EncodedChunk;
use crate::error::Result;

pub use rate::PricedTables;
pub use target::{COARSEST, Start};
pub use training::count_payload;

/// A PSNR that only lossless coding reaches.
const LOSSLESS_DB: f64 = 200.0;

/// Encodes the frames of one cell into chunks of a fixed number of frames.
#[derive(Debug)]
pub struct TransformEncoder<S> {
    format: CellFormat<S>,
    search: SearchSettings,
    tables: Arc<PricedTables>,
    chunk_frames: u32,
    chunk_first: u32,
    frames: Vec<Vec<S>>,
    /// Step and table set of the previous chunk, at which the next search starts.
    pub start: Option<Start>,
}

impl<S: Keyed> TransformEncoder<S> {
    /// `chunk_frames` is 1 to [`crate::color::transform::blocks::MAX_FRAMES`].
    pub fn new(format: CellFormat<S>, search: SearchSettings, chunk_frames: u32, tables: Arc<PricedTables>) -> Self {
        TransformEncoder { format, search, tables, chunk_frames, chunk_first: 0, frames: Vec::new(), start: None }
    }

    /// Adds the next frame. Returns the chunk that it completes, if any.
    pub fn push<Q: Quality<S>>(&mut self, samples: &[S], quality: &Q) -> Result<Option<EncodedChunk>> {
        self.frames.push(samples.to_vec());
        if self.frames.len() < self.chunk_frames as usize { Ok(None) } else { self.close(quality).map(Some) }
    }

    /// Returns the last chunk, if frames remain.
    pub fn finish<Q: Quality<S>>(&mut self, quality: &Q) -> Result<Option<EncodedChunk>> {
        if self.frames.is_empty() { Ok(None) } else { self.close(quality).map(Some) }
    }

    fn close<Q: Quality<S>>(&mut self, quality: &Q) -> Result<EncodedChunk> {
        let frames = std::mem::take(&mut self.frames);
        let cell = CellSource { size: self.format.size, frames: &frames };
        let transformed = encode_chunk(&cell, quality, &self.search, &self.tables, self.start);
        let raw_bytes = 3 * S::BYTES * self.format.pixels() * frames.len();
        // Keyframes take at least a quarter of the samples unless frames repeat, which takes a transform few bytes, too.
        let max_bytes = if matches!(self.search.target, Target::Psnr(_)) { raw_bytes / 4 } else { raw_bytes };
        let payload = match transformed {
            Some(Encoded { payload, start }) if payload.len() <= max_bytes => {
                self.start = Some(start);
                payload
            }
            transformed => {
                let cells = self.as_cells(&frames, quality)?;
                transformed
                    .map(|encoded| encoded.payload)
                    .filter(|payload| payload.len() <= cells.len())
                    .unwrap_or(cells)
            }
        };
        let (first_frame, frame_count) = (self.chunk_first, frames.len() as u32);
        self.chunk_first += frame_count;
        Ok(EncodedChunk { first_frame, frame_count, payload })
    }

    /// Encodes the chunk as keyframes and weights (color.md 4), without loss unless the target is a PSNR.
    fn as_cells<Q: Quality<S>>(&self, frames: &[Vec<S>], quality: &Q) -> Result<Vec<u8>> {
        let target = match self.search.target {
            Target::Psnr(db) => Target::Psnr(db),
            Target::Quality(_) | Target::Step(_) => Target::Psnr(LOSSLESS_DB),
        };
        let search = SearchSettings { target, ..self.search };
        let mut encoder = CellEncoder::new(search, usize::MAX);
        for frame in frames {
            encoder.push(frame, quality)?;
        }
        let chunks = encoder.finish(quality)?;
        Ok(chunks.into_iter().fold(vec![CELLS], |mut out, chunk| {
            out.extend(chunk.payload);
            out
        }))
    }
}
