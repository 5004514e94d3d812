//! The first 16 and the last 40 bytes of a container (container.md 3 and 7).
//!
//! The head says what the file is; the foot, written last, says where the index lies. A file whose writing was cut
//! short has no foot and does not open.

use crate::container::fields::{Fields, PutFields};
use crate::error::{Error, Result};

/// First eight bytes: a byte above 127, the name, and line ends that a text-mode copy would change.
pub const MAGIC: [u8; 8] = [0x89, b'L', b'F', b'L', b'D', 0x0d, 0x0a, 0x1a];
/// Last four bytes.
pub const FOOT_MAGIC: [u8; 4] = *b"LFND";
/// Major version: readers refuse any other.
pub const VERSION_MAJOR: u16 = 1;
/// Minor version: later ones may only add codecs.
pub const VERSION_MINOR: u16 = 0;
/// Size of the head.
pub const HEAD_BYTES: usize = 16;
/// Size of the foot.
pub const FOOT_BYTES: usize = 40;

/// The head of a file of this version.
pub fn write_head() -> [u8; HEAD_BYTES] {
    let mut head = [0; HEAD_BYTES];
    head[..8].copy_from_slice(&MAGIC);
    head[8..10].copy_from_slice(&VERSION_MAJOR.to_le_bytes());
    head[10..12].copy_from_slice(&VERSION_MINOR.to_le_bytes());
    head
}

/// Checks the head: the file is a container, of a version and with flags that this reader knows.
pub fn read_head(bytes: &[u8]) -> Result<()> {
    let mut fields = Fields::new(bytes, 0, "container.md 3");
    if fields.bytes(8)? != MAGIC {
        return Err(Error::invalid_at(
            "container.md 3",
            0,
            "this is not a lightfold container: its first 8 bytes are other",
        ));
    }
    let (major, _minor) = (fields.u16()?, fields.u16()?);
    if major != VERSION_MAJOR {
        return Err(Error::unsupported(format!(
            "the container has format version {major}; this lightfold reads version {VERSION_MAJOR}"
        )));
    }
    fields.zeros(4)
}

/// Where the index lies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Foot {
    /// Offset of the index from the start of the file.
    pub index_offset: u64,
    /// Size of the index.
    pub index_bytes: u64,
    /// CRC-32 of the index.
    pub index_crc32: u32,
}

impl Foot {
    /// The last bytes of a file that ends with this foot right after its index.
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

    /// Reads the foot of a file of `file_bytes` bytes.
    ///
    /// The index it names lies inside the file, ends where the foot starts, and starts behind the head.
    pub fn read(bytes: &[u8], file_bytes: u64) -> Result<Foot> {
        const SECTION: &str = "container.md 7";
        let start = file_bytes.saturating_sub(FOOT_BYTES as u64);
        if bytes.len() != FOOT_BYTES || bytes[36..] != FOOT_MAGIC {
            return Err(Error::invalid_at(
                SECTION,
                start,
                "the container has no foot: it was cut short, so copy or encode it again",
            ));
        }
        let mut fields = Fields::new(bytes, start, SECTION);
        let foot = Foot { index_offset: fields.u64()?, index_bytes: fields.u64()?, index_crc32: fields.u32()? };
        fields.zeros(4)?;
        let said = fields.u64()?;
        if fields.u32()? != crc32fast::hash(&bytes[..32]) {
            return Err(Error::invalid_at(SECTION, start, "the foot's CRC-32 does not match: the file is damaged"));
        }
        if said != file_bytes {
            return Err(Error::invalid_at(
                SECTION,
                start + 24,
                format!("the foot speaks of a file of {said} bytes, this one has {file_bytes}"),
            ));
        }
        let end = foot.index_offset.checked_add(foot.index_bytes);
        if foot.index_offset < HEAD_BYTES as u64 || end != Some(start) {
            return Err(Error::invalid_at(SECTION, start, "the index does not lie between the chunks and the foot"));
        }
        Ok(foot)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
        read_head(&head).unwrap();
        for at in (0..8).chain(8..10).chain(12..16) {
            let mut damaged = head;
            damaged[at] ^= 1;
            assert!(read_head(&damaged).is_err(), "byte {at}");
        }
        let mut later = head;
        later[10] = 9;
        read_head(&later).unwrap();
        assert!(read_head(&head[..15]).is_err());
    }
}
