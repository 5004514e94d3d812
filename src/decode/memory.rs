//! What work on a container takes of memory at the most, told from its index before a chunk is read.
//!
//! What a decoder holds for pixels and payloads is said in one place, [`CodecHeader::held_pixel_bytes`] and
//! [`CodecHeader::held_payload_bytes`], by which containers are also refused (container.md 2); here LZMA2, threads and files
//! are added.

use crate::container::{ChunkEntry, Reader, Storage, lzma2};
use crate::decode::decoder::{Decoder, StreamInfo};
use crate::streams::header::CodecHeader;

/// Bytes of memory for each byte of the dictionary when LZMA2 compresses: a tree of two positions of 4 bytes for each byte
/// (8), a table of hashes with half as many positions (2), the window and half of it again (1.5), and tables of fixed size.
const LZMA2_ENCODER_RATIO: u64 = 12;

/// Bytes that a chunk takes while it is read, decompressed and checked, and afterwards, ready to be shown.
pub fn chunk_bytes(header: &CodecHeader, chunk: &ChunkEntry) -> u64 {
    reading_bytes(chunk) + header.held_payload_bytes(u64::from(chunk.raw_bytes))
}

/// Bytes that are given back when a chunk has been read and decompressed.
fn reading_bytes(chunk: &ChunkEntry) -> u64 {
    match chunk.storage {
        Storage::Raw => 0,
        Storage::Lzma2 => u64::from(chunk.stored_bytes) + u64::from(lzma2::dictionary_bytes(chunk.raw_bytes)),
    }
}

/// Bytes that LZMA2 takes to compress a payload, the result included.
pub fn compressing_bytes(raw_bytes: u64) -> u64 {
    let raw = u32::try_from(raw_bytes).unwrap_or(u32::MAX);
    LZMA2_ENCODER_RATIO * u64::from(lzma2::dictionary_bytes(raw)) + raw_bytes
}

/// Bytes that decoding one unit takes: what it shows, and its largest chunk.
pub fn unit_bytes(decoder: &Decoder, stream: &StreamInfo, unit: u32) -> u64 {
    let [_, _, width, height] = stream.entry.unit_rect(unit);
    let chunks = decoder.reader().index().unit_chunks(stream.index, unit);
    let largest = chunks.iter().map(|chunk| u64::from(chunk.raw_bytes)).max().unwrap_or(0);
    CodecHeader::HELD_UNIT_BYTES
        + u64::from(width) * u64::from(height) * stream.header.held_pixel_bytes()
        + stream.header.held_payload_bytes(largest)
        + most_reading_bytes(chunks)
}

fn most_reading_bytes(chunks: &[ChunkEntry]) -> u64 {
    chunks.iter().map(reading_bytes).max().unwrap_or(0)
}

/// Bytes that decoding images of a stream takes, one image included.
pub fn stream_bytes(decoder: &Decoder, stream: &StreamInfo) -> u64 {
    let index = decoder.reader().index();
    // Each thread reads one chunk at a time.
    let reading = most_reading_bytes(index.stream_chunks(stream.index)) * rayon::current_num_threads() as u64;
    stream.memory_bytes(index).saturating_add(reading)
}

/// Bytes that writing a decoded image of a stream into a file takes: 4-byte metres, half floats or three floats a pixel, as
/// they are, by channel in the writer, and compressed.
pub fn file_bytes(stream: &StreamInfo) -> u64 {
    let pixels = u64::from(stream.entry.width) * u64::from(stream.entry.height);
    let converted = match stream.header {
        CodecHeader::Depth(_) => 4,
        CodecHeader::Material(_) => 12,
        CodecHeader::Color(_) => 6,
    };
    3 * pixels * converted
}

/// Bytes that an open container takes: its index, and all of it where it came through a pipe.
pub fn container_bytes(reader: &Reader) -> u64 {
    // As it is read the index is there twice.
    3 * reader.overhead_bytes() + reader.bytes_in_memory()
}
