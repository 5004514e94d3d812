//! How much memory a scene may ask for.
//!
//! Enters: bytes of files that were read, and what is about to be made of them. Leaves: consent, or an error before
//! anything is allocated.

use std::fmt::Display;

use crate::error::{Error, Result};

/// Bytes that a file of any size may ask for.
const FLOOR: u64 = 512 << 20;
/// Bytes that each byte of a file may ask for beyond that: a picture of one colour or a node that shows a mesh again
/// is a few bytes in the file.
const PER_BYTE: u64 = 128;
/// Most bytes, whatever the size of the files.
const MOST: u64 = 16 << 30;

/// Bytes that a triangle takes in a mesh and in the tree of its boxes.
pub const TRIANGLE_BYTES: u64 = 160;
/// Bytes that a corner takes in a mesh, and on the way there.
pub const CORNER_BYTES: u64 = 152;

/// Bytes of memory that may still be asked for.
#[derive(Debug)]
pub struct Budget {
    files: u64,
    taken: u64,
}

impl Budget {
    /// That of a file of `bytes` bytes.
    pub fn new(bytes: u64) -> Budget {
        Budget { files: bytes, taken: 0 }
    }

    /// Another file of the scene was read.
    pub fn grow(&mut self, bytes: u64) {
        self.files = self.files.saturating_add(bytes);
    }

    /// Most bytes that a scene in files of so many bytes may come to.
    pub fn allowance(files: u64) -> u64 {
        files.saturating_mul(PER_BYTE).saturating_add(FLOOR).min(MOST)
    }

    /// Asks for `count` things of `size` bytes.
    ///
    /// # Errors
    /// When that is more than files of this size may ask for.
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
        assert_eq!(Budget::allowance(u64::MAX), MOST);
    }
}
