//! Compresses chunk payloads (container.md 6.1), by `lzma-rust2`: `lzma-rs` 0.3 writes valid streams that store.

use std::io::Write;

use crate::container::lzma2::dictionary_bytes;
use crate::error::{Error, Result};

pub const DEFAULT_LEVEL: u32 = 6;

/// Compresses at a preset of 0 (fast) to 9 (small).
pub fn compress(raw: &[u8], level: u32) -> Result<Vec<u8>> {
    let raw_bytes = u32::try_from(raw.len()).map_err(|_| Error::unsupported("a chunk of more than 4 GiB"))?;
    let mut options = lzma_rust2::Lzma2Options::with_preset(level);
    options.lzma_options.dict_size = dictionary_bytes(raw_bytes);
    let mut writer = lzma_rust2::Lzma2Writer::new(Vec::new(), options);
    writer.write_all(raw).and_then(|()| writer.finish()).map_err(|source| Error::io("LZMA2 encoder", source))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::container::chunk::MAX_EXPANSION;
    use crate::container::lzma2::decompress;
    use crate::container::lzma2_independent::decompress_independent;

    #[test]
    fn both_decoders_give_back_what_was_compressed() {
        let noise = |n: u32| (0..n).map(|i| (i.wrapping_mul(2_654_435_761) >> 24) as u8).collect::<Vec<_>>();
        for raw in [vec![], vec![7], vec![0; 300_000], noise(70_000), noise(3)] {
            let stored = compress(&raw, 6).unwrap();
            assert_eq!(decompress(&stored, raw.len() as u32).unwrap(), raw);
            assert_eq!(decompress_independent(&stored, raw.len() as u32).unwrap(), raw);
            assert!(decompress(&stored, raw.len() as u32 + 1).is_err());
            assert!(decompress(&[&stored[..], &[0]].concat(), raw.len() as u32).is_err());
            if !raw.is_empty() {
                assert!(decompress(&stored, raw.len() as u32 - 1).is_err());
                assert!(decompress(&stored[..stored.len() / 2], raw.len() as u32).is_err());
            }
        }
        let zeros = compress(&vec![0; 1 << 20], 6).unwrap();
        assert!((1u64 << 20) < zeros.len() as u64 * MAX_EXPANSION);
    }
}
