//! Compression of chunks, each by itself (container.md 6.1 and 6.2), for random access.

use std::fmt;
use std::io::Write;

use crate::container::chunk::Storage;
use crate::container::lzma2::dictionary_bytes;
use crate::error::{Error, Result};

pub const DEFAULT_LZMA2_LEVEL: u32 = 6;
pub const DEFAULT_ZSTD_LEVEL: u32 = 9;
/// Maximum level; higher levels have windows that container.md 6.2 forbids.
pub const MAX_ZSTD_LEVEL: u32 = 19;

/// Compression method of chunks; a chunk that does not become smaller is stored raw.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Compression {
    /// All chunks are stored raw.
    None,
    /// LZMA2 with a preset of 0 (fast) to 9 (small).
    Lzma2(u32),
    /// Zstandard with a level of 1 (fast) to 19 (small).
    Zstd(u32),
}

impl fmt::Display for Compression {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Compression::None => f.write_str("none"),
            Compression::Lzma2(level) => write!(f, "LZMA2 {level}"),
            Compression::Zstd(level) => write!(f, "Zstandard {level}"),
        }
    }
}

impl Default for Compression {
    fn default() -> Self {
        Compression::Zstd(DEFAULT_ZSTD_LEVEL)
    }
}

/// Main content of a payload, which selects parameters of LZMA2.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum PayloadKind {
    #[default]
    Mixed,
    /// Samples of one byte.
    Bytes,
    /// Fields of odd sizes, such as the nodes of a quadtree.
    Unaligned,
    /// Half floats.
    Words,
    /// Texture blocks of 8 or 16 bytes.
    Blocks,
}

impl PayloadKind {
    /// Parameters lc, lp and pb of LZMA: the contexts of literals depend on bits of the previous byte and on the position in
    /// a block.
    fn lzma_contexts(self) -> [u32; 3] {
        match self {
            PayloadKind::Mixed => [3, 0, 2],
            PayloadKind::Bytes => [4, 0, 0],
            PayloadKind::Unaligned => [3, 0, 0],
            PayloadKind::Words => [2, 1, 1],
            PayloadKind::Blocks => [0, 4, 4],
        }
    }
}

impl Compression {
    /// Compresses a payload. Returns the storage method and the bytes to store.
    #[doc(hidden)]
    pub fn compress(self, raw: Vec<u8>, kind: PayloadKind) -> Result<(Storage, Vec<u8>)> {
        let (storage, stored) = match self {
            Compression::None => return Ok((Storage::Raw, raw)),
            Compression::Lzma2(level) => (Storage::Lzma2, lzma2(&raw, level, kind)?),
            Compression::Zstd(level) => (Storage::Zstd, zstd(&raw, level)?),
        };
        Ok(if stored.len() < raw.len() { (storage, stored) } else { (Storage::Raw, raw) })
    }
}

/// Compresses with `lzma-rust2`, because `lzma-rs` 0.3 writes valid streams without compression.
pub fn lzma2(raw: &[u8], level: u32, kind: PayloadKind) -> Result<Vec<u8>> {
    let raw_bytes = u32::try_from(raw.len()).map_err(|_| Error::unsupported("a chunk of more than 4 GiB"))?;
    let mut options = lzma_rust2::Lzma2Options::with_preset(level);
    options.lzma_options.dict_size = dictionary_bytes(raw_bytes);
    [options.lzma_options.lc, options.lzma_options.lp, options.lzma_options.pb] = kind.lzma_contexts();
    let mut writer = lzma_rust2::Lzma2Writer::new(Vec::new(), options);
    writer.write_all(raw).and_then(|()| writer.finish()).map_err(|source| Error::io("LZMA2 encoder", source))
}

/// Writes one frame with its content size, and without checksum or dictionary, as the library does in one step.
pub fn zstd(raw: &[u8], level: u32) -> Result<Vec<u8>> {
    let level = level.clamp(1, MAX_ZSTD_LEVEL) as i32;
    zstd::bulk::compress(raw, level).map_err(|source| Error::io("Zstandard encoder", source))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::container::chunk::{MAX_EXPANSION, MAX_ZSTD_EXPANSION};

    fn noise(n: u32) -> Vec<u8> {
        (0..n).map(|i| (i.wrapping_mul(2_654_435_761) >> 24) as u8).collect()
    }

    fn inputs() -> Vec<Vec<u8>> {
        vec![vec![], vec![7], vec![0; 300_000], noise(70_000), noise(3), noise(1000).repeat(40)]
    }

    #[test]
    fn both_decoders_of_lzma2_give_back_what_was_compressed() {
        let decompress = crate::container::lzma2::decompress;
        let independent = crate::container::lzma2::decompress_independent;
        for (raw, kind) in inputs().iter().flat_map(|raw| {
            [PayloadKind::Mixed, PayloadKind::Bytes, PayloadKind::Words, PayloadKind::Blocks].map(|kind| (raw, kind))
        }) {
            let stored = lzma2(raw, 6, kind).unwrap();
            assert_eq!(decompress(&stored, raw.len() as u32).unwrap(), *raw);
            assert_eq!(independent(&stored, raw.len() as u32).unwrap(), *raw);
            assert!(decompress(&stored, raw.len() as u32 + 1).is_err());
            assert!(decompress(&[&stored[..], &[0]].concat(), raw.len() as u32).is_err());
            if !raw.is_empty() {
                assert!(decompress(&stored, raw.len() as u32 - 1).is_err());
                assert!(decompress(&stored[..stored.len() / 2], raw.len() as u32).is_err());
            }
        }
        let zeros = lzma2(&vec![0; 1 << 20], 6, PayloadKind::Mixed).unwrap();
        assert!((1u64 << 20) < zeros.len() as u64 * MAX_EXPANSION);
    }

    #[test]
    fn both_decoders_of_zstd_give_back_what_was_compressed() {
        let decompress = crate::container::zstd::decompress;
        let independent = crate::container::zstd::decompress_independent;
        for (raw, level) in inputs().iter().flat_map(|raw| [1, 9, 19].map(|level| (raw, level))) {
            let stored = zstd(raw, level).unwrap();
            let raw_bytes = raw.len() as u32;
            assert_eq!(decompress(&stored, raw_bytes).unwrap(), *raw);
            assert_eq!(independent(&stored, raw_bytes).unwrap(), *raw);
            assert!(decompress(&stored, raw_bytes + 1).is_err());
            assert!(decompress(&[&stored[..], &[0]].concat(), raw_bytes).is_err());
            // A second frame, which is empty.
            assert!(decompress(&[stored.clone(), zstd(&[], 1).unwrap()].concat(), raw_bytes).is_err());
            assert!(decompress(&stored[..stored.len() - 1], raw_bytes).is_err());
        }
        let zeros = zstd(&vec![0; 64 << 20], 19).unwrap();
        assert!((64u64 << 20) < zeros.len() as u64 * MAX_ZSTD_EXPANSION, "{} bytes", zeros.len());
    }

    #[test]
    fn a_chunk_that_does_not_become_smaller_stays_raw() {
        for compression in [Compression::None, Compression::Lzma2(6), Compression::Zstd(9)] {
            assert_eq!(compression.compress(noise(200), PayloadKind::Mixed).unwrap(), (Storage::Raw, noise(200)));
        }
        let zeros = |compression: Compression| compression.compress(vec![0; 500], PayloadKind::Mixed).unwrap().0;
        assert_eq!(zeros(Compression::Lzma2(6)), Storage::Lzma2);
        assert_eq!(zeros(Compression::Zstd(9)), Storage::Zstd);
    }
}
