//! COLMAP models: `cameras` and `images` in a folder, as text or binary (colmap.github.io/format.html).
//!
//! Poses are world-to-camera; the camera looks along +Z with +Y down. Poses in a file have no frames. 3D points are neither read
//! nor written. The lens is that of the photographs: distortion is noted and left out, and a fisheye becomes a pinhole with the
//! same focal length.

use std::collections::HashMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use glam::{DMat3, DQuat};

use super::colmap_binary;
use super::colmap_model::{Image, Intrinsics, Lenses, MODELS};
use super::document::{Content, FileCamera, FileCameras, WriteSettings, Written};
use super::lens::Distortion;
use super::poses::{picture_names, poses};
use codec::error::{Error, Result};

pub const CAMERAS: &str = "cameras.txt";
pub const IMAGES: &str = "images.txt";
const POINTS: &str = "points3D.txt";

/// Folders of a model below that of a project, as COLMAP and nerfstudio make them.
const MODEL_FOLDERS: [&str; 5] = ["", "sparse/0", "sparse", "colmap/sparse/0", "0"];

/// Returns the file of images of a model, if `path` is a folder or a file of a model. In a folder without a model it is that of a
/// text model.
pub fn images_file(path: &Path) -> Option<PathBuf> {
    let of_model = [CAMERAS, IMAGES, colmap_binary::CAMERAS, colmap_binary::IMAGES];
    if path.is_file() {
        let name = path.file_name().filter(|name| of_model.iter().any(|known| name == known))?;
        let is_text = name.to_string_lossy().ends_with(".txt");
        return Some(path.with_file_name(if is_text { IMAGES } else { colmap_binary::IMAGES }));
    }
    let models = MODEL_FOLDERS.iter().flat_map(|folder| {
        let folder = path.join(folder);
        [(IMAGES, CAMERAS), (colmap_binary::IMAGES, colmap_binary::CAMERAS)]
            .map(|(images, cameras)| (folder.join(images), folder.join(cameras)))
    });
    path.is_dir().then(|| {
        let found = models.into_iter().find(|(images, cameras)| images.is_file() && cameras.is_file());
        found.map_or_else(|| path.join(IMAGES), |(images, _)| images)
    })
}

pub fn read(content: &Content<'_>) -> Result<FileCameras> {
    let mut distortion = Distortion::default();
    let is_text = content.path.extension().is_some_and(|ending| ending == "txt");
    let beside = content.path.with_file_name(if is_text { CAMERAS } else { colmap_binary::CAMERAS });
    let bytes = std::fs::read(&beside).map_err(|error| Error::io(&beside, error))?;
    let in_file = |error: Error| error.in_file(&beside);
    let cameras = if is_text {
        let text = Content { bytes: &bytes, ..*content }.text().map_err(in_file)?;
        let lenses = lenses(&text, &mut distortion).map_err(in_file)?;
        images(&content.text()?, &lenses)?
    } else {
        let lenses = colmap_binary::lenses(&bytes, &mut distortion).map_err(in_file)?;
        colmap_binary::images(content.bytes, &lenses)?
    };
    let mut found = FileCameras { cameras, notes: distortion.notes() };
    found.sort_by_names();
    Ok(found)
}

fn images(text: &str, lenses: &Lenses) -> Result<Vec<FileCamera>> {
    let mut cameras = Vec::new();
    let mut lines = text.lines().map(str::trim).enumerate().filter(|(_, line)| !line.starts_with('#')).peekable();
    while let Some((number, line)) = lines.next() {
        if line.is_empty() {
            continue;
        }
        let named = |error: Error| error.context(format!("line {}", number + 1));
        cameras.push(image(line).and_then(|image| image.camera(lenses)).map_err(named)?);
        // The points of the image follow; some writers leave out the line.
        lines.next_if(|(_, line)| line.is_empty() || are_points(line));
    }
    Ok(cameras)
}

/// True for a line of points: each has X, Y and the index of a 3D point.
fn are_points(line: &str) -> bool {
    let words: Vec<&str> = line.split_whitespace().collect();
    words.len().is_multiple_of(3) && words.iter().all(|word| word.parse::<f64>().is_ok())
}

fn image(line: &str) -> Result<Image> {
    let expected = || Error::invalid("IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, CAMERA_ID and NAME were expected");
    let words: Vec<&str> = line.split_whitespace().collect();
    if words.len() < 10 {
        return Err(expected());
    }
    let numbers: Vec<f64> = words[1..8].iter().map(|word| number(word)).collect::<Result<_>>()?;
    let [qw, qx, qy, qz, tx, ty, tz] = numbers[..] else { return Err(expected()) };
    Ok(Image {
        turn: [qw, qx, qy, qz],
        shift: [tx, ty, tz],
        camera: words[8].parse().map_err(|_| expected())?,
        name: words[9..].join(" "),
    })
}

fn lenses(text: &str, distortion: &mut Distortion) -> Result<Lenses> {
    let mut all = HashMap::new();
    for (number, line) in text.lines().enumerate() {
        let line = line.trim();
        if line.is_empty() || line.starts_with('#') {
            continue;
        }
        let (id, lens) = lens(line, distortion).map_err(|error| error.context(format!("line {}", number + 1)))?;
        all.insert(id, lens);
    }
    Ok(all)
}

fn lens(line: &str, distortion: &mut Distortion) -> Result<(u64, Intrinsics)> {
    let words: Vec<&str> = line.split_whitespace().collect();
    let [id, model, width, height, parameters @ ..] = &words[..] else {
        return Err(Error::invalid("CAMERA_ID, MODEL, WIDTH, HEIGHT and parameters were expected"));
    };
    let whole =
        |word: &str| word.parse::<u32>().map_err(|_| Error::invalid(format!("“{word}” is not a size in pixels")));
    let size = [whole(width)?, whole(height)?];
    let id = id.parse().map_err(|_| Error::invalid(format!("“{id}” is not a camera ID")))?;
    let known = MODELS.iter().find(|known| known.name == *model);
    let known = known.ok_or_else(|| Error::unsupported(format!("camera model {model} is not supported")))?;
    let parameters: Vec<f64> = parameters.iter().map(|word| number(word)).collect::<Result<_>>()?;
    Ok((id, Intrinsics::new(known, size, &parameters, distortion)?))
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
