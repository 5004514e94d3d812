//! A second LZMA2 decoder, which verification compares with the first.

use std::io::Write;

use crate::error::{Error, Result};

struct Capped {
    raw: Vec<u8>,
    most: usize,
}

impl Write for Capped {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        if bytes.len() > self.most - self.raw.len() {
            return Err(std::io::Error::other("more comes out than the table says"));
        }
        self.raw.extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

/// Decompresses at most `raw_bytes` by `lzma-rs`.
pub fn decompress_independent(stored: &[u8], raw_bytes: u32) -> Result<Vec<u8>> {
    let mut capped = Capped { raw: Vec::new(), most: raw_bytes as usize };
    lzma_rs::lzma2_decompress(&mut std::io::BufReader::new(stored), &mut capped)
        .map_err(|error| Error::invalid(format!("the second LZMA2 decoder refuses the chunk: {error:?}")))?;
    Ok(capped.raw)
}
