//! Output folders whose files appear together.

use std::io::Write;
use std::path::{Path, PathBuf};

use super::disk::{self, DiskFile};
use super::file_folder::FileFolder;
use super::names::{check_name, parent_of};
use super::work_folder::{WorkFolder, clear_left};
use codec::error::{Error, Result};

/// An output folder whose files appear together, once all of them are written and synced.
#[derive(Debug)]
pub struct OutputFolder {
    path: PathBuf,
    work: WorkFolder,
    /// Dropped after the temporary folder inside it.
    _made: MadeFolders,
}

/// Parents that were created for a folder; the empty ones are removed on drop.
#[derive(Debug)]
pub struct MadeFolders(Vec<PathBuf>);

impl MadeFolders {
    pub fn create(folder: &Path) -> std::io::Result<MadeFolders> {
        disk::create_folders(folder).map(MadeFolders)
    }
}

impl Drop for MadeFolders {
    fn drop(&mut self) {
        for folder in &self.0 {
            // A folder with files stays.
            let _ = disk::remove_folder(folder);
        }
    }
}

impl OutputFolder {
    /// Starts the folder; creates missing parents.
    pub fn create(path: &Path) -> Result<OutputFolder> {
        let io = |error| Error::io(path, error);
        check_name(path)?;
        if std::fs::metadata(path).is_ok_and(|meta| !meta.is_dir()) {
            return Err(Error::Usage(format!("{}: a file, where a folder was expected", path.display())));
        }
        // The temporary folder is beside the output, or inside if the output exists: it may be a mount point or a link to
        // another disk.
        let parent = if path.exists() { path } else { parent_of(path) };
        if std::fs::metadata(parent).is_ok_and(|meta| !meta.is_dir()) {
            return Err(Error::Usage(format!("{}: a file, where a folder was expected", parent.display())));
        }
        let made = MadeFolders::create(parent).map_err(io)?;
        // A killed process that began before the output existed has its temporary folder beside it.
        clear_left(parent_of(path));
        let work = WorkFolder::create(parent).map_err(io)?;
        Ok(OutputFolder { path: path.to_path_buf(), work, _made: made })
    }

    /// Folder to write into until [`Self::commit`].
    pub fn work_path(&self) -> &Path {
        self.work.files()
    }

    /// Replaces the temporary folder by the final one in the path of an error.
    pub fn present(&self, error: Error) -> Error {
        name_final_path(error, self.work_path(), &self.path)
    }

    /// Writes a file at a path relative to the folder; creates missing folders. `write` gets the temporary path; its result
    /// is returned.
    pub fn write<T>(&self, file: &Path, write: impl FnOnce(&Path) -> Result<T>) -> Result<T> {
        let path = self.work_path().join(file);
        let made = disk::create_folders(parent_of(&path)).map_err(|error| Error::io(&path, error));
        made.and_then(|_| write(&path)).map_err(|error| self.present(error))
    }

    /// Writes a file with these bytes.
    pub fn write_bytes(&self, file: &Path, bytes: &[u8]) -> Result<()> {
        self.write(file, |path| {
            let written = DiskFile::create(path).and_then(|mut out| out.write_all(bytes));
            written.map_err(|error| Error::io(path, error))
        })
    }

    /// Moves all files to the final folder and replaces files of the same names in it.
    pub fn commit(self) -> Result<()> {
        let moved =
            disk::sync_tree(self.work.files()).and_then(|()| rename_or_move_into(self.work.files(), &self.path));
        moved.map_err(|error| Error::io(&self.path, error))
    }
}

impl FileFolder for OutputFolder {
    fn made(&self, _file: &Path) -> Option<PathBuf> {
        None
    }

    fn write_file(&self, file: &Path, write: &mut dyn FnMut(&Path) -> Result<()>) -> Result<u64> {
        self.write(file, |path| {
            write(path)?;
            std::fs::metadata(path).map(|meta| meta.len()).map_err(|error| Error::io(path, error))
        })
    }
}

pub fn name_final_path(error: Error, from: &Path, to: &Path) -> Error {
    match error {
        Error::Io { file, source } => {
            let file = file.strip_prefix(from).map_or(file.clone(), |below| to.join(below));
            Error::Io { file, source }
        }
        other => other,
    }
}

/// Renames a folder to its final name, or moves its content if a folder of that name exists, which another process may have
/// just created. The content must be synced before; the directory entries are on disk on return.
pub fn rename_or_move_into(from: &Path, to: &Path) -> std::io::Result<()> {
    if !to.exists() {
        match disk::rename(from, to) {
            Ok(()) => return disk::sync_folder(parent_of(to)),
            Err(error) if !to.is_dir() => return Err(error),
            Err(_) => {}
        }
    }
    move_into(from, to)
}

/// Moves the content of a folder: subfolders first, then files, and JSON files last, because they describe the other files.
fn move_into(from: &Path, to: &Path) -> std::io::Result<()> {
    disk::create_folders(to)?;
    let mut entries = Vec::new();
    for entry in std::fs::read_dir(from)? {
        let entry = entry?;
        let is_file = !entry.file_type()?.is_dir();
        let is_description = Path::new(&entry.file_name()).extension().is_some_and(|end| end == "json");
        entries.push((is_file, is_description, entry.file_name()));
    }
    entries.sort();
    for (is_file, is_description, name) in entries {
        if is_description {
            disk::sync_folder(to)?;
        }
        let (from, to) = (from.join(&name), to.join(&name));
        if is_file { disk::rename(&from, &to) } else { move_into(&from, &to) }?;
    }
    disk::sync_folder(to)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_appears_whole_and_joins_one_that_exists() {
        let base = tempfile::tempdir().unwrap();
        let path = base.path().join("new/out");
        for name in ["a/x", "a/y"] {
            let folder = OutputFolder::create(&path).unwrap();
            std::fs::create_dir(folder.work_path().join("a")).unwrap();
            std::fs::write(folder.work_path().join(name), name).unwrap();
            folder.commit().unwrap();
        }
        assert_eq!(std::fs::read_dir(path.join("a")).unwrap().count(), 2);
        drop(OutputFolder::create(&path).unwrap());
        assert_eq!(std::fs::read_dir(base.path().join("new")).unwrap().count(), 1);
        drop(OutputFolder::create(&base.path().join("other/deep/out")).unwrap());
        assert!(!base.path().join("other").exists());
    }
}
