//! Decodes units of many streams and discards the pixels, for timing and for checks.

use std::collections::BTreeMap;

use crate::container::ChunkEntry;
use crate::decode::chunk_source::DecodeCost;
use crate::decode::damage::{DamagedChunk, FrameRanges, MissingImages, OnDamage};
use crate::decode::decoder::Decoder;
use crate::decode::memory;
use crate::decode::selection::{Request, StreamFrames};
use crate::error::Result;
use crate::image::sequence::FrameRange;
use crate::math::add_members;
use crate::memory::{Budget, Need};
use crate::monitor::Monitor;
use crate::ordered::{try_map_at_once_with, try_map_ordered};
use crate::streams::{CodecHeader, StreamChunk, StreamInfo};

#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct DecodeSummary {
    pub frames: u64,
    /// Number of pixels of the selected units of these images.
    pub pixels: u64,
    /// Bytes of the pixels written, in the codec's domain; for file output, bytes of the files.
    pub bytes_out: u64,
    pub cost: DecodeCost,
}

add_members!(DecodeSummary: frames, pixels, bytes_out, cost);

pub fn decoded_pixel_bytes(header: &CodecHeader) -> u64 {
    match header {
        CodecHeader::Depth(_) => 2,
        CodecHeader::Color(header) if header.is_half() => 6,
        CodecHeader::Color(_) | CodecHeader::Material(_) => 3,
        CodecHeader::Alpha(_) => 1,
    }
}

/// Returns the stored bytes of all chunks that contain these frames. Decoding all units reads these bytes, and chunks after the
/// last frame that hold the second keyframe of a cell.
pub fn stored_bytes(decoder: &Decoder, streams: &[StreamFrames<'_>]) -> u64 {
    let of_stream = |StreamFrames { stream, frames }: &StreamFrames<'_>| {
        let chunks = (0..stream.entry.unit_count())
            .flat_map(|unit| decoder.reader().index().unit_chunks(stream.index, unit))
            .filter(|chunk| chunk.key.first_frame <= frames.last && frames.first <= chunk.key.last_frame());
        chunks.map(|chunk| u64::from(chunk.stored_bytes)).sum::<u64>()
    };
    streams.iter().map(of_stream).sum()
}

#[derive(Debug, Clone, Default, PartialEq)]
pub struct Decoded {
    pub summary: DecodeSummary,
    /// Damaged chunks in the order of stream, unit and frame.
    pub damaged: Vec<DamagedChunk>,
    pub missing: Vec<MissingImages>,
    /// Number of half-float pixels clipped in 8-bit files.
    pub clipped_pixels: u64,
    /// Reason why a folder of images has no manifest.
    pub no_manifest: Option<&'static str>,
}

pub struct DecodedPart {
    pub stream: u32,
    pub summary: DecodeSummary,
    pub damaged: Vec<DamagedChunk>,
    pub missing: FrameRanges,
}

impl Decoded {
    pub fn of(parts: Vec<DecodedPart>) -> Decoded {
        let mut decoded = Decoded::default();
        let mut frames: BTreeMap<u32, FrameRanges> = BTreeMap::new();
        for part in parts {
            decoded.summary = decoded.summary + part.summary;
            decoded.damaged.extend(part.damaged);
            frames.entry(part.stream).or_default().join(part.missing);
        }
        decoded.damaged.sort_by_key(|damaged| damaged.chunk.key);
        let missing = frames.into_iter().filter_map(|(stream, frames)| MissingImages::new(stream, frames));
        decoded.missing = missing.collect();
        decoded
    }

    pub fn missing_images(&self) -> u64 {
        self.missing.iter().map(MissingImages::count).sum()
    }
}

/// Returns the bytes of memory needed to decode the units one at a time, including the open container.
pub fn min_bytes(decoder: &Decoder, streams: &[StreamFrames<'_>]) -> u64 {
    let units = |stream: &StreamInfo| {
        (0..stream.entry.unit_count()).map(|unit| memory::unit_bytes(decoder, stream, unit)).max().unwrap_or(0)
    };
    let largest = streams.iter().map(|StreamFrames { stream, .. }| units(stream)).max().unwrap_or(0);
    memory::container_bytes(decoder.reader()) + largest
}

/// Decodes the selected units frame by frame. The monitor advances by one per image.
pub fn decode_units(
    decoder: &Decoder,
    Request { streams, filter, memory }: Request<'_>,
    on_damage: OnDamage,
    monitor: &dyn Monitor,
) -> Result<Decoded> {
    struct Job<'a> {
        stream: &'a StreamInfo,
        frames: FrameRange,
        unit: u32,
    }
    let units =
        |&StreamFrames { stream, frames }| (0..stream.entry.unit_count()).map(move |unit| Job { stream, frames, unit });
    let jobs: Vec<Job<'_>> = streams.iter().flat_map(units).collect();
    let each = |job: &Job<'_>| memory::unit_bytes(decoder, job.stream, job.unit);
    let at_once = jobs_at_once(decoder, memory, || jobs.iter().map(each).max())?;
    let parts = try_map_at_once_with(jobs, at_once, Vec::new, |buffer, Job { stream, frames, unit }| {
        let mut decoder = decoder.unit_with_buffer(stream, unit, std::mem::take(buffer));
        let (mut decoded, mut missing) = (0, FrameRanges::default());
        for frame in frames.iter() {
            monitor.check()?;
            if !filter.wants(stream, unit, frame) {
                continue;
            }
            match decoder.decode(frame) {
                Ok(_) => decoded += 1,
                Err(_) if on_damage == OnDamage::KeepGoing && decoder.damaged().len() > 0 => missing.push(frame),
                Err(error) => return Err(error),
            }
        }
        // Each image is counted once, with its first unit.
        let images = if unit == 0 { frames.count() } else { 0 };
        monitor.advance(images);
        let cost = decoder.cost();
        let summary = DecodeSummary {
            frames: images,
            pixels: decoded * decoder.pixel_count(),
            bytes_out: cost.updated_pixels * decoded_pixel_bytes(&stream.header),
            cost,
        };
        let damaged = decoder.damaged().cloned().collect();
        *buffer = decoder.into_buffer();
        Ok(DecodedPart { stream: stream.index, summary, damaged, missing })
    })?;
    let mut decoded = Decoded::of(parts);
    decoded.summary.frames -= decoded.missing_images();
    Ok(decoded)
}

pub fn jobs_at_once(decoder: &Decoder, memory: Budget, largest: impl FnOnce() -> Option<u64>) -> Result<usize> {
    if memory.bytes.is_none() {
        return Ok(usize::MAX);
    }
    let fixed = memory::container_bytes(decoder.reader());
    let each = largest().unwrap_or(0);
    memory.at_once(&Need { what: "decoding", fixed, each, instead: "" }, rayon::current_num_threads())
}

/// Checks the window rule (depth.md 4) in all chunks of depth and material that hold requested frames.
pub fn check_windows(decoder: &Decoder, request: &Request<'_>) -> Result<()> {
    let jobs: Vec<_> = request.streams.iter().flat_map(|part| chunks_of(decoder, part)).collect();
    try_map_ordered(jobs, |(stream, chunk)| {
        let reader = decoder.reader();
        let parsed = StreamChunk::parse(stream, reader.index(), &chunk, reader.fetch(&chunk)?);
        let checked = parsed.and_then(|parsed| parsed.check_window(stream, chunk.key.frame_count));
        checked.map_err(|error| reader.blame(&chunk, error))
    })?;
    Ok(())
}

fn chunks_of<'a>(
    decoder: &'a Decoder,
    StreamFrames { stream, frames }: &StreamFrames<'a>,
) -> impl Iterator<Item = (&'a StreamInfo, ChunkEntry)> + use<'a> {
    let (stream, frames) = (*stream, *frames);
    let window = match &stream.header {
        CodecHeader::Depth(header) => header.window(),
        CodecHeader::Material(header) => header.temporal.window,
        CodecHeader::Color(_) | CodecHeader::Alpha(_) => 1,
    };
    let chunks = decoder.reader().index().stream_chunks(stream.index).iter().filter(move |chunk| {
        window > 1 && chunk.key.first_frame <= frames.last && frames.first <= chunk.key.last_frame()
    });
    chunks.map(move |chunk| (stream, *chunk))
}
