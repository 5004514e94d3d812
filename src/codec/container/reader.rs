//! Opens a container and fetches single chunks.

use std::fs::File;
use std::io::{ErrorKind, Read};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::container::chunk::{ChunkEntry, ChunkKey, Storage};
use crate::container::header::{self, FOOT_BYTES, FOOT_MAGIC, Foot, HEAD_BYTES};
use crate::container::index::Index;
use crate::container::index_read::read_as_written;
use crate::container::limits::{self, OpenLimits};
use crate::container::payload::Payload;
use crate::container::source::ByteSource;
use crate::container::{lzma2, zstd};
use crate::error::{Error, Result};

/// Number of bytes at the end of a file that are searched for a foot with bytes after it.
const FOOT_SEARCH_BYTES: u64 = 1 << 16;

/// An open container, shared between threads. A fetch reads only the bytes of the chunk.
#[derive(Debug)]
pub struct Reader {
    path: PathBuf,
    source: Box<dyn ByteSource>,
    pub file_bytes: u64,
    index_bytes: u64,
    pub minor_version: u16,
    index: Index,
    pub limits: OpenLimits,
}

impl Reader {
    /// Opens a file, or standard input for `-`, which is read completely.
    pub fn open(path: impl AsRef<Path>) -> Result<Reader> {
        let (path, limits) = (path.as_ref(), OpenLimits::default());
        let io = |error| Error::io(path, error);
        let whole = |memory: Result<Vec<u8>>| {
            Self::from_source(Arc::new(memory.map_err(|error| error.in_file(path))?), path, limits)
        };
        if path == Path::new("-") {
            return whole(read_stream(std::io::stdin().lock(), "standard input"));
        }
        let file = File::open(path).map_err(io)?;
        let metadata = file.metadata().map_err(io)?;
        if metadata.is_dir() {
            return Err(Error::Usage(format!("{}: a folder, where a .lfold container was expected", path.display())));
        }
        if !metadata.is_file() {
            // A pipe, such as a shell's process substitution.
            return whole(read_stream(file, "this file"));
        }
        if metadata.len() == 0 {
            return Err(empty("this file").in_file(path));
        }
        Self::from_source(file, path, limits)
    }

    pub fn from_memory(memory: Vec<u8>) -> Result<Reader> {
        Self::from_source(Arc::new(memory), "", OpenLimits::default())
    }

    /// Opens a container in any source. Errors name it `path`.
    pub fn from_source(
        source: impl ByteSource + 'static,
        path: impl AsRef<Path>,
        limits: OpenLimits,
    ) -> Result<Reader> {
        let path = path.as_ref().to_path_buf();
        let file_bytes = source.byte_count().map_err(|error| Error::io(&path, error))?;
        let (source, index) = (Box::new(source), Index::default());
        let mut reader = Reader { path, source, file_bytes, index_bytes: 0, minor_version: 0, index, limits };
        reader.read_index().map_err(|error| error.in_file(&reader.path))?;
        Ok(reader)
    }

    /// Reads a source of at most `limit_bytes` bytes into memory. Returns true if the source is in memory.
    pub fn load(&mut self, limit_bytes: u64) -> Result<bool> {
        if self.source.memory().is_none() && self.file_bytes <= limit_bytes {
            self.source = Box::new(Arc::new(self.read_at(0, self.file_bytes, Vec::new())?.into_vec()));
        }
        Ok(self.source.memory().is_some())
    }

    fn read_index(&mut self) -> Result<()> {
        let head = self.read_at(0, self.file_bytes.min(HEAD_BYTES as u64), Vec::new())?;
        self.minor_version = header::read_head(&head)?;
        if self.file_bytes < (HEAD_BYTES + FOOT_BYTES) as u64 {
            return Err(Error::invalid_at("container.md 7", self.file_bytes, "the container ends after its head"));
        }
        let (foot, bytes) = self.read_index_bytes()?;
        let index = Index::read(&bytes, foot.index_offset).map_err(|error| match self.minor_version {
            ..=header::VERSION_MINOR => error,
            later => error.context(format!("format version {}.{later}, newer than supported", header::VERSION_MAJOR)),
        })?;
        limits::check(&index, self.file_bytes, self.limits)?;
        (self.index, self.index_bytes) = (index, foot.index_bytes);
        Ok(())
    }

    fn read_index_bytes(&self) -> Result<(Foot, Payload)> {
        let foot = self.read_foot()?;
        let bytes = self.read_at(foot.index_offset, foot.index_bytes, Vec::new())?;
        if crc32fast::hash(&bytes) != foot.index_crc32 {
            let message = "the index's CRC-32 does not match: the file is damaged";
            return Err(Error::invalid_at("container.md 4", foot.index_offset, message));
        }
        Ok((foot, bytes))
    }

    /// Reads the index again and returns the chunks in the order in which they were written.
    pub fn chunks_as_written(&self) -> Result<Vec<ChunkEntry>> {
        let (foot, bytes) = self.read_index_bytes()?;
        Ok(read_as_written(&bytes, foot.index_offset)?.chunks)
    }

    /// Reads the foot at the end of the file. If the foot lies before the end, the error states the number of bytes after it.
    fn read_foot(&self) -> Result<Foot> {
        let start = self.file_bytes - FOOT_BYTES as u64;
        Foot::read(&self.read_at(start, FOOT_BYTES as u64, Vec::new())?, self.file_bytes).map_err(|error| {
            let first = start.saturating_sub(FOOT_SEARCH_BYTES);
            let Ok(tail) = self.read_at(first, self.file_bytes - first, Vec::new()) else { return error };
            let feet = tail.windows(FOOT_BYTES).enumerate().filter(|(_, bytes)| bytes.ends_with(&FOOT_MAGIC));
            let mut ends = feet.map(|(at, bytes)| (first + (at + FOOT_BYTES) as u64, bytes));
            let end = ends.rfind(|&(end, bytes)| end < self.file_bytes && Foot::read(bytes, end).is_ok());
            end.map_or(error, |(end, _)| {
                let more = self.file_bytes - end;
                Error::invalid_at("container.md 7", end, format!("the container ends here, and {more} bytes follow it"))
            })
        })
    }

    /// Path that the container was opened from; `-` for standard input, empty for memory.
    pub fn path(&self) -> &Path {
        &self.path
    }

    pub fn index(&self) -> &Index {
        &self.index
    }

    pub fn bytes_in_memory(&self) -> u64 {
        if self.source.memory().is_some() { self.file_bytes } else { 0 }
    }

    pub fn overhead_bytes(&self) -> u64 {
        (HEAD_BYTES + FOOT_BYTES) as u64 + self.index_bytes
    }

    pub fn fetch_stored(&self, chunk: &ChunkEntry) -> Result<Vec<u8>> {
        self.load_stored(chunk).map_err(|error| self.blame(chunk, error))
    }

    /// As [`Self::fetch_stored`], but errors do not name the chunk.
    pub fn load_stored(&self, chunk: &ChunkEntry) -> Result<Vec<u8>> {
        self.load_stored_into(chunk, Vec::new()).map(Payload::into_vec)
    }

    /// As [`Self::fetch_stored`], for contiguous chunks with a single read.
    pub fn fetch_stored_run(&self, chunks: &[ChunkEntry]) -> Result<Vec<Payload>> {
        let Some(first) = chunks.first() else { return Ok(Vec::new()) };
        let lengths = || chunks.iter().map(|chunk| chunk.stored_bytes);
        let bytes = lengths().map(u64::from).sum();
        let run = self.read_at(first.offset, bytes, Vec::new()).map_err(|error| self.blame(first, error))?;
        let parts = run.split(lengths().map(|bytes| bytes as usize));
        for (chunk, stored) in chunks.iter().zip(&parts) {
            check_crc(chunk, stored).map_err(|error| self.blame(chunk, error))?;
        }
        Ok(parts)
    }

    fn load_stored_into(&self, chunk: &ChunkEntry, spare: Vec<u8>) -> Result<Payload> {
        let stored = self.read_at(chunk.offset, u64::from(chunk.stored_bytes), spare)?;
        check_crc(chunk, &stored).map(|()| stored)
    }

    pub fn fetch(&self, chunk: &ChunkEntry) -> Result<Payload> {
        self.load_into(chunk, Vec::new()).map_err(|error| self.blame(chunk, error))
    }

    /// Returns a chunk's payload, read into `spare` memory. Errors do not name the chunk.
    pub fn load_into(&self, chunk: &ChunkEntry, spare: Vec<u8>) -> Result<Payload> {
        let stored = self.load_stored_into(chunk, spare)?;
        match chunk.storage {
            Storage::Raw => Ok(stored),
            Storage::Lzma2 => lzma2::decompress(&stored, chunk.raw_bytes).map(Payload::from),
            Storage::Zstd => zstd::decompress(&stored, chunk.raw_bytes).map(Payload::from),
        }
    }

    /// Adds the names of the chunk and the file to an error.
    pub fn blame(&self, chunk: &ChunkEntry, error: Error) -> Error {
        let (ChunkKey { stream, unit, first_frame, .. }, last) = (chunk.key, chunk.key.last_frame());
        let place =
            format!("stream {stream}, unit {unit}, frames {first_frame}-{last}, chunk at byte {}", chunk.offset);
        error.context(place).in_file(&self.path)
    }

    /// Returns `count` bytes from `offset` on: a range of the source's memory, or bytes read into `spare`.
    fn read_at(&self, offset: u64, count: u64, mut spare: Vec<u8>) -> Result<Payload> {
        let past_end = || {
            Error::invalid_at("container.md 3", offset, "the file is truncated: it ends before data that it refers to")
                .in_file(&self.path)
        };
        if offset.checked_add(count).is_none_or(|end| end > self.file_bytes) {
            return Err(past_end());
        }
        let length = usize::try_from(count).map_err(|_| past_end())?;
        // Memory of a much larger chunk is freed, and does not add to that of the decompressed chunk.
        if spare.capacity() > 2 * length {
            spare = Vec::new();
        }
        if let Some(memory) = self.source.memory() {
            return Ok(Payload::shared(memory, offset as usize..offset as usize + length));
        }
        if spare.len() < length {
            spare.resize(length, 0);
        }
        self.source.read_at(offset, &mut spare[..length]).map_err(|error| match error.kind() {
            ErrorKind::UnexpectedEof => past_end(),
            _ => Error::io(&self.path, error),
        })?;
        Ok(Payload::front_of(spare, length))
    }
}

fn check_crc(chunk: &ChunkEntry, stored: &[u8]) -> Result<()> {
    match crc32fast::hash(stored) == chunk.crc32 {
        true => Ok(()),
        false => Err(Error::invalid("its CRC-32 does not match: the file is damaged")),
    }
}

/// Error for an input without bytes, such as a pipe from a command that failed.
fn empty(what: &str) -> Error {
    Error::invalid(format!("{what} is empty, where a .lfold container was expected"))
}

/// Reads a stream to its end. Fails early if its head is not that of a container.
fn read_stream(mut stream: impl Read, what: &str) -> Result<Vec<u8>> {
    let io = |error| Error::io("", error);
    let mut memory = Vec::new();
    stream.by_ref().take(HEAD_BYTES as u64).read_to_end(&mut memory).map_err(io)?;
    if memory.is_empty() {
        return Err(empty(what));
    }
    header::read_head(&memory)?;
    stream.read_to_end(&mut memory).map_err(io)?;
    Ok(memory)
}

#[cfg(feature = "encode")]
#[cfg(test)]
mod tests {
    use super::*;
    use crate::container::chunk::ChunkKey;
    use crate::container::compression::{Compression, PayloadKind};
    use crate::container::index::{ProbeEntry, StreamEntry};
    use crate::container::writer::{PackedChunk, Writer};

    /// A source without shared memory that fails, or ends, at byte `from`.
    #[derive(Debug)]
    struct Broken {
        bytes: Vec<u8>,
        from: u64,
        kind: ErrorKind,
    }

    impl ByteSource for Broken {
        fn byte_count(&self) -> std::io::Result<u64> {
            Ok(self.bytes.len() as u64)
        }

        fn read_at(&self, offset: u64, bytes: &mut [u8]) -> std::io::Result<()> {
            let end = offset as usize + bytes.len();
            if end as u64 > self.from {
                return Err(self.kind.into());
            }
            bytes.copy_from_slice(&self.bytes[offset as usize..end]);
            Ok(())
        }
    }

    /// One stream of three chunks, two of them compressed.
    fn sample() -> Vec<u8> {
        let mut writer = Writer::new(Vec::new(), "sample", 24.0, 0).unwrap();
        let (position, orientation, intrinsics) = ([0.0; 3], [0.0, 0.0, 0.0, 1.0], [0.0; 4]);
        let probe = ProbeEntry { name: "00".into(), position, orientation, frames: [0, 2], intrinsics };
        let probe = writer.add_probe(probe).unwrap();
        writer.add_stream(StreamEntry {
            kind: 1,
            face: 0,
            probe,
            codec: *b"TEST",
            width: 8,
            height: 8,
            first_frame: 0,
            frame_count: 3,
            unit_width: 8,
            unit_height: 8,
            codec_header: Arc::default(),
        });
        let compressions = [Compression::None, Compression::Lzma2(6), Compression::Zstd(9)];
        for (first_frame, compression) in (0..).zip(compressions) {
            let key = ChunkKey { stream: 0, unit: 0, first_frame, frame_count: 1 };
            writer
                .push(&PackedChunk::new(key, vec![first_frame as u8; 500], (compression, PayloadKind::Mixed)).unwrap())
                .unwrap();
        }
        writer.finish().unwrap().0
    }

    #[test]
    fn all_sources_give_the_same_bytes() {
        let (folder, bytes) = (tempfile::tempdir().unwrap(), sample());
        let path = folder.path().join("sample.lfold");
        std::fs::write(&path, &bytes).unwrap();
        let leaked: &'static [u8] = bytes.clone().leak();
        let other = Broken { bytes: bytes.clone(), from: u64::MAX, kind: ErrorKind::Other };
        let mut loaded = Reader::open(&path).unwrap();
        assert!(!loaded.load(bytes.len() as u64 - 1).unwrap() && loaded.load(bytes.len() as u64).unwrap());
        let readers = [
            Reader::open(&path).unwrap(),
            loaded,
            Reader::from_memory(bytes.clone()).unwrap(),
            Reader::from_source(leaked, "", OpenLimits::DEFAULT).unwrap(),
            Reader::from_source(other, "", OpenLimits::DEFAULT).unwrap(),
        ];
        assert_eq!(readers.each_ref().map(|reader| reader.bytes_in_memory() > 0), [false, true, true, false, false]);
        for reader in &readers {
            assert_eq!(reader.index(), readers[0].index());
            for (chunk, value) in reader.index().chunks.iter().zip([0, 1, 2]) {
                assert_eq!(*reader.fetch(chunk).unwrap(), [value; 500]);
                assert_eq!(reader.fetch_stored(chunk).unwrap(), readers[0].fetch_stored(chunk).unwrap());
            }
        }
    }

    #[test]
    fn a_source_that_fails_or_is_short_gives_one_error() {
        let bytes = sample();
        let open = |from, kind| {
            Reader::from_source(Broken { bytes: bytes.clone(), from, kind }, "x.lfold", OpenLimits::DEFAULT)
        };
        let message = open(100, ErrorKind::UnexpectedEof).unwrap_err().to_string();
        assert!(message.starts_with("x.lfold: at byte ") && message.contains("the file is truncated"), "{message}");
        let message = open(100, ErrorKind::TimedOut).unwrap_err().to_string();
        assert_eq!(message, "x.lfold: timed out");
        // Opened while the source was complete.
        let mut reader = open(u64::MAX, ErrorKind::Other).unwrap();
        reader.source = Box::new(Broken { bytes: bytes.clone(), from: 20, kind: ErrorKind::UnexpectedEof });
        let message = reader.fetch(&reader.index().chunks[0]).unwrap_err().to_string();
        assert!(
            message.contains("stream 0, unit 0, frames 0-0") && message.contains("the file is truncated"),
            "{message}"
        );
    }

    #[test]
    fn bytes_after_the_end_are_counted() {
        let bytes = sample();
        for more in [1, 40, 5000] {
            let longer = [&bytes[..], &vec![7; more]].concat();
            let message = Reader::from_memory(longer).unwrap_err().to_string();
            assert!(message.contains(&format!("ends here, and {more} bytes follow it")), "{message}");
        }
        let message = Reader::from_memory(bytes[..bytes.len() - 1].to_vec()).unwrap_err().to_string();
        assert!(message.contains("is truncated"), "{message}");
    }

    #[test]
    fn a_later_minor_version_opens_and_is_named_in_errors() {
        let mut bytes = sample();
        bytes[10] = 3;
        let reader = Reader::from_memory(bytes.clone()).unwrap();
        assert_eq!(reader.minor_version, 3);
    }

    #[test]
    fn an_empty_input_is_called_empty() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("none.lfold");
        std::fs::write(&path, b"").unwrap();
        let message = Reader::open(&path).unwrap_err().to_string();
        let words = "none.lfold: this file is empty, where a .lfold container was expected";
        assert!(message.ends_with(words), "{message}");
        let message = read_stream(&b""[..], "standard input").unwrap_err().in_file("-").to_string();
        assert_eq!(message, "-: standard input is empty, where a .lfold container was expected");
    }
}
