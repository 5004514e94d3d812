//! Limit on the memory of a scene file, checked before allocation: 512 MiB plus 128 times the size of its files.

use std::fmt::Display;

use codec::error::{Error, Result};

/// Bytes allowed for files of any size.
const FLOOR: u64 = 512 << 20;
/// Additional bytes allowed for each byte of the files: an image of one colour takes a few bytes in the file.
const PER_BYTE: u64 = 128;
/// Maximum number of bytes for files of any size.
const MAX_BYTES: u64 = 16 << 30;

/// Bytes of a triangle in a mesh and its bounding volume hierarchy.
pub const TRIANGLE_BYTES: u64 = 160;
/// Bytes of a corner in a mesh and while the mesh is assembled.
pub const CORNER_BYTES: u64 = 152;

#[derive(Debug)]
pub struct Budget {
    files: u64,
    taken: u64,
}

impl Budget {
    pub fn new(bytes: u64) -> Budget {
        Budget { files: bytes, taken: 0 }
    }

    /// Adds the size of another file of the scene.
    pub fn grow(&mut self, bytes: u64) {
        self.files = self.files.saturating_add(bytes);
    }

    /// Returns the maximum bytes of memory for a scene with this many bytes of files.
    pub fn allowance(files: u64) -> u64 {
        files.saturating_mul(PER_BYTE).saturating_add(FLOOR).min(MAX_BYTES)
    }

    /// Reserves memory for `count` elements of `size` bytes. Fails if the total exceeds what the files allow.
    pub fn take(&mut self, count: u64, size: u64, what: impl Display) -> Result<()> {
        let taken = count.saturating_mul(size).saturating_add(self.taken);
        let allowance = Budget::allowance(self.files);
        if taken > allowance {
            return Err(Error::invalid(format!(
                "{what}: with {count} of {size} bytes the scene would take {taken} bytes of memory, where files of {} \
                 bytes may take {allowance}",
                self.files
            )));
        }
        self.taken = taken;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_taken_adds_up() {
        let mut budget = Budget::new(0);
        budget.take(FLOOR / 8, 4, "a").unwrap();
        budget.take(FLOOR / 8, 4, "b").unwrap();
        let message = budget.take(1, 1, "mesh 3").unwrap_err().to_string();
        assert!(message.contains("mesh 3") && message.contains("536870912"), "{message}");
        budget.grow(1);
        budget.take(1, PER_BYTE, "c").unwrap();
        assert!(budget.take(u64::MAX, u64::MAX, "d").is_err());
        assert_eq!(Budget::allowance(u64::MAX), MAX_BYTES);
    }
}
