//! Decodes one cell of the transform codec. A frame needs only its own chunk.

use std::time::Instant;

use crate::color::transform::Keyed;
use crate::color::{ChunkFormat, ColorChunk};
use crate::decode::chunk_source::ChunkSource;
use crate::error::Result;

/// Decoded samples of one cell. The symbols of a chunk are decoded once; showing a frame rewrites only the blocks that differ
/// from the frame shown before.
#[derive(Debug)]
pub(super) struct TransformState<S> {
    format: ChunkFormat<S>,
    pub picture: Vec<S>,
    pub chunk: Option<(usize, ColorChunk<S>)>,
    /// Frame shown by `picture`, counted from the chunk's first.
    at: Option<u32>,
    /// Scratch buffer for a keyframe, used by chunks with keyframes.
    keyframe: Vec<S>,
}

impl<S: Keyed> TransformState<S> {
    pub fn new(format: ChunkFormat<S>) -> Self {
        TransformState { format, picture: Vec::new(), chunk: None, at: None, keyframe: Vec::new() }
    }

    pub fn forget(&mut self) {
        (self.chunk, self.at, self.keyframe) = (None, None, Vec::new());
    }

    pub fn shows(&self, index: usize, target: u32) -> bool {
        let held = self.chunk.as_ref().filter(|(held, _)| *held == index);
        held.zip(self.at).is_some_and(|((_, chunk), at)| chunk.is_same(target, at))
    }

    pub fn show(&mut self, source: &mut ChunkSource<'_>, frame: u32) -> Result<u64> {
        let (index, entry) = source.find(frame)?;
        if self.chunk.as_ref().is_none_or(|(held, _)| *held != index) {
            if let Some((_, old)) = self.chunk.take() {
                source.buffer = old.into_spare();
            }
            self.at = None;
            let place = source.reader.index().place(&entry);
            let format = &self.format;
            let parsed = source.fetch(&entry, |payload| format.parse(payload, entry.key.frame_count, place))?;
            self.chunk = Some((index, parsed));
        }
        let Some((_, chunk)) = &self.chunk else { return Ok(0) };
        let start = Instant::now();
        self.picture.resize(3 * self.format.cell.pixels(), S::default());
        let target = frame - entry.key.first_frame;
        let updated = match chunk {
            ColorChunk::Cells(chunk) => chunk.show(target, self.at, &mut self.picture, &mut self.keyframe),
            ColorChunk::Transform(chunk) => {
                chunk.show(target as usize, self.at.map(|at| at as usize), &mut self.picture)
            }
        };
        self.at = Some(target);
        source.cost.applying += start.elapsed();
        Ok(updated)
    }
}
