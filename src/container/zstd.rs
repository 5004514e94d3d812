//! Decompresses Zstandard chunks (container.md 6.2).

use crate::container::fields::Fields;
use crate::error::{Error, Result};

const MAGIC: u32 = 0xfd2f_b528;
/// Largest window of a frame, which bounds the memory of a reader.
pub const MAX_WINDOW_BYTES: u64 = 1 << 24;

/// Decompresses exactly `raw_bytes`.
pub fn decompress(stored: &[u8], raw_bytes: u32) -> Result<Vec<u8>> {
    check_frame(stored, raw_bytes)?;
    let damaged =
        |error: &dyn std::fmt::Display| Error::invalid(format!("the chunk's Zstandard frame is damaged: {error}"));
    // The library decodes frames that follow each other as one.
    let frame_bytes = zstd::zstd_safe::find_frame_compressed_size(stored)
        .map_err(|code| damaged(&zstd::zstd_safe::get_error_name(code)))?;
    if frame_bytes != stored.len() {
        let left = stored.len() - frame_bytes;
        return Err(Error::invalid(format!("{left} bytes follow the end of the chunk's Zstandard frame")));
    }
    let raw = zstd::bulk::decompress(stored, raw_bytes as usize).map_err(|error| damaged(&error))?;
    if raw.len() != raw_bytes as usize {
        return Err(size_differs(raw_bytes));
    }
    Ok(raw)
}

fn size_differs(raw_bytes: u32) -> Error {
    Error::invalid(format!("the chunk's Zstandard frame does not mean the {raw_bytes} bytes that the table says"))
}

/// Checks the header of a frame (RFC 8878, 3.1.1.1): its content size, window, and that it has neither dictionary nor
/// checksum.
fn check_frame(stored: &[u8], raw_bytes: u32) -> Result<()> {
    let mut fields = Fields::new(stored, 0, "container.md 6.2");
    if fields.u32()? != MAGIC {
        return Err(Error::invalid("the chunk's Zstandard frame is damaged: its magic number is other"));
    }
    let descriptor = fields.u8()?;
    if descriptor & 0x1f != 0 {
        return Err(Error::invalid("the chunk's Zstandard frame has a dictionary, a checksum or reserved bits"));
    }
    let single_segment = descriptor & 0x20 != 0;
    let window = if single_segment {
        u64::from(raw_bytes)
    } else {
        let byte = fields.u8()?;
        let base = 1u64 << (10 + u64::from(byte >> 3));
        base + base / 8 * u64::from(byte & 7)
    };
    if window > MAX_WINDOW_BYTES {
        return Err(Error::invalid(format!(
            "the chunk's Zstandard frame has a window of {window} bytes, {MAX_WINDOW_BYTES} at most"
        )));
    }
    let content = match descriptor >> 6 {
        0 if single_segment => fields.u8()?.into(),
        0 => return Err(Error::invalid("the chunk's Zstandard frame lacks its content size")),
        1 => u64::from(fields.u16()?) + 256,
        2 => fields.u32()?.into(),
        _ => fields.u64()?,
    };
    if content == u64::from(raw_bytes) { Ok(()) } else { Err(size_differs(raw_bytes)) }
}
