//! A second LZMA2 decoder, with which verification compares the first.

use crate::error::{Error, Result};

/// Decompresses at most `raw_bytes` bytes, the size that the first decoder has found, with `lzma-rs`.
pub fn decompress_independent(stored: &[u8], raw_bytes: u32) -> Result<Vec<u8>> {
    let mut raw = vec![0; raw_bytes as usize];
    let mut left = raw.as_mut_slice();
    lzma_rs::lzma2_decompress(&mut std::io::BufReader::new(stored), &mut left)
        .map_err(|error| Error::invalid(format!("the second LZMA2 decoder refuses the chunk: {error:?}")))?;
    let unused = left.len();
    raw.truncate(raw_bytes as usize - unused);
    Ok(raw)
}
