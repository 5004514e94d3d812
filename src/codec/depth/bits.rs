//! Bits packed into bytes, the least significant first (depth.md 9).

use crate::container::fields::Fields;
use crate::error::Result;

#[derive(Debug, Default)]
pub struct BitWriter {
    bytes: Vec<u8>,
    /// Number of bits used in the last byte; 0 if it is full.
    taken: u32,
}

impl BitWriter {
    /// Appends the `count` low bits of `value`, at most 16.
    pub fn put(&mut self, value: u16, count: u32) {
        for bit in 0..count {
            if self.taken == 0 {
                self.bytes.push(0);
            }
            if let Some(last) = self.bytes.last_mut() {
                *last |= ((value >> bit & 1) as u8) << self.taken;
            }
            self.taken = (self.taken + 1) % 8;
        }
    }

    pub fn finish(self) -> Vec<u8> {
        self.bytes
    }
}

#[derive(Debug)]
pub struct BitReader<'f, 'a> {
    fields: &'f mut Fields<'a>,
    current: u8,
    left: u32,
}

impl<'f, 'a> BitReader<'f, 'a> {
    pub fn new(fields: &'f mut Fields<'a>) -> Self {
        BitReader { fields, current: 0, left: 0 }
    }

    pub fn bit(&mut self) -> Result<bool> {
        if self.left == 0 {
            self.current = self.fields.u8()?;
            self.left = 8;
        }
        let bit = self.current & 1 == 1;
        self.current >>= 1;
        self.left -= 1;
        Ok(bit)
    }

    /// Ends at a byte boundary. Fails if the remaining bits of the byte are not 0.
    pub fn finish(self) -> Result<()> {
        if self.current != 0 {
            return Err(self.fields.error("the bits after the last one are not zero"));
        }
        Ok(())
    }
}
