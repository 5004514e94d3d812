//! Operations that change files and folders. No other module calls the system for these (`clippy.toml`), so that a test can
//! record the operations of a command in their order (`record`).

use std::fs::File;
use std::io::{Read, Result, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use super::names::parent_of;
use super::record::{self, Operation};

/// An open, writable file.
#[derive(Debug)]
pub struct DiskFile {
    file: File,
    handle: record::Handle,
}

impl DiskFile {
    /// Creates a file, or truncates an existing one.
    pub fn create(path: &Path) -> Result<DiskFile> {
        DiskFile::open_as(path, File::options().write(true).create(true).truncate(true), true)
    }

    /// Opens a file and keeps its content; creates it if it is missing.
    pub fn open(path: &Path) -> Result<DiskFile> {
        DiskFile::open_as(path, File::options().read(true).write(true).create(true).truncate(false), false)
    }

    /// Opens a pipe or a device for writing.
    pub fn device(path: &Path) -> Result<File> {
        File::options().write(true).open(path)
    }

    /// Creates a file without a name, which is removed when it is closed.
    pub fn scratch(folder: &Path) -> Result<File> {
        tempfile::tempfile_in(folder)
    }

    fn open_as(path: &Path, options: &std::fs::OpenOptions, is_emptied: bool) -> Result<DiskFile> {
        let handle = record::Handle::new();
        let file = record::done(
            || options.open(path),
            |_| Operation::Open { handle: handle.number(), path: path.to_path_buf(), is_emptied },
        )?;
        let handle = handle.of(path);
        Ok(DiskFile { file, handle })
    }

    /// Returns a second handle of the same open file; both share one position.
    pub fn try_clone(&self) -> Result<DiskFile> {
        Ok(DiskFile { file: self.file.try_clone()?, handle: self.handle.clone() })
    }

    /// Returns the file, for reading, locks and times.
    pub fn file(&self) -> &File {
        &self.file
    }

    pub fn set_len(&self, bytes: u64) -> Result<()> {
        record::done(|| self.file.set_len(bytes), |_| Operation::SetLen { handle: self.handle.number(), bytes })
    }

    /// Waits until the content is on disk.
    pub fn sync(&self) -> Result<()> {
        record::done(|| self.file.sync_all(), |_| Operation::Sync { handle: self.handle.number() })
    }
}

#[cfg(test)]
impl From<File> for DiskFile {
    fn from(file: File) -> DiskFile {
        DiskFile { file, handle: record::Handle::new() }
    }
}

impl Write for DiskFile {
    fn write(&mut self, bytes: &[u8]) -> Result<usize> {
        if self.handle.is_recorded() {
            let at = self.file.stream_position()?;
            let handle = self.handle.number();
            let noted = |written: &usize| Operation::Write { handle, at, bytes: bytes[..*written].to_vec() };
            return record::done(|| self.file.write(bytes), noted);
        }
        self.file.write(bytes)
    }

    fn flush(&mut self) -> Result<()> {
        self.file.flush()
    }
}

impl Read for DiskFile {
    fn read(&mut self, bytes: &mut [u8]) -> Result<usize> {
        self.file.read(bytes)
    }
}

impl Seek for DiskFile {
    fn seek(&mut self, to: SeekFrom) -> Result<u64> {
        self.file.seek(to)
    }
}

/// Waits until the content of the file at `path` is on disk. The system reports an earlier failed write to the first handle
/// that syncs, even if that handle was opened after the write.
pub fn sync_file(path: &Path) -> Result<()> {
    // Windows syncs only files that are open for writing.
    let open = || File::options().read(true).write(cfg!(windows)).open(path);
    record::done(|| open().and_then(|file| file.sync_all()), |_| Operation::SyncFile { path: path.to_path_buf() })
}

/// Waits until the directory entries of a folder are on disk, on systems that sync folders.
#[cfg(unix)]
pub fn sync_folder(folder: &Path) -> Result<()> {
    use std::io::ErrorKind::{InvalidInput, PermissionDenied, Unsupported};
    // A folder may be writable but not readable.
    let done = match File::open(folder).and_then(|opened| opened.sync_all()) {
        Err(error) if !matches!(error.kind(), InvalidInput | PermissionDenied | Unsupported) => Err(error),
        _ => Ok(()),
    };
    record::done(|| done, |_| Operation::SyncFolder { path: folder.to_path_buf() })
}

#[cfg(not(unix))]
pub fn sync_folder(folder: &Path) -> Result<()> {
    record::done(|| Ok(()), |_| Operation::SyncFolder { path: folder.to_path_buf() })
}

/// Renames a file or a folder. An existing file at `to` is replaced.
pub fn rename(from: &Path, to: &Path) -> Result<()> {
    record::done(|| std::fs::rename(from, to), |_| Operation::Rename { from: from.to_path_buf(), to: to.to_path_buf() })
}

pub fn remove_file(path: &Path) -> Result<()> {
    record::done(|| std::fs::remove_file(path), |_| Operation::Remove { path: path.to_path_buf() })
}

/// Removes an empty folder.
pub fn remove_folder(path: &Path) -> Result<()> {
    record::done(|| std::fs::remove_dir(path), |_| Operation::Remove { path: path.to_path_buf() })
}

/// Removes a folder with its content; does not follow links.
pub fn remove_tree(path: &Path) -> Result<()> {
    for entry in std::fs::read_dir(path)? {
        let entry = entry?;
        if entry.file_type()?.is_dir() { remove_tree(&entry.path()) } else { remove_file(&entry.path()) }?;
    }
    remove_folder(path)
}

/// Creates a folder and its missing parents. Returns the created folders, deepest first; their directory entries are on disk.
pub fn create_folders(folder: &Path) -> Result<Vec<PathBuf>> {
    let missing = folder.ancestors().take_while(|above| !above.as_os_str().is_empty() && !above.exists());
    let missing: Vec<PathBuf> = missing.map(Path::to_path_buf).collect();
    let mut made = Vec::new();
    for path in missing.iter().rev() {
        match record::done(|| std::fs::create_dir(path), |_| Operation::CreateFolder { path: path.clone() }) {
            Ok(()) => made.insert(0, path.clone()),
            // Another thread or process has created it. A path such as `a/..` also exists once `a` does.
            Err(_) if path.is_dir() => {}
            Err(error) => return Err(error),
        }
        sync_folder(parent_of(path))?;
    }
    // If a file has this name, the system returns the error.
    if missing.is_empty() && !folder.as_os_str().is_empty() && !folder.is_dir() {
        std::fs::create_dir(folder)?;
    }
    Ok(made)
}

/// Creates a folder with a unique name that starts with `begin` and ends with `end`.
pub fn create_named_folder(parent: &Path, [begin, end]: [&str; 2]) -> Result<PathBuf> {
    let created = tempfile::Builder::new().prefix(begin).suffix(end).tempdir_in(parent);
    // The message of this error contains the random name; only its kind is kept.
    let path = created.map_err(|error| std::io::Error::from(error.kind()))?.keep();
    record::done(|| Ok(path.clone()), |_| Operation::CreateFolder { path: path.clone() })
}

/// Syncs the content of a folder: all files first, then the directory entries of each folder.
pub fn sync_tree(folder: &Path) -> Result<()> {
    use rayon::iter::{IntoParallelRefIterator, ParallelIterator};
    let (mut folders, mut files, mut at) = (vec![folder.to_path_buf()], Vec::new(), 0);
    while at < folders.len() {
        for entry in std::fs::read_dir(&folders[at])? {
            let entry = entry?;
            if entry.file_type()?.is_dir() { &mut folders } else { &mut files }.push(entry.path());
        }
        at += 1;
    }
    // A disk syncs several files in the time of one.
    files.par_iter().try_for_each(|path| sync_file(path))?;
    folders.iter().rev().try_for_each(|path| sync_folder(path))
}
