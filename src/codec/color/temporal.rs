//! Encodes the frames of one colour cell into chunks (CALF 5.1, algorithm 2; keyframes in blocks: 5.3).
//!
//! Input: the cell's samples, frame by frame. Output: payloads of [`crate::color::cells`]. Memory: the pictures of the
//! lookahead, with repeats stored once, and the open chunk.

use crate::color::blend::Sample;
use crate::color::cells::builder::CellBuilder;
use crate::color::keyframe_blocks::KeyframeBlocks;
use crate::color::keyframes::Candidates;
use crate::color::quality::{Quality, SearchSettings};
use crate::container::EncodedChunk;
use crate::error::Result;

/// A chunk is closed at the first keyframe after it has reached this many bytes. Larger chunks compress better; seeking into
/// smaller ones is cheaper.
pub const CLOSE_AT_BYTES: usize = 512 << 10;
const MAX_KEYFRAMES: usize = 4096;

#[derive(Debug)]
struct Entry<S> {
    samples: Vec<S>,
    run: u32,
}

/// Encoding of a cell's keyframes in blocks, after their positions are selected (CALF 5.3).
#[derive(Debug, Clone, Copy)]
pub struct BlockStage<S> {
    pub blocks: KeyframeBlocks<S>,
    pub size: [usize; 2],
    /// Minimum PSNR in dB of every frame with keyframes in blocks; at most that of the search.
    pub final_psnr_db: f64,
}

#[derive(Debug)]
enum Keyframe<S> {
    Samples,
    Blocks { stored: Vec<u8>, shown: Vec<S> },
}

impl<S> Keyframe<S> {
    fn shown<'a>(&'a self, source: &'a [S]) -> &'a [S] {
        match self {
            Keyframe::Samples => source,
            Keyframe::Blocks { shown, .. } => shown,
        }
    }
}

#[derive(Debug)]
pub struct CellEncoder<S> {
    settings: SearchSettings,
    blocks: Option<BlockStage<S>>,
    close_at_bytes: usize,
    /// The last keyframe, and the pictures after it.
    pending: Vec<Entry<S>>,
    keyframe: Keyframe<S>,
    open: CellBuilder,
    chunk_first: u32,
}

impl<S: Sample> CellEncoder<S> {
    /// Creates an encoder for one cell that closes chunks at `close_at_bytes`: [`CLOSE_AT_BYTES`], or less if memory is
    /// short.
    pub fn new(settings: SearchSettings, close_at_bytes: usize) -> Self {
        CellEncoder {
            settings,
            blocks: None,
            close_at_bytes,
            pending: Vec::new(),
            keyframe: Keyframe::Samples,
            open: CellBuilder::default(),
            chunk_first: 0,
        }
    }

    #[must_use]
    pub fn with_blocks(self, blocks: BlockStage<S>) -> Self {
        CellEncoder { blocks: Some(blocks), ..self }
    }

    /// Encodes the next frame; all frames have the same number of samples. Returns the chunk that this closes, if any.
    pub fn push<Q: Quality<S>>(&mut self, samples: &[S], quality: &Q) -> Result<Option<EncodedChunk>> {
        match self.pending.last_mut() {
            Some(last) if last.samples == samples => {
                last.run += 1;
                return Ok(None);
            }
            Some(_) => self.pending.push(Entry { samples: samples.to_vec(), run: 1 }),
            None => {
                let keyframe = self.coded(samples, quality);
                self.pending.push(Entry { samples: samples.to_vec(), run: 1 });
                self.open_keyframe(keyframe);
            }
        }
        if self.pending.len() > self.settings.lookahead as usize + 1 { self.place_keyframe(quality) } else { Ok(None) }
    }

    pub fn finish<Q: Quality<S>>(&mut self, quality: &Q) -> Result<Vec<EncodedChunk>> {
        let mut chunks = Vec::new();
        while self.pending.len() > 1 {
            if self.keyframe_serves_all(quality) {
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

    fn shown_psnr_db(&self) -> f64 {
        self.blocks.map_or(self.settings.target.min_psnr_db(), |stage| stage.final_psnr_db)
    }

    fn sources<'a, Q: Quality<S>>(&'a self, quality: &'a Q) -> Candidates<'a, S, Q> {
        let pictures = self.pending.iter().map(|entry| entry.samples.as_slice()).collect();
        Candidates::new(pictures, quality, self.settings.target.min_psnr_db())
    }

    /// As [`Self::sources`], with the decoded keyframe, up to picture `next`, whose decoded samples are `last`.
    fn shown<'a, Q: Quality<S>>(&'a self, next: usize, last: &'a [S], quality: &'a Q) -> Candidates<'a, S, Q> {
        let mut pictures: Vec<_> = self.pending[..=next].iter().map(|entry| entry.samples.as_slice()).collect();
        pictures[0] = self.keyframe.shown(pictures[0]);
        pictures[next] = last;
        Candidates::new(pictures, quality, self.shown_psnr_db())
    }

    fn keyframe_serves_all<Q: Quality<S>>(&self, quality: &Q) -> bool {
        let last = self.pending.len() - 1;
        let source = self.pending[last].samples.as_slice();
        self.sources(quality).keyframe_serves_all()
            && (self.blocks.is_none() || self.shown(last, source, quality).keyframe_serves_all())
    }

    /// Selects the storage of a keyframe: blocks if they reproduce its frame well enough, otherwise samples.
    fn coded<Q: Quality<S>>(&self, source: &[S], quality: &Q) -> Keyframe<S> {
        let Some(BlockStage { blocks, size, final_psnr_db }) = self.blocks else { return Keyframe::Samples };
        let limit = quality.max_squared_error(final_psnr_db, source.len());
        for &effort in blocks.encoder.tries(self.settings.effort) {
            let stored = (blocks.encoder.encode)(source, size, effort);
            let mut shown = vec![S::default(); source.len()];
            (blocks.decode)(&stored, size, &mut shown);
            if quality.squared_error(&shown, &shown, 0, source, limit) <= limit {
                return Keyframe::Blocks { stored, shown };
            }
        }
        Keyframe::Samples
    }

    fn open_keyframe(&mut self, keyframe: Keyframe<S>) {
        match &keyframe {
            Keyframe::Blocks { stored, .. } => self.open.push_keyframe_in_blocks(stored),
            Keyframe::Samples if self.blocks.is_some() => self.open.push_keyframe_as_samples(&self.pending[0].samples),
            Keyframe::Samples => self.open.push_keyframe(&self.pending[0].samples),
        }
        self.keyframe = keyframe;
    }

    /// Writes the frames up to the next keyframe, and the keyframe.
    ///
    /// Positions are searched with the source pictures. Between keyframes in blocks a frame may miss the final PSNR: it then
    /// becomes the next keyframe itself, which leaves fewer frames in between each time.
    fn place_keyframe<Q: Quality<S>>(&mut self, quality: &Q) -> Result<Option<EncodedChunk>> {
        let mut next = self.sources(quality).next_keyframe(self.settings.effort);
        let (weights, keyframe) = loop {
            let source = &self.pending[next].samples;
            let keyframe = self.coded(source, quality);
            match self.shown(next, keyframe.shown(source), quality).weights_of_all() {
                Ok(weights) => break (weights, keyframe),
                Err(failed) => next = failed,
            }
        };
        // The keyframe's own frame is already in the chunk; its repeats are not.
        self.open.push_weight(0, self.pending[0].run - 1);
        for (entry, weight) in self.pending[1..next].iter().zip(weights) {
            self.open.push_weight(weight, entry.run);
        }
        self.pending.drain(..next);
        let full = self.open.bytes() >= self.close_at_bytes || self.open.keyframe_count() >= MAX_KEYFRAMES;
        let closed = if full { Some(self.close()?) } else { None };
        self.open_keyframe(keyframe);
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
mod tests;
