//! File names in folders.

use std::collections::BTreeMap;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use crate::error::{Error, Result};

/// Cache of the file names in folders; each folder is listed once.
#[derive(Debug, Default)]
pub struct FolderNames(BTreeMap<PathBuf, Option<Vec<String>>>);

impl FolderNames {
    /// Returns the sorted names in `folder`, empty if the folder does not exist; `None` if listing it is not permitted.
    pub fn list(&mut self, folder: &Path) -> Result<Option<&[String]>> {
        if !self.0.contains_key(folder) {
            let names = match file_names(folder) {
                Ok(mut names) => {
                    names.sort_unstable();
                    Some(names)
                }
                Err(Error::Io { source, .. }) if source.kind() == ErrorKind::PermissionDenied => None,
                Err(Error::Io { source, .. })
                    if matches!(source.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory) =>
                {
                    Some(Vec::new())
                }
                Err(error) => return Err(error),
            };
            self.0.insert(folder.to_path_buf(), names);
        }
        Ok(self.0.get(folder).and_then(Option::as_deref))
    }
}

/// Returns the names that are valid UTF-8, in any order.
pub fn file_names(folder: &Path) -> Result<Vec<String>> {
    let entries = std::fs::read_dir(folder).map_err(|error| Error::io(folder, error))?;
    let mut names = Vec::new();
    for entry in entries {
        let entry = entry.map_err(|error| Error::io(folder, error))?;
        names.extend(entry.file_name().into_string().ok());
    }
    Ok(names)
}
