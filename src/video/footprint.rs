//! What work on a container takes of memory at the most, told from its index before a chunk is read.

use crate::container::{ChunkEntry, Reader, Storage, lzma2};
use crate::video::codec::{CodecHeader, ColorFormat, DepthCoding};
use crate::video::decode::{Decoder, StreamInfo};

/// How many times its payload a chunk of nodes takes as it is decoded: a node of two bytes becomes one of 34.
const NODE_RATIO: u64 = 20;
/// Bytes of memory for each byte of the dictionary when LZMA2 compresses.
const LZMA2_ENCODER_RATIO: u64 = 12;

/// Bytes that a chunk takes while it is read, decompressed and checked, and afterwards, ready to be shown.
pub fn chunk_bytes(header: &CodecHeader, chunk: &ChunkEntry) -> u64 {
    reading_bytes(chunk) + ready_bytes(header, chunk)
}

/// Bytes that are given back when a chunk has been read and decompressed.
fn reading_bytes(chunk: &ChunkEntry) -> u64 {
    match chunk.storage {
        Storage::Raw => 0,
        Storage::Lzma2 => u64::from(chunk.stored_bytes) + u64::from(lzma2::dictionary_bytes(chunk.raw_bytes)),
    }
}

/// Bytes of a chunk that is ready to be shown.
fn ready_bytes(header: &CodecHeader, chunk: &ChunkEntry) -> u64 {
    let raw = u64::from(chunk.raw_bytes);
    let nodes = matches!(header, CodecHeader::Depth(depth)
        if matches!(depth.coding, DepthCoding::Nodes(_) | DepthCoding::Tree(_)));
    // What is decompressed grows by doubling.
    let payload = if chunk.storage == Storage::Lzma2 { 2 * raw } else { raw };
    payload + if nodes { NODE_RATIO * raw } else { raw / 8 }
}

/// Bytes that LZMA2 takes to compress a payload, the result included.
pub fn compressing_bytes(raw_bytes: u64) -> u64 {
    let raw = u32::try_from(raw_bytes).unwrap_or(u32::MAX);
    LZMA2_ENCODER_RATIO * u64::from(lzma2::dictionary_bytes(raw)) + raw_bytes
}

/// Bytes that decoding one unit takes: what it shows, and its largest chunks.
pub fn unit_bytes(decoder: &Decoder, stream: &StreamInfo, unit: u32) -> u64 {
    held_bytes(decoder, stream, unit) + unit_reading_bytes(decoder, stream, unit)
}

fn unit_reading_bytes(decoder: &Decoder, stream: &StreamInfo, unit: u32) -> u64 {
    decoder.reader().index().unit_chunks(stream.index, unit).iter().map(reading_bytes).max().unwrap_or(0)
}

/// Bytes of a unit between one frame and the next.
fn held_bytes(decoder: &Decoder, stream: &StreamInfo, unit: u32) -> u64 {
    let [_, _, width, height] = stream.entry.unit_rect(unit);
    let pixels = u64::from(width) * u64::from(height);
    let chunks = decoder.reader().index().unit_chunks(stream.index, unit);
    let chunk = chunks.iter().map(|chunk| ready_bytes(&stream.header, chunk)).max().unwrap_or(0);
    match stream.header {
        CodecHeader::Depth(_) => 2 * pixels + chunk,
        CodecHeader::Material(_) => 3 * pixels + chunk,
        // Two keyframes and what lies between them; a chunk and the one after it.
        CodecHeader::Color(color) => 3 * pixels * sample_bytes(&color.format) * 3 + 2 * chunk,
    }
}

/// Bytes that decoding images of a stream takes, without the images.
pub fn stream_bytes(decoder: &Decoder, stream: &StreamInfo) -> u64 {
    let units = || 0..stream.entry.unit_count();
    let held: u64 = units().map(|unit| held_bytes(decoder, stream, unit)).sum();
    // Each thread reads one chunk at a time.
    let reading = units().map(|unit| unit_reading_bytes(decoder, stream, unit)).max().unwrap_or(0);
    held + reading * rayon::current_num_threads() as u64
}

/// Bytes of an image of a stream: as it is decoded, as metres or light, and while it is written into a file.
pub fn image_bytes(stream: &StreamInfo) -> u64 {
    let pixels = u64::from(stream.entry.width) * u64::from(stream.entry.height);
    let (coded, converted) = match stream.header {
        CodecHeader::Depth(_) => (2, 4),
        CodecHeader::Material(_) => (3, 12),
        CodecHeader::Color(color) => (3 * sample_bytes(&color.format), 6),
    };
    // The writer has the values once by channel and once compressed.
    pixels * (coded + 3 * converted)
}

/// Bytes that an open container takes: its index, and all of it where it came through a pipe.
pub fn container_bytes(reader: &Reader) -> u64 {
    // As it is read the index is there twice.
    3 * reader.overhead_bytes() + reader.bytes_in_memory()
}

fn sample_bytes(format: &ColorFormat) -> u64 {
    match format {
        ColorFormat::EightBit(_) => 1,
        ColorFormat::Half { .. } => 2,
    }
}
