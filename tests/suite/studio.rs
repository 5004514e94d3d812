//! Footage as studios deliver it is encoded from its manifest alone, without options, and decodes to the right values.

use std::path::{Path, PathBuf};

use codec::image::{Face, ImageProjection};
use exr::prelude::{Blocks, Compression, FlatSamples, IntegerBounds, Vec2};
use footage::dataset::{Source, SourceOptions, StreamKind};
use footage::image_files::exr as ours;
use half::f16;
use tempfile::TempDir;

use crate::commands::{fine, refused};
use crate::exr_files::{Part, write_parts};
use crate::input::assert_says;

const SIDE: usize = 16;
const FRAMES: [u32; 2] = [1, 3];
const INF: f32 = f32::INFINITY;
const VIEW: [Face; 1] = [Face::View];

/// Returns planar depth in metres; the top rows are background.
fn depth_m(x: usize, y: usize, frame: u32) -> f32 {
    if y < 4 { INF } else { 2.0 + 0.125 * x as f32 + 0.25 * y as f32 + 0.5 * frame as f32 }
}

fn color(x: usize, y: usize, _frame: u32) -> [f32; 3] {
    [0.25, 0.5 + 0.015625 * x as f32, 0.25 + 0.015625 * y as f32]
}

fn floats(size: [usize; 2], value: impl Fn(usize, usize) -> f32) -> FlatSamples {
    FlatSamples::F32((0..size[0] * size[1]).map(|at| value(at % size[0], at / size[0])).collect())
}

fn halves(size: [usize; 2], value: impl Fn(usize, usize) -> f32) -> FlatSamples {
    FlatSamples::F16((0..size[0] * size[1]).map(|at| f16::from_f32(value(at % size[0], at / size[0]))).collect())
}

/// Compression and block layout of a test's files.
#[derive(Clone, Copy)]
struct Storage {
    compression: Compression,
    blocks: Blocks,
}

const ZIP: Storage = Storage { compression: Compression::ZIP16, blocks: Blocks::ScanLines };

type Channels<'a> = Vec<(&'a str, FlatSamples)>;

fn write(path: &Path, size: [usize; 2], storage: Storage, parts: Vec<(Option<&str>, Channels<'_>)>) {
    std::fs::create_dir_all(path.parent().unwrap()).unwrap();
    let part = |(name, channels)| Part { name, position: [0, 0], size, channels };
    let display = IntegerBounds::from_dimensions((size[0], size[1]));
    write_parts(path, display, storage.compression, storage.blocks, parts.into_iter().map(part).collect());
}

fn rgb<'a>(names: [&'a str; 3], frame: u32) -> Channels<'a> {
    let channel = |at: usize| halves([SIDE; 2], move |x, y| color(x, y, frame)[at]);
    names.into_iter().enumerate().map(|(at, name)| (name, channel(at))).collect()
}

/// A folder of footage, which is encoded to a container and decoded to a dataset.
struct Studio(TempDir);

impl Studio {
    fn new() -> Studio {
        Studio(TempDir::new().unwrap())
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join("in").join(name)
    }

    /// Writes a file per frame, with the name that `name` returns for it.
    fn frames(
        &self,
        name: impl Fn(u32) -> String,
        parts: impl Fn(u32) -> Vec<(Option<&'static str>, Channels<'static>)>,
    ) {
        for frame in FRAMES[0]..=FRAMES[1] {
            write(&self.path(&name(frame)), [SIDE; 2], ZIP, parts(frame));
        }
    }

    fn manifest(&self, keys: &str) {
        std::fs::create_dir_all(self.0.path().join("in")).unwrap();
        let text = format!(r#"{{"lightfield": 1, "name": "shot", "frames": [1, 3], {keys}}}"#);
        std::fs::write(self.path("lightfield.json"), text).unwrap();
    }

    /// Writes a manifest with these keys for one perspective camera with planar depth.
    fn view(&self, keys: &str) {
        self.manifest(&format!(
            r#""fps": 24, "projection": "perspective", "size": [16, 16], {keys},
               "probes": [{{"name": "cam", "position": [0, 0, 0], "fov_y_deg": 60}}]"#
        ));
    }

    /// Encodes and decodes the footage without options; returns the standard error of `encode`, and the decoded dataset.
    fn there_and_back(&self) -> (String, Source) {
        let said = fine("encode in -o film.lfold --quiet", self.0.path()).stderr;
        fine("decode film.lfold -o out --quiet", self.0.path());
        let source = Source::open(&self.0.path().join("out"), &SourceOptions::default()).unwrap();
        (String::from_utf8(said).unwrap(), source)
    }
}

/// Compares depth and colour of all frames and faces with the expected values, which are functions of probe, face, column and
/// row, and frame.
fn check(
    source: &Source,
    faces: &[Face],
    distance: impl Fn(&str, Face, [u32; 2], u32) -> f32,
    light: impl Fn(&str, Face, [u32; 2], u32) -> [f32; 3],
) {
    let of = |kind: StreamKind| source.groups().iter().filter(move |group| group.kind == kind);
    assert_eq!(of(StreamKind::Depth).count(), faces.len() * source.probes().len());
    assert_eq!(of(StreamKind::Color).count(), faces.len() * source.probes().len());
    for group in source.groups() {
        let (probe, face) = (source.probes()[group.probe].name.as_str(), group.faces[0]);
        assert!(faces.contains(&face), "{face:?}");
        for (frame, y, x) in group
            .frames
            .iter()
            .flat_map(|frame| (0..group.height).flat_map(move |y| (0..group.width).map(move |x| (frame, y, x))))
            .step_by(7)
        {
            let at = format!("{probe} {face:?} {x},{y} frame {frame}");
            if group.kind == StreamKind::Depth {
                let (found, wanted) =
                    (source.read_depth(group, frame).unwrap()[0].get(x, y), distance(probe, face, [x, y], frame));
                assert!(found == wanted || (found / wanted - 1.0).abs() < 0.01, "{at}: {found} for {wanted}");
            } else {
                let (found, wanted) =
                    (source.read_color(group, frame).unwrap()[0].get(x, y), light(probe, face, [x, y], frame));
                let error = found.iter().zip(wanted).map(|(a, b)| (a.to_f32() - b).abs()).fold(0.0, f32::max);
                assert!(error < 0.08, "{at}: {found:?} for {wanted:?}");
            }
        }
    }
}

/// Runs [`check`] for a perspective camera of 60 degrees that sees [`depth_m`] and [`color`].
fn check_view(source: &Source) {
    let intrinsics = source.probes()[0].intrinsics.unwrap();
    let pinhole = ImageProjection::Pinhole { size: [SIDE as u32; 2], intrinsics };
    let distance = |_: &str, _: Face, [x, y]: [u32; 2], frame: u32| {
        depth_m(x as usize, y as usize, frame) * pinhole.ray_length_factor(x, y) as f32
    };
    check(source, &VIEW, distance, |_, _, [x, y], frame| color(x as usize, y as usize, frame));
}

/// Returns depth with `value` for the background.
fn with_background(value: f32, frame: u32) -> impl Fn(usize, usize) -> f32 {
    move |x, y| if depth_m(x, y, frame) == INF { value } else { depth_m(x, y, frame) }
}

#[test]
fn blender_writes_one_part_of_many_layers() {
    let studio = Studio::new();
    studio.frames(
        |frame| format!("shot{frame:04}.exr"),
        |frame| {
            let mut channels = rgb(["ViewLayer.Combined.R", "ViewLayer.Combined.G", "ViewLayer.Combined.B"], frame);
            channels.push(("ViewLayer.Combined.A", halves([SIDE; 2], |_, _| 1.0)));
            // Blender writes its clipping distance instead of infinity.
            channels.push(("ViewLayer.Depth.Z", floats([SIDE; 2], with_background(1e10, frame))));
            for name in ["ViewLayer.Normal.X", "ViewLayer.Normal.Y", "ViewLayer.Normal.Z"] {
                channels.push((name, floats([SIDE; 2], |_, _| 0.5)));
            }
            vec![(None, channels)]
        },
    );
    studio.view(r#""depth": {"kind": "planar"}, "files": {"color": "shot####.exr", "depth": "shot####.exr"}"#);
    check_view(&studio.there_and_back().1);
}

#[test]
fn arnold_writes_1e30_where_nothing_is() {
    let studio = Studio::new();
    studio.frames(
        |frame| format!("beauty.{frame:04}.exr"),
        |frame| {
            let mut channels = rgb(["R", "G", "B"], frame);
            channels.push(("A", halves([SIDE; 2], |_, y| f32::from(u8::from(y >= 4)))));
            channels.push(("Z", floats([SIDE; 2], with_background(1e30, frame))));
            vec![(None, channels)]
        },
    );
    let files = r#""files": {"color": "beauty.%04d.exr", "depth": "beauty.%04d.exr"}"#;
    for background in ["", r#", "background": 1e30"#] {
        studio.view(&format!(r#""depth": {{"kind": "planar"{background}}}, {files}"#));
        check_view(&studio.there_and_back().1);
    }
    // Depth averaged over edges, as Arnold's default filter does.
    studio.frames(
        |frame| format!("beauty.{frame:04}.exr"),
        |frame| {
            let mut channels = rgb(["R", "G", "B"], frame);
            channels.push((
                "Z",
                floats([SIDE; 2], move |x, y| if y == 4 { 2e29 } else { with_background(1e30, frame)(x, y) }),
            ));
            vec![(None, channels)]
        },
    );
    let said = refused("encode in -o film.lfold", studio.0.path());
    assert_says(&said, &["beauty.0001.exr", "pixel (0, 4)", "2e29", "--invalid-depth", "depth.far"]);
}

#[test]
fn v_ray_writes_depth_three_times() {
    let studio = Studio::new();
    studio.frames(
        |frame| format!("v.{frame:04}.exr"),
        |frame| {
            let mut channels = rgb(["R", "G", "B"], frame);
            for name in ["VRayZDepth.R", "VRayZDepth.G", "VRayZDepth.B"] {
                channels.push((name, floats([SIDE; 2], move |x, y| 100.0 * depth_m(x, y, frame))));
            }
            vec![(None, channels)]
        },
    );
    for channel in ["", r#", "channel": "VRayZDepth""#] {
        studio.view(&format!(
            r#""depth": {{"kind": "planar", "unit": "cm"{channel}}},
               "files": {{"color": "v.<frame04>.exr", "depth": "v.<f4>.exr"}}"#
        ));
        check_view(&studio.there_and_back().1);
    }
}

#[test]
fn houdini_writes_negative_z() {
    let studio = Studio::new();
    studio.frames(
        |frame| format!("render/shot.{frame:04}.exr"),
        |frame| {
            let mut channels = rgb(["C.R", "C.G", "C.B"], frame);
            channels.push(("Pz", floats([SIDE; 2], move |x, y| -with_background(0.0, frame)(x, y))));
            vec![(None, channels)]
        },
    );
    let files = r#""files": {"color": "render/shot.$F4.exr", "depth": "render/shot.$F4.exr"}"#;
    studio.view(&format!(r#""depth": {{"kind": "planar", "scale": -1, "background": 0}}, {files}"#));
    check_view(&studio.there_and_back().1);
    studio.view(&format!(r#""depth": {{"kind": "planar", "background": 0}}, {files}"#));
    assert_says(&refused("encode in -o film.lfold", studio.0.path()), &["negative", "Pz", "depth.scale to -1"]);
}

#[test]
fn parts_of_stereo_files_are_probes() {
    let studio = Studio::new();
    studio.frames(
        |frame| format!("s.{frame:04}.exr"),
        |frame| {
            let eye = |name, nearer: f32| {
                let mut channels = rgb(["R", "G", "B"], frame);
                channels.push(("Z", floats([SIDE; 2], move |x, y| depth_m(x, y, frame) - nearer)));
                (Some(name), channels)
            };
            vec![eye("left", 0.0), eye("right", 1.0)]
        },
    );
    studio.manifest(
        r#""fps": 24, "projection": "perspective", "size": [16, 16],
           "depth": {"channel": "{probe}"}, "color": {"layer": "{probe}"},
           "files": {"color": "s.%04d.exr", "depth": "s.%04d.exr"},
           "probes": [{"name": "left", "position": [-0.03, 0, 0]}, {"name": "right", "position": [0.03, 0, 0]}]"#,
    );
    let distance = |probe: &str, _: Face, [x, y]: [u32; 2], frame: u32| {
        depth_m(x as usize, y as usize, frame) - f32::from(u8::from(probe == "right"))
    };
    let light = |_: &str, _: Face, [x, y]: [u32; 2], frame: u32| color(x as usize, y as usize, frame);
    check(&studio.there_and_back().1, &VIEW, distance, light);
    // Only one of the two views.
    studio.view(
        r#""depth": {"channel": "left", "kind": "planar"}, "color": {"layer": "left"},
           "files": {"color": "s.%04d.exr", "depth": "s.%04d.exr"}"#,
    );
    check_view(&studio.there_and_back().1);
}

#[test]
fn tiles_and_lossy_compression_of_halves_and_floats() {
    for compression in [Compression::ZIP16, Compression::PIZ, Compression::DWAA(None), Compression::DWAB(None)] {
        for blocks in [Blocks::ScanLines, Blocks::Tiles(Vec2(8, 8))] {
            for as_half in [false, true] {
                let studio = Studio::new();
                for frame in FRAMES[0]..=FRAMES[1] {
                    let samples = if as_half { halves } else { floats };
                    let mut channels = rgb(["R", "G", "B"], frame);
                    channels.push(("Z", samples([SIDE; 2], |x, y| depth_m(x, y, frame))));
                    let storage = Storage { compression, blocks };
                    write(&studio.path(&format!("t.{frame}.exr")), [SIDE; 2], storage, vec![(None, channels)]);
                }
                studio.view(r#""depth": {"kind": "planar"}, "files": {"color": "t.%d.exr", "depth": "t.%d.exr"}"#);
                check_view(&studio.there_and_back().1);
            }
        }
    }
}

/// Returns the distance to the walls of a box around the probe, and a colour per direction.
fn in_a_box(face: Face, [x, y]: [u32; 2]) -> (f32, [f32; 3]) {
    let direction = face.direction(x, y, SIDE as u32).normalize();
    let distance = 1.0 / (direction.x.abs() / 2.0).max(direction.y.abs()).max(direction.z.abs() / 3.0);
    (distance as f32, (direction * 0.125 + 0.5).as_vec3().to_array())
}

fn check_box(source: &Source) {
    check(source, &Face::CUBE, |_, face, at, _| in_a_box(face, at).0, |_, face, at, _| in_a_box(face, at).1);
}

fn box_channels(place: impl Fn(usize, usize) -> Option<(Face, [u32; 2])>, size: [usize; 2]) -> Channels<'static> {
    let seen = |x, y| place(x, y).map_or((0.0, [0.0; 3]), |(face, at)| in_a_box(face, at));
    let mut channels: Channels<'static> = ["R", "G", "B"]
        .into_iter()
        .enumerate()
        .map(|(at, name)| (name, halves(size, |x, y| seen(x, y).1[at])))
        .collect();
    channels.push(("Z", floats(size, |x, y| seen(x, y).0)));
    channels
}

#[test]
fn crosses_hold_a_cube() {
    let studio = Studio::new();
    let places =
        [(Face::Px, 2, 1), (Face::Nx, 0, 1), (Face::Py, 1, 0), (Face::Ny, 1, 2), (Face::Pz, 1, 1), (Face::Nz, 3, 1)];
    let place = |x: usize, y: usize| {
        let cell = (x / SIDE, y / SIDE);
        let found = places.iter().find(|(_, column, row)| (*column, *row) == cell)?;
        Some((found.0, [(x % SIDE) as u32, (y % SIDE) as u32]))
    };
    let size = [4 * SIDE, 3 * SIDE];
    for frame in FRAMES[0]..=FRAMES[1] {
        write(&studio.path(&format!("x.{frame:04}.exr")), size, ZIP, vec![(None, box_channels(place, size))]);
    }
    studio.manifest(
        r#""fps": "24000/1001", "projection": "cubemap", "faces": "opengl-cube-cross", "size": [64, 48],
           "files": {"color": "x.%04d.exr", "depth": "x.%04d.exr"}, "probes": [{"name": "a", "position": [0, 0, 0]}]"#,
    );
    let source = studio.there_and_back().1;
    assert_eq!(source.fps(), 24000.0 / 1001.0);
    check_box(&source);
}

#[test]
fn faces_have_the_names_of_the_studio() {
    let studio = Studio::new();
    let names = [
        ("right", Face::Px),
        ("left", Face::Nx),
        ("top", Face::Py),
        ("ny", Face::Ny),
        ("front", Face::Pz),
        ("nz", Face::Nz),
    ];
    for (name, face) in names {
        for frame in FRAMES[0]..=FRAMES[1] {
            let place = |x: usize, y: usize| Some((face, [x as u32, y as u32]));
            let channels = box_channels(place, [SIDE; 2]);
            write(&studio.path(&format!("{name}/{name}_{frame:03}.exr")), [SIDE; 2], ZIP, vec![(None, channels)]);
        }
    }
    studio.manifest(
        r#""$schema": "manifest.json", "fps": 24, "projection": "cubemap", "size": [16, 16],
           "face_names": {"px": "right", "nx": "left", "py": "top", "pz": "front"},
           "files": {"color": "{face}/{face}_%03d.exr", "depth": "{face}/{face}_%03d.exr"},
           "probes": [{"name": "a", "position": [0, 0, 0]}]"#,
    );
    check_box(&studio.there_and_back().1);
}

#[test]
fn the_left_eye_is_above_the_right_one() {
    let studio = Studio::new();
    let size = [64, 64];
    for frame in FRAMES[0]..=FRAMES[1] {
        let of = |values: [f32; 2]| move |_: usize, y: usize| values[usize::from(y >= 32)];
        let channels = vec![
            ("R", halves(size, of([0.25, 0.75]))),
            ("G", halves(size, of([0.5, 0.5]))),
            ("B", halves(size, of([0.75, 0.25]))),
            ("Z", floats(size, of([2.0, 5.0]))),
        ];
        write(&studio.path(&format!("vr.{frame:04}.exr")), size, ZIP, vec![(None, channels)]);
    }
    studio.manifest(
        r#""fps": 24, "projection": "equirect", "size": [64, 64], "stereo": "over-under",
           "files": {"color": "vr.%04d.exr", "depth": "vr.%04d.exr"},
           "probes": [{"name": "l", "position": [-0.03, 0, 0], "eye": "left"},
                      {"name": "r", "position": [0.03, 0, 0], "eye": "right"}]"#,
    );
    let of = |probe: &str| usize::from(probe == "r");
    check(
        &studio.there_and_back().1,
        &Face::CUBE,
        |probe, _, _, _| [2.0, 5.0][of(probe)],
        |probe, _, _, _| [[0.25, 0.5, 0.75], [0.75, 0.5, 0.25]][of(probe)],
    );
}

#[test]
fn a_moving_camera_has_a_pose_for_each_frame() {
    let studio = Studio::new();
    studio.frames(
        |frame| format!("m.{frame:04}.exr"),
        |frame| {
            let mut channels = rgb(["R", "G", "B"], frame);
            channels.push(("Z", floats([SIDE; 2], move |x, y| depth_m(x, y, frame))));
            vec![(None, channels)]
        },
    );
    studio.manifest(
        r#""fps": 24, "projection": "perspective", "size": [16, 16], "depth": {"kind": "planar"},
           "files": {"color": "m.%04d.exr", "depth": "m.%04d.exr"},
           "probes": [{"name": "cam", "fov_y_deg": 60, "poses": [
               {"frame": 1, "position": [1, 2, 3]},
               {"frame": 3, "position": [3, 2, 3], "orientation": [0, 1, 0, 0]},
               {"frame": 2, "position": [2, 2, 3], "orientation": [0, 0.6, 0, 0.8]}]}]"#,
    );
    let source = Source::open(&studio.path(""), &SourceOptions::default()).unwrap();
    let probe = &source.probes()[0];
    assert_eq!((probe.position, probe.orientation), ([1.0, 2.0, 3.0], [0.0, 0.0, 0.0, 1.0]));
    let poses: Vec<_> = probe.poses.iter().map(|pose| (pose.frame, pose.position[0])).collect();
    assert_eq!(poses, [(1, 1.0), (2, 2.0), (3, 3.0)]);
    assert_eq!((probe.pose(2).orientation, probe.pose(9).position), ([0.0, 0.6, 0.0, 0.8], [1.0, 2.0, 3.0]));
    let (said, decoded) = studio.there_and_back();
    assert_eq!(said, "");
    assert_eq!(decoded.probes()[0].poses, probe.poses);
    check_view(&decoded);
    // Each image is rendered, and compared with the source, from the pose of its frame.
    fine("render film.lfold --frames 2-3 --size 16 -o own.%04d.exr", studio.0.path());
    for frame in [2, 3] {
        let read =
            |name: String| ours::read_color(&studio.0.path().join(name), &Default::default(), &Default::default());
        let [shown, taken] =
            [format!("own.{frame:04}.exr"), format!("in/m.{frame:04}.exr")].map(|name| read(name).unwrap());
        let error = shown.data().as_flattened().iter().zip(taken.data().as_flattened());
        let most = error.map(|(a, b)| (a.to_f32() - b.to_f32()).abs()).fold(0.0, f32::max);
        // Colour is lossy by default.
        assert!(most < 0.06, "frame {frame}: {most}");
    }
    let report = fine("render film.lfold --reference in --null --json", studio.0.path()).stdout;
    let report: serde_json::Value = serde_json::from_slice(&report).unwrap();
    assert!(report["reference"]["psnr_db"].as_f64().unwrap() > 40.0, "{report}");
}

#[test]
fn options_override_the_manifest() {
    let studio = Studio::new();
    studio.frames(
        |frame| format!("o.{frame:04}.exr"),
        |frame| {
            let mut channels = rgb(["wrong.R", "wrong.G", "wrong.B"], frame + 1);
            channels.extend(rgb(["right.R", "right.G", "right.B"], frame));
            channels.push(("far", floats([SIDE; 2], move |x, y| 3.0 * depth_m(x, y, frame))));
            channels.push(("close", floats([SIDE; 2], move |x, y| depth_m(x, y, frame))));
            vec![(None, channels)]
        },
    );
    studio.view(
        r#""depth": {"kind": "planar", "channel": "far"}, "color": {"layer": "none"},
           "files": {"color": "o.%04d.exr", "depth": "o.%04d.exr"}"#,
    );
    let said = refused("encode in -o film.lfold", studio.0.path());
    assert_says(&said, &["o.0001.exr", "there is no layer, channel or view none", "right.R"]);
    fine("encode in -o film.lfold --depth-channel close --color-channel right --quiet", studio.0.path());
    fine("diff in film.lfold --depth-channel close --color-channel right --max-error 100", studio.0.path());
    // Image sequences accept the same options.
    fine("encode-depth in/o.%04d.exr --depth-channel close -o z.lfold --quiet", studio.0.path());
    fine("diff in/o.$F4.exr z.lfold --depth-channel close --max-error 100", studio.0.path());
    let said = refused("encode-depth in/o.%04d.exr --color-channel right -o z.lfold", studio.0.path());
    assert_says(&said, &["--color-channel", "a sequence of depth"]);
}
