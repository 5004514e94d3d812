//! Files that one process at a time has.

use std::fs::{File, TryLockError};
use std::io::{Error, ErrorKind, Result};
use std::path::Path;

/// Opens a file to read and write, made where there is none, that no other process gets until it is closed, however this
/// one ends. `None` where another process has it. Where the file system has no locks, processes do not know of each other.
pub fn claim(path: &Path) -> Result<Option<File>> {
    // The one before may rename or remove the file between our opening and locking it, and we would have one that nobody sees.
    for _ in 0..100 {
        if path.symlink_metadata().is_ok_and(|meta| !meta.is_file()) {
            let message = format!("{} is in the way, and no plain file", path.display());
            return Err(Error::new(ErrorKind::AlreadyExists, message));
        }
        let file = File::options().create(true).truncate(false).read(true).write(true).open(path)?;
        match file.try_lock() {
            Err(TryLockError::WouldBlock) => return Ok(None),
            Ok(()) | Err(TryLockError::Error(_)) if is_at(&file, path) => return Ok(Some(file)),
            Ok(()) | Err(TryLockError::Error(_)) => {}
        }
    }
    Ok(None)
}

/// Whether a path still leads to a file, and not by a link.
#[cfg(unix)]
fn is_at(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let place = |meta: std::fs::Metadata| (meta.dev(), meta.ino());
    matches!((file.metadata().map(place), path.symlink_metadata().map(place)), (Ok(ours), Ok(theirs)) if ours == theirs)
}

/// Whether a path still leads to a file.
#[cfg(not(unix))]
fn is_at(_file: &File, path: &Path) -> bool {
    path.is_file()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_had_by_one_at_a_time_until_it_is_closed() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        let first = claim(&path).unwrap().unwrap();
        assert!(claim(&path).unwrap().is_none());
        // Under another name it is another's file no more.
        std::fs::rename(&path, folder.path().join("b")).unwrap();
        let second = claim(&path).unwrap().unwrap();
        drop(first);
        assert!(claim(&path).unwrap().is_none());
        drop(second);
        assert!(claim(&path).unwrap().is_some());
    }

    #[test]
    #[cfg(unix)]
    fn what_a_link_leads_to_is_left_alone() {
        let folder = tempfile::tempdir().unwrap();
        let (target, link) = (folder.path().join("theirs"), folder.path().join("a"));
        std::fs::write(&target, "theirs").unwrap();
        std::os::unix::fs::symlink(&target, &link).unwrap();
        assert_eq!(claim(&link).unwrap_err().kind(), ErrorKind::AlreadyExists);
        assert_eq!(std::fs::read(&target).unwrap(), b"theirs");
    }
}
