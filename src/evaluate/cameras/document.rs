//! Types and functions that all camera formats use.

use std::path::Path;

use glam::{DMat3, DMat4, DVec3};

use codec::error::{Error, Result};
use render::camera_path::{MAX_PATH_FRAMES, TimedCamera};

/// A camera in a file.
#[derive(Debug, Clone, PartialEq)]
pub struct FileCamera {
    /// Name in the file; may be empty.
    pub name: String,
    /// Width and height of the images in pixels; `None` if the file does not state them.
    pub size: Option<[u32; 2]>,
    pub timed: TimedCamera,
}

/// Content of a file to read.
#[derive(Debug, Clone, Copy)]
pub struct Content<'a> {
    /// Path of the file; the files that it references are relative to it.
    pub path: &'a Path,
    /// Bytes of the file; for COLMAP those of images.txt.
    pub bytes: &'a [u8],
    /// Frames per second, for formats with times in seconds.
    pub fps: f64,
}

impl<'a> Content<'a> {
    pub fn text(&self) -> Result<&'a str> {
        std::str::from_utf8(self.bytes)
            .map_err(|error| Error::invalid(format!("it is not text: byte {} is not UTF-8", error.valid_up_to())))
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WriteSettings {
    /// Image size in pixels, for formats that state it and cameras that do not: width and height, or only the height, in which
    /// case the width follows from the aspect ratio.
    pub size: (u32, Option<u32>),
    /// Frames per second.
    pub fps: f64,
}

/// Output of a format.
#[derive(Debug, Clone, PartialEq)]
pub enum Written {
    File(Vec<u8>),
    /// Names and contents of the files of a folder.
    Folder(Vec<(&'static str, String)>),
}

impl FileCamera {
    /// Returns the width and height of the images in pixels; from `settings` if the file does not state them.
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

/// Returns the eye and the unit vectors forward, right and down of a camera-to-world matrix. The camera looks along −Z with +Y
/// up. The matrix may scale; fails if it shears, mirrors or is not finite.
pub fn axes_of(to_world: &DMat4) -> Result<(DVec3, [DVec3; 3])> {
    let columns = DMat3::from_mat4(*to_world);
    let units = [columns.x_axis, columns.y_axis, columns.z_axis].map(DVec3::normalize);
    let [x, y, z] = units;
    if !to_world.is_finite() || !units.iter().all(|axis| axis.is_finite()) {
        return Err(Error::invalid("its matrix has numbers that are not finite, or axes of length 0"));
    }
    if [x.dot(y), y.dot(z), z.dot(x)].iter().any(|cosine| cosine.abs() > 1e-3) {
        return Err(Error::unsupported("its matrix has shear, but the axes of a camera must be orthogonal"));
    }
    if x.cross(y).dot(z) < 0.0 {
        return Err(Error::unsupported("its matrix is a reflection, which a camera cannot have"));
    }
    let forward = -z;
    let right = (x - x.dot(forward) * forward).normalize();
    Ok((to_world.w_axis.truncate(), [forward, right, forward.cross(right)]))
}

/// Returns the camera-to-world matrix; the inverse of [`axes_of`].
pub fn matrix_of(eye: DVec3, [forward, right, down]: [DVec3; 3]) -> DMat4 {
    // Adding zero turns negative zeros into positive ones.
    let column = |axis: DVec3, last: f64| (axis + DVec3::ZERO).extend(last);
    DMat4::from_cols(column(right, 0.0), column(-down, 0.0), column(-forward, 0.0), column(eye, 1.0))
}

/// Fails if a file has too many poses; a moving camera has one per frame.
pub fn check_count(read: usize, more: f64) -> Result<()> {
    match read as f64 + more > f64::from(MAX_PATH_FRAMES) {
        true => Err(Error::unsupported(format!("the cameras have more than {MAX_PATH_FRAMES} frames"))),
        false => Ok(()),
    }
}

/// Returns a function that adds the name of the camera to an error.
pub fn of_camera(name: impl std::fmt::Display) -> impl Fn(Error) -> Error {
    move |error| error.context(format!("camera {name}"))
}
