//! Encodes the frames of one unit into chunks: a keyframe, then boxes around what changes (CALF 5.2, algorithm 3).
//!
//! Enters: the unit's pixels, frame by frame. Leaves: payloads of [`crate::depth::records`], one for each group of
//! frames. Memory: two pictures and the open chunk.

use crate::container::EncodedChunk;
use crate::depth::boxes::{self, BoxBudget, MAX_BOXES, Mask};
use crate::depth::records::ChunkBuilder;
use crate::depth::texel::Texel;
use crate::depth::window::WindowState;
use crate::error::{Error, Result};

/// A chunk is closed early when it has grown to this many bytes, so that no keyframe interval is too long to store.
pub const CLOSE_AT_BYTES: usize = 256 << 20;

/// How frames are coded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TemporalSettings {
    /// W: a decoder may step over up to W − 1 frames. 1 to 255.
    pub window: u8,
    /// Largest difference, in codes, between a decoded pixel and its source.
    pub epsilon: u16,
    /// Most boxes in one frame of one unit. 1 to 256.
    pub max_aabbs: u16,
    /// Frames from one keyframe to the next, at least 1.
    pub keyframe_interval: u32,
}

impl Default for TemporalSettings {
    fn default() -> Self {
        TemporalSettings { window: 2, epsilon: 0, max_aabbs: 8, keyframe_interval: 64 }
    }
}

impl TemporalSettings {
    /// Refuses values that the format has no room for.
    pub fn check(&self) -> Result<()> {
        let wrong = |what: &str| Err(Error::Usage(what.to_owned()));
        match self {
            TemporalSettings { window: 0, .. } => wrong("the depth window must be 1 to 255 frames"),
            TemporalSettings { max_aabbs, .. } if !(1..=MAX_BOXES).contains(max_aabbs) => {
                wrong("the number of boxes must be 1 to 256")
            }
            TemporalSettings { keyframe_interval: 0, .. } => wrong("the keyframe interval must be at least 1 frame"),
            _ => Ok(()),
        }
    }
}

/// What an encoder knows of the picture that every decoder holds, and how it writes that picture.
pub trait Held<T: Texel> {
    /// Starts over at a keyframe.
    fn start(&mut self, source: &[T]) -> ChunkBuilder<T>;

    /// Takes a frame, counted from the keyframe, in, and writes what it sends, if anything.
    fn advance(&mut self, source: &[T], frame: u32, chunk: &mut ChunkBuilder<T>);
}

/// A picture whose boxes are written as values.
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
            let boxes = boxes::cover(Mask { pixels: state.mask(), width: self.width }, budget);
            chunk.push_boxes(frame, &boxes, state.held(), self.width);
        }
    }
}

/// Encodes one unit.
#[derive(Debug)]
pub struct TemporalEncoder<T, H = HeldValues<T>> {
    keyframe_interval: u32,
    held: H,
    open: Option<ChunkBuilder<T>>,
    chunk_first: u32,
    next_frame: u32,
}

impl<T: Texel> TemporalEncoder<T> {
    /// An encoder for a unit of `width` columns, whose boxes are written as values.
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

    /// Closes the open chunk, if there is one.
    pub fn finish(&mut self) -> Result<Option<EncodedChunk>> {
        let Some(open) = self.open.take() else { return Ok(None) };
        let (first_frame, frame_count) = (self.chunk_first, self.next_frame - self.chunk_first);
        Ok(Some(EncodedChunk { first_frame, frame_count, payload: open.finish()? }))
    }
}

/// For tests of this encoder with either way to write pictures.
#[cfg(test)]
pub(super) mod paths {
    use super::*;
    use crate::depth::records::{Layout, TemporalChunk};

    pub fn encode<T: Texel, H: Held<T>>(mut encoder: TemporalEncoder<T, H>, frames: &[Vec<T>]) -> Vec<EncodedChunk> {
        let mut chunks = Vec::new();
        for frame in frames {
            chunks.extend(encoder.push(frame).unwrap());
        }
        chunks.extend(encoder.finish().unwrap());
        assert_eq!(chunks.iter().map(|chunk| chunk.frame_count as usize).sum::<usize>(), frames.len());
        chunks
    }

    /// Walks random legal paths and the two canonical ones; all must show the same pictures within the bound.
    pub fn check_all<T: Texel, L: Layout<T>>(
        frames: &[Vec<T>],
        size: [u32; 2],
        chunks: Vec<EncodedChunk>,
        settings: TemporalSettings,
    ) {
        let mut seed = 7u32;
        for chunk in chunks {
            let parsed = TemporalChunk::<T, L>::parse(chunk.payload, size, chunk.frame_count).unwrap();
            let body = |frame| parsed.records().iter().find(|record| record.frame == frame).map(|record| record.body);
            let mut canonical = vec![vec![T::default(); frames[0].len()]];
            parsed.apply(&mut canonical[0], body(0).unwrap());
            for frame in 1..chunk.frame_count {
                let mut picture = canonical[frame as usize - 1].clone();
                if let Some(body) = body(frame) {
                    parsed.apply(&mut picture, body);
                }
                canonical.push(picture);
            }
            for (at, picture) in canonical.iter().enumerate() {
                let source = &frames[chunk.first_frame as usize + at];
                let ok = picture.iter().zip(source).all(|(&held, &source)| T::within(held, source, settings.epsilon));
                assert!(ok, "frame {at} leaves the bound");
            }
            for _ in 0..50 {
                let (mut picture, mut frame) = (canonical[0].clone(), 0);
                while frame + 1 < chunk.frame_count {
                    seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                    frame += 1 + (seed >> 16) % u32::from(settings.window);
                    frame = frame.min(chunk.frame_count - 1);
                    if let Some(body) = body(frame) {
                        parsed.apply(&mut picture, body);
                    }
                    assert_eq!(picture, canonical[frame as usize], "frame {frame}");
                }
            }
            for frame in 0..chunk.frame_count {
                let mut picture = vec![T::default(); frames[0].len()];
                parsed.advance(&mut picture, None, frame, settings.window);
                assert_eq!(picture, canonical[frame as usize]);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::depth::records::{TemporalChunk, Values};

    const SIZE: [u32; 2] = [12, 9];

    fn encode(frames: &[Vec<u16>], settings: TemporalSettings) -> Vec<EncodedChunk> {
        paths::encode(TemporalEncoder::new(SIZE[0], settings), frames)
    }

    fn check_all_paths(frames: &[Vec<u16>], settings: TemporalSettings) {
        paths::check_all::<u16, Values>(frames, SIZE, encode(frames, settings), settings);
    }

    #[test]
    fn every_legal_path_shows_the_same_frames_within_epsilon() {
        let mut seed = 3u32;
        let mut next = |n: u32| {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (seed >> 12) % n
        };
        let pixels = (SIZE[0] * SIZE[1]) as usize;
        let mut frames = vec![vec![30_000u16; pixels]];
        for _ in 1..60 {
            let mut frame = frames[frames.len() - 1].clone();
            for _ in 0..next(6) {
                let at = next(pixels as u32) as usize;
                frame[at] = match next(4) {
                    0 => u16::MAX,
                    1 => frame[at].wrapping_add(1),
                    2 => 30_000,
                    _ => next(65_536) as u16,
                };
            }
            frames.push(frame);
        }
        for window in [1, 2, 3, 16, 100] {
            for epsilon in [0, 1, 40] {
                for (max_aabbs, keyframe_interval) in [(1, 1000), (8, 20), (256, 7), (3, 1)] {
                    check_all_paths(&frames, TemporalSettings { window, epsilon, max_aabbs, keyframe_interval });
                }
            }
        }
    }

    #[test]
    fn a_pixel_that_creeps_below_epsilon_for_600_frames_stays_within_it() {
        let pixels = (SIZE[0] * SIZE[1]) as usize;
        let frames: Vec<Vec<u16>> =
            (0..600u16).map(|n| (0..pixels).map(|at| if at == 50 { 1000 + n } else { 7 }).collect()).collect();
        let settings = TemporalSettings { epsilon: 10, keyframe_interval: 1000, ..TemporalSettings::default() };
        check_all_paths(&frames, settings);
        let chunk = &encode(&frames, settings)[0];
        let parsed = TemporalChunk::<u16>::parse(chunk.payload.clone(), SIZE, 600).unwrap();
        // It is sent once every 11 frames, for the two frames of the window.
        assert_eq!(parsed.records().len(), 1 + 599 / 11 * 2);
    }

    #[test]
    fn a_static_unit_has_one_record_and_a_constant_one_no_pixels() {
        let flat = encode(&vec![vec![9; 108]; 30], TemporalSettings::default());
        assert_eq!(flat.len(), 1);
        assert_eq!(flat[0].payload.len(), 4 + 8 + 4 + 2);
        let ramp: Vec<u16> = (0..108).collect();
        let chunks = encode(&vec![ramp; 30], TemporalSettings { keyframe_interval: 10, ..Default::default() });
        assert_eq!(chunks.len(), 3);
        assert!(chunks.iter().all(|chunk| chunk.payload == chunks[0].payload));
    }
}
