//! Errors for paths on the command line that do not exist.
//!
//! A path that was typed and does not exist is bad input: the same command fails again. Images of a sequence, files
//! named by a manifest and shards of a capture may still be written, so their absence is a temporary failure
//! ([`crate::global::EXIT_RETRY`]). A pattern such as `depth.%04d.exr` names a sequence, but its folder counts as
//! typed.

use std::ffi::OsString;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use codec::error::{Error, Result};
use codec::image::Pattern;

/// Maximum number of names in a folder that are compared with the typed name.
const MAX_NAMES: usize = 10_000;

/// Turns the error for a missing file into one for bad input, if a path among the arguments is the cause.
pub fn judge(error: Error, arguments: &[OsString]) -> Error {
    let Error::Io { file, source } = &error else { return error };
    if source.kind() != ErrorKind::NotFound {
        return error;
    }
    let Some((folder, missing)) = first_missing(file) else { return error };
    let is_reason = |typed: &PathBuf| typed.starts_with(&missing) && !(*typed == missing && is_pattern(typed));
    let Some(typed) = arguments.iter().skip(1).flat_map(paths).find(is_reason) else { return error };
    let mut message = if typed == missing {
        "there is no such file or folder".to_owned()
    } else {
        format!("there is no folder {}", missing.display())
    };
    if let Ok(target) = missing.read_link() {
        message = format!("this is a link to {}, which does not exist", target.display());
    } else if let Ok(Some(near)) = nearest(&folder, &missing) {
        message += &format!("; did you mean {}?", near.display());
    }
    Error::invalid(message).in_file(typed)
}

/// Returns the paths that an argument may be or contain: itself, or the value of an option.
fn paths(argument: &OsString) -> Vec<PathBuf> {
    let mut paths = vec![PathBuf::from(argument)];
    if let Some(text) = argument.to_str().filter(|text| text.starts_with('-')) {
        let value = match text.split_once('=') {
            Some((_, value)) => value,
            // The value of a long option is the next argument.
            None if text.starts_with("--") => "",
            None => text.get(2..).unwrap_or_default(),
        };
        paths.push(PathBuf::from(value));
    }
    paths.retain(|path| !path.as_os_str().is_empty());
    paths
}

fn is_pattern(path: &Path) -> bool {
    path.to_str().is_some_and(|text| Pattern::parse(text).is_ok_and(|pattern| pattern.has_field()))
}

/// Returns the first missing part of a path, and the existing folder that should contain it. `None` if the path exists.
fn first_missing(path: &Path) -> Option<(PathBuf, PathBuf)> {
    let mut missing = path;
    if missing.as_os_str().is_empty() || missing.exists() {
        return None;
    }
    loop {
        let parent = missing.parent()?;
        let folder = if parent.as_os_str().is_empty() { Path::new(".") } else { parent };
        if folder.exists() {
            return Some((folder.to_path_buf(), missing.to_path_buf()));
        }
        missing = parent;
    }
}

/// Returns the path of the name in a folder that is most similar to a missing one: few letters differ, or the extension
/// was omitted.
fn nearest(folder: &Path, missing: &Path) -> Result<Option<PathBuf>> {
    let Some(typed) = missing.file_name().and_then(|name| name.to_str()) else { return Ok(None) };
    let typed = typed.to_lowercase();
    let most = (typed.chars().count() / 3).max(1);
    let entries = std::fs::read_dir(folder).map_err(|error| Error::io(folder, error))?;
    let distance = |name: &str| {
        let name = name.to_lowercase();
        let is_stem = name.strip_prefix(&typed).is_some_and(|ending| ending.starts_with('.'));
        let distance = if is_stem { 0 } else { strsim::osa_distance(&typed, &name) };
        (distance <= most).then_some(distance)
    };
    let names = entries.take(MAX_NAMES).filter_map(|entry| entry.ok()?.file_name().into_string().ok());
    let near = names.filter(|name| !name.starts_with('.') || typed.starts_with('.'));
    let near = near.filter_map(|name| Some((distance(&name)?, name))).min();
    Ok(near.map(|(_, name)| missing.with_file_name(name)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_typed_is_bad_input_and_what_may_appear_is_not() {
        let place = tempfile::tempdir().unwrap();
        let at = place.path();
        std::fs::create_dir_all(at.join("footage/probe_00")).unwrap();
        std::fs::write(at.join("film.lfold"), b"").unwrap();
        let judged = |typed: &str, file: &str| {
            let arguments =
                ["lightfold", "any", typed].map(|word| OsString::from(word.replace('@', at.to_str().unwrap())));
            let error = Error::not_found(at.join(file), "there is no such file or folder");
            match judge(error, &arguments) {
                Error::Invalid { file, message, .. } => {
                    let plain = |text: &str| text.replace(&format!("{}/", at.display()), "");
                    Some(format!("{}: {}", plain(&file.display().to_string()), plain(&message)))
                }
                _ => None,
            }
        };
        let some = |text: &str| Some(text.to_owned());
        for typed in ["@/film.lfod", "--tables=@/film.lfod", "-o@/film.lfod"] {
            let said = some("film.lfod: there is no such file or folder; did you mean film.lfold?");
            assert_eq!(judged(typed, "film.lfod"), said, "{typed}");
        }
        assert_eq!(judged("@/film", "film"), some("film: there is no such file or folder; did you mean film.lfold?"));
        assert_eq!(judged("@/shot.glb", "shot.glb"), some("shot.glb: there is no such file or folder"));
        let folder = some("foootage/a.json: there is no folder foootage; did you mean footage?");
        assert_eq!(judged("@/foootage/a.json", "foootage/a.json"), folder);
        let pattern = some("foootage/d.%04d.exr: there is no folder foootage; did you mean footage?");
        assert_eq!(judged("@/foootage/d.%04d.exr", "foootage"), pattern);
        for (typed, file) in [
            ("@/footage", "footage/probe_00/depth.0000.exr"),
            ("@/footage/lightfield.json", "footage/probe_01/depth.0000.exr"),
            ("@/footage/d.%04d.exr", "footage/d.%04d.exr"),
            ("@/footage/d.%04d.exr", "footage/d.0003.exr"),
            // The file was created in the meantime.
            ("@/film.lfold", "film.lfold"),
        ] {
            assert_eq!(judged(typed, file), None, "{typed} {file}");
        }
    }
}
