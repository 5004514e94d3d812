//! LZMA2 decompression of chunk payloads (container.md 6.1): raw LZMA2 without xz framing, because the container has its own
//! CRC-32s.
//!
//! Each chunk is compressed by itself, for random access. CALF compresses the data set as a whole.

use std::io::Read;

use crate::error::{Error, Result};

const MIN_DICTIONARY: u32 = 1 << 12;
/// Maximum dictionary size of a container in bytes, which limits the memory of a reader.
const MAX_DICTIONARY: u32 = 1 << 24;

/// Dictionary size of a payload in bytes: the next power of two, from 4 KiB to 16 MiB.
pub fn dictionary_bytes(raw_bytes: u32) -> u32 {
    raw_bytes.clamp(MIN_DICTIONARY, MAX_DICTIONARY).next_power_of_two()
}

/// Decompresses exactly `raw_bytes` bytes. Memory grows with the output.
pub fn decompress(stored: &[u8], raw_bytes: u32) -> Result<Vec<u8>> {
    let mut reader = lzma_rust2::Lzma2Reader::new(stored, dictionary_bytes(raw_bytes), None);
    let mut raw = Vec::new();
    // Reads one byte more than expected, to detect a stream that is too long.
    (&mut reader)
        .take(u64::from(raw_bytes) + 1)
        .read_to_end(&mut raw)
        .map_err(|error| Error::invalid(format!("the chunk's LZMA2 stream is damaged: {error}")))?;
    if raw.len() != raw_bytes as usize {
        return Err(Error::invalid(format!(
            "the chunk's LZMA2 stream does not decompress to the {raw_bytes} bytes that the chunk table states"
        )));
    }
    match reader.inner().len() {
        0 => Ok(raw),
        left => Err(Error::invalid(format!("{left} bytes follow the end of the chunk's LZMA2 stream"))),
    }
}

/// Decompresses with a second decoder, `lzma-rs`, with which verification compares the first: at most `raw_bytes` bytes, the size
/// that the first has found.
#[cfg(feature = "encode")]
pub fn decompress_independent(stored: &[u8], raw_bytes: u32) -> Result<Vec<u8>> {
    let mut raw = vec![0; raw_bytes as usize];
    let mut left = raw.as_mut_slice();
    lzma_rs::lzma2_decompress(&mut std::io::BufReader::new(stored), &mut left)
        .map_err(|error| Error::invalid(format!("the second LZMA2 decoder refuses the chunk: {error:?}")))?;
    let unused = left.len();
    raw.truncate(raw_bytes as usize - unused);
    Ok(raw)
}
