//! Encodes the frames of one unit into independent chunks.

use std::sync::Arc;

use crate::container::EncodedChunk;
use crate::depth::mode_decision::Decide;
use crate::depth::open_chunk::close_at_bytes;
use crate::depth::predictive::price::{PricedTables, Recorder, priced};
use crate::depth::predictive::projection::UnitArea;
use crate::depth::predictive::search::{FrameSearch, SearchSettings};
use crate::depth::predictive::tile::{MAX_FRAMES, PredictiveHeader, Tile};
use crate::effort::Effort;
use crate::error::Result;

/// Maximum bytes of the recorded symbols of a frame per pixel: its own symbol, a class, raw bits, and a part of those of its
/// block.
pub const FRAME_BYTES_A_PIXEL: usize = 11;

#[derive(Debug)]
pub struct PredictiveEncoder {
    settings: SearchSettings,
    keyframe_interval: u32,
    tables: Arc<PricedTables>,
    /// Table set whose prices are used to choose modes: `first_set` for the first frame, then the cheapest set so far.
    set: usize,
    /// Table set with which most streams with this header are coded.
    first_set: usize,
    tile: Tile,
    recorder: Recorder,
    first_frame: u32,
    next_frame: u32,
}

impl PredictiveEncoder {
    pub fn new(header: &PredictiveHeader, area: UnitArea, decide: Decide, effort: Effort) -> Result<PredictiveEncoder> {
        let error_weight = match decide {
            Decide::Size => 0.0,
            // Measured on sponza at E = 100: weight 2 takes 1% more bytes than weight 1; weight 4 takes 3% more, with an RMS
            // error of 35 instead of 37 codes.
            Decide::Mse => 2.0,
        };
        let (bound, epsilon) = (header.bound, header.epsilon);
        Ok(PredictiveEncoder {
            settings: SearchSettings { bound, epsilon, error_weight, effort },
            keyframe_interval: header.keyframe_interval.min(MAX_FRAMES),
            tables: priced(&header.tables),
            set: usual_set(header),
            first_set: usual_set(header),
            tile: Tile::new(header, area)?,
            recorder: Recorder::default(),
            first_frame: 0,
            next_frame: 0,
        })
    }

    /// Encodes a frame of the unit, row by row: codes, or [level numbers](crate::depth::predictive::Levels::numbers) if the
    /// header has levels. Returns the previous chunk if this frame starts a new one.
    pub fn push(&mut self, source: &[u16]) -> Option<EncodedChunk> {
        let frames = self.next_frame - self.first_frame;
        let is_full = frames >= self.keyframe_interval || self.recorder.held_bytes() >= close_at_bytes(source.len());
        let finished = if is_full { self.finish() } else { None };
        self.next_frame += 1;
        let Self { tile, tables, set, recorder: sink, settings, .. } = self;
        FrameSearch { tile, source, prices: &tables.prices[*set], settings: *settings, sink }.run();
        self.set = self.tables.cheapest(&self.recorder.counts).0;
        finished
    }

    pub fn finish(&mut self) -> Option<EncodedChunk> {
        let (first_frame, frame_count) = (self.first_frame, self.next_frame - self.first_frame);
        self.first_frame = self.next_frame;
        self.tile.clear();
        let payload = std::mem::take(&mut self.recorder).finish(&self.tables);
        self.set = self.first_set;
        (frame_count > 0).then_some(EncodedChunk { first_frame, frame_count, payload })
    }
}

/// Returns the built-in table set with which most footage with such a header is coded.
fn usual_set(header: &PredictiveHeader) -> usize {
    match header.bound {
        _ if !header.levels.is_empty() => 8,
        0..=2 => 0,
        3..=31 => 2,
        32..=316 => 4,
        _ => 6,
    }
}
