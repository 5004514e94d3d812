//! The folder of a report: one process at a time, nothing that a killed one left, no pictures of other points.

use std::fs::File;
use std::io::ErrorKind;
use std::path::{Component, Path, PathBuf};

use serde_json::Value;
use tempfile::TempDir;

use crate::error::{Error, Result};
use crate::files::open_locked;

/// The report as JSON, which lists all files.
pub const REPORT: &str = "tradeoff.json";
/// The file that is locked.
const LOCK: &str = ".tradeoff.lock";
/// How names of unfinished files and folders begin and end.
const UNFINISHED: [&str; 2] = [".tradeoff.", ".partial"];
/// The page that each kind of sweep writes.
pub const PAGE: &str = "index.html";
/// Endings of files that are removed when they show other points.
const PICTURES: &[&str] = &["svg", "png", "html"];

/// A folder that no other process measures into.
pub struct Folder {
    path: PathBuf,
    /// Locked for as long as it is open.
    _lock: File,
}

impl Folder {
    /// Makes the folder if there is none, locks it, and removes what killed processes left.
    ///
    /// # Errors
    /// When another process has the lock, or the folder cannot be written.
    pub fn open(path: &Path) -> Result<Folder> {
        std::fs::create_dir_all(path).map_err(|error| Error::io(path, error))?;
        let busy = || {
            Error::Usage(format!("{}: another tradeoff measures into it; wait, or name another folder", path.display()))
        };
        let lock = path.join(LOCK);
        let _lock = open_locked(&lock).map_err(|error| Error::io(&lock, error))?.ok_or_else(busy)?.file;
        let folder = Folder { path: path.to_path_buf(), _lock };
        let [begin, end] = UNFINISHED;
        for entry in std::fs::read_dir(path).map_err(|error| Error::io(path, error))?.flatten() {
            let name = entry.file_name();
            let name = name.to_string_lossy();
            if name.starts_with(begin) && name.ends_with(end) {
                // What cannot be removed is in nobody's way.
                let is_folder = entry.file_type().is_ok_and(|kind| kind.is_dir());
                let _ =
                    if is_folder { std::fs::remove_dir_all(entry.path()) } else { std::fs::remove_file(entry.path()) };
            }
        }
        Ok(folder)
    }

    /// Refuses to replace files of these names that are not of the sweep itself.
    pub fn refuse_to_replace(&self, names: &[&str], own: &[String]) -> Result<()> {
        let is_lost = |name: &&&str| self.path.join(name).exists() && !own.iter().any(|other| other == **name);
        match names.iter().find(is_lost) {
            None => Ok(()),
            Some(name) => Err(Error::Usage(format!(
                "{}: there already, and would be lost; name another folder, or replace it by --overwrite",
                self.path.join(name).display()
            ))),
        }
    }

    /// Removes files of these names, and pictures whose names begin with `stem`.
    pub fn remove(&self, names: &[&str], stem: &str) -> Result<()> {
        let is_picture = |path: &Path| {
            let begins = path.file_name().is_some_and(|name| name.to_string_lossy().starts_with(stem));
            begins && path.extension().is_some_and(|of| PICTURES.iter().any(|end| of == *end))
        };
        let entries = std::fs::read_dir(&self.path).map_err(|error| Error::io(&self.path, error))?;
        let pictures = entries.flatten().map(|entry| entry.path()).filter(|path| is_picture(path));
        names.iter().map(|name| self.path.join(name)).chain(pictures).try_for_each(|path| remove(&path))
    }

    /// A folder in it for unfinished work, which goes when it is dropped.
    pub fn work(&self) -> Result<TempDir> {
        let [begin, end] = UNFINISHED;
        let work = tempfile::Builder::new().prefix(begin).suffix(end).tempdir_in(&self.path);
        work.map_err(|error| Error::io(&self.path, error.kind().into()))
    }

    /// Names of the files that the last report lists and that are there.
    pub fn files(&self) -> Vec<String> {
        let text = std::fs::read_to_string(self.path.join(REPORT)).unwrap_or_default();
        let report: Value = serde_json::from_str(&text).unwrap_or_default();
        let names = report["files"].as_array().into_iter().flatten().filter_map(Value::as_str);
        let is_name = |name: &&str| {
            let mut parts = Path::new(name).components();
            matches!((parts.next(), parts.next()), (Some(Component::Normal(_)), None))
        };
        names.filter(is_name).filter(|name| self.path.join(name).is_file()).map(str::to_owned).collect()
    }

    /// Removes the last report and its pictures.
    pub fn clear(&self) -> Result<()> {
        let is_picture =
            |name: &String| Path::new(name).extension().is_some_and(|of| PICTURES.iter().any(|end| of == *end));
        for name in self.files().into_iter().filter(is_picture).chain([REPORT.to_owned()]) {
            remove(&self.path.join(name))?;
        }
        Ok(())
    }
}

/// Removes a file, if it is there.
fn remove(path: &Path) -> Result<()> {
    match std::fs::remove_file(path) {
        Err(error) if error.kind() != ErrorKind::NotFound => Err(Error::io(path, error)),
        _ => Ok(()),
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        // A file that stays is in nobody's way: it is not locked.
        let _ = std::fs::remove_file(self.path.join(LOCK));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_process_at_a_time_and_nothing_stays() {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join("out");
        let first = Folder::open(&path).unwrap();
        let said = Folder::open(&path).err().unwrap().to_string();
        assert!(said.contains("another tradeoff measures into it"), "{said}");
        drop(first);
        assert_eq!(std::fs::read_dir(&path).unwrap().count(), 0);
        drop(Folder::open(&path).unwrap());
    }

    #[test]
    fn nothing_is_replaced_but_what_a_report_lists() {
        let place = tempfile::tempdir().unwrap();
        let folder = Folder::open(place.path()).unwrap();
        for name in [PAGE, "rendering.csv", "rendering.svg", "render.svg", "rendering.txt"] {
            std::fs::write(place.path().join(name), "").unwrap();
        }
        let said = folder.refuse_to_replace(&["a.csv", PAGE], &folder.files()).unwrap_err().to_string();
        assert!(said.contains(PAGE) && said.contains("another folder") && said.contains("--overwrite"), "{said}");
        std::fs::write(place.path().join(REPORT), r#"{ "files": ["index.html"] }"#).unwrap();
        folder.refuse_to_replace(&["a.csv", PAGE], &folder.files()).unwrap();
        assert!(folder.refuse_to_replace(&["rendering.csv"], &folder.files()).is_err());
        let work = folder.work().unwrap();
        assert!(work.path().starts_with(place.path()));
        folder.remove(&["rendering.csv", "a.csv"], "rendering").unwrap();
        let left = [PAGE, "rendering.csv", "rendering.svg", "render.svg", "rendering.txt"];
        assert_eq!(left.map(|name| place.path().join(name).exists()), [true, false, false, true, true]);
    }

    #[test]
    fn what_a_killed_process_left_is_removed_and_nothing_else() {
        let place = tempfile::tempdir().unwrap();
        std::fs::create_dir(place.path().join(".tradeoff.abc.partial")).unwrap();
        for name in [".tradeoff.abc.partial/point.lfold", ".tradeoff.csv.x.partial", "tradeoff.csv", "a.partial", LOCK]
        {
            std::fs::write(place.path().join(name), "").unwrap();
        }
        drop(Folder::open(place.path()).unwrap());
        let mut left: Vec<_> =
            std::fs::read_dir(place.path()).unwrap().map(|entry| entry.unwrap().file_name()).collect();
        left.sort();
        assert_eq!(left, ["a.partial", "tradeoff.csv"]);
    }

    #[test]
    fn only_pictures_that_the_report_lists_are_removed() {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join("out");
        std::fs::create_dir(&path).unwrap();
        for name in ["a.png", "b.png", "notes.txt", "index.html", "../c.png"] {
            std::fs::write(path.join(name), "").unwrap();
        }
        let files = r#"{ "files": ["a.png", "notes.txt", "index.html", "../c.png", "gone.svg", 5] }"#;
        std::fs::write(path.join(REPORT), files).unwrap();
        let folder = Folder::open(&path).unwrap();
        assert_eq!(folder.files(), ["a.png", "notes.txt", "index.html"]);
        folder.clear().unwrap();
        drop(folder);
        let mut left: Vec<_> = std::fs::read_dir(&path).unwrap().map(|entry| entry.unwrap().file_name()).collect();
        left.sort();
        assert_eq!(left, ["b.png", "notes.txt"]);
        assert!(place.path().join("c.png").is_file());
    }
}
