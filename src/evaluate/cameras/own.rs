//! The camera files of lightfold ([`crate::camera_file`]), and its files of probes to capture
//! ([`footage::dataset::CameraSet`]).

use std::path::Path;

use serde_json::Value;

use super::document::{Content, FileCamera, FileCameras, WriteSettings, Written};
use super::probes;
use crate::camera_file::{CameraEntry, CameraFile, MAX_CAMERA_FILE_BYTES};
use codec::error::{Error, Result};
use footage::dataset::CameraSet;
use footage::text::json;

/// Returns true for a manifest and for a file of probes to capture.
pub fn has_probes(document: &Value) -> bool {
    ["lightfield", "lightfold_cameras"].iter().any(|key| document.get(key).is_some())
}

pub fn read(content: &Content<'_>) -> Result<FileCameras> {
    Ok(FileCameras { cameras: cameras(content)?, notes: Vec::new() })
}

fn cameras(content: &Content<'_>) -> Result<Vec<FileCamera>> {
    if content.bytes.len() as u64 > MAX_CAMERA_FILE_BYTES {
        return Err(Error::invalid(format!("a camera file has at most {MAX_CAMERA_FILE_BYTES} bytes")));
    }
    match json::<Value>(content.bytes, "a camera file") {
        Ok(document) if document.get("lightfield").is_some() && content.path != Path::new("-") => {
            return probes::of_probes(content.path);
        }
        Ok(document) if has_probes(&document) => {
            return probes::of_placed(&CameraSet::from_json(content.bytes)?);
        }
        _ => {}
    }
    let cameras = CameraFile::parse(content.bytes)?;
    Ok(cameras.into_iter().map(|timed| FileCamera { name: String::new(), size: None, timed }).collect())
}

pub fn write(cameras: &[FileCamera], _settings: &WriteSettings) -> Result<Written> {
    let cameras = cameras.iter().map(|camera| CameraEntry::of(&camera.timed)).collect();
    let text = footage::json::pretty(&CameraFile { cameras })?;
    Ok(Written::File(text.into_bytes()))
}
