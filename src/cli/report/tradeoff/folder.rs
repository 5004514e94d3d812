//! Output folder of a sweep. It is locked against other processes, and files of killed processes and pictures of
//! earlier points are removed.

use std::io::ErrorKind;
use std::path::{Component, Path, PathBuf};

use serde_json::Value;

use super::kind::SweepKind;
use super::page::PAGE;
use codec::error::{Error, Result};
use footage::files::{DiskFile, WorkFolder, create_folders, open_locked, remove_file};

const LOCK: &str = ".tradeoff.lock";
const PICTURES: &[&str] = &["svg", "png", "html"];

/// A folder that is locked against other measuring processes.
pub struct Folder {
    path: PathBuf,
    kind: &'static SweepKind,
    /// The lock is held while this file is open.
    _lock: DiskFile,
}

impl Folder {
    /// Creates the folder if it is missing, and locks it.
    pub fn open(path: &Path, kind: &'static SweepKind) -> Result<Folder> {
        create_folders(path).map_err(|error| Error::io(path, error))?;
        let busy = || Error::busy(path, "another tradeoff process writes to it: wait, or use another folder");
        let lock = path.join(LOCK);
        let _lock = open_locked(&lock).map_err(|error| Error::io(&lock, error))?.ok_or_else(busy)?.file;
        Ok(Folder { path: path.to_path_buf(), kind, _lock })
    }

    /// Path of the JSON report.
    pub fn report(&self) -> PathBuf {
        self.path.join(self.kind.json_name())
    }

    /// Names of the files, other than pictures, that a sweep overwrites regardless of their content.
    fn replaced(&self) -> Vec<String> {
        match self.kind.is_resumable {
            true => vec![PAGE.to_owned()],
            false => vec![self.kind.csv_name(), self.kind.json_name(), PAGE.to_owned()],
        }
    }

    /// Returns a file that the sweep would overwrite and cannot be resumed from.
    pub fn in_the_way(&self) -> Option<PathBuf> {
        let own = if self.kind.is_resumable { self.files() } else { Vec::new() };
        let mut lost = self.replaced().into_iter().filter(|name| !own.contains(name)).map(|name| self.path.join(name));
        lost.find(|path| path.exists())
    }

    /// Creates a subfolder for unfinished work. It is removed when dropped, and so are those of killed processes.
    pub fn work(&self) -> Result<WorkFolder> {
        WorkFolder::create(&self.path).map_err(|error| Error::io(&self.path, error))
    }

    /// Returns the names of the existing files that the last report lists.
    pub fn files(&self) -> Vec<String> {
        let text = std::fs::read_to_string(self.report()).unwrap_or_default();
        let report: Value = serde_json::from_str(&text).unwrap_or_default();
        let names = report["files"].as_array().into_iter().flatten().filter_map(Value::as_str);
        let is_name = |name: &&str| {
            let mut parts = Path::new(name).components();
            matches!((parts.next(), parts.next()), (Some(Component::Normal(_)), None))
        };
        names.filter(is_name).filter(|name| self.path.join(name).is_file()).map(str::to_owned).collect()
    }

    /// Removes the last report and its pictures. Removes the CSV and the page as well, unless the sweep is resumed from
    /// the CSV.
    pub fn clear(&self) -> Result<()> {
        let is_picture =
            |name: &String| Path::new(name).extension().is_some_and(|of| PICTURES.iter().any(|end| of == *end));
        let mut names: Vec<String> = self.files().into_iter().filter(is_picture).collect();
        names.push(self.kind.json_name());
        if !self.kind.is_resumable {
            names.extend(self.replaced());
        }
        names.into_iter().try_for_each(|name| remove(&self.path.join(name)))
    }
}

fn remove(path: &Path) -> Result<()> {
    match remove_file(path) {
        Err(error) if error.kind() != ErrorKind::NotFound => Err(Error::io(path, error)),
        _ => Ok(()),
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        // If removal fails, the file stays but is not locked.
        let _ = remove_file(&self.path.join(LOCK));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::tradeoff::kind::{CODING, RENDERING};

    #[test]
    fn one_process_at_a_time_and_nothing_stays() {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join("out");
        let first = Folder::open(&path, &CODING).unwrap();
        let said = Folder::open(&path, &CODING).err().unwrap().to_string();
        assert!(said.contains("another tradeoff process writes to it"), "{said}");
        drop(first);
        assert_eq!(std::fs::read_dir(&path).unwrap().count(), 0);
        drop(Folder::open(&path, &CODING).unwrap());
    }

    #[test]
    fn nothing_is_replaced_but_what_a_report_lists() {
        let place = tempfile::tempdir().unwrap();
        let put = |name: &str, text: &str| std::fs::write(place.path().join(name), text).unwrap();
        put(PAGE, "");
        {
            let folder = Folder::open(place.path(), &CODING).unwrap();
            assert_eq!(folder.in_the_way(), Some(place.path().join(PAGE)));
            put("tradeoff.json", r#"{ "files": ["index.html"] }"#);
            assert_eq!(folder.in_the_way(), None);
            assert!(folder.work().unwrap().files().starts_with(place.path()));
        }
        let folder = Folder::open(place.path(), &RENDERING).unwrap();
        assert_eq!(folder.in_the_way(), Some(place.path().join(PAGE)));
        put("rendering.csv", "");
        put("rendering.svg", "");
        put("render.svg", "");
        put("rendering.json", r#"{ "files": ["rendering.svg"] }"#);
        assert_eq!(folder.in_the_way(), Some(place.path().join("rendering.csv")));
        folder.clear().unwrap();
        let left = [PAGE, "rendering.csv", "rendering.svg", "rendering.json", "render.svg", "tradeoff.json"];
        let left = left.map(|name| place.path().join(name).exists());
        assert_eq!(left, [false, false, false, false, true, true]);
        assert_eq!(folder.in_the_way(), None);
    }

    #[test]
    fn removes_what_a_killed_process_left_and_nothing_else() {
        let place = tempfile::tempdir().unwrap();
        std::fs::create_dir(place.path().join(".lightfold.abc.partial")).unwrap();
        for name in
            [".lightfold.abc.partial/point.lfold", ".lightfold.abc.partial/lock", "tradeoff.csv", "a.partial", LOCK]
        {
            std::fs::write(place.path().join(name), "").unwrap();
        }
        drop(Folder::open(place.path(), &CODING).unwrap().work().unwrap());
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
        std::fs::write(path.join("tradeoff.json"), files).unwrap();
        let folder = Folder::open(&path, &CODING).unwrap();
        assert_eq!(folder.files(), ["a.png", "notes.txt", "index.html"]);
        folder.clear().unwrap();
        drop(folder);
        let mut left: Vec<_> = std::fs::read_dir(&path).unwrap().map(|entry| entry.unwrap().file_name()).collect();
        left.sort();
        assert_eq!(left, ["b.png", "notes.txt"]);
        assert!(place.path().join("c.png").is_file());
    }
}
