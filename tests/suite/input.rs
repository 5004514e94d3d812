//! Input of datasets and of single image sequences: values that are read, and input that is refused.

use std::path::{Path, PathBuf};

use codec::image::{ColorPlane, DepthPlane, Face, FrameRange, ImageProjection, Plane};
use footage::dataset::{
    Arrangement, DepthKind, InvalidColor, InvalidDepth, Projection, SequenceLayout, Source, SourceOptions, StreamKind,
};
use footage::image_files::{exr as ours, png};
use glam::DVec3;
use half::f16;
use tempfile::TempDir;

pub(crate) fn ramp(width: u32, height: u32) -> DepthPlane {
    Plane::from_fn(width, height, |x, y| (y * width + x) as f32 + 0.5)
}

pub(crate) fn message<T>(result: lightfold::Result<T>) -> String {
    match result {
        Ok(_) => panic!("this should have been refused"),
        Err(error) => error.to_string(),
    }
}

#[track_caller]
pub(crate) fn assert_says(text: &str, words: &[&str]) {
    for word in words {
        assert!(text.contains(word), "\"{text}\" does not say \"{word}\"");
    }
}

struct Set {
    folder: TempDir,
}

impl Set {
    fn new(manifest: &str) -> Set {
        let set = Set { folder: TempDir::new().unwrap() };
        std::fs::write(set.path("lightfield.json"), manifest).unwrap();
        set
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn open(&self) -> lightfold::Result<Source> {
        Source::open(self.folder.path(), &SourceOptions::default())
    }

    fn depth(&self, options: &SourceOptions) -> lightfold::Result<Vec<DepthPlane>> {
        let source = Source::open(self.folder.path(), options)?;
        let group = source.groups()[0].clone();
        source.read_depth(&group, group.frames.first)
    }
}

/// Returns a manifest of two frames and one probe; `more` is inserted before the key `files`.
fn manifest(projection: &str, size: [u32; 2], more: &str, files: &str, probe: &str) -> String {
    format!(
        r#"{{"lightfield": 1, "name": "t", "fps": 24, "frames": [0, 1], "projection": "{projection}",
            "size": [{}, {}], {more} "files": {{{files}}}, "probes": [{{"name": "a", "position": [1, 2, 3]{probe}}}]}}"#,
        size[0], size[1]
    )
}

fn face_color(direction: DVec3) -> [f16; 3] {
    (direction.normalize() * 0.5 + 0.5).to_array().map(f16::from_f64)
}

fn face_image(face: Face, size: u32) -> ColorPlane {
    Plane::from_fn(size, size, |x, y| face_color(face.direction(x, y, size)))
}

#[test]
fn six_face_files() {
    let files = r#""color": "p_{probe}/{face}.%04d.exr", "depth": "p_{probe}/z_{face}.####.exr""#;
    let set = Set::new(&manifest("cubemap", [4, 4], r#""faces_present": ["nz", "px"],"#, files, ""));
    std::fs::create_dir(set.path("p_a")).unwrap();
    for face in [Face::Px, Face::Nz] {
        for frame in 0..2 {
            ours::write_color(&set.path(&format!("p_a/{}.{frame:04}.exr", face.name())), &face_image(face, 4)).unwrap();
            ours::write_depth(&set.path(&format!("p_a/z_{}.{frame:04}.exr", face.name())), &ramp(4, 4)).unwrap();
        }
    }
    let source = set.open().unwrap();
    let order: Vec<_> = source.groups().iter().map(|group| (group.kind, group.faces.clone())).collect();
    let (px, nz) = (vec![Face::Px], vec![Face::Nz]);
    let expected = [
        (StreamKind::Color, px.clone()),
        (StreamKind::Color, nz.clone()),
        (StreamKind::Depth, px),
        (StreamKind::Depth, nz),
    ];
    assert_eq!(order, expected);
    assert_eq!((source.projection(), source.depth_stored), (Projection::Cubemap, DepthKind::Distance));
    assert_eq!(source.read_color(&source.groups()[1], 1).unwrap(), [face_image(Face::Nz, 4)]);
    assert_eq!(source.read_depth(&source.groups()[2], 0).unwrap(), [ramp(4, 4)]);
    assert!(source.read_depth(&source.groups()[0], 0).is_err(), "a colour group is no depth");
    assert!(source.read_depth(&source.groups()[2], 2).is_err(), "no such frame");

    ours::write_depth(&set.path("p_a/z_nz.0001.exr"), &ramp(4, 3)).unwrap();
    let text = message(source.read_depth(&source.groups()[3], 1));
    assert_says(&text, &["z_nz.0001.exr", "frame 1", "4x3", "4x4"]);
    std::fs::remove_file(set.path("p_a/nz.0001.exr")).unwrap();
    assert_says(&message(set.open()), &["nz.0001.exr", "frame 1", "missing"]);
    let first = SourceOptions { frames: Some(FrameRange { first: 0, last: 0 }), ..SourceOptions::default() };
    assert!(Source::open(&set.path("lightfield.json"), &first).is_ok());
    let none = SourceOptions { frames: Some(FrameRange { first: 7, last: 9 }), ..SourceOptions::default() };
    assert!(Source::open(set.folder.path(), &none).is_err());
}

#[test]
fn crosses_and_strips_hold_the_same_cube() {
    let size = 3;
    let cross =
        [(Face::Px, 2, 1), (Face::Nx, 0, 1), (Face::Py, 1, 0), (Face::Ny, 1, 2), (Face::Pz, 1, 1), (Face::Nz, 3, 1)];
    let strip: Vec<_> = Face::CUBE.into_iter().map(|face| (face, face as u32, 0)).collect();
    for (faces, columns, rows, places) in [("cross", 4, 3, cross.to_vec()), ("strip", 6, 1, strip)] {
        let files = r#""color": "c.%d.exr", "depth": "z.%d.exr""#;
        let more = format!(r#""faces": "opengl-cube-{faces}", "depth": {{"kind": "planar"}},"#);
        let set = Set::new(&manifest("cubemap", [columns * size, rows * size], &more, files, ""));
        let mut image = Plane::filled(columns * size, rows * size, [f16::ZERO; 3]);
        for (face, column, row) in places {
            for (y, x) in (0..size).flat_map(|y| (0..size).map(move |x| (y, x))) {
                image.row_mut(row * size + y)[(column * size + x) as usize] = face_color(face.direction(x, y, size));
            }
        }
        for frame in 0..2 {
            ours::write_color(&set.path(&format!("c.{frame}.exr")), &image).unwrap();
            ours::write_depth(&set.path(&format!("z.{frame}.exr")), &image.map(|_| 2.0)).unwrap();
        }
        let source = set.open().unwrap();
        assert_eq!(source.groups()[0].faces, Face::CUBE);
        let expected: Vec<_> = Face::CUBE.into_iter().map(|face| face_image(face, size)).collect();
        assert_eq!(source.read_color(&source.groups()[0], 0).unwrap(), expected);
        // The faces are planes 2 m away, so the distance at a pixel is twice the length of its direction.
        let depth = source.read_depth(&source.groups()[1], 1).unwrap();
        for (face, plane) in Face::CUBE.into_iter().zip(depth) {
            let exact = Plane::from_fn(size, size, |x, y| (2.0 * face.direction(x, y, size).length()) as f32);
            assert_eq!(plane, exact);
        }
        let arrangement = if faces == "cross" { Arrangement::Cross } else { Arrangement::Strip };
        let layout = SequenceLayout { arrangement, ..SequenceLayout::default() };
        let pattern = set.path("c.@.exr");
        let single =
            Source::from_sequence(StreamKind::Color, pattern.to_str().unwrap(), &layout, &SourceOptions::default())
                .unwrap();
        assert_eq!(single.read_color(&single.groups()[0], 1).unwrap(), expected);
        assert_eq!(single.projection(), Projection::Cubemap);
    }
}

#[test]
fn equirect_images_become_a_cube() {
    let files = r#""color": "c.%d.exr", "depth": "z.%d.exr""#;
    let set = Set::new(&manifest("equirect", [256, 128], "", files, ""));
    // The camera is in a box of 4 x 2 x 6 metres. Colour is the direction, and the distance of the walls is known.
    let distance = |d: DVec3| 1.0 / (d.x.abs() / 2.0).max(d.y.abs()).max(d.z.abs() / 3.0);
    let color = Plane::from_fn(256, 128, |x, y| {
        face_color(ImageProjection::Equirect { size: [256, 128] }.pixel_direction(x, y))
    });
    let depth = Plane::from_fn(256, 128, |x, y| {
        distance(ImageProjection::Equirect { size: [256, 128] }.pixel_direction(x, y)) as f32
    });
    for frame in 0..2 {
        ours::write_color(&set.path(&format!("c.{frame}.exr")), &color).unwrap();
        ours::write_depth(&set.path(&format!("z.{frame}.exr")), &depth).unwrap();
    }
    let source = set.open().unwrap();
    assert_eq!((source.projection(), source.groups()[0].width), (Projection::Cubemap, 96));
    let colors = source.read_color(&source.groups()[0], 0).unwrap();
    let depths = source.read_depth(&source.groups()[1], 0).unwrap();
    for (face, (color, found)) in Face::CUBE.into_iter().zip(colors.iter().zip(&depths)) {
        for (y, x) in (0..96).flat_map(|y| (0..96).map(move |x| (y, x))) {
            let direction = face.direction(x, y, 96).normalize();
            let expected = face_color(direction);
            for (a, b) in color.get(x, y).into_iter().zip(expected) {
                assert!((a.to_f32() - b.to_f32()).abs() < 0.008, "{face:?} {x},{y}");
            }
            let found = found.get(x, y);
            assert!(depth.data().contains(&found), "depth is never blended");
            let relative = (f64::from(found) / distance(direction) - 1.0).abs();
            assert!(relative < 0.06, "{face:?} {x},{y} {relative}");
        }
    }
    let sized = |pixels| {
        let options = SourceOptions { face_size: Some(pixels), ..SourceOptions::default() };
        Source::open(set.folder.path(), &options)
    };
    assert_eq!(sized(5).unwrap().groups()[0].height, 5);
    assert_eq!(sized(128).unwrap().groups()[0].height, 128);
    assert_says(&message(sized(129)), &["lightfield.json", "129", "256", "96"]);
}

#[test]
fn equirect_images_are_twice_as_wide_as_high() {
    let set = Set::new(&manifest("equirect", [256, 100], "", r#""color": "c.%d.exr""#, ""));
    assert_says(&message(set.open()), &["lightfield.json", "256x100", "twice as wide"]);
    let path = set.path("c.0.exr");
    ours::write_color(&path, &Plane::filled(6, 4, [f16::ONE; 3])).unwrap();
    let layout = SequenceLayout { arrangement: Arrangement::Equirect, ..SequenceLayout::default() };
    let lone =
        |options: &SourceOptions| Source::from_sequence(StreamKind::Color, path.to_str().unwrap(), &layout, options);
    assert_says(&message(lone(&SourceOptions::default())), &["c.0.exr", "6x4", "twice as wide"]);
}

#[test]
fn perspective_without_a_lens() {
    let both = r#""depth": "z_{probe}.%d.exr""#;
    let probes = |b: &str, c: &str| {
        format!(r#", "frames": [0, 0]{b}}}, {{"name": "b", "position": [0, 0, 0], "frames": [0, 0]{c}"#)
    };
    let lens = r#", "fov_y_deg": 60"#;
    for (kind, a, b, stored) in [
        ("distance", "", "", Some(DepthKind::Distance)),
        ("distance", lens, "", Some(DepthKind::Distance)),
        ("planar", "", "", Some(DepthKind::Planar)),
        ("planar", lens, lens, Some(DepthKind::Distance)),
        ("planar", lens, "", None),
    ] {
        let depth = format!(r#""depth": {{"kind": "{kind}"}},"#);
        let set = Set::new(&manifest("perspective", [3, 2], &depth, both, &probes(a, b)));
        for name in ["a", "b"] {
            ours::write_depth(&set.path(&format!("z_{name}.0.exr")), &ramp(3, 2)).unwrap();
        }
        let Some(stored) = stored else {
            assert_says(&message(set.open()), &["lightfield.json", "probe \"b\"", "fov_y_deg", "intrinsics"]);
            continue;
        };
        let source = set.open().unwrap();
        assert_eq!(source.depth_stored, stored, "{kind} {a} {b}");
        let converted = kind == "planar" && stored == DepthKind::Distance;
        assert_eq!(source.read_depth(&source.groups()[0], 0).unwrap()[0] != ramp(3, 2), converted);
        let distance = SourceOptions { depth_kind: Some(DepthKind::Distance), ..SourceOptions::default() };
        assert_eq!(set.depth(&distance).unwrap(), [ramp(3, 2)]);
    }
}

#[test]
fn integers_need_a_scale() {
    let files = r#""depth": "z.%d.png""#;
    let codes = Plane::filled(2, 1, 1500u16);
    let with = |depth: &str, depth_scale| {
        let set = Set::new(&manifest("perspective", [2, 1], depth, files, r#", "fov_y_deg": 60"#));
        for frame in 0..2 {
            png::write_depth16(&set.path(&format!("z.{frame}.png")), &codes).unwrap();
        }
        let options = SourceOptions { depth_scale, ..SourceOptions::default() };
        set.depth(&options).map(|planes| planes[0].get(0, 0))
    };
    let words = ["z.0.png", "has integer depth", "`depth_scale`", "0.001 for millimetres", "depth.scale"];
    assert_says(&message(with("", None)), &words);
    assert_says(&message(with(r#""depth": {"kind": "distance"},"#, None)), &words);
    for (depth, scale, metres) in [
        ("", Some(0.01), 15.0),
        ("", Some(1.0), 1500.0),
        (r#""depth": {"unit": "m"},"#, None, 1500.0),
        (r#""depth": {"unit": "mm"},"#, None, 1.5),
        (r#""depth": {"scale": 1},"#, None, 1500.0),
        (r#""depth": {"scale": 0.001},"#, Some(0.1), 150.0),
    ] {
        assert_eq!(with(depth, scale).unwrap(), metres, "{depth} {scale:?}");
    }
}

#[test]
fn perspective_planar_depth() {
    let probe = r#", "intrinsics": [2, 3, 1.5, 1]"#;
    let files = r#""depth": "z.%04d.png""#;
    let depth = r#""depth": {"kind": "planar", "unit": "mm", "background": 0},"#;
    let set = Set::new(&manifest("perspective", [3, 2], depth, files, probe));
    let codes = Plane::from_fn(3, 2, |x, y| if x == 0 { 0 } else { 1000 + y as u16 });
    for frame in 0..2 {
        png::write_depth16(&set.path(&format!("z.{frame:04}.png")), &codes).unwrap();
    }
    let source = set.open().unwrap();
    assert_eq!(source.projection(), Projection::Perspective);
    assert_eq!(source.probes()[0].intrinsics, Some([2.0, 3.0, 1.5, 1.0]));
    let plane = &source.read_depth(&source.groups()[0], 0).unwrap()[0];
    let view = ImageProjection::Pinhole { size: [3, 2], intrinsics: [2.0, 3.0, 1.5, 1.0] };
    for (y, x) in (0..2).flat_map(|y| (0..3).map(move |x| (y, x))) {
        let factor = view.ray_length_factor(x, y);
        let metres = f64::from((f64::from(codes.get(x, y)) * 0.001) as f32);
        let expected = if x == 0 { f32::INFINITY } else { (metres * factor) as f32 };
        assert_eq!(plane.get(x, y), expected, "{x},{y}");
    }
    // Without intrinsics, planar depth is not converted to distance.
    let options = SourceOptions {
        depth_kind: Some(DepthKind::Planar),
        depth_scale: Some(0.001),
        background: Some(0.0),
        ..SourceOptions::default()
    };
    let spec = set.path("z.%04d.png");
    let layout = SequenceLayout::default();
    let lone = Source::from_sequence(StreamKind::Depth, spec.to_str().unwrap(), &layout, &options).unwrap();
    assert_eq!((lone.depth_stored, lone.name()), (DepthKind::Planar, "z"));
    assert_eq!(lone.read_depth(&lone.groups()[0], 1).unwrap()[0].get(1, 0), 1.0);
    assert_eq!(lone.rules.background, 0.0);
}

#[test]
fn depth_that_is_none() {
    let files = r#""depth": "z.%d.exr""#;
    let set = Set::new(&manifest("perspective", [3, 1], "", files, r#", "fov_y_deg": 60"#));
    let write = |value: f32| {
        for frame in 0..2 {
            let plane = Plane::new(3, 1, vec![1.0, f32::INFINITY, value]).unwrap();
            ours::write_depth(&set.path(&format!("z.{frame}.exr")), &plane).unwrap();
        }
    };
    let with = |invalid_depth, background| SourceOptions { invalid_depth, background, ..SourceOptions::default() };
    let read = |options: &SourceOptions| set.depth(options).map(|planes| planes[0].data().to_vec());
    let inf = f32::INFINITY;
    let none = [(f32::NAN, "not a number"), (0.0, "zero"), (-0.0, "zero"), (-3.5, "-3.5"), (f32::NEG_INFINITY, "-inf")];
    for (value, word) in none {
        write(value);
        let text = message(read(&with(InvalidDepth::Refuse, None)));
        assert_says(
            &text,
            &["z.0.exr", "frame 0", "pixel (2, 0)", word, "`invalid_depth` to far or near", "`background`"],
        );
        assert_eq!(read(&with(InvalidDepth::Far, None)).unwrap(), [1.0, inf, inf]);
        assert_eq!(read(&with(InvalidDepth::Near, None)).unwrap(), [1.0, inf, 0.0]);
        if !value.is_nan() {
            assert_eq!(read(&with(InvalidDepth::Refuse, Some(value))).unwrap(), [1.0, inf, inf]);
        }
    }
    for (value, scales) in [(f32::from_bits(1), [1e-30, 1e9]), (9e9, [1e-30, 1.0])] {
        write(value);
        assert_eq!(read(&with(InvalidDepth::Refuse, None)).unwrap(), [1.0, inf, value]);
        // Scaling does not turn a surface into 0 or infinity, and background stays infinite.
        for scale in scales {
            let options = SourceOptions { depth_scale: Some(scale), ..SourceOptions::default() };
            let values = read(&options).unwrap();
            assert!(values[2] > 0.0 && values[2].is_finite() && values[1] == inf);
        }
    }
    let nan = SourceOptions { depth_scale: Some(f64::NAN), ..SourceOptions::default() };
    assert!(read(&nan).is_err() && read(&with(InvalidDepth::Refuse, Some(f32::NAN))).is_err());
}

#[test]
fn colour_that_is_none() {
    let files = r#""color": "c.%d.exr""#;
    let set = Set::new(&manifest("perspective", [2, 2], "", files, r#", "fov_y_deg": 60"#));
    let mut plane = Plane::filled(2, 2, [f16::ONE; 3]);
    plane.data_mut()[2] = [f16::NAN, f16::INFINITY, f16::NEG_INFINITY];
    for frame in 0..2 {
        ours::write_color(&set.path(&format!("c.{frame}.exr")), &plane).unwrap();
    }
    let source = set.open().unwrap();
    let text = message(source.read_color(&source.groups()[0], 1));
    assert_says(&text, &["c.1.exr", "frame 1", "pixel (0, 1)", "not a number"]);
    let black = SourceOptions { invalid_color: InvalidColor::Black, ..SourceOptions::default() };
    let source = Source::open(set.folder.path(), &black).unwrap();
    let read = source.read_color(&source.groups()[0], 1).unwrap();
    assert_eq!(read[0].get(0, 1), [f16::ZERO, f16::MAX, f16::MIN]);
}

#[test]
fn probes_keep_their_own_frames() {
    let text = r#"{"lightfield": 1, "name": "t", "fps": 12.5, "frames": [0, 3], "projection": "perspective", "size": [1, 1],
        "files": {"depth": "{probe}.%d.exr"}, "extra": {"anything": [1]}, "probes": [
        {"name": "a", "position": [0, 0, 0], "fov_y_deg": 90, "frames": [0, 1]},
        {"name": "b", "position": [0, 0, 1], "fov_y_deg": 90, "frames": [2, 9], "extra": 7},
        {"name": "c", "position": [0, 0, 2], "fov_y_deg": 90, "frames": [8, 9]}]}"#;
    let set = Set::new(text);
    for name in ["a.0", "a.1", "b.2", "b.3"] {
        ours::write_depth(&set.path(&format!("{name}.exr")), &ramp(1, 1)).unwrap();
    }
    let source = set.open().unwrap();
    let ranges: Vec<_> = source.groups().iter().map(|group| (group.probe, group.frames.to_string())).collect();
    assert_eq!(ranges, [(0, "0-1".to_string()), (1, "2-3".to_string())]);
    assert_eq!((source.probes().len(), source.fps()), (3, 12.5));
    let again = source.manifest.as_ref().unwrap().to_json().unwrap();
    assert_eq!(&footage::dataset::Manifest::from_json(again.as_bytes()).unwrap(), source.manifest.as_ref().unwrap());
}

#[test]
fn manifests_that_contradict_themselves() {
    let good = r#"{"lightfield": 1, "name": "t", "fps": 24, "frames": [0, 1], "projection": "cubemap", "size": [4, 4],
        "depth": {"kind": "distance", "unit": "m", "background": "inf", "near": 0.5, "far": 9},
        "files": {"depth": "{probe}/{face}.%04d.exr"}, "probes": [{"name": "a", "position": [0, 0, 0]}]}"#;
    let read = |text: &str| footage::dataset::Manifest::from_json(text.as_bytes());
    read(good).unwrap();
    for (from, to, words) in [
        (r#""lightfield": 1"#, r#""lightfield": 2"#, "version"),
        (r#""fps": 24"#, r#""fps": 0"#, "fps"),
        (r#""fps": 24"#, r#""fps": 1e999"#, "number"),
        (r#""fps": 24"#, r#""fps": true"#, "24000/1001"),
        (r#""fps": 24"#, r#""fps": "24/0""#, "24/0"),
        (r#""depth": {"#, r#""stereo": "over-under", "depth": {"#, "square"),
        (r#"[0, 0, 0]}"#, r#"[0, 0, 0], "eye": "left"}"#, "stereo"),
        (r#""name": "t","#, r#""name": "t", "face_names": {"up": "u"},"#, "up"),
        (r#""name": "t","#, r#""name": "t", "face_names": {"px": "nx"},"#, "same name"),
        (r#""name": "t","#, r#""name": "t", "face_names": {"px": "a#"},"#, "a#"),
        (r#""kind": "distance","#, r#""kind": "distance", "scale": 0,"#, "must not be 0"),
        (r#", "position": [0, 0, 0]"#, "", "neither"),
        (r#", "position": [0, 0, 0]"#, r#", "poses": []"#, "neither"),
        (r#""position": [0, 0, 0]"#, r#""poses": [{"frame": 0, "position": [0, 0, 0]}]"#, "lacks frame 1"),
        (
            r#"[0, 0, 0]}"#,
            r#"[0, 0, 0], "poses": [{"frame": 1, "position": [1, 0, 0]}, {"frame": 0, "position": [1, 0, 0]}]}"#,
            "first of its",
        ),
        (
            r#"[0, 0, 0]}"#,
            r#"[0, 0, 0], "orientation": [0, 0, 0, 1], "poses": [{"frame": 1, "position": [1, 0, 0]}]}"#,
            "leave \"orientation\" out",
        ),
        (
            r#""position": [0, 0, 0]"#,
            r#""poses": [{"frame": 1, "position": [1, 0, 0]}, {"frame": 1, "position": [1, 0, 0]}]"#,
            "frame 1 twice",
        ),
        (
            r#""position": [0, 0, 0]"#,
            r#""poses": [{"frame": 0, "position": [1, 0, 0], "orientation": [1, 1, 0, 0]}]"#,
            "frame 0: \"orientation\"",
        ),
        ("[0, 1]", "[3, 1]", "first frame 3"),
        ("[0, 1]", "[-3, 1]", "-3"),
        (r#""size": [4, 4],"#, "", "size"),
        ("[4, 4]", "[4, 0]", "size"),
        ("[4, 4]", "[4, 8]", "square"),
        (r#""name": "t","#, r#""name": "t", "colour": 1,"#, "colour"),
        ("\"kind\"", "\"knd\"", "knd"),
        (r#""inf""#, r#""far""#, "background"),
        (r#""inf""#, "1e300", "background"),
        (r#""near": 0.5"#, r#""near": 10"#, "below"),
        (r#""near": 0.5"#, r#""near": -1"#, "above 0"),
        (r#""unit": "m""#, r#""unit": "ft""#, "ft"),
        (".%04d", "", "%04d"),
        (".%04d", ".%04d.%d", "more than one"),
        ("{face}", "f", "{face}"),
        (r#"{"name": "a", "position": [0, 0, 0]}"#, "", "empty"),
        (r#""name": "a""#, r#""name": "../a""#, "letters"),
        (r#""name": "a""#, r#""name": "..""#, "letters"),
        (r#""name": "a""#, r#""name": "a", "fov_y_deg": 60"#, "perspective"),
        (r#""name": "a""#, r#""name": "a", "orientation": [0, 0, 0, 2]"#, "length 1"),
        (r#""name": "a""#, r#""name": "a", "frames": [5, 4]"#, "first frame 5"),
        (r#"[0, 0, 0]}"#, r#"[0, 0, 0]}, {"name": "a", "position": [0, 0, 0]}"#, "two probes"),
        (r#""projection": "cubemap""#, r#""projection": "perspective""#, "{face}"),
        (r#""projection": "cubemap""#, r#""projection": "fisheye""#, "fisheye"),
        (r#""depth": "{probe}/{face}.%04d.exr""#, "", "files"),
        (r#""name": "t","#, r#""name": "t", "faces_present": ["px", "up"],"#, "up"),
        (r#""name": "t","#, r#""name": "t", "faces_present": [],"#, "at least one"),
        ("}]}", "}]", "this is not JSON"),
    ] {
        let text = good.replacen(from, to, 1);
        assert_ne!(text, good, "{from}");
        assert_says(&message(read(&text)), &[words]);
    }
    let folder = TempDir::new().unwrap();
    assert_says(&message(Source::open(folder.path(), &SourceOptions::default())), &["lightfield.json"]);
}

#[test]
fn single_sequences() {
    let folder = TempDir::new().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_string();
    for frame in [4, 5, 7] {
        ours::write_depth(Path::new(&at(&format!("depth.{frame:04}.exr"))), &ramp(4, 4)).unwrap();
    }
    let open = |spec: &str, arrangement, options: &SourceOptions| {
        let layout = SequenceLayout { arrangement, probe: "p".into(), intrinsics: None };
        Source::from_sequence(StreamKind::Depth, spec, &layout, options)
    };
    let options = SourceOptions::default();
    let face = Arrangement::Single(Face::Ny);
    assert_says(&message(open(&at("depth.%04d.exr"), face, &options)), &["depth.0006.exr", "frame 6"]);
    assert_says(&message(open(&at(""), face, &options)), &["depth.0006.exr"]);
    let some = SourceOptions { frames: Some(FrameRange { first: 4, last: 5 }), ..SourceOptions::default() };
    let source = open(&at("depth.####.exr"), face, &some).unwrap();
    assert_eq!(
        (source.name(), source.projection(), source.probes()[0].name.as_str()),
        ("depth", Projection::Cubemap, "p")
    );
    assert_eq!(source.read_depth(&source.groups()[0], 5).unwrap(), [ramp(4, 4)]);
    let single = open(&at("depth.0007.exr"), Arrangement::Single(Face::View), &options).unwrap();
    assert_eq!(single.groups()[0].frames, FrameRange { first: 7, last: 7 });
    assert_says(&message(open(&at("depth.0007.exr"), Arrangement::Cross, &options)), &["depth.0007.exr", "4:3"]);
    assert_says(&message(open(&at("depth.0007.exr"), Arrangement::Equirect, &options)), &["depth.0007.exr", "4x4"]);
    ours::write_depth(Path::new(&at("wide.0.exr")), &ramp(4, 2)).unwrap();
    assert!(open(&at("wide.0.exr"), Arrangement::Equirect, &options).is_ok());
    assert!(open(&at("nothing.%04d.exr"), face, &options).is_err());
    let planar = SourceOptions { depth_kind: Some(DepthKind::Planar), ..SourceOptions::default() };
    assert!(open(&at("depth.0007.exr"), Arrangement::Equirect, &planar).is_err());
    let source = open(&at("depth.0007.exr"), face, &planar).unwrap();
    let exact = Plane::from_fn(4, 4, |x, y| {
        (f64::from(ramp(4, 4).get(x, y)) * ImageProjection::cube_face(Face::Px, 4).ray_length_factor(x, y)) as f32
    });
    assert_eq!(
        (source.read_depth(&source.groups()[0], 7).unwrap(), source.depth_stored),
        (vec![exact], DepthKind::Distance)
    );
}
