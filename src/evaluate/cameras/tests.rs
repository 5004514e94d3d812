//! Tests that cameras round-trip through each format.

#[path = "foreign/tests.rs"]
mod foreign;

use glam::DVec3;

use super::*;
use codec::image::FrameRange;
use codec::math::{Camera, Lens};
use render::camera_path::TimedCamera;

/// Lenses of USD are in single precision.
const OF_FLOATS: f64 = f32::EPSILON as f64;

const SETTINGS: WriteSettings = WriteSettings { size: (720, None), fps: 24.0 };

fn camera(at: f64, fov_y_deg: f64, middle: [f64; 2]) -> Camera {
    let eye = DVec3::new(at, 1.5 - at / 3.0, 0.25 * at * at);
    let lens = Lens { aspect: 16.0 / 9.0, ..Lens::new(fov_y_deg) };
    let camera = Camera::look_at(eye, DVec3::new(5.0, at, -7.0), DVec3::new(0.1, 1.0, 0.2), lens).unwrap();
    camera.off_axis(middle).unwrap()
}

fn still(camera: Camera) -> FileCamera {
    FileCamera { name: String::new(), size: None, timed: TimedCamera { camera, frames: None } }
}

fn at_frame(camera: Camera, frame: u32) -> FileCamera {
    let frames = Some(FrameRange { first: frame, last: frame });
    FileCamera { timed: TimedCamera { camera, frames }, ..still(camera) }
}

/// Writes cameras and reads them back.
fn again(cameras: &[FileCamera], format: CameraFormat) -> Vec<FileCamera> {
    let folder = tempfile::tempdir().unwrap();
    match write(cameras, format, &SETTINGS).unwrap() {
        Written::File(bytes) => std::fs::write(folder.path().join("file"), bytes).unwrap(),
        Written::Folder(files) => {
            files.iter().for_each(|(name, text)| std::fs::write(folder.path().join(name), text).unwrap());
        }
    }
    let path = if format == CameraFormat::Colmap { folder.path().to_path_buf() } else { folder.path().join("file") };
    read(&path, ReadSettings::with_fps(SETTINGS.fps)).unwrap().cameras
}

/// Returns the maximum of the distance of the eyes in metres and the differences of directions.
fn apart(a: &Camera, b: &Camera) -> f64 {
    let corners = [[0.0, 0.0], [1.0, 0.0], [0.3, 0.6], [0.0, 1.0], [1.0, 1.0]];
    let turned = corners.iter().map(|&at| (a.direction(at) - b.direction(at)).length());
    turned.fold((a.eye() - b.eye()).length(), f64::max)
}

fn check(cameras: &[FileCamera], format: CameraFormat, tolerance: f64) {
    let read = again(cameras, format);
    assert_eq!(read.len(), cameras.len(), "{format:?}");
    for (was, is) in cameras.iter().zip(&read) {
        let apart = apart(&was.timed.camera, &is.timed.camera);
        assert!(apart <= tolerance, "{format:?}: {apart:e}");
        if format != CameraFormat::Colmap {
            assert_eq!(was.timed.frames, is.timed.frames, "{format:?}");
        }
    }
}

#[test]
fn still_cameras_come_back() {
    let cameras: Vec<FileCamera> =
        (0..5).map(|at| still(camera(f64::from(at), 40.0 + f64::from(at), [0.0; 2]))).collect();
    for (format, tolerance) in [
        (CameraFormat::Lightfold, 1e-12),
        (CameraFormat::Transforms, 1e-12),
        (CameraFormat::Colmap, 1e-12),
        (CameraFormat::Usd, OF_FLOATS),
        (CameraFormat::Gltf, 1e-6),
    ] {
        check(&cameras, format, tolerance);
    }
}

#[test]
fn off_axis_windows_come_back_or_are_refused() {
    let cameras: Vec<FileCamera> =
        (0..3).map(|at| still(camera(f64::from(at), 35.0, [0.1 * f64::from(at), -0.05]))).collect();
    for format in [CameraFormat::Lightfold, CameraFormat::Transforms, CameraFormat::Colmap] {
        check(&cameras, format, 1e-12);
    }
    check(&cameras, CameraFormat::Usd, OF_FLOATS);
    let said = write(&cameras, CameraFormat::Gltf, &SETTINGS).unwrap_err().to_string();
    assert!(said.contains("off-axis"), "{said}");
}

#[test]
fn cameras_that_move_come_back_frame_by_frame() {
    let moving: Vec<FileCamera> = (3..40).map(|at| at_frame(camera(f64::from(at) / 8.0, 50.0, [0.0; 2]), at)).collect();
    for (format, tolerance) in [
        (CameraFormat::Lightfold, 1e-12),
        (CameraFormat::Transforms, 1e-12),
        (CameraFormat::Colmap, 1e-12),
        (CameraFormat::Usd, OF_FLOATS),
        (CameraFormat::Gltf, 2e-6),
    ] {
        check(&moving, format, tolerance);
    }
    let zooming: Vec<FileCamera> =
        (0..4).map(|at| at_frame(camera(1.0, 30.0 + f64::from(at), [0.01 * f64::from(at), 0.0]), at)).collect();
    check(&zooming, CameraFormat::Usd, OF_FLOATS);
    let zooming: Vec<FileCamera> = (0..4).map(|at| at_frame(camera(1.0, 30.0 + f64::from(at), [0.0; 2]), at)).collect();
    assert!(write(&zooming, CameraFormat::Gltf, &SETTINGS).unwrap_err().to_string().contains("field of view"));
    // A range of frames is one pose per frame, and two cameras in one frame are two moving cameras.
    let range = FrameRange { first: 2, last: 4 };
    let mut held = at_frame(camera(0.0, 50.0, [0.0; 2]), 0);
    held.timed.frames = Some(range);
    let read = again(&[held.clone(), at_frame(camera(1.0, 50.0, [0.0; 2]), 3)], CameraFormat::Usd);
    let frames: Vec<u32> = read.iter().map(|camera| camera.timed.frames.unwrap().first).collect();
    assert_eq!(frames, [2, 3, 4, 3]);
    assert_eq!(again(std::slice::from_ref(&held), CameraFormat::Lightfold)[0].timed.frames, Some(range));
}

#[test]
fn formats_are_recognised() {
    let cameras = [still(camera(1.0, 40.0, [0.0; 2]))];
    for format in [CameraFormat::Lightfold, CameraFormat::Transforms, CameraFormat::Gltf, CameraFormat::Usd] {
        let Written::File(bytes) = write(&cameras, format, &SETTINGS).unwrap() else { panic!("a file") };
        assert_eq!(CameraFormat::of_content(&bytes), format);
    }
    for (name, format) in [
        ("a/transforms.json", Some(CameraFormat::Transforms)),
        ("transforms_train.json", Some(CameraFormat::Transforms)),
        ("path.json", Some(CameraFormat::Lightfold)),
        ("a.GLB", Some(CameraFormat::Gltf)),
        ("b.usda", Some(CameraFormat::Usd)),
        ("folder", Some(CameraFormat::Colmap)),
        ("b.txt", None),
    ] {
        assert_eq!(CameraFormat::of_name(std::path::Path::new(name)), format, "{name}");
    }
}
