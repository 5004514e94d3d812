//! Statistics of a container: settings and results.

use serde::Serialize;

use crate::inspect::chunk_counts::{BlockCount, FrameCost, PredictiveCount, TransformCount};
use codec::decode::{DamagedChunk, StreamInfo};
use codec::depth::mode_statistics::ModeStatistics;
use codec::image::{FrameRange, StreamKind};
use codec::memory::Budget;

pub const MAX_ROWS: u64 = 1_000_000;

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum FrameRows {
    #[default]
    None,
    All,
    Range(FrameRange),
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Check {
    #[default]
    StopAtFirst,
    /// Lists all damaged chunks. Compressed chunks must decompress to the same bytes in two independent decoders, and records of
    /// depth and material must follow the window rule (depth.md 4).
    ListAll,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct InspectSettings {
    pub rows: FrameRows,
    pub check: Check,
    pub memory: Budget,
}

/// Bytes of the chunks of a stream. Bytes that chunks share in the file count for the first stream that has them, so that `bytes`
/// adds up over streams.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct StorageStats {
    pub chunks: u64,
    pub lzma2_chunks: u64,
    pub zstd_chunks: u64,
    /// Bytes in the file; shared bytes count once.
    pub bytes: u64,
    /// Bytes in the file; shared bytes count for every chunk that uses them.
    pub stored_bytes: u64,
    /// Payload bytes before compression; shared chunks count once.
    pub temporal_bytes: u64,
    /// Payload bytes before compression; shared chunks count each time.
    pub payload_bytes: u64,
}

#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Spread {
    pub min: u64,
    pub mean: f64,
    pub max: u64,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StreamStats<'a> {
    pub stream: &'a StreamInfo,
    /// Uncompressed size as in table 1 of CALF (4 bytes per depth, 3 per colour, 3 per material).
    pub raw_bytes: u64,
    pub storage: StorageStats,
    pub units: u64,
    pub keyframes: u64,
    pub keyframes_per_unit: Spread,
    pub aabbs: u64,
    /// Nodes of all frames by level and function; for trees, all nodes of the tree.
    pub nodes: ModeStatistics,
    /// Keyframes and block tiles by storage, for block codecs.
    pub blocks: BlockCount,
    /// Chunks of the transform codec.
    pub transform: TransformCount,
    /// Blocks of predictive coding.
    pub predictive: PredictiveCount,
    /// Number of pixels written, keyframes included, when all frames are decoded in order.
    pub updated_pixels: u64,
    pub static_units: u64,
    /// Number of units with a single value in each frame, such as empty space; colour cells are not counted.
    pub constant_units: u64,
}

impl StreamStats<'_> {
    pub fn pixels(&self) -> u64 {
        let entry = &self.stream.entry;
        self.stream.frames.count() * u64::from(entry.width) * u64::from(entry.height)
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrameRow<'a> {
    pub stream: &'a StreamInfo,
    pub frame: u32,
    pub cost: FrameCost,
}

#[derive(Debug, Clone, PartialEq)]
pub struct Inspection<'a> {
    pub streams: Vec<StreamStats<'a>>,
    pub rows: Vec<FrameRow<'a>>,
    /// Damaged chunks; they are excluded from all counts of pixels, boxes and keyframes.
    pub damaged: Vec<DamagedChunk>,
}

/// Sums over the streams of one kind: a row of table 1 of CALF.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct Totals {
    pub streams: u64,
    pub frames: u64,
    pub raw_bytes: u64,
    pub temporal_bytes: u64,
    pub bytes: u64,
    pub chunks: u64,
    pub lzma2_chunks: u64,
    pub zstd_chunks: u64,
    /// Bytes saved by chunks that share bytes in the file.
    pub shared_bytes_saved: u64,
}

impl Inspection<'_> {
    pub fn totals(&self, kind: Option<StreamKind>) -> Totals {
        let mut totals = Totals::default();
        for stats in self.streams.iter().filter(|stats| kind.is_none_or(|kind| stats.stream.kind == kind)) {
            totals.streams += 1;
            totals.frames += stats.stream.frames.count();
            // A damaged index may claim a huge number of frames.
            totals.raw_bytes = totals.raw_bytes.saturating_add(stats.raw_bytes);
            totals.temporal_bytes += stats.storage.temporal_bytes;
            totals.bytes += stats.storage.bytes;
            totals.chunks += stats.storage.chunks;
            totals.lzma2_chunks += stats.storage.lzma2_chunks;
            totals.zstd_chunks += stats.storage.zstd_chunks;
            totals.shared_bytes_saved += stats.storage.stored_bytes - stats.storage.bytes;
        }
        totals
    }
}
