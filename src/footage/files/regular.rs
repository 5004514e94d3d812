//! Input files.

use std::fs::File;
use std::path::Path;

use codec::error::{Error, Result};

/// Opens a regular file. Fails on any other, because opening a named pipe would block.
pub fn open_regular(path: &Path) -> Result<File> {
    let io = |error| Error::io(path, error);
    if std::fs::metadata(path).map_err(io)?.is_file() {
        return File::open(path).map_err(io);
    }
    Err(Error::invalid("not a regular file").in_file(path))
}
