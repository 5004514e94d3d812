//! Measures a container: what each stream, unit and frame costs and changes, and whether every chunk is sound.
//!
//! Enters: an open container. Leaves: numbers. Chunks are fetched, counted and dropped, units in parallel, so memory
//! stays at one chunk for each thread. Counts are those of a decoder that shows all frames in order.

use serde::Serialize;

use crate::container::{ChunkEntry, Reader, Storage, lzma2, lzma2_independent};
use crate::dataset::stream::StreamKind;
use crate::decode::{DamagedChunk, Decoder, StreamInfo, memory};
use crate::depth::mode_statistics::ModeStatistics;
use crate::error::{Error, Result};
use crate::image::sequence::FrameRange;
use crate::memory::{Budget, Need};
use crate::monitor::Monitor;
use crate::ordered::try_map_at_once;

pub use crate::inspect::counts::{BlockCount, Check, FrameCost};
use crate::inspect::counts::{ChunkMeasure, Event, count_chunk};

/// Rows of frames that one inspection may list.
pub const MAX_ROWS: u64 = 1_000_000;

/// Which frames get a row of their own.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum FrameRows {
    /// None.
    #[default]
    None,
    /// All.
    All,
    /// Those of a range.
    Range(FrameRange),
}

/// What to find out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct InspectSettings {
    /// Rows of frames.
    pub rows: FrameRows,
    /// Damaged chunks.
    pub check: Check,
    /// Memory that chunks may take.
    pub memory: Budget,
}

/// How much the chunks of a stream hold. Chunks that share their place in the file count for the first stream that
/// has them, so that the streams' `bytes` add up.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct StorageStats {
    /// Rows of the chunk table.
    pub chunks: u64,
    /// Those stored as LZMA2.
    pub lzma2_chunks: u64,
    /// Bytes in the file, each counted once.
    pub bytes: u64,
    /// Bytes in the file, counted for every chunk that uses them.
    pub stored_bytes: u64,
    /// Payload before LZMA2, shared chunks counted once.
    pub temporal_bytes: u64,
    /// Payload before LZMA2, counted for every chunk.
    pub payload_bytes: u64,
}

/// Least, mean and most.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Spread {
    /// Least.
    pub min: u64,
    /// Mean.
    pub mean: f64,
    /// Most.
    pub max: u64,
}

/// A stream, measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StreamStats<'a> {
    /// The stream.
    pub stream: &'a StreamInfo,
    /// Its size as CALF's table 1 counts it ([`crate::streams::CodecHeader::raw_pixel_bytes`]).
    pub raw_bytes: u64,
    /// Bytes.
    pub storage: StorageStats,
    /// Tiles or cells.
    pub units: u64,
    /// Keyframes of all units.
    pub keyframes: u64,
    /// Keyframes of each unit.
    pub keyframes_per_unit: Spread,
    /// Boxes of all frames.
    pub aabbs: u64,
    /// Nodes of all frames, by level and function; of a tree all that it holds, whatever it will be flattened to.
    pub nodes: ModeStatistics,
    /// Keyframes and pieces by how they are stored, in codecs of blocks.
    pub blocks: BlockCount,
    /// Pixels written, keyframes included, when all frames are shown in order.
    pub updated_pixels: u64,
    /// Units whose picture never changes; keyframes that repeat it do not count as change.
    pub static_units: u64,
    /// Units that have one value in each frame, such as empty space; colour cells are not looked at.
    pub constant_units: u64,
}

impl StreamStats<'_> {
    /// Pixels of all frames.
    pub fn pixels(&self) -> u64 {
        let entry = &self.stream.entry;
        self.stream.frames.count() * u64::from(entry.width) * u64::from(entry.height)
    }
}

/// A frame of a stream, measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrameRow<'a> {
    /// The stream.
    pub stream: &'a StreamInfo,
    /// The frame.
    pub frame: u32,
    /// What it holds and changes.
    pub cost: FrameCost,
}

/// A container, measured.
#[derive(Debug, Clone, PartialEq)]
pub struct Inspection<'a> {
    /// The streams asked for.
    pub streams: Vec<StreamStats<'a>>,
    /// The frames asked for, by stream and frame.
    pub rows: Vec<FrameRow<'a>>,
    /// Damaged chunks of the streams asked for; what they hold is in no count of pixels, boxes or keyframes.
    pub damaged: Vec<DamagedChunk>,
    /// Bytes between head and index that no chunk of any stream refers to.
    pub unreferenced_bytes: u64,
}

/// Sums of the streams of one kind: a row of CALF's table 1.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct Totals {
    /// Streams.
    pub streams: u64,
    /// Images.
    pub frames: u64,
    /// Raw size.
    pub raw_bytes: u64,
    /// After the coding in time.
    pub temporal_bytes: u64,
    /// In the file.
    pub bytes: u64,
    /// Chunks.
    pub chunks: u64,
    /// Those stored as LZMA2.
    pub lzma2_chunks: u64,
    /// Bytes that would be stored on top, were no chunk shared.
    pub shared_bytes_saved: u64,
}

impl Inspection<'_> {
    /// Sums of the streams of a kind, or of all.
    pub fn totals(&self, kind: Option<StreamKind>) -> Totals {
        let mut totals = Totals::default();
        for stats in self.streams.iter().filter(|stats| kind.is_none_or(|kind| stats.stream.kind == kind)) {
            totals.streams += 1;
            totals.frames += stats.stream.frames.count();
            // A damaged index may claim frames without end.
            totals.raw_bytes = totals.raw_bytes.saturating_add(stats.raw_bytes);
            totals.temporal_bytes += stats.storage.temporal_bytes;
            totals.bytes += stats.storage.bytes;
            totals.chunks += stats.storage.chunks;
            totals.lzma2_chunks += stats.storage.lzma2_chunks;
            totals.shared_bytes_saved += stats.storage.stored_bytes - stats.storage.bytes;
        }
        totals
    }
}

/// Number of steps that [`inspect`] advances its monitor by: one for each chunk.
pub fn steps(decoder: &Decoder, streams: &[&StreamInfo]) -> u64 {
    streams.iter().map(|stream| decoder.reader().index().stream_chunks(stream.index).len() as u64).sum()
}

/// Measures some streams of a container.
pub fn inspect<'a>(
    decoder: &'a Decoder,
    streams: &[&'a StreamInfo],
    settings: InspectSettings,
    monitor: &dyn Monitor,
) -> Result<Inspection<'a>> {
    let listed = |stream: &StreamInfo| match settings.rows {
        FrameRows::None => None,
        FrameRows::All => Some(stream.frames),
        FrameRows::Range(range) => stream.frames.intersect(range),
    };
    let row_count: u64 = streams.iter().filter_map(|stream| listed(stream)).map(FrameRange::count).sum();
    if let FrameRows::Range(range) = settings.rows
        && row_count == 0
    {
        return Err(Error::Usage(format!("no stream has frames {range}")));
    }
    if row_count > MAX_ROWS {
        return Err(Error::Usage(format!(
            "{row_count} rows of frames, more than {MAX_ROWS}: choose fewer frames or streams"
        )));
    }
    // Where fewer chunks fit than there are threads, streams are taken one by one.
    let threads = rayon::current_num_threads();
    let at_once = chunks_at_once(decoder, streams, settings.memory, threads)?;
    let streams_at_once = if at_once < threads { 1 } else { usize::MAX };
    let (storage, unreferenced_bytes) = storage_of(decoder.reader());
    let measured = try_map_at_once(streams.to_vec(), streams_at_once, |stream| {
        let watch = Watch { reader: decoder.reader(), stream, settings, monitor };
        let units = try_map_at_once((0..stream.entry.unit_count()).collect(), at_once, |unit| watch.unit(unit))?;
        Ok(StreamMeasure::new(stream, listed(stream), storage[stream.index as usize], units))
    })?;
    let mut inspection = Inspection { streams: vec![], rows: vec![], damaged: vec![], unreferenced_bytes };
    for StreamMeasure { stats, rows, damaged } in measured {
        inspection.streams.push(stats);
        inspection.rows.extend(rows);
        inspection.damaged.extend(damaged);
    }
    Ok(inspection)
}

/// How many chunks may be counted at once.
fn chunks_at_once(decoder: &Decoder, streams: &[&StreamInfo], memory: Budget, threads: usize) -> Result<usize> {
    if memory.bytes().is_none() {
        return Ok(usize::MAX);
    }
    let of_stream = |stream: &&StreamInfo| {
        let chunks = decoder.reader().index().stream_chunks(stream.index);
        chunks.iter().map(|chunk| memory::chunk_bytes(&stream.header, chunk)).max()
    };
    let each = streams.iter().filter_map(of_stream).max().unwrap_or(0);
    let fixed = memory::container_bytes(decoder.reader());
    memory.at_once(&Need { what: "inspecting", fixed, each, instead: "" }, threads)
}

/// Bytes of all streams, and bytes that belong to none.
fn storage_of(reader: &Reader) -> (Vec<StorageStats>, u64) {
    let index = reader.index();
    let mut storage = vec![StorageStats::default(); index.streams.len()];
    let mut order: Vec<u32> = (0..index.chunks.len() as u32).collect();
    order.sort_by_key(|&at| {
        let chunk = &index.chunks[at as usize];
        (chunk.offset, chunk.stored_bytes, at)
    });
    let area = reader.payload_area();
    let (mut covered, mut unreferenced, mut last) = (area.start, 0, None);
    for at in order {
        let chunk = &index.chunks[at as usize];
        let end = chunk.offset + u64::from(chunk.stored_bytes);
        unreferenced += chunk.offset.saturating_sub(covered);
        let stats = &mut storage[chunk.key.stream as usize];
        stats.chunks += 1;
        stats.lzma2_chunks += u64::from(chunk.storage == Storage::Lzma2);
        stats.stored_bytes += u64::from(chunk.stored_bytes);
        stats.payload_bytes += u64::from(chunk.raw_bytes);
        stats.bytes += end.saturating_sub(covered.max(chunk.offset));
        let place = (chunk.offset, chunk.stored_bytes);
        if last != Some(place) {
            stats.temporal_bytes += u64::from(chunk.raw_bytes);
        }
        last = Some(place);
        covered = covered.max(end);
    }
    (storage, unreferenced + area.end.saturating_sub(covered))
}

#[derive(Debug)]
struct UnitMeasure {
    /// Sums of all frames.
    total: FrameCost,
    census: ModeStatistics,
    blocks: BlockCount,
    /// Every chunk writes one picture, and all chunks hold the same bytes.
    is_static: bool,
    constant: bool,
    /// Kept only where frames are listed.
    events: Vec<Event>,
    damaged: Vec<DamagedChunk>,
}

struct Watch<'a> {
    reader: &'a Reader,
    stream: &'a StreamInfo,
    settings: InspectSettings,
    monitor: &'a dyn Monitor,
}

impl Watch<'_> {
    fn unit(&self, unit: u32) -> Result<UnitMeasure> {
        let [_, _, width, height] = self.stream.entry.unit_rect(unit);
        let chunks = self.reader.index().unit_chunks(self.stream.index, unit);
        let mut measure = UnitMeasure {
            total: FrameCost::default(),
            census: ModeStatistics::default(),
            blocks: BlockCount::default(),
            is_static: true,
            constant: true,
            events: vec![],
            damaged: vec![],
        };
        let identity = |chunk: &ChunkEntry| (chunk.crc32, chunk.stored_bytes, chunk.raw_bytes);
        measure.is_static = chunks.iter().all(|chunk| identity(chunk) == identity(&chunks[0]));
        for chunk in chunks {
            self.monitor.check()?;
            let counted = self.chunk(chunk, [width, height]);
            self.monitor.advance(1);
            match (counted, self.settings.check) {
                (Ok(counted), _) => measure.add(counted, self.settings.rows),
                (Err(error), Check::StopAtFirst) => return Err(self.reader.blame(chunk, error)),
                (Err(error), Check::ListAll) => {
                    measure.damaged.push(DamagedChunk::new(chunk, &error));
                }
            }
        }
        Ok(measure)
    }

    fn chunk(&self, chunk: &ChunkEntry, size: [u32; 2]) -> Result<ChunkMeasure> {
        let stored = self.reader.load_stored(chunk)?;
        let payload = match chunk.storage {
            Storage::Raw => stored,
            Storage::Lzma2 => {
                let payload = lzma2::decompress(&stored, chunk.raw_bytes)?;
                if self.settings.check == Check::ListAll
                    && lzma2_independent::decompress_independent(&stored, chunk.raw_bytes)? != payload
                {
                    return Err(Error::invalid("two LZMA2 decoders do not agree on the chunk"));
                }
                payload
            }
        };
        let place = self.reader.index().place(chunk);
        let mut counted =
            count_chunk(&self.stream.header, payload, size, chunk.key.frame_count, place, self.settings.check)?;
        // What belongs to the whole chunk is read with its first frame.
        let counted_bytes: u64 = counted.events.iter().map(|event| event.cost.bytes).sum();
        if let Some(first) = counted.events.first_mut() {
            first.cost.bytes += u64::from(chunk.raw_bytes).saturating_sub(counted_bytes);
        }
        counted.events.iter_mut().for_each(|event| event.frame += chunk.key.first_frame);
        Ok(counted)
    }
}

impl UnitMeasure {
    fn add(&mut self, chunk: ChunkMeasure, rows: FrameRows) {
        for event in &chunk.events {
            self.total.add(event.cost);
        }
        self.census.add(&chunk.census);
        self.blocks.add(chunk.blocks);
        self.is_static &= chunk.events.iter().filter(|event| event.cost.updated_pixels > 0).count() == 1;
        self.constant &= chunk.constant;
        if rows != FrameRows::None {
            self.events.extend(chunk.events);
        }
    }
}

struct StreamMeasure<'a> {
    stats: StreamStats<'a>,
    rows: Vec<FrameRow<'a>>,
    damaged: Vec<DamagedChunk>,
}

impl<'a> StreamMeasure<'a> {
    fn new(
        stream: &'a StreamInfo,
        listed: Option<FrameRange>,
        storage: StorageStats,
        units: Vec<UnitMeasure>,
    ) -> StreamMeasure<'a> {
        let blank = |frame| FrameRow { stream, frame, cost: FrameCost::default() };
        let mut rows: Vec<_> = listed.map(|frames| frames.iter().map(blank).collect()).unwrap_or_default();
        let (mut total, mut census) = (FrameCost::default(), ModeStatistics::default());
        let mut blocks = BlockCount::default();
        let (mut static_units, mut constant_units) = (0, 0);
        let keyframes = || units.iter().map(|unit| unit.total.keyframe_units);
        let spread = (keyframes().min().unwrap_or(0), keyframes().max().unwrap_or(0));
        let mut damaged = Vec::new();
        let unit_count = units.len() as u64;
        for unit in units {
            total.add(unit.total);
            census.add(&unit.census);
            blocks.add(unit.blocks);
            let sound = unit.damaged.is_empty();
            static_units += u64::from(sound && unit.is_static);
            constant_units += u64::from(sound && unit.constant);
            damaged.extend(unit.damaged);
            if let Some(frames) = listed {
                for event in unit.events.iter().filter(|event| frames.contains(event.frame)) {
                    rows[(event.frame - frames.first) as usize].cost.add(event.cost);
                }
            }
        }
        let mut stats = StreamStats {
            stream,
            raw_bytes: 0,
            storage,
            units: unit_count,
            keyframes: total.keyframe_units,
            keyframes_per_unit: Spread {
                min: spread.0,
                mean: total.keyframe_units as f64 / unit_count.max(1) as f64,
                max: spread.1,
            },
            aabbs: total.aabbs,
            nodes: census,
            blocks,
            updated_pixels: total.updated_pixels,
            static_units,
            constant_units,
        };
        stats.raw_bytes = stats.pixels() * stream.header.raw_pixel_bytes();
        StreamMeasure { stats, rows, damaged }
    }
}
