//! The probes of a light field as cameras: a perspective probe is one camera, a cube map is six cameras of 90 degrees. A moving
//! probe has its cameras in each frame.
//!
//! Faces of cube maps are stored mirrored; their cameras are not mirrored, like the images that `render` writes.

use std::path::Path;

use glam::{DQuat, DVec3};

use super::document::FileCamera;
use crate::camera_file::camera_of;
use crate::reference::{Reference, ReferenceImage};
use codec::error::{Error, Result};
use codec::image::{Face, FrameRange};
use codec::math::camera::rotation;
use codec::math::{Camera, Lens};
use footage::dataset::CameraSet;
use render::camera_path::TimedCamera;

/// Returns the cameras of a container or dataset, by probe and then by face. They have frames only if frames differ between
/// cameras or a probe moves.
pub fn of_probes(path: &Path) -> Result<Vec<FileCamera>> {
    let images = Reference::open(path)?.images;
    let is_same = images.windows(2).all(|pair| pair[0].frames == pair[1].frames)
        && images.iter().all(|image| image.cameras().count() == 1);
    let camera = |(image, frames, camera): (&ReferenceImage, FrameRange, Camera)| -> Result<FileCamera> {
        let is_view = image.face == Face::View;
        let name = if is_view { image.probe.clone() } else { format!("{}_{}", image.probe, image.face.name()) };
        let camera = if is_view { camera } else { of_face(camera.eye(), camera.axes())? };
        let timed = TimedCamera { camera, frames: (!is_same).then_some(frames) };
        Ok(FileCamera { name: format!("probe_{name}"), size: Some(image.size), timed })
    };
    let all = images.iter().flat_map(|image| image.cameras().map(move |(frames, camera)| (image, frames, camera)));
    all.map(camera).collect()
}

/// Returns the cameras of probes to capture: probes with a field of view are perspective, others are cube maps.
pub fn of_placed(set: &CameraSet) -> Result<Vec<FileCamera>> {
    let mut cameras = Vec::new();
    for (at, placed) in set.cameras.iter().enumerate() {
        let name = set.name_of(at);
        let frames = placed.frames.map(|[first, last]| FrameRange { first, last });
        let mut add = |name: String, camera: Result<Camera>| -> Result<()> {
            let camera = camera.map_err(|error| error.context(format!("camera {at}")))?;
            cameras.push(FileCamera {
                name: format!("probe_{name}"),
                size: None,
                timed: TimedCamera { camera, frames },
            });
            Ok(())
        };
        if let Some(fov_y_deg) = placed.fov_y_deg {
            add(name, camera_of(placed, fov_y_deg))?;
            continue;
        }
        let no_turn = || Error::invalid(format!("camera {at}: its orientation is not a quaternion of length 1"));
        let turn = placed.orientation.map_or(Some(DQuat::IDENTITY), rotation).ok_or_else(no_turn)?;
        for face in Face::CUBE {
            let camera = of_face(DVec3::from_array(placed.position), face.axes().map(|axis| turn * axis));
            add(format!("{name}_{}", face.name()), camera)?;
        }
    }
    Ok(cameras)
}

/// Returns the camera of a cube map face with mirrored `axes`, without the mirroring.
fn of_face(eye: DVec3, axes: [DVec3; 3]) -> Result<Camera> {
    let upright = Camera::with_axes(eye, axes, Lens::new(90.0))?.mirrored();
    Camera::with_window(eye, upright.axes(), [1.0; 2], [0.0; 2])
}
