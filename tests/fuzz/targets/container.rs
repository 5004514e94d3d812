//! Whole containers, LZMA2 and Zstandard chunks, and shard entries.

use std::hash::{DefaultHasher, Hash, Hasher};

use codec::container::{Compression, OpenLimits, Reader, lzma2, zstd};
use codec::decode::{self, AllUnits, Decoder, FaceDecoder, OnDamage, Picture, Request, StreamFrames, StreamInfo};
use codec::depth::mode_decision::Decide;
use codec::effort::Effort;
use codec::error::{Error, Result};
use codec::image::FrameRange;
use codec::memory::Budget;
use codec::monitor::Silent;
use codec::streams::CodecHeader;
use codec::streams::shard::{FootageDigests, SHARD, ShardEntry};
use footage::encode::ErrorBound;
use footage::inspect::{self, Check, FrameRows, InspectSettings, coding_map};
use footage::pack::{self, FlattenSettings, PackSettings, Repack};

use super::{Judged, Verdict, judge, refused};
use crate::ALLOCATED;

/// Limits for most inputs; they are small so that an input runs fast.
const SMALL: OpenLimits = OpenLimits { memory_floor_bytes: 256 << 10, memory_ratio: 64, ..OpenLimits::DEFAULT };
/// One in so many inputs, selected by CRC-32, is opened with the default limits of the commands.
const DEFAULT_EVERY: u32 = 512;
/// Bytes used by node encoders and LZMA2 when quadtrees are flattened.
pub const FLATTENING: u64 = 48 << 20;
/// Maximum bytes used to pack, in addition to the file and its index: a batch of chunks, and [`FLATTENING`].
const PACKING: u64 = FLATTENING + (16 << 20);
/// Number of frames of a stream that are decoded with `--keep-going`.
const KEPT_FRAMES: u32 = 6;
/// Maximum number of decoded streams of an input.
const MAX_STREAMS: usize = 8;

/// Returns the limits for an input.
fn limits(bytes: &[u8]) -> OpenLimits {
    if crc32fast::hash(bytes).is_multiple_of(DEFAULT_EVERY) { OpenLimits::DEFAULT } else { SMALL }
}

/// Returns the bytes used in addition to the images and payloads of the decoded stream: several copies of the file and its index,
/// and tables.
pub fn beside(file_bytes: u64) -> u64 {
    (2 << 20) + 64 * file_bytes
}

/// Returns the maximum bytes used to decode the streams one after another (container.md 2).
pub fn bound(bytes: &[u8]) -> u64 {
    let file_bytes = bytes.len() as u64;
    let flattened = if bytes.windows(4).any(|codec| codec == b"DQTR") { FLATTENING } else { 0 };
    limits(bytes).stream_bytes(file_bytes) + beside(file_bytes) + flattened
}

/// Opens, packs, inspects and decodes a container.
pub fn run(bytes: &[u8]) -> Judged {
    run_within(bytes, limits(bytes))
}

pub fn run_within(bytes: &[u8], limits: OpenLimits) -> Judged {
    let open = || Reader::from_source(std::sync::Arc::new(bytes.to_vec()), "", limits);
    let reader = match open() {
        Ok(reader) => reader,
        Err(error) => return refused(&error),
    };
    match open() {
        Ok(again) if again.index() == reader.index() => {}
        _ => return Err("opened twice, it is not the same".into()),
    }
    drop(reader);
    let copied = pack_within(bytes, limits)?;
    let reader = open().map_err(|error| error.to_string())?;
    // A shard cannot be packed without the other shards of its encode.
    let is_shard = reader.index().attributes.get(SHARD).is_some();
    let decoder = match Decoder::new(reader) {
        Ok(decoder) => decoder,
        Err(error) => return refused(&error),
    };
    let sound = inspect_all(&decoder)?;
    let mut verdict = Verdict::Accepted;
    for stream in decoder.streams().iter().take(MAX_STREAMS) {
        if decode_by_two_ways(&decoder, stream)? == Verdict::Refused {
            verdict = Verdict::Refused;
        }
        keep_going(&decoder, stream)?;
    }
    if sound == Verdict::Accepted && copied == Verdict::Refused && !is_shard {
        return Err("a sound container cannot be packed".into());
    }
    Ok(verdict)
}

/// Packs a container within a separate memory bound, because decoding does not hold batches of chunks.
fn pack_within(bytes: &[u8], limits: OpenLimits) -> Judged {
    let before = ALLOCATED.current_usage();
    ALLOCATED.reset_peak_usage();
    let verdict = pack_again(bytes, limits);
    let packed = ALLOCATED.peak_usage().saturating_sub(before) as u64;
    ALLOCATED.reset_peak_usage();
    let file_bytes = bytes.len() as u64;
    let bound = PACKING + beside(file_bytes);
    if packed > bound {
        return Err(format!("packing took {packed} bytes of memory: the bound is {bound}"));
    }
    verdict
}

/// Packs a container: flattened, if it has intermediate quadtrees (`DQTR`), and with its chunks copied unchanged. Copying does
/// not parse payloads.
fn pack_again(bytes: &[u8], limits: OpenLimits) -> Judged {
    let reader = Reader::from_source(std::sync::Arc::new(bytes.to_vec()), "", limits);
    let Ok(reader) = reader else { return Ok(Verdict::Refused) };
    let readers = [reader];
    if readers[0].index().streams.iter().any(|stream| stream.codec == *b"DQTR") {
        let flatten = FlattenSettings {
            error: ErrorBound::Codes(30),
            window: 2,
            epsilon: 1,
            decide: Decide::default(),
            effort: Effort::Fast,
            min_children: 3,
        };
        let settings = PackSettings {
            repack: Repack::As(Compression::Zstd(1)),
            flatten: Some(flatten),
            memory: Budget::UNLIMITED,
        };
        judge(&pack::pack(&readers, &settings, Vec::new(), &Silent))?;
    }
    let settings = PackSettings { repack: Repack::Keep, flatten: None, memory: Budget::UNLIMITED };
    judge(&pack::pack(&readers, &settings, Vec::new(), &Silent))
}

fn inspect_all(decoder: &Decoder) -> Judged {
    let streams: Vec<&StreamInfo> = decoder.streams().iter().take(MAX_STREAMS).collect();
    let listed = InspectSettings { rows: FrameRows::None, check: Check::ListAll, memory: Budget::UNLIMITED };
    let inspection = match inspect::inspect(decoder, &streams, listed, &Silent) {
        Ok(inspection) => inspection,
        Err(error) => return refused(&error),
    };
    if let Some(chunk) = inspection.damaged.iter().find(|chunk| chunk.reason.contains(char::is_control)) {
        return Err(format!("a reason with control characters: {:?}", chunk.reason));
    }
    if inspection.damaged.is_empty() {
        return Ok(Verdict::Accepted);
    }
    // Without the list, inspection must fail with the first error of the list.
    match inspect::inspect(decoder, &streams, InspectSettings::default(), &Silent) {
        Err(error) => refused(&error),
        // Some damage is detected only by comparing two decoders.
        Ok(_) => Ok(Verdict::Refused),
    }
}

/// Returns the frames of a stream to test: the first five, the middle one and the last.
fn frames_of(stream: &StreamInfo) -> Vec<u32> {
    let (first, count) = (stream.frames.first, stream.entry.frame_count);
    let mut frames: Vec<u32> = (0..count.min(5)).chain([count / 2, count - 1]).map(|at| first + at).collect();
    frames.sort_unstable();
    frames.dedup();
    frames
}

/// True if a frame has the same image in any decoding order, for any payload. With a window above 1, only encoders ensure this.
fn any_way_is_equal(header: &CodecHeader) -> bool {
    match header {
        CodecHeader::Depth(depth) => depth.window() == 1,
        CodecHeader::Material(material) => material.temporal.window == 1,
        CodecHeader::Color(_) | CodecHeader::Alpha(_) => true,
    }
}

fn decode_by_two_ways(decoder: &Decoder, stream: &StreamInfo) -> Judged {
    let frames = frames_of(stream);
    let mut face = decoder.face(stream);
    let forward: Vec<Result<u64>> = frames.iter().map(|&frame| shown(&mut face, frame)).collect();
    drop(face);
    let mut verdict = Verdict::Accepted;
    for error in forward.iter().filter_map(|result| result.as_ref().err()) {
        verdict = refused(error)?;
    }
    let compare = |at: usize, other: &Result<u64>, way: &str| match (&forward[at], other) {
        (Ok(one), Ok(other)) if one == other => Ok(()),
        (Err(_), Err(_)) => Ok(()),
        (one, other) => Err(format!(
            "stream {} frame {} is {} forwards and {} {way}",
            stream.index,
            frames[at],
            words(one),
            words(other)
        )),
    };
    let mut again = decoder.face(stream);
    for (at, &frame) in frames.iter().enumerate() {
        compare(at, &shown(&mut again, frame), "forwards again")?;
    }
    drop(again);
    if any_way_is_equal(&stream.header) {
        let mut face = decoder.face(stream);
        for (at, &frame) in frames.iter().enumerate().rev() {
            compare(at, &shown(&mut face, frame), "backwards")?;
        }
    }
    // An error in one unit does not affect another.
    let unit_count = stream.entry.unit_count();
    for unit in (0..unit_count.min(3)).chain(unit_count.checked_sub(1)) {
        let result = decoder.unit(stream, unit).decode(frames[frames.len() - 1]);
        judge(&result)?;
    }
    judge(&coding_map(decoder, stream, frames[frames.len() / 2]))?;
    Ok(verdict)
}

/// Checks that `--keep-going` lists exactly the images that cannot be decoded, and that a face decoder agrees.
fn keep_going(decoder: &Decoder, stream: &StreamInfo) -> Judged {
    let first = stream.frames.first;
    let frames = FrameRange { first, last: stream.frames.last.min(first + (KEPT_FRAMES - 1)) };
    let decoded = match decode::decode_units(
        decoder,
        Request::all(&[StreamFrames { stream, frames }]),
        OnDamage::KeepGoing,
        &Silent,
    ) {
        Ok(decoded) => decoded,
        Err(error) => return refused(&error),
    };
    if decoded.missing.is_empty() != decoded.damaged.is_empty() {
        return Err(format!("{:?} missing for {:?}", decoded.missing, decoded.damaged));
    }
    let listed = |frame| decoded.missing.iter().flat_map(|missing| &missing.frames).any(|range| range.contains(frame));
    let mut face = decoder.face(stream);
    for frame in frames.iter() {
        let intact = match face.decode_intact(frame, &AllUnits) {
            Ok(picture) => picture.is_some(),
            Err(error) => return refused(&error),
        };
        if intact == listed(frame) || intact != decoder.face(stream).decode(frame).is_ok() {
            return Err(format!("stream {} frame {frame} is listed: {}", stream.index, listed(frame)));
        }
    }
    Ok(Verdict::Accepted)
}

/// Returns a hash of an image's bits.
fn shown(face: &mut FaceDecoder<'_>, frame: u32) -> Result<u64> {
    let mut hasher = DefaultHasher::new();
    match face.decode(frame)? {
        Picture::Depth(plane) => plane.data().hash(&mut hasher),
        Picture::Color8(plane) | Picture::Material(plane) => plane.data().hash(&mut hasher),
        Picture::Alpha(plane) => plane.data().hash(&mut hasher),
        Picture::ColorHalf(plane) => {
            plane.data().as_flattened().iter().for_each(|value| hasher.write_u16(value.to_bits()));
        }
    }
    Ok(hasher.finish())
}

fn words(result: &Result<u64>) -> String {
    match result {
        Ok(hash) => format!("picture {hash:016x}"),
        Err(error) => format!("an error ({error})"),
    }
}

/// Decompresses an LZMA2 stream preceded by its uncompressed size in four bytes.
pub fn run_lzma2(bytes: &[u8]) -> Judged {
    let Some((size, stored)) = bytes.split_first_chunk::<4>() else { return Ok(Verdict::Refused) };
    let raw_bytes = u32::from_le_bytes(*size) % (4 << 20);
    let ours = lzma2::decompress(stored, raw_bytes);
    let raw = match &ours {
        Ok(raw) => raw,
        Err(error) => return refused(error),
    };
    if raw.len() != raw_bytes as usize {
        return Err(format!("{} bytes where {raw_bytes} were asked for", raw.len()));
    }
    match lzma2::decompress_independent(stored, raw_bytes) {
        Ok(other) if other != *raw => Err("two LZMA2 decoders do not agree".into()),
        Ok(_) => Ok(Verdict::Accepted),
        Err(error @ Error::Invalid { .. }) => refused(&error),
        Err(error) => Err(format!("another kind of error: {error}")),
    }
}

/// Decompresses a Zstandard frame preceded by its uncompressed size in four bytes.
pub fn run_zstd(bytes: &[u8]) -> Judged {
    let Some((size, stored)) = bytes.split_first_chunk::<4>() else { return Ok(Verdict::Refused) };
    let raw_bytes = u32::from_le_bytes(*size) % (4 << 20);
    let raw = match zstd::decompress(stored, raw_bytes) {
        Ok(raw) => raw,
        Err(error) => return refused(&error),
    };
    if raw.len() != raw_bytes as usize {
        return Err(format!("{} bytes where {raw_bytes} were asked for", raw.len()));
    }
    // The decoder accepts only frames that keep all rules, so no other decoder may refuse them.
    match zstd::decompress_independent(stored, raw_bytes) {
        Ok(other) if other != raw => Err("two Zstandard decoders do not agree".into()),
        Ok(_) => Ok(Verdict::Accepted),
        Err(error) => Err(format!("the second Zstandard decoder refuses it: {error}")),
    }
}

/// Twice the maximum output, two dictionaries and the decoders' tables.
pub fn bound_lzma2(bytes: &[u8]) -> u64 {
    (40 << 20) + 4 * bytes.len() as u64
}

/// Parses the attributes of a shard; its entry is written and parsed again.
pub fn run_shard(bytes: &[u8]) -> Judged {
    FootageDigests::read(bytes, bytes.len() % 5);
    let entry = match ShardEntry::read(bytes) {
        Ok(entry) => entry,
        Err(error) => return refused(&error),
    };
    match ShardEntry::read(&entry.write()) {
        Ok(again) if again == entry => Ok(Verdict::Accepted),
        _ => Err("the entry of a shard comes back as another".into()),
    }
}
