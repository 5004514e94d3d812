//! Writes the player and a film as a static site, for any web server that supports range requests.

use std::fs::{self, File};
use std::io::{self, ErrorKind, Read, Write};
use std::path::Path;

use serde_json::Value;

use super::film::{Description, Film, State};
use super::opening::POSTER;
use super::player::{self, PlayerFile};
use codec::error::{Error, Result};
use codec::monitor::Monitor;
use footage::files::{self, DiskFile, OutputFolder, create_folders, parent_of};
use footage::json;

/// Bytes copied between checks of the monitor.
const PIECE_BYTES: u64 = 16 << 20;
/// Name of the film's description.
pub const DESCRIPTION: &str = "film.json";
/// Maximum bytes of the description.
const MAX_DESCRIPTION_BYTES: u64 = 64 << 10;
/// Names that a film can have on a site.
const FILMS: [&str; 3] = ["film.lfold", "film.glb", "film.png"];

/// A site that was written.
#[derive(Debug, Clone)]
pub struct Site {
    pub film: Description,
    pub files: u64,
    /// Total bytes of all files.
    pub bytes: u64,
}

/// Writes a site into a folder, which must be new, empty, or hold an earlier site, which is replaced. The monitor advances by
/// the bytes of the film.
pub fn export(film: &Film, path: &Path, monitor: &dyn Monitor) -> Result<Site> {
    let earlier = match earlier_site(path)? {
        Earlier::Nothing => None,
        Earlier::Film(url) => Some(url),
        Earlier::Other(name) => {
            let message = format!("{}: the folder has other files ({name}): use another folder", path.display());
            return Err(Error::Usage(message));
        }
    };
    let folder = OutputFolder::create(path)?;
    let site = write(film, folder.work_path(), monitor).map_err(|error| folder.present(error))?;
    folder.commit()?;
    let other = earlier.filter(|url| *url != film.url());
    let poster = (site.film.poster.is_none() && earlier.is_some()).then_some(POSTER);
    for name in other.into_iter().chain(poster) {
        let old = path.join(name);
        match files::remove_file(&old) {
            Err(error) if error.kind() != ErrorKind::NotFound => return Err(Error::io(old, error)),
            _ => {}
        }
    }
    Ok(site)
}

/// Contents of a folder.
enum Earlier {
    Nothing,
    /// A site, with a film of this name.
    Film(&'static str),
    /// A file of this name, which belongs to no site.
    Other(String),
}

/// Determines whether a folder is new, empty, or a site: only files of a player and one film, all of them regular files.
fn earlier_site(folder: &Path) -> Result<Earlier> {
    let io = |error| Error::io(folder, error);
    let entries = match fs::read_dir(folder) {
        // A path that is not a folder fails later, when the folder is written.
        Err(error) if matches!(error.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory) => {
            return Ok(Earlier::Nothing);
        }
        entries => entries.map_err(io)?,
    };
    let mut entries: Vec<_> = entries.collect::<io::Result<_>>().map_err(io)?;
    if entries.is_empty() {
        return Ok(Earlier::Nothing);
    }
    entries.sort_by_key(fs::DirEntry::file_name);
    let film = described_film(&folder.join(DESCRIPTION))?;
    for entry in entries {
        let name = entry.file_name().to_string_lossy().into_owned();
        let is_known = [DESCRIPTION, POSTER].contains(&name.as_str())
            || film == Some(name.as_str())
            || PlayerFile::named(&name).is_some();
        if film.is_none() || !is_known || !entry.file_type().map_err(io)?.is_file() {
            return Ok(Earlier::Other(name));
        }
    }
    Ok(film.map_or(Earlier::Nothing, Earlier::Film))
}

/// Returns the film that a description names; `None` if the file is no description.
fn described_film(path: &Path) -> Result<Option<&'static str>> {
    if !fs::symlink_metadata(path).is_ok_and(|metadata| metadata.is_file()) {
        return Ok(None);
    }
    let mut text = Vec::new();
    let file = File::open(path).map_err(|error| Error::io(path, error))?;
    file.take(MAX_DESCRIPTION_BYTES).read_to_end(&mut text).map_err(|error| Error::io(path, error))?;
    let Ok(described) = serde_json::from_slice::<Value>(&text) else { return Ok(None) };
    let has = |key: &str| described.get(key).is_some();
    let url = described.get("url").and_then(Value::as_str);
    let film = FILMS.into_iter().find(|film| url == Some(*film));
    Ok(film.filter(|_| ["kind", "name", "bytes"].into_iter().all(has)))
}

fn write(film: &Film, folder: &Path, monitor: &dyn Monitor) -> Result<Site> {
    let mut bytes = 0;
    let mut put = |name: &str, content: &[u8]| {
        let path = folder.join(name);
        bytes += content.len() as u64;
        // Names of the player's files may include folders, which do not exist yet.
        let made = create_folders(parent_of(&path)).and_then(|_| DiskFile::create(&path));
        made.and_then(|mut file| file.write_all(content)).map_err(|error| Error::io(&path, error))
    };
    for file in &player::FILES {
        put(file.name, file.bytes)?;
    }
    let film_bytes = copy(film, &folder.join(film.url()), monitor)?;
    let opening = film.opening();
    let mut description = film.description(film_bytes, &opening);
    let mut file_count = player::FILES.len() as u64 + 2;
    if let Some(poster) = opening.poster() {
        put(POSTER, poster)?;
        file_count += 1;
    } else {
        description.poster = None;
    }
    put(DESCRIPTION, json::pretty(&description)?.as_bytes())?;
    Ok(Site { bytes: bytes + description.bytes, files: file_count, film: description })
}

/// Copies the film; returns its size in bytes.
fn copy(film: &Film, to: &Path, monitor: &dyn Monitor) -> Result<u64> {
    let io = |error| Error::io(to, error);
    let opened = film.open_now()?;
    let mut out = DiskFile::create(to).map_err(io)?;
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
