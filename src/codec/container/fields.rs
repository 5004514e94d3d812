//! Reader of little-endian fields in a byte slice; an error has the offset of the first invalid field.

use byteorder::{ByteOrder, LittleEndian};

use crate::error::{Error, Result};

/// Reads fields one after the other, and never past the end.
#[derive(Debug, Clone)]
pub struct Fields<'a> {
    bytes: &'a [u8],
    position: usize,
    base: u64,
    section: &'static str,
}

impl<'a> Fields<'a> {
    /// `base` is the offset of `bytes` for errors; `section` is the section of `formats/` that describes the fields.
    pub fn new(bytes: &'a [u8], base: u64, section: &'static str) -> Self {
        Fields { bytes, position: 0, base, section }
    }

    pub fn enter(&mut self, section: &'static str) {
        self.section = section;
    }

    pub fn offset(&self) -> u64 {
        self.base + self.position as u64
    }

    pub fn position(&self) -> usize {
        self.position
    }

    pub fn remaining(&self) -> usize {
        self.bytes.len() - self.position
    }

    pub fn error(&self, message: impl Into<String>) -> Error {
        Error::invalid_at(self.section, self.offset(), message)
    }

    /// As [`Self::error`], for a row that starts at `offset`.
    pub fn error_at(&self, offset: u64, message: impl Into<String>) -> Error {
        Error::invalid_at(self.section, offset, message)
    }

    pub fn bytes(&mut self, count: usize) -> Result<&'a [u8]> {
        if count > self.remaining() {
            return Err(self.error(format!("{count} more bytes expected, {} left", self.remaining())));
        }
        let start = self.position;
        self.position += count;
        Ok(&self.bytes[start..self.position])
    }

    pub fn u8(&mut self) -> Result<u8> {
        Ok(self.bytes(1)?[0])
    }

    pub fn u16(&mut self) -> Result<u16> {
        Ok(LittleEndian::read_u16(self.bytes(2)?))
    }

    pub fn u32(&mut self) -> Result<u32> {
        Ok(LittleEndian::read_u32(self.bytes(4)?))
    }

    pub fn u32s<const N: usize>(&mut self) -> Result<[u32; N]> {
        let mut values = [0; N];
        LittleEndian::read_u32_into(self.bytes(4 * N)?, &mut values);
        Ok(values)
    }

    pub fn u64(&mut self) -> Result<u64> {
        Ok(LittleEndian::read_u64(self.bytes(8)?))
    }

    /// Reads an unsigned LEB128 number of at most five bytes (35 bits), in its shortest form (container.md 1).
    pub fn varint(&mut self) -> Result<u64> {
        let mut value = 0;
        for shift in (0..35).step_by(7) {
            let byte = self.u8()?;
            value |= u64::from(byte & 0x7f) << shift;
            match byte {
                0 if shift > 0 => return Err(self.error("a number is not in its shortest form")),
                0..0x80 => return Ok(value),
                _ => {}
            }
        }
        Err(self.error("a number of more than five bytes"))
    }

    pub fn varint_u32(&mut self) -> Result<u32> {
        let value = self.varint()?;
        u32::try_from(value).map_err(|_| self.error(format!("{value} is more than 32 bits hold")))
    }

    pub fn f32(&mut self) -> Result<f32> {
        Ok(LittleEndian::read_f32(self.bytes(4)?))
    }

    pub fn finite_f64(&mut self, what: &str) -> Result<f64> {
        let offset = self.offset();
        let value = LittleEndian::read_f64(self.bytes(8)?);
        let expected =
            || Error::invalid_at(self.section, offset, format!("{what} is {value}, a finite number was expected"));
        value.is_finite().then_some(value).ok_or_else(expected)
    }

    pub fn finite_f64s<const N: usize>(&mut self, what: &str) -> Result<[f64; N]> {
        let mut values = [0.0; N];
        for value in &mut values {
            *value = self.finite_f64(what)?;
        }
        Ok(values)
    }

    /// Reads a UTF-8 string with a length prefix (u16).
    pub fn string(&mut self, what: &str) -> Result<String> {
        let length = self.u16()? as usize;
        let offset = self.offset();
        let bytes = self.bytes(length)?;
        std::str::from_utf8(bytes)
            .map(str::to_owned)
            .map_err(|_| Error::invalid_at(self.section, offset, format!("{what} is not UTF-8")))
    }

    /// Reads `count` reserved bytes. Fails if one is not zero.
    pub fn zeros(&mut self, count: usize) -> Result<()> {
        let offset = self.offset();
        match self.bytes(count)?.iter().position(|&byte| byte != 0) {
            None => Ok(()),
            Some(at) => Err(Error::invalid_at(
                self.section,
                offset + at as u64,
                "a reserved byte is not zero: the file was written by a later version or is damaged",
            )),
        }
    }

    pub fn finish(&self) -> Result<()> {
        match self.remaining() {
            0 => Ok(()),
            left => Err(self.error(format!("{left} bytes after the last field"))),
        }
    }
}

#[cfg(feature = "encode")]
#[cfg(test)]
mod tests {
    use super::*;
    use crate::container::serialize::PutFields;

    #[test]
    fn varints_come_back_in_their_shortest_form_only() {
        for (value, length) in
            [(0, 1), (127, 1), (128, 2), (16_383, 2), (16_384, 3), (u64::from(u32::MAX), 5), ((1 << 35) - 1, 5)]
        {
            let mut bytes = Vec::new();
            bytes.put_varint(value);
            let mut fields = Fields::new(&bytes, 0, "container.md 1");
            assert_eq!((fields.varint().unwrap(), fields.position(), bytes.len()), (value, length, length));
            assert_eq!(Fields::new(&bytes, 0, "").varint_u32().is_ok(), value <= u64::from(u32::MAX));
        }
        for bytes in [&[0x80, 0][..], &[0xff, 0x80, 0], &[0x80], &[0xff; 6], &[0x80, 0x80, 0x80, 0x80, 0x80, 1]] {
            assert!(Fields::new(bytes, 0, "").varint().is_err(), "{bytes:?}");
        }
    }

    #[test]
    fn fields_come_back_and_the_end_is_an_error() {
        let mut bytes = Vec::new();
        bytes.push(7);
        bytes.put_u16(0x0102);
        bytes.put_u32(0x0304_0506);
        bytes.put_u64(u64::MAX - 1);
        bytes.put_f32(-0.5);
        bytes.put_f64(1e300);
        bytes.put_string("name", "πrobe").unwrap();
        bytes.extend_from_slice(&[0, 0, 9]);
        let mut fields = Fields::new(&bytes, 100, "container.md 3");
        assert_eq!(fields.u8().unwrap(), 7);
        assert_eq!(fields.u16().unwrap(), 0x0102);
        assert_eq!(fields.u32().unwrap(), 0x0304_0506);
        assert_eq!(fields.u64().unwrap(), u64::MAX - 1);
        assert_eq!(fields.f32().unwrap(), -0.5);
        assert_eq!(fields.finite_f64("x").unwrap(), 1e300);
        assert_eq!(fields.string("name").unwrap(), "πrobe");
        fields.zeros(2).unwrap();
        assert!(fields.finish().is_err());
        let at = fields.offset();
        let error = fields.zeros(1).unwrap_err().to_string();
        assert!(error.contains(&format!("at byte {at}")), "{error}");
        assert!(error.contains("formats/container.md 3"), "{error}");
        assert!(fields.u8().is_err());
    }
}
