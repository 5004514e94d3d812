//! Folders that commands write files into.

use std::path::{Path, PathBuf};

use crate::error::Result;

/// A folder that takes files until they appear together.
pub trait FileFolder: Sync {
    /// The place of a file that an earlier process made, and that is intact.
    fn made(&self, file: &Path) -> Option<PathBuf>;

    /// Writes a file by a path, in folders that are made where they are missing. Returns its bytes.
    fn write_file(&self, file: &Path, write: &mut dyn FnMut(&Path) -> Result<()>) -> Result<u64>;
}
