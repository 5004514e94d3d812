//! Kinds of footage that `lightfold init` recognises by names and content: depth in colour channels, disparity, JPEG, cameras of a
//! cube, stills, views, times.

use std::path::Path;

use codec::image::{DepthKind, Face, FrameRange, Plane, Projection, StreamKind};
use codec::monitor::Silent;
use exr::prelude::{Image, SpecificChannels, WritableImage};
use footage::dataset::manifest::{FaceFiles, FileDepth, Keep, Manifest};
use footage::dataset::source::{Arrangement, SequenceLayout};
use footage::dataset::{Source, SourceOptions};
use footage::image_files::{exr as ours, png};
use half::f16;
use image::{ImageBuffer, Rgb};
use scene::{DemoKind, FootagePlan};
use tempfile::TempDir;

use crate::accounts::assert_images_are_named;
use crate::commands::{fine, refused};
use crate::input::assert_says;

struct Set(TempDir);

impl Set {
    fn new() -> Set {
        let set = Set(TempDir::new().unwrap());
        std::fs::create_dir_all(set.folder()).unwrap();
        set
    }

    fn folder(&self) -> std::path::PathBuf {
        self.0.path().join("in")
    }

    fn file(&self, name: &str) -> std::path::PathBuf {
        let path = self.folder().join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        path
    }

    /// Runs `init` with options, and returns its standard error and the manifest.
    fn init(&self, options: &str) -> (String, Manifest) {
        let output = fine(&format!("init in --force {options}"), self.0.path());
        assert_images_are_named(self.0.path(), options);
        (String::from_utf8(output.stderr).unwrap(), Manifest::read(&self.folder()).unwrap())
    }

    fn refused(&self) -> String {
        refused("init in --force", self.0.path())
    }

    fn encodes(&self) {
        fine("encode in -o film.lfold --quiet", self.0.path());
        fine("inspect film.lfold --verify", self.0.path());
    }

    fn source(&self) -> Source {
        Source::open(&self.folder(), &SourceOptions::default()).unwrap()
    }

    fn depth(&self) -> Plane<f32> {
        let source = self.source();
        let group = source.groups().iter().find(|group| group.kind == StreamKind::Depth).unwrap();
        source.read_depth(group, group.frames.first).unwrap().remove(0)
    }
}

fn color(path: &Path, value: f32) {
    ours::write_color(path, &Plane::from_fn(8, 6, |x, y| [f16::from_f32(value * (x + y) as f32 / 12.0); 3])).unwrap();
}

fn rgb(path: &Path, values: impl Fn(usize, usize) -> (f32, f32, f32) + Sync) {
    let channels = SpecificChannels::rgb(|at: exr::math::Vec2<usize>| values(at.x(), at.y()));
    Image::from_channels((8, 6), channels).write().non_parallel().to_file(path).unwrap();
}

fn depth_png(path: &Path) {
    png::write_depth16(path, &Plane::from_fn(8, 6, |x, y| (1000 + 100 * x + y) as u16)).unwrap();
}

#[test]
fn depth_in_three_equal_channels_is_depth() {
    let set = Set::new();
    rgb(&set.file("Depth0001.exr"), |x, _| (1.0 + x as f32, 1.0 + x as f32, 1.0 + x as f32));
    color(&set.file("Image0001.exr"), 0.5);
    let (_, found) = set.init("");
    assert_eq!(
        (found.files.depth.as_deref(), found.files.color.as_deref(), found.probes.len()),
        (Some("Depth%04d.exr"), Some("Image%04d.exr"), 1)
    );
    assert_eq!(found.depth.unwrap().channel.as_deref(), Some("R"));
    assert_eq!(set.depth().row(0)[..3], [1.0, 2.0, 3.0]);
    set.encodes();

    let set = Set::new();
    let gray = |x: u32, y: u32| Rgb([(1000 + x * 50 + y) as u16; 3]);
    ImageBuffer::from_fn(8, 6, gray).save(set.file("cam_depth.0001.png")).unwrap();
    color(&set.file("cam_rgb.0001.exr"), 0.5);
    let (_, found) = set.init("");
    assert_eq!(found.files.depth.as_deref(), Some("cam_depth.%04d.png"));
    assert_eq!(set.depth().row(1)[..2], [1.001, 1.051]);

    // Gray beside Z is colour, a Z alone is depth.
    let set = Set::new();
    let channels = exr::prelude::AnyChannels::sort(
        ["Y", "Z"]
            .map(|name| {
                let samples = exr::prelude::FlatSamples::F32((0..48).map(|at| 0.5 + at as f32 / 100.0).collect());
                exr::prelude::AnyChannel::new(name, samples)
            })
            .into_iter()
            .collect(),
    );
    Image::from_channels((8, 6), channels).write().non_parallel().to_file(set.file("a.1.exr")).unwrap();
    let (_, found) = set.init("");
    assert_eq!((found.files.color.as_deref(), found.files.depth.as_deref()), (Some("a.%d.exr"), Some("a.%d.exr")));
}

#[test]
fn depth_in_false_colours_or_jpeg_is_left_out() {
    let set = Set::new();
    color(&set.file("rgb.0001.exr"), 0.5);
    rgb(&set.file("depth.0001.exr"), |x, y| (x as f32, y as f32, 0.5));
    let picture = ImageBuffer::from_fn(8, 6, |x, y| Rgb([x as u8 * 30, y as u8 * 40, 9u8]));
    picture.save(set.file("z.0001.png")).unwrap();
    picture.save(set.file("distance.0001.jpg")).unwrap();
    let (said, found) = set.init("");
    assert_says(&said, &["z.%04d.png was left out", "distance.%04d.jpg was left out", "depth.%04d.exr was left out"]);
    assert_eq!(found.files.depth, None);
}

#[test]
fn disparity_by_scale_and_by_range() {
    let manifest = |depth: &str, file: &str| {
        format!(
            r#"{{"lightfield": 1, "name": "d", "fps": 24, "frames": [0, 0], "projection": "perspective", "size": [8, 6],
            "depth": {depth}, "files": {{"depth": "{file}"}}, "probes": [{{"name": "a", "position": [0, 0, 0]}}]}}"#
        )
    };
    let set = Set::new();
    let write = |depth: &str, file: &str| std::fs::write(set.file("lightfield.json"), manifest(depth, file)).unwrap();
    png::write_depth16(&set.file("d.0.png"), &Plane::from_fn(8, 6, |x, _| (x * 9362) as u16)).unwrap();
    write(r#"{"kind": "disparity", "near": 0.5, "far": 10}"#, "d.%d.png");
    let read = set.depth();
    assert!((read.get(0, 0) - 10.0).abs() < 1e-5 && (read.get(7, 0) - 0.5).abs() < 1e-4, "{read:?}");
    assert_eq!(set.source().depth_in_files, DepthKind::Planar);
    set.encodes();
    // Near and far define the values; along rays, surfaces are farther than far.
    let lens = manifest(r#"{"kind": "disparity", "near": 0.5, "far": 10}"#, "d.%d.png");
    let lens = lens.replace("\"position\"", "\"fov_y_deg\": 60, \"position\"");
    std::fs::write(set.file("lightfield.json"), lens).unwrap();
    assert!(set.depth().get(0, 0) > 10.5);
    set.encodes();
    // In pixels, from stereo: 60 pixel metres. 0 is no match.
    ours::write_depth(&set.file("d.0.exr"), &Plane::from_fn(8, 6, |x, _| 10.0 * x as f32)).unwrap();
    write(r#"{"kind": "disparity", "scale": 60}"#, "d.%d.exr");
    assert_eq!(set.depth().row(0)[..4], [f32::INFINITY, 6.0, 3.0, 2.0]);
    set.encodes();
    for (wrong, says) in [
        (r#"{"kind": "disparity"}"#, "needs a \"scale\""),
        (r#"{"kind": "disparity", "near": 1}"#, "needs a \"scale\""),
        (r#"{"kind": "disparity", "scale": 60, "unit": "m"}"#, "no \"unit\""),
    ] {
        let read = Manifest::from_json(manifest(wrong, "d.%d.exr").as_bytes());
        assert_says(&read.unwrap_err().to_string(), &[says]);
    }

    let set = Set::new();
    depth_png(&set.file("disparity/0001.png"));
    color(&set.file("color/0001.exr"), 0.5);
    let (said, found) = set.init("");
    assert_eq!(found.depth.unwrap().kind, FileDepth::Disparity);
    assert_says(&said, &["was taken for disparity", "\"scale\""]);
    set.encodes();
}

#[test]
fn pixels_that_are_not_square() {
    let set = Set::new();
    let channels = SpecificChannels::rgb(|_: exr::math::Vec2<usize>| (0.5f32, 0.5f32, 0.5f32));
    let mut image = Image::from_channels((8, 6), channels);
    image.attributes.pixel_aspect = 2.0;
    image.write().non_parallel().to_file(set.file("a.0.exr")).unwrap();
    let manifest = |projection: &str, size: &str, lens: &str| {
        let text = format!(
            r#"{{"lightfield": 1, "name": "d", "fps": 24, "frames": [0, 0], "projection": "{projection}", "size": {size},
            "faces_present": null, "files": {{"color": "a.%d.exr"}}, "probes": [{{"name": "a", "position": [0, 0, 0]{lens}}}]}}"#
        );
        std::fs::write(set.file("lightfield.json"), text.replace("\"faces_present\": null,", "")).unwrap();
        Source::open(&set.folder(), &SourceOptions::default())
    };
    let lens = manifest("perspective", "[8, 6]", r#", "fov_y_deg": 90"#).unwrap().probes()[0].intrinsics.unwrap();
    assert!((lens[0] - 1.5).abs() < 1e-12 && (lens[1] - 3.0).abs() < 1e-12, "{lens:?}");
    let stated = r#", "intrinsics": [5, 5, 4, 3]"#;
    assert_eq!(manifest("perspective", "[8, 6]", stated).unwrap().probes()[0].intrinsics, Some([5.0, 5.0, 4.0, 3.0]));
    let said = manifest("equirect", "[12, 6]", "").unwrap_err().to_string();
    assert_says(&said, &["a.0.exr", "pixelAspectRatio is 2", "square"]);
}

#[test]
fn jpeg_colour_beside_png_depth() {
    let set = Set::new();
    for frame in 0..2 {
        let picture = ImageBuffer::from_fn(8, 6, |x, y| Rgb([x as u8 * 30, 99, y as u8 * 40]));
        picture.save(set.file(&format!("color/{frame:06}.jpg"))).unwrap();
        depth_png(&set.file(&format!("depth/{frame:06}.png")));
    }
    let (said, found) = set.init("");
    assert_eq!(
        (found.files.color.as_deref(), found.files.depth.as_deref(), found.frames),
        (Some("color/%06d.jpg"), Some("depth/%06d.png"), [0, 1])
    );
    assert_says(&said, &["PNG and JPEG", "millimetres"]);
    set.encodes();
    std::fs::write(set.file("color/000001.jpg"), b"\xff\xd8\xff\xe0 no picture").unwrap();
    let said = refused("encode in -o film.lfold", set.0.path());
    assert_says(&said, &["000001.jpg", "damaged"]);
}

#[test]
fn marks_in_file_names() {
    for name in ["take#1@2_", "100%_", "a{b}.", "x$F.", "<frame>-", "<f4>@", "{F4}#."] {
        let set = Set::new();
        for frame in 1..3 {
            color(&set.file(&format!("{name}{frame:04}.exr")), 0.5);
        }
        let (_, found) = set.init("");
        assert_eq!(found.files.color, Some(format!("{}%04d.exr", name.replace('%', "%%"))));
        assert_eq!(found.frames, [1, 2], "{name}");
        set.encodes();
    }
    let set = Set::new();
    color(&set.file("a{probe}.0001.exr"), 0.5);
    assert_says(&set.refused(), &["a{probe}.%04d.exr was left out", "cannot be written as a pattern"]);
}

/// Writes a PNG file of depth whose code is `code` in all pixels.
fn flat_depth(path: &Path, code: u16) {
    png::write_depth16(path, &Plane::filled(8, 6, code)).unwrap();
}

#[test]
fn files_named_by_times_are_paired() {
    let set = Set::new();
    let rgb = ["1305031102.175304", "1305031102.211214", "1305031102.243211"];
    let depth = ["1305031102.160407", "1305031102.194330", "1305031102.262886", "1305031102.295279"];
    for (at, name) in (1..).zip(rgb) {
        let plane = Plane::filled(8, 6, [40 * at; 3]);
        png::write_color8(&set.file(&format!("rgb/{name}.png")), &plane).unwrap();
    }
    for (at, name) in (1..).zip(depth) {
        flat_depth(&set.file(&format!("depth/{name}.png")), 5000 * at);
    }
    let (said, found) = set.init("");
    assert_says(&said, &["depth/{time}.png was paired with rgb/{time}.png by the nearest time, at most 20 ms apart"]);
    assert_eq!((found.frames, found.fps), ([0, 2], 29.452));
    assert_eq!(found.depth.as_ref().unwrap().unit, Some(footage::dataset::manifest::Unit::Mm));
    let source = set.source();
    let group = source.groups().iter().find(|group| group.kind == StreamKind::Depth).unwrap();
    // 211214 is nearer to 194330 than to 262886, 243211 to 262886.
    let metres: Vec<f32> = (0..3).map(|frame| source.read_depth(group, frame).unwrap()[0].get(0, 0)).collect();
    assert_eq!(metres, [5.0, 10.0, 15.0]);
    set.encodes();
    // Both lists are those of TUM RGB-D, with 5000 units per metre.
    ["rgb.txt", "depth.txt"].iter().for_each(|name| std::fs::write(set.file(name), "# a\n").unwrap());
    assert_says(&set.init("").0, &["5000 units per metre"]);
    assert_eq!(set.depth().get(0, 0), 1.0);
    // A frame that no file has.
    let mut longer = Manifest::read(&set.folder()).unwrap();
    longer.frames = [0, 3];
    std::fs::write(set.folder().join("lightfield.json"), longer.to_json().unwrap()).unwrap();
    assert_says(&refused("encode in -o film.lfold", set.0.path()), &["frames 0-3", "3 files"]);
}

#[test]
fn times_are_no_frame_numbers() {
    let set = Set::new();
    ["1403636579763555584", "1403636579813555456", "1403636579863555584"]
        .iter()
        .for_each(|name| depth_png(&set.file(&format!("data/{name}.png"))));
    let (_, found) = set.init("");
    assert_eq!((found.files.depth.as_deref(), found.fps), (Some("data/{time}.png"), 20.0));
    set.encodes();
    let set = Set::new();
    ["shot_1700.25.png", "shot_1700.50.png"].iter().for_each(|name| depth_png(&set.file(name)));
    assert_eq!(set.init("").1.frames, [25, 50]);
    // A stray picture costs itself alone.
    let set = Set::new();
    color(&set.file("a.1.exr"), 0.5);
    depth_png(&set.file("Screenshot_20240501123456.png"));
    let (said, found) = set.init("");
    assert_says(&said, &["Screenshot_20240501123456.png was left out: the name is a time"]);
    assert_eq!(found.files.color.as_deref(), Some("a.%d.exr"));
    // Faults of patterns with times.
    for (pattern, says) in [
        ("a{time}_%d.png", "both {time} and a place"),
        ("{time}/a.png", "once, in the file name"),
        ("{time}_{time}.png", "once, in the file name"),
    ] {
        let mut wrong = found.clone();
        wrong.files.color = Some(pattern.into());
        assert_says(&wrong.validate().unwrap_err().to_string(), &[says]);
    }
}

#[test]
fn depth_of_another_size_is_resampled() {
    let set = Set::new();
    for frame in 0..2 {
        color(&set.file(&format!("color_{frame:05}.exr")), 0.5);
        let small = Plane::from_fn(4, 3, |x, y| (1000 + 100 * x + y) as u16);
        png::write_depth16(&set.file(&format!("depth_{frame:05}.png")), &small).unwrap();
    }
    let (said, found) = set.init("");
    assert_says(&said, &["depth_%05d.png is 4x3 pixels, others are 8x6", "nearest neighbour"]);
    assert_eq!((found.size, found.depth.as_ref().unwrap().size), ([8, 6], Some([4, 3])));
    let depth = set.depth();
    assert_eq!([(0, 0), (1, 1), (2, 1), (7, 5)].map(|(x, y)| depth.get(x, y)), [1.0, 1.0, 1.1, 1.302]);
    set.encodes();
    // Depth larger than colour.
    let set = Set::new();
    depth_png(&set.file("depth_0.png"));
    png::write_color8(&set.file("color_0.png"), &Plane::filled(4, 3, [9; 3])).unwrap();
    assert_eq!(set.init("").1.size, [4, 3]);
    set.encodes();
    // Another shape is another picture.
    let set = Set::new();
    depth_png(&set.file("depth_0.png"));
    png::write_color8(&set.file("color_0.png"), &Plane::filled(6, 6, [9; 3])).unwrap();
    assert_says(&set.refused(), &["8x6", "6x6", "the same size"]);
    // The files must have the size that the manifest states.
    let set = Set::new();
    color(&set.file("color_0.exr"), 0.5);
    png::write_depth16(&set.file("depth_0.png"), &Plane::filled(4, 3, 1000)).unwrap();
    let (_, mut found) = set.init("");
    found.depth.as_mut().unwrap().size = Some([2, 3]);
    std::fs::write(set.folder().join("lightfield.json"), found.to_json().unwrap()).unwrap();
    assert_says(&refused("encode in -o film.lfold", set.0.path()), &["depth_0.png", "4x3 pixels, expected 2x3"]);
}

#[test]
fn stills_and_views_of_one_moment() {
    let set = Set::new();
    color(&set.file("beauty.exr"), 0.5);
    ours::write_depth(&set.file("depth.exr"), &Plane::filled(8, 6, 2.0)).unwrap();
    let (said, found) = set.init("");
    assert_says(&said, &["a still of one frame"]);
    assert_eq!(
        (found.files.color.as_deref(), found.files.depth.as_deref(), found.frames),
        (Some("beauty.exr"), Some("depth.exr"), [0, 0])
    );
    set.encodes();

    let set = Set::new();
    (1..4).for_each(|view| color(&set.file(&format!("images/frame_{view:05}.exr")), 0.5));
    let (_, found) = set.init("");
    assert_eq!((found.frames, found.probes.len()), ([1, 3], 1));
    let (_, found) = set.init("--views");
    let names: Vec<&str> = found.probes.iter().map(|probe| probe.name.as_str()).collect();
    assert_eq!((found.frames, &names[..]), ([0, 0], &["00001", "00002", "00003"][..]));
    assert_eq!(found.files.color.as_deref(), Some("images/frame_{probe}.exr"));
    set.encodes();
}

#[test]
fn previews_of_another_size_are_left_out() {
    let set = Set::new();
    color(&set.file("beauty.0001.exr"), 0.5);
    ours::write_depth(&set.file("depth.0001.exr"), &Plane::filled(8, 6, 2.0)).unwrap();
    ImageBuffer::from_pixel(4, 3, Rgb([9u8; 3])).save(set.file("preview.0001.png")).unwrap();
    ImageBuffer::from_pixel(4, 3, Rgb([9u8; 3])).save(set.file("preview2.0001.jpg")).unwrap();
    let (said, found) = set.init("");
    assert_says(&said, &["preview.%04d.png was left out: it is 4x3 pixels, others are 8x6", "preview2.%04d.jpg"]);
    assert_eq!(found.files.color.as_deref(), Some("beauty.%04d.exr"));
    set.encodes();
}

#[test]
fn bright_colour_is_kept_as_the_manifest_says() {
    let set = Set::new();
    (0..2).for_each(|frame| color(&set.file(&format!("a.{frame}.exr")), 7.0));
    let (_, found) = set.init("");
    assert_eq!(found.color.unwrap().keep, Some(Keep::Hdr));
    let is_hdr = || {
        set.encodes();
        let report = fine("inspect film.lfold --json", set.0.path()).stdout;
        String::from_utf8(report).unwrap().contains("transform-half")
    };
    assert!(is_hdr());
    let text = std::fs::read_to_string(set.file("lightfield.json")).unwrap();
    std::fs::write(set.file("lightfield.json"), text.replace("\"hdr\"", "\"clip\"")).unwrap();
    assert!(!is_hdr());
    // Options override the manifest.
    fine("encode in -o film.lfold --hdr --quiet", set.0.path());
    std::fs::write(set.file("lightfield.json"), &text).unwrap();
    fine("encode in -o clipped.lfold --clip --quiet", set.0.path());
    let bytes = |name: &str| std::fs::read(set.0.path().join(name)).unwrap();
    assert_ne!(bytes("film.lfold"), bytes("clipped.lfold"));
    let set = Set::new();
    color(&set.file("a.0.exr"), 1.0);
    assert_eq!(set.init("").1.color.and_then(|color| color.keep), None);
}

/// Pictures that six cameras take: what is to the right of a camera is to the right in its picture.
#[test]
fn pictures_of_six_cameras_become_faces() {
    let folder = TempDir::new().unwrap();
    let faces = folder.path().join("faces");
    FootagePlan { kind: DemoKind::Interior, frames: 1, face_size: 32, probes: 1 }.write(&faces, &Silent).unwrap();
    let set = Set::new();
    let cameras =
        [("right", Face::Px), ("left", Face::Nx), ("top", Face::Py), ("bottom", Face::Ny), ("back", Face::Pz)];
    for (name, face) in cameras.into_iter().chain([("front", Face::Nz)]) {
        let own = |kind: &str| faces.join(format!("probe_00/face_{}/{kind}.0000.exr", face.name()));
        let light = ours::read_color(&own("color"), &Default::default(), &Default::default()).unwrap();
        let depth = ours::read_depth(&own("depth"), &Default::default(), &Default::default()).unwrap();
        // The axes of each camera, from the front one by turns.
        let [forward, right, down] = face.axes();
        let seen_right = if matches!(face, Face::Py | Face::Ny) { right } else { -right };
        let seen_down = if matches!(face, Face::Py | Face::Ny) { -down } else { down };
        assert_eq!(seen_right.cross(seen_down), forward, "{name} is not mirrored");
        let at = |x: u32, y: u32| if seen_right == right { (x, 31 - y) } else { (31 - x, y) };
        let turned = |x: u32, y: u32| at(x, y);
        ours::write_color(
            &set.file(&format!("{name}/color.0000.exr")),
            &Plane::from_fn(32, 32, |x, y| light.get(turned(x, y).0, turned(x, y).1)),
        )
        .unwrap();
        ours::write_depth(
            &set.file(&format!("{name}/depth.0000.exr")),
            &Plane::from_fn(32, 32, |x, y| depth.get(turned(x, y).0, turned(x, y).1)),
        )
        .unwrap();
    }
    let (said, found) = set.init("");
    assert_eq!((found.faces, found.projection), (Some(FaceFiles::Cameras), Projection::Cubemap));
    assert_eq!(found.face_names.as_ref().unwrap()["nz"], "front");
    assert_says(&said, &["pictures of six cameras"]);
    let (read, expected) = (set.source(), Source::open(&faces, &SourceOptions::default()).unwrap());
    for kind in [StreamKind::Color, StreamKind::Depth] {
        for face in Face::CUBE {
            let group = |source: &Source| {
                let is = |group: &&_| {
                    let group: &footage::dataset::SourceGroup = group;
                    group.kind == kind && group.faces == [face]
                };
                source.groups().iter().find(is).unwrap().clone()
            };
            if kind == StreamKind::Color {
                let of = |source: &Source| source.read_color(&group(source), 0).unwrap();
                assert_eq!(of(&read), of(&expected), "{face:?}");
            } else {
                let of = |source: &Source| source.read_depth(&group(source), 0).unwrap();
                assert_eq!(of(&read), of(&expected), "{face:?}");
            }
        }
    }
    set.encodes();
}

#[test]
fn panoramas_keep_their_resolution() {
    let set = Set::new();
    ours::write_color(&set.file("pano.0.exr"), &Plane::filled(1024, 512, [f16::ONE; 3])).unwrap();
    let layout = SequenceLayout { arrangement: Arrangement::Equirect, ..SequenceLayout::default() };
    let spec = set.file("pano.%d.exr").display().to_string();
    let open = |face_size: Option<u32>| {
        let options = SourceOptions { face_size, ..SourceOptions::default() };
        Source::from_sequence(StreamKind::Color, &spec, &layout, &options).unwrap().groups()[0].clone()
    };
    // 1024 / pi = 325.9
    assert_eq!((open(None).width, open(Some(200)).width), (352, 200));
    assert_eq!(open(None).frames, FrameRange { first: 0, last: 0 });
}

#[test]
fn depth_channels_of_distance() {
    for (name, kind) in [
        ("dd.T", FileDepth::Distance),
        ("dist.Y", FileDepth::Distance),
        ("cam.depth.T", FileDepth::Distance),
        ("Z", FileDepth::Planar),
    ] {
        let set = Set::new();
        let constant = |name: &str| exr::prelude::AnyChannel::new(name, exr::prelude::FlatSamples::F32(vec![0.5; 48]));
        let channels = ["R", "G", "B", name].into_iter().map(constant).collect();
        let image = Image::from_channels((8, 6), exr::prelude::AnyChannels::sort(channels));
        image.write().non_parallel().to_file(set.file("a.1.exr")).unwrap();
        let (_, found) = set.init("");
        assert_eq!(found.depth.map(|depth| depth.kind), Some(kind), "{name}");
    }
}

#[test]
fn pictures_are_compared_without_their_kind() {
    let set = Set::new();
    color(&set.file("a.exr"), 0.5);
    color(&set.file("b.exr"), 0.5);
    ImageBuffer::from_pixel(8, 6, Rgb([9u8; 3])).save(set.file("c.png")).unwrap();
    depth_png(&set.file("gray.png"));
    ours::write_depth(&set.file("z.exr"), &Plane::filled(8, 6, 2.0)).unwrap();
    for pair in ["a.exr b.exr", "c.png c.png", "z.exr z.exr"] {
        let [a, b] = pair.split_once(' ').map(<[&str; 2]>::from).unwrap();
        fine(&format!("diff in/{a} in/{b}"), set.0.path());
    }
    assert_says(&refused("diff in/gray.png in/gray.png", set.0.path()), &["the kind of images is unknown", "--stream"]);
}

#[test]
fn passes_that_are_no_lengths_are_left_out() {
    let set = Set::new();
    color(&set.file("Image0001.exr"), 0.5);
    color(&set.file("Mist0001.exr"), 0.5);
    ours::write_depth(&set.file("Depth0001.exr"), &Plane::filled(8, 6, 2.0)).unwrap();
    let (said, found) = set.init("");
    assert_says(&said, &["Mist%04d.exr was left out"]);
    assert_eq!((found.files.depth.as_deref(), found.probes.len()), (Some("Depth%04d.exr"), 1));

    // Y of a vector is no gray, and positions are no normals.
    let set = Set::new();
    color(&set.file("rgb.0001.exr"), 0.5);
    let constant = |name: &str| exr::prelude::AnyChannel::new(name, exr::prelude::FlatSamples::F32(vec![0.5; 48]));
    for name in ["P.0001.exr", "position.0001.exr", "depth.0001.exr"] {
        let channels = ["X", "Y", "Z"].into_iter().map(constant).collect();
        let image = Image::from_channels((8, 6), exr::prelude::AnyChannels::sort(channels));
        image.write().non_parallel().to_file(set.file(name)).unwrap();
    }
    let (said, found) = set.init("");
    assert_eq!((found.files.color.as_deref(), found.files.depth.as_deref()), (Some("rgb.%04d.exr"), None));
    assert_says(&said, &["the channels", "X, Y, Z"].map(|words| words.trim_start_matches("the ")));
}

#[test]
fn frame_numbers_below_zero_and_labels() {
    let set = Set::new();
    [-2, -1].iter().for_each(|frame| color(&set.file(&format!("a.{frame:04}.exr")), 0.5));
    assert_says(&set.refused(), &["a.-001.exr was left out", "a.-002.exr was left out", "below 0"]);
    let set = Set::new();
    (0..3).for_each(|frame| color(&set.file(&format!("s_{frame:03}_2k.exr")), 0.5));
    let (_, found) = set.init("");
    assert_eq!((found.files.color.as_deref(), found.frames), (Some("s_%03d_2k.exr"), [0, 2]));
    set.encodes();
}
