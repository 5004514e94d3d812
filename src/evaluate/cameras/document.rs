//! What files of cameras have in common.

use std::path::Path;

use glam::{DMat3, DMat4, DVec3};

use crate::error::{Error, Result};
use crate::evaluate::TimedCamera;
use crate::evaluate::camera_path::MAX_PATH_FRAMES;

/// A camera of a file.
#[derive(Debug, Clone, PartialEq)]
pub struct FileCamera {
    /// Its name in the file; may be empty.
    pub name: String,
    /// Width and height of its pictures in pixels, where the file states them.
    pub size: Option<[u32; 2]>,
    pub timed: TimedCamera,
}

/// A file that is read.
#[derive(Debug, Clone, Copy)]
pub struct Content<'a> {
    /// Files that it names lie beside it.
    pub path: &'a Path,
    /// Of COLMAP those of images.txt.
    pub bytes: &'a [u8],
    /// Frames per second, of formats that have seconds.
    pub fps: f64,
}

impl<'a> Content<'a> {
    pub fn text(&self) -> Result<&'a str> {
        std::str::from_utf8(self.bytes)
            .map_err(|error| Error::invalid(format!("it is no text: byte {} is not UTF-8", error.valid_up_to())))
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WriteSettings {
    /// Height of pictures in pixels, and their width unless it follows from the aspect; of formats that state them, and cameras that do not.
    pub size: (u32, Option<u32>),
    /// Frames per second.
    pub fps: f64,
}

/// What is written.
#[derive(Debug, Clone, PartialEq)]
pub enum Written {
    File(Vec<u8>),
    /// Files of a folder, by name.
    Folder(Vec<(&'static str, String)>),
}

impl FileCamera {
    /// Width and height of its pictures in pixels.
    pub fn size_in(&self, settings: &WriteSettings) -> [u32; 2] {
        self.size.unwrap_or_else(|| {
            let (first, second) = settings.size;
            match second {
                Some(height) => [first, height],
                None => [((f64::from(first) * self.timed.camera.aspect()).round() as u32).max(1), first],
            }
        })
    }
}

/// Eye, and forward, right and down, of a matrix from a camera that looks along −Z with +Y up to the world. It may scale.
pub fn axes_of(to_world: &DMat4) -> Result<(DVec3, [DVec3; 3])> {
    let columns = DMat3::from_mat4(*to_world);
    let units = [columns.x_axis, columns.y_axis, columns.z_axis].map(DVec3::normalize);
    let [x, y, z] = units;
    if !to_world.is_finite() || !units.iter().all(|axis| axis.is_finite()) {
        return Err(Error::invalid("its matrix has numbers that are not finite, or axes of length 0"));
    }
    if [x.dot(y), y.dot(z), z.dot(x)].iter().any(|cosine| cosine.abs() > 1e-3) {
        return Err(Error::unsupported("its matrix shears, and a camera's axes are at right angles to each other"));
    }
    if x.cross(y).dot(z) < 0.0 {
        return Err(Error::unsupported("its matrix mirrors, which no camera does"));
    }
    let forward = -z;
    let right = (x - x.dot(forward) * forward).normalize();
    Ok((to_world.w_axis.truncate(), [forward, right, forward.cross(right)]))
}

/// The matrix of [`axes_of`].
pub fn matrix_of(eye: DVec3, [forward, right, down]: [DVec3; 3]) -> DMat4 {
    // Zeros have no sign.
    let column = |axis: DVec3, last: f64| (axis + DVec3::ZERO).extend(last);
    DMat4::from_cols(column(right, 0.0), column(-down, 0.0), column(-forward, 0.0), column(eye, 1.0))
}

/// Refuses a file of too many poses: cameras that move have one in each frame.
pub fn check_count(read: usize, more: f64) -> Result<()> {
    match read as f64 + more > f64::from(MAX_PATH_FRAMES) {
        true => Err(Error::unsupported(format!("the cameras have more than {MAX_PATH_FRAMES} frames"))),
        false => Ok(()),
    }
}

/// Names the camera in an error.
pub fn of_camera(name: impl std::fmt::Display) -> impl Fn(Error) -> Error {
    move |error| error.context(format!("camera {name}"))
}
