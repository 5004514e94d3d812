//! COLMAP models in text form: `cameras.txt` and `images.txt` in a folder (colmap.github.io/format.html).
//!
//! Poses are world-to-camera; the camera looks along +Z with +Y down. Poses in a file have no frames. 3D points are neither read
//! nor written.

use std::collections::HashMap;
use std::fmt::Write as _;
use std::path::Path;

use glam::{DMat3, DQuat, DVec3};

use super::document::{Content, FileCamera, WriteSettings, Written, of_camera};
use super::poses::{picture_names, poses};
use codec::error::{Error, Result};
use codec::math::Camera;
use render::camera_path::TimedCamera;

pub const CAMERAS: &str = "cameras.txt";
pub const IMAGES: &str = "images.txt";
const POINTS: &str = "points3D.txt";

/// Camera models: indices of fx, fy, cx and cy in the parameters, and the number of parameters. Parameters after cy are
/// distortion.
const MODELS: &[(&str, [usize; 4], usize)] = &[
    ("SIMPLE_PINHOLE", [0, 0, 1, 2], 3),
    ("PINHOLE", [0, 1, 2, 3], 4),
    ("SIMPLE_RADIAL", [0, 0, 1, 2], 4),
    ("RADIAL", [0, 0, 1, 2], 5),
    ("OPENCV", [0, 1, 2, 3], 8),
    ("FULL_OPENCV", [0, 1, 2, 3], 12),
];

/// A camera of `cameras.txt`.
struct Intrinsics {
    size: [u32; 2],
    /// fx, fy, cx, cy.
    pinhole: [f64; 4],
}

/// Returns the folder of a model if `path` is a folder, or a file of a model.
pub fn folder(path: &Path) -> Option<&Path> {
    let is_file = path.file_name().is_some_and(|name| name == CAMERAS || name == IMAGES);
    if is_file { path.parent() } else { path.is_dir().then_some(path) }
}

pub fn read(content: &Content<'_>) -> Result<Vec<FileCamera>> {
    let beside = content.path.with_file_name(CAMERAS);
    let text = std::fs::read_to_string(&beside).map_err(|error| Error::io(&beside, error))?;
    let lenses = intrinsics(&text).map_err(|error| error.in_file(&beside))?;
    let mut cameras = Vec::new();
    let mut lines = content.text()?.lines().enumerate();
    while let Some((number, line)) = lines.next() {
        let line = line.trim();
        if line.is_empty() || line.starts_with('#') {
            continue;
        }
        let named = |error: Error| error.context(format!("line {}", number + 1));
        cameras.push(image(line, &lenses).map_err(named)?);
        // The next line lists the points of the image.
        lines.next();
    }
    Ok(cameras)
}

fn image(line: &str, lenses: &HashMap<u64, Intrinsics>) -> Result<FileCamera> {
    let expected = || Error::invalid("IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, CAMERA_ID and NAME were expected");
    let words: Vec<&str> = line.split_whitespace().collect();
    if words.len() < 10 {
        return Err(expected());
    }
    let numbers: Vec<f64> = words[1..8].iter().map(|word| number(word)).collect::<Result<_>>()?;
    let id: u64 = words[8].parse().map_err(|_| expected())?;
    let name = words[9..].join(" ");
    let lens = lenses.get(&id).ok_or_else(|| Error::invalid(format!("there is no camera {id} in {CAMERAS}")))?;
    let quaternion = DQuat::from_xyzw(numbers[1], numbers[2], numbers[3], numbers[0]);
    if (quaternion.length() - 1.0).abs() > 1e-3 {
        return Err(Error::invalid(format!("a quaternion of length {} is not a rotation", quaternion.length())));
    }
    let to_world = DMat3::from_quat(quaternion.normalize()).transpose();
    let eye = -(to_world * DVec3::from_slice(&numbers[4..7]));
    let camera = Camera::pinhole(
        eye,
        [to_world.z_axis, to_world.x_axis, to_world.y_axis],
        lens.size.map(f64::from),
        lens.pinhole,
    );
    let timed = TimedCamera { camera: camera.map_err(of_camera(id))?, frames: None };
    Ok(FileCamera { name, size: Some(lens.size), timed })
}

fn intrinsics(text: &str) -> Result<HashMap<u64, Intrinsics>> {
    let mut all = HashMap::new();
    for (number, line) in text.lines().enumerate() {
        let line = line.trim();
        if line.is_empty() || line.starts_with('#') {
            continue;
        }
        let (id, lens) = camera(line).map_err(|error| error.context(format!("line {}", number + 1)))?;
        all.insert(id, lens);
    }
    Ok(all)
}

fn camera(line: &str) -> Result<(u64, Intrinsics)> {
    let words: Vec<&str> = line.split_whitespace().collect();
    let [id, model, width, height, parameters @ ..] = &words[..] else {
        return Err(Error::invalid("CAMERA_ID, MODEL, WIDTH, HEIGHT and parameters were expected"));
    };
    let whole =
        |word: &str| word.parse::<u32>().map_err(|_| Error::invalid(format!("“{word}” is not a size in pixels")));
    let size = [whole(width)?, whole(height)?];
    let id = id.parse().map_err(|_| Error::invalid(format!("“{id}” is not a camera ID")))?;
    let Some((_, places, count)) = MODELS.iter().find(|(name, ..)| name == model) else {
        return Err(Error::unsupported(format!(
            "camera model {model} is not supported: undistort its images (colmap image_undistorter)"
        )));
    };
    let parameters: Vec<f64> = parameters.iter().map(|word| number(word)).collect::<Result<_>>()?;
    if parameters.len() != *count {
        return Err(Error::invalid(format!("{} parameters were found, but {model} has {count}", parameters.len())));
    }
    let distortion = &parameters[places[3] + 1..];
    if let Some(value) = distortion.iter().find(|value| **value != 0.0) {
        return Err(Error::unsupported(format!(
            "a camera with distortion ({value}): undistort its images (colmap image_undistorter)"
        )));
    }
    Ok((id, Intrinsics { size, pinhole: places.map(|at| parameters[at]) }))
}

fn number(word: &str) -> Result<f64> {
    let value = word.parse::<f64>().ok().filter(|value| value.is_finite());
    value.ok_or_else(|| Error::invalid(format!("“{word}” is not a number")))
}

pub fn write(cameras: &[FileCamera], settings: &WriteSettings) -> Result<Written> {
    let poses = poses(cameras)?;
    let mut lenses: Vec<([u32; 2], [f64; 4])> = Vec::new();
    let mut images = "# IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, CAMERA_ID, NAME; then a line of points\n".to_owned();
    let mut out = "# CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]\n".to_owned();
    for (at, (pose, name)) in poses.iter().zip(picture_names(&poses)).enumerate() {
        let camera = &pose.of.timed.camera;
        let size = pose.of.size_in(settings);
        let lens = (size, camera.intrinsics(size.map(f64::from)));
        let known = lenses.iter().position(|other| *other == lens);
        let id = known.unwrap_or_else(|| {
            lenses.push(lens);
            lenses.len() - 1
        });
        let [forward, right, down] = camera.axes();
        let turn = DMat3::from_cols(right, down, forward).transpose();
        let [tx, ty, tz] = (-(turn * camera.eye())).to_array();
        let [qx, qy, qz, qw] = DQuat::from_mat3(&turn).normalize().to_array();
        let name = name.trim_start_matches("images/");
        let line = format!("{} {qw} {qx} {qy} {qz} {tx} {ty} {tz} {} {name}\n\n", at + 1, id + 1);
        images.push_str(&line);
    }
    for (at, ([width, height], [fx, fy, cx, cy])) in lenses.iter().enumerate() {
        let _ = writeln!(out, "{} PINHOLE {width} {height} {fx} {fy} {cx} {cy}", at + 1);
    }
    let points = "# POINT3D_ID, X, Y, Z, R, G, B, ERROR, TRACK[]\n".to_owned();
    Ok(Written::Folder(vec![(CAMERAS, out), (IMAGES, images), (POINTS, points)]))
}
