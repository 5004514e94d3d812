//! The probes of a light field as cameras: a perspective probe is one, a cube map six of 90 degrees.
//!
//! Faces of cube maps are stored mirrored. Their cameras see them the right way round, as `render` draws them.

use std::path::Path;

use super::document::FileCamera;
use crate::error::Result;
use crate::evaluate::TimedCamera;
use crate::evaluate::reference::{Reference, ReferenceImage};
use crate::image::Face;

/// The cameras of a container, or of a dataset, by probe and then by face. They have frames where these differ between probes.
pub fn of_probes(path: &Path) -> Result<Vec<FileCamera>> {
    let images = Reference::open(path)?.images;
    let is_same = images.windows(2).all(|pair| pair[0].frames == pair[1].frames);
    let camera = |image: &ReferenceImage| {
        let is_view = image.face == Face::View;
        let name = if is_view { image.probe.clone() } else { format!("{}_{}", image.probe, image.face.name()) };
        let camera = if is_view { image.camera } else { image.camera.mirrored() };
        let timed = TimedCamera { camera, frames: (!is_same).then_some(image.frames) };
        FileCamera { name: format!("probe_{name}"), size: Some(image.size), timed }
    };
    Ok(images.iter().map(camera).collect())
}
