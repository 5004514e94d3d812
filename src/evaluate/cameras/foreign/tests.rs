//! Tests of files as other programs write them: what is read, what is left out, and what is refused with one sentence.

use glam::DVec3;

use crate::cameras::*;
use codec::error::Result;

/// Files of a folder by their paths in it.
struct Files(tempfile::TempDir);

impl Files {
    fn new(files: &[(&str, &[u8])]) -> Files {
        let folder = tempfile::tempdir().unwrap();
        for (name, bytes) in files {
            let path = folder.path().join(name);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, bytes).unwrap();
        }
        Files(folder)
    }

    fn read(&self, name: &str) -> Result<FileCameras> {
        read(&self.0.path().join(name), ReadSettings::with_fps(24.0))
    }
}

/// Returns the error, or the number of cameras and the notes.
fn said(found: Result<FileCameras>) -> String {
    found.map_or_else(
        |error| error.to_string(),
        |found| {
            let count = format!("{} cameras", found.cameras.len());
            [count].into_iter().chain(found.notes).collect::<Vec<_>>().join("; ")
        },
    )
}

fn said_of(text: &str) -> String {
    said(Files::new(&[("file", text.as_bytes())]).read("file"))
}

fn said_of_model(cameras: &str, images: &str) -> String {
    said(Files::new(&[("cameras.txt", cameras.as_bytes()), ("images.txt", images.as_bytes())]).read("images.txt"))
}

const MATRIX: &str = "[[1, 0, 0, 1], [0, 1, 0, 2], [0, 0, 1, 3], [0, 0, 0, 1]]";

fn transforms(keys: &str, matrix: &str) -> String {
    format!(r#"{{ {keys} "frames": [{{ "file_path": "a.png", "transform_matrix": {matrix} }}] }}"#)
}

#[test]
fn lenses_of_transforms_are_pinholes() {
    for (keys, expected) in [
        (r#""w": 8, "h": 4, "fl_x": 5, "k1": 0.0, "k2": null, "p2": 0, "camera_model": "OPENCV","#, "1 cameras"),
        (r#""w": 8, "h": 4, "camera_angle_x": 1.2,"#, "1 cameras"),
        (r#""camera_angle_x": 1.2,"#, "1 cameras"),
        (
            r#""w": 8, "h": 4, "fl_x": 5, "k1": 0.01, "p1": 1e-5,"#,
            "1 cameras; the lens distortion of the photographs (k1, p1) was left out: poses and focal lengths are used",
        ),
        (
            r#""w": 8, "h": 4, "fl_x": 5, "camera_model": "OPENCV_FISHEYE","#,
            "1 cameras; the fisheye lens was replaced by a pinhole with the same focal length",
        ),
        (
            r#""w": 8, "h": 4, "fl_x": 5, "is_fisheye": true,"#,
            "1 cameras; the fisheye lens was replaced by a pinhole with the same focal length",
        ),
    ] {
        assert_eq!(said_of(&transforms(keys, MATRIX)), expected, "{keys}");
    }
}

#[test]
fn fields_of_view_follow_from_either_angle_or_the_principal_point() {
    let degrees = |angle: f64| angle.to_degrees();
    for (keys, fov_y_deg, aspect) in [
        (r#""camera_angle_x": 1.2, "camera_angle_y": 0.8,"#, degrees(0.8), 0.6f64.tan() / 0.4f64.tan()),
        (r#""camera_angle_y": 0.8, "w": 640, "h": 480,"#, degrees(0.8), 640.0 / 480.0),
        (r#""camera_angle_x": 1.2, "w": 640, "h": 480,"#, degrees(2.0 * (0.6f64.tan() * 0.75).atan()), 640.0 / 480.0),
        (r#""camera_angle_y": 0.8,"#, degrees(0.8), 1.0),
        (r#""fl_x": 500, "fl_y": 500, "cx": 320, "cy": 240,"#, degrees(2.0 * (240.0f64 / 500.0).atan()), 640.0 / 480.0),
        (r#""fl_y": 500, "w": 640, "h": 480,"#, degrees(2.0 * (240.0f64 / 500.0).atan()), 640.0 / 480.0),
    ] {
        let files = Files::new(&[("file", transforms(keys, MATRIX).as_bytes())]);
        let lens = files.read("file").unwrap().cameras[0].timed.camera.lens();
        assert!((lens.fov_y_deg - fov_y_deg).abs() < 1e-9 && (lens.aspect - aspect).abs() < 1e-9, "{keys}: {lens:?}");
    }
    let files = Files::new(&[("file", transforms(r#""fl_x": 500,"#, MATRIX).as_bytes())]);
    let settings = ReadSettings { size: Some([640, 480]), ..ReadSettings::default() };
    let camera = &read(&files.0.path().join("file"), settings).unwrap().cameras[0];
    assert_eq!(camera.size, Some([640, 480]));
    assert!((camera.timed.camera.aspect() - 640.0 / 480.0).abs() < 1e-12);
}

#[test]
fn transforms_that_are_not_clear_are_refused() {
    for (keys, matrix, words) in [
        (r#""camera_angle_x": 1.2, "w": 8,"#, MATRIX, "\"h\" is missing"),
        ("", MATRIX, "\"w\" is missing"),
        (r#""w": 8, "h": 4,"#, MATRIX, "\"fl_x\" is missing"),
        (r#""w": 8, "h": 4, "fl_x": 5, "k1": "high","#, MATRIX, "\"k1\" is \"high\", not a number"),
        (r#""w": 8, "h": 4, "fl_x": 5, "camera_model": "EQUIRECTANGULAR","#, MATRIX, "EQUIRECTANGULAR"),
        (r#""w": 8, "h": 4, "fl_x": 0,"#, MATRIX, "frame 0"),
        (r#""w": 8, "h": 4, "fl_x": 5,"#, "[[1, 0, 0], [0, 1, 0], [0, 0, 1]]", "4 rows of 4 numbers"),
        (r#""w": 8, "h": 4, "fl_x": 5,"#, "[[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, -1, 0]]", "reflection"),
        (r#""w": 8, "h": 4, "fl_x": 5,"#, "[[1, 1, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0]]", "shear"),
    ] {
        let said = said_of(&transforms(keys, matrix));
        assert!(said.contains(words), "{keys} {matrix}: {said}");
    }
    assert!(said_of(r#"{ "frames": [] }"#).contains("no cameras"));
}

#[test]
fn poses_are_in_the_order_of_their_pictures() {
    let frame = |name: &str, x: u32| {
        let matrix = format!("[[1, 0, 0, {x}], [0, 1, 0, 0], [0, 0, 1, 0]]");
        format!(r#"{{ "file_path": "{name}", "transform_matrix": {matrix} }}"#)
    };
    let file = |names: [&str; 3]| {
        let frames: Vec<String> = names.iter().zip(0..).map(|(name, x)| frame(name, x)).collect();
        format!(r#"{{ "camera_angle_x": 1, "frames": [{}] }}"#, frames.join(", "))
    };
    let read = |names| Files::new(&[("file", file(names).as_bytes())]).read("file").unwrap();
    let eyes = |found: &FileCameras| found.cameras.iter().map(|of| of.timed.camera.eye().x).collect::<Vec<_>>();
    let found = read(["images/10.png", "images/9.png", "images/2.png"]);
    assert_eq!((eyes(&found), found.notes.len()), (vec![2.0, 1.0, 0.0], 1));
    let found = read(["images/2.png", "images/first.png", "images/1.png"]);
    assert_eq!((eyes(&found), found.notes.len()), (vec![0.0, 1.0, 2.0], 0));
}

const IMAGE: &str = "1 1 0 0 0 0 0 0 3 a b.png\n\n";

#[test]
fn lenses_of_colmap_are_pinholes() {
    let distorted = |model: &str| {
        format!(
            "1 cameras; the lens distortion of the photographs ({model}) was left out: poses and focal lengths are used"
        )
    };
    assert_eq!(said_of_model("# words\n3 OPENCV 8 4 5 5 4 2 0 0 0 0\n", IMAGE), "1 cameras");
    assert_eq!(said_of_model("3 OPENCV 8 4 5 5 4 2 0 0 0.1 0\n", IMAGE), distorted("OPENCV"));
    assert_eq!(said_of_model("3 SIMPLE_RADIAL 8 4 5 4 2 0.1\n", IMAGE), distorted("SIMPLE_RADIAL"));
    let said = said_of_model("3 OPENCV_FISHEYE 8 4 5 5 4 2 0 0 0 0\n", IMAGE);
    assert!(said.starts_with("1 cameras; the fisheye lens"), "{said}");
}

#[test]
fn colmap_models_that_are_not_clear_are_refused() {
    for (cameras, images, words) in [
        ("3 PINHOLE 8 4 5 5 4\n", IMAGE, "3 parameters were found, but PINHOLE has 4"),
        ("3 PINHOLE 8 4 5 5 4 nan\n", IMAGE, "“nan” is not a number"),
        ("3 LENTICULAR 8 4 5 5 4 2\n", IMAGE, "camera model LENTICULAR is not supported"),
        ("4 PINHOLE 8 4 5 5 4 2\n", IMAGE, "no camera 3"),
        ("3 PINHOLE 8 4 5 5 4 2\n", "1 1 0 0 0 0 0 3 a.png\n", "were expected"),
        ("3 PINHOLE 8 4 5 5 4 2\n", "1 0 0 0 0 0 0 0 3 a.png\n", "line 1"),
    ] {
        let said = said_of_model(cameras, images);
        assert!(said.contains(words), "{images} {cameras}: {said}");
    }
    assert!(said(Files::new(&[("a.txt", b"")]).read("")).contains("a COLMAP model was expected"));
}

#[test]
fn images_without_lines_of_points_are_read() {
    let cameras = "1 PINHOLE 640 480 500 500 320 240\n";
    let image = |at: u32| format!("{at} 1 0 0 0 -0.{at} 0 2 1 {at:04}.png\n");
    for points in ["", "\n", "1.5 2 -1 3 4e1 17\n", "# no points\n\n"] {
        let images: String = (1..5).map(|at| image(at) + points).collect();
        assert_eq!(said_of_model(cameras, &images), "4 cameras", "{points}");
    }
}

fn binary_model() -> [Vec<u8>; 2] {
    let mut cameras = 1u64.to_le_bytes().to_vec();
    cameras.extend([7u32.to_le_bytes(), 1u32.to_le_bytes()].concat());
    cameras.extend([640u64, 480].iter().flat_map(|size| size.to_le_bytes()));
    cameras.extend([500f64, 510.0, 320.0, 240.0].iter().flat_map(|number| number.to_le_bytes()));
    let mut images = 2u64.to_le_bytes().to_vec();
    for (at, points) in [(1u32, 3u64), (2, 0)] {
        images.extend(at.to_le_bytes());
        let pose = [1.0, 0.0, 0.0, 0.0, -f64::from(at), 0.0, 2.0];
        images.extend(pose.iter().flat_map(|number: &f64| number.to_le_bytes()));
        images.extend(7u32.to_le_bytes());
        images.extend(format!("a{at}.png\0").bytes());
        images.extend(points.to_le_bytes());
        images.extend(vec![0; 24 * points as usize]);
    }
    [cameras, images]
}

#[test]
fn binary_models_and_projects_are_those_of_text() {
    let [cameras, images] = binary_model();
    let text_cameras = "7 PINHOLE 640 480 500 510 320 240\n";
    let text_images = "1 1 0 0 0 -1 0 2 7 a1.png\n\n2 1 0 0 0 -2 0 2 7 a2.png\n\n";
    let binary = Files::new(&[("sparse/0/cameras.bin", &cameras), ("sparse/0/images.bin", &images)]);
    let text = Files::new(&[("cameras.txt", text_cameras.as_bytes()), ("images.txt", text_images.as_bytes())]);
    let expected = text.read("").unwrap();
    assert_eq!(expected.cameras[1].timed.camera.eye(), DVec3::new(2.0, 0.0, -2.0));
    for name in ["", "sparse/0", "sparse/0/images.bin", "sparse/0/cameras.bin"] {
        assert_eq!(binary.read(name).unwrap(), expected, "{name}");
    }
    for length in 0..images.len() {
        let cut = Files::new(&[("cameras.bin", &cameras), ("images.bin", &images[..length])]);
        let said = said(cut.read(""));
        assert!(said.contains("the file ends within an entry"), "{length}: {said}");
    }
}

#[test]
fn paths_of_programs_for_radiance_fields_are_read() {
    let nerfstudio = r#"{ "camera_type": "perspective", "render_height": 1080, "render_width": 1920, "keyframes": [],
        "camera_path": [{ "camera_to_world": [1,0,0,0.5, 0,1,0,0, 0,0,1,2, 0,0,0,1], "fov": 50, "aspect": 1.5 }] }"#;
    let splatting = r#"[{ "id": 0, "img_name": "0001", "width": 640, "height": 480, "position": [0.5, 0, 2],
        "rotation": [[1,0,0], [0,-1,0], [0,0,-1]], "fy": 500, "fx": 500 }]"#;
    // The camera looks along −Z of the world, which is −Y of the cube.
    let instant_ngp = r#"{ "path": [{ "R": [0.5, 0.5, 0.5, -0.5], "T": [0.5, 1.16, 0.665], "fov": 50, "scale": 1 }] }"#;
    for (text, fov_y_deg, aspect, size) in [
        (nerfstudio, 50.0, 1.5, Some([1920, 1080])),
        (splatting, (2.0 * (240.0f64 / 500.0).atan()).to_degrees(), 640.0 / 480.0, Some([640, 480])),
    ] {
        let found = Files::new(&[("file", text.as_bytes())]).read("file").unwrap();
        let camera = found.cameras[0].timed.camera;
        assert_eq!((found.cameras.len(), found.cameras[0].size), (1, size));
        assert!((camera.eye() - DVec3::new(0.5, 0.0, 2.0)).length() < 1e-12, "{camera:?}");
        assert!((camera.axes()[0] - DVec3::NEG_Z).length() < 1e-12, "{camera:?}");
        assert!((camera.axes()[2] - DVec3::NEG_Y).length() < 1e-12, "{camera:?}");
        assert!((camera.lens().fov_y_deg - fov_y_deg).abs() < 1e-9 && (camera.aspect() - aspect).abs() < 1e-9);
    }
    let found = Files::new(&[("file", instant_ngp.as_bytes())]).read("file").unwrap();
    let camera = found.cameras[0].timed.camera;
    assert!((camera.eye() - DVec3::new(0.5, 0.0, 2.0)).length() < 1e-9, "{camera:?}");
    assert!(found.notes[0].contains("keys of a spline"), "{:?}", found.notes);
    for (text, unused) in [(nerfstudio, "keyframes, seconds"), (splatting, "seconds"), (instant_ngp, "scale, seconds")]
    {
        let text = text.replacen("\"fov\"", "\"seconds\": 2, \"fov\"", 1);
        let text = text.replacen("\"fy\"", "\"seconds\": 2, \"fy\"", 1);
        let said = said_of(&text);
        assert!(said.ends_with(&format!("keys that were not used: {unused}")), "{said}");
    }
    let other = nerfstudio.replace("\"perspective\"", "\"equirectangular\"");
    assert!(said_of(&other).contains("its \"camera_type\" is equirectangular"), "{}", said_of(&other));
}

fn usda(content: &str) -> String {
    said_of(&format!("#usda 1.0\ndef Camera \"a\" {{\n{content}\n}}\n"))
}

#[test]
fn usd_cameras_that_are_not_clear_are_left_out() {
    let place = |op: &str| usda(&format!("{op}\nuniform token[] xformOpOrder = [\"xformOp:translate\"]"));
    assert_eq!(usda(""), "1 cameras");
    assert_eq!(place("double3 xformOp:translate.timeSamples = { 3: (1, 2, 3), 5: (2, 2, 2) }"), "3 cameras");
    for (said, words) in [
        (usda("token projection = \"orthographic\""), "camera a was left out: it is orthographic"),
        (place(""), "has no value"),
        (place("double xformOp:translate = 1"), "three numbers"),
        (place("double3 xformOp:translate.timeSamples = { -3: (1, 2, 3), 5: (2, 2, 2) }"), "from 0 on"),
        (place("double3 xformOp:translate.timeSamples = { 0: (1, 2, 3), 1e9: (2, 2, 2) }"), "more than 100000 frames"),
        (said_of("PXR-USDC binary"), "usdcat"),
        (said_of("PK\x03\x04"), "usdcat"),
        (said_of(&format!("#usda 1.0\n{}", "def \"a\" {\n".repeat(100_000))), "nested more than 64 deep"),
        (
            said_of(&format!("#usda 1.0\n(\n customLayerData = {}", "{ dictionary a = ".repeat(100_000))),
            "nested more than 64",
        ),
        (said_of("#usda 1.0\ndef Xform \"a\" {}"), "no cameras"),
        (said_of("#usda 1.0\ndef Xform \"a\" {"), "the USD file cannot be read"),
    ] {
        assert!(said.contains(words), "{words}: {said}");
    }
}

#[test]
fn usd_cameras_come_through_layers_and_time_codes() {
    let shot = "#usda 1.0\n(\n subLayers = [@./anim.usda@]\n timeCodesPerSecond = 48\n metersPerUnit = 1\n upAxis = \"Y\"\n)\n\
        def Xform \"rig\" (references = @cams/hero.usda@</hero>) {\n double3 xformOp:translate = (0, 1, 0)\n \
        uniform token[] xformOpOrder = [\"xformOp:translate\"]\n}\n\
        def \"gone\" (references = @missing.usda@) {}\ndef \"binary\" (references = @binary.usdc@) {}\n";
    let hero = "#usda 1.0\ndef Xform \"hero\" {\n def Camera \"eye\" {\n float focalLength = 20\n \
        double3 xformOp:translate = (5, 0, 0)\n uniform token[] xformOpOrder = [\"xformOp:translate\"]\n }\n}\n";
    let motion = "#usda 1.0\n(\n timeCodesPerSecond = 48\n)\nover \"rig\" {\n over \"eye\" {\n double3 xformOp:translate.timeSamples = { 0: (0, 0, 0), 8: (8, 0, 0) }\n }\n}\n";
    let files = Files::new(&[
        ("shot.usda", shot.as_bytes()),
        ("anim.usda", motion.as_bytes()),
        ("cams/hero.usda", hero.as_bytes()),
        ("binary.usdc", b"PXR-USDC"),
    ]);
    let found = files.read("shot.usda").unwrap();
    let eyes: Vec<DVec3> = found.cameras.iter().map(|of| of.timed.camera.eye()).collect();
    // 48 time codes are 24 frames.
    let expected: Vec<DVec3> = (0..5).map(|frame| DVec3::new(2.0 * f64::from(frame), 1.0, 0.0)).collect();
    assert_eq!(eyes, expected);
    assert!((found.cameras[0].timed.camera.half()[0] - 20.955 / 2.0 / 20.0).abs() < 1e-12);
    for words in ["missing.usda", "usdcat"] {
        assert!(found.notes.iter().any(|note| note.contains(words)), "{words}: {:?}", found.notes);
    }
    let identity = read(&files.0.path().join("shot.usda"), ReadSettings::default()).unwrap();
    assert_eq!(identity.cameras.len(), 9);
}

#[test]
fn one_camera_of_several_is_chosen_by_name() {
    let camera = |name: &str, content: &str| format!("def Camera \"{name}\" {{\n{content}\n}}\n");
    let moving = "double3 xformOp:translate.timeSamples = { 0: (1, 2, 3), 1: (2, 2, 2) }\n\
        uniform token[] xformOpOrder = [\"xformOp:translate\"]";
    let text = format!(
        "#usda 1.0\n{}{}{}",
        camera("hero", moving),
        camera("lamp", ""),
        camera("plan", "token projection = \"orthographic\"")
    );
    let files = Files::new(&[("file", text.as_bytes())]);
    let mut all = files.read("file").unwrap();
    assert_eq!((all.names(), all.notes.len()), (vec!["hero", "lamp"], 1));
    assert!(!all.share_frames());
    let twice = FileCameras { cameras: [&all.cameras[..], &all.cameras[..]].concat(), notes: Vec::new() };
    assert!(twice.share_frames());
    let mut chosen = all.clone();
    chosen.choose("lamp").unwrap();
    assert_eq!((chosen.names(), chosen.cameras.len()), (vec!["lamp"], 1));
    assert_eq!(chosen.choose("hero").unwrap_err().to_string(), "there is no camera hero, only lamp");
    all.leave_out_still();
    assert_eq!((all.names(), all.cameras.len()), (vec!["hero"], 2));
    assert!(all.notes[1].starts_with("camera lamp was left out: it does not move"), "{:?}", all.notes);
}
