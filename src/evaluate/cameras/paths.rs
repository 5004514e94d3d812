//! Camera paths and lists of programs for radiance fields: `camera_path.json` of nerfstudio's viewer, `cameras.json` of Gaussian
//! splatting, and `base_cam.json` of instant-ngp. Their cameras are successive poses without frames.

use glam::{DMat3, DMat4, DQuat, DVec3};
use serde::Deserialize;
use serde_json::{Map, Value};

use super::document::{Content, FileCamera, FileCameras, axes_of, of_camera};
use codec::error::{Error, Result};
use codec::math::{Camera, Lens};
use footage::text::{json, json_with_comments};
use render::camera_path::TimedCamera;

fn pose(name: String, size: Option<[u32; 2]>, camera: Camera) -> FileCamera {
    FileCamera { name, size, timed: TimedCamera { camera, frames: None } }
}

pub fn is_nerfstudio(document: &Value) -> bool {
    document.get("camera_path").is_some_and(Value::is_array)
}

#[derive(Deserialize)]
struct NerfstudioPath {
    camera_type: Option<String>,
    render_width: Option<u32>,
    render_height: Option<u32>,
    camera_path: Vec<NerfstudioPose>,
    #[serde(flatten)]
    others: Map<String, Value>,
}

#[derive(Deserialize)]
struct NerfstudioPose {
    /// Rows of a matrix from camera to world; the camera looks along −Z with +Y up.
    camera_to_world: Vec<f64>,
    /// Vertical field of view in degrees.
    fov: f64,
    aspect: Option<f64>,
    #[serde(flatten)]
    others: Map<String, Value>,
}

/// Reads `camera_path.json`, a pose for each picture.
pub fn read_nerfstudio(content: &Content<'_>) -> Result<FileCameras> {
    let path: NerfstudioPath = json(content.bytes, "a camera_path.json of nerfstudio")?;
    if let Some(kind) = path.camera_type.as_ref().filter(|kind| *kind != "perspective") {
        return Err(Error::unsupported(format!(
            "its \"camera_type\" is {kind}, only perspective cameras are supported"
        )));
    }
    let size = path.render_width.zip(path.render_height).map(|(width, height)| [width, height]);
    let of_size = size.map(|[width, height]| f64::from(width) / f64::from(height));
    let read = |at: usize, of: &NerfstudioPose| -> Result<FileCamera> {
        let rows = <[f64; 16]>::try_from(of.camera_to_world.as_slice())
            .map_err(|_| Error::invalid("a \"camera_to_world\" of 16 numbers was expected"))?;
        let (eye, axes) = axes_of(&DMat4::from_cols_array(&rows).transpose())?;
        let lens = Lens { aspect: of.aspect.or(of_size).unwrap_or(1.0), ..Lens::new(of.fov) };
        Ok(pose(at.to_string(), size, Camera::with_axes(eye, axes, lens)?))
    };
    let poses = path.camera_path.iter().enumerate();
    let cameras = poses.map(|(at, of)| read(at, of).map_err(of_camera(at))).collect::<Result<_>>()?;
    let mut found = FileCameras { cameras, notes: Vec::new() };
    found.note_unused(path.camera_path.iter().map(|of| &of.others).chain([&path.others]));
    Ok(found)
}

pub fn is_splatting(document: &Value) -> bool {
    let first = document.as_array().and_then(|all| all.first());
    first.is_some_and(|first| first.get("position").is_some() && first.get("rotation").is_some())
}

#[derive(Deserialize)]
struct SplattingCamera {
    id: Option<u64>,
    img_name: Option<String>,
    width: f64,
    height: f64,
    position: [f64; 3],
    /// Rows of a rotation from camera to world; the camera looks along +Z with +Y down.
    rotation: [[f64; 3]; 3],
    fx: f64,
    fy: f64,
    #[serde(flatten)]
    others: Map<String, Value>,
}

/// Reads `cameras.json` of Gaussian splatting, the cameras of its photographs.
pub fn read_splatting(content: &Content<'_>) -> Result<FileCameras> {
    let all: Vec<SplattingCamera> = json(content.bytes, "a cameras.json of Gaussian splatting")?;
    let read = |at: usize, of: &SplattingCamera| -> Result<FileCamera> {
        let turn = DMat3::from_cols_array_2d(&of.rotation).transpose();
        let to_world = DMat4::from_mat3(DMat3::from_cols(turn.x_axis, -turn.y_axis, -turn.z_axis));
        let (_, axes) = axes_of(&to_world)?;
        let size = [of.width, of.height];
        let lens = [of.fx, of.fy, of.width / 2.0, of.height / 2.0];
        let camera = Camera::pinhole(DVec3::from_array(of.position), axes, size, lens)?;
        let name = of.img_name.clone().unwrap_or_else(|| of.id.unwrap_or(at as u64).to_string());
        let is_whole = size.iter().all(|side| side.fract() == 0.0 && (1.0..=f64::from(u32::MAX)).contains(side));
        Ok(pose(name, is_whole.then(|| size.map(|side| side as u32)), camera))
    };
    let cameras = all.iter().enumerate().map(|(at, of)| read(at, of).map_err(of_camera(at))).collect::<Result<_>>()?;
    let mut found = FileCameras { cameras, notes: Vec::new() };
    found.note_unused(all.iter().map(|of| &of.others));
    found.sort_by_names();
    Ok(found)
}

pub fn is_instant_ngp(document: &Value) -> bool {
    let first = document.get("path").and_then(Value::as_array).and_then(|all| all.first());
    first.is_some_and(|first| first.get("R").is_some() && first.get("T").is_some())
}

#[derive(Deserialize)]
struct InstantNgpPath {
    path: Vec<InstantNgpKey>,
    #[serde(flatten)]
    others: Map<String, Value>,
}

#[derive(Deserialize)]
struct InstantNgpKey {
    /// Unit quaternion x, y, z, w from camera to the unit cube of instant-ngp; the camera looks along +Z with +Y down.
    #[serde(rename = "R")]
    turn: [f64; 4],
    #[serde(rename = "T")]
    place: [f64; 3],
    /// Vertical field of view in degrees.
    fov: f64,
    #[serde(flatten)]
    others: Map<String, Value>,
}

/// Position of the world's origin in the unit cube of instant-ngp, and length of a metre there, unless a `transforms.json` states
/// others.
const NGP_OFFSET: f64 = 0.5;
const NGP_SCALE: f64 = 0.33;

/// Reads `base_cam.json` of instant-ngp, the keys of a path.
pub fn read_instant_ngp(content: &Content<'_>) -> Result<FileCameras> {
    let path: InstantNgpPath = json_with_comments(content.bytes, "a base_cam.json of instant-ngp")?;
    // Its axes are those of the world in turn: x, y, z of the cube are y, z, x.
    let to_world = |v: DVec3| DVec3::new(v.z, v.x, v.y);
    let read = |at: usize, key: &InstantNgpKey| -> Result<FileCamera> {
        let turn = DQuat::from_array(key.turn);
        if !(0.999..=1.001).contains(&turn.length()) {
            return Err(Error::invalid(format!("a quaternion of length {} is not a rotation", turn.length())));
        }
        let turn = DMat3::from_quat(turn.normalize());
        let eye = to_world((DVec3::from_array(key.place) - NGP_OFFSET) / NGP_SCALE);
        let axes = [turn.z_axis, turn.x_axis, turn.y_axis].map(to_world);
        Ok(pose(at.to_string(), None, Camera::with_axes(eye, axes, Lens::new(key.fov))?))
    };
    let keys = path.path.iter().enumerate();
    let cameras = keys.map(|(at, key)| read(at, key).map_err(of_camera(at))).collect::<Result<_>>()?;
    let note = format!(
        "these are the keys of a spline, without the poses between them; a scale of {NGP_SCALE} and an offset of \
        {NGP_OFFSET} were assumed, those of instant-ngp where transforms.json states none"
    );
    let mut found = FileCameras { cameras, notes: vec![note] };
    found.note_unused(path.path.iter().map(|key| &key.others).chain([&path.others]));
    Ok(found)
}
