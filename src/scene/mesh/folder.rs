//! Files that a scene refers to. They are read only from the scene's folder, from below it, and where a name begins with `../`
//! from below its parent. A name that leads to no file there is searched in the scene's folder by its last part, because exporters
//! write the paths of their own machine and other case. A symbolic link counts as its target: one that leads out of the folder is
//! not followed.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::budget::Budget;
use codec::error::{Error, Result};
use footage::files::open_regular;
use footage::fingerprint::digest;

#[derive(Debug)]
pub struct Folder {
    path: PathBuf,
    /// Files read so far; each is read once.
    read: Vec<(PathBuf, Arc<Vec<u8>>)>,
    /// Names of files that could not be read.
    missing: Vec<String>,
    /// Names that a search found, and the files that were read.
    found: Vec<(String, PathBuf)>,
}

/// Maximum number of files and folders that a search looks at.
const MAX_SEARCHED: usize = 10_000;

impl Folder {
    pub fn of(file: &Path) -> Folder {
        Folder {
            path: file.parent().unwrap_or(Path::new("")).to_path_buf(),
            read: Vec::new(),
            missing: Vec::new(),
            found: Vec::new(),
        }
    }

    /// Describes the files that were read from another place than the scene names.
    pub fn notes(&self) -> impl Iterator<Item = String> {
        self.found.iter().map(|(name, path)| format!("“{}” was found as {}", shown(name), path.display()))
    }

    /// Paths of the files that were read, relative to the scene's folder where they are below it.
    pub fn files(&self) -> impl Iterator<Item = String> {
        self.read.iter().map(|(path, _)| path.strip_prefix(&self.path).unwrap_or(path).display().to_string())
    }

    /// Returns the bytes of the file of that name. Fails if the name leads out of the folder.
    pub fn fetch(&mut self, name: &str, budget: &mut Budget) -> Result<Arc<Vec<u8>>> {
        self.look_up(name, budget).inspect_err(|_| self.missing.push(name.to_owned()))
    }

    /// Returns the digest of a scene's file, of all files fetched so far, and of the names of files that could not be read.
    pub fn contents(&self, file: &[u8]) -> String {
        let of_named: Vec<(&Path, String)> = self
            .read
            .iter()
            .map(|(path, bytes)| (path.strip_prefix(&self.path).unwrap_or(path), digest(bytes)))
            .collect();
        digest(format!("{} {of_named:?} {:?}", digest(file), self.missing).as_bytes())
    }

    /// Fails if links lead from a path in a folder out of it.
    fn check_links(name: &str, path: &Path, folder: &Path) -> Result<()> {
        let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        let real = |path: &Path| path.canonicalize().map_err(|error| Error::io(path, error));
        if real(path)?.starts_with(real(folder)?) {
            return Ok(());
        }
        let message = format!(
            "“{}” is a link to a file outside the scene's folder, which is not followed: copy the file into the folder",
            shown(name)
        );
        Err(Error::invalid(message))
    }

    fn look_up(&mut self, name: &str, budget: &mut Budget) -> Result<Arc<Vec<u8>>> {
        let below = self.path.clone();
        let asked = inside(name).map(|rest| below.join(rest));
        // A file or link that is there is not searched elsewhere.
        let is_there = asked.as_ref().is_ok_and(|path| path.symlink_metadata().is_ok());
        let asked = asked.and_then(|path| self.open(name, path, &below, budget));
        let Err(error) = asked else { return asked };
        if is_there {
            return Err(error);
        }
        // Remote names have no place on this machine.
        if name.contains("://") {
            return Err(error);
        }
        let slashed = name.replace('\\', "/");
        let parent = self.path.join("..");
        let beside = slashed.strip_prefix("../").and_then(|rest| inside(rest).ok()).map(|rest| parent.join(rest));
        let found = match beside.filter(|path| path.is_file()) {
            Some(path) => Some((path, parent)),
            None => search(&below, slashed.rsplit(['/', ':']).next().unwrap_or_default()).map(|path| (path, below)),
        };
        let Some((place, root)) = found else { return Err(error) };
        let bytes = self.open(name, place.clone(), &root, budget)?;
        if !self.found.iter().any(|(known, _)| known == name) {
            self.found.push((name.to_owned(), place));
        }
        Ok(bytes)
    }

    /// Reads a file, once, unless links lead out of `folder`.
    fn open(&mut self, name: &str, path: PathBuf, folder: &Path, budget: &mut Budget) -> Result<Arc<Vec<u8>>> {
        if let Some((_, bytes)) = self.read.iter().find(|(read, _)| *read == path) {
            return Ok(bytes.clone());
        }
        let failed = |error: Error| match error {
            Error::Io { source, .. } => Error::invalid(format!("“{}” cannot be read: {source}", shown(name))),
            other => Error::invalid(other.to_string()),
        };
        Self::check_links(name, &path, folder).map_err(failed)?;
        let bytes = Arc::new(read(&path).map_err(failed)?);
        budget.grow(bytes.len() as u64);
        self.read.push((path, bytes.clone()));
        Ok(bytes)
    }
}

/// Returns the file with a name in a folder or below it: the first by depth and name, of the same case if there is one. Links are
/// not followed.
fn search(folder: &Path, name: &str) -> Option<PathBuf> {
    if name.is_empty() {
        return None;
    }
    let lower = name.to_lowercase();
    let (mut folders, mut other_case, mut searched) = (vec![folder.to_path_buf()], None, 0);
    while !folders.is_empty() && searched < MAX_SEARCHED {
        let mut next = Vec::new();
        for folder in folders {
            let folder = if folder.as_os_str().is_empty() { PathBuf::from(".") } else { folder };
            let mut entries: Vec<_> = std::fs::read_dir(&folder).into_iter().flatten().flatten().collect();
            entries.sort_by_key(std::fs::DirEntry::file_name);
            for entry in entries {
                searched += 1;
                let Ok(kind) = entry.file_type() else { continue };
                let own = entry.file_name();
                if kind.is_dir() {
                    next.push(entry.path());
                } else if kind.is_file() && own == name {
                    return Some(entry.path());
                } else if kind.is_file() && other_case.is_none() && own.to_string_lossy().to_lowercase() == lower {
                    other_case = Some(entry.path());
                }
            }
        }
        folders = next;
    }
    other_case
}

fn shown(name: &str) -> String {
    name.chars().take(80).collect()
}

pub fn read(path: &Path) -> Result<Vec<u8>> {
    use std::io::Read;
    let mut bytes = Vec::new();
    open_regular(path)?.read_to_end(&mut bytes).map_err(|error| Error::io(path, error))?;
    Ok(bytes)
}

/// Returns the path of a name below the folder. Fails for absolute names, URI schemes and `..`.
fn inside(name: &str) -> Result<PathBuf> {
    let refuse = |why: &str| Err(Error::invalid(format!("“{}” {why}", shown(name))));
    if name.contains(':') {
        return refuse("is not a file in the scene's folder: remote and absolute names are not followed");
    }
    if name.contains('\0') || name.is_empty() {
        return refuse("is not a file name");
    }
    let slashed = name.replace('\\', "/");
    if slashed.starts_with('/') {
        return refuse("is an absolute name: only files in the scene's folder are read");
    }
    let parts: Vec<&str> = slashed.split('/').filter(|part| !part.is_empty() && *part != ".").collect();
    if parts.contains(&"..") {
        return refuse("leads out of the scene's folder, which is not followed");
    }
    Ok(parts.iter().collect())
}

/// Decodes percent encoding (RFC 3986, 2.1). Returns the input if the result is not UTF-8.
pub fn percent_decoded(uri: &str) -> String {
    let mut parts = uri.as_bytes().split(|&byte| byte == b'%');
    let mut out = parts.next().unwrap_or_default().to_vec();
    for part in parts {
        let hex = part.get(..2).and_then(|hex| std::str::from_utf8(hex).ok()).filter(|hex| !hex.starts_with('+'));
        let code = hex.and_then(|hex| u8::from_str_radix(hex, 16).ok());
        out.push(code.unwrap_or(b'%'));
        out.extend_from_slice(&part[if code.is_some() { 2 } else { 0 }..]);
    }
    String::from_utf8(out).unwrap_or_else(|_| uri.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_stay_in_the_folder() {
        assert_eq!(inside("a/b.png").unwrap(), Path::new("a/b.png"));
        assert_eq!(inside("./a\\b c.png").unwrap(), Path::new("a/b c.png"));
        for bad in
            ["../a", "a/../b", "..", "/etc/passwd", "\\a", "c:\\a", "http://a/b", "file:///a", "", "a\0b", "a\\..\\b"]
        {
            assert!(inside(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn files_in_other_places_are_searched() {
        let place = tempfile::tempdir().unwrap();
        let at = |name: &str| place.path().join(name);
        for name in ["model/source/maps", "model/textures", "other"] {
            std::fs::create_dir_all(at(name)).unwrap();
        }
        for name in
            ["model/textures/up.png", "model/source/maps/Wood.PNG", "model/source/maps/tin.png", "other/far.png"]
        {
            std::fs::write(at(name), name).unwrap();
        }
        let mut folder = Folder::of(&at("model/source/scene.gltf"));
        let mut fetch = |name: &str| folder.fetch(name, &mut Budget::new(0)).map(|bytes| bytes.as_slice().to_vec());
        for (name, expected) in [
            ("../textures/up.png", "model/textures/up.png"),
            ("..\\textures\\up.png", "model/textures/up.png"),
            ("maps/wood.png", "model/source/maps/Wood.PNG"),
            ("C:\\Users\\me\\wood.png", "model/source/maps/Wood.PNG"),
            ("/other/place/maps/tin.png", "model/source/maps/tin.png"),
        ] {
            assert_eq!(fetch(name).unwrap(), expected.as_bytes(), "{name}");
        }
        for name in ["up.png", "../../other/far.png", "../other/far.png", "http://example.com/tin.png", "/other/place/"]
        {
            assert!(fetch(name).is_err(), "{name}");
        }
        let notes: Vec<String> = folder.notes().collect();
        assert_eq!(notes.len(), 5);
        assert!(notes[0].starts_with("“../textures/up.png” was found as"), "{}", notes[0]);
    }

    #[test]
    fn percent_signs_are_undone() {
        assert_eq!(percent_decoded("a%20b%2Fc"), "a b/c");
        assert_eq!(percent_decoded("100%"), "100%");
        assert_eq!(percent_decoded("%zz%4"), "%zz%4");
        assert_eq!(percent_decoded("%ff"), "%ff");
        assert_eq!(percent_decoded("%C3%A4"), "ä");
        assert!(inside(&percent_decoded("%2e%2e/a")).is_err());
    }

    #[test]
    fn a_file_is_read_once() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("a.bin"), [1, 2, 3]).unwrap();
        let mut files = Folder::of(&folder.path().join("scene.gltf"));
        let mut budget = Budget::new(0);
        let first = files.fetch("a.bin", &mut budget).unwrap();
        let second = files.fetch("./a.bin", &mut budget).unwrap();
        assert!(Arc::ptr_eq(&first, &second) && **first == [1, 2, 3]);
        assert!(files.fetch("b.bin", &mut budget).unwrap_err().to_string().contains("b.bin"));
        assert!(files.fetch(".", &mut budget).is_err(), "a folder is no file");
    }

    #[test]
    fn every_file_that_was_named_counts() {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str, bytes: &[u8]| std::fs::write(folder.path().join(name), bytes).unwrap();
        let contents = |file: &[u8], names: &[&str]| {
            let mut files = Folder::of(&folder.path().join("scene.gltf"));
            let mut budget = Budget::new(0);
            names.iter().for_each(|name| drop(files.fetch(name, &mut budget)));
            files.contents(file)
        };
        write("a.bin", &[1]);
        let mut all = vec![contents(b"1", &["a.bin", "b.png"])];
        assert_eq!(contents(b"1", &["a.bin", "b.png"]), all[0]);
        all.push(contents(b"2", &["a.bin", "b.png"]));
        write("b.png", &[2]);
        all.push(contents(b"1", &["a.bin", "b.png"]));
        write("b.png", &[3]);
        all.push(contents(b"1", &["a.bin", "b.png"]));
        write("a.bin", &[4]);
        all.push(contents(b"1", &["a.bin", "b.png"]));
        all.sort();
        all.dedup();
        assert_eq!(all.len(), 5);
    }

    #[cfg(unix)]
    #[test]
    fn a_link_counts_as_the_file_that_it_leads_to() {
        use std::os::unix::fs::symlink;
        let place = tempfile::tempdir().unwrap();
        let at = place.path();
        for folder in ["scene/deep", "elsewhere", "scene-2"] {
            std::fs::create_dir_all(at.join(folder)).unwrap();
            std::fs::write(at.join(folder).join("a.bin"), folder).unwrap();
        }
        let link = |to: &str, name: &str| symlink(to, at.join("scene").join(name)).unwrap();
        for (to, name) in [
            ("deep/a.bin", "inside"),
            ("inside", "twice"),
            ("deep", "folder"),
            ("../elsewhere/a.bin", "outside"),
            ("../elsewhere", "outer"),
            ("../scene-2/a.bin", "beside"),
            ("outside", "chain"),
            ("none", "dangling"),
            ("loop", "loop"),
        ] {
            link(to, name);
        }
        symlink(at.join("elsewhere/a.bin"), at.join("scene/absolute")).unwrap();
        // The folder itself may be a link, because the caller named it.
        symlink("scene", at.join("alias")).unwrap();
        for folder in ["scene", "alias"] {
            let mut files = Folder::of(&at.join(folder).join("scene.gltf"));
            let mut fetch = |name: &str| files.fetch(name, &mut Budget::new(0)).map_err(|error| error.to_string());
            for name in ["inside", "twice", "folder/a.bin"] {
                assert_eq!(**fetch(name).unwrap(), *b"scene/deep", "{name}");
            }
            for name in ["outside", "outer/a.bin", "beside", "chain", "absolute"] {
                let said = fetch(name).unwrap_err();
                assert!(said.contains(name) && said.contains("outside the scene's folder"), "{name}: {said}");
            }
            for name in ["dangling", "loop"] {
                assert!(fetch(name).unwrap_err().contains("cannot be read"), "{name}");
            }
        }
    }
}
