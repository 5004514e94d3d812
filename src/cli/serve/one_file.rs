//! Writes the player and a film as one HTML file, which browsers open without a server.
//!
//! Styles and the script of the page are part of it. Workers, the decoder and the film are base64 in elements that browsers do not
//! run; `viewer/src/assets.ts` reads them.

use std::io::{Read, Write};
use std::path::Path;

use data_encoding::BASE64;

use super::film::{Film, State};
use super::opening::POSTER;
use super::player::{PAGE, PlayerFile};
use super::site::{DESCRIPTION, Site};
use codec::error::{Error, Result};
use codec::monitor::Monitor;
use footage::files::OutputFile;
use footage::json;

/// Maximum bytes of the film: browsers hold it in memory, as text and as bytes.
const MAX_FILM_BYTES: u64 = 50_000_000;
/// Bytes encoded between checks of the monitor.
const PIECE_BYTES: usize = 3 << 20;
/// The page may run what it contains, and nothing else.
const POLICY: &str = "default-src 'none'; script-src 'unsafe-inline' 'wasm-unsafe-eval' blob:; worker-src blob:; \
    style-src 'unsafe-inline'; img-src blob: data:; connect-src blob:; base-uri 'none'; form-action 'none'";
const SCRIPT: &str = "<script type=\"module\" src=\"viewer.js\"></script>";
const STYLES: [&str; 2] = ["style.css", "narrow.css"];
const POLICY_START: &str = "content=\"default-src";

/// Writes the page as `path`. The monitor advances by the bytes of the film.
pub fn export_file(film: &Film, path: &Path, monitor: &dyn Monitor) -> Result<Site> {
    let opened = film.open_now()?;
    let bytes = opened.state.bytes;
    if bytes > MAX_FILM_BYTES {
        let (megabytes, most) = (bytes.div_ceil(1_000_000), MAX_FILM_BYTES / 1_000_000);
        return Err(Error::Usage(format!(
            "{}: the film has {megabytes} MB, a page in one file holds films of up to {most} MB: set `export` to a folder, \
            for a web server",
            path.display()
        )));
    }
    let opening = film.opening();
    let poster = opening.poster();
    let mut description = film.description(bytes, &opening);
    description.poster = description.poster.filter(|_| poster.is_some());
    let mut out = OutputFile::create(path)?;
    let mut page = PageFile { out: &mut out, bytes: 0, path };
    let [head, tail] = page_parts()?;
    page.put(head.as_bytes())?;
    page.data(DESCRIPTION, json::pretty(&description)?.as_bytes())?;
    if let Some(poster) = poster {
        page.data(POSTER, poster)?;
    }
    for name in film.player_files() {
        page.data(name, player_file(name)?.bytes)?;
    }
    page.start_data(description.url)?;
    let mut left = bytes;
    while left > 0 {
        monitor.check()?;
        let mut piece = Vec::new();
        let most = left.min(PIECE_BYTES as u64);
        (&opened.file).take(most).read_to_end(&mut piece).map_err(|error| Error::io(path, error))?;
        if piece.is_empty() {
            break;
        }
        // Pieces of a file are whole, unless it was cut meanwhile.
        page.put(BASE64.encode(&piece).as_bytes())?;
        monitor.advance(piece.len() as u64);
        left -= piece.len() as u64;
    }
    if left > 0 || State::of(&opened.file.metadata().map_err(|error| Error::io(path, error))?) != opened.state {
        return Err(film.changed());
    }
    page.put(b"</script>\n")?;
    page.put(tail.as_bytes())?;
    let written = page.bytes;
    out.commit()?;
    Ok(Site { film: description, files: 1, bytes: written })
}

/// Returns the page with its styles, up to its data, and what follows them: the script.
fn page_parts() -> Result<[String; 2]> {
    let mut page = text_of(PAGE)?.to_owned();
    let start = page.find(POLICY_START).ok_or_else(|| unexpected(POLICY_START))? + "content=\"".len();
    let end = page[start..].find('"').ok_or_else(|| unexpected(POLICY_START))? + start;
    page.replace_range(start..end, POLICY);
    for name in STYLES {
        let link = format!("<link rel=\"stylesheet\" href=\"{name}\" />");
        page = replaced(&page, &link, &format!("<style>\n{}</style>", text_of(name)?))?;
    }
    page = replaced(&page, SCRIPT, "")?;
    let end = "</body>";
    let at = page.find(end).ok_or_else(|| unexpected(end))?;
    let script = text_of("viewer.js")?;
    if script.contains("</script") || script.contains("<!--") {
        return Err(unexpected("a script without </script"));
    }
    let tail = format!("<script type=\"module\">\n{script}</script>\n{}", &page[at..]);
    page.truncate(at);
    Ok([page, tail])
}

fn replaced(page: &str, from: &str, to: &str) -> Result<String> {
    match page.contains(from) {
        true => Ok(page.replacen(from, to, 1)),
        false => Err(unexpected(from)),
    }
}

fn text_of(name: &str) -> Result<&'static str> {
    std::str::from_utf8(player_file(name)?.bytes).map_err(|_| unexpected(name))
}

fn player_file(name: &str) -> Result<&'static PlayerFile> {
    PlayerFile::named(name).ok_or_else(|| unexpected(name))
}

/// The player of the program is not as this module expects.
fn unexpected(what: &str) -> Error {
    Error::unsupported(format!("the player of this program does not have {what}"))
}

/// The page while it is written.
struct PageFile<'a> {
    out: &'a mut OutputFile,
    bytes: u64,
    path: &'a Path,
}

impl PageFile<'_> {
    fn put(&mut self, bytes: &[u8]) -> Result<()> {
        self.bytes += bytes.len() as u64;
        self.out.write_all(bytes).map_err(|error| Error::io(self.path, error))
    }

    fn start_data(&mut self, name: &str) -> Result<()> {
        self.put(format!("<script type=\"application/octet-stream\" data-file=\"{name}\">").as_bytes())
    }

    fn data(&mut self, name: &str, content: &[u8]) -> Result<()> {
        self.start_data(name)?;
        self.put(BASE64.encode(content).as_bytes())?;
        self.put(b"</script>\n")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_page_asks_for_no_other_file() {
        let [head, tail] = page_parts().unwrap();
        assert!(head.starts_with("<!doctype html>") && tail.trim_end().ends_with("</html>"));
        assert_eq!((head.matches("<style>").count(), head.matches(POLICY).count()), (2, 1));
        assert!(!head.contains("href=\"style") && !head.contains("src=\"") && !head.contains("'self'"), "{head}");
    }
}
