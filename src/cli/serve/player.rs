//! The player's files, which are embedded in the program. The build script lists them.

/// A file of the player.
pub struct PlayerFile {
    /// Path relative to the page, with `/` between folders.
    pub name: &'static str,
    pub bytes: &'static [u8],
}

/// Name of the page.
pub const PAGE: &str = "index.html";

include!(concat!(env!("OUT_DIR"), "/player.rs"));

impl PlayerFile {
    /// Returns the file of this name; the page for an empty name.
    pub fn named(name: &str) -> Option<&'static PlayerFile> {
        let name = if name.is_empty() { PAGE } else { name };
        FILES.iter().find(|file| file.name == name)
    }

    pub fn media_type(&self) -> &'static str {
        match self.name.rsplit_once('.').map_or("", |(_, extension)| extension) {
            "css" => "text/css; charset=utf-8",
            "html" => "text/html; charset=utf-8",
            "js" => "text/javascript; charset=utf-8",
            "json" => "application/json",
            "png" => "image/png",
            "svg" => "image/svg+xml",
            "txt" => "text/plain; charset=utf-8",
            "wasm" => "application/wasm",
            "woff2" => "font/woff2",
            _ => "application/octet-stream",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_page_and_its_scripts_are_in_the_program() {
        let page = PlayerFile::named("").unwrap();
        assert_eq!((page.name, page.media_type()), (PAGE, "text/html; charset=utf-8"));
        assert!(page.bytes.starts_with(b"<!"), "no page");
        for file in &FILES {
            assert!(!file.bytes.is_empty(), "{} is empty", file.name);
            assert!(!file.name.starts_with("film."), "{} has the name of the film", file.name);
            assert_ne!(file.media_type(), "application/octet-stream", "{} has no media type", file.name);
        }
        assert!(["/", "../Cargo.toml", "INDEX.HTML"].iter().all(|name| PlayerFile::named(name).is_none()));
    }
}
