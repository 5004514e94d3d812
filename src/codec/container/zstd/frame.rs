//! Frames and their blocks (RFC 8878, 3.1.1).

use super::bits::damaged;
use super::huffman::Table;
use super::literals;
use super::sequences::{Bounds, State};
use crate::container::fields::Fields;
use crate::error::{Error, Result};

const MAGIC: u32 = 0xfd2f_b528;
/// Maximum window of a frame in bytes.
pub const MAX_WINDOW_BYTES: u64 = 1 << 24;
const MAX_BLOCK_BYTES: u64 = 1 << 17;
const SECTION: &str = "container.md 6.2";

/// Decompresses exactly `raw_bytes` bytes, for which memory is reserved at once.
///
/// # Errors
/// If the frame breaks RFC 8878 or container.md 6.2, has more or fewer bytes, or is followed by other bytes.
pub fn decompress(stored: &[u8], raw_bytes: u32) -> Result<Vec<u8>> {
    decode(stored, raw_bytes, MAX_WINDOW_BYTES)
}

/// Decompresses with a second decoder, `ruzstd`, with which verification compares the first: at most `raw_bytes` bytes, the size
/// that the first has found.
#[cfg(feature = "encode")]
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

/// Decodes a frame of exactly `raw_bytes` bytes with a window of at most `max_window` bytes.
fn decode(stored: &[u8], raw_bytes: u32, max_window: u64) -> Result<Vec<u8>> {
    let mut fields = Fields::new(stored, 0, SECTION);
    let window = read_header(&mut fields, raw_bytes, max_window)?;
    let max_block = window.min(MAX_BLOCK_BYTES) as usize;
    let raw_bytes_found = raw_bytes as usize;
    let mut out = Vec::with_capacity(raw_bytes_found);
    let (mut table, mut sequences, mut literals) = (None::<Table>, State::new(), Vec::new());
    loop {
        let head = early(fields.bytes(3))?;
        let head = u32::from_le_bytes([head[0], head[1], head[2], 0]);
        let (kind, size) = (head >> 1 & 3, (head >> 3) as usize);
        if kind == 3 || size > max_block {
            return Err(damaged("a block is illegal"));
        }
        let end = raw_bytes_found.min(out.len() + max_block);
        if kind < 2 && size > end - out.len() {
            return Err(size_differs(raw_bytes));
        }
        match kind {
            0 => out.extend_from_slice(early(fields.bytes(size))?),
            1 => out.resize(out.len() + size, early(fields.u8())?),
            _ => {
                let block = early(fields.bytes(size))?;
                let used = literals::read(block, &mut table, &mut literals, max_block)?;
                sequences.write(&block[used..], &literals, &mut out, Bounds { window: window as usize, end })?;
            }
        }
        if head & 1 == 1 {
            break;
        }
    }
    match fields.remaining() {
        0 if out.len() == raw_bytes_found => Ok(out),
        0 => Err(size_differs(raw_bytes)),
        left => Err(Error::invalid(format!("{left} bytes follow the end of the chunk's Zstandard frame"))),
    }
}

fn early<T>(read: Result<T>) -> Result<T> {
    read.map_err(|_| damaged("it ends early"))
}

fn size_differs(raw_bytes: u32) -> Error {
    Error::invalid(format!(
        "the chunk's Zstandard frame does not decompress to the {raw_bytes} bytes that the chunk table states"
    ))
}

/// Reads the header (RFC 8878, 3.1.1.1) and returns the window size in bytes. Checks the content size and the window, and
/// that there is neither a dictionary nor a checksum.
fn read_header(fields: &mut Fields<'_>, raw_bytes: u32, max_window: u64) -> Result<u64> {
    if early(fields.u32())? != MAGIC {
        return Err(damaged("its magic number is wrong"));
    }
    let descriptor = early(fields.u8())?;
    if descriptor & 0x1f != 0 {
        return Err(Error::invalid("the chunk's Zstandard frame has a dictionary, a checksum or reserved bits"));
    }
    let single_segment = descriptor & 0x20 != 0;
    let window = if single_segment {
        u64::from(raw_bytes)
    } else {
        let byte = early(fields.u8())?;
        let base = 1u64 << (10 + u64::from(byte >> 3));
        base + base / 8 * u64::from(byte & 7)
    };
    if window > max_window {
        return Err(Error::invalid(format!(
            "the chunk's Zstandard frame has a window of {window} bytes, {max_window} at most"
        )));
    }
    let content = match descriptor >> 6 {
        0 if single_segment => early(fields.u8())?.into(),
        0 => return Err(Error::invalid("the chunk's Zstandard frame lacks its content size")),
        1 => u64::from(early(fields.u16())?) + 256,
        2 => early(fields.u32())?.into(),
        _ => early(fields.u64())?,
    };
    if content == u64::from(raw_bytes) { Ok(window) } else { Err(size_differs(raw_bytes)) }
}
