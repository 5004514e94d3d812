//! Output folders, whose files appear together.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use tempfile::TempDir;

use super::atomic::parent_of;
use crate::error::{Error, Result};

/// An output folder whose files appear only when all of them are written.
#[derive(Debug)]
pub struct OutputFolder {
    path: PathBuf,
    work: TempDir,
    /// Dropped after the temporary folder in it.
    _made: MadeFolders,
}

/// Parents that were made for a folder; those that are empty are removed at the end.
#[derive(Debug)]
pub struct MadeFolders(Vec<PathBuf>);

impl MadeFolders {
    pub fn create(folder: &Path) -> std::io::Result<MadeFolders> {
        let missing = folder.ancestors().take_while(|above| !above.as_os_str().is_empty() && !above.exists());
        let made = MadeFolders(missing.map(Path::to_path_buf).collect());
        std::fs::create_dir_all(folder)?;
        Ok(made)
    }
}

impl Drop for MadeFolders {
    fn drop(&mut self) {
        for folder in &self.0 {
            // One with files stays.
            let _ = std::fs::remove_dir(folder);
        }
    }
}

impl OutputFolder {
    /// Starts the folder; its parents are made where they are missing.
    pub fn create(path: &Path) -> Result<OutputFolder> {
        let io = |error| Error::io(path, error);
        if std::fs::metadata(path).is_ok_and(|meta| !meta.is_dir()) {
            return Err(Error::Usage(format!("{}: a file, where a folder was expected", path.display())));
        }
        // Beside the folder, or inside where it exists: it may be a mount point or a link to another disk.
        let parent = if path.exists() { path } else { parent_of(path) };
        if std::fs::metadata(parent).is_ok_and(|meta| !meta.is_dir()) {
            return Err(Error::Usage(format!("{}: a file, where a folder was expected", parent.display())));
        }
        let made = MadeFolders::create(parent).map_err(io)?;
        let work = tempfile::Builder::new().prefix(".lightfold.").suffix(".partial").tempdir_in(parent);
        let work = work.map_err(|error| io(error.kind().into()))?;
        Ok(OutputFolder { path: path.to_path_buf(), work, _made: made })
    }

    /// Where to write until [`Self::commit`].
    pub fn work_path(&self) -> &Path {
        self.work.path()
    }

    /// Replaces the temporary folder by the final one in an error's path.
    pub fn present(&self, error: Error) -> Error {
        name_final_path(error, self.work_path(), &self.path)
    }

    /// Moves everything to the final folder; files of the same names there are replaced.
    pub fn commit(self) -> Result<()> {
        let path = &self.path;
        let io = |error| Error::io(path, error);
        #[cfg(unix)]
        std::fs::set_permissions(self.work.path(), std::os::unix::fs::PermissionsExt::from_mode(0o755)).map_err(io)?;
        if rename_or_move_into(self.work.path(), path, &|_| true).map_err(io)? {
            // There is nothing left to remove under the old name.
            let _ = self.work.keep();
        }
        Ok(())
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

/// Gives a folder its final name, and answers true; or moves its content, except for names that are not wanted, where there is a
/// folder of that name, which another process may have made a moment ago.
pub fn rename_or_move_into(from: &Path, to: &Path, is_wanted: &dyn Fn(&OsStr) -> bool) -> std::io::Result<bool> {
    if !to.exists() {
        match std::fs::rename(from, to) {
            Ok(()) => return Ok(true),
            Err(error) if !to.is_dir() => return Err(error),
            Err(_) => {}
        }
    }
    move_into(from, to, is_wanted).map(|()| false)
}

/// Moves the content of a folder, except for names that are not wanted.
fn move_into(from: &Path, to: &Path, is_wanted: &dyn Fn(&OsStr) -> bool) -> std::io::Result<()> {
    std::fs::create_dir_all(to)?;
    for entry in std::fs::read_dir(from)? {
        let entry = entry?;
        if !is_wanted(&entry.file_name()) {
            continue;
        }
        let target = to.join(entry.file_name());
        if entry.file_type()?.is_dir() {
            move_into(&entry.path(), &target, is_wanted)?;
        } else {
            std::fs::rename(entry.path(), target)?;
        }
    }
    Ok(())
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
