//! Encodes the frames of one unit into chunks: a keyframe, then boxes around the changes (CALF 5.2, algorithm 3).
//!
//! Input: the unit's pixels, frame by frame. Output: payloads of [`crate::depth::records`]. Memory: the decoder's picture, two
//! bytes per pixel for age and mask, and the open chunk.
//!
//! The window rule (depth.md 4): the paper compares source frames with each other, so that a pixel that creeps by less than
//! epsilon per frame is never sent and drifts without limit. Here the loop is closed: the source is compared with the decoder's
//! picture. A pixel is sent while fewer than W frames have passed since it changed.

use crate::container::EncodedChunk;
use crate::depth::boxes::TemporalSettings;
use crate::depth::boxes::cover::{BoxBudget, Mask, cover};
use crate::depth::open_chunk::OpenChunk;
use crate::depth::record_table::TableBuilder;
use crate::depth::texel::Texel;
use crate::error::Result;

pub trait Held<T: Texel>: std::fmt::Debug + Send {
    fn start(&mut self, source: &[T], chunk: &mut TableBuilder);

    /// Encodes a frame, counted from the keyframe, and writes its record if anything must be sent.
    fn advance(&mut self, source: &[T], frame: u32, chunk: &mut TableBuilder);
}

#[derive(Debug)]
struct HeldValues<T> {
    settings: TemporalSettings,
    width: usize,
    picture: Vec<T>,
    /// Frames since the pixel changed, saturating; also `u8::MAX` if it has not changed since the keyframe.
    age: Vec<u8>,
    /// One byte per pixel: 1 if the current frame must send it.
    mask: Vec<u8>,
}

impl<T: Texel> Held<T> for HeldValues<T> {
    fn start(&mut self, source: &[T], chunk: &mut TableBuilder) {
        self.picture.clear();
        self.picture.extend_from_slice(source);
        self.age.clear();
        self.age.resize(source.len(), u8::MAX);
        self.mask.resize(source.len(), 0);
        chunk.put_values(source);
    }

    fn advance(&mut self, source: &[T], frame: u32, chunk: &mut TableBuilder) {
        let TemporalSettings { window, epsilon, max_aabbs, .. } = self.settings;
        let mut any = 0;
        for (((held, age), mask), &source) in self.picture.iter_mut().zip(&mut self.age).zip(&mut self.mask).zip(source)
        {
            let keep = T::within(*held, source, epsilon);
            *held = if keep { *held } else { source };
            *age = if keep { age.saturating_add(1) } else { 0 };
            *mask = u8::from(*age < window);
            any |= *mask;
        }
        if any != 0 {
            // A box takes eight bytes, so an additional box must save more bytes of pixels than that.
            let budget = BoxBudget { max_boxes: max_aabbs, min_saving: (8 / T::BYTES) as u32 };
            let boxes = cover(Mask { pixels: &self.mask, width: self.width }, budget);
            chunk.put_boxes_of(frame, &boxes, &self.picture, self.width);
        }
    }
}

#[derive(Debug)]
pub struct TemporalEncoder<T> {
    chunk: OpenChunk,
    held: Box<dyn Held<T>>,
}

impl<T: Texel> TemporalEncoder<T> {
    pub fn new(width: u32, settings: TemporalSettings) -> Self {
        let (picture, age, mask) = (Vec::new(), Vec::new(), Vec::new());
        let held = HeldValues { settings, width: width as usize, picture, age, mask };
        Self::with(Box::new(held), settings.keyframe_interval)
    }

    pub fn with(held: Box<dyn Held<T>>, keyframe_interval: u32) -> Self {
        TemporalEncoder { chunk: OpenChunk::new(keyframe_interval), held }
    }

    pub fn push(&mut self, source: &[T]) -> Result<Option<EncodedChunk>> {
        let finished = self.chunk.count_frame(source.len())?;
        match self.chunk.frame() {
            0 => self.held.start(source, self.chunk.records()),
            frame => self.held.advance(source, frame, self.chunk.records()),
        }
        Ok(finished)
    }

    pub fn finish(&mut self) -> Result<Option<EncodedChunk>> {
        self.chunk.finish()
    }
}

#[cfg(test)]
pub(super) mod tests;
