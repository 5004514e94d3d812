//! Byte ranges of a container, from a file, from memory, or from another [`ByteSource`].

use std::fs::File;
use std::io;
use std::sync::Arc;

/// Bytes of a container, which do not change while it is open. Several threads read concurrently.
pub trait ByteSource: std::fmt::Debug + Send + Sync {
    /// Returns the number of bytes.
    ///
    /// # Errors
    /// If the source cannot determine its size.
    fn byte_count(&self) -> io::Result<u64>;

    /// Fills `bytes` with the bytes from `offset` on.
    ///
    /// # Errors
    /// Kind [`io::ErrorKind::UnexpectedEof`] if the source ends before; any other kind if reading fails.
    fn read_at(&self, offset: u64, bytes: &mut [u8]) -> io::Result<()>;

    /// Returns all bytes if they are in shared memory: chunks are then ranges of it, and nothing is copied.
    fn memory(&self) -> Option<&Arc<Vec<u8>>> {
        None
    }
}

impl ByteSource for Arc<Vec<u8>> {
    fn byte_count(&self) -> io::Result<u64> {
        Ok(self.len() as u64)
    }

    fn read_at(&self, offset: u64, bytes: &mut [u8]) -> io::Result<()> {
        read_slice(self, offset, bytes)
    }

    fn memory(&self) -> Option<&Arc<Vec<u8>>> {
        Some(self)
    }
}

impl ByteSource for &'static [u8] {
    fn byte_count(&self) -> io::Result<u64> {
        Ok(self.len() as u64)
    }

    fn read_at(&self, offset: u64, bytes: &mut [u8]) -> io::Result<()> {
        read_slice(self, offset, bytes)
    }
}

fn read_slice(memory: &[u8], offset: u64, bytes: &mut [u8]) -> io::Result<()> {
    let start = usize::try_from(offset).ok();
    let part = start.and_then(|start| memory.get(start..start.checked_add(bytes.len())?));
    bytes.copy_from_slice(part.ok_or(io::ErrorKind::UnexpectedEof)?);
    Ok(())
}

impl ByteSource for File {
    fn byte_count(&self) -> io::Result<u64> {
        Ok(self.metadata()?.len())
    }

    #[cfg(unix)]
    fn read_at(&self, offset: u64, bytes: &mut [u8]) -> io::Result<()> {
        std::os::unix::fs::FileExt::read_exact_at(self, bytes, offset)
    }

    /// WebAssembly has no files.
    #[cfg(not(any(unix, windows)))]
    fn read_at(&self, _offset: u64, _bytes: &mut [u8]) -> io::Result<()> {
        Err(io::ErrorKind::Unsupported.into())
    }

    #[cfg(windows)]
    fn read_at(&self, mut offset: u64, mut bytes: &mut [u8]) -> io::Result<()> {
        while !bytes.is_empty() {
            match std::os::windows::fs::FileExt::seek_read(self, bytes, offset)? {
                0 => return Err(io::ErrorKind::UnexpectedEof.into()),
                count => {
                    bytes = &mut bytes[count..];
                    offset += count as u64;
                }
            }
        }
        Ok(())
    }
}
