//! `transforms.json` of nerfstudio and instant-ngp: camera-to-world matrices, in which the camera looks along −Z with +Y up
//! (docs.nerf.studio, data conventions).
//!
//! Written files have the additional key `frame` for cameras with a frame. `applied_transform` is not undone, since the matrices
//! include it. Files with `camera_angle_x` but no size, such as those of NeRF's synthetic scenes, are read as square images.

use glam::{DMat4, DVec4};
use serde::Deserialize;
use serde_json::{Map, Value, json};

use super::document::{Content, FileCamera, WriteSettings, Written, axes_of, matrix_of, of_camera};
use super::poses::{picture_names, poses};
use codec::error::{Error, Result};
use codec::image::FrameRange;
use codec::math::Camera;
use render::camera_path::TimedCamera;

/// Lens parameters of all frames, or of one frame.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(default)]
struct Keys {
    camera_model: Option<String>,
    camera_angle_x: Option<f64>,
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
const DISTORTION: [&str; 6] = ["k1", "k2", "k3", "k4", "p1", "p2"];
/// Camera models whose projection without distortion is that of a pinhole.
const MODELS: [&str; 6] = ["PINHOLE", "SIMPLE_PINHOLE", "OPENCV", "SIMPLE_RADIAL", "RADIAL", "PERSPECTIVE"];

pub fn is_of(document: &Value) -> bool {
    document.get("frames").and_then(Value::as_array).is_some() && document.get("cameras").is_none()
}

pub fn read(content: &Content<'_>) -> Result<Vec<FileCamera>> {
    let file: File = serde_json::from_slice(content.bytes)
        .map_err(|error| Error::invalid(format!("this is not a nerfstudio transforms.json: {error}")))?;
    let named = |(at, frame)| camera(&file.lens, frame).map_err(|error| error.context(format!("frame {at}")));
    file.frames.iter().enumerate().map(named).collect()
}

fn camera(all: &Keys, frame: &Frame) -> Result<FileCamera> {
    let own = &frame.lens;
    let model = own.camera_model.as_deref().or(all.camera_model.as_deref()).unwrap_or("OPENCV");
    if !MODELS.contains(&model) {
        return Err(Error::unsupported(format!("camera model {model} is not supported")));
    }
    for key in DISTORTION {
        let value = own.others.get(key).or(all.others.get(key));
        if value.is_some_and(|value| value.as_f64() != Some(0.0)) {
            return Err(Error::unsupported(format!(
                "lens distortion (\"{key}\") is not supported: undistort the images"
            )));
        }
    }
    let missing = |key: &str| Error::invalid(format!("\"{key}\" is missing"));
    let (angle, stated) = (own.camera_angle_x.or(all.camera_angle_x), [own.w.or(all.w), own.h.or(all.h)]);
    let is_square = angle.is_some() && stated == [None; 2];
    let [width, height] = if is_square { [Some(1.0); 2] } else { stated };
    let width = width.ok_or_else(|| missing("w"))?;
    let height = height.ok_or_else(|| missing("h"))?;
    let of_angle = angle.map(|angle| width / 2.0 / (angle / 2.0).tan());
    let fx = own.fl_x.or(all.fl_x).or(of_angle).ok_or_else(|| missing("fl_x"))?;
    let fy = own.fl_y.or(all.fl_y).unwrap_or(fx);
    let cx = own.cx.or(all.cx).unwrap_or(width / 2.0);
    let cy = own.cy.or(all.cy).unwrap_or(height / 2.0);
    let (eye, axes) = axes_of(&matrix(&frame.transform_matrix)?)?;
    let size = [width, height];
    let camera = Camera::pinhole(eye, axes, size, [fx, fy, cx, cy]).map_err(of_camera(&frame.file_path))?;
    let is_whole =
        !is_square && size.iter().all(|size| size.fract() == 0.0 && (1.0..=f64::from(u32::MAX)).contains(size));
    Ok(FileCamera {
        name: frame.file_path.clone(),
        size: is_whole.then(|| size.map(|size| size as u32)),
        timed: TimedCamera { camera, frames: frame.frame.map(|at| FrameRange { first: at, last: at }) },
    })
}

/// Converts rows of 4 numbers to a matrix; the last row may be omitted.
fn matrix(rows: &[Vec<f64>]) -> Result<DMat4> {
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
