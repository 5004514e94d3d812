//! The player and a film as a static site, for any web server that answers requests for ranges.

use std::fs::{self, File};
use std::io::{self, ErrorKind, Read};
use std::path::Path;

use serde_json::Value;

use super::film::{Description, Film, State};
use super::player;
use crate::error::{Error, Result};
use crate::files::OutputFolder;
use crate::json;
use crate::monitor::Monitor;

/// Bytes between looks at the monitor.
const PIECE_BYTES: u64 = 16 << 20;
/// What the page is told of the film.
const DESCRIPTION: &str = "film.json";
/// Names that a film has on a site.
const FILMS: [&str; 3] = ["film.lfold", "film.glb", "film.png"];

/// A site that was written.
#[derive(Debug, Clone)]
pub struct Site {
    pub film: Description,
    pub files: u64,
    /// Of all files.
    pub bytes: u64,
}

/// Writes a site into a folder, which is new, empty, or holds an earlier site; that one is replaced. The monitor gets the bytes of the
/// film as steps.
pub fn export(film: &Film, path: &Path, monitor: &dyn Monitor) -> Result<Site> {
    if !is_free(path)? {
        return Err(Error::Usage(format!("{}: holds files of something else; name another folder", path.display())));
    }
    let folder = OutputFolder::create(path)?;
    let site = write(film, folder.work_path(), monitor).map_err(|error| folder.present(error))?;
    folder.commit()?;
    for other in FILMS.iter().filter(|name| **name != film.url()).map(|name| path.join(name)) {
        match fs::remove_file(&other) {
            Err(error) if error.kind() != ErrorKind::NotFound => return Err(Error::io(other, error)),
            _ => {}
        }
    }
    Ok(site)
}

/// Whether a folder is not there, empty, or a site. Another error than that it is not there comes when it is written.
fn is_free(folder: &Path) -> Result<bool> {
    let Ok(mut entries) = fs::read_dir(folder) else { return Ok(true) };
    if entries.next().is_none() {
        return Ok(true);
    }
    let path = folder.join(DESCRIPTION);
    let text = match fs::read(&path) {
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(false),
        read => read.map_err(|error| Error::io(path, error))?,
    };
    let described: Option<Value> = serde_json::from_slice(&text).ok();
    let url = described.as_ref().and_then(|value| value.get("url")?.as_str());
    Ok(url.is_some_and(|url| FILMS.contains(&url)))
}

fn write(film: &Film, folder: &Path, monitor: &dyn Monitor) -> Result<Site> {
    let mut bytes = 0;
    let mut put = |name: &str, content: &[u8]| {
        let path = folder.join(name);
        bytes += content.len() as u64;
        // The folder is new, and names of the player's files may have folders of their own.
        let made = path.parent().map_or(Ok(()), fs::create_dir_all);
        made.and_then(|()| fs::write(&path, content)).map_err(|error| Error::io(&path, error))
    };
    for file in &player::FILES {
        put(file.name, file.bytes)?;
    }
    let description = film.description(copy(film, &folder.join(film.url()), monitor)?);
    put(DESCRIPTION, json::pretty(&description)?.as_bytes())?;
    Ok(Site { bytes: bytes + description.bytes, files: player::FILES.len() as u64 + 2, film: description })
}

/// Copies the film; answers its bytes.
fn copy(film: &Film, to: &Path, monitor: &dyn Monitor) -> Result<u64> {
    let io = |error| Error::io(to, error);
    let opened = film.open_now()?;
    let mut out = File::create(to).map_err(io)?;
    let (all, mut left) = (opened.state.bytes, opened.state.bytes);
    while left > 0 {
        monitor.check()?;
        let copied = io::copy(&mut (&opened.file).take(left.min(PIECE_BYTES)), &mut out).map_err(io)?;
        if copied == 0 {
            break;
        }
        monitor.advance(copied);
        left -= copied;
    }
    if left > 0 || State::of(&opened.file.metadata().map_err(io)?) != opened.state {
        return Err(film.changed());
    }
    Ok(all)
}
