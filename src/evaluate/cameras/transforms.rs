//! `transforms.json` of nerfstudio and instant-ngp: camera-to-world matrices, in which the camera looks along −Z with +Y up
//! (docs.nerf.studio, data conventions).
//!
//! Written files have the additional key `frame` for cameras with a frame. `applied_transform` is not undone, since the matrices
//! include it. The lens is that of the photographs: distortion is noted and left out, and a fisheye becomes a pinhole with the
//! same focal length. A file with an angle but no size, such as those of NeRF's synthetic scenes, has square pixels, and square
//! pictures if it states one angle.

use glam::{DMat4, DVec4};
use serde::Deserialize;
use serde_json::{Map, Value, json};

use super::document::{Content, FileCamera, FileCameras, WriteSettings, Written, axes_of, matrix_of, of_camera};
use super::lens::Distortion;
use super::poses::{picture_names, poses};
use codec::error::{Error, Result};
use codec::image::FrameRange;
use codec::math::Camera;
use footage::text::json_with_comments;
use render::camera_path::TimedCamera;

/// Lens parameters of all frames, or of one frame.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(default)]
struct Keys {
    camera_model: Option<String>,
    is_fisheye: Option<bool>,
    camera_angle_x: Option<f64>,
    camera_angle_y: Option<f64>,
    fl_x: Option<f64>,
    fl_y: Option<f64>,
    cx: Option<f64>,
    cy: Option<f64>,
    w: Option<f64>,
    h: Option<f64>,
    #[serde(flatten)]
    others: Map<String, Value>,
}

#[derive(Deserialize)]
struct File {
    frames: Vec<Frame>,
    #[serde(flatten)]
    lens: Keys,
}

#[derive(Deserialize)]
struct Frame {
    #[serde(default)]
    file_path: String,
    transform_matrix: Vec<Vec<f64>>,
    frame: Option<u32>,
    #[serde(flatten)]
    lens: Keys,
}

/// Distortion coefficients.
const DISTORTION: [&str; 8] = ["k1", "k2", "k3", "k4", "k5", "k6", "p1", "p2"];
/// Camera models of perspective pictures.
const PERSPECTIVE: [&str; 7] =
    ["PINHOLE", "SIMPLE_PINHOLE", "OPENCV", "FULL_OPENCV", "SIMPLE_RADIAL", "RADIAL", "PERSPECTIVE"];

pub fn is_of(document: &Value) -> bool {
    document.get("frames").and_then(Value::as_array).is_some() && document.get("cameras").is_none()
}

pub fn read(content: &Content<'_>) -> Result<FileCameras> {
    let mut file: File = json_with_comments(content.bytes, "a nerfstudio transforms.json")?;
    let mut distortion = Distortion::default();
    let mut cameras = Vec::new();
    for (at, frame) in file.frames.iter().enumerate() {
        let lens = Lens::of(&file.lens, &frame.lens, &mut distortion, content.settings.size);
        let camera = lens.and_then(|lens| camera(&lens, frame));
        cameras.push(camera.map_err(|error| error.context(format!("frame {at}")))?);
    }
    let mut found = FileCameras { cameras, notes: distortion.notes() };
    let lenses = file.frames.iter_mut().map(|frame| &mut frame.lens).chain([&mut file.lens]);
    let others = lenses.map(|lens| {
        lens.others.retain(|key, _| !DISTORTION.contains(&key.as_str()) && key != "applied_transform");
        &lens.others
    });
    found.note_unused(others);
    found.sort_by_names();
    Ok(found)
}

/// Field of view of a picture.
struct Lens {
    /// Half the width and height of the picture at distance 1.
    half: [f64; 2],
    /// Offset of its centre at distance 1, to the right and down.
    middle: [f64; 2],
    /// Width and height in pixels, where the file or the caller states them.
    size: Option<[f64; 2]>,
}

impl Lens {
    /// Returns the lens of a frame, whose keys override those of the file. `size` applies if neither states one.
    fn of(all: &Keys, own: &Keys, distortion: &mut Distortion, size: Option<[u32; 2]>) -> Result<Lens> {
        let model = own.camera_model.as_deref().or(all.camera_model.as_deref()).unwrap_or("OPENCV");
        let is_fisheye = own.is_fisheye.or(all.is_fisheye) == Some(true) || model.contains("FISHEYE");
        if !is_fisheye && !PERSPECTIVE.contains(&model) {
            return Err(Error::unsupported(format!("camera model {model} is not supported")));
        }
        if is_fisheye {
            distortion.add_fisheye();
        }
        for key in DISTORTION {
            match own.others.get(key).or(all.others.get(key)) {
                None | Some(Value::Null) => {}
                Some(Value::Number(number)) if number.as_f64() == Some(0.0) => {}
                Some(Value::Number(_)) => distortion.add(key),
                Some(other) => return Err(Error::invalid(format!("\"{key}\" is {other}, not a number"))),
            }
        }
        let missing = |key: &str| Error::invalid(format!("\"{key}\" is missing"));
        let centre = [own.cx.or(all.cx), own.cy.or(all.cy)];
        let stated = match [own.w.or(all.w), own.h.or(all.h)] {
            [None, None] => size.map_or([None, None], |size| size.map(|size| Some(f64::from(size)))),
            stated => stated,
        };
        let angles = [own.camera_angle_x.or(all.camera_angle_x), own.camera_angle_y.or(all.camera_angle_y)];
        let half_of = |angle: Option<f64>| angle.map(|angle| (angle / 2.0).tan());
        let focal = [own.fl_x.or(all.fl_x), own.fl_y.or(all.fl_y)];
        let size = match (stated, centre) {
            ([Some(width), Some(height)], _) => [width, height],
            // The principal point is in the middle of most pictures.
            ([None, None], [Some(cx), Some(cy)]) if focal != [None; 2] => [2.0 * cx, 2.0 * cy],
            ([None, None], _) if focal == [None; 2] && angles != [None; 2] => {
                let half = [half_of(angles[0].or(angles[1])), half_of(angles[1].or(angles[0]))];
                let half = half.map(Option::unwrap_or_default);
                return Ok(Lens { half, middle: [0.0; 2], size: None });
            }
            ([None, _], ..) => return Err(missing("w")),
            ([_, None], ..) => return Err(missing("h")),
        };
        let of_angle = |axis: usize| half_of(angles[axis]).map(|half| size[axis] / 2.0 / half);
        let stated_focal = [0, 1].map(|axis| focal[axis].or_else(|| of_angle(axis)));
        let focal = match stated_focal {
            [Some(fx), Some(fy)] => [fx, fy],
            [Some(both), None] | [None, Some(both)] => [both; 2],
            [None, None] => return Err(missing("fl_x")),
        };
        if let Some(value) = focal.into_iter().chain(size).find(|value| !(value.is_finite() && *value > 0.0)) {
            return Err(Error::invalid(format!("{value} is neither a focal length nor a size of a picture")));
        }
        let centre = [0, 1].map(|axis| centre[axis].unwrap_or(size[axis] / 2.0));
        let half = [0, 1].map(|axis| size[axis] / 2.0 / focal[axis]);
        let middle = [0, 1].map(|axis| (size[axis] / 2.0 - centre[axis]) / focal[axis]);
        let is_stated = stated != [None; 2];
        Ok(Lens { half, middle, size: is_stated.then_some(size) })
    }
}

fn camera(lens: &Lens, frame: &Frame) -> Result<FileCamera> {
    let (eye, axes) = axes_of(&matrix(&frame.transform_matrix)?)?;
    let camera = Camera::with_window(eye, axes, lens.half, lens.middle).map_err(of_camera(&frame.file_path))?;
    let is_whole =
        |size: &[f64; 2]| size.iter().all(|size| size.fract() == 0.0 && (1.0..=f64::from(u32::MAX)).contains(size));
    Ok(FileCamera {
        name: frame.file_path.clone(),
        size: lens.size.filter(is_whole).map(|size| size.map(|size| size as u32)),
        timed: TimedCamera { camera, frames: frame.frame.map(|at| FrameRange { first: at, last: at }) },
    })
}

/// Converts rows of 4 numbers to a matrix; the last row may be omitted.
pub(super) fn matrix(rows: &[Vec<f64>]) -> Result<DMat4> {
    let expected = || Error::invalid("a \"transform_matrix\" of 4 rows of 4 numbers was expected");
    let row = |row: &Vec<f64>| <[f64; 4]>::try_from(row.as_slice()).map(DVec4::from_array).map_err(|_| expected());
    let rows: Vec<DVec4> = rows.iter().map(row).collect::<Result<_>>()?;
    match rows[..] {
        [a, b, c, ref rest @ ..] if rest.is_empty() || rest == [DVec4::W] => {
            Ok(DMat4::from_cols(a, b, c, DVec4::W).transpose())
        }
        _ => Err(expected()),
    }
}

pub fn write(cameras: &[FileCamera], settings: &WriteSettings) -> Result<Written> {
    let poses = poses(cameras)?;
    let names = picture_names(&poses);
    let lens = |camera: &FileCamera| {
        let size = camera.size_in(settings);
        let [fx, fy, cx, cy] = camera.timed.camera.intrinsics(size.map(f64::from));
        json!({ "w": size[0], "h": size[1], "fl_x": fx, "fl_y": fy, "cx": cx, "cy": cy })
    };
    let lenses: Vec<Value> = poses.iter().map(|pose| lens(pose.of)).collect();
    let is_one = lenses.windows(2).all(|pair| pair[0] == pair[1]);
    let frame = |((pose, lens), name): ((&super::poses::Pose<'_>, &Value), &String)| {
        let camera = &pose.of.timed.camera;
        let rows = matrix_of(camera.eye(), camera.axes()).transpose().to_cols_array_2d();
        let mut frame = json!({ "file_path": name, "transform_matrix": rows });
        if let Some(number) = pose.frame {
            frame["frame"] = number.into();
        }
        if !is_one {
            extend(&mut frame, lens);
        }
        frame
    };
    let frames: Vec<Value> = poses.iter().zip(&lenses).zip(&names).map(frame).collect();
    let mut document = json!({ "camera_model": "OPENCV" });
    if let Some(lens) = lenses.first().filter(|_| is_one) {
        extend(&mut document, lens);
    }
    document["frames"] = frames.into();
    Ok(Written::File(footage::json::pretty(&document)?.into_bytes()))
}

fn extend(object: &mut Value, others: &Value) {
    for (key, value) in others.as_object().into_iter().flatten() {
        object[key] = value.clone();
    }
}
