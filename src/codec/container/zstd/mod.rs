//! Zstandard decompression of chunks (container.md 6.2): one frame of RFC 8878, with every rule enforced.
//!
//! We have our own decoder because no library refuses all that the RFC forbids, and readers must agree about every frame.
//! libzstd ignores bits that remain in a Huffman stream, and matches outside the window; `ruzstd` ignores the window, the
//! sizes of the four streams, and reserved bits. On chunks of quadtrees this decoder is as fast as libzstd; `ruzstd` takes
//! twice as long. `inspect --verify` compares it with `ruzstd`, and tests compare it with both.

mod bits;
mod frame;
mod fse;
mod huffman;
mod literals;
mod sequences;

#[cfg(feature = "encode")]
pub use frame::decompress_independent;
pub use frame::{MAX_WINDOW_BYTES, decompress};
