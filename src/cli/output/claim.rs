//! Files that one process at a time has.

use std::fs::{File, TryLockError};
use std::io::{Error, ErrorKind, Result};
use std::path::Path;

/// A file that is open to read and write.
#[derive(Debug)]
pub struct Claimed {
    /// The file.
    pub file: File,
    /// Whether no other process gets it until it is closed. Where the file system has no locks, processes do not know of
    /// each other.
    pub is_locked: bool,
}

/// Opens a file to read and write, made where there is none, that no other process gets until it is closed, however this
/// one ends, if the file system has locks. `None` where another process has it.
pub fn claim(path: &Path) -> Result<Option<Claimed>> {
    // The one before may rename or remove the file between our opening and locking it, and we would have one that nobody sees.
    for _ in 0..100 {
        if path.symlink_metadata().is_ok_and(|meta| !meta.is_file()) {
            let message = format!("{} is in the way, and no plain file", path.display());
            return Err(Error::new(ErrorKind::AlreadyExists, message));
        }
        let file = File::options().create(true).truncate(false).read(true).write(true).open(path)?;
        let Some(is_locked) = got(&file.try_lock()) else { return Ok(None) };
        if is_at(&file, path) {
            return Ok(Some(Claimed { file, is_locked }));
        }
    }
    Ok(None)
}

/// Whether a lock was had, or there are none; `None` where another process has it.
fn got(lock: &std::result::Result<(), TryLockError>) -> Option<bool> {
    match lock {
        Ok(()) => Some(true),
        Err(TryLockError::WouldBlock) => None,
        Err(TryLockError::Error(_)) => Some(false),
    }
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
        assert!(first.is_locked);
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
    fn a_file_system_without_locks_is_no_other_process() {
        let unsupported = TryLockError::Error(ErrorKind::Unsupported.into());
        assert_eq!([got(&Ok(())), got(&Err(unsupported))], [Some(true), Some(false)]);
        assert_eq!(got(&Err(TryLockError::WouldBlock)), None);
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
