//! A row of the chunk table (container.md 6): the unit and frames of a chunk, and where and how it is stored.
//!
//! A chunk is fetched, checked and decompressed as a whole, so its length determines the cost of a seek.

use crate::container::fields::Fields;
use crate::container::header::HEAD_BYTES;
use crate::error::Result;

pub const MAX_CHUNK_BYTES: u32 = 1 << 30;
/// Maximum raw bytes per stored byte of LZMA2; its densest codes reach about 7,000.
pub const MAX_EXPANSION: u64 = 16_384;
/// Maximum raw bytes per stored byte of Zstandard: a block of 128 KiB takes at least four bytes.
pub const MAX_ZSTD_EXPANSION: u64 = 32_768;

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum Storage {
    Raw = 0,
    /// One LZMA2 stream, with the dictionary size of [`dictionary_bytes`](crate::container::lzma2::dictionary_bytes).
    Lzma2 = 1,
    /// One Zstandard frame.
    Zstd = 2,
}

impl Storage {
    /// Returns the storage of a number in a file.
    pub(super) fn of(number: u64) -> Option<Storage> {
        [Storage::Raw, Storage::Lzma2, Storage::Zstd].into_iter().find(|&storage| storage as u64 == number)
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ChunkKey {
    pub stream: u32,
    /// Index of the tile or cell in the stream, in row-major order.
    pub unit: u32,
    pub first_frame: u32,
    /// Number of frames, at least 1.
    pub frame_count: u32,
}

impl ChunkKey {
    pub fn last_frame(self) -> u32 {
        self.first_frame + (self.frame_count - 1)
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ChunkPlace {
    Inner,
    Last,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ChunkEntry {
    pub key: ChunkKey,
    pub offset: u64,
    pub stored_bytes: u32,
    pub raw_bytes: u32,
    pub crc32: u32,
    pub storage: Storage,
}

impl ChunkEntry {
    /// Fails unless the chunk lies between the head and `end`, and its sizes are plausible; `start` is the offset of the row.
    pub(super) fn check(&self, fields: &Fields<'_>, start: u64, end: u64) -> Result<()> {
        let ChunkEntry { offset, stored_bytes, raw_bytes, .. } = *self;
        let inside =
            offset >= HEAD_BYTES as u64 && offset.checked_add(u64::from(stored_bytes)).is_some_and(|last| last <= end);
        if !inside {
            return Err(fields.error_at(
                start,
                format!("a chunk of {stored_bytes} bytes at {offset} lies outside the file's chunks"),
            ));
        }
        let plausible = raw_bytes <= MAX_CHUNK_BYTES
            && match self.storage {
                Storage::Raw => raw_bytes == stored_bytes,
                Storage::Lzma2 => u64::from(raw_bytes) <= u64::from(stored_bytes) * MAX_EXPANSION,
                Storage::Zstd => u64::from(raw_bytes) <= u64::from(stored_bytes) * MAX_ZSTD_EXPANSION,
            };
        if !plausible {
            return Err(fields.error_at(
                start,
                format!("a chunk of {stored_bytes} stored bytes cannot decompress to {raw_bytes} bytes"),
            ));
        }
        Ok(())
    }
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub struct EncodedChunk {
    /// First frame, relative to the unit's first.
    pub first_frame: u32,
    pub frame_count: u32,
    pub payload: Vec<u8>,
}
