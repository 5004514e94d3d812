//! Memory that a scene file may ask for, checked before it is allocated: 512 MiB and 128 times the size of its files.

use std::fmt::Display;

use crate::error::{Error, Result};

/// Bytes allowed for a file of any size.
const FLOOR: u64 = 512 << 20;
/// Further bytes for each byte of the files: an image of one colour is a few bytes in the file.
const PER_BYTE: u64 = 128;
/// Most bytes for files of any size.
const MAX_BYTES: u64 = 16 << 30;

/// Bytes of a triangle in a mesh and its bounding volume hierarchy.
pub const TRIANGLE_BYTES: u64 = 160;
/// Bytes of a corner in a mesh and on the way there.
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

    /// Adds a file of the scene.
    pub fn grow(&mut self, bytes: u64) {
        self.files = self.files.saturating_add(bytes);
    }

    /// Most bytes that a scene of so many bytes of files may take.
    pub fn allowance(files: u64) -> u64 {
        files.saturating_mul(PER_BYTE).saturating_add(FLOOR).min(MAX_BYTES)
    }

    /// Reserves memory, or fails where it is more than the files allow.
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
