//! Footage for tests of resumed encodes: every codec, with chunks that end at different frames.

use std::fs;
use std::path::PathBuf;

use codec::color::Target;
use codec::container::Compression;
use codec::depth::predictive::Tables;
use codec::image::{Plane, StreamKind};
use codec::streams::{ColorBlocks, ColorFormat};
use footage::dataset::source::{SequenceLayout, Source, SourceOptions};
use footage::encode::{ColorBlockSettings, ColorCodec, DepthCodec, EncodeSettings, ErrorBound};
use footage::image_files::{exr, png};
use tempfile::TempDir;

use crate::roundtrip::{decoder, encoded};
use crate::samples::{self, Random};
use crate::train::trained;

/// Images on disk, with their encode settings.
pub struct Footage {
    pub folder: TempDir,
    kind: StreamKind,
    pub settings: EncodeSettings,
}

impl Footage {
    fn new(kind: StreamKind, settings: EncodeSettings, write: impl FnOnce(&dyn Fn(u32) -> PathBuf)) -> Footage {
        let folder = TempDir::new().unwrap();
        let end = if kind == StreamKind::Color { "png" } else { "exr" };
        write(&|frame| folder.path().join(format!("frame.{frame:03}.{end}")));
        Footage { folder, kind, settings }
    }

    pub fn path(&self, frame: u32) -> PathBuf {
        self.source().file(&self.source().groups()[0], frame).unwrap().unwrap()
    }

    pub fn source(&self) -> Source {
        if self.folder.path().join("lightfield.json").is_file() {
            return Source::open(self.folder.path(), &SourceOptions::default()).unwrap();
        }
        let (layout, options) = (SequenceLayout::default(), SourceOptions::default());
        Source::from_sequence(self.kind, self.folder.path().to_str().unwrap(), &layout, &options).unwrap()
    }
}

/// Returns depth footage of 40x24 pixels in four tiles that change often, in chunks of five frames.
pub fn depth(codec: DepthCodec) -> Footage {
    let mut settings = EncodeSettings::default();
    settings.temporal.keyframe_interval = 5;
    settings.temporal.window = 3;
    settings.depth.codec = codec;
    settings.depth.error = ErrorBound::Codes(40);
    Footage::new(StreamKind::Depth, settings, |path| write_depths(path, |code| 1.0 + f32::from(code)))
}

/// Returns footage as [`depth`] does, with 16 distances that are not integers.
pub fn few_depths(codec: DepthCodec) -> Footage {
    let settings = depth(codec).settings.clone();
    Footage::new(StreamKind::Depth, settings, |path| write_depths(path, |code| 0.7 + 0.37 * f32::from(code % 16)))
}

fn write_depths(path: &dyn Fn(u32) -> PathBuf, metres: impl Fn(u16) -> f32) {
    for (frame, codes) in samples::moving_codes([40, 24], 23, 7).into_iter().enumerate() {
        let metres = codes.iter().map(|&code| if code == u16::MAX { f32::INFINITY } else { metres(code) });
        exr::write_depth(&path(frame as u32), &Plane::new(40, 24, metres.collect()).unwrap()).unwrap();
    }
}

pub fn material(in_blocks: bool) -> Footage {
    let mut settings = EncodeSettings::default();
    settings.temporal.keyframe_interval = 4;
    settings.material.in_blocks = in_blocks;
    settings.material.epsilon = 8;
    Footage::new(StreamKind::Material, settings, |path| {
        for (frame, bytes) in samples::patched_materials([40, 24], 18).into_iter().enumerate() {
            let weights = bytes.iter().map(|b| [f32::from(b[0]) / 255.0, f32::from(b[1]) / 255.0, 1.0]);
            let plane = Plane::new(40, 24, weights.collect()).unwrap();
            exr::write_material(&path(frame as u32), &plane, ["reflect", "refract", "ior"]).unwrap();
        }
    })
}

/// Returns colour footage of two cells of different sizes, whose chunks are closed at different frames and long after their first
/// frames are read: frames of noise, some of them repeated, some followed by the mean of their neighbours.
pub fn color(hdr: bool, blocks: Option<ColorBlocks>) -> Footage {
    // Chunks are closed by size in bytes, and texture blocks have few bytes.
    let (width, height) = if blocks.is_some() { (640, 512) } else { (384, 256) };
    let mut settings = EncodeSettings { cell: height, color_codec: ColorCodec::Cells, ..EncodeSettings::default() };
    settings.search.target = Target::Psnr(38.0);
    settings.search.lookahead = 3;
    if blocks.is_some() {
        settings.search.effort = codec::effort::Effort::Fast;
    }
    if hdr {
        settings.color = ColorFormat::Half { white_cd_m2: 100.0 };
    }
    settings.color_blocks = blocks.map(|blocks| ColorBlockSettings { blocks, final_psnr_db: 12.0 });
    Footage::new(StreamKind::Color, settings, |path| {
        let mut random = Random(5);
        let mut noise = || (0..width * height * 3).map(|_| random.below(256) as u8).collect::<Vec<u8>>();
        let (mut before, mut frame) = (noise(), 0);
        let mut write = |bytes: &[u8], times: u32| {
            for _ in 0..times {
                let plane = Plane::new(width, height, bytes.as_chunks().0.to_vec()).unwrap();
                png::write_color8(&path(frame), &plane).unwrap();
                frame += 1;
            }
        };
        for n in 0..9 {
            let next = noise();
            write(&before, if n % 4 == 1 { 3 } else { 1 });
            write(&before.iter().zip(&next).map(|(&a, &b)| a.midpoint(b)).collect::<Vec<u8>>(), n % 2);
            before = next;
        }
        write(&before, 2);
    })
}

/// Returns colour footage of four cells for the transform codec, in chunks of five frames; one cell is noise, which is stored as
/// keyframes.
pub fn transform(hdr: bool) -> Footage {
    let mut settings = EncodeSettings { cell: 24, color_chunk: 5, ..EncodeSettings::default() };
    if hdr {
        settings.color = ColorFormat::Half { white_cd_m2: 100.0 };
    }
    settings.search.target = Target::Psnr(45.0);
    Footage::new(StreamKind::Color, settings, |path| {
        let mut random = Random(5);
        for (frame, mut bytes) in samples::drifting_bytes([40, 30], 17).into_iter().enumerate() {
            for pixel in (0..bytes.len()).filter(|at| at % 40 >= 24 && at / 40 >= 24) {
                bytes[pixel] = [0; 3].map(|_: u8| random.below(256) as u8);
            }
            png::write_color8(&path(frame as u32), &Plane::new(40, 30, bytes).unwrap()).unwrap();
        }
    })
}

fn predictive_with_own_tables() -> Footage {
    let mut footage = depth(DepthCodec::Predictive);
    footage.settings.depth_tables = Tables::default().sets()[2..4].to_vec();
    footage
}

pub fn transform_with_own_tables() -> Footage {
    let mut footage = transform(false);
    let container = encoded(&footage.source(), &footage.settings);
    footage.settings.color_tables = trained(&[decoder(&container)], 1).0.pop();
    footage
}

/// Returns a dataset of two probes, one of them with fewer frames, each with two faces of colour, depth and material.
pub fn dataset() -> Footage {
    let mut settings = EncodeSettings { compression: Compression::Lzma2(1), cell: 8, ..EncodeSettings::default() };
    settings.temporal.keyframe_interval = 3;
    // The quadtree codec uses several tiles for each image.
    settings.depth.codec = DepthCodec::Quadtree;
    let manifest = r#"{
        "lightfield": 1, "name": "two", "fps": 24, "frames": [10, 20], "projection": "cubemap", "size": [16, 16],
        "faces_present": ["px", "ny"],
        "files": { "color": "{probe}/{face}/c.%04d.exr", "depth": "{probe}/{face}/d.%04d.exr",
            "material": "{probe}/{face}/m.%04d.exr" },
        "probes": [{ "name": "a", "position": [0, 0, 0] }, { "name": "b", "position": [1, 0, 0], "frames": [13, 19] }]
    }"#;
    let footage = Footage::new(StreamKind::Depth, settings, |_| {});
    let root = footage.folder.path();
    fs::write(root.join("lightfield.json"), manifest).unwrap();
    let mut random = Random(11);
    for (probe, face) in [("a", "px"), ("a", "ny"), ("b", "px"), ("b", "ny")] {
        let folder = root.join(probe).join(face);
        fs::create_dir_all(&folder).unwrap();
        let still = random.below(2) == 0;
        let codes = samples::moving_codes([16, 16], 11, u64::from(random.below(99)));
        let bytes = samples::drifting_bytes([16, 16], 11);
        for (at, frame) in (10..=20).enumerate() {
            let metres = codes[if still { 0 } else { at }].iter().map(|&code| 1.0 + f32::from(code)).collect();
            let name = |kind: &str| folder.join(format!("{kind}.{frame:04}.exr"));
            exr::write_depth(&name("d"), &Plane::new(16, 16, metres).unwrap()).unwrap();
            let light = bytes[at].iter().map(|b| b.map(|v| half::f16::from_f32(f32::from(v) / 200.0))).collect();
            exr::write_color(&name("c"), &Plane::new(16, 16, light).unwrap()).unwrap();
            let weights = bytes[at / 2].iter().map(|b| b.map(|v| f32::from(v / 90) / 4.0 + 0.1)).collect();
            let plane = Plane::new(16, 16, weights).unwrap().map(|&[a, b, _]| [a, b, 1.5]);
            exr::write_material(&name("m"), &plane, ["reflect", "refract", "ior"]).unwrap();
        }
    }
    footage
}

pub fn all() -> Vec<(&'static str, Footage)> {
    vec![
        ("quadtree", depth(DepthCodec::Quadtree)),
        ("tree", depth(DepthCodec::Tree)),
        ("boxes", depth(DepthCodec::Boxes)),
        ("boxes in blocks", depth(DepthCodec::BoxesInBlocks)),
        ("blocks", depth(DepthCodec::Blocks)),
        ("predictive", depth(DepthCodec::Predictive)),
        ("predictive with own tables", predictive_with_own_tables()),
        ("predictive with levels", few_depths(DepthCodec::Predictive)),
        ("material", material(false)),
        ("material in blocks", material(true)),
        ("color", color(false, None)),
        ("color in bc1", color(false, Some(ColorBlocks::Bc1))),
        ("color in bc7", color(false, Some(ColorBlocks::Bc7))),
        ("half", color(true, None)),
        ("transform", transform(false)),
        ("transform of half floats", transform(true)),
        ("transform with own tables", transform_with_own_tables()),
        ("half in bc6h", color(true, Some(ColorBlocks::Bc6h))),
        ("dataset", dataset()),
    ]
}
