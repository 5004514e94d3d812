//! Writes fields, and the head and foot (container.md 3 and 7) as [`header`](crate::container::header) reads them.

use crate::container::header::{FOOT_BYTES, FOOT_MAGIC, Foot, HEAD_BYTES, MAGIC, VERSION_MAJOR, VERSION_MINOR};
use crate::error::{Error, Result};

/// Appends little-endian fields to a byte vector, as `Fields` reads them.
pub trait PutFields {
    fn put(&mut self, bytes: &[u8]);

    fn put_u16(&mut self, value: u16) {
        self.put(&value.to_le_bytes());
    }

    fn put_u32(&mut self, value: u32) {
        self.put(&value.to_le_bytes());
    }

    fn put_u64(&mut self, value: u64) {
        self.put(&value.to_le_bytes());
    }

    /// Writes a number of at most 35 bits in the shortest LEB128 form (container.md 1).
    fn put_varint(&mut self, mut value: u64) {
        while value >= 0x80 {
            self.put(&[value as u8 | 0x80]);
            value >>= 7;
        }
        self.put(&[value as u8]);
    }

    fn put_f32(&mut self, value: f32) {
        self.put(&value.to_le_bytes());
    }

    fn put_f64(&mut self, value: f64) {
        self.put(&value.to_le_bytes());
    }

    /// Writes a u16 length and the UTF-8 bytes.
    fn put_string(&mut self, what: &str, value: &str) -> Result<()> {
        let length = u16::try_from(value.len())
            .map_err(|_| Error::Usage(format!("{what} has {} bytes; a container holds at most 65535", value.len())))?;
        self.put_u16(length);
        self.put(value.as_bytes());
        Ok(())
    }
}

impl PutFields for Vec<u8> {
    fn put(&mut self, bytes: &[u8]) {
        self.extend_from_slice(bytes);
    }
}

pub fn write_head() -> [u8; HEAD_BYTES] {
    let mut head = [0; HEAD_BYTES];
    head[..8].copy_from_slice(&MAGIC);
    head[8..10].copy_from_slice(&VERSION_MAJOR.to_le_bytes());
    head[10..12].copy_from_slice(&VERSION_MINOR.to_le_bytes());
    head
}

impl Foot {
    /// Returns the foot of a file that ends with it, directly after the index.
    pub fn write(&self) -> Vec<u8> {
        let mut bytes = Vec::with_capacity(FOOT_BYTES);
        bytes.put_u64(self.index_offset);
        bytes.put_u64(self.index_bytes);
        bytes.put_u32(self.index_crc32);
        bytes.put_u32(0);
        bytes.put_u64(self.index_offset + self.index_bytes + FOOT_BYTES as u64);
        let crc = crc32fast::hash(&bytes);
        bytes.put_u32(crc);
        bytes.extend_from_slice(&FOOT_MAGIC);
        bytes
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::container::header::read_head;

    #[test]
    fn the_foot_round_trips_and_any_changed_byte_is_refused() {
        let foot = Foot { index_offset: 16, index_bytes: 1000, index_crc32: 0xdead_beef };
        let bytes = foot.write();
        let size = 16 + 1000 + FOOT_BYTES as u64;
        assert_eq!(Foot::read(&bytes, size).unwrap(), foot);
        for at in 0..bytes.len() {
            let mut damaged = bytes.clone();
            damaged[at] ^= 0x10;
            assert!(Foot::read(&damaged, size).is_err(), "byte {at}");
        }
        assert!(Foot::read(&bytes, size + 1).is_err());
        assert!(Foot::read(&bytes[1..], size).is_err());
    }

    #[test]
    fn the_head_refuses_other_files_versions_and_flags() {
        let head = write_head();
        assert_eq!(read_head(&head).unwrap(), VERSION_MINOR);
        for at in (0..8).chain(8..10).chain(12..16) {
            let mut damaged = head;
            damaged[at] ^= 1;
            assert!(read_head(&damaged).is_err(), "byte {at}");
        }
        let mut later = head;
        later[10] = 9;
        assert_eq!(read_head(&later).unwrap(), 9);
        assert!(read_head(&head[..15]).is_err());
    }
}
