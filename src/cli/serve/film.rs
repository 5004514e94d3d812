//! The file that is played: its kind, its description for the page, and its state on disk.

use std::fs::{File, Metadata};
use std::io::{BufRead, BufReader, ErrorKind, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

use serde::{Deserialize, Serialize};

use super::opening::{Content, Opening, POSTER};
use super::quilt_shape::QuiltShape;
use codec::container::header::{FOOT_BYTES, MAGIC};
use codec::decode::Decoder;
use codec::error::{Error, Result};
use codec::streams::StartView;
use footage::dataset::manifest::{MANIFEST_NAME, MAX_MANIFEST_BYTES};
use footage::files::open_regular;
use scene::mesh::gltf::document::is_glb;

const PNG_MAGIC: [u8; 8] = *b"\x89PNG\r\n\x1a\n";
/// Magic, version and length of the file.
const GLB_HEAD_BYTES: usize = 12;

/// A file that can be played.
#[derive(Debug, Clone)]
pub struct Film {
    path: PathBuf,
    kind: Kind,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Kind {
    Container,
    Glb,
    Quilt(QuiltShape),
}

/// Description of a film that the page reads, `film.json`.
#[derive(Debug, Clone, Serialize)]
pub struct Description {
    /// `lfold`, `glb` or `quilt`.
    pub kind: &'static str,
    /// Relative to the page.
    pub url: &'static str,
    /// File name on this machine, without its folder.
    pub name: String,
    pub bytes: u64,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub quilt: Option<QuiltShape>,
    /// Camera with which a container or a scene opens.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub start: Option<StartView>,
    /// Picture of the start, relative to the page.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub poster: Option<&'static str>,
}

/// An open film, and its state when it was opened.
#[derive(Debug)]
pub struct OpenFilm {
    pub file: File,
    pub state: State,
    /// CRC-32 of the last bytes. In a container these are the foot, which contains the CRC-32 of the index (container.md 7).
    end_crc32: u32,
}

/// Metadata that changes with the content of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct State {
    pub bytes: u64,
    modified: Option<SystemTime>,
    inode: u64,
}

impl Film {
    /// Opens a film. Fails unless it is a container that opens, a binary glTF file, or a PNG picture whose name states the
    /// layout of a quilt.
    pub fn open(path: &Path) -> Result<Film> {
        if path.join(MANIFEST_NAME).is_file() {
            return Err(dataset(path));
        }
        let mut file = open_regular(path)?;
        let mut head = Vec::new();
        Read::by_ref(&mut file)
            .take(GLB_HEAD_BYTES as u64)
            .read_to_end(&mut head)
            .map_err(|error| Error::io(path, error))?;
        let kind = if head.starts_with(&MAGIC) {
            Decoder::open(path)?;
            Kind::Container
        } else if is_glb(&head) {
            check_glb(&head, path)?;
            Kind::Glb
        } else if head.starts_with(&PNG_MAGIC) {
            check_png(file, path)?;
            Kind::Quilt(QuiltShape::of(path)?)
        } else {
            return Err(not_a_film(file, path));
        };
        Ok(Film { path: path.to_path_buf(), kind })
    }

    pub fn is_glb(&self) -> bool {
        self.kind == Kind::Glb
    }

    pub fn is_container(&self) -> bool {
        self.kind == Kind::Container
    }

    /// Returns the name of the film on the site.
    pub fn url(&self) -> &'static str {
        match self.kind {
            Kind::Container => "film.lfold",
            Kind::Glb => "film.glb",
            Kind::Quilt(_) => "film.png",
        }
    }

    pub fn media_type(&self) -> &'static str {
        match self.kind {
            Kind::Container => "application/octet-stream",
            Kind::Glb => "model/gltf-binary",
            Kind::Quilt(_) => "image/png",
        }
    }

    /// Returns the start of the film as it is now.
    pub fn opening(&self) -> Opening {
        let content = match self.kind {
            Kind::Container => Content::Container,
            Kind::Glb => Content::Scene,
            Kind::Quilt(shape) => Content::Quilt(shape),
        };
        Opening::new(&self.path, content)
    }

    /// Returns the files of the player, beside the page, that it loads to play this film.
    pub fn player_files(&self) -> &'static [&'static str] {
        match self.kind {
            Kind::Container => &["worker.js", "cpu_worker.js", "lightfold.wasm"],
            Kind::Glb => &["glb.js"],
            Kind::Quilt(_) => &[],
        }
    }

    /// Returns the description for the page, of a file of `bytes` bytes.
    pub fn description(&self, bytes: u64, opening: &Opening) -> Description {
        let (kind, quilt) = match self.kind {
            Kind::Container => ("lfold", None),
            Kind::Glb => ("glb", None),
            Kind::Quilt(shape) => ("quilt", Some(shape)),
        };
        let name = self.path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let poster = opening.has_poster().then_some(POSTER);
        Description { kind, url: self.url(), name, bytes, quilt, start: opening.start, poster }
    }

    /// Returns the error for a file that another program has modified meanwhile.
    pub fn changed(&self) -> Error {
        Error::busy(&self.path, "the file changed while it was copied; copy it again once it is written")
    }

    /// Opens the file that currently has the film's name.
    pub fn open_now(&self) -> Result<OpenFilm> {
        let io = |error| Error::io(&self.path, error);
        let mut file = open_regular(&self.path)?;
        let state = State::of(&file.metadata().map_err(io)?);
        let mut end = Vec::new();
        file.seek(SeekFrom::Start(state.bytes.saturating_sub(FOOT_BYTES as u64))).map_err(io)?;
        Read::by_ref(&mut file).take(FOOT_BYTES as u64).read_to_end(&mut end).map_err(io)?;
        file.rewind().map_err(io)?;
        Ok(OpenFilm { file, state, end_crc32: crc32fast::hash(&end) })
    }
}

impl OpenFilm {
    /// Returns a strong entity tag: it differs whenever the bytes may differ.
    pub fn tag(&self) -> String {
        let State { bytes, modified, inode } = self.state;
        let since = modified.and_then(|time| time.duration_since(UNIX_EPOCH).ok()).unwrap_or_default();
        format!("\"{bytes:x}-{:x}-{inode:x}-{:08x}\"", since.as_nanos(), self.end_crc32)
    }
}

impl State {
    pub fn of(metadata: &Metadata) -> State {
        State { bytes: metadata.len(), modified: metadata.modified().ok(), inode: inode(metadata) }
    }
}

#[cfg(unix)]
fn inode(metadata: &Metadata) -> u64 {
    std::os::unix::fs::MetadataExt::ino(metadata)
}

#[cfg(not(unix))]
fn inode(_metadata: &Metadata) -> u64 {
    0
}

fn dataset(path: &Path) -> Error {
    let message = "a dataset, where a film was expected: encode it with lightfold encode, and view the container";
    Error::Usage(format!("{}: {message}", path.display()))
}

/// Returns the error for a file whose first bytes are not those of a film.
fn not_a_film(mut file: File, path: &Path) -> Error {
    /// The field that every manifest has.
    #[derive(Deserialize)]
    struct ManifestHead {
        #[serde(rename = "lightfield")]
        _version: u32,
    }
    let is_manifest = file.rewind().is_ok() && {
        let text = BufReader::new(file.take(MAX_MANIFEST_BYTES));
        serde_json::from_reader::<_, ManifestHead>(text).is_ok()
    };
    if is_manifest || path.ends_with(MANIFEST_NAME) {
        return dataset(path);
    }
    let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
    let (expected, command) = match extension.to_str() {
        Some("lfold") => ("a container", "encode"),
        Some("glb") => ("a binary glTF file", "simplify"),
        Some("png") => ("a PNG picture", "quilt"),
        _ => {
            let message = "not a film: a container (.lfold), a simplified scene (.glb) or a quilt (.png) was expected; lightfold encode, \
                simplify and quilt write them";
            return Error::unsupported(message).in_file(path);
        }
    };
    let message = format!("not {expected}, despite its name: copy it again, or write it with lightfold {command}");
    Error::invalid(message).in_file(path)
}

/// Checks the CRC-32 of each chunk of a PNG file, up to the last one.
fn check_png(file: File, path: &Path) -> Result<()> {
    let mut file = BufReader::new(file);
    match png_is_whole(&mut file) {
        Ok(true) => Ok(()),
        Err(error) if error.kind() != ErrorKind::UnexpectedEof => Err(Error::io(path, error)),
        _ => {
            let message = "a PNG picture that is damaged or truncated: copy it again, or write it with lightfold quilt";
            Err(Error::invalid(message).in_file(path))
        }
    }
}

fn png_is_whole(file: &mut (impl BufRead + Seek)) -> std::io::Result<bool> {
    file.seek(SeekFrom::Start(PNG_MAGIC.len() as u64))?;
    loop {
        let (mut length, mut name, mut stored) = ([0; 4], [0; 4], [0; 4]);
        file.read_exact(&mut length)?;
        file.read_exact(&mut name)?;
        let mut crc32 = crc32fast::Hasher::new();
        crc32.update(&name);
        let mut left = u32::from_be_bytes(length) as usize;
        while left > 0 {
            let bytes = file.fill_buf()?;
            let count = bytes.len().min(left);
            if count == 0 {
                return Ok(false);
            }
            crc32.update(&bytes[..count]);
            file.consume(count);
            left -= count;
        }
        file.read_exact(&mut stored)?;
        if crc32.finalize() != u32::from_be_bytes(stored) {
            return Ok(false);
        }
        if &name == b"IEND" {
            return Ok(true);
        }
    }
}

/// Checks version and length in the first bytes of a binary glTF file.
fn check_glb(head: &[u8], path: &Path) -> Result<()> {
    let field = |at: usize| head.get(at..at + 4)?.try_into().ok().map(u32::from_le_bytes);
    let bytes = std::fs::metadata(path).map_err(|error| Error::io(path, error))?.len();
    match (field(4), field(8)) {
        (Some(2), Some(length)) if u64::from(length) <= bytes => Ok(()),
        (Some(2), Some(length)) => {
            let message = format!("truncated: the file has {bytes} of the {length} bytes that its glTF header states");
            Err(Error::invalid(message).in_file(path))
        }
        (Some(version), Some(_)) => {
            Err(Error::unsupported(format!("binary glTF of version {version}; 2 was expected")).in_file(path))
        }
        _ => Err(Error::invalid(format!("truncated: {bytes} bytes are too few for a binary glTF file")).in_file(path)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use footage::image_files::png;

    #[test]
    fn tags_follow_the_bytes_of_the_end_and_the_file_that_has_the_name() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.glb");
        let write = |end: u8| {
            let mut bytes = b"glTF\x02\0\0\0\x40\0\0\0".to_vec();
            bytes.resize(64, end);
            std::fs::write(&path, bytes).unwrap();
            let file = File::options().write(true).open(&path).unwrap();
            file.set_modified(UNIX_EPOCH).unwrap();
        };
        write(0);
        let film = Film::open(&path).unwrap();
        let tag = || film.open_now().unwrap().tag();
        let first = tag();
        assert_eq!((tag(), film.url()), (first.clone(), "film.glb"));
        write(1);
        let second = tag();
        assert_ne!(first, second, "the same length and time, another end");
        File::options().write(true).open(&path).unwrap().set_modified(SystemTime::now()).unwrap();
        assert_ne!(tag(), second, "another time");
        let opened = film.open_now().unwrap();
        assert_eq!((opened.state.bytes, opened.tag().matches('"').count()), (64, 2));
    }

    #[test]
    fn a_quilt_that_is_damaged_anywhere_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a_qs2x2.png");
        png::write_color8(&path, &codec::image::Plane::from_fn(12, 8, |x, y| [x as u8, y as u8, 7])).unwrap();
        let whole = std::fs::read(&path).unwrap();
        assert!(Film::open(&path).is_ok());
        let refused = |bytes: &[u8]| {
            std::fs::write(&path, bytes).unwrap();
            Film::open(&path).unwrap_err().to_string()
        };
        for at in PNG_MAGIC.len()..whole.len() {
            assert!(refused(&whole[..at]).contains("damaged or truncated"), "cut at byte {at}");
            let mut other = whole.clone();
            other[at] ^= 1;
            assert!(refused(&other).contains("damaged or truncated"), "byte {at}");
        }
    }

    #[test]
    fn quilts_have_the_layout_of_their_names() {
        let folder = tempfile::tempdir().unwrap();
        let plane = codec::image::Plane::filled(12, 8, [0u8; 3]);
        let shape = |name: &str| {
            let path = folder.path().join(name);
            png::write_color8(&path, &plane).unwrap();
            Film::open(&path)
                .map(|film| film.description(1, &Opening::default()).quilt)
                .map_err(|error| error.to_string())
        };
        let quilt = |columns, rows, aspect| Ok(Some(QuiltShape { columns, rows, aspect }));
        assert_eq!(shape("a_qs4x2a0.75.png"), quilt(4, 2, 0.75));
        assert_eq!(shape("a_qs4x2.png"), quilt(4, 2, 0.75));
        assert_eq!(shape("a_qs4x1.png"), quilt(4, 1, 0.375));
        assert!(shape("a.png").unwrap_err().contains("film_qs8x6a0.75.png"));
        assert!(shape("a_qs13x1.png").unwrap_err().contains("12x8 pixels"));
    }
}
