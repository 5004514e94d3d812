//! A second Zstandard decoder, with which verification compares the first.

use crate::container::zstd::MAX_WINDOW_BYTES;
use crate::error::{Error, Result};

/// Decompresses at most `raw_bytes` bytes, the size that the first decoder has found, with `ruzstd`.
pub fn decompress_independent(stored: &[u8], raw_bytes: u32) -> Result<Vec<u8>> {
    let mut decoder = ruzstd::decoding::FrameDecoder::new();
    decoder.set_max_window_size(MAX_WINDOW_BYTES);
    let mut raw = vec![0; raw_bytes as usize];
    let count = decoder
        .decode_all(stored, &mut raw)
        .map_err(|error| Error::invalid(format!("the second Zstandard decoder refuses the chunk: {error}")))?;
    raw.truncate(count);
    Ok(raw)
}
