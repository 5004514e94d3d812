//! One row of the chunk table (container.md 6): which frames of which unit lie where, and how they are stored.

use crate::container::fields::{Fields, PutFields};
use crate::error::Result;

/// Bytes of a row of the chunk table.
pub const ENTRY_BYTES: usize = 40;
/// The largest payload of a chunk, stored or raw.
pub const MAX_CHUNK_BYTES: u32 = 1 << 30;
/// No stored byte of LZMA2 can mean more raw bytes than this; a table that claims more is refused before memory is
/// asked for. (LZMA's densest match codes reach about 7,000.)
pub const MAX_EXPANSION: u64 = 16_384;

/// How a chunk's bytes are stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum Storage {
    /// As they are.
    Raw = 0,
    /// As one LZMA2 stream, with the dictionary of [`super::lzma2::dictionary_bytes`].
    Lzma2 = 1,
}

/// What a chunk holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ChunkKey {
    /// Index of the stream in the stream table.
    pub stream: u32,
    /// Tile or cell of the stream, row-major.
    pub unit: u32,
    /// First frame.
    pub first_frame: u32,
    /// Number of frames, at least 1.
    pub frame_count: u32,
}

/// Where a chunk stands among those of its unit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ChunkPlace {
    /// Another one follows it.
    Inner,
    /// None follows it.
    Last,
}

/// A row of the chunk table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ChunkEntry {
    /// What the chunk holds.
    pub key: ChunkKey,
    /// Where its stored bytes start in the file.
    pub offset: u64,
    /// How many bytes are stored.
    pub stored_bytes: u32,
    /// How many bytes they mean.
    pub raw_bytes: u32,
    /// CRC-32 of the stored bytes.
    pub crc32: u32,
    /// How they are stored.
    pub storage: Storage,
}

impl ChunkEntry {
    /// Appends the row.
    pub fn write(&self, out: &mut Vec<u8>) {
        out.put_u32(self.key.stream);
        out.put_u32(self.key.unit);
        out.put_u32(self.key.first_frame);
        out.put_u32(self.key.frame_count);
        out.put_u64(self.offset);
        out.put_u32(self.stored_bytes);
        out.put_u32(self.raw_bytes);
        out.put_u32(self.crc32);
        out.push(self.storage as u8);
        out.extend_from_slice(&[0; 3]);
    }

    /// Reads a row; the chunk lies between the head and `end`, and its sizes are plausible.
    pub fn read(fields: &mut Fields<'_>, end: u64) -> Result<ChunkEntry> {
        let key = ChunkKey {
            stream: fields.u32()?,
            unit: fields.u32()?,
            first_frame: fields.u32()?,
            frame_count: fields.u32()?,
        };
        let (offset, stored_bytes, raw_bytes, crc32) = (fields.u64()?, fields.u32()?, fields.u32()?, fields.u32()?);
        let storage = match fields.u8()? {
            0 => Storage::Raw,
            1 => Storage::Lzma2,
            other => return Err(fields.error(format!("a chunk is stored by method {other}, which is unknown"))),
        };
        fields.zeros(3)?;
        let inside = offset >= super::header::HEAD_BYTES as u64
            && offset.checked_add(u64::from(stored_bytes)).is_some_and(|last| last <= end);
        if !inside {
            return Err(
                fields.error(format!("a chunk of {stored_bytes} bytes at {offset} lies outside the file's chunks"))
            );
        }
        let plausible = raw_bytes <= MAX_CHUNK_BYTES
            && match storage {
                Storage::Raw => raw_bytes == stored_bytes,
                Storage::Lzma2 => u64::from(raw_bytes) <= u64::from(stored_bytes) * MAX_EXPANSION,
            };
        if !plausible {
            return Err(fields.error(format!("a chunk of {stored_bytes} stored bytes cannot mean {raw_bytes} bytes")));
        }
        Ok(ChunkEntry { key, offset, stored_bytes, raw_bytes, crc32, storage })
    }
}

/// A finished group of frames of one unit, as an encoder hands it over.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct EncodedChunk {
    /// Frames since the unit's first.
    pub first_frame: u32,
    /// Number of frames.
    pub frame_count: u32,
    /// The payload.
    pub payload: Vec<u8>,
}
