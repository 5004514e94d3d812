//! Decodes one colour cell by blending the two keyframes around a frame (color.md 3).

use std::time::Instant;

use crate::color::blend::{self, Sample};
use crate::color::cells::{CellChunk, CellFormat, MISSING_NEXT_KEYFRAME};
use crate::container::ChunkEntry;
use crate::decode::chunk_source::ChunkSource;
use crate::error::{Error, Result};

/// Decoded samples of one cell. They are blended again only if a keyframe or the weight changes.
#[derive(Debug)]
pub(super) struct CellState<S> {
    format: CellFormat<S>,
    pub shown: Vec<S>,
    blended: Option<Blended>,
    /// Index and chunk of the current frame.
    pub chunk: Option<(usize, CellChunk<S>)>,
    /// Index and chunk after `chunk`, loaded when its first keyframe is needed.
    next_chunk: Option<(usize, CellChunk<S>)>,
    keyframes: [Keyframe<S>; 2],
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Blended {
    keyframe: KeyframeId,
    /// Weight of the next keyframe, in 255ths.
    weight: u8,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct KeyframeId {
    chunk: usize,
    keyframe: usize,
}

#[derive(Debug, Default)]
struct Keyframe<S> {
    of: Option<KeyframeId>,
    samples: Vec<S>,
}

impl<S: Sample> CellState<S> {
    pub fn new(format: CellFormat<S>) -> Self {
        CellState {
            format,
            shown: Vec::new(),
            blended: None,
            chunk: None,
            next_chunk: None,
            keyframes: Default::default(),
        }
    }

    pub fn forget(&mut self) {
        (self.chunk, self.next_chunk, self.blended) = (None, None, None);
        self.keyframes = Default::default();
    }

    pub fn shows(&self, index: usize, target: u32) -> bool {
        self.chunk.as_ref().filter(|(held, _)| *held == index).is_some_and(|(_, chunk)| {
            let blend = chunk.blend(target);
            let keyframe = KeyframeId { chunk: index, keyframe: blend.keyframe };
            self.blended == Some(Blended { keyframe, weight: blend.weight })
        })
    }

    pub fn show(&mut self, source: &mut ChunkSource<'_>, frame: u32) -> Result<u64> {
        let (index, entry) = source.find(frame)?;
        self.load(source, index, &entry)?;
        let Some((_, chunk)) = &self.chunk else { return Ok(0) };
        let blend = chunk.blend(frame - entry.key.first_frame);
        let keyframe = KeyframeId { chunk: index, keyframe: blend.keyframe };
        let blended = Blended { keyframe, weight: blend.weight };
        if self.blended == Some(blended) {
            return Ok(0);
        }
        let next = if chunk.is_last(blend.keyframe) {
            KeyframeId { chunk: index + 1, keyframe: 0 }
        } else {
            KeyframeId { chunk: index, keyframe: blend.keyframe + 1 }
        };
        let start = Instant::now();
        let fetched_before = source.cost.fetching;
        self.hold(source, 0, keyframe)?;
        let samples = self.format.pixels() * 3;
        self.shown.resize(samples, S::default());
        if blend.weight == 0 {
            self.shown.copy_from_slice(&self.keyframes[0].samples);
        } else {
            self.hold(source, 1, next)?;
            let [a, b] = &self.keyframes;
            blend::lerp_all(&a.samples, &b.samples, blend.weight, &mut self.shown);
        }
        self.blended = Some(blended);
        source.cost.applying += start.elapsed().saturating_sub(source.cost.fetching - fetched_before);
        Ok(self.format.pixels() as u64)
    }

    fn load(&mut self, source: &mut ChunkSource<'_>, index: usize, entry: &ChunkEntry) -> Result<()> {
        if self.chunk.as_ref().is_none_or(|(held, _)| *held != index) {
            if let Some((_, old)) = self.chunk.take() {
                source.buffer = old.into_spare();
            }
            self.chunk = match self.next_chunk.take() {
                Some((held, next)) if held == index => Some((held, next)),
                _ => Some((index, self.parse(source, entry)?)),
            };
        }
        Ok(())
    }

    fn parse(&self, source: &mut ChunkSource<'_>, entry: &ChunkEntry) -> Result<CellChunk<S>> {
        let format = self.format;
        let place = source.reader.index().place(entry);
        source.fetch(entry, |payload| CellChunk::parse_at(payload, format, entry.key.frame_count, place))
    }

    /// Loads a keyframe into a slot, by a swap if the other slot holds it.
    fn hold(&mut self, source: &mut ChunkSource<'_>, slot: usize, of: KeyframeId) -> Result<()> {
        if self.keyframes[slot].of == Some(of) {
            return Ok(());
        }
        if self.keyframes[1 - slot].of == Some(of) {
            self.keyframes.swap(0, 1);
            return Ok(());
        }
        let holds = |chunk: &Option<(usize, CellChunk<S>)>| chunk.as_ref().is_some_and(|(held, _)| *held == of.chunk);
        if !holds(&self.chunk) && !holds(&self.next_chunk) {
            let Some(&entry) = source.chunks.get(of.chunk) else {
                return Err(Error::invalid(MISSING_NEXT_KEYFRAME).in_file(source.reader.path()));
            };
            self.next_chunk = Some((of.chunk, self.parse(source, &entry)?));
        }
        let held = if holds(&self.chunk) { &self.chunk } else { &self.next_chunk };
        let chunk = held.as_ref().map(|(_, chunk)| chunk);
        let target = &mut self.keyframes[slot];
        target.samples.resize(self.format.pixels() * 3, S::default());
        if let Some(chunk) = chunk {
            chunk.read_keyframe(of.keyframe, &mut target.samples);
        }
        target.of = Some(of);
        Ok(())
    }
}
