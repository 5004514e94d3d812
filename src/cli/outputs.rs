//! Checks that the outputs of a command are neither inputs nor each other.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use crate::refuse;
use codec::error::Result;
use footage::files::parent_of;

pub type Output = (&'static str, PathBuf);

/// Fails if an output is an input or equals another output, except `-`.
pub fn check(outputs: &[Output], inputs: &[&Path]) -> Result<()> {
    let mut taken: HashMap<PathBuf, &str> = HashMap::new();
    let inputs: Vec<PathBuf> = inputs.iter().filter_map(|path| path.canonicalize().ok()).collect();
    for (option, path) in outputs.iter().filter(|(_, path)| path != Path::new("-")) {
        let place = place_of(path);
        if inputs.contains(&place) {
            return refuse(format!(
                "{option} {}: an input would be overwritten: use another file name",
                path.display()
            ));
        }
        if let Some(other) = taken.insert(place, option) {
            let path = path.display();
            return refuse(format!("{option} {path}: is also written by {other}: use another file or folder"));
        }
    }
    Ok(())
}

/// Returns the canonical path, also for files that do not exist yet.
fn place_of(path: &Path) -> PathBuf {
    if let Ok(place) = path.canonicalize() {
        return place;
    }
    let parent = parent_of(path).canonicalize().unwrap_or_else(|_| parent_of(path).to_path_buf());
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
        assert!(check(&[("-o", "a"), ("--trace", "in")]).unwrap_err().contains("an input"));
        assert!(check(&[("-o", "a"), ("--trace", "./a")]).unwrap_err().contains("written by -o"));
        assert!(super::check(&[("-o", "-".into()), ("--trace", "-".into())], &[]).is_ok());
    }
}
