//! Upper bounds of the memory for operations on a container, computed from its index or from payload sizes alone.
//!
//! A decoder holds [`CodecHeader::held_pixel_bytes`] and [`CodecHeader::parsed_chunk_bytes`]. This module adds the memory of
//! decompression, parsing, threads and files.

#[cfg(feature = "encode")]
use crate::container::Compression;
use crate::container::{ChunkEntry, Reader, Storage, StreamEntry, lzma2};
use crate::decode::decoder::Decoder;
use crate::streams::{CodecHeader, StreamInfo};

/// Bytes of memory per byte of the dictionary in LZMA2 compression: a binary tree with two 4-byte positions per byte (8), a hash
/// table with half a position per byte (2), 1.5 times the window (1.5), and tables of fixed size.
#[cfg(feature = "encode")]
const LZMA2_ENCODER_RATIO: u64 = 12;
/// Bytes of memory per byte of the window in Zstandard compression: a hash table with two 4-byte positions per byte (8), a binary
/// tree with two positions per byte (8). Each level also limits these tables (see [`zstd_level_bytes`]).
#[cfg(feature = "encode")]
const ZSTD_ENCODER_RATIO: u64 = 16;
/// Bytes of the Zstandard encoder's tables of fixed size: prices, sequences, literals.
#[cfg(feature = "encode")]
const ZSTD_ENCODER_BYTES: u64 = 3 << 20;
const ZSTD_DECODER_BYTES: u64 = 256 << 10;

/// Returns the bytes needed to read, decompress and parse a chunk.
pub fn chunk_bytes(header: &CodecHeader, stream: &StreamEntry, chunk: &ChunkEntry) -> u64 {
    header.parsed_chunk_bytes(stream, chunk) + reading_bytes(chunk).max(header.parsing_bytes(stream, chunk))
}

/// Returns the bytes that are freed once a chunk is decompressed.
pub fn reading_bytes(chunk: &ChunkEntry) -> u64 {
    match chunk.storage {
        Storage::Raw => 0,
        Storage::Lzma2 => u64::from(chunk.stored_bytes) + u64::from(lzma2::dictionary_bytes(chunk.raw_bytes)),
        // The decoder uses the decompressed payload as its window.
        Storage::Zstd => u64::from(chunk.stored_bytes) + ZSTD_DECODER_BYTES,
    }
}

#[cfg(feature = "encode")]
pub fn compressing_bytes(compression: Compression, raw_bytes: u64) -> u64 {
    let raw = u32::try_from(raw_bytes).unwrap_or(u32::MAX);
    let window = u64::from(lzma2::dictionary_bytes(raw));
    match compression {
        Compression::None => 0,
        Compression::Lzma2(_) => LZMA2_ENCODER_RATIO * window + raw_bytes,
        Compression::Zstd(level) => {
            let tables = (ZSTD_ENCODER_RATIO * window + ZSTD_ENCODER_BYTES).min(zstd_level_bytes(level));
            // The output buffer has space for incompressible data.
            tables + raw_bytes + raw_bytes / 256
        }
    }
}

/// Returns the maximum bytes that a Zstandard level allocates for input of any size, in whole MiB: window, hash and chain tables
/// as allocated by libzstd 1.5.7.
#[cfg(feature = "encode")]
fn zstd_level_bytes(level: u32) -> u64 {
    let mib = match level {
        0..=4 => 3,
        5..=6 => 4,
        7..=8 => 6,
        9 => 11,
        10..=11 => 21,
        12 => 41,
        13 | 16 => 33,
        14 | 17 | 18 => 50,
        15 => 65,
        19.. => 82,
    };
    mib << 20
}

/// Returns the bytes needed to decode one unit: its picture and its largest chunk.
pub fn unit_bytes(decoder: &Decoder, stream: &StreamInfo, unit: u32) -> u64 {
    let [_, _, width, height] = stream.entry.unit_rect(unit);
    let chunks = decoder.reader().index().unit_chunks(stream.index, unit);
    CodecHeader::HELD_UNIT_BYTES
        + u64::from(width) * u64::from(height) * stream.header.held_pixel_bytes()
        + chunks.iter().map(|chunk| stream.header.parsed_chunk_bytes(&stream.entry, chunk)).max().unwrap_or(0)
        + max_reading_bytes(stream, chunks)
}

fn max_reading_bytes(stream: &StreamInfo, chunks: &[ChunkEntry]) -> u64 {
    let bytes = chunks.iter().map(|chunk| reading_bytes(chunk).max(stream.header.parsing_bytes(&stream.entry, chunk)));
    bytes.max().unwrap_or(0)
}

pub fn stream_bytes(decoder: &Decoder, stream: &StreamInfo) -> u64 {
    let index = decoder.reader().index();
    // Each thread reads one chunk at a time.
    let reading = max_reading_bytes(stream, index.stream_chunks(stream.index)) * rayon::current_num_threads() as u64;
    stream.parsed_bytes(index).saturating_add(reading)
}

/// Returns the number of pixels of an image.
pub fn stream_pixels(stream: &StreamInfo) -> u64 {
    u64::from(stream.entry.width) * u64::from(stream.entry.height)
}

/// Returns the bytes needed to write an image to a file: its values, and the writer's copy of them by channel. For colour the
/// second term also covers the conversion to other primaries, which precedes the copy.
pub fn file_bytes(stream: &StreamInfo) -> u64 {
    let converted = match &stream.header {
        CodecHeader::Depth(_) => 4 + 4,
        CodecHeader::Material(_) => 12 + 6,
        CodecHeader::Color(_) => 6 + 6,
        CodecHeader::Alpha(_) => 2 + 2,
    };
    stream_pixels(stream) * converted
}

/// Returns the bytes of an open container: its index, and the whole file if it is in memory, for example after reading from a
/// pipe.
pub fn container_bytes(reader: &Reader) -> u64 {
    // The index is in memory twice while it is read.
    3 * reader.overhead_bytes() + reader.bytes_in_memory()
}

#[cfg(feature = "encode")]
#[cfg(test)]
mod tests {
    use super::*;
    use crate::container::compression::MAX_ZSTD_LEVEL;
    use ::zstd::zstd_safe::{CCtx, compress_bound};

    #[test]
    fn levels_of_zstandard_allocate_no_more_than_is_counted() {
        // 16 MiB exceed the window of every level but the last ones, whose tables reach their maximum at 8 MiB.
        let noise: Vec<u8> =
            (0..16u64 << 17).flat_map(|at| at.wrapping_mul(0x9E37_79B9_7F4A_7C15).to_le_bytes()).collect();
        let mut out = vec![0; compress_bound(noise.len())];
        for level in 1..=MAX_ZSTD_LEVEL {
            let mut context = CCtx::create();
            context.compress(&mut out[..], &noise, level as i32).unwrap();
            let (taken, counted) = (context.sizeof() as u64, zstd_level_bytes(level));
            assert!(taken <= counted, "level {level}: {taken} bytes of {counted}");
        }
    }
}
