//! Small files that are replaced as a whole.

use std::ffi::OsString;
use std::path::Path;

use crate::error::{Error, Result};

/// Calls `write` with a temporary path beside `path` and renames that file afterwards. Concurrent writers do not disturb
/// each other: the last rename wins.
pub fn write_whole<T>(path: &Path, write: impl FnOnce(&Path) -> Result<T>) -> Result<T> {
    let mut prefix = OsString::from(".");
    prefix.push(path.file_name().unwrap_or_default());
    prefix.push(".");
    let mut builder = tempfile::Builder::new();
    builder.prefix(&prefix).suffix(".partial");
    // Temporary files are private by default; a result has the usual permissions.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    let file = builder.tempfile_in(parent_of(path)).map_err(|error| Error::io(path, error.kind().into()))?;
    let file = file.into_temp_path();
    let written = write(&file).map_err(|error| match error {
        Error::Io { source, .. } => Error::io(path, source),
        other => other,
    })?;
    file.persist(path).map_err(|error| Error::io(path, error.error))?;
    Ok(written)
}

/// The folder that a path is in; `.` for a bare name.
pub fn parent_of(path: &Path) -> &Path {
    path.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_appear_whole_or_not_at_all_even_when_two_write_at_once() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("page");
        let put = |partial: &Path, text: &str| std::fs::write(partial, text).map_err(|error| Error::io(partial, error));
        write_whole(&path, |outer| {
            put(outer, "outer")?;
            write_whole(&path, |inner| put(inner, "inner"))?;
            assert_eq!(std::fs::read_to_string(&path).unwrap(), "inner");
            Ok(())
        })
        .unwrap();
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "outer");
        let refused = write_whole(&path, |partial| {
            put(partial, "half")?;
            Err::<(), _>(Error::invalid("no more"))
        });
        assert!(refused.unwrap_err().to_string().contains("no more"));
        let missing = write_whole(&path, |partial| put(&partial.join("none"), "")).unwrap_err().to_string();
        assert!(missing.contains("page") && !missing.contains("partial"), "{missing}");
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "outer");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }
}
