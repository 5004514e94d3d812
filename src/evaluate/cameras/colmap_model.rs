//! Cameras and poses of COLMAP models, as text and binary files state them.

use std::collections::HashMap;

use glam::{DMat3, DQuat, DVec3};

use super::document::{FileCamera, of_camera};
use super::lens::Distortion;
use codec::error::{Error, Result};
use codec::math::Camera;
use render::camera_path::TimedCamera;

/// A camera model.
pub struct Model {
    pub name: &'static str,
    /// Number in binary files.
    pub number: i32,
    /// Indices of fx, fy, cx and cy in the parameters; those after cy are distortion.
    places: [usize; 4],
    pub parameter_count: usize,
    is_fisheye: bool,
}

const fn model(name: &'static str, number: i32, places: [usize; 4], parameter_count: usize, is_fisheye: bool) -> Model {
    Model { name, number, places, parameter_count, is_fisheye }
}

const ONE_FOCAL: [usize; 4] = [0, 0, 1, 2];
const TWO_FOCALS: [usize; 4] = [0, 1, 2, 3];

pub const MODELS: &[Model] = &[
    model("SIMPLE_PINHOLE", 0, ONE_FOCAL, 3, false),
    model("PINHOLE", 1, TWO_FOCALS, 4, false),
    model("SIMPLE_RADIAL", 2, ONE_FOCAL, 4, false),
    model("RADIAL", 3, ONE_FOCAL, 5, false),
    model("OPENCV", 4, TWO_FOCALS, 8, false),
    model("OPENCV_FISHEYE", 5, TWO_FOCALS, 8, true),
    model("FULL_OPENCV", 6, TWO_FOCALS, 12, false),
    model("FOV", 7, TWO_FOCALS, 5, true),
    model("SIMPLE_RADIAL_FISHEYE", 8, ONE_FOCAL, 4, true),
    model("RADIAL_FISHEYE", 9, ONE_FOCAL, 5, true),
    model("THIN_PRISM_FISHEYE", 10, TWO_FOCALS, 12, true),
];

/// The lens of a camera.
pub struct Intrinsics {
    size: [u32; 2],
    /// fx, fy, cx, cy.
    pinhole: [f64; 4],
}

impl Intrinsics {
    pub fn new(model: &Model, size: [u32; 2], parameters: &[f64], distortion: &mut Distortion) -> Result<Intrinsics> {
        if parameters.len() != model.parameter_count {
            let (found, expected) = (parameters.len(), model.parameter_count);
            let message = format!("{found} parameters were found, but {} has {expected}", model.name);
            return Err(Error::invalid(message));
        }
        if let Some(value) = parameters.iter().find(|value| !value.is_finite()) {
            return Err(Error::invalid(format!("“{value}” is not a number")));
        }
        if parameters[model.places[3] + 1..].iter().any(|value| *value != 0.0) {
            distortion.add(model.name);
        }
        if model.is_fisheye {
            distortion.add_fisheye();
        }
        Ok(Intrinsics { size, pinhole: model.places.map(|at| parameters[at]) })
    }
}

pub type Lenses = HashMap<u64, Intrinsics>;

/// A pose of images.txt or images.bin.
pub struct Image {
    /// Quaternion w, x, y, z.
    pub turn: [f64; 4],
    pub shift: [f64; 3],
    pub camera: u64,
    pub name: String,
}

impl Image {
    pub fn camera(self, lenses: &Lenses) -> Result<FileCamera> {
        let id = self.camera;
        let lens = lenses.get(&id).ok_or_else(|| Error::invalid(format!("there is no camera {id} in its model")))?;
        let [w, x, y, z] = self.turn;
        let quaternion = DQuat::from_xyzw(x, y, z, w);
        let length = quaternion.length();
        if !(0.999..=1.001).contains(&length) {
            return Err(Error::invalid(format!("a quaternion of length {length} is not a rotation")));
        }
        let to_world = DMat3::from_quat(quaternion.normalize()).transpose();
        let eye = -(to_world * DVec3::from_array(self.shift));
        let axes = [to_world.z_axis, to_world.x_axis, to_world.y_axis];
        let camera = Camera::pinhole(eye, axes, lens.size.map(f64::from), lens.pinhole).map_err(of_camera(id))?;
        Ok(FileCamera { name: self.name, size: Some(lens.size), timed: TimedCamera { camera, frames: None } })
    }
}
