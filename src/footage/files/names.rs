//! Output names: checks that a file system accepts them, and hidden names beside an output.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use codec::error::{Error, Result};

/// Returns the parent folder of a path; `.` for a bare name.
pub fn parent_of(path: &Path) -> &Path {
    path.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Fails if the file system cannot accept the name: too long, or with a NUL character. Creates nothing.
pub fn check_name(path: &Path) -> Result<()> {
    let refused = |why: &str| Err(Error::Usage(format!("{}: {why}: use another name", shortened(path))));
    let existing = path.ancestors().find(|above| above.is_dir() || above.as_os_str().is_empty());
    let folder = existing.filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let missing = existing.and_then(|existing| path.strip_prefix(existing).ok()).unwrap_or(path);
    // If a folder is missing, the system does not check the names below it; each is checked in the deepest existing folder.
    let names = missing.iter().map(|name| folder.join(name));
    for tried in names.chain([path.to_path_buf()]) {
        match tried.symlink_metadata().map_err(|error| error.kind()) {
            Err(ErrorKind::InvalidFilename) => return refused("its name is too long for the file system"),
            Err(ErrorKind::InvalidInput) => return refused("file names cannot have NUL characters"),
            _ => {}
        }
    }
    Ok(())
}

/// Fails if no file can have the name, or if its folder is missing.
pub fn check_file(path: &Path) -> Result<()> {
    check_name(path)?;
    let folder = parent_of(path);
    match folder.is_dir() {
        true => Ok(()),
        false => Err(Error::Usage(format!("{}: there is no folder {}", path.display(), folder.display()))),
    }
}

/// Maximum characters of a path in a message.
const MAX_SHOWN: usize = 120;

/// Returns the path as text, cut at [`MAX_SHOWN`] characters.
fn shortened(path: &Path) -> String {
    let text = path.display().to_string();
    match text.char_indices().nth(MAX_SHOWN) {
        Some((at, _)) => format!("{}... ({} bytes)", &text[..at], text.len()),
        None => text,
    }
}

/// Maximum bytes of a hidden name. File systems allow 255, or fewer if they encrypt names.
const MAX_HIDDEN_BYTES: usize = 140;

/// Returns a path beside an output: a dot, the output's name and `end`. A long name is cut and gets its CRC-32, to stay
/// unique.
pub fn hidden_beside(output: &Path, end: &str) -> Option<PathBuf> {
    let name = output.file_name()?;
    let mut hidden = std::ffi::OsString::from(".");
    let bytes = name.as_encoded_bytes();
    if bytes.len() + end.len() < MAX_HIDDEN_BYTES {
        hidden.push(name);
    } else {
        let text = name.to_string_lossy();
        let start: String = text.chars().take(MAX_HIDDEN_BYTES / 4 - end.len().min(20)).collect();
        hidden.push(format!("{start}~{:08x}", crc32fast::hash(bytes)));
    }
    hidden.push(end);
    Some(output.with_file_name(hidden))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn refuses_names_that_no_file_can_have() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        for name in ["a", "none/b/c.%04d.png", "x/../y", "é", &"n".repeat(250)] {
            check_name(&at(name)).unwrap();
        }
        let long = "n".repeat(70_000);
        for name in [&long, &format!("none/{long}/c.png"), &"d/".repeat(30_000), "a\0b", "none/a\0b.lfold"] {
            let error = check_name(&at(name)).unwrap_err().to_string();
            assert!(error.len() < 400 && error.contains("use another name"), "{error}");
            assert!(check_name(Path::new(name)).is_err());
        }
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }

    #[test]
    fn hidden_names_are_short_and_differ() {
        let name = |length: usize, end: char| format!("{}{end}.lfold", "é".repeat(length));
        let [a, b] =
            ['a', 'b'].map(|end| hidden_beside(Path::new(&name(120, end)), ".1-of-2.capture.partial").unwrap());
        assert!(a != b && a.as_os_str().len() <= MAX_HIDDEN_BYTES, "{}", a.display());
        assert_eq!(hidden_beside(Path::new("out/a.lfold"), ".partial").unwrap(), Path::new("out/.a.lfold.partial"));
        assert_eq!(hidden_beside(Path::new(".."), ".partial"), None);
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(name(120, 'a'));
        crate::files::write_whole(&path, b"whole").unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"whole");
    }
}
