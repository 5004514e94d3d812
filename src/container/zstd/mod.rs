//! Decompresses Zstandard chunks (container.md 6.2): one frame of RFC 8878, of which every rule is enforced.
//!
//! The decoder is ours since no library refuses all that the RFC forbids, and readers must agree about every frame. libzstd ignores
//! what is left of a Huffman stream and matches that leave the window; `ruzstd` ignores the window, the sizes of the four streams,
//! and reserved bits. It is as fast as libzstd on chunks of quadtrees, and `ruzstd` takes twice as long. `inspect --verify` compares it with
//! `ruzstd`, and tests with both.

mod bits;
mod frame;
mod fse;
mod huffman;
mod literals;
mod sequences;

use crate::error::Result;

/// Largest window of a frame.
pub const MAX_WINDOW_BYTES: u64 = 1 << 24;

/// Decompresses exactly `raw_bytes`, which are reserved at once.
///
/// # Errors
/// A frame that breaks RFC 8878 or container.md 6.2, holds more or fewer bytes, or is followed by others.
pub fn decompress(stored: &[u8], raw_bytes: u32) -> Result<Vec<u8>> {
    frame::decode(stored, raw_bytes, MAX_WINDOW_BYTES)
}
