//! Measures a container: bytes, keyframes, nodes and changed pixels of each stream and frame, and the integrity of chunks.
//!
//! Chunks are fetched, counted and dropped, units in parallel, so that memory is one chunk per thread. Counts are those of a
//! decoder that decodes all frames in order.

use std::sync::{Mutex, PoisonError};

use crate::inspect::chunk_counts::{
    BlockCount, ChunkMeasure, Event, FrameCost, PredictiveCount, TransformCount, count_chunk,
};
use crate::inspect::statistics::{
    Check, FrameRow, FrameRows, InspectSettings, Inspection, MAX_ROWS, Spread, StorageStats, StreamStats,
};
use codec::container::{ChunkEntry, Index, Reader, Storage, lzma2, zstd};
use codec::decode::{DamagedChunk, Decoder, StreamInfo, memory};
use codec::depth::mode_statistics::ModeStatistics;
use codec::depth::predictive::tile::MAX_FRAMES;
use codec::error::{Error, Result};
use codec::image::FrameRange;
use codec::memory::Need;
use codec::monitor::{Monitor, Silent};
use codec::ordered::try_map_at_once;
use codec::streams::{CodecHeader, DepthCoding, DepthHeader, StreamChunk};

/// Returns the number of steps by which [`inspect`] advances its monitor: one per chunk.
pub fn steps(decoder: &Decoder, streams: &[&StreamInfo]) -> u64 {
    streams.iter().map(|stream| decoder.reader().index().stream_chunks(stream.index).len() as u64).sum()
}

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
            "{row_count} rows, at most {MAX_ROWS} are possible: select fewer frames or streams"
        )));
    }
    // If fewer chunks fit in memory than there are threads, streams are measured one by one.
    let threads = rayon::current_num_threads();
    let at_once = chunks_at_once(decoder, streams, settings, row_count, threads)?;
    let streams_at_once = if at_once < threads { 1 } else { usize::MAX };
    let storage = storage_of(decoder.reader().index());
    let measured = try_map_at_once(streams.to_vec(), streams_at_once, |stream| {
        let rows = Rows::new(stream, listed(stream));
        let measure = Measure { reader: decoder.reader(), stream, check: settings.check, rows, monitor };
        let units = try_map_at_once((0..stream.entry.unit_count()).collect(), at_once, |unit| measure.unit(unit))?;
        Ok(Inspection::of_stream(stream, measure.rows, storage[stream.index as usize], units))
    })?;
    let mut inspection = Inspection { streams: vec![], rows: vec![], damaged: vec![] };
    for Inspection { streams, rows, damaged, .. } in measured {
        inspection.streams.extend(streams);
        inspection.rows.extend(rows);
        inspection.damaged.extend(damaged);
    }
    Ok(inspection)
}

/// Measures all streams of a container with the default settings.
///
/// # Errors
/// [`Error::Invalid`] names the first damaged chunk.
pub fn statistics(decoder: &Decoder) -> Result<Inspection<'_>> {
    let streams: Vec<&StreamInfo> = decoder.streams().iter().collect();
    inspect(decoder, &streams, InspectSettings::default(), &Silent)
}

fn chunks_at_once(
    decoder: &Decoder,
    streams: &[&StreamInfo],
    settings: InspectSettings,
    row_count: u64,
    threads: usize,
) -> Result<usize> {
    if settings.memory.bytes.is_none() {
        return Ok(usize::MAX);
    }
    let of_stream = |stream: &&StreamInfo| {
        let chunks = decoder.reader().index().stream_chunks(stream.index);
        chunks.iter().map(|chunk| measuring_bytes(stream, chunk, settings.check)).max()
    };
    let each = streams.iter().filter_map(of_stream).max().unwrap_or(0);
    // Rows are in memory twice while those of all streams are joined.
    let rows = 2 * row_count * size_of::<FrameRow<'_>>() as u64;
    let fixed = memory::container_bytes(decoder.reader()) + rows;
    settings.memory.at_once(&Need { what: "inspecting", fixed, each, instead: "" }, threads)
}

/// Bytes of an event of a chunk and of its frame number, three times because their vectors double while growing.
const EVENT_BYTES: u64 = 3 * (size_of::<Event>() + size_of::<u32>()) as u64;
/// Returns the bytes of memory for decompressing, parsing, counting and checking a chunk.
fn measuring_bytes(stream: &StreamInfo, chunk: &ChunkEntry, check: Check) -> u64 {
    let (header, raw_bytes) = (&stream.header, u64::from(chunk.raw_bytes));
    let checks = check == Check::ListAll;
    // The payload (1); with checks also the output of the second decoder (1) and its window while it grows (4).
    let payloads = if checks && chunk.storage != Storage::Raw { 6 } else { 1 };
    let pixel_bytes = match header {
        // These codecs are decoded for the counts.
        CodecHeader::Depth(DepthHeader { coding: DepthCoding::Predictive(_), .. }) | CodecHeader::Alpha(_) => {
            header.held_pixel_bytes()
        }
        CodecHeader::Depth(DepthHeader { coding: DepthCoding::Tree(_) | DepthCoding::Blocks, .. })
        | CodecHeader::Color(_) => 0,
        _ if !checks => 0,
        // Two pictures, a mask of pixels that a record covers, and the frame of the last change of each pixel.
        CodecHeader::Depth(_) => 2 * 2 + 1 + 4,
        CodecHeader::Material(_) => 2 * 3 + 1 + 4,
    };
    let [_, _, width, height] = stream.entry.unit_rect(chunk.key.unit);
    // Only frames of predictive and transform chunks can take less than a byte.
    let events = u64::from(chunk.key.frame_count).min(raw_bytes.max(MAX_FRAMES.into())) * EVENT_BYTES;
    let parsed = header.parsed_chunk_bytes(&stream.entry, chunk)
        + header.parsing_bytes(&stream.entry, chunk)
        + events
        + u64::from(width) * u64::from(height) * pixel_bytes;
    parsed.max(memory::reading_bytes(chunk) + payloads * raw_bytes)
}

fn storage_of(index: &Index) -> Vec<StorageStats> {
    let mut storage = vec![StorageStats::default(); index.streams.len()];
    let mut order: Vec<u32> = (0..index.chunks.len() as u32).collect();
    order.sort_by_key(|&at| {
        let chunk = &index.chunks[at as usize];
        (chunk.offset, chunk.stored_bytes, at)
    });
    let mut last = None;
    for at in order {
        let chunk = &index.chunks[at as usize];
        let stats = &mut storage[chunk.key.stream as usize];
        stats.chunks += 1;
        stats.lzma2_chunks += u64::from(chunk.storage == Storage::Lzma2);
        stats.zstd_chunks += u64::from(chunk.storage == Storage::Zstd);
        stats.stored_bytes += u64::from(chunk.stored_bytes);
        stats.payload_bytes += u64::from(chunk.raw_bytes);
        let place = (chunk.offset, chunk.stored_bytes);
        if last != Some(place) {
            stats.bytes += u64::from(chunk.stored_bytes);
            stats.temporal_bytes += u64::from(chunk.raw_bytes);
        }
        last = Some(place);
    }
    storage
}

#[derive(Default)]
struct UnitMeasure {
    total: FrameCost,
    modes: ModeStatistics,
    blocks: BlockCount,
    transform: TransformCount,
    predictive: PredictiveCount,
    /// True if every chunk writes one picture and all chunks hold the same bytes.
    is_static: bool,
    constant: bool,
    damaged: Vec<DamagedChunk>,
}

/// Costs of the listed frames of a stream; units add their costs in any order.
struct Rows<'a> {
    frames: Option<FrameRange>,
    rows: Mutex<Vec<FrameRow<'a>>>,
}

impl<'a> Rows<'a> {
    fn new(stream: &'a StreamInfo, frames: Option<FrameRange>) -> Rows<'a> {
        let blank = |frame| FrameRow { stream, frame, cost: FrameCost::default() };
        let rows = frames.map(|frames| frames.iter().map(blank).collect()).unwrap_or_default();
        Rows { frames, rows: Mutex::new(rows) }
    }

    fn add(&self, events: &[Event]) {
        let Some(frames) = self.frames else { return };
        let mut rows = self.rows.lock().unwrap_or_else(PoisonError::into_inner);
        for event in events.iter().filter(|event| frames.contains(event.frame)) {
            rows[(event.frame - frames.first) as usize].cost.add(event.cost);
        }
    }
}

struct Measure<'r, 'a> {
    reader: &'r Reader,
    stream: &'a StreamInfo,
    check: Check,
    rows: Rows<'a>,
    monitor: &'r dyn Monitor,
}

impl Measure<'_, '_> {
    fn unit(&self, unit: u32) -> Result<UnitMeasure> {
        let [_, _, width, height] = self.stream.entry.unit_rect(unit);
        let chunks = self.reader.index().unit_chunks(self.stream.index, unit);
        let identity = |chunk: &ChunkEntry| (chunk.crc32, chunk.stored_bytes, chunk.raw_bytes);
        let is_static = chunks.iter().all(|chunk| identity(chunk) == identity(&chunks[0]));
        let mut measure = UnitMeasure { is_static, constant: true, ..UnitMeasure::default() };
        for chunk in chunks {
            self.monitor.check()?;
            let counted = self.chunk(chunk, u64::from(width) * u64::from(height));
            self.monitor.advance(1);
            match (counted, self.check) {
                (Ok(counted), _) => {
                    self.rows.add(&counted.events);
                    measure.add(&counted);
                }
                (Err(error), Check::StopAtFirst) => return Err(self.reader.blame(chunk, error)),
                (Err(error), Check::ListAll) => measure.damaged.push(DamagedChunk::new(chunk, &error)),
            }
        }
        Ok(measure)
    }

    /// Returns the payload of a chunk. With [`Check::ListAll`], fails if two independent decoders of the compression disagree.
    fn payload(&self, chunk: &ChunkEntry) -> Result<Vec<u8>> {
        let stored = self.reader.load_stored(chunk)?;
        let raw_bytes = chunk.raw_bytes;
        let both = self.check == Check::ListAll;
        Ok(match chunk.storage {
            Storage::Raw => stored,
            Storage::Lzma2 => {
                let payload = lzma2::decompress(&stored, raw_bytes)?;
                if both && lzma2::decompress_independent(&stored, raw_bytes)? != payload {
                    return Err(Error::invalid("two LZMA2 decoders do not agree on the chunk"));
                }
                payload
            }
            Storage::Zstd => {
                let payload = zstd::decompress(&stored, raw_bytes)?;
                if both && zstd::decompress_independent(&stored, raw_bytes)? != payload {
                    return Err(Error::invalid("two Zstandard decoders do not agree on the chunk"));
                }
                payload
            }
        })
    }

    fn chunk(&self, chunk: &ChunkEntry, pixels: u64) -> Result<ChunkMeasure> {
        let frames = chunk.key.frame_count;
        let parsed = StreamChunk::parse(self.stream, self.reader.index(), chunk, self.payload(chunk)?.into())?;
        if self.check == Check::ListAll {
            parsed.check_window(self.stream, frames)?;
        }
        let mut counted = count_chunk(&parsed, pixels, frames)?;
        // Bytes that belong to the whole chunk count for its first frame, with which they are read.
        let counted_bytes: u64 = counted.events.iter().map(|event| event.cost.bytes).sum();
        if let Some(first) = counted.events.first_mut() {
            first.cost.bytes += u64::from(chunk.raw_bytes).saturating_sub(counted_bytes);
        }
        counted.events.iter_mut().for_each(|event| event.frame += chunk.key.first_frame);
        Ok(counted)
    }
}

impl UnitMeasure {
    fn add(&mut self, chunk: &ChunkMeasure) {
        for event in &chunk.events {
            self.total.add(event.cost);
        }
        self.modes.add(&chunk.modes);
        self.blocks.add(chunk.blocks);
        self.transform.add(chunk.transform);
        self.predictive.add(&chunk.predictive);
        self.is_static &= chunk.events.iter().filter(|event| event.cost.updated_pixels > 0).count() == 1;
        self.constant &= chunk.constant;
    }
}

impl<'a> Inspection<'a> {
    /// Returns the inspection of a single stream.
    fn of_stream(
        stream: &'a StreamInfo,
        rows: Rows<'a>,
        storage: StorageStats,
        units: Vec<UnitMeasure>,
    ) -> Inspection<'a> {
        let mut damaged = Vec::new();
        let (mut total, mut modes, mut blocks) =
            (FrameCost::default(), ModeStatistics::default(), BlockCount::default());
        let (mut transform, mut predictive) = (TransformCount::default(), PredictiveCount::default());
        let keyframes = || units.iter().map(|unit| unit.total.keyframe_units);
        let (min, max) = (keyframes().min().unwrap_or(0), keyframes().max().unwrap_or(0));
        let count = |is_such: fn(&UnitMeasure) -> bool| {
            units.iter().filter(|unit| unit.damaged.is_empty() && is_such(unit)).count() as u64
        };
        let (static_units, constant_units) = (count(|unit| unit.is_static), count(|unit| unit.constant));
        let unit_count = units.len() as u64;
        for unit in units {
            total.add(unit.total);
            modes.add(&unit.modes);
            blocks.add(unit.blocks);
            transform.add(unit.transform);
            predictive.add(&unit.predictive);
            damaged.extend(unit.damaged);
        }
        let mean = total.keyframe_units as f64 / unit_count.max(1) as f64;
        let mut stats = StreamStats {
            stream,
            raw_bytes: 0,
            storage,
            units: unit_count,
            keyframes: total.keyframe_units,
            keyframes_per_unit: Spread { min, mean, max },
            aabbs: total.aabbs,
            nodes: modes,
            blocks,
            transform,
            predictive,
            updated_pixels: total.updated_pixels,
            static_units,
            constant_units,
        };
        stats.raw_bytes = stats.pixels() * stream.header.raw_pixel_bytes();
        let rows = rows.rows.into_inner().unwrap_or_else(PoisonError::into_inner);
        Inspection { streams: vec![stats], rows, damaged }
    }
}
