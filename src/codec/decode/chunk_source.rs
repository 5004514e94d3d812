//! Finds, reads, checks and parses the chunks of one unit, and measures the cost.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use crate::container::{ChunkEntry, ChunkKey, Payload, Reader};
use crate::decode::damage::DamagedChunk;
use crate::error::{Error, Result};
use crate::math::add_members;

/// Work done by a decoder.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct DecodeCost {
    /// Pixels written.
    pub updated_pixels: u64,
    /// Stored bytes read.
    pub bytes_read: u64,
    /// Time for reading chunks, checking CRCs, decompressing and parsing, summed over threads.
    pub fetching: Duration,
    /// Time for writing pixels, summed over threads.
    pub applying: Duration,
}

add_members!(DecodeCost: updated_pixels, bytes_read, fetching, applying);

#[derive(Debug)]
pub(super) struct ChunkSource<'a> {
    pub reader: &'a Reader,
    pub chunks: &'a [ChunkEntry],
    pub cost: DecodeCost,
    /// Buffer of the last chunk, reused for the next one.
    pub buffer: Vec<u8>,
    /// Damaged chunks, which are not read again.
    pub damaged: BTreeMap<ChunkKey, DamagedChunk>,
}

impl<'a> ChunkSource<'a> {
    pub fn new(reader: &'a Reader, chunks: &'a [ChunkEntry], buffer: Vec<u8>) -> ChunkSource<'a> {
        ChunkSource { reader, chunks, cost: DecodeCost::default(), buffer, damaged: BTreeMap::new() }
    }

    pub fn find(&self, frame: u32) -> Result<(usize, ChunkEntry)> {
        let at = self.chunks.partition_point(|chunk| chunk.key.first_frame <= frame);
        at.checked_sub(1)
            .map(|at| (at, self.chunks[at]))
            .filter(|(_, chunk)| frame - chunk.key.first_frame < chunk.key.frame_count)
            .ok_or_else(|| Error::invalid(format!("no chunk holds frame {frame}")).in_file(self.reader.path()))
    }

    /// Adds a chunk to `damaged`; returns the error with the names of the chunk and the file.
    pub fn damage(&mut self, chunk: &ChunkEntry, error: Error) -> Error {
        self.damaged.insert(chunk.key, DamagedChunk::new(chunk, &error));
        self.reader.blame(chunk, error)
    }

    /// Reads and parses a chunk; adds it to `damaged` if that fails.
    pub fn fetch<T>(&mut self, chunk: &ChunkEntry, parse: impl FnOnce(Payload) -> Result<T>) -> Result<T> {
        if let Some(known) = self.damaged.get(&chunk.key) {
            return Err(self.reader.blame(chunk, Error::invalid(known.reason.clone())));
        }
        let start = Instant::now();
        let buffer = std::mem::take(&mut self.buffer);
        let parsed = self.reader.load_into(chunk, buffer).and_then(parse).map_err(|error| self.damage(chunk, error))?;
        self.cost.fetching += start.elapsed();
        self.cost.bytes_read += u64::from(chunk.stored_bytes);
        Ok(parsed)
    }
}
