//! Temporary folders that a process owns. Those of killed processes are removed by the next process that creates one in the
//! same place.

use std::io::{ErrorKind, Result};
use std::path::{Path, PathBuf};

use super::disk;
use super::lock::{Locked, open_locked};

/// Prefix and suffix of the folder's name.
const NAME: [&str; 2] = [".lightfold.", ".partial"];
/// Name of the locked file in the folder, beside the subfolder of files.
const LOCK: &str = "lock";
const FILES: &str = "files";
/// Maximum attempts to create a folder: another process may mistake a new one for a leftover and remove it.
const ATTEMPTS: usize = 100;

/// A temporary folder, removed on drop.
#[derive(Debug)]
pub struct WorkFolder {
    path: PathBuf,
    files: PathBuf,
    _lock: Locked,
}

impl WorkFolder {
    /// Creates a folder in `parent`, and removes the folders that killed processes left in `parent`.
    pub fn create(parent: &Path) -> Result<WorkFolder> {
        clear_left(parent);
        for _ in 0..ATTEMPTS {
            let path = disk::create_named_folder(parent, NAME)?;
            match open_locked(&path.join(LOCK)) {
                Ok(Some(lock)) => {
                    let work = WorkFolder { files: path.join(FILES), path, _lock: lock };
                    disk::create_folders(&work.files)?;
                    return Ok(work);
                }
                // Another process has just removed it.
                Ok(None) => {}
                Err(error) if error.kind() == ErrorKind::NotFound => {}
                Err(error) => {
                    let _ = disk::remove_folder(&path);
                    return Err(error);
                }
            }
        }
        Err(ErrorKind::ResourceBusy.into())
    }

    /// Path of its files.
    pub fn files(&self) -> &Path {
        &self.files
    }
}

impl Drop for WorkFolder {
    fn drop(&mut self) {
        let _ = disk::remove_tree(&self.path);
    }
}

/// Removes folders that no process owns. Folders that cannot be removed, and all folders on a file system without locks,
/// stay; they are harmless.
pub fn clear_left(parent: &Path) {
    for entry in std::fs::read_dir(parent).into_iter().flatten().flatten() {
        let name = entry.file_name();
        let name = name.to_string_lossy();
        let is_folder = entry.file_type().is_ok_and(|kind| kind.is_dir());
        if !is_folder || !name.starts_with(NAME[0]) || !name.ends_with(NAME[1]) {
            continue;
        }
        let path = entry.path();
        // The lock is created first, but may be lost in a power failure. A folder with neither lock nor files is empty, or of
        // an older version; only an empty one is removed.
        if !path.join(LOCK).exists() && !path.join(FILES).is_dir() {
            let _ = disk::remove_folder(&path);
        } else if let Ok(Some(lock)) = open_locked(&path.join(LOCK))
            && lock.is_locked
        {
            let _ = disk::remove_tree(&path);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> usize {
        std::fs::read_dir(folder).unwrap().count()
    }

    #[test]
    fn removes_folders_that_no_process_owns() {
        let base = tempfile::tempdir().unwrap();
        let owned = WorkFolder::create(base.path()).unwrap();
        std::fs::write(owned.files().join("a"), "1").unwrap();
        // A killed process leaves its files and a lock file that nobody holds.
        for left in [".lightfold.a.partial", ".lightfold.b.partial"] {
            let path = base.path().join(left);
            std::fs::create_dir_all(path.join("files/deep")).unwrap();
            std::fs::write(path.join("files/deep/image"), "1").unwrap();
            std::fs::write(path.join(LOCK), "").unwrap();
        }
        std::fs::create_dir(base.path().join(".lightfold.c.partial")).unwrap();
        for theirs in ["mine", ".lightfold.d.partial", ".other.partial"] {
            std::fs::create_dir(base.path().join(theirs)).unwrap();
            std::fs::write(base.path().join(theirs).join("a"), "").unwrap();
        }
        let second = WorkFolder::create(base.path()).unwrap();
        assert_eq!(names(base.path()), 5);
        assert_eq!(std::fs::read(owned.files().join("a")).unwrap(), b"1");
        drop((owned, second));
        assert_eq!(names(base.path()), 3);
    }

    #[test]
    fn processes_at_once_do_not_disturb_each_other() {
        let base = tempfile::tempdir().unwrap();
        std::thread::scope(|scope| {
            for _ in 0..8 {
                scope.spawn(|| {
                    for _ in 0..20 {
                        let work = WorkFolder::create(base.path()).unwrap();
                        std::fs::write(work.files().join("a"), "1").unwrap();
                    }
                });
            }
        });
        assert_eq!(names(base.path()), 0);
    }
}
