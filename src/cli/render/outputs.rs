//! What `render` writes may neither be what it reads, nor one file twice.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use crate::error::{Error, Result};

/// A file that is to be written, and which option asks for it.
pub type Output = (&'static str, PathBuf);

/// Refuses outputs that are one of the inputs, or the same file as another output; `-` is no file.
///
/// # Errors
/// The first clash, in the order of the outputs.
pub fn check(outputs: &[Output], inputs: &[&Path]) -> Result<()> {
    let mut taken: HashMap<PathBuf, &str> = HashMap::new();
    let inputs: Vec<PathBuf> = inputs.iter().filter_map(|path| path.canonicalize().ok()).collect();
    for (option, path) in outputs.iter().filter(|(_, path)| path != Path::new("-")) {
        let place = place_of(path);
        if inputs.contains(&place) {
            return Err(Error::Usage(format!(
                "{option} {}: is read by this command, and would be overwritten; name another file",
                path.display()
            )));
        }
        if let Some(other) = taken.insert(place, option) {
            return Err(Error::Usage(format!(
                "{option} {}: is written by {other}, too; name another file or folder",
                path.display()
            )));
        }
    }
    Ok(())
}

/// The place that a path leads to, also where there is no file yet.
fn place_of(path: &Path) -> PathBuf {
    if let Ok(place) = path.canonicalize() {
        return place;
    }
    let parent = path.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let parent = parent.canonicalize().unwrap_or_else(|_| parent.to_path_buf());
    path.file_name().map_or(parent.clone(), |name| parent.join(name))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_written_once_and_no_input_is() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::write(at("in"), "").unwrap();
        let check = |outputs: &[(&'static str, &str)]| {
            let outputs: Vec<Output> = outputs.iter().map(|(option, name)| (*option, at(name))).collect();
            super::check(&outputs, &[&at("in"), &at("no such file")]).map_err(|error| error.to_string())
        };
        assert_eq!(check(&[("-o", "a"), ("--trace", "b"), ("--contact-sheet", "sub/a")]), Ok(()));
        assert!(check(&[("-o", "a"), ("--trace", "in")]).unwrap_err().contains("is read"));
        assert!(check(&[("-o", "a"), ("--trace", "./a")]).unwrap_err().contains("written by -o"));
        assert!(super::check(&[("-o", "-".into()), ("--trace", "-".into())], &[]).is_ok());
    }
}
