//! Files that only one process at a time may open.

use std::fs::{File, TryLockError};
use std::io::{Error, ErrorKind, Result};
use std::path::Path;

use super::disk::DiskFile;

#[derive(Debug)]
pub struct Locked {
    /// The file; closing it releases the lock.
    pub file: DiskFile,
    /// False if the file system has no locks; other processes can then open the file, too.
    pub is_locked: bool,
}

/// Opens or creates a file and locks it until it is closed. Returns `None` if another process holds the lock.
pub fn open_locked(path: &Path) -> Result<Option<Locked>> {
    // The previous owner may rename or remove the file between our open and our lock; the path is then opened again.
    for _ in 0..100 {
        if path.symlink_metadata().is_ok_and(|meta| !meta.is_file()) {
            let message = format!("{} exists and is not a regular file", path.display());
            return Err(Error::new(ErrorKind::AlreadyExists, message));
        }
        let file = DiskFile::open(path)?;
        let Some(is_locked) = lock_state(&file.file().try_lock()) else { return Ok(None) };
        if is_at(file.file(), path) {
            return Ok(Some(Locked { file, is_locked }));
        }
    }
    Ok(None)
}

/// True if the lock was acquired, false if the file system has no locks, `None` if another process holds it.
fn lock_state(lock: &std::result::Result<(), TryLockError>) -> Option<bool> {
    match lock {
        Ok(()) => Some(true),
        Err(TryLockError::WouldBlock) => None,
        Err(TryLockError::Error(_)) => Some(false),
    }
}

/// True if the path still names this file, and does so without a link.
#[cfg(unix)]
fn is_at(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let place = |meta: std::fs::Metadata| (meta.dev(), meta.ino());
    matches!((file.metadata().map(place), path.symlink_metadata().map(place)), (Ok(ours), Ok(theirs)) if ours == theirs)
}

#[cfg(not(unix))]
fn is_at(_file: &File, path: &Path) -> bool {
    path.is_file()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_locked_until_it_is_closed() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        let first = open_locked(&path).unwrap().unwrap();
        assert!(first.is_locked);
        assert!(open_locked(&path).unwrap().is_none());
        // A lock on a renamed file does not apply to its old name.
        std::fs::rename(&path, folder.path().join("b")).unwrap();
        let second = open_locked(&path).unwrap().unwrap();
        drop(first);
        assert!(open_locked(&path).unwrap().is_none());
        drop(second);
        assert!(open_locked(&path).unwrap().is_some());
    }

    #[test]
    fn a_file_system_without_locks_is_no_other_process() {
        let unsupported = TryLockError::Error(ErrorKind::Unsupported.into());
        assert_eq!([lock_state(&Ok(())), lock_state(&Err(unsupported))], [Some(true), Some(false)]);
        assert_eq!(lock_state(&Err(TryLockError::WouldBlock)), None);
    }

    #[test]
    #[cfg(unix)]
    fn the_target_of_a_link_is_left_alone() {
        let folder = tempfile::tempdir().unwrap();
        let (target, link) = (folder.path().join("theirs"), folder.path().join("a"));
        std::fs::write(&target, "theirs").unwrap();
        std::os::unix::fs::symlink(&target, &link).unwrap();
        assert_eq!(open_locked(&link).unwrap_err().kind(), ErrorKind::AlreadyExists);
        assert_eq!(std::fs::read(&target).unwrap(), b"theirs");
    }
}
