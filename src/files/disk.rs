//! Operations that change files and folders. The crate calls the system for them here only (`clippy.toml`), so that a test can
//! record what a command does, and in which order (`record`).

use std::fs::File;
use std::io::{Read, Result, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use super::names::parent_of;

#[cfg(feature = "internals")]
use super::record::{self, Operation};

/// An open file that may be written.
#[derive(Debug)]
pub struct DiskFile {
    file: File,
    #[cfg(feature = "internals")]
    handle: record::Handle,
}

/// Calls the system, and lets recorders know what was done.
macro_rules! recorded {
    ($call:expr, $operation:expr) => {{
        #[cfg(feature = "internals")]
        let result = record::done(|| $call, |_| $operation);
        #[cfg(not(feature = "internals"))]
        let result = $call;
        result
    }};
}

impl DiskFile {
    /// Creates a file, or empties an existing one.
    pub fn create(path: &Path) -> Result<DiskFile> {
        DiskFile::open_as(path, File::options().write(true).create(true).truncate(true), true)
    }

    /// Opens a file with its content, and creates one where there is none.
    pub fn open(path: &Path) -> Result<DiskFile> {
        DiskFile::open_as(path, File::options().read(true).write(true).create(true).truncate(false), false)
    }

    /// Opens a pipe or a device.
    pub fn device(path: &Path) -> Result<File> {
        File::options().write(true).open(path)
    }

    /// A file without a name, which is gone when it is closed.
    pub fn scratch(folder: &Path) -> Result<File> {
        tempfile::tempfile_in(folder)
    }

    #[cfg_attr(not(feature = "internals"), allow(unused_variables))]
    fn open_as(path: &Path, options: &std::fs::OpenOptions, is_emptied: bool) -> Result<DiskFile> {
        #[cfg(feature = "internals")]
        let handle = record::Handle::new();
        let file = recorded!(
            options.open(path),
            Operation::Open { handle: handle.number(), path: path.to_path_buf(), is_emptied }
        )?;
        #[cfg(feature = "internals")]
        let handle = handle.of(path);
        Ok(DiskFile {
            file,
            #[cfg(feature = "internals")]
            handle,
        })
    }

    /// The same open file, with the same position.
    pub fn try_clone(&self) -> Result<DiskFile> {
        Ok(DiskFile {
            file: self.file.try_clone()?,
            #[cfg(feature = "internals")]
            handle: self.handle.clone(),
        })
    }

    /// The file for reading, locks and times.
    pub fn file(&self) -> &File {
        &self.file
    }

    pub fn set_len(&self, bytes: u64) -> Result<()> {
        recorded!(self.file.set_len(bytes), Operation::SetLen { handle: self.handle.number(), bytes })
    }

    /// Waits until the content is on the disk.
    pub fn sync(&self) -> Result<()> {
        recorded!(self.file.sync_all(), Operation::Sync { handle: self.handle.number() })
    }
}

#[cfg(test)]
impl From<File> for DiskFile {
    fn from(file: File) -> DiskFile {
        DiskFile {
            file,
            #[cfg(feature = "internals")]
            handle: record::Handle::new(),
        }
    }
}

impl Write for DiskFile {
    fn write(&mut self, bytes: &[u8]) -> Result<usize> {
        #[cfg(feature = "internals")]
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

/// Waits until the content of a file is on the disk, by its name. The system reports a write that failed since to the first
/// that asks, also if it has opened the file only now.
pub fn sync_file(path: &Path) -> Result<()> {
    // Windows syncs what is open for writing only.
    let open = || File::options().read(true).write(cfg!(windows)).open(path);
    recorded!(open().and_then(|file| file.sync_all()), Operation::SyncFile { path: path.to_path_buf() })
}

/// Waits until the names in a folder are on the disk, on systems that sync folders.
#[cfg(unix)]
pub fn sync_folder(folder: &Path) -> Result<()> {
    use std::io::ErrorKind::{InvalidInput, PermissionDenied, Unsupported};
    // A folder may be writable without being readable.
    let done = match File::open(folder).and_then(|opened| opened.sync_all()) {
        Err(error) if !matches!(error.kind(), InvalidInput | PermissionDenied | Unsupported) => Err(error),
        _ => Ok(()),
    };
    recorded!(done, Operation::SyncFolder { path: folder.to_path_buf() })
}

#[cfg(not(unix))]
pub fn sync_folder(folder: &Path) -> Result<()> {
    recorded!(Ok(()), Operation::SyncFolder { path: folder.to_path_buf() })
}

/// Gives a file or a folder another name; a file of that name is replaced.
pub fn rename(from: &Path, to: &Path) -> Result<()> {
    recorded!(std::fs::rename(from, to), Operation::Rename { from: from.to_path_buf(), to: to.to_path_buf() })
}

pub fn remove_file(path: &Path) -> Result<()> {
    recorded!(std::fs::remove_file(path), Operation::Remove { path: path.to_path_buf() })
}

/// Removes an empty folder.
pub fn remove_folder(path: &Path) -> Result<()> {
    recorded!(std::fs::remove_dir(path), Operation::Remove { path: path.to_path_buf() })
}

/// Removes a folder with its content; links are not followed.
pub fn remove_tree(path: &Path) -> Result<()> {
    for entry in std::fs::read_dir(path)? {
        let entry = entry?;
        if entry.file_type()?.is_dir() { remove_tree(&entry.path()) } else { remove_file(&entry.path()) }?;
    }
    remove_folder(path)
}

/// Creates a folder and those above it, where they are missing. Returns them, the deepest first; their names are on the disk.
pub fn create_folders(folder: &Path) -> Result<Vec<PathBuf>> {
    let missing = folder.ancestors().take_while(|above| !above.as_os_str().is_empty() && !above.exists());
    let missing: Vec<PathBuf> = missing.map(Path::to_path_buf).collect();
    let mut made = Vec::new();
    for path in missing.iter().rev() {
        match recorded!(std::fs::create_dir(path), Operation::CreateFolder { path: path.clone() }) {
            Ok(()) => made.insert(0, path.clone()),
            // Another thread or process was faster; a name such as `a/..` is there, too, once `a` is.
            Err(_) if path.is_dir() => {}
            Err(error) => return Err(error),
        }
        sync_folder(parent_of(path))?;
    }
    // A file in the way is an error of the system.
    if missing.is_empty() && !folder.as_os_str().is_empty() && !folder.is_dir() {
        std::fs::create_dir(folder)?;
    }
    Ok(made)
}

/// Creates a folder with a name of its own.
pub fn create_named_folder(parent: &Path, [begin, end]: [&str; 2]) -> Result<PathBuf> {
    let created = tempfile::Builder::new().prefix(begin).suffix(end).tempdir_in(parent);
    // Its message has the random name in it.
    let path = created.map_err(|error| std::io::Error::from(error.kind()))?.keep();
    recorded!(Ok(path.clone()), Operation::CreateFolder { path: path.clone() })
}

/// Brings a folder's content to the disk: files, then the names of each folder in it.
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
    // A disk takes several at once in the time of one.
    files.par_iter().try_for_each(|path| sync_file(path))?;
    folders.iter().rev().try_for_each(|path| sync_folder(path))
}
