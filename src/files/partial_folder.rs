//! An output folder whose files are collected beside it, so that a later process can resume.

use std::ffi::OsString;
use std::fs::File;
use std::io::{Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use super::atomic::parent_of;
use super::lock::{Locked, open_locked};
use super::output_folder::{MadeFolders, name_final_path, rename_or_move_into};
use crate::error::{Error, Result};

/// Names in and around an unfinished folder.
#[derive(Debug, Clone, Copy)]
pub struct FolderKind {
    /// Ending of the folder's name, after a dot and the name of the output.
    pub suffix: &'static str,
    /// The locked file in it that describes the work.
    pub state: &'static str,
    /// Extension of the files that are counted.
    pub extension: &'static str,
    /// A further file that is moved to the output.
    pub manifest: &'static str,
}

/// An unfinished folder that is locked by this process. Dropping it removes the folder, unless it was committed, kept, or
/// left by an earlier process.
#[derive(Debug)]
pub struct PartialFolder {
    kind: FolderKind,
    output: PathBuf,
    path: PathBuf,
    state: File,
    is_locked: bool,
    keep: bool,
    /// Dropped after the folder in it is removed.
    _made: MadeFolders,
}

impl PartialFolder {
    /// Opens the unfinished folder of an output with its content; a new one is empty. Missing parents are created.
    pub fn open(output: &Path, kind: FolderKind) -> Result<PartialFolder> {
        PartialFolder::open_part(output, kind, "")
    }

    /// The same, where several processes may each write a part of the output, by the part's name.
    pub fn open_part(output: &Path, kind: FolderKind, part: &str) -> Result<PartialFolder> {
        let io = |error| Error::io(output, error);
        if std::fs::metadata(output).is_ok_and(|meta| !meta.is_dir()) {
            return Err(Error::Usage(format!("{}: a file, where a folder was expected", output.display())));
        }
        if output.is_symlink() && !output.exists() {
            return Err(Error::Usage(format!(
                "{}: a link that leads nowhere, where a folder was expected; remove it, or make what it leads to",
                output.display()
            )));
        }
        let path = path_for(output, &format!("{part}{}", kind.suffix))?;
        if path.symlink_metadata().is_ok_and(|meta| !meta.is_dir()) {
            return Err(Error::Usage(format!("{}: it is in the way, and no folder; remove it", path.display())));
        }
        let made = MadeFolders::create(parent_of(&path)).map_err(io)?;
        std::fs::create_dir_all(&path).map_err(io)?;
        let Some(Locked { file, is_locked }) = open_locked(&path.join(kind.state)).map_err(io)? else {
            let place = path.display();
            let message = format!("another lightfold is writing it, in {place}; wait for it, or name another folder");
            return Err(Error::busy(output, message));
        };
        // On a full disk the state may be empty beside intact images.
        let keep = file.metadata().is_ok_and(|meta| meta.len() > 0) || kind.count(&path) > 0;
        Ok(PartialFolder { kind, output: output.to_path_buf(), path, state: file, is_locked, keep, _made: made })
    }

    /// False where the file system has no locks.
    pub fn is_locked(&self) -> bool {
        self.is_locked
    }

    /// Where to write until [`Self::commit`].
    pub fn work_path(&self) -> &Path {
        &self.path
    }

    /// The text that an earlier process gave to [`Self::start_over`]; empty for a new folder.
    pub fn state(&mut self) -> Result<String> {
        let mut text = String::new();
        let read = self.state.seek(SeekFrom::Start(0)).and_then(|_| self.state.read_to_string(&mut text));
        read.map(|_| text).map_err(|error| Error::io(self.path.join(self.kind.state), error))
    }

    pub fn files(&self) -> u64 {
        self.kind.count(&self.path)
    }

    /// Removes all files and writes a new state.
    pub fn start_over(&mut self, state: &str) -> Result<()> {
        self.keep = false;
        let io = |error| Error::io(&self.path, error);
        for entry in std::fs::read_dir(&self.path).map_err(io)? {
            let path = entry.map_err(io)?.path();
            if path.file_name() != Some(self.kind.state.as_ref()) {
                let is_folder = path.symlink_metadata().is_ok_and(|meta| meta.is_dir());
                if is_folder { std::fs::remove_dir_all(&path) } else { std::fs::remove_file(&path) }.map_err(io)?;
            }
        }
        let file = &mut self.state;
        let written = file.set_len(0).and_then(|()| file.seek(SeekFrom::Start(0)));
        written.and_then(|_| file.write_all(state.as_bytes())).and_then(|()| file.sync_all()).map_err(io)
    }

    pub fn keep(&mut self) {
        self.keep = true;
    }

    pub fn present(&self, error: Error) -> Error {
        name_final_path(error, &self.path, &self.output)
    }

    /// Moves images and the manifest to the output, replacing files of the same names. Other files are removed.
    /// After an error a later process can resume with the rest.
    pub fn commit(&mut self) -> Result<()> {
        let (output, state) = (&self.output, self.kind.state);
        let io = |error| Error::io(output, error);
        self.keep = true;
        self.kind.remove_foreign(&self.path).map_err(io)?;
        match rename_or_move_into(&self.path, output, &|name| name != state).map_err(io)? {
            true => std::fs::remove_file(output.join(state)).map_err(io),
            false => std::fs::remove_dir_all(&self.path).map_err(io),
        }
    }
}

/// Beside the output; or inside an existing output, which may be a mount point or a link, unless one is beside it.
fn path_for(output: &Path, suffix: &str) -> Result<PathBuf> {
    let beside = output.file_name().map(|name| {
        let mut own = OsString::from(".");
        own.push(name);
        own.push(suffix);
        output.with_file_name(own)
    });
    match beside {
        Some(beside) if beside.exists() || !output.exists() => Ok(beside),
        _ if output.is_dir() => Ok(output.join(suffix)),
        _ => Err(Error::Usage(format!("{}: no name of a folder", output.display()))),
    }
}

impl FolderKind {
    fn remove_foreign(&self, folder: &Path) -> std::io::Result<()> {
        for entry in std::fs::read_dir(folder)? {
            let entry = entry?;
            let name = entry.file_name();
            if entry.file_type()?.is_dir() {
                self.remove_foreign(&entry.path())?;
            } else if !self.is_image(Path::new(&name)) && name != self.manifest && name != self.state {
                std::fs::remove_file(entry.path())?;
            }
        }
        Ok(())
    }

    fn is_image(&self, path: &Path) -> bool {
        path.extension().is_some_and(|extension| extension == self.extension)
    }

    fn count(&self, folder: &Path) -> u64 {
        let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
        let files = entries.map(|entry| {
            let path = entry.path();
            match entry.file_type() {
                Ok(kind) if kind.is_dir() => self.count(&path),
                Ok(_) => u64::from(self.is_image(&path)),
                Err(_) => 0,
            }
        });
        files.sum()
    }
}

impl Drop for PartialFolder {
    fn drop(&mut self) {
        if !self.keep && !std::thread::panicking() {
            let _ = std::fs::remove_dir_all(&self.path);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STATE: &str = ".capture.json";
    const CAPTURE: FolderKind =
        FolderKind { suffix: ".capture.partial", state: STATE, extension: "exr", manifest: "lightfield.json" };

    fn names(folder: &Path) -> Vec<String> {
        let entries = std::fs::read_dir(folder).unwrap();
        let mut names: Vec<String> = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    #[test]
    fn what_is_kept_is_gone_on_with_and_what_is_not_goes() {
        let base = tempfile::tempdir().unwrap();
        let output = base.path().join("deep/cap");
        let mut folder = PartialFolder::open(&output, CAPTURE).unwrap();
        assert_eq!(folder.state().unwrap(), "");
        folder.start_over("of a").unwrap();
        std::fs::create_dir(folder.work_path().join("sub")).unwrap();
        std::fs::write(folder.work_path().join("sub/one.exr"), "1").unwrap();
        assert_eq!(folder.files(), 1);
        let second = PartialFolder::open(&output, CAPTURE);
        assert!(matches!(second, Err(Error::Io { .. })), "there are two of them");
        folder.keep();
        drop(folder);
        let mut folder = PartialFolder::open(&output, CAPTURE).unwrap();
        assert_eq!((folder.state().unwrap().as_str(), folder.files()), ("of a", 1));
        drop(folder);
        assert_eq!(names(&base.path().join("deep")), [".cap.capture.partial"], "it was not ours to remove");
        let mut folder = PartialFolder::open(&output, CAPTURE).unwrap();
        folder.start_over("of b").unwrap();
        assert_eq!(folder.files(), 0);
        drop(folder);
        assert_eq!(names(&base.path().join("deep")), [""; 0]);
    }

    #[test]
    fn everything_moves_to_the_output_also_where_there_is_one() {
        let base = tempfile::tempdir().unwrap();
        let output = base.path().join("cap");
        for (round, expected) in [(0, vec!["a.exr", "sub"]), (1, vec!["a.exr", "sub"])] {
            let mut folder = PartialFolder::open(&output, CAPTURE).unwrap();
            folder.start_over("of it").unwrap();
            std::fs::create_dir(folder.work_path().join("sub")).unwrap();
            for name in ["a.exr", "sub/b.exr", "notes.txt", "sub/b.exr.partial"] {
                std::fs::write(folder.work_path().join(name), round.to_string()).unwrap();
            }
            folder.commit().unwrap();
            drop(folder);
            assert_eq!(names(&output), expected);
            assert_eq!(names(&output.join("sub")), ["b.exr"]);
            assert_eq!(std::fs::read(output.join("sub/b.exr")).unwrap(), round.to_string().as_bytes());
            assert_eq!(names(base.path()), ["cap"]);
        }
    }

    #[test]
    fn images_without_a_state_are_not_removed() {
        let base = tempfile::tempdir().unwrap();
        let left = base.path().join(".cap.capture.partial");
        std::fs::create_dir(&left).unwrap();
        std::fs::write(left.join("a.exr"), "1").unwrap();
        std::fs::write(left.join(STATE), "").unwrap();
        let mut folder = PartialFolder::open(&base.path().join("cap"), CAPTURE).unwrap();
        assert_eq!((folder.state().unwrap().as_str(), folder.files()), ("", 1));
        drop(folder);
        assert_eq!(names(&left), [STATE, "a.exr"]);
    }

    #[test]
    #[cfg(unix)]
    fn a_link_that_leads_nowhere_is_refused() {
        let base = tempfile::tempdir().unwrap();
        std::os::unix::fs::symlink(base.path().join("gone"), base.path().join("cap")).unwrap();
        let said = PartialFolder::open(&base.path().join("cap"), CAPTURE).unwrap_err().to_string();
        assert!(said.contains("leads nowhere"), "{said}");
        assert_eq!(names(base.path()), ["cap"]);
    }

    #[test]
    fn parents_that_were_made_for_nothing_are_removed() {
        let base = tempfile::tempdir().unwrap();
        drop(PartialFolder::open(&base.path().join("new/deep/cap"), CAPTURE).unwrap());
        assert_eq!(names(base.path()), [""; 0]);
    }

    #[test]
    fn what_lies_in_the_way_is_left_alone() {
        let base = tempfile::tempdir().unwrap();
        std::fs::write(base.path().join("cap"), "theirs").unwrap();
        assert!(PartialFolder::open(&base.path().join("cap"), CAPTURE).is_err());
        std::fs::write(base.path().join(".other.capture.partial"), "theirs").unwrap();
        let said = PartialFolder::open(&base.path().join("other"), CAPTURE).unwrap_err().to_string();
        assert!(said.contains("in the way"), "{said}");
        assert_eq!(names(base.path()), [".other.capture.partial", "cap"]);
        assert!(PartialFolder::open(&base.path().join("none/.."), CAPTURE).is_err());
    }
}
