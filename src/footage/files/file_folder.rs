//! Trait of folders that commands write files into.

use std::path::{Path, PathBuf};

use codec::error::Result;

/// A folder whose files appear together at the end.
pub trait FileFolder: Sync {
    /// Returns the path of a file that an earlier process made, if it is intact.
    fn made(&self, file: &Path) -> Option<PathBuf>;

    /// Writes a file at a path relative to the folder; creates missing folders. Returns the size of the file in bytes.
    fn write_file(&self, file: &Path, write: &mut dyn FnMut(&Path) -> Result<()>) -> Result<u64>;
}
