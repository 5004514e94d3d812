//! LZMA2 for chunk payloads (container.md 6.1). The raw LZMA2 chunk stream, without xz framing: the container's own
//! CRC-32 guards it.

use std::io::{Read, Write};

use crate::error::{Error, Result};

/// The preset where none is asked for.
pub const DEFAULT_LEVEL: u32 = 6;
/// Smallest dictionary that LZMA2 knows.
const MIN_DICTIONARY: u32 = 1 << 12;
/// Largest dictionary that a container uses, so that a chunk's claims never cost a reader more than this.
const MAX_DICTIONARY: u32 = 1 << 24;

/// Dictionary size that encoder and decoder use for a payload of `raw_bytes`: the power of two that covers it,
/// from 4 KiB to 16 MiB.
pub fn dictionary_bytes(raw_bytes: u32) -> u32 {
    raw_bytes.clamp(MIN_DICTIONARY, MAX_DICTIONARY).next_power_of_two()
}

/// Compresses at a preset of 0 (fast) to 9 (small).
pub fn compress(raw: &[u8], level: u32) -> Result<Vec<u8>> {
    let raw_bytes = u32::try_from(raw.len()).map_err(|_| Error::unsupported("a chunk of more than 4 GiB"))?;
    let mut options = lzma_rust2::Lzma2Options::with_preset(level);
    options.lzma_options.dict_size = dictionary_bytes(raw_bytes);
    let mut writer = lzma_rust2::Lzma2Writer::new(Vec::new(), options);
    writer.write_all(raw).and_then(|()| writer.finish()).map_err(|source| Error::io("LZMA2 encoder", source))
}

/// Decompresses exactly `raw_bytes`; memory grows with what really comes out.
pub fn decompress(stored: &[u8], raw_bytes: u32) -> Result<Vec<u8>> {
    let mut reader = lzma_rust2::Lzma2Reader::new(stored, dictionary_bytes(raw_bytes), None);
    let mut raw = Vec::new();
    // One byte more than expected, so that a stream that is too long is noticed.
    (&mut reader)
        .take(u64::from(raw_bytes) + 1)
        .read_to_end(&mut raw)
        .map_err(|error| Error::invalid(format!("the chunk's LZMA2 stream is damaged: {error}")))?;
    if raw.len() != raw_bytes as usize {
        return Err(Error::invalid(format!(
            "the chunk's LZMA2 stream does not mean the {raw_bytes} bytes that the table says"
        )));
    }
    match reader.inner().len() {
        0 => Ok(raw),
        left => Err(Error::invalid(format!("{left} bytes follow the end of the chunk's LZMA2 stream"))),
    }
}

/// Takes what comes out, up to a number of bytes.
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

/// Decompresses at most `raw_bytes` with an independent implementation, for verification.
pub fn decompress_independent(stored: &[u8], raw_bytes: u32) -> Result<Vec<u8>> {
    let mut capped = Capped { raw: Vec::new(), most: raw_bytes as usize };
    lzma_rs::lzma2_decompress(&mut std::io::BufReader::new(stored), &mut capped)
        .map_err(|error| Error::invalid(format!("the second LZMA2 decoder refuses the chunk: {error:?}")))?;
    Ok(capped.raw)
}

#[cfg(test)]
mod tests {
    use super::*;

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
        assert!((1u64 << 20) < zeros.len() as u64 * super::super::chunk::MAX_EXPANSION);
    }
}
