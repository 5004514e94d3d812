//! Journal beside an unfinished container, in which a later process finds the complete chunks. Not a part of the format.
//!
//! A container has its index at the end, so an incomplete file does not describe its chunks. If the index were written after
//! each batch, the bytes of the file would depend on when it was stopped, and the file would have to be seekable.
//!
//! Layout: the eight bytes `LFJOURN1`, then records: length of the body (u32), CRC-32 of kind and body (u32), kind (u8),
//! body. Kind 0, the head: the configuration of the encode. Kind 1, a chunk: its row of the chunk table, and the last frame
//! that its bytes depend on (u32). Kind 2: a note of the encoder. A chunk's record is written after the chunk's bytes, at
//! least every 256 chunks or 4 MiB. Neither file is synced in between, so [`recover`] compares the CRC-32 of every chunk with
//! the container's bytes.

use std::collections::{HashMap, VecDeque};
use std::fmt;
use std::hash::{DefaultHasher, Hasher};
use std::io::{Read, Write};

use crate::container::chunk::{ChunkEntry, ChunkKey, Storage};
use crate::container::fields::Fields;
use crate::container::serialize::{PutFields, write_head};
use crate::error::{Error, Result};
use crate::monitor::Monitor;

/// First eight bytes of a journal; the last is the version of the layout.
pub const MAGIC: [u8; 8] = *b"LFJOURN1";
/// Bytes of the body of a record of a chunk.
const CHUNK_BYTES: usize = 41;
/// Bytes of a record before its body: length, CRC-32 and kind.
const RECORD_HEAD_BYTES: usize = 9;
const HEAD: u8 = 0;
const CHUNK: u8 = 1;
const NOTE: u8 = 2;

/// 128 bits of hash; CRC-32 and length.
pub(super) type Identity = [u64; 3];

/// Identity of a stored chunk. Chunks with the same bytes and the same storage are stored once (container.md 6).
pub(super) fn identity(entry: &ChunkEntry, stored: &[u8]) -> Identity {
    let hash = |salt: u8| {
        let mut hasher = DefaultHasher::new();
        hasher.write(&[salt, entry.storage as u8]);
        hasher.write_u32(entry.raw_bytes);
        hasher.write(stored);
        hasher.finish()
    };
    [hash(1), hash(2), u64::from(entry.crc32) << 32 | stored.len() as u64]
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CompleteChunk {
    pub entry: ChunkEntry,
    /// Last frame that the chunk's bytes depend on: its own last frame, or a frame of the lookahead.
    pub last_frame: u32,
}

/// Journalled chunks that a restart can recover.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct SafeChunks {
    pub count: u64,
    pub last: Option<ChunkKey>,
}

/// Appends records. They stay in memory until [`super::Writer::checkpoint`] has written the chunks that they describe.
pub struct Journal {
    out: Box<dyn Write + Send>,
    gathered: VecDeque<Record>,
    pushed: SafeChunks,
    safe: SafeChunks,
}

struct Record {
    bytes: Vec<u8>,
    /// Chunks that can be recovered once the record is written.
    safe: SafeChunks,
}

impl fmt::Debug for Journal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Journal").field("safe", &self.safe).finish_non_exhaustive()
    }
}

impl Journal {
    pub fn start(out: Box<dyn Write + Send>, head: &[u8]) -> Journal {
        let safe = SafeChunks::default();
        let mut journal = Journal { out, gathered: VecDeque::new(), pushed: safe, safe };
        journal.gathered.push_back(Record { bytes: MAGIC.to_vec(), safe });
        journal.record(HEAD, head);
        journal
    }

    pub fn go_on(out: Box<dyn Write + Send>, recovered: &Recovered) -> Journal {
        let safe = recovered.safe();
        Journal { out, gathered: VecDeque::new(), pushed: safe, safe }
    }

    pub fn note(&mut self, body: &[u8]) {
        self.record(NOTE, body);
    }

    pub(super) fn chunk(&mut self, chunk: &CompleteChunk) {
        let mut body = Vec::with_capacity(CHUNK_BYTES);
        let ChunkEntry { key, offset, stored_bytes, raw_bytes, crc32, storage } = chunk.entry;
        [key.stream, key.unit, key.first_frame, key.frame_count].iter().for_each(|&value| body.put_u32(value));
        body.put_u64(offset);
        [stored_bytes, raw_bytes, crc32, chunk.last_frame].iter().for_each(|&value| body.put_u32(value));
        body.push(storage as u8);
        self.pushed = SafeChunks { count: self.pushed.count + 1, last: Some(key) };
        self.record(CHUNK, &body);
    }

    fn record(&mut self, kind: u8, body: &[u8]) {
        let mut bytes = Vec::with_capacity(RECORD_HEAD_BYTES + body.len());
        bytes.put_u32(body.len() as u32);
        bytes.put_u32(checksum(kind, body));
        bytes.push(kind);
        bytes.extend_from_slice(body);
        self.gathered.push_back(Record { bytes, safe: self.pushed });
    }

    /// Number of chunks that were pushed since the last checkpoint.
    pub(super) fn unsafe_chunks(&self) -> u64 {
        self.pushed.count - self.safe.count
    }

    /// Writes the gathered records; the chunks that they describe must be written. If the disk fills up, the records written
    /// before remain valid.
    pub(super) fn write(&mut self) -> Result<()> {
        while let Some(record) = self.gathered.pop_front() {
            self.out.write_all(&record.bytes).and_then(|()| self.out.flush()).map_err(|error| Error::io("", error))?;
            self.safe = record.safe;
        }
        Ok(())
    }

    pub fn safe(&self) -> SafeChunks {
        self.safe
    }
}

fn checksum(kind: u8, body: &[u8]) -> u32 {
    let mut hasher = crc32fast::Hasher::new();
    hasher.update(&[kind]);
    hasher.update(body);
    hasher.finalize()
}

#[derive(Debug, Clone, Default)]
pub struct Recovered {
    pub head: Vec<u8>,
    pub chunks: Vec<CompleteChunk>,
    pub notes: Vec<Vec<u8>>,
    /// Number of valid bytes of the container, which is truncated to them.
    pub container_bytes: u64,
    /// Number of valid bytes of the journal, which is truncated to them.
    pub journal_bytes: u64,
    pub(super) stored: HashMap<Identity, u64>,
}

impl Recovered {
    pub fn safe(&self) -> SafeChunks {
        SafeChunks { count: self.chunks.len() as u64, last: self.chunks.last().map(|chunk| chunk.entry.key) }
    }
}

pub fn recover_watched(journal: &[u8], container: impl Read, monitor: &dyn Monitor) -> Result<Option<Recovered>> {
    let found = recover(journal, Watched { from: container, monitor });
    monitor.check()?;
    found
}

/// A reader that fails when the monitor requests a stop.
struct Watched<'a, R> {
    from: R,
    monitor: &'a dyn Monitor,
}

impl<R: Read> Read for Watched<'_, R> {
    fn read(&mut self, bytes: &mut [u8]) -> std::io::Result<usize> {
        // Not of kind `Interrupted`, because readers retry after that.
        if self.monitor.interrupted() { Err(std::io::Error::other("asked to stop")) } else { self.from.read(bytes) }
    }
}

/// Reads a journal up to the first record that is incomplete, damaged, or describes a chunk that the container does not fully
/// have. Returns `None` if the head of the journal or of the container is invalid.
pub fn recover(journal: &[u8], mut container: impl Read) -> Result<Option<Recovered>> {
    let mut records = Records { bytes: journal, position: MAGIC.len() };
    let Some((HEAD, head)) = journal.starts_with(&MAGIC).then(|| records.next()).flatten() else { return Ok(None) };
    let mut bytes = Vec::new();
    let expected = write_head();
    if !read_some(&mut container, expected.len(), &mut bytes)? || bytes != expected {
        return Ok(None);
    }
    let mut found = Recovered {
        head: head.to_vec(),
        container_bytes: expected.len() as u64,
        journal_bytes: records.position as u64,
        ..Recovered::default()
    };
    // CRC-32 by offset and length, because chunks with equal bytes are stored once.
    let mut checked: HashMap<(u64, u32), u32> = HashMap::new();
    while let Some((kind, body)) = records.next() {
        match kind {
            NOTE => found.notes.push(body.to_vec()),
            CHUNK => {
                let Some(chunk) = read_chunk(body) else { break };
                let ChunkEntry { offset, stored_bytes, crc32, .. } = chunk.entry;
                let known = checked.get(&(offset, stored_bytes));
                let sound = match known {
                    Some(&known) => known == crc32,
                    None => {
                        offset == found.container_bytes
                            && read_some(&mut container, stored_bytes as usize, &mut bytes)?
                            && crc32fast::hash(&bytes) == crc32
                    }
                };
                if !sound {
                    break;
                }
                if known.is_none() {
                    checked.insert((offset, stored_bytes), crc32);
                    found.stored.insert(identity(&chunk.entry, &bytes), offset);
                    found.container_bytes += u64::from(stored_bytes);
                }
                found.chunks.push(chunk);
            }
            _ => break,
        }
        found.journal_bytes = records.position as u64;
    }
    Ok(Some(found))
}

fn read_some(from: &mut impl Read, count: usize, bytes: &mut Vec<u8>) -> Result<bool> {
    bytes.clear();
    from.by_ref().take(count as u64).read_to_end(bytes).map_err(|error| Error::io("", error))?;
    Ok(bytes.len() == count)
}

fn read_chunk(body: &[u8]) -> Option<CompleteChunk> {
    let mut fields = Fields::new(body, 0, "");
    let [stream, unit, first_frame, frame_count] = fields.u32s().ok()?;
    let key = ChunkKey { stream, unit, first_frame, frame_count };
    let (offset, [stored_bytes, raw_bytes, crc32, last_frame]) = (fields.u64().ok()?, fields.u32s().ok()?);
    let storage = Storage::of(fields.u8().ok()?.into())?;
    let entry = ChunkEntry { key, offset, stored_bytes, raw_bytes, crc32, storage };
    entry.check(&fields, 0, u64::MAX).ok()?;
    let has_frames = frame_count > 0 && first_frame.checked_add(frame_count).is_some();
    (has_frames && fields.finish().is_ok()).then_some(CompleteChunk { entry, last_frame })
}

struct Records<'a> {
    bytes: &'a [u8],
    position: usize,
}

impl<'a> Records<'a> {
    fn next(&mut self) -> Option<(u8, &'a [u8])> {
        let mut fields = Fields::new(self.bytes.get(self.position..)?, 0, "");
        let (length, crc32) = (fields.u32().ok()?, fields.u32().ok()?);
        let kind = fields.u8().ok()?;
        let body = fields.bytes(length as usize).ok()?;
        if checksum(kind, body) != crc32 {
            return None;
        }
        self.position += RECORD_HEAD_BYTES + body.len();
        Some((kind, body))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn records_before_the_end_of_the_disk_count() {
        /// A disk with space for some bytes.
        struct Disk(usize);
        impl Write for Disk {
            fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
                let written = bytes.len().min(self.0);
                self.0 -= written;
                if written == 0 { Err(std::io::ErrorKind::StorageFull.into()) } else { Ok(written) }
            }

            fn flush(&mut self) -> std::io::Result<()> {
                Ok(())
            }
        }
        let key = ChunkKey { stream: 0, unit: 1, first_frame: 3, frame_count: 2 };
        let (stored_bytes, raw_bytes, crc32, storage) = (7, 7, 0, Storage::Raw);
        let entry = ChunkEntry { key, offset: 16, stored_bytes, raw_bytes, crc32, storage };
        let chunk = CompleteChunk { entry, last_frame: 4 };
        let record = RECORD_HEAD_BYTES + CHUNK_BYTES;
        let head = MAGIC.len() + RECORD_HEAD_BYTES;
        for (room, count) in [(head, 0), (head + record - 1, 0), (head + record, 1), (head + 2 * record + 5, 2)] {
            let mut journal = Journal::start(Box::new(Disk(room)), b"");
            (0..4).for_each(|_| journal.chunk(&chunk));
            assert!(journal.write().is_err());
            let last = (count > 0).then_some(key);
            assert_eq!(journal.safe(), SafeChunks { count, last }, "{room}");
        }
    }

    #[test]
    fn checking_chunks_stops_when_asked() {
        struct Stops;
        impl Monitor for Stops {
            fn advance(&self, _steps: u64) {}

            fn interrupted(&self) -> bool {
                true
            }
        }
        assert!(matches!(recover_watched(b"records", &b"chunks"[..], &Stops), Err(Error::Interrupted)));
        let mut watched = Watched { from: &b"abc"[..], monitor: &Stops };
        assert!(watched.read_to_end(&mut Vec::new()).is_err(), "it goes on reading");
    }
}
