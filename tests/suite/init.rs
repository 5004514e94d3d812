//! `lightfold init`: manifests inferred from folders of images as renderers write them.

use std::path::Path;

use codec::image::{ColorPlane, Eye, Face, ImageProjection, Plane, Primaries, StereoLayout};
use codec::monitor::Silent;
use exr::prelude::{
    AnyChannel, AnyChannels, Blocks, Compression, Encoding, FlatSamples, Image, Layer, LayerAttributes, LineOrder,
    WritableImage,
};
use footage::dataset::manifest::{Background, FaceFiles, FileDepth, Unit};
use footage::dataset::{Manifest, Projection};
use footage::image_files::{ColorSpace, exr as ours, png};
use half::f16;
use scene::{DemoKind, FootagePlan};
use tempfile::TempDir;

use crate::accounts::assert_images_are_named;
use crate::commands::{fine, refused};
use crate::input::assert_says;

/// Runs `init` on the folder `in` and returns its standard error.
fn init(folder: &Path) -> String {
    let output = fine("init in --force", folder);
    assert!(output.stdout.is_empty());
    assert_images_are_named(folder, "");
    String::from_utf8(output.stderr).unwrap()
}

fn manifest(folder: &Path) -> Manifest {
    Manifest::read(&folder.join("lightfield.json")).unwrap()
}

fn encodes(folder: &Path) {
    fine("encode in -o film.lfold --clip --quiet", folder);
    fine("inspect film.lfold --verify", folder);
}

fn gray(width: u32, height: u32, value: impl Fn(u32, u32) -> f32) -> ColorPlane {
    Plane::from_fn(width, height, |x, y| [f16::from_f32(value(x, y)); 3])
}

/// Writes an EXR file of 8x6 pixels with the given attributes and channels of 32-bit floats.
fn write(path: &Path, attributes: LayerAttributes, channels: &[(&str, &dyn Fn(usize) -> f32)]) {
    std::fs::create_dir_all(path.parent().unwrap()).unwrap();
    let samples = |value: &dyn Fn(usize) -> f32| FlatSamples::F32((0..48).map(value).collect());
    let list = channels.iter().map(|(name, value)| AnyChannel::new(*name, samples(*value))).collect();
    let encoding =
        Encoding { compression: Compression::ZIP16, blocks: Blocks::ScanLines, line_order: LineOrder::Increasing };
    let layer = Layer::new((8, 6), attributes, encoding, AnyChannels::sort(list));
    Image::from_layer(layer).write().non_parallel().to_file(path).unwrap();
}

#[test]
fn a_captured_scene_gets_its_manifest_back() {
    let folder = TempDir::new().unwrap();
    let set = folder.path().join("in");
    let before =
        FootagePlan { kind: DemoKind::Courtyard, frames: 2, face_size: 48, probes: 2 }.write(&set, &Silent).unwrap();
    assert_says(&refused("init in", folder.path()), &["lightfield.json", "--force"]);
    assert_eq!(manifest(&set), before);
    let said = init(folder.path());
    let found = manifest(&set);
    assert_eq!(found.files, before.files);
    assert_eq!((found.frames, found.size, found.projection), (before.frames, before.size, before.projection));
    assert_eq!(found.depth.unwrap().kind, before.depth.unwrap().kind);
    let names =
        |of: &[footage::dataset::manifest::Probe]| of.iter().map(|probe| probe.name.clone()).collect::<Vec<_>>();
    assert_eq!(names(&found.probes), names(&before.probes));
    assert_says(&said, &["unsure: no file states its frame rate", "unsure: no file states where 2 of 2 probes stand"]);
    assert_says(&said, &["checked 1 of 2 probes, 12 of 48 images: "]);
    assert!(!said.contains("depth.kind") && !said.contains("seams"), "{said}");
    encodes(folder.path());
}

#[test]
fn the_checks_tell_planar_depth_of_a_cube() {
    let folder = TempDir::new().unwrap();
    let set = folder.path().join("in");
    FootagePlan { kind: DemoKind::Courtyard, frames: 1, face_size: 64, probes: 1 }.write(&set, &Silent).unwrap();
    std::fs::remove_file(set.join("lightfield.json")).unwrap();
    for face in Face::CUBE {
        let path = set.join(format!("probe_00/face_{}/depth.0000.exr", face.name()));
        let distance = ours::read_depth(&path, &Default::default(), &Default::default()).unwrap();
        let projection = ImageProjection::cube_face(face, 64);
        let planar = Plane::from_fn(64, 64, |x, y| distance.get(x, y) / projection.ray_length_factor(x, y) as f32);
        ours::write_depth(&path, &planar).unwrap();
    }
    let said = init(folder.path());
    assert_eq!(manifest(&set).depth.unwrap().kind, FileDepth::Planar, "{said}");
    encodes(folder.path());
}

#[test]
fn faces_by_words_and_other_passes() {
    let folder = TempDir::new().unwrap();
    let set = folder.path().join("in/shot");
    std::fs::create_dir_all(&set).unwrap();
    for face in ["Right", "Left", "Top", "Bottom", "Front", "Back"] {
        for frame in 10..12 {
            let image = gray(8, 8, |x, y| (x + y) as f32 * 0.05 + 0.1);
            ours::write_color(&set.join(format!("{face}_beauty_{frame:03}.exr")), &image).unwrap();
            ours::write_color(&set.join(format!("{face}_albedo_{frame:03}.exr")), &image).unwrap();
        }
    }
    std::fs::write(set.join("slate.png"), b"").unwrap();
    let said = init(folder.path());
    let found = manifest(&folder.path().join("in"));
    assert_eq!(found.files.color.as_deref(), Some("shot/{face}_beauty_%03d.exr"));
    assert_eq!((found.frames, found.projection), ([10, 11], Projection::Cubemap));
    assert_eq!(found.face_names.unwrap()["ny"], "Bottom");
    let words = ["shot/slate.png was left out", "Top_albedo_%03d.exr was left out", "Right = px", "Back = pz"];
    assert_says(&said, &words);
    assert_eq!(said.matches("Top_albedo_%03d.exr").count(), 1, "files that are left out are noted once: {said}");
    encodes(folder.path());
}

#[test]
fn a_houdini_camera_that_moves_by_its_attributes() {
    let folder = TempDir::new().unwrap();
    for frame in 1..4u8 {
        let mut attributes = LayerAttributes { frames_per_second: Some((24000, 1001)), ..LayerAttributes::default() };
        let at = [-f32::from(frame), -1.5, 0.0];
        attributes.world_to_camera =
            Some([1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, at[0], at[1], at[2], 1.0]);
        let z = |at: usize| if at < 8 { 0.0 } else { -1.0 - at as f32 * 0.125 };
        let light = |at: usize| at as f32 / 64.0;
        let channels: [(&str, &dyn Fn(usize) -> f32); 4] =
            [("C.R", &light), ("C.G", &light), ("C.B", &light), ("Pz", &z)];
        write(&folder.path().join(format!("in/shot.{frame:04}.exr")), attributes, &channels);
    }
    let said = init(folder.path());
    let found = manifest(&folder.path().join("in"));
    assert_eq!((found.fps, found.frames, found.size), (24000.0 / 1001.0, [1, 3], [8, 6]));
    assert_eq!(
        (found.files.color.as_deref(), found.files.depth.as_deref()),
        (Some("shot.%04d.exr"), Some("shot.%04d.exr"))
    );
    let depth = found.depth.unwrap();
    assert_eq!((depth.kind, depth.scale, depth.background), (FileDepth::Planar, Some(-1.0), Background::Value(0.0)));
    let places: Vec<_> = found.probes[0].poses.iter().map(|pose| (pose.frame, pose.position)).collect();
    assert_eq!(places, [(1, [1.0, 1.5, 0.0]), (2, [2.0, 1.5, 0.0]), (3, [3.0, 1.5, 0.0])]);
    assert_says(&said, &["negative depth", "background", "fov_y_deg"]);
    assert!(!said.contains("frame rate") && !said.contains("where"), "{said}");
    encodes(folder.path());
}

#[test]
fn panoramas_crosses_and_sensors_by_their_shape() {
    let folder = TempDir::new().unwrap();
    let set = folder.path().join("in");
    for probe in ["a", "b"] {
        std::fs::create_dir_all(set.join(probe)).unwrap();
        for frame in 0..2 {
            ours::write_color(&set.join(format!("{probe}/c{frame}.exr")), &gray(16, 8, |x, _| x as f32 / 16.0))
                .unwrap();
        }
    }
    let said = init(folder.path());
    let found = manifest(&set);
    assert_eq!((found.projection, found.files.color.as_deref()), (Projection::Equirect, Some("{probe}/c%d.exr")));
    assert_says(&said, &["panoramas", "2 of 2 probes"]);
    encodes(folder.path());

    let cross = |x: u32, y: u32| if y / 4 == 1 || x / 4 == 1 { 0.5 + (x + y) as f32 / 64.0 } else { 0.0 };
    for (image, projection, faces) in [
        (gray(16, 12, cross), Projection::Cubemap, Some(FaceFiles::Cross)),
        (gray(16, 12, |x, y| cross(x, y) + (x + y) as f32), Projection::Perspective, None),
        (gray(24, 4, cross), Projection::Cubemap, Some(FaceFiles::Strip)),
    ] {
        std::fs::remove_dir_all(&set).unwrap();
        std::fs::create_dir_all(&set).unwrap();
        ours::write_color(&set.join("x.0001.exr"), &image).unwrap();
        init(folder.path());
        let found = manifest(&set);
        assert_eq!((found.projection, found.faces), (projection, faces));
        encodes(folder.path());
    }

    std::fs::remove_dir_all(&set).unwrap();
    std::fs::create_dir_all(&set).unwrap();
    for frame in 150..152 {
        let depth = Plane::from_fn(8, 6, |x, y| if x == 0 { 0 } else { (1000 + x * 100 + y) as u16 });
        png::write_depth16(&set.join(format!("frame-{frame:06}.depth.png")), &depth).unwrap();
        png::write_color8(&set.join(format!("frame-{frame:06}.color.png")), &Plane::filled(8, 6, [9, 99, 199]))
            .unwrap();
    }
    let said = init(folder.path());
    let found = manifest(&set);
    assert_eq!(found.files.depth.as_deref(), Some("frame-%06d.depth.png"));
    assert_eq!(found.files.color.as_deref(), Some("frame-%06d.color.png"));
    let depth = found.depth.unwrap();
    assert_eq!((depth.unit, depth.background, depth.kind), (Some(Unit::Mm), Background::Value(0.0), FileDepth::Planar));
    assert_says(&said, &["millimetres", "sRGB", "depth 0.0 was assumed"]);
    encodes(folder.path());
}

#[test]
fn two_eyes_in_parts_become_two_probes() {
    let folder = TempDir::new().unwrap();
    let set = folder.path().join("in");
    std::fs::create_dir_all(&set).unwrap();
    for frame in 1..3 {
        let eye = |name: &str| {
            let samples = |at: usize| FlatSamples::F32((0..48).map(|pixel| (pixel + at) as f32 * 0.01 + 0.5).collect());
            let list =
                ["R", "G", "B", "Z"].iter().enumerate().map(|(at, name)| AnyChannel::new(*name, samples(at))).collect();
            let encoding = Encoding {
                compression: Compression::ZIP16,
                blocks: Blocks::ScanLines,
                line_order: LineOrder::Increasing,
            };
            Layer::new((8, 6), LayerAttributes::named(name), encoding, AnyChannels::sort(list))
        };
        let display = exr::prelude::IntegerBounds::from_dimensions((8, 6));
        let image = Image::from_layers(exr::prelude::ImageAttributes::new(display), vec![eye("left"), eye("right")]);
        image.write().non_parallel().to_file(set.join(format!("s_{frame}.exr"))).unwrap();
    }
    assert_says(&init(folder.path()), &["two eyes"]);
    let found = manifest(&set);
    assert_eq!(found.probes.iter().map(|probe| probe.name.as_str()).collect::<Vec<_>>(), ["left", "right"]);
    assert_eq!(found.color.unwrap().layer.as_deref(), Some("{probe}"));
    assert_eq!(found.depth.unwrap().channel.as_deref(), Some("{probe}"));
    encodes(folder.path());
}

#[test]
fn panoramas_of_two_eyes_by_their_halves() {
    let scene = |x: u32, y: u32| ((x % 64) as f32 * 0.3).sin() * 0.2 + ((y % 32) as f32 * 0.2).cos() * 0.3 + 0.5;
    for (size, layout) in [([64, 64], StereoLayout::OverUnder), ([128, 32], StereoLayout::SideBySide)] {
        let folder = TempDir::new().unwrap();
        let set = folder.path().join("in");
        std::fs::create_dir_all(&set).unwrap();
        for frame in 0..2 {
            let image = gray(size[0], size[1], |x, y| scene(x, y) + (y / 32 + x / 64) as f32 * 0.01);
            ours::write_color(&set.join(format!("vr.{frame}.exr")), &image).unwrap();
        }
        let said = init(folder.path());
        assert_says(&said, &["unsure:", "stereo panoramas", "both eyes have the same position"]);
        let found = manifest(&set);
        assert_eq!((found.stereo, found.projection), (Some(layout), Projection::Equirect));
        let eyes: Vec<_> = found.probes.iter().map(|probe| (probe.name.as_str(), probe.eye)).collect();
        assert_eq!(eyes, [("left", Some(Eye::Left)), ("right", Some(Eye::Right))]);
        encodes(folder.path());
    }
    // A square image whose halves differ is not stereo.
    let folder = TempDir::new().unwrap();
    let set = folder.path().join("in");
    std::fs::create_dir_all(&set).unwrap();
    ours::write_color(&set.join("a.0.exr"), &gray(64, 64, |x, y| (x + y * y) as f32 / 4200.0)).unwrap();
    init(folder.path());
    assert_eq!((manifest(&set).stereo, manifest(&set).projection), (None, Projection::Perspective));
}

#[test]
fn the_space_of_colour_by_its_chromaticities() {
    let folder = TempDir::new().unwrap();
    let set = folder.path().join("in");
    std::fs::create_dir_all(&set).unwrap();
    let path = set.join("a.0.exr");
    let image = gray(8, 6, |x, _| x as f32 / 8.0);
    for space in ColorSpace::ALL.into_iter().filter(|space| *space != ColorSpace::Srgb) {
        ours::write_color_of(&path, &image, space.primaries()).unwrap();
        init(folder.path());
        let expected = (space != ColorSpace::LinearRec709).then_some(space);
        assert_eq!(manifest(&set).color.and_then(|color| color.space), expected);
    }
    let odd = Primaries { red: [0.7, 0.3], ..Primaries::REC709 };
    ours::write_color_of(&path, &image, odd).unwrap();
    assert_says(&init(folder.path()), &["unsure: colour has the chromaticities", "0.7", "no named colour space"]);
    assert_eq!(manifest(&set).color, None);
}

#[test]
fn a_lens_by_its_attributes() {
    let folder = TempDir::new().unwrap();
    let attributes = LayerAttributes {
        world_to_camera: Some([1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, -1.0, -2.0, 0.0, 1.0]),
        // The focal length is 10 pixels in an image of 8x6 pixels; the camera looks along -Z.
        world_to_normalized_device: Some([
            2.5,
            0.0,
            0.0,
            0.0,
            0.0,
            10.0 / 3.0,
            0.0,
            0.0,
            0.0,
            0.0,
            -1.0,
            -1.0,
            -2.5,
            -20.0 / 3.0,
            -0.1,
            0.0,
        ]),
        ..LayerAttributes::default()
    };
    let light = |at: usize| at as f32 / 64.0;
    write(&folder.path().join("in/a.0.exr"), attributes, &[("R", &light), ("G", &light), ("B", &light)]);
    let said = init(folder.path());
    let found = &manifest(&folder.path().join("in")).probes[0];
    let intrinsics = found.intrinsics.unwrap();
    assert!(intrinsics.iter().zip([10.0, 10.0, 4.0, 3.0]).all(|(a, b)| (a - b).abs() < 1e-5), "{intrinsics:?}");
    assert_eq!(found.position, Some([1.0, 2.0, 0.0]));
    assert!(!said.contains("lens") && !said.contains("where"), "{said}");
    encodes(folder.path());
}

#[test]
fn cameras_of_a_file_beside_the_images() {
    let folder = TempDir::new().unwrap();
    let set = folder.path().join("in");
    std::fs::create_dir_all(&set).unwrap();
    for frame in 1..4 {
        ours::write_color(&set.join(format!("view.{frame:04}.exr")), &gray(8, 6, |x, _| x as f32 / 8.0)).unwrap();
    }
    let frame = |at: u32| {
        let matrix = [[1, 0, 0, at], [0, 1, 0, 2], [0, 0, 1, 3], [0, 0, 0, 1]];
        serde_json::json!({ "file_path": format!("images/view.{at:04}.png"), "transform_matrix": matrix })
    };
    let write = |frames: &[u32]| {
        let frames: Vec<_> = frames.iter().map(|at| frame(*at)).collect();
        let file = serde_json::json!({ "w": 8, "h": 6, "fl_x": 10, "frames": frames });
        std::fs::write(set.join("transforms.json"), file.to_string()).unwrap();
    };
    // The file may list the frames in any order.
    write(&[3, 1, 2]);
    let said = init(folder.path());
    assert_says(&said, &["unsure: cameras were read from transforms.json"]);
    assert!(!said.contains("no file states the lens") && !said.contains("stands"), "{said}");
    let found = &manifest(&set).probes[0];
    let places: Vec<_> = found.poses.iter().map(|pose| (pose.frame, pose.position)).collect();
    assert_eq!(places, [(1, [1.0, 2.0, 3.0]), (2, [2.0, 2.0, 3.0]), (3, [3.0, 2.0, 3.0])]);
    assert_eq!((found.intrinsics, found.position), (Some([10.0, 10.0, 4.0, 3.0]), None));
    encodes(folder.path());
    write(&[1, 2]);
    assert_says(
        &init(folder.path()),
        &["transforms.json was ignored", "nor are they one for each frame", "the probe stands"],
    );
    std::fs::write(set.join("transforms.json"), "{").unwrap();
    assert_says(&init(folder.path()), &["transforms.json was ignored:"]);
    std::fs::remove_file(set.join("transforms.json")).unwrap();

    // COLMAP files of one static camera, whose image has the name of the probe.
    std::fs::write(set.join("cameras.txt"), "1 PINHOLE 8 6 10 10 4 3\n").unwrap();
    let probe = &manifest(&set).probes[0].name;
    std::fs::write(set.join("images.txt"), format!("1 1 0 0 0 -1 -2 -3 1 {probe}.png\n\n")).unwrap();
    init(folder.path());
    let found = &manifest(&set).probes[0];
    assert_eq!((found.position, found.intrinsics), (Some([1.0, 2.0, 3.0]), Some([10.0, 10.0, 4.0, 3.0])));
    assert!(found.poses.is_empty());
}

#[test]
fn manifests_go_elsewhere_and_bad_folders_are_refused() {
    let folder = TempDir::new().unwrap();
    let set = folder.path().join("in");
    std::fs::create_dir_all(&set).unwrap();
    assert_says(&refused("init in", folder.path()), &["in", "no .exr, .png or .jpg files"]);
    assert_says(&refused("init nowhere", folder.path()), &["nowhere", "there is no such file or folder"]);
    ours::write_color(&set.join("x.1.exr"), &gray(8, 6, |x, _| x as f32)).unwrap();
    let printed = fine("init in -o -", folder.path()).stdout;
    assert_eq!(Manifest::from_json(&printed).unwrap().files.color.as_deref(), Some("x.%d.exr"));
    assert!(!set.join("lightfield.json").exists());
    fine("init in -o a.json", folder.path());
    fine("encode a.json -o film.lfold --clip --quiet", folder.path());
    ours::write_color(&set.join("y.1.exr"), &gray(4, 3, |x, _| x as f32)).unwrap();
    assert_says(&init(folder.path()), &["y.%d.exr was left out: it is 4x3 pixels, others are 8x6"]);
    ours::write_depth(&set.join("z.1.exr"), &Plane::filled(5, 5, 1.0)).unwrap();
    let said = refused("init in --force", folder.path());
    assert_says(&said, &["x.%d.exr is 8x6", "all images of a dataset must have the same size"]);
}
