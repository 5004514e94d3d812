//! The probes of a light field as cameras: a perspective probe is one, a cube map six of 90 degrees; a moving probe has them in each
//! frame.
//!
//! Faces of cube maps are stored mirrored. Their cameras see them the right way round, as `render` draws them.

use std::path::Path;

use super::document::FileCamera;
use crate::error::Result;
use crate::evaluate::TimedCamera;
use crate::evaluate::reference::{Reference, ReferenceImage};
use crate::image::{Face, FrameRange};
use crate::math::Camera;

/// The cameras of a container, or of a dataset, by probe and then by face. They have frames where these differ between them.
pub fn of_probes(path: &Path) -> Result<Vec<FileCamera>> {
    let images = Reference::open(path)?.images;
    let is_same = images.windows(2).all(|pair| pair[0].frames == pair[1].frames)
        && images.iter().all(|image| image.cameras().count() == 1);
    let camera = |(image, frames, camera): (&ReferenceImage, FrameRange, Camera)| -> Result<FileCamera> {
        let is_view = image.face == Face::View;
        let name = if is_view { image.probe.clone() } else { format!("{}_{}", image.probe, image.face.name()) };
        let upright = camera.mirrored();
        let camera = match is_view {
            true => camera,
            false => Camera::with_window(upright.eye(), upright.axes(), [1.0; 2], [0.0; 2])?,
        };
        let timed = TimedCamera { camera, frames: (!is_same).then_some(frames) };
        Ok(FileCamera { name: format!("probe_{name}"), size: Some(image.size), timed })
    };
    let all = images.iter().flat_map(|image| image.cameras().map(move |(frames, camera)| (image, frames, camera)));
    all.map(camera).collect()
}
