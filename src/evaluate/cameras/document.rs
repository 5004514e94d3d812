//! Types and functions that all camera formats use.

use std::borrow::Cow;
use std::collections::{BTreeSet, HashSet};
use std::path::Path;

use glam::{DMat3, DMat4, DVec3};
use serde_json::{Map, Value};

use codec::error::{Error, Result};
use codec::image::FrameRange;
use codec::image::sequence::split_number;
use footage::account::listed;
use footage::text::decode;
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

/// Cameras of a file, and what of it was not used as it is.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct FileCameras {
    pub cameras: Vec<FileCamera>,
    /// Sentences about what was left out or replaced, and why.
    pub notes: Vec<String>,
}

impl FileCameras {
    /// Adds the poses of a camera; one that is not supported or damaged is left out and noted.
    pub fn add(&mut self, name: &str, poses: Result<Vec<FileCamera>>) {
        match poses {
            Ok(poses) => self.cameras.extend(poses),
            Err(error) => self.notes.push(format!("camera {name} was left out: {error}")),
        }
    }

    /// Notes the keys of JSON objects that no field of a format has.
    pub fn note_unused<'a>(&mut self, objects: impl IntoIterator<Item = &'a Map<String, Value>>) {
        let unused: BTreeSet<&str> = objects.into_iter().flat_map(Map::keys).map(String::as_str).collect();
        if !unused.is_empty() {
            let names: Vec<&str> = unused.into_iter().collect();
            self.notes.push(format!("keys that were not used: {}", listed(&names)));
        }
    }

    /// Returns the names of the cameras in order, each once. Poses of one camera may have names of their own.
    pub fn names(&self) -> Vec<&str> {
        let mut known = HashSet::new();
        self.cameras.iter().map(|camera| camera.name.as_str()).filter(|name| known.insert(*name)).collect()
    }

    /// Returns the first names, in words.
    pub fn listed(&self) -> String {
        const MAX_LISTED: usize = 8;
        let names = self.names();
        let more = if names.len() > MAX_LISTED { ", …" } else { "" };
        names[..names.len().min(MAX_LISTED)].join(", ") + more
    }

    /// True if two cameras have frames in common: their pictures are those of several cameras.
    pub fn share_frames(&self) -> bool {
        let mut frames: Vec<FrameRange> = self.cameras.iter().filter_map(|camera| camera.timed.frames).collect();
        frames.sort_unstable_by_key(|frames| frames.first);
        frames.windows(2).any(|pair| pair[1].first <= pair[0].last)
    }

    /// Keeps the camera with this name: that in the file, or the name of its picture without folders and ending.
    ///
    /// # Errors
    ///
    /// [`Error::Usage`] if there is none; the message lists the names.
    pub fn choose(&mut self, name: &str) -> Result<()> {
        let is_chosen = |camera: &FileCamera| camera.name == name || picture_stem(&camera.name) == name;
        if !self.cameras.iter().any(is_chosen) {
            return Err(Error::Usage(format!("there is no camera {name}, only {}", self.listed())));
        }
        self.cameras.retain(is_chosen);
        Ok(())
    }

    /// Leaves out cameras that do not move where others of the file do: their poses are those of one film.
    pub fn leave_out_still(&mut self) {
        let is_still = |camera: &FileCamera| camera.timed.frames.is_none();
        if self.cameras.iter().all(is_still) {
            return;
        }
        let still = self.cameras.iter().filter(|camera| is_still(camera));
        self.notes.extend(still.map(|camera| {
            format!("camera {} was left out: it does not move, and others do; `camera_name` chooses it", camera.name)
        }));
        self.cameras.retain(|camera| !is_still(camera));
    }

    /// Puts poses without frames in the order of the numbers in the names of their pictures, if each has one.
    pub fn sort_by_names(&mut self) {
        let number = |camera: &FileCamera| {
            let (_, number, _) = split_number(&camera.name)?;
            camera.timed.frames.is_none().then_some(())?;
            number.parse::<u64>().ok()
        };
        let Some(numbers) = self.cameras.iter().map(number).collect::<Option<Vec<u64>>>() else { return };
        if numbers.is_sorted() {
            return;
        }
        let mut order: Vec<usize> = (0..numbers.len()).collect();
        order.sort_by_key(|&at| numbers[at]);
        self.cameras = order.into_iter().map(|at| self.cameras[at].clone()).collect();
        self.notes.push("poses are in the order of the numbers of their pictures".into());
    }
}

/// Returns the name of a picture without its folders and ending.
pub fn picture_stem(name: &str) -> &str {
    let name = name.rsplit('/').next().unwrap_or(name);
    name.rsplit_once('.').map_or(name, |(stem, _)| stem)
}

#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct ReadSettings {
    /// Frames per second, for formats with times; without it 24, or for USD a frame for each time code.
    pub fps: Option<f64>,
    /// Width and height in pixels of pictures whose file states no size.
    pub size: Option<[u32; 2]>,
}

impl ReadSettings {
    pub fn with_fps(fps: f64) -> ReadSettings {
        ReadSettings { fps: Some(fps), ..ReadSettings::default() }
    }
}

/// Content of a file to read.
#[derive(Debug, Clone, Copy)]
pub struct Content<'a> {
    /// Path of the file; the files that it references are relative to it.
    pub path: &'a Path,
    /// Bytes of the file; for COLMAP those of the list of images.
    pub bytes: &'a [u8],
    pub settings: ReadSettings,
}

impl<'a> Content<'a> {
    pub fn text(&self) -> Result<Cow<'a, str>> {
        decode(self.bytes)
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
