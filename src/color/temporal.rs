//! Encodes the frames of one colour cell into chunks (CALF 5.1, algorithm 2).
//!
//! Enters: the cell's samples, frame by frame. Leaves: payloads of [`crate::color::cells`]. Memory: the pictures that
//! the search may reach, repeats counted once, and the open chunk.

use crate::color::blend::Sample;
use crate::color::cells::CellBuilder;
use crate::color::keyframes::{Candidates, SearchSettings};
use crate::color::quality::Quality;
use crate::container::EncodedChunk;
use crate::error::Result;

/// A chunk is closed at the first keyframe after it has grown to this many bytes. Larger chunks compress better,
/// smaller ones cost less to reach into.
pub const CLOSE_AT_BYTES: usize = 512 << 10;
/// Keyframes that a chunk may hold.
const MAX_KEYFRAMES: usize = 4096;

/// A picture and how often it is repeated.
#[derive(Debug)]
struct Entry<S> {
    samples: Vec<S>,
    run: u32,
}

/// Encodes one cell.
#[derive(Debug)]
pub struct CellEncoder<S> {
    settings: SearchSettings,
    close_at_bytes: usize,
    /// The last keyframe, and what came after it.
    pending: Vec<Entry<S>>,
    open: CellBuilder,
    chunk_first: u32,
}

impl<S: Sample> CellEncoder<S> {
    /// An encoder for one cell that closes chunks at `close_at_bytes`, [`CLOSE_AT_BYTES`] unless memory is short.
    pub fn new(settings: SearchSettings, close_at_bytes: usize) -> Self {
        CellEncoder { settings, close_at_bytes, pending: Vec::new(), open: CellBuilder::default(), chunk_first: 0 }
    }

    /// Takes the next frame; all frames have the same number of samples. Answers the chunk that it closes, if any.
    pub fn push<Q: Quality<S>>(&mut self, samples: &[S], quality: &Q) -> Result<Option<EncodedChunk>> {
        match self.pending.last_mut() {
            Some(last) if last.samples == samples => {
                last.run += 1;
                return Ok(None);
            }
            Some(_) => self.pending.push(Entry { samples: samples.to_vec(), run: 1 }),
            None => {
                self.open.push_keyframe(samples);
                self.pending.push(Entry { samples: samples.to_vec(), run: 1 });
            }
        }
        if self.pending.len() > self.settings.reach as usize + 1 { self.place_keyframe(quality) } else { Ok(None) }
    }

    /// Ends the cell; answers the chunks still open.
    pub fn finish<Q: Quality<S>>(&mut self, quality: &Q) -> Result<Vec<EncodedChunk>> {
        let mut chunks = Vec::new();
        while self.pending.len() > 1 {
            if self.candidates(quality).keyframe_serves_all() {
                self.pending[0].run += self.pending.drain(1..).map(|entry| entry.run).sum::<u32>();
            } else {
                chunks.extend(self.place_keyframe(quality)?);
            }
        }
        if let Some(last) = self.pending.pop() {
            self.open.push_weight(0, last.run - 1);
            chunks.push(self.close()?);
        }
        Ok(chunks)
    }

    fn candidates<'a, Q: Quality<S>>(&'a self, quality: &'a Q) -> Candidates<'a, S, Q> {
        let pictures = self.pending.iter().map(|entry| entry.samples.as_slice()).collect();
        Candidates::new(pictures, quality, self.settings.min_psnr_db)
    }

    /// Writes the frames up to the next keyframe, and the keyframe.
    fn place_keyframe<Q: Quality<S>>(&mut self, quality: &Q) -> Result<Option<EncodedChunk>> {
        let search = self.candidates(quality);
        let next = search.next_keyframe(self.settings.effort);
        let weights: Vec<u8> = (1..next).map(|at| search.best_weight(at, next).0).collect();
        // The keyframe's own frame is in the chunk already; its repeats are not.
        self.open.push_weight(0, self.pending[0].run - 1);
        for (entry, weight) in self.pending[1..next].iter().zip(weights) {
            self.open.push_weight(weight, entry.run);
        }
        self.pending.drain(..next);
        let full = self.open.bytes() >= self.close_at_bytes || self.open.keyframe_count() >= MAX_KEYFRAMES;
        let closed = if full { Some(self.close()?) } else { None };
        self.open.push_keyframe(&self.pending[0].samples);
        Ok(closed)
    }

    fn close(&mut self) -> Result<EncodedChunk> {
        let open = std::mem::take(&mut self.open);
        let (first_frame, frame_count) = (self.chunk_first, open.frame_count());
        self.chunk_first += frame_count;
        Ok(EncodedChunk { first_frame, frame_count, payload: open.finish()? })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::cells::CellChunk;
    use crate::color::keyframes::Effort;
    use crate::color::quality::EightBit;

    fn encode(frames: &[Vec<u8>], settings: SearchSettings) -> Vec<(EncodedChunk, CellChunk<u8>)> {
        let mut encoder = CellEncoder::new(settings, CLOSE_AT_BYTES);
        let mut chunks = Vec::new();
        for frame in frames {
            chunks.extend(encoder.push(frame, &EightBit).unwrap());
        }
        chunks.extend(encoder.finish(&EightBit).unwrap());
        chunks
            .into_iter()
            .map(|chunk| {
                let parsed = CellChunk::parse(chunk.payload.clone(), frames[0].len() / 3, chunk.frame_count).unwrap();
                (chunk, parsed)
            })
            .collect()
    }

    /// Decodes every frame from scratch and checks its quality; answers the number of keyframes.
    fn check(frames: &[Vec<u8>], settings: SearchSettings) -> usize {
        let chunks = encode(frames, settings);
        let samples = frames[0].len();
        let limit = EightBit.max_squared_error(settings.min_psnr_db, samples);
        let mut frame = 0;
        for (at, (chunk, cell)) in chunks.iter().enumerate() {
            assert_eq!(chunk.first_frame as usize, frame);
            for inside in 0..chunk.frame_count {
                let blend = cell.blend(inside);
                let (mut a, mut b) = (vec![0; samples], vec![0; samples]);
                cell.read_keyframe(blend.keyframe, &mut a);
                if blend.weight != 0 {
                    let (next, index) =
                        if cell.is_last(blend.keyframe) { (&chunks[at + 1].1, 0) } else { (cell, blend.keyframe + 1) };
                    next.read_keyframe(index, &mut b);
                }
                let error = EightBit.squared_error(&a, &b, blend.weight, &frames[frame], u64::MAX);
                assert!(error <= limit, "frame {frame}: {error} > {limit}");
                frame += 1;
            }
        }
        assert_eq!(frame, frames.len());
        chunks.iter().map(|(_, cell)| cell.keyframes().len()).sum()
    }

    fn footage(n: usize, samples: usize) -> Vec<Vec<u8>> {
        let mut seed = 11u32;
        (0..n)
            .map(|t| {
                (0..samples)
                    .map(|i| {
                        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                        let noise = if (t / 40) % 2 == 1 { (seed >> 24) % 8 } else { 0 };
                        let cut = if t > n / 2 { 60 } else { 0 };
                        (i + t / 2 + cut + noise as usize) as u8
                    })
                    .collect()
            })
            .collect()
    }

    #[test]
    fn every_frame_reaches_the_quality_asked_for() {
        for effort in [Effort::Fast, Effort::Normal, Effort::Exhaustive] {
            for (min_psnr_db, reach) in [(50.0, 64), (35.0, 64), (50.0, 1), (99.0, 3)] {
                let count = check(&footage(160, 60), SearchSettings { min_psnr_db, effort, reach });
                assert!(count > 1 && count <= 160);
            }
        }
    }

    #[test]
    fn a_cell_that_never_changes_has_one_keyframe_and_no_weights() {
        let frames = vec![(0..30).collect::<Vec<u8>>(); 500];
        assert_eq!(check(&frames, SearchSettings::default()), 1);
        assert_eq!(encode(&frames, SearchSettings::default())[0].0.payload.len(), 8 + 4 + 30);
    }

    #[test]
    fn a_cell_that_changes_once_has_two() {
        let mut frames = vec![vec![10u8; 30]; 100];
        frames.extend(vec![vec![200u8; 30]; 100]);
        assert_eq!(check(&frames, SearchSettings::default()), 2);
    }

    #[test]
    fn long_noise_is_split_into_chunks_that_lead_into_each_other() {
        let frames = footage(80, 30_000);
        let settings = SearchSettings { min_psnr_db: 30.0, reach: 8, ..SearchSettings::default() };
        assert!(encode(&frames, SearchSettings { min_psnr_db: 60.0, ..settings }).len() > 1);
        check(&frames, SearchSettings { min_psnr_db: 60.0, ..settings });
        check(&frames, settings);
    }
}
