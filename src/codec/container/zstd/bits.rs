//! Bit streams of a frame: forward streams of table descriptions (RFC 8878, 4.1.1), and streams that are read from their end
//! (4.1.2, 4.2.2).

use crate::error::{Error, Result};

/// Returns an error about the frame; `why` is a clause.
pub fn damaged(why: impl std::fmt::Display) -> Error {
    Error::invalid(format!("the chunk's Zstandard frame is damaged: {why}"))
}

/// Bits from the first byte on, lowest bit first.
pub struct ForwardBits<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> ForwardBits<'a> {
    pub fn new(bytes: &'a [u8]) -> Self {
        ForwardBits { bytes, at: 0 }
    }

    /// Takes the next `count` bits, at most 16.
    pub fn take(&mut self, count: u32) -> Result<u32> {
        let end = self.at + count as usize;
        if end > 8 * self.bytes.len() {
            return Err(damaged("a table ends early"));
        }
        let byte = |offset: usize| u32::from(self.bytes.get(self.at / 8 + offset).copied().unwrap_or(0));
        let word = byte(0) | byte(1) << 8 | byte(2) << 16;
        let value = word >> (self.at % 8) & ((1 << count) - 1);
        self.at = end;
        Ok(value)
    }

    /// Number of bytes that were read, the last one possibly in part.
    pub fn used_bytes(&self) -> usize {
        self.at.div_ceil(8)
    }
}

/// Bits from the last byte backwards, starting below its highest set bit. Bits before the first byte are 0.
pub struct BackwardBits<'a> {
    bytes: &'a [u8],
    left: isize,
}

impl<'a> BackwardBits<'a> {
    pub fn new(bytes: &'a [u8]) -> Result<Self> {
        match bytes.last() {
            Some(&last) if last != 0 => {
                let left = 8 * bytes.len() as isize - 1 - last.leading_zeros() as isize;
                Ok(BackwardBits { bytes, left })
            }
            _ => Err(damaged("a bit stream has no end mark")),
        }
    }

    /// Number of remaining bits; negative if more bits were taken than exist.
    pub fn left(&self) -> isize {
        self.left
    }

    /// Returns at least the next 57 bits, in the highest bits of the word.
    #[inline]
    pub fn peek(&self) -> u64 {
        let Ok(left) = usize::try_from(self.left) else { return 0 };
        let end = left.div_ceil(8);
        let word = match self.bytes[..end].last_chunk::<8>() {
            Some(bytes) => u64::from_le_bytes(*bytes),
            None => {
                let mut bytes = [0; 8];
                bytes[8 - end..].copy_from_slice(&self.bytes[..end]);
                u64::from_le_bytes(bytes)
            }
        };
        word << (8 * end - left)
    }

    #[inline]
    pub fn skip(&mut self, count: u32) {
        self.left -= count as isize;
    }

    /// Takes the next `count` bits, at most 31.
    #[inline]
    pub fn take(&mut self, count: u32) -> u32 {
        // Two shifts, because for 0 bits a single shift would be one by 64, which overflows.
        let value = self.peek() >> 1 >> (63 - count);
        self.skip(count);
        value as u32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_bits_from_the_end_and_zeros_before_the_start() {
        let bytes: Vec<u8> = (1..=20).collect();
        let whole = bytes.iter().rev().fold(String::new(), |text, byte| text + &format!("{byte:08b}"));
        let expected = whole.trim_start_matches('0')[1..].to_owned() + &"0".repeat(80);
        for widths in [vec![1; 160], vec![7; 24], vec![31; 6], vec![0, 3, 11, 20, 5, 31, 31, 2, 31, 17, 31]] {
            let mut bits = BackwardBits::new(&bytes).unwrap();
            let mut at = 0;
            for width in widths {
                let end = at + width as usize;
                let value = u32::from_str_radix(&format!("0{}", &expected[at..end]), 2).unwrap();
                assert_eq!((bits.take(width), bits.left()), (value, 156 - end as isize), "bits {at} to {end}");
                at = end;
            }
        }
        assert!(BackwardBits::new(&[]).is_err() && BackwardBits::new(&[1, 0]).is_err());
    }
}
