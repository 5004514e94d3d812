//! Colour, depth and material in texture blocks: decoded values keep the quality and error bounds of the settings, through the
//! library and through the commands.

use std::path::Path;

use codec::color::SearchSettings;
use codec::container::Compression;
use codec::decode::Picture;
use codec::depth::TemporalSettings;
use codec::effort::Effort;
use codec::image::{ColorPlane, Face, MaterialPlane, Plane};
use codec::monitor::Silent;
use codec::streams::{CodecHeader, ColorBlocks, ColorFormat, convert};
use footage::encode::{
    ColorBlockSettings, ColorCodec, DepthCodec, DepthSettings, EncodeSettings, MaterialSettings, encode,
};
use half::f16;
use lightfold::Error;
use tempfile::TempDir;

use crate::commands::{fine, refused};
use crate::footage::{Footage, Random, drifting_color};
use crate::roundtrip::{check_color8, check_depth, decoder, encoded};

const ALL_BLOCKS: [Option<ColorBlocks>; 3] = [None, Some(ColorBlocks::Bc1), Some(ColorBlocks::Bc7)];

/// Returns red and green ramps, where red drifts with the frame, and noise in blue in the top left 8x8 pixels.
fn noisy_color(width: u32, height: u32, frame: u32) -> ColorPlane {
    let mut random = Random(u64::from(frame) + 5);
    Plane::from_fn(width, height, |x, y| {
        let noise = if x < 8 && y < 8 { random.below(1000) as f32 / 1000.0 } else { 0.0 };
        [0.1 + (x + frame) as f32 * 0.004, 0.3 + y as f32 * 0.003, noise].map(f16::from_f32)
    })
}

fn materials(width: u32, height: u32, frame: u32) -> MaterialPlane {
    let mut random = Random(u64::from(frame / 2));
    Plane::from_fn(width, height, |x, y| match (x / 8 + y / 8) % 3 {
        _ if x < 12 && y < 12 && random.below(9) < 3 => [random.below(9) as f32 / 8.0, 0.0, 3.0],
        0 => [0.0, 0.0, 1.0],
        1 => [0.5, (x % 8) as f32 / 64.0, 1.5],
        _ => [0.25, 0.75, 1.25],
    })
}

fn settings(blocks: Option<ColorBlocks>, final_psnr_db: f64) -> EncodeSettings {
    let depth = DepthSettings { codec: DepthCodec::BoxesInBlocks, effort: Effort::Fast, ..DepthSettings::default() };
    EncodeSettings {
        cell: 16,
        color_codec: ColorCodec::Cells,
        color_blocks: blocks.map(|blocks| ColorBlockSettings { blocks, final_psnr_db }),
        search: SearchSettings { effort: Effort::Fast, ..SearchSettings::default() },
        material: MaterialSettings { epsilon: 8, in_blocks: true },
        depth,
        ..EncodeSettings::default()
    }
}

#[test]
fn colour_of_any_size_reaches_the_final_quality() {
    for (width, height) in [(1, 1), (3, 5), (17, 9), (33, 20)] {
        let folder = TempDir::new().unwrap();
        let color = |_: Face, frame: u32| noisy_color(width, height, frame);
        let source =
            Footage { color: Some(&color), frames: [0, 11], ..Footage::new(width, height) }.open(folder.path());
        for (blocks, db) in ALL_BLOCKS.iter().flatten().flat_map(|&blocks| [(blocks, 25.0), (blocks, 45.0)]) {
            let bytes = encoded(&source, &settings(Some(blocks), db));
            check_color8(&source, &bytes, db);
            let decoder = decoder(&bytes);
            let CodecHeader::Color(header) = &decoder.streams()[0].header else { panic!("colour expected") };
            assert_eq!((header.blocks(), header.min_psnr_db), (Some(blocks), db));
        }
    }
}

#[test]
fn depth_and_material_of_any_size_keep_their_bounds() {
    for (width, height) in [(1, 1), (3, 5), (17, 9), (70, 33)] {
        let folder = TempDir::new().unwrap();
        let depth = |_: Face, frame: u32| {
            Plane::from_fn(width, height, |x, y| match (x + 2 * y + frame) % 37 {
                0 => f32::INFINITY,
                1 => 40.0,
                _ => 2.0 + x as f32 * 0.01 + y as f32 * 0.02,
            })
        };
        let material = |_: Face, frame: u32| materials(width, height, frame);
        let footage = Footage { depth: Some(&depth), material: Some(&material), ..Footage::new(width, height) };
        let source = footage.open(folder.path());
        for (epsilon, window) in [(0, 1), (40, 2), (2000, 3)] {
            let temporal = TemporalSettings { epsilon, window, ..TemporalSettings::default() };
            let bytes = encoded(&source, &EncodeSettings { temporal, ..settings(None, 0.0) });
            check_depth(&source, &bytes, epsilon);
            let decoder = decoder(&bytes);
            let stream = decoder.streams().iter().find(|stream| matches!(stream.header, CodecHeader::Material(_)));
            let (stream, group) = (stream.unwrap(), &source.groups()[1]);
            let mut face = decoder.face(stream);
            for frame in stream.frames.iter().rev() {
                let wanted = convert::material_codes(&source.read_material(group, frame).unwrap()[0]).unwrap();
                let Picture::Material(shown) = face.decode(frame).unwrap() else { panic!("material expected") };
                let pairs = wanted.data().as_flattened().iter().zip(shown.data().as_flattened());
                assert!(pairs.into_iter().all(|(a, b)| a.abs_diff(*b) <= 8), "frame {frame}");
            }
        }
    }
}

#[test]
fn the_same_bytes_on_any_number_of_threads() {
    let folder = TempDir::new().unwrap();
    let depth = |_: Face, frame: u32| Plane::from_fn(64, 48, |x, y| 1.0 + ((x + frame * 3) % 64 * (y + 1)) as f32);
    let color = |_: Face, frame: u32| noisy_color(64, 48, frame);
    let material = |_: Face, frame: u32| materials(64, 48, frame);
    let footage = Footage {
        frames: [3, 20],
        depth: Some(&depth),
        color: Some(&color),
        material: Some(&material),
        ..Footage::new(64, 48)
    };
    let source = footage.open(folder.path());
    let temporal = TemporalSettings { epsilon: 300, ..TemporalSettings::default() };
    let settings =
        EncodeSettings { temporal, compression: Compression::Lzma2(3), ..settings(Some(ColorBlocks::Bc7), 35.0) };
    let once = encoded(&source, &settings);
    for threads in [1, 2, 5] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        assert!(pool.install(|| encoded(&source, &settings)) == once, "{threads} threads give other bytes");
    }
}

#[test]
fn settings_that_cannot_be_are_refused() {
    let folder = TempDir::new().unwrap();
    let color = |_: Face, frame: u32| drifting_color(8, 8, frame);
    let source = Footage { color: Some(&color), ..Footage::new(8, 8) }.open(folder.path());
    let bc1 = settings(Some(ColorBlocks::Bc1), 30.0);
    let hdr = ColorFormat::Half { white_cd_m2: 100.0 };
    let wrong = [
        (EncodeSettings { cell: 10, ..bc1.clone() }, "a multiple of 4"),
        (EncodeSettings { color: hdr, ..bc1.clone() }, "bc6h with `hdr`"),
        (settings(Some(ColorBlocks::Bc6h), 30.0), "bc6h with `hdr`"),
        (settings(Some(ColorBlocks::Bc1), 50.5), "blocks only lose"),
    ];
    for (settings, said) in wrong {
        match encode(&source, &settings, Vec::new(), &Silent) {
            Err(Error::Usage(message)) => assert!(message.contains(said), "{message}"),
            other => panic!("{said}: {other:?}"),
        }
    }
}

fn dataset(folder: &Path) {
    let depth = |_: Face, frame: u32| Plane::from_fn(48, 48, |x, y| 2.0 + ((x + frame) * y) as f32 * 0.001);
    let color = |_: Face, frame: u32| noisy_color(48, 48, frame);
    let material = |_: Face, frame: u32| materials(48, 48, frame);
    Footage { depth: Some(&depth), color: Some(&color), material: Some(&material), ..Footage::new(48, 48) }
        .write(folder);
}

fn inspected(folder: &Path, file: &str) -> serde_json::Value {
    serde_json::from_slice(&fine(&format!("inspect {file} --json"), folder).stdout).unwrap()
}

#[test]
fn commands_encode_inspect_decode_pack_and_compare_blocks() {
    let folder = TempDir::new().unwrap();
    dataset(folder.path());
    let options =
        "--depth-codec aabb --depth-block bc5 --update-threshold 50 --material-block bc1 --color-cell 16 --effort fast";
    for (color, name) in [("bc1 --psnr-final 28", "cells-bc1"), ("bc7", "cells-bc7"), ("bc6h --hdr", "cells-bc6h")] {
        fine(&format!("encode . -o a.lfold --color-block {color} {options}"), folder.path());
        let json = inspected(folder.path(), "a.lfold");
        let streams = json["streams"].as_array().unwrap();
        let codecs: Vec<_> = streams.iter().map(|stream| stream["codec"].as_str().unwrap()).collect();
        assert_eq!(codecs, [name, "aabb-bc5", "aabb-bc1"]);
        let count = |at: usize, key: &str| streams[at].pointer(key).and_then(|value| value.as_u64()).unwrap();
        assert!(count(0, "/keyframes_blocks") > 0);
        let keyframes = count(0, "/keyframes_blocks") + count(0, "/keyframes_raw");
        assert!(keyframes >= 9 && keyframes <= count(0, "/keyframes"), "{keyframes}");
        assert!(
            count(1, "/pieces/blocks") + count(1, "/pieces/raw") > 0
                && count(2, "/pieces/blocks") > 0
                && count(2, "/pieces/raw") > 0
        );
        let text = String::from_utf8(fine("inspect a.lfold", folder.path()).stdout).unwrap();
        assert!(text.contains(name) && text.contains("block tiles of 16x16") && text.contains("BC5"), "{text}");
        fine("pack a.lfold --lzma2 -o b.lfold", folder.path());
        fine("diff a.lfold b.lfold --exact", folder.path());
        fine("inspect b.lfold --verify", folder.path());
        let db = streams[0]["min_psnr_db"].as_f64().unwrap();
        fine(&format!("diff . a.lfold --max-error 50 --min-cell-psnr {db} --ssim none"), folder.path());
        let out = format!("out-{name}");
        fine(&format!("decode b.lfold -o {out}"), folder.path());
        fine(&format!("diff {out} a.lfold --exact"), folder.path());
    }
}

#[test]
fn with_blocks_other_bounds_are_usual() {
    let folder = TempDir::new().unwrap();
    dataset(folder.path());
    let bytes_of = |options: &str| {
        fine(format!("encode . --effort fast -o a.lfold {options}").trim_end(), folder.path());
        std::fs::read(folder.path().join("a.lfold")).unwrap()
    };
    let of_color = |options: &str| bytes_of(&format!("--stream color --color-block BC7 {options}"));
    // `assert_eq!` would print both files in full.
    assert!(of_color("") == of_color("--psnr 40 --psnr-final 40"));
    assert!(of_color("--psnr-final 20") == of_color("--psnr 20 --psnr-final 20"));
    assert!(of_color("--psnr-final 20") != of_color("--psnr 50 --psnr-final 20"));
    let of_depth = |options: &str| bytes_of(&format!("--stream depth --depth-codec aabb --depth-block bc5 {options}"));
    assert!(of_depth("") == of_depth("--update-threshold 100"));
    assert!(of_depth("") != of_depth("--update-threshold 0"));
}

#[test]
fn options_that_do_not_go_together_are_refused() {
    let folder = TempDir::new().unwrap();
    dataset(folder.path());
    let says = |options: &str, what: &str| {
        let said = refused(&format!("encode . -o a.lfold {options}"), folder.path());
        assert!(said.contains(what), "{options}: {said}");
        assert!(!folder.path().join("a.lfold").exists());
    };
    says("--color-block bc6h", "--hdr");
    says("--color-block bc7 --hdr", "--hdr");
    says("--color-block bc1 --color-cell 18", "a multiple of 4");
    says("--color-block bc1 --psnr 50 --psnr-final 60", "at most --psnr, 50 dB");
    says("--color-block bc1 --psnr-final 201", "0 to 200 dB");
    says("--depth-codec aabb --max-error 10", "--update-threshold");
    says("--depth-codec aabb --max-error-relative 1%", "--update-threshold");
    says("--depth-codec bc4w --max-error 10", "no error bound");
    says("--psnr-final 30", "--color-block");
    says("--depth-block bc5", "--depth-codec aabb");
    says("--depth-block bc5 --depth-codec bc4w", "--depth-codec aabb");
}
