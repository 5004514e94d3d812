//! Encodes the frames of one unit into chunks: a keyframe, then boxes around what changes (CALF 5.2, algorithm 3).
//!
//! In: the unit's pixels, frame by frame. Out: payloads of [`crate::depth::records`]. Memory: two pictures and the open
//! chunk.

use crate::container::EncodedChunk;
use crate::depth::boxes::cover::{BoxBudget, Mask, cover};
use crate::depth::records::builder::ChunkBuilder;
use crate::depth::settings::TemporalSettings;
use crate::depth::texel::Texel;
use crate::depth::window::WindowState;
use crate::error::Result;

/// A chunk is closed early when it has grown to this many bytes, so that no keyframe interval is too long to store.
pub const CLOSE_AT_BYTES: usize = 256 << 20;

/// The decoder's picture, and how boxes of it are written.
pub trait Held<T: Texel> {
    fn start(&mut self, source: &[T]) -> ChunkBuilder<T>;

    /// Takes a frame, counted from the keyframe, in, and writes what it sends, if anything.
    fn advance(&mut self, source: &[T], frame: u32, chunk: &mut ChunkBuilder<T>);
}

#[derive(Debug)]
pub struct HeldValues<T> {
    settings: TemporalSettings,
    width: usize,
    state: Option<WindowState<T>>,
}

impl<T: Texel> Held<T> for HeldValues<T> {
    fn start(&mut self, source: &[T]) -> ChunkBuilder<T> {
        match &mut self.state {
            Some(state) => state.restart(source),
            None => self.state = Some(WindowState::new(source)),
        }
        ChunkBuilder::new(source)
    }

    fn advance(&mut self, source: &[T], frame: u32, chunk: &mut ChunkBuilder<T>) {
        let Some(state) = &mut self.state else { return };
        if state.advance(source, self.settings.epsilon, self.settings.window) {
            // A box costs eight bytes, so one more must save more pixels than that.
            let budget = BoxBudget { max_boxes: self.settings.max_aabbs, min_saving: (8 / T::BYTES) as u32 };
            let boxes = cover(Mask { pixels: state.mask(), width: self.width }, budget);
            chunk.push_boxes(frame, &boxes, state.held(), self.width);
        }
    }
}

#[derive(Debug)]
pub struct TemporalEncoder<T, H = HeldValues<T>> {
    keyframe_interval: u32,
    held: H,
    open: Option<ChunkBuilder<T>>,
    chunk_first: u32,
    next_frame: u32,
}

impl<T: Texel> TemporalEncoder<T> {
    pub fn new(width: u32, settings: TemporalSettings) -> Self {
        let held = HeldValues { settings, width: width as usize, state: None };
        Self::with(held, settings.keyframe_interval)
    }
}

impl<T: Texel, H: Held<T>> TemporalEncoder<T, H> {
    /// An encoder of what writes the picture, with at most `keyframe_interval` frames in a chunk.
    pub fn with(held: H, keyframe_interval: u32) -> Self {
        TemporalEncoder { keyframe_interval, held, open: None, chunk_first: 0, next_frame: 0 }
    }

    /// Takes the next frame; all frames have the same number of pixels. Answers the chunk that it closes, if any.
    pub fn push(&mut self, source: &[T]) -> Result<Option<EncodedChunk>> {
        let frame = self.next_frame;
        let in_chunk = frame - self.chunk_first;
        let full = |open: &ChunkBuilder<T>| in_chunk >= self.keyframe_interval || open.bytes() >= CLOSE_AT_BYTES;
        let finished = match &self.open {
            Some(open) if full(open) => self.finish()?,
            _ => None,
        };
        self.next_frame += 1;
        match &mut self.open {
            Some(open) => self.held.advance(source, in_chunk, open),
            None => {
                self.open = Some(self.held.start(source));
                self.chunk_first = frame;
            }
        }
        Ok(finished)
    }

    pub fn finish(&mut self) -> Result<Option<EncodedChunk>> {
        let Some(open) = self.open.take() else { return Ok(None) };
        let (first_frame, frame_count) = (self.chunk_first, self.next_frame - self.chunk_first);
        Ok(Some(EncodedChunk { first_frame, frame_count, payload: open.finish()? }))
    }
}

#[cfg(test)]
pub(super) mod tests;
