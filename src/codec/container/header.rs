//! The first 16 and the last 40 bytes of a container (container.md 3 and 7).
//!
//! The foot is written last and locates the index. An incomplete file has no foot and cannot be opened.

use crate::container::fields::Fields;
use crate::error::{Error, Result};

/// First eight bytes: a byte above 127, the name, and line endings that a text-mode copy would change.
pub const MAGIC: [u8; 8] = [0x89, b'L', b'F', b'L', b'D', 0x0d, 0x0a, 0x1a];
pub const FOOT_MAGIC: [u8; 4] = *b"LFND";
/// Major version; readers refuse any other.
pub const VERSION_MAJOR: u16 = 1;
/// Minor version; readers accept later ones (container.md 3).
pub const VERSION_MINOR: u16 = 0;
pub const HEAD_BYTES: usize = 16;
pub const FOOT_BYTES: usize = 40;

/// True if a file is read as a container, by its extension or its first bytes.
#[cfg(feature = "encode")]
pub fn is_container(path: &std::path::Path) -> Result<bool> {
    use std::io::Read;
    if path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("lfold")) {
        return Ok(true);
    }
    if !path.is_file() {
        return Ok(false);
    }
    let mut head = Vec::new();
    let file = std::fs::File::open(path).map_err(|error| Error::io(path, error))?;
    file.take(MAGIC.len() as u64).read_to_end(&mut head).map_err(|error| Error::io(path, error))?;
    Ok(head == MAGIC)
}

/// Checks the head of a container. Fails for an unknown major version. Returns the minor version.
pub fn read_head(bytes: &[u8]) -> Result<u16> {
    let mut fields = Fields::new(bytes, 0, "container.md 3");
    if fields.bytes(8)? != MAGIC {
        let message = "this is not a lightfold container: its signature is wrong";
        return Err(Error::invalid_at("container.md 3", 0, message));
    }
    let (major, minor) = (fields.u16()?, fields.u16()?);
    if major != VERSION_MAJOR {
        return Err(Error::unsupported(format!(
            "the container has format version {major}; this lightfold reads version {VERSION_MAJOR}"
        )));
    }
    fields.zeros(4)?;
    Ok(minor)
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Foot {
    pub index_offset: u64,
    pub index_bytes: u64,
    pub index_crc32: u32,
}

impl Foot {
    /// Reads the foot of a file of `file_bytes` bytes. Fails unless the index lies between the chunks and the foot.
    pub fn read(bytes: &[u8], file_bytes: u64) -> Result<Foot> {
        const SECTION: &str = "container.md 7";
        let start = file_bytes.saturating_sub(FOOT_BYTES as u64);
        let wrong = |at: u64, message: String| Err(Error::invalid_at(SECTION, at, message));
        if bytes.len() != FOOT_BYTES || bytes[36..] != FOOT_MAGIC {
            let message = "the container has no foot: the file is truncated; copy or encode it again";
            return wrong(start, message.into());
        }
        let mut fields = Fields::new(bytes, start, SECTION);
        let (index_offset, index_bytes, index_crc32) = (fields.u64()?, fields.u64()?, fields.u32()?);
        fields.zeros(4)?;
        let said = fields.u64()?;
        if fields.u32()? != crc32fast::hash(&bytes[..32]) {
            return wrong(start, "the foot's CRC-32 does not match: the file is damaged".into());
        }
        let foot = Foot { index_offset, index_bytes, index_crc32 };
        if said != file_bytes {
            let message = format!("the foot states a file size of {said} bytes, but the file has {file_bytes}");
            return wrong(start + 24, message);
        }
        let end = foot.index_offset.checked_add(foot.index_bytes);
        if foot.index_offset < HEAD_BYTES as u64 || end != Some(start) {
            return wrong(start, "the index does not lie between the chunks and the foot".into());
        }
        Ok(foot)
    }
}
