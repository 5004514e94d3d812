//! Writes a container front to back without seeking, so that the output may be a pipe.

use std::collections::HashMap;
use std::io::Write;

use crate::container::chunk::{ChunkEntry, ChunkKey, MAX_CHUNK_BYTES};
use crate::container::compression::{Compression, PayloadKind};
use crate::container::header::{FOOT_BYTES, Foot};
use crate::container::index::{Index, ProbeEntry, StreamEntry};
use crate::container::journal::{CompleteChunk, Identity, Journal, Recovered, SafeChunks, identity};
use crate::container::limits::{self, OpenLimits};
use crate::container::payload::Payload;
use crate::container::serialize::write_head;
use crate::error::{Error, Result};

/// Chunks, and bytes of chunks, between two checkpoints of a journal: the maximum that a killed process loses.
const CHECKPOINT_CHUNKS: u64 = 256;
const CHECKPOINT_BYTES: u64 = 4 << 20;

#[derive(Debug, Clone)]
pub struct PackedChunk {
    /// Row of the chunk table, without the offset.
    entry: ChunkEntry,
    identity: Identity,
    stored: Payload,
}

impl PackedChunk {
    /// Compresses the payload if that makes it smaller.
    pub fn new(
        key: ChunkKey,
        payload: Vec<u8>,
        (compression, kind): (Compression, PayloadKind),
    ) -> Result<PackedChunk> {
        let raw_bytes = u32::try_from(payload.len()).ok().filter(|&bytes| bytes <= MAX_CHUNK_BYTES);
        let Some(raw_bytes) = raw_bytes else {
            return Err(Error::unsupported(format!(
                "a chunk of {} bytes: at most {MAX_CHUNK_BYTES} fit, use a shorter `keyframe_interval`, a smaller \
                 `depth_tile` or a smaller `color_cell`",
                payload.len()
            )));
        };
        let (storage, stored) = compression.compress(payload, kind)?;
        let (stored_bytes, crc32) = (stored.len() as u32, crc32fast::hash(&stored));
        let entry = ChunkEntry { key, offset: 0, stored_bytes, raw_bytes, crc32, storage };
        Ok(PackedChunk { identity: identity(&entry, &stored), entry, stored: stored.into() })
    }

    pub fn stored(entry: &ChunkEntry, key: ChunkKey, stored: impl Into<Payload>) -> Result<PackedChunk> {
        let stored = stored.into();
        if stored.len() != entry.stored_bytes as usize {
            return Err(Error::invalid(format!("a chunk of {} bytes, {} announced", stored.len(), entry.stored_bytes)));
        }
        Ok(PackedChunk { entry: ChunkEntry { key, ..*entry }, identity: identity(entry, &stored), stored })
    }

    pub fn key(&self) -> ChunkKey {
        self.entry.key
    }
}

/// Writer of a container. Chunks are stored in the order in which they are pushed; chunks with equal bytes are stored once.
#[derive(Debug)]
pub struct Writer<W: Write> {
    out: W,
    position: u64,
    index: Index,
    stored: HashMap<Identity, u64>,
    journal: Option<Journal>,
    checkpoint: u64,
}

impl<W: Write> Writer<W> {
    /// Writes the head. Probes and streams must be declared before their chunks.
    pub fn new(mut out: W, name: &str, fps: f64, projection: u8) -> Result<Self> {
        let head = write_head();
        out.write_all(&head).map_err(|error| Error::io("", error))?;
        Ok(Writer {
            out,
            position: head.len() as u64,
            index: Index { name: name.to_owned(), fps, projection, ..Index::default() },
            stored: HashMap::new(),
            journal: None,
            checkpoint: 0,
        })
    }

    #[must_use]
    pub fn with_journal(self, journal: Journal) -> Self {
        Writer { journal: Some(journal), ..self }
    }

    /// Continues after the recovered chunks; `out` and the journal append. Probes and streams must be declared again.
    pub fn go_on(out: W, name: &str, fps: f64, projection: u8, (recovered, journal): (Recovered, Journal)) -> Self {
        let Recovered { chunks, container_bytes: position, stored, .. } = recovered;
        let chunks = chunks.into_iter().map(|chunk| chunk.entry).collect();
        let index = Index { name: name.to_owned(), fps, projection, chunks, ..Index::default() };
        Writer { out, position, index, stored, journal: Some(journal), checkpoint: position }
    }

    pub fn add_probe(&mut self, probe: ProbeEntry) -> Result<u16> {
        self.index.probes.push(probe);
        u16::try_from(self.index.probes.len() - 1)
            .map_err(|_| Error::unsupported("a container holds at most 65536 probes: split the dataset"))
    }

    pub fn add_stream(&mut self, stream: StreamEntry) -> u32 {
        self.index.streams.push(stream);
        self.index.streams.len() as u32 - 1
    }

    /// Sets an attribute (container.md 6.3), at any time before the writer is finished.
    pub fn set_attribute(&mut self, name: &str, value: Vec<u8>) {
        self.index.attributes.set(name, value);
    }

    pub fn push(&mut self, chunk: &PackedChunk) -> Result<()> {
        self.push_after(chunk, chunk.key().last_frame())
    }

    /// Appends a chunk that depends on frames up to `last_frame`.
    pub fn push_after(&mut self, chunk: &PackedChunk, last_frame: u32) -> Result<()> {
        let offset = match self.stored.get(&chunk.identity) {
            Some(&offset) => offset,
            None => {
                self.out.write_all(&chunk.stored).map_err(|error| Error::io("", error))?;
                let offset = self.position;
                self.position += chunk.stored.len() as u64;
                self.stored.insert(chunk.identity, offset);
                offset
            }
        };
        let entry = ChunkEntry { offset, ..chunk.entry };
        self.index.chunks.push(entry);
        let Some(journal) = &mut self.journal else { return Ok(()) };
        journal.chunk(&CompleteChunk { entry, last_frame });
        let due = journal.unsafe_chunks() >= CHECKPOINT_CHUNKS || self.position - self.checkpoint >= CHECKPOINT_BYTES;
        if due { self.checkpoint() } else { Ok(()) }
    }

    pub fn note(&mut self, body: &[u8]) {
        if let Some(journal) = &mut self.journal {
            journal.note(body);
        }
    }

    /// Brings the journal, if any, up to date: all chunks pushed so far can be recovered after the process ends.
    pub fn checkpoint(&mut self) -> Result<()> {
        let Some(journal) = &mut self.journal else { return Ok(()) };
        self.out.flush().map_err(|error| Error::io("", error))?;
        self.checkpoint = self.position;
        journal.write()
    }

    pub fn safe(&self) -> SafeChunks {
        self.journal.as_ref().map(Journal::safe).unwrap_or_default()
    }

    pub fn finish(self) -> Result<(W, u64)> {
        self.finish_checked(|_, _| Ok(()))
    }

    /// Writes index and foot, unless `check`, which gets the index and the size of the file, fails. Returns the sink and the
    /// size of the file.
    pub fn finish_checked(mut self, check: impl FnOnce(&Index, u64) -> Result<()>) -> Result<(W, u64)> {
        let checked = || {
            let index = self.index.write()?;
            let bytes = self.position + (index.len() + FOOT_BYTES) as u64;
            let read = Index::read(&index, self.position)?;
            limits::check(&read, bytes, OpenLimits::default())?;
            check(&read, bytes)?;
            Ok((index, bytes))
        };
        let (index, bytes) =
            checked().map_err(|error: Error| error.context("this container could not be opened again"))?;
        let foot =
            Foot { index_offset: self.position, index_bytes: index.len() as u64, index_crc32: crc32fast::hash(&index) };
        let foot = foot.write();
        let written =
            self.out.write_all(&index).and_then(|()| self.out.write_all(&foot)).and_then(|()| self.out.flush());
        written.map_err(|error| Error::io("", error))?;
        Ok((self.out, bytes))
    }
}
