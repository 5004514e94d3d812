//! Table of camera formats.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use serde_json::Value;

use super::document::{Content, FileCamera, WriteSettings, Written};
use super::{colmap, gltf, own, probes, transforms, usd};
use codec::container::header::is_container;
use codec::error::{Error, Result};
use footage::dataset::manifest::MANIFEST_NAME;
use scene::mesh::gltf::document::is_glb;

/// Maximum size of a file in bytes.
const MAX_BYTES: u64 = 256 << 20;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CameraFormat {
    /// Camera files of lightfold.
    Lightfold,
    /// `transforms.json` of nerfstudio.
    Transforms,
    /// Text model of COLMAP, `cameras.txt` and `images.txt`.
    Colmap,
    Gltf,
    /// USD text files.
    Usd,
}

type ReadCameras = fn(&Content<'_>) -> Result<Vec<FileCamera>>;
type WriteCameras = fn(&[FileCamera], &WriteSettings) -> Result<Written>;

const FORMATS: &[(CameraFormat, ReadCameras, WriteCameras)] = &[
    (CameraFormat::Lightfold, own::read, own::write),
    (CameraFormat::Transforms, transforms::read, transforms::write),
    (CameraFormat::Colmap, colmap::read, colmap::write),
    (CameraFormat::Gltf, gltf::read, gltf::write),
    (CameraFormat::Usd, usd::read, usd::write),
];

impl CameraFormat {
    fn functions(self) -> (ReadCameras, WriteCameras) {
        let found = FORMATS.iter().find(|(format, ..)| *format == self);
        found.map_or((own::read as ReadCameras, own::write as WriteCameras), |(_, read, write)| (*read, *write))
    }

    /// Returns the format of a file with this content.
    pub fn of_content(bytes: &[u8]) -> CameraFormat {
        if usd::is_of(bytes) {
            return CameraFormat::Usd;
        }
        if is_glb(bytes) {
            return CameraFormat::Gltf;
        }
        match serde_json::from_slice::<Value>(bytes) {
            Ok(document) if own::has_probes(&document) => CameraFormat::Lightfold,
            Ok(document) if document.get("asset").is_some() => CameraFormat::Gltf,
            Ok(document) if transforms::is_of(&document) => CameraFormat::Transforms,
            _ => CameraFormat::Lightfold,
        }
    }

    /// Returns the format of a file or folder to write by its name; `None` if the name does not determine it.
    pub fn of_name(path: &Path) -> Option<CameraFormat> {
        let name = path.file_name()?.to_string_lossy().to_lowercase();
        match name.rsplit_once('.').map(|(_, ending)| ending) {
            Some("json") if name.starts_with("transforms") => Some(CameraFormat::Transforms),
            Some("json") => Some(CameraFormat::Lightfold),
            Some("glb") => Some(CameraFormat::Gltf),
            Some("usda") => Some(CameraFormat::Usd),
            None => Some(CameraFormat::Colmap),
            Some(_) => None,
        }
    }
}

/// Reads the cameras of a file, or of the probes of a container or dataset; at least one. The path `-` is standard input. `fps`
/// is frames per second, for formats with times in seconds.
pub fn read(path: &Path, fps: f64) -> Result<Vec<FileCamera>> {
    let read = || {
        if path != Path::new("-") && (path.join(MANIFEST_NAME).is_file() || path.is_file() && is_container(path)?) {
            return probes::of_probes(path);
        }
        let (path, folder) = match colmap::folder(path) {
            Some(folder) => (folder.join(colmap::IMAGES), true),
            None => (path.to_path_buf(), false),
        };
        if folder && !path.is_file() {
            return Err(Error::invalid(
                "a COLMAP text model with images.txt and cameras.txt was expected, and one is missing: convert a \
                binary model with colmap model_converter",
            ));
        }
        let bytes = bytes(&path)?;
        let content = Content { path: &path, bytes: &bytes, fps };
        let cameras = if folder { colmap::read(&content) } else { parse(&content) };
        let cameras = cameras.map_err(|error| error.in_file(&path))?;
        if cameras.is_empty() {
            return Err(Error::invalid("it has no cameras, where at least one was expected").in_file(&path));
        }
        Ok(cameras)
    };
    read().map_err(|error: Error| error.in_file(path))
}

/// Parses the cameras of a file of any format but COLMAP, which is determined by its content.
pub fn parse(content: &Content<'_>) -> Result<Vec<FileCamera>> {
    let (read, _) = CameraFormat::of_content(content.bytes).functions();
    read(content)
}

fn bytes(path: &Path) -> Result<Vec<u8>> {
    let source: Box<dyn Read> = match path == Path::new("-") {
        true => Box::new(std::io::stdin().lock()),
        false => Box::new(File::open(path).map_err(|error| Error::io(path, error))?),
    };
    let mut bytes = Vec::new();
    source.take(MAX_BYTES + 1).read_to_end(&mut bytes).map_err(|error| Error::io(path, error))?;
    match bytes.len() as u64 > MAX_BYTES {
        true => Err(Error::invalid(format!("a file of cameras has at most {MAX_BYTES} bytes")).in_file(path)),
        false => Ok(bytes),
    }
}

/// Writes perspective cameras in a format.
pub fn write(cameras: &[FileCamera], format: CameraFormat, settings: &WriteSettings) -> Result<Written> {
    let (_, write) = format.functions();
    write(cameras, settings)
}
