//! Opens a container and fetches single chunks from it.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::container::chunk::{ChunkEntry, Storage};
use crate::container::header::{self, FOOT_BYTES, Foot, HEAD_BYTES};
use crate::container::index::Index;
use crate::container::lzma2;
use crate::container::payload::Payload;
use crate::error::{Error, Result};

/// What a reader may spend on a file that is not trusted (container.md 2, "What a reader spends").
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct OpenLimits {
    /// Decoding one stream may always take this many bytes.
    pub memory_floor_bytes: u64,
    /// Beyond the floor, it may take this many times the file's size.
    pub memory_ratio: u64,
    /// Units times frames, summed over all streams, may always reach this number.
    pub unit_frames_floor: u64,
    /// Beyond the floor, they may reach this many times the file's bytes.
    pub unit_frames_ratio: u64,
    /// Pixels of all images of all streams may always reach this number.
    pub pixels_floor: u64,
    /// Beyond the floor, they may reach this many times the file's bytes.
    pub pixels_ratio: u64,
}

impl OpenLimits {
    /// 1 GiB or 1,024 times the file; 2²⁶ units in frames and 1,024 more for each byte of the file; 2³⁸ pixels and 2²⁰
    /// more for each byte.
    pub const DEFAULT: OpenLimits = OpenLimits {
        memory_floor_bytes: 1 << 30,
        memory_ratio: 1024,
        unit_frames_floor: 1 << 26,
        unit_frames_ratio: 1024,
        pixels_floor: 1 << 38,
        pixels_ratio: 1 << 20,
    };
    /// For a file that is trusted: whatever the format allows.
    pub const NONE: OpenLimits = OpenLimits {
        memory_floor_bytes: u64::MAX,
        unit_frames_floor: u64::MAX,
        pixels_floor: u64::MAX,
        ..OpenLimits::DEFAULT
    };
    /// All streams together may take so many times what one may.
    const ALL_STREAMS: u64 = 4;

    /// Bytes that decoding one stream of a file of `file_bytes` may take.
    pub fn stream_bytes(&self, file_bytes: u64) -> u64 {
        self.memory_floor_bytes.max(self.memory_ratio.saturating_mul(file_bytes))
    }

    /// Bytes that decoding all streams of a file of `file_bytes` at once may take.
    pub fn all_streams_bytes(&self, file_bytes: u64) -> u64 {
        self.stream_bytes(file_bytes).saturating_mul(Self::ALL_STREAMS)
    }

    /// Units times frames that a file of `file_bytes` may have.
    pub fn unit_frames(&self, file_bytes: u64) -> u64 {
        self.unit_frames_floor.saturating_add(self.unit_frames_ratio.saturating_mul(file_bytes))
    }

    /// Pixels that all images of a file of `file_bytes` may have.
    pub fn pixels(&self, file_bytes: u64) -> u64 {
        self.pixels_floor.saturating_add(self.pixels_ratio.saturating_mul(file_bytes))
    }
}

impl Default for OpenLimits {
    fn default() -> Self {
        OpenLimits::DEFAULT
    }
}

#[derive(Debug)]
enum Bytes {
    File(File),
    Memory(Arc<Vec<u8>>),
}

/// An open container. Shared between threads; every fetch reads just the chunk's own bytes.
#[derive(Debug)]
pub struct Reader {
    path: PathBuf,
    bytes: Bytes,
    file_bytes: u64,
    index_bytes: u64,
    index: Index,
    limits: OpenLimits,
}

impl Reader {
    /// Opens a file, or standard input for `-`, which is read whole.
    pub fn open(path: impl AsRef<Path>) -> Result<Reader> {
        Self::open_with(path, OpenLimits::default())
    }

    /// Opens a file with other limits than the default.
    pub fn open_with(path: impl AsRef<Path>, limits: OpenLimits) -> Result<Reader> {
        let path = path.as_ref();
        let io = |error| Error::io(path, error);
        if path == Path::new("-") {
            let memory = read_stream(std::io::stdin().lock(), "standard input").map_err(|error| error.in_file(path))?;
            return Self::new(path, Bytes::Memory(Arc::new(memory)), limits);
        }
        let file = File::open(path).map_err(io)?;
        let metadata = file.metadata().map_err(io)?;
        if metadata.is_dir() {
            return Err(Error::Usage(format!("{}: a folder, where a .lfold container was expected", path.display())));
        }
        if !metadata.is_file() {
            // A pipe, as a shell's process substitution makes one.
            let memory = read_stream(file, "this file").map_err(|error| error.in_file(path))?;
            return Self::new(path, Bytes::Memory(Arc::new(memory)), limits);
        }
        if metadata.len() == 0 {
            return Err(empty("this file").in_file(path));
        }
        Self::new(path, Bytes::File(file), limits)
    }

    /// Reads the whole file into memory where it has at most `limit_bytes`, so that fetching chunks copies nothing;
    /// answers whether it lies in memory now.
    pub fn load(&mut self, limit_bytes: u64) -> Result<bool> {
        if let Bytes::File(_) = self.bytes
            && self.file_bytes <= limit_bytes
        {
            self.bytes = Bytes::Memory(Arc::new(self.read_at(0, self.file_bytes)?.into_vec()));
        }
        Ok(matches!(self.bytes, Bytes::Memory(_)))
    }

    /// Opens a container that lies in memory.
    pub fn from_memory(memory: Vec<u8>) -> Result<Reader> {
        Self::from_memory_with(memory, OpenLimits::default())
    }

    /// Opens a container that lies in memory, with other limits than the default.
    pub fn from_memory_with(memory: Vec<u8>, limits: OpenLimits) -> Result<Reader> {
        Self::new(Path::new(""), Bytes::Memory(Arc::new(memory)), limits)
    }

    fn new(path: &Path, bytes: Bytes, limits: OpenLimits) -> Result<Reader> {
        let file_bytes = match &bytes {
            Bytes::File(file) => file.metadata().map_err(|error| Error::io(path, error))?.len(),
            Bytes::Memory(memory) => memory.len() as u64,
        };
        let mut reader =
            Reader { path: path.to_path_buf(), bytes, file_bytes, index_bytes: 0, index: Index::default(), limits };
        (reader.index, reader.index_bytes) = reader.read_index(limits).map_err(|error| error.in_file(path))?;
        Ok(reader)
    }

    fn read_index(&self, limits: OpenLimits) -> Result<(Index, u64)> {
        let head = self.read_at(0, self.file_bytes.min(HEAD_BYTES as u64))?;
        header::read_head(&head)?;
        if self.file_bytes < (HEAD_BYTES + FOOT_BYTES) as u64 {
            return Err(Error::invalid_at("container.md 7", self.file_bytes, "the container ends after its head"));
        }
        let foot = self.read_at(self.file_bytes - FOOT_BYTES as u64, FOOT_BYTES as u64)?;
        let foot = Foot::read(&foot, self.file_bytes)?;
        let bytes = self.read_at(foot.index_offset, foot.index_bytes)?;
        if crc32fast::hash(&bytes) != foot.index_crc32 {
            return Err(Error::invalid_at(
                "container.md 4",
                foot.index_offset,
                "the index's CRC-32 does not match: the file is damaged",
            ));
        }
        let index = Index::read(&bytes, foot.index_offset)?;
        justify(&index, self.file_bytes, limits)?;
        Ok((index, foot.index_bytes))
    }

    /// The path it was opened from, `-` for standard input, empty for memory.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The index.
    pub fn index(&self) -> &Index {
        &self.index
    }

    /// What it may spend.
    pub fn limits(&self) -> OpenLimits {
        self.limits
    }

    /// The file's size.
    pub fn file_bytes(&self) -> u64 {
        self.file_bytes
    }

    /// Bytes of the file that lie in memory: all or none.
    pub fn bytes_in_memory(&self) -> u64 {
        match self.bytes {
            Bytes::File(_) => 0,
            Bytes::Memory(_) => self.file_bytes,
        }
    }

    /// Bytes of head, index and foot.
    pub fn overhead_bytes(&self) -> u64 {
        (HEAD_BYTES + FOOT_BYTES) as u64 + self.index_bytes
    }

    /// Where chunks may lie: the offset of the first byte behind the head, and that of the index.
    pub fn payload_area(&self) -> std::ops::Range<u64> {
        let start = HEAD_BYTES as u64;
        start..start + self.file_bytes - self.overhead_bytes()
    }

    /// The stored bytes of a chunk, which match its CRC-32.
    pub fn fetch_stored(&self, chunk: &ChunkEntry) -> Result<Vec<u8>> {
        self.load_stored(chunk).map_err(|error| self.blame(chunk, error))
    }

    /// As [`Self::fetch_stored`], for callers that say themselves which chunk an error came from.
    pub fn load_stored(&self, chunk: &ChunkEntry) -> Result<Vec<u8>> {
        self.load_stored_into(chunk, Vec::new()).map(Payload::into_vec)
    }

    fn load_stored_into(&self, chunk: &ChunkEntry, spare: Vec<u8>) -> Result<Payload> {
        let stored = self.read_at_into(chunk.offset, u64::from(chunk.stored_bytes), spare)?;
        if crc32fast::hash(&stored) != chunk.crc32 {
            return Err(Error::invalid("its CRC-32 does not match: the file is damaged"));
        }
        Ok(stored)
    }

    /// A chunk's payload.
    pub fn fetch(&self, chunk: &ChunkEntry) -> Result<Payload> {
        self.fetch_into(chunk, Vec::new())
    }

    /// A chunk's payload in memory that is no longer needed: fresh memory costs more than reading into it.
    pub fn fetch_into(&self, chunk: &ChunkEntry, spare: Vec<u8>) -> Result<Payload> {
        self.load_into(chunk, spare).map_err(|error| self.blame(chunk, error))
    }

    /// As [`Self::fetch_into`], for callers that say themselves which chunk an error came from.
    pub fn load_into(&self, chunk: &ChunkEntry, spare: Vec<u8>) -> Result<Payload> {
        let stored = self.load_stored_into(chunk, spare)?;
        match chunk.storage {
            Storage::Raw => Ok(stored),
            Storage::Lzma2 => lzma2::decompress(&stored, chunk.raw_bytes).map(Payload::from),
        }
    }

    /// Says which chunk of which file an error came from.
    pub fn blame(&self, chunk: &ChunkEntry, error: Error) -> Error {
        let key = chunk.key;
        let last = key.first_frame + (key.frame_count - 1);
        error
            .context(format!(
                "stream {}, unit {}, frames {}-{last}, chunk at byte {}",
                key.stream, key.unit, key.first_frame, chunk.offset
            ))
            .in_file(&self.path)
    }

    fn read_at(&self, offset: u64, count: u64) -> Result<Payload> {
        self.read_at_into(offset, count, Vec::new())
    }

    fn read_at_into(&self, offset: u64, count: u64, mut spare: Vec<u8>) -> Result<Payload> {
        let past_end = || {
            Error::invalid_at("container.md 3", offset, "the file ends before what it announces").in_file(&self.path)
        };
        if offset.checked_add(count).is_none_or(|end| end > self.file_bytes) {
            return Err(past_end());
        }
        let length = usize::try_from(count).map_err(|_| past_end())?;
        match &self.bytes {
            Bytes::Memory(memory) => Ok(Payload::shared(memory, offset as usize..offset as usize + length)),
            Bytes::File(file) => {
                if spare.len() < length {
                    spare.resize(length, 0);
                }
                read_exact_at(file, &mut spare[..length], offset).map_err(|error| Error::io(&self.path, error))?;
                Ok(Payload::front_of(spare, length))
            }
        }
    }
}

/// What decoding one image of a stream takes at the least: 3 bytes a pixel, which no codec goes below once the image is put
/// together from its units, and the largest payload of each unit.
fn least_bytes(index: &Index, at: u32) -> u64 {
    let stream = &index.streams[at as usize];
    let pixels = u64::from(stream.width) * u64::from(stream.height) * 3;
    pixels.saturating_add(index.held_payload_bytes(at, |bytes| bytes))
}

/// Refuses an index whose images, payloads or frames are more than `limits` allow for a file of `file_bytes`. Decoders
/// know more of a stream, and may refuse more.
pub fn justify(index: &Index, file_bytes: u64, limits: OpenLimits) -> Result<()> {
    let (mut total, mut unit_frames, mut pixels) = (0u64, 0u64, 0u64);
    for (at, stream) in (0..).zip(&index.streams) {
        let bytes = least_bytes(index, at);
        if bytes > limits.stream_bytes(file_bytes) {
            return Err(Error::invalid(format!(
                "stream {at} claims {}x{} pixels and payloads of {} bytes, more than a file of {file_bytes} bytes justifies",
                stream.width,
                stream.height,
                index.held_payload_bytes(at, |bytes| bytes)
            )));
        }
        total = total.saturating_add(bytes);
        let frames = u64::from(stream.frame_count);
        unit_frames = unit_frames.saturating_add(u64::from(stream.unit_count()) * frames);
        pixels = pixels.saturating_add(u64::from(stream.width) * u64::from(stream.height) * frames);
    }
    if total > limits.all_streams_bytes(file_bytes) {
        return Err(Error::invalid(format!(
            "{} streams claim images and payloads of {total} bytes, more than a file of {file_bytes} bytes justifies",
            index.streams.len()
        )));
    }
    if unit_frames > limits.unit_frames(file_bytes) || pixels > limits.pixels(file_bytes) {
        return Err(Error::invalid(format!(
            "the streams claim {unit_frames} units and {pixels} pixels in all their frames, more than a file of \
             {file_bytes} bytes justifies"
        )));
    }
    Ok(())
}

/// What is said of a named input without a single byte, as a command that failed before a pipe leaves it.
fn empty(what: &str) -> Error {
    Error::invalid(format!("{what} is empty, where a .lfold container was expected"))
}

/// Reads a stream to its end, which an endless one that is no container never reaches; errors call it `what`.
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

#[cfg(unix)]
fn read_exact_at(file: &File, bytes: &mut [u8], offset: u64) -> std::io::Result<()> {
    std::os::unix::fs::FileExt::read_exact_at(file, bytes, offset)
}

#[cfg(windows)]
fn read_exact_at(file: &File, mut bytes: &mut [u8], mut offset: u64) -> std::io::Result<()> {
    use std::os::windows::fs::FileExt;
    while !bytes.is_empty() {
        match file.seek_read(bytes, offset)? {
            0 => return Err(std::io::ErrorKind::UnexpectedEof.into()),
            count => {
                bytes = &mut bytes[count..];
                offset += count as u64;
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

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
