//! Table of camera formats.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use serde_json::Value;

use super::document::{Content, FileCamera, FileCameras, ReadSettings, WriteSettings, Written};
use super::{colmap, gltf, own, paths, probes, transforms, usd};
use codec::container::header::is_container;
use codec::error::{Error, Result};
use footage::dataset::manifest::MANIFEST_NAME;
use footage::text::{decode, json_with_comments};
use scene::mesh::gltf::document::is_glb;

/// Maximum size of a file in bytes.
const MAX_BYTES: u64 = 256 << 20;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CameraFormat {
    /// Camera files of lightfold.
    Lightfold,
    /// `transforms.json` of nerfstudio.
    Transforms,
    /// Model of COLMAP.
    Colmap,
    Gltf,
    Usd,
    /// `camera_path.json` of nerfstudio.
    NerfstudioPath,
    /// `cameras.json` of Gaussian splatting.
    Splatting,
    /// `base_cam.json` of instant-ngp.
    InstantNgp,
}

type IsOf = fn(&Value) -> bool;
type Reader = fn(&Content<'_>) -> Result<FileCameras>;
type Writer = fn(&[FileCamera], &WriteSettings) -> Result<Written>;

/// Formats with their readers, and writers for those that are written.
const FORMATS: &[(CameraFormat, Reader, Option<Writer>)] = &[
    (CameraFormat::Lightfold, own::read, Some(own::write)),
    (CameraFormat::Transforms, transforms::read, Some(transforms::write)),
    (CameraFormat::Colmap, colmap::read, Some(colmap::write)),
    (CameraFormat::Gltf, gltf::read, Some(gltf::write)),
    (CameraFormat::Usd, usd::read, Some(usd::write)),
    (CameraFormat::NerfstudioPath, paths::read_nerfstudio, None),
    (CameraFormat::Splatting, paths::read_splatting, None),
    (CameraFormat::InstantNgp, paths::read_instant_ngp, None),
];

/// JSON formats by their content. Others are camera files of lightfold, whose reader reports what it expects.
const JSON_FORMATS: &[(CameraFormat, IsOf)] = &[
    (CameraFormat::Lightfold, own::has_probes),
    (CameraFormat::Gltf, |document| document.get("asset").is_some()),
    (CameraFormat::Transforms, transforms::is_of),
    (CameraFormat::NerfstudioPath, paths::is_nerfstudio),
    (CameraFormat::Splatting, paths::is_splatting),
    (CameraFormat::InstantNgp, paths::is_instant_ngp),
];

impl CameraFormat {
    fn functions(self) -> (Reader, Option<Writer>) {
        let found = FORMATS.iter().find(|(format, ..)| *format == self);
        found.map_or((own::read as Reader, None), |(_, read, write)| (*read, *write))
    }

    /// Returns the format of a file with this content.
    pub fn of_content(bytes: &[u8]) -> CameraFormat {
        // A byte order mark may precede any text.
        let text = decode(bytes).unwrap_or_default();
        if usd::is_of(bytes) || usd::is_of(text.as_bytes()) {
            return CameraFormat::Usd;
        }
        if is_glb(bytes) {
            return CameraFormat::Gltf;
        }
        let Ok(document) = json_with_comments::<Value>(bytes, "JSON") else { return CameraFormat::Lightfold };
        let found = JSON_FORMATS.iter().find(|(_, is_of)| is_of(&document));
        found.map_or(CameraFormat::Lightfold, |(format, _)| *format)
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

/// Reads the cameras of a file, or of the probes of a container or dataset; at least one. The path `-` is standard input. Cameras
/// that cannot be used are left out and noted.
///
/// # Errors
///
/// [`Error::Invalid`] and [`Error::Unsupported`] if the file is of no known format or no camera of it can be used.
pub fn read(path: &Path, settings: ReadSettings) -> Result<FileCameras> {
    let read = || {
        if path != Path::new("-") && (path.join(MANIFEST_NAME).is_file() || path.is_file() && is_container(path)?) {
            let cameras = probes::of_probes(path)?;
            return Ok(FileCameras { cameras, notes: Vec::new() });
        }
        let model = colmap::images_file(path);
        let file = model.clone().unwrap_or_else(|| path.to_path_buf());
        if model.is_some() && !file.is_file() {
            return Err(Error::invalid(
                "a COLMAP model was expected: a folder with images and cameras, both .txt or both .bin, or with \
                sparse/0",
            ));
        }
        let bytes = bytes(&file)?;
        let content = Content { path: &file, bytes: &bytes, settings };
        let found = if model.is_some() { colmap::read(&content) } else { parse(&content) };
        let found = found.map_err(|error| error.in_file(&file))?;
        match (found.cameras.is_empty(), found.notes.first()) {
            (false, _) => Ok(found),
            (true, Some(note)) => Err(Error::unsupported(format!("it has no usable camera: {note}")).in_file(&file)),
            (true, None) => Err(Error::invalid("it has no cameras, where at least one was expected").in_file(&file)),
        }
    };
    read().map_err(|error: Error| error.in_file(path))
}

/// Parses the cameras of a file of any format but COLMAP, which is determined by its content.
pub fn parse(content: &Content<'_>) -> Result<FileCameras> {
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
///
/// # Errors
///
/// [`Error::Usage`] if the format is only read.
pub fn write(cameras: &[FileCamera], format: CameraFormat, settings: &WriteSettings) -> Result<Written> {
    let (_, write) = format.functions();
    let write = write.ok_or_else(|| Error::Usage(format!("{format:?} files are only read")))?;
    write(cameras, settings)
}
