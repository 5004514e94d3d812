//! Tests that cameras round-trip through each format, and that unsupported files are rejected with a one-sentence error.

use glam::DVec3;

use super::*;
use codec::image::FrameRange;
use codec::math::{Camera, Lens};
use render::camera_path::TimedCamera;

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
    read(&path, SETTINGS.fps).unwrap()
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
        (CameraFormat::Usd, 1e-12),
        (CameraFormat::Gltf, 1e-6),
    ] {
        check(&cameras, format, tolerance);
    }
}

#[test]
fn off_axis_windows_come_back_or_are_refused() {
    let cameras: Vec<FileCamera> =
        (0..3).map(|at| still(camera(f64::from(at), 35.0, [0.1 * f64::from(at), -0.05]))).collect();
    for format in [CameraFormat::Lightfold, CameraFormat::Transforms, CameraFormat::Colmap, CameraFormat::Usd] {
        check(&cameras, format, 1e-12);
    }
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
        (CameraFormat::Usd, 1e-12),
        (CameraFormat::Gltf, 2e-6),
    ] {
        check(&moving, format, tolerance);
    }
    let zooming: Vec<FileCamera> =
        (0..4).map(|at| at_frame(camera(1.0, 30.0 + f64::from(at), [0.01 * f64::from(at), 0.0]), at)).collect();
    check(&zooming, CameraFormat::Usd, 1e-12);
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

/// Reads a file with this text; with `cameras`, an `images.txt` beside that `cameras.txt`. Returns the error, or the number of
/// cameras.
fn said(text: &str, cameras: Option<&str>) -> String {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(if cameras.is_some() { "images.txt" } else { "file" });
    std::fs::write(&path, text).unwrap();
    if let Some(cameras) = cameras {
        std::fs::write(folder.path().join("cameras.txt"), cameras).unwrap();
    }
    read(&path, 24.0).map_or_else(|error| error.to_string(), |cameras| format!("{} cameras", cameras.len()))
}

#[test]
fn transforms_that_are_no_pinholes_are_refused() {
    let matrix = "[[1, 0, 0, 1], [0, 1, 0, 2], [0, 0, 1, 3], [0, 0, 0, 1]]";
    let with = |keys: &str, matrix: &str| {
        said(
            &format!(
                r#"{{ "w": 8, "h": 4{keys}, "frames": [{{ "file_path": "a.png", "transform_matrix": {matrix} }}] }}"#
            ),
            None,
        )
    };
    assert_eq!(with(r#", "fl_x": 5, "k1": 0.0, "p2": 0, "camera_model": "OPENCV""#, matrix), "1 cameras");
    assert_eq!(with(r#", "camera_angle_x": 1.2"#, matrix), "1 cameras");
    let frame = format!(r#""frames": [{{ "file_path": "a", "transform_matrix": {matrix} }}]"#);
    assert_eq!(said(&format!(r#"{{ "camera_angle_x": 1.2, {frame} }}"#), None), "1 cameras");
    assert!(said(&format!(r#"{{ "camera_angle_x": 1.2, "w": 8, {frame} }}"#), None).contains("\"h\" is missing"));
    assert!(said(&format!("{{ {frame} }}"), None).contains("\"w\" is missing"));
    for (keys, matrix, words) in [
        (r#", "fl_x": 5, "k1": 0.01"#, matrix, "lens distortion (\"k1\")"),
        (r#", "fl_x": 5, "camera_model": "OPENCV_FISHEYE""#, matrix, "OPENCV_FISHEYE"),
        ("", matrix, "\"fl_x\" is missing"),
        (r#", "fl_x": 5"#, "[[1, 0, 0], [0, 1, 0], [0, 0, 1]]", "4 rows of 4 numbers"),
        (r#", "fl_x": 5"#, "[[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, -1, 0]]", "reflection"),
        (r#", "fl_x": 5"#, "[[1, 1, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0]]", "shear"),
        (r#", "fl_x": 0"#, matrix, "frame 0"),
    ] {
        let said = with(keys, matrix);
        assert!(said.contains(words), "{keys} {matrix}: {said}");
    }
    assert!(said(r#"{ "frames": [] }"#, None).contains("no cameras"));
}

#[test]
fn colmap_models_that_are_no_pinholes_are_refused() {
    let image = "1 1 0 0 0 0 0 0 3 a b.png\n\n";
    assert_eq!(said(image, Some("# words\n3 OPENCV 8 4 5 5 4 2 0 0 0 0\n")), "1 cameras");
    for (text, cameras, words) in [
        (image, "3 OPENCV 8 4 5 5 4 2 0 0 0.1 0\n", "distortion (0.1)"),
        (image, "3 OPENCV_FISHEYE 8 4 5 5 4 2 0 0 0 0\n", "OPENCV_FISHEYE"),
        (image, "3 PINHOLE 8 4 5 5 4\n", "3 parameters were found, but PINHOLE has 4"),
        (image, "3 PINHOLE 8 4 5 5 4 nan\n", "“nan” is not a number"),
        (image, "4 PINHOLE 8 4 5 5 4 2\n", "no camera 3"),
        ("1 1 0 0 0 0 0 3 a.png\n", "3 PINHOLE 8 4 5 5 4 2\n", "were expected"),
        ("1 0 0 0 0 0 0 0 3 a.png\n", "3 PINHOLE 8 4 5 5 4 2\n", "line 1"),
    ] {
        let said = said(text, Some(cameras));
        assert!(said.contains(words), "{text} {cameras}: {said}");
    }
}

#[test]
fn usd_files_that_are_not_clear_are_refused() {
    let prim = |content: &str| said(&format!("#usda 1.0\ndef Camera \"a\" {{\n{content}\n}}\n"), None);
    let place = |op: &str| prim(&format!("{op}\nuniform token[] xformOpOrder = [\"xformOp:translate\"]"));
    assert_eq!(prim(""), "1 cameras");
    assert_eq!(place("double3 xformOp:translate.timeSamples = { 3: (1, 2, 3), 5: (2, 2, 2) }"), "3 cameras");
    for (said, words) in [
        (prim("token projection = \"orthographic\""), "orthographic"),
        (place(""), "has no value"),
        (place("double3 xformOp:translate = (1, 2)"), "three numbers"),
        (place("double3 xformOp:translate.timeSamples = { -3: (1, 2, 3), 5: (2, 2, 2) }"), "from 0 on"),
        (place("double3 xformOp:translate.timeSamples = { 0: (1, 2, 3), 1e9: (2, 2, 2) }"), "more than 100000 frames"),
        (place("double3 xformOp:translate.timeSamples = { 0: (1, 2, 3), 1: \"x\" }"), "a number was expected"),
        (said("PXR-USDC binary", None), "usdcat"),
        (said("#usda 1.0\ndef Xform \"a\" {}", None), "no cameras"),
    ] {
        assert!(said.contains(words), "{words}: {said}");
    }
}
