//! Regression test of encoded bytes and quality against tests/baselines/footage.csv, one row for each dataset and kind of stream.
//!
//! `cargo test --test suite quality::write_baselines -- --ignored` rewrites the file after an intended change.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use codec::color::{SearchSettings, Target};
use codec::container::{Compression, Reader};
use codec::decode::{Decoder, Picture};
use codec::depth::TemporalSettings;
use codec::effort::Effort;
use codec::image::StreamKind;
use codec::image::transfer::{EncodeTable, ToneMap};
use codec::metrics::psnr::SquaredError;
use codec::monitor::Silent;
use codec::streams::{CodecHeader, ColorBlocks, convert};
use footage::dataset::source::{Source, SourceOptions};
use footage::dataset::{Manifest, Projection};
use footage::encode::{
    ColorBlockSettings, ColorCodec, DepthCodec, DepthSettings, EncodeSettings, MaterialSettings, encode,
};
use scene::{DemoKind, FootagePlan};

const FILE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/baselines/footage.csv");
const HEAD: &str = "set,kind,lzma2,bytes,max_error_codes,min_psnr_db";

/// Bytes and errors of the streams of one kind in one dataset.
#[derive(Debug, PartialEq)]
struct Row {
    name: String,
    kind: &'static str,
    lzma2: bool,
    bytes: u64,
    max_error_codes: u16,
    /// Minimum over all frames of colour; infinite for other kinds.
    min_psnr_db: f64,
}

impl Row {
    fn line(&self) -> String {
        let Row { name, kind, lzma2, bytes, max_error_codes, min_psnr_db } = self;
        format!("{name},{kind},{lzma2},{bytes},{max_error_codes},{min_psnr_db:.3}")
    }
}

/// Returns the settings of each kind of row, by its name in the file.
fn coded() -> Vec<(&'static str, EncodeSettings)> {
    let of = |kind, codec| {
        // Fast effort is short enough for a test; its files are slightly larger.
        let depth = DepthSettings { codec, effort: Effort::Fast, ..DepthSettings::default() };
        EncodeSettings { kinds: vec![kind], depth, ..EncodeSettings::default() }
    };
    let transform = |target| EncodeSettings {
        search: SearchSettings { target, ..SearchSettings::default() },
        ..of(StreamKind::Color, DepthCodec::Boxes)
    };
    let color = || EncodeSettings {
        color_codec: ColorCodec::Cells,
        search: SearchSettings::default(),
        ..of(StreamKind::Color, DepthCodec::Boxes)
    };
    let blocks = |blocks| {
        let search = SearchSettings { effort: Effort::Fast, ..SearchSettings::default() };
        EncodeSettings { color_blocks: Some(ColorBlockSettings::new(blocks, &search)), search, ..color() }
    };
    let bc5 = of(StreamKind::Depth, DepthCodec::BoxesInBlocks);
    let temporal = TemporalSettings { epsilon: 100, ..bc5.temporal };
    let bc1 = of(StreamKind::Material, DepthCodec::Boxes);
    vec![
        ("color", color()),
        ("color-transform", transform(Target::Psnr(40.0))),
        ("color-transform-quality", transform(ColorCodec::Transform.usual_target())),
        ("color-bc1", blocks(ColorBlocks::Bc1)),
        ("color-bc7", blocks(ColorBlocks::Bc7)),
        ("depth", of(StreamKind::Depth, DepthCodec::Boxes)),
        ("depth-quadtree", of(StreamKind::Depth, DepthCodec::Quadtree)),
        ("depth-bc5", EncodeSettings { temporal, ..bc5 }),
        ("material", of(StreamKind::Material, DepthCodec::Boxes)),
        ("material-bc1", EncodeSettings { material: MaterialSettings { epsilon: 8, in_blocks: true }, ..bc1 }),
    ]
}

fn measure(name: &str, folder: &Path) -> Vec<Row> {
    // Baselines of panoramas have faces of a quarter of the width.
    let manifest = Manifest::read(folder).unwrap();
    let face_size = (manifest.projection == Projection::Equirect).then_some(manifest.size[0] / 4);
    let source = Source::open(folder, &SourceOptions { face_size, ..SourceOptions::default() }).unwrap();
    let mut rows = Vec::new();
    for (label, settings) in coded() {
        let kind = settings.kinds[0];
        if source.groups().iter().all(|group| group.kind != kind) {
            continue;
        }
        // LZMA2 takes most of the time. It has the same effect on all texture blocks, and none on transform coefficients.
        let levels = if label.contains("-bc") || label.contains("-transform") { &[None][..] } else { &[None, Some(6)] };
        for &lzma2 in levels {
            let settings =
                EncodeSettings { compression: lzma2.map_or(Compression::None, Compression::Lzma2), ..settings.clone() };
            let (bytes, _) = encode(&source, &settings, Vec::new(), &Silent).unwrap();
            let (max_error_codes, min_psnr_db) = distance(&source, &bytes);
            rows.push(Row {
                name: name.into(),
                kind: label,
                lzma2: lzma2.is_some(),
                bytes: bytes.len() as u64,
                max_error_codes,
                min_psnr_db,
            });
        }
    }
    rows
}

/// Returns the maximum error in codes of any depth or material pixel, and the minimum PSNR in dB of any colour image.
fn distance(source: &Source, container: &[u8]) -> (u16, f64) {
    let decoder = Decoder::new(Reader::from_memory(container.to_vec()).unwrap()).unwrap();
    let table = EncodeTable::new(&ToneMap::default());
    let (mut worst, mut lowest) = (0, f64::INFINITY);
    for stream in decoder.streams() {
        let same = |group: &&footage::dataset::source::SourceGroup| {
            (group.kind, group.probe) == (stream.kind, stream.probe) && group.faces.contains(&stream.face)
        };
        let group = source.groups().iter().find(same).unwrap();
        let at = group.faces.iter().position(|face| *face == stream.face).unwrap();
        let mut face = decoder.face(stream);
        for frame in stream.frames.iter() {
            match face.decode(frame).unwrap() {
                Picture::Depth(codes) => {
                    let CodecHeader::Depth(header) = &stream.header else { panic!("a depth header") };
                    let wanted = source.read_depth(group, frame).unwrap()[at].map(|&z| header.range.code(z));
                    let errors = wanted.data().iter().zip(codes.data()).map(|(a, b)| a.abs_diff(*b));
                    worst = worst.max(errors.max().unwrap());
                }
                Picture::Color8(shown) => {
                    let (wanted, _) = convert::color_codes(&source.read_color(group, frame).unwrap()[at], &table);
                    let error = SquaredError::of_u8(wanted.data().as_flattened(), shown.data().as_flattened()).unwrap();
                    lowest = lowest.min(error.psnr_db());
                }
                Picture::Material(codes) => {
                    let wanted = convert::material_codes(&source.read_material(group, frame).unwrap()[at]).unwrap();
                    let pairs = wanted.data().as_flattened().iter().zip(codes.data().as_flattened());
                    worst = worst.max(pairs.map(|(a, b)| u16::from(a.abs_diff(*b))).max().unwrap());
                }
                Picture::ColorHalf(_) | Picture::Alpha(_) => panic!("8-bit colour was asked for, and no alpha"),
            }
        }
    }
    (worst, lowest)
}

fn demo() -> Vec<Row> {
    let folder = tempfile::tempdir().unwrap();
    let plan = FootagePlan { kind: DemoKind::Courtyard, frames: 12, face_size: 64, probes: 1 };
    plan.write(folder.path(), &Silent).unwrap();
    measure("demo", folder.path())
}

/// Data sets, the quickest first.
const SETS: [&str; 6] = ["equirect", "object", "glass", "sponza1k", "sponza9", "sponza"];
/// Number of data sets that are measured unless all tests run.
const SHORT: usize = 3;

#[cfg(footage_at_hand)]
fn shared(sets: &[&str]) -> Vec<Row> {
    let data = PathBuf::from(env!("LIGHTFOLD_DATA"));
    sets.iter().flat_map(|name| measure(name, &data.join(name))).collect()
}

#[cfg(not(footage_at_hand))]
fn shared(_: &[&str]) -> Vec<Row> {
    let _: Option<PathBuf> = None;
    Vec::new()
}

fn check(rows: &[Row]) {
    let text = std::fs::read_to_string(FILE).unwrap();
    assert_eq!(text.lines().next(), Some(HEAD));
    for row in rows {
        println!("{}", row.line());
        let key = format!("{},{},{},", row.name, row.kind, row.lzma2);
        let line = text.lines().find(|line| line.starts_with(&key)).unwrap_or_else(|| panic!("{key} has no baseline"));
        let numbers: Vec<f64> = line[key.len()..].split(',').map(|number| number.parse().unwrap()).collect();
        // The encoders of these blocks depend slightly on the processor's instruction set (formats/blocks.md 9).
        let varies = row.kind.ends_with("-bc1") || row.kind.ends_with("-bc7");
        let slack = if varies { 1.01 } else { 1.0 };
        assert!(row.bytes as f64 <= numbers[0] * slack, "{key} {} bytes are more than {}", row.bytes, numbers[0]);
        assert!(f64::from(row.max_error_codes) <= numbers[1], "{key} an error of {} codes", row.max_error_codes);
        // The file has three decimals.
        let slack = if varies { 0.5 } else { 0.0005 };
        assert!(row.min_psnr_db >= numbers[2] - slack, "{key} {} dB are less than {}", row.min_psnr_db, numbers[2]);
    }
}

#[test]
fn the_demo_costs_no_more_and_is_no_worse() {
    check(&demo());
}

#[test]
#[cfg_attr(not(footage_at_hand), ignore = "no footage at hand: see LIGHTFOLD_DATA in CONTRIBUTING.md")]
fn real_footage_costs_no_more_and_is_no_worse() {
    let names = if cfg!(all_tests) { &SETS[..] } else { &SETS[..SHORT] };
    let rows = shared(names);
    let text = std::fs::read_to_string(FILE).unwrap();
    let expected = text.lines().filter(|line| names.iter().any(|name| line.starts_with(&format!("{name},"))));
    assert_eq!(rows.len(), expected.count());
    check(&rows);
}

#[test]
#[ignore = "writes tests/baselines"]
fn write_baselines() {
    let mut text = format!("{HEAD}\n");
    for row in demo().iter().chain(&shared(&SETS)) {
        writeln!(text, "{}", row.line()).unwrap();
    }
    std::fs::write(FILE, text).unwrap();
}
