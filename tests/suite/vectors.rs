//! Frozen containers (tests/vectors/README.md): `valid/` decode to the images whose CRC-32s lie beside them, in this library
//! and in `decode.py`, which was written from the documents alone; `invalid/` and `limits/` are refused for their reasons.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Arc;

use half::f16;
use lightfold::Error;
use lightfold::color::cells::builder::CellBuilder;
use lightfold::color::{HalfKey, SearchSettings};
use lightfold::container::{Compression, Index, PayloadKind, Reader, Storage, Writer, compression};
use lightfold::decode::Decoder;
use lightfold::depth::TemporalSettings;

use crate::samples::{self, Random, Shape, Stream};
use crate::{vectors_of_blocks, vectors_of_indices, vectors_of_limits, vectors_of_nodes, vectors_of_transforms};

fn folder(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/vectors").join(name)
}

/// The containers of a folder, by name.
fn frozen(name: &str) -> Vec<PathBuf> {
    let mut files: Vec<_> = fs::read_dir(folder(name)).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.retain(|path| path.extension().is_some_and(|extension| extension == "lfold"));
    files.sort();
    files
}

pub fn crc_line(stream: u32, frame: u32, image: &[u8]) -> String {
    format!("{stream} {frame} {:08x}\n", crc32fast::hash(image))
}

fn decode_in_order(decoder: &Decoder) -> String {
    let mut lines = String::new();
    for stream in decoder.streams() {
        let mut face = decoder.face(stream);
        for frame in stream.frames.iter() {
            lines += &crc_line(stream.index, frame, &samples::image_bytes(&face.decode(frame).unwrap()));
        }
    }
    lines
}

fn decode_in_any_order(decoder: &Decoder, seed: u64) -> String {
    let mut random = Random(seed);
    let mut lines = String::new();
    for stream in decoder.streams() {
        let mut face = decoder.face(stream);
        let count = stream.entry.frame_count;
        let mut of_frame = vec![String::new(); count as usize];
        let wanted: Vec<u32> = (0..2 * count).map(|_| random.below(count)).chain((0..count).rev()).collect();
        for at in wanted {
            let frame = stream.frames.first + at;
            let line = crc_line(stream.index, frame, &samples::image_bytes(&face.decode(frame).unwrap()));
            let held = &mut of_frame[at as usize];
            assert!(held.is_empty() || *held == line, "stream {} frame {frame}", stream.index);
            *held = line;
        }
        lines += &of_frame.concat();
    }
    lines
}

#[test]
fn valid_vectors_decode_to_their_images_in_any_order() {
    let files = frozen("valid");
    let expected: BTreeSet<_> = valid().into_iter().map(|(name, _)| format!("{name}.lfold")).collect();
    let found: BTreeSet<_> = files.iter().map(|path| path.file_name().unwrap().to_str().unwrap().to_owned()).collect();
    assert_eq!(found, expected, "tests/vectors/valid is not what the list in this file says");
    for path in files {
        let said = fs::read_to_string(path.with_extension("crc")).unwrap();
        let bytes = fs::read(&path).unwrap();
        assert!(bytes.len() < 64 << 10, "{} has {} bytes", path.display(), bytes.len());
        let decoder = Decoder::open(&path).unwrap();
        assert_eq!(decode_in_order(&decoder), said, "{}", path.display());
        for seed in 0..4 {
            assert_eq!(decode_in_any_order(&decoder, seed), said, "{}", path.display());
        }
        let in_memory = Decoder::new(Reader::from_memory(bytes).unwrap()).unwrap();
        assert_eq!(decode_in_order(&in_memory), said, "{}", path.display());
    }
}

/// Runs decode.py; answers what it printed, and the refusals that it wrote.
pub fn python(paths: &[PathBuf]) -> (String, String) {
    let script = folder("decode.py");
    let output = ["python3", "python"]
        .iter()
        .find_map(|python| Command::new(python).arg(&script).args(paths).output().ok())
        .expect("this test runs tests/vectors/decode.py: install Python 3 so that `python3` can be found");
    let text = |bytes| String::from_utf8(bytes).unwrap().replace("\r\n", "\n");
    let (printed, refusals) = (text(output.stdout), text(output.stderr));
    assert!(matches!(output.status.code(), Some(0 | 2)), "decode.py broke: {refusals}");
    (printed, refusals)
}

#[test]
fn the_decoder_written_from_the_documents_agrees() {
    let files = frozen("valid");
    let said = files.iter().map(|path| fs::read_to_string(path.with_extension("crc")).unwrap());
    assert_eq!(python(&files), (said.collect(), String::new()));

    let files = frozen("invalid");
    let (printed, refusals) = python(&files);
    assert_eq!(printed, "");
    for path in files {
        let name = path.display().to_string();
        assert!(refusals.lines().any(|line| line.starts_with(&name)), "decode.py takes {name}");
    }
}

#[test]
fn invalid_vectors_are_refused_for_their_reason() {
    let files = [frozen("invalid"), frozen("limits")].concat();
    assert_eq!(
        files.len(),
        invalid().len(),
        "tests/vectors/invalid and limits are not what the list in this file says"
    );
    let mut wrong = Vec::new();
    for path in files {
        let reason = fs::read_to_string(path.with_extension("txt")).unwrap();
        let message = match samples::decode_all(fs::read(&path).unwrap()) {
            Err(error @ (Error::Invalid { .. } | Error::Unsupported { .. })) => error.to_string(),
            Err(error) => format!("another kind of error: {error}"),
            Ok(_) => "it is taken".into(),
        };
        if !message.contains(reason.trim_end()) {
            wrong.push(format!("{}: {message}", path.display()));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Writes all vectors anew: for a new format version, or to add one. Frozen files must not change otherwise.
#[test]
#[ignore = "writes tests/vectors"]
fn regenerate_vectors() {
    for name in ["valid", "invalid", "limits"] {
        fs::create_dir_all(folder(name)).unwrap();
        for entry in fs::read_dir(folder(name)).unwrap() {
            fs::remove_file(entry.unwrap().path()).unwrap();
        }
    }
    write(valid(), invalid());
}

/// Writes the vectors of the transform codec anew, which are made with the built-in entropy tables.
#[test]
#[ignore = "writes tests/vectors"]
fn regenerate_transform_vectors() {
    write(vectors_of_transforms::valid(), vectors_of_transforms::invalid());
}

fn write(valid: Vec<(&str, Vec<u8>)>, invalid: Vec<(&str, Vec<u8>, &str)>) {
    for (name, bytes) in valid {
        let path = folder("valid").join(name);
        let decoder = Decoder::new(Reader::from_memory(bytes.clone()).unwrap()).unwrap();
        fs::write(path.with_extension("crc"), decode_in_order(&decoder)).unwrap();
        fs::write(path.with_extension("lfold"), bytes).unwrap();
    }
    for (name, bytes, reason) in invalid {
        let limits = vectors_of_limits::ONLY_TOO_LARGE.contains(&name);
        let path = folder(if limits { "limits" } else { "invalid" }).join(name);
        fs::write(path.with_extension("txt"), format!("{reason}\n")).unwrap();
        fs::write(path.with_extension("lfold"), bytes).unwrap();
    }
}

fn temporal(window: u8, epsilon: u16, max_aabbs: u16, keyframe_interval: u32) -> TemporalSettings {
    TemporalSettings { window, epsilon, max_aabbs, keyframe_interval }
}

pub fn shape(face: u8, size: [u32; 2], unit: [u32; 2], first_frame: u32, frame_count: u32) -> Shape {
    Shape { face, size, unit, first_frame, frame_count }
}

pub fn one(stream: Stream) -> Vec<u8> {
    samples::container(0, samples::probe("00", 40), &[stream], Compression::None)
}

fn f16s(values: [f32; 3]) -> [f16; 3] {
    values.map(f16::from_f32)
}

fn keys(values: &[f32]) -> Vec<HalfKey> {
    values.iter().map(|&value| HalfKey::from_bits(f16::from_f32(value).to_bits())).collect()
}

/// 8-bit cells in which every way to make a frame occurs.
pub fn closing_cells() -> Vec<CellBuilder> {
    let mut first = CellBuilder::default();
    first.push_keyframe::<u8>(&[0, 255, 10, 1, 128, 77]);
    first.push_weight(0, 2);
    first.push_keyframe::<u8>(&[255, 0, 200, 2, 127, 77]);
    first.push_weight(1, 1);
    first.push_weight(128, 2);
    first.push_weight(255, 1);
    let mut second = CellBuilder::default();
    second.push_keyframe::<u8>(&[9, 8, 7, 6, 5, 4]);
    second.push_weight(17, 1);
    second.push_weight(0, 1);
    second.push_keyframe::<u8>(&[200, 200, 200, 0, 0, 0]);
    second.push_keyframe::<u8>(&[1, 1, 1, 250, 250, 250]);
    second.push_weight(77, 1);
    let mut third = CellBuilder::default();
    third.push_keyframe::<u8>(&[50, 60, 70, 80, 90, 100]);
    third.push_weight(0, 2);
    vec![first, second, third]
}

/// Name and bytes of every valid vector.
fn valid() -> Vec<(&'static str, Vec<u8>)> {
    let moving = |size, count, seed| samples::moving_codes(size, count, seed);
    let search = |min_psnr_db| SearchSettings { min_psnr_db, ..SearchSettings::default() };
    let mut all = Vec::new();

    let size = [17, 9];
    let frames = moving(size, 20, 1);
    all.push(("depth-w1-epsilon", {
        let settings = temporal(1, 3, 8, 12);
        one(samples::depth(shape(0, size, [8, 8], 5, 20), [0.25, 100.0], &frames, settings))
    }));
    all.push(("depth-w3-boxes", {
        let settings = temporal(3, 2, 256, 100);
        one(samples::depth(shape(4, size, [16, 16], 0, 20), [0.25, 100.0], &frames, settings))
    }));
    all.push(("depth-w255-lossless", {
        let settings = temporal(255, 0, 1, 7);
        one(samples::depth(shape(5, size, [5, 3], 0, 20), [0.25, 100.0], &frames, settings))
    }));
    all.push(("depth-odd-sizes", {
        let stream = |face: u8, size: [u32; 2], unit| {
            let settings = temporal(2, 1, 4, 6);
            let images = moving(size, 9, u64::from(face) + 3);
            samples::depth(shape(face, size, unit, 2, 9), [1.0, 2.0], &images, settings)
        };
        let streams = [
            stream(0, [1, 1], [1, 1]),
            stream(1, [3, 5], [2, 2]),
            stream(2, [17, 9], [8, 4]),
            stream(3, [1, 17], [8, 8]),
            stream(4, [33, 1], [8, 8]),
        ];
        samples::container(0, samples::probe("odd", 10), &streams, Compression::None)
    }));
    all.push(("depth-constant-tiles-shared", {
        let image = |t: usize| (0..16 * 8).map(|at| if at == 3 && t > 3 { 9 } else { u16::MAX }).collect();
        let images: Vec<Vec<u16>> = (0..6).map(image).collect();
        let bytes = one(samples::depth(shape(0, [16, 8], [4, 4], 0, 6), [1.0, 1.0], &images, temporal(2, 0, 8, 3)));
        let (index, _) = samples::take_apart(&bytes);
        let places: BTreeSet<_> = index.chunks.iter().map(|chunk| chunk.offset).collect();
        assert!(places.len() < index.chunks.len());
        bytes
    }));
    all.push(("depth-later-records-whole-and-constant", {
        // No encoder of ours writes these, and the format allows them.
        let header = samples::depth_header([1.0, 2.0], temporal(1, 0, 8, 64));
        let mut payload = vec![];
        for value in [4u32, 0, 36, 1, 42, 3, 50, 4, 56] {
            payload.extend_from_slice(&value.to_le_bytes());
        }
        payload.extend_from_slice(&[1, 0, 0, 0, 5, 1]);
        payload.extend_from_slice(&[0, 0, 0, 0, 1, 2, 3, 4]);
        payload.extend_from_slice(&[1, 0, 0, 0, 255, 255]);
        payload.extend_from_slice(&[2, 0, 2, 0, 1, 0, 0, 0, 1, 0, 1, 0, 0, 0, 0, 0, 1, 0, 1, 0, 7, 8, 9, 10]);
        let chunk = lightfold::container::EncodedChunk { first_frame: 0, frame_count: 7, payload };
        one(Stream { entry: samples::entry(shape(0, [2, 1], [4, 4], 0, 7), &header), chunks: vec![(0, chunk)] })
    }));

    all.push(("color8-cells", {
        let images = samples::drifting_bytes(size, 30);
        one(samples::color8(shape(0, size, [8, 8], 3, 30), &images, search(40.0)))
    }));
    all.push(("color8-odd-sizes", {
        let stream = |face, size, unit| {
            samples::color8(shape(face, size, unit, 0, 16), &samples::drifting_bytes(size, 16), search(45.0))
        };
        let streams = [stream(0, [1, 1], [64, 64]), stream(3, [3, 5], [2, 3]), stream(6, [5, 3], [1, 16])];
        samples::container(0, samples::probe("a.b_c-D", 15), &streams, Compression::None)
    }));
    all.push(("color8-closed-by-next", {
        let header = samples::color8_header(&search(20.0));
        let cells = closing_cells();
        let count = cells.iter().map(CellBuilder::frame_count).sum();
        one(samples::cells_by_hand(shape(1, [2, 1], [2, 2], 7, count), &header, cells))
    }));
    all.push(("color8-flag-without-weight", {
        let header = samples::color8_header(&search(20.0));
        let mut cell = CellBuilder::default();
        cell.push_keyframe::<u8>(&[1, 2, 3]);
        cell.push_weight(0, 3);
        let bytes = one(samples::cells_by_hand(shape(1, [1, 1], [1, 1], 0, 4), &header, vec![cell]));
        samples::with_payloads(&bytes, |_, payload| payload[2] = 1)
    }));
    all.push(("half-cells-negative", {
        let image = |t: u32| -> Vec<[f16; 3]> {
            let t = t as f32;
            let pixel = |at: u32| {
                let x = at as f32 / 8.0;
                f16s([x - 3.0 + t * 0.01, (x * 0.7 + t * 0.02).exp2(), -x * 0.25 * (t - 6.0)])
            };
            (0..15).map(pixel).collect()
        };
        let images: Vec<_> = (0..16).map(image).collect();
        one(samples::color_half(shape(2, [3, 5], [2, 4], 0, 16), &images, search(45.0)))
    }));
    all.push(("half-closed-by-next", {
        let header = samples::half_header(&search(20.0));
        let mut first = CellBuilder::default();
        first.push_keyframe(&keys(&[-1.0, 0.0, 65504.0, 1e-7, f32::INFINITY, -0.0]));
        [1, 100, 254].iter().for_each(|&weight| first.push_weight(weight, 1));
        let mut second = CellBuilder::default();
        second.push_keyframe(&keys(&[1.0, -0.0, -65504.0, 1000.0, f32::NEG_INFINITY, f32::NAN]));
        second.push_weight(0, 1);
        one(samples::cells_by_hand(shape(0, [2, 1], [2, 1], 0, 6), &header, vec![first, second]))
    }));

    let materials: Vec<Vec<[u8; 3]>> = samples::drifting_bytes([9, 4], 12)
        .into_iter()
        .map(|image| image.iter().map(|p| [p[0] / 64, 0, p[2]]).collect())
        .collect();
    all.push(("material", {
        one(samples::material(shape(0, [9, 4], [8, 8], 0, 12), &materials, temporal(2, 1, 3, 5)))
    }));
    all.push(("lzma2", {
        let ramp = |t: u32| (0..256 * 192).map(|at| (at / 256 * 3 + at % 256 / 8 + t * (at / 40_000)) as u16).collect();
        let depth: Vec<Vec<u16>> = (0..3).map(ramp).collect();
        let streams = [
            samples::depth(shape(0, [256, 192], [256, 192], 0, 3), [1.0, 50.0], &depth, temporal(2, 0, 8, 64)),
            samples::color8(shape(0, [48, 24], [32, 16], 0, 4), &vec![vec![[5, 6, 7]; 48 * 24]; 4], search(50.0)),
            samples::material(shape(0, [9, 4], [16, 16], 0, 12), &materials, temporal(1, 0, 8, 64)),
        ];
        let bytes = samples::container(0, samples::probe("00", 11), &streams, Compression::Lzma2(9));
        let (index, _) = samples::take_apart(&bytes);
        assert!(index.chunks.iter().filter(|chunk| chunk.storage == Storage::Lzma2).count() >= 3);
        bytes
    }));
    all.push(("perspective", {
        let mut probe = samples::probe("view", 8);
        probe.orientation = [0.5, -0.5, 0.5, 0.5];
        probe.intrinsics = [20.5, 20.25, 8.5, 4.5];
        let streams = [
            samples::color8(shape(6, size, [8, 8], 0, 9), &samples::drifting_bytes(size, 9), search(40.0)),
            samples::depth(shape(6, size, [16, 8], 0, 9), [0.1, 9.0], &moving(size, 9, 8), temporal(2, 0, 8, 64)),
            samples::material(shape(6, [9, 4], [8, 8], 0, 12), &materials, temporal(2, 0, 8, 64)),
        ];
        samples::container(1, probe, &streams, Compression::None)
    }));
    all.push(("empty", Writer::new(Vec::new(), "nothing", 0.1, 0).unwrap().finish().unwrap().0));
    all.push(("minor-version-of-later", {
        let mut bytes = base();
        bytes[10] = 9;
        bytes
    }));
    all.extend(vectors_of_nodes::valid());
    all.extend(vectors_of_blocks::valid());
    all.iter_mut().for_each(|(_, bytes)| *bytes = samples::in_rows(std::mem::take(bytes)));
    all.extend(vectors_of_indices::valid());
    all.extend(vectors_of_transforms::valid());
    all
}

/// What the invalid vectors are made of. Chunks: 0 and 1 depth, 2 and 3 8-bit colour, 4 half colour, 5 material.
fn base() -> Vec<u8> {
    let search = SearchSettings::default();
    let depth: Vec<Vec<u16>> = (0..4).map(|t| (0..6).map(|at| at * 100 + t * (at % 2)).collect()).collect();
    let mut cells = vec![CellBuilder::default(), CellBuilder::default()];
    cells[0].push_keyframe::<u8>(&[1, 2, 3, 4, 5, 6]);
    cells[0].push_weight(9, 1);
    cells[0].push_keyframe::<u8>(&[6, 5, 4, 3, 2, 1]);
    cells[0].push_weight(8, 1);
    cells[1].push_keyframe::<u8>(&[7, 7, 7, 8, 8, 8]);
    let mut half = CellBuilder::default();
    half.push_keyframe(&keys(&[0.5, 1.0, -2.0]));
    half.push_weight(0, 1);
    let streams = [
        samples::depth(shape(0, [3, 2], [8, 8], 0, 4), [1.0, 4.0], &depth, temporal(1, 0, 2, 2)),
        samples::cells_by_hand(shape(0, [2, 1], [4, 4], 0, 5), &samples::color8_header(&search), cells),
        samples::cells_by_hand(shape(1, [1, 1], [1, 1], 0, 2), &samples::half_header(&search), vec![half]),
        samples::material(shape(0, [2, 2], [8, 8], 0, 1), &[vec![[1, 2, 3]; 4]], temporal(1, 0, 1, 1)),
    ];
    samples::in_rows(samples::container(0, samples::probe("00", 4), &streams, Compression::None))
}

/// Name, bytes and a part of the message of every invalid vector.
fn invalid() -> Vec<(&'static str, Vec<u8>, &'static str)> {
    let good = base();
    let size = good.len();
    let (index, stored) = samples::take_apart(&good);
    assert_eq!(index.chunks.len(), 6);
    let mut all: Vec<(&'static str, Vec<u8>, &'static str)> = Vec::new();
    let byte = |at: usize, value: u8| {
        let mut bytes = good.clone();
        bytes[at] = value;
        bytes
    };
    all.push(("file-empty", vec![], "8 more bytes expected, 0 left"));
    all.push(("file-is-other", b"PK\x03\x04 and something else".to_vec(), "this is not a lightfold container"));
    all.push(("file-cut-in-head", good[..12].to_vec(), "4 more bytes expected, 0 left"));
    all.push(("file-cut-after-head", good[..20].to_vec(), "the container ends after its head"));
    all.push(("file-cut-in-chunks", good[..100].to_vec(), "the container has no foot"));
    all.push(("file-cut-in-foot", good[..size - 1].to_vec(), "the container has no foot"));
    all.push(("file-longer-by-one", [&good[..16], &[0], &good[16..]].concat(), "the foot speaks of a file of"));
    all.push(("head-magic", byte(1, b'l'), "its first 8 bytes are other"));
    all.push(("head-major-version", byte(8, 2), "the container has format version 2"));
    all.push(("head-reserved", byte(15, 1), "a reserved byte is not zero"));
    all.push(("foot-magic", byte(size - 1, b'X'), "the container has no foot"));
    all.push(("foot-crc", byte(size - 40, good[size - 40] ^ 1), "the foot's CRC-32 does not match"));
    let foot = |change: fn(&mut [u8])| {
        let mut foot = good[size - 40..].to_vec();
        change(&mut foot);
        [&good[..size - 40], &samples::foot_end(foot)].concat()
    };
    all.push(("foot-reserved", foot(|foot| foot[20] = 1), "projection 4 is unknown"));
    all.push(("foot-reserved-of-compact", foot(|foot| foot[21] = 1), "a reserved byte is not zero"));
    all.push(("foot-index-form", foot(|foot| foot[20] = 2), "the index has form 2, which is unknown"));
    all.push(("foot-file-size", foot(|foot| foot[26] = 1), "the foot speaks of a file of"));
    all.push(("foot-index-elsewhere", foot(|foot| foot[0] -= 1), "the index does not lie between the chunks"));
    all.push(("foot-index-in-head", foot(|foot| foot[..8].fill(0)), "the index does not lie between the chunks"));
    all.push(("foot-index-wraps", foot(|foot| foot[..16].fill(0xff)), "the index does not lie between the chunks"));
    all.push(("index-crc", byte(size - 50, good[size - 50] ^ 1), "the index's CRC-32 does not match"));

    let patched = |change: &dyn Fn(&mut Vec<u8>)| samples::assemble(&index, &stored, change);
    let counts = "do not fit into the rest of the index";
    all.push(("index-probe-count", patched(&|bytes| bytes[..4].fill(0xff)), counts));
    all.push(("index-stream-count", patched(&|bytes| bytes[4..8].fill(0xff)), counts));
    all.push(("index-chunk-count", patched(&|bytes| bytes[8..12].fill(0xff)), counts));
    all.push(("index-projection", patched(&|bytes| bytes[12] = 2), "projection 2 is unknown"));
    all.push(("index-reserved", patched(&|bytes| bytes[14] = 1), "a reserved byte is not zero"));
    all.push(("index-name-not-utf8", patched(&|bytes| bytes[26] = 0xff), "the dataset's name is not UTF-8"));
    all.push(("index-name-too-long", patched(&|bytes| bytes[24..26].fill(0xff)), "65535 more bytes expected"));
    all.push(("index-trailing-byte", patched(&|bytes| bytes.push(0)), "1 bytes after the last field"));
    all.push(("index-cut", patched(&|bytes| bytes.truncate(60)), counts));
    let chunk_row = |row: usize, at: usize, value: u8| {
        patched(&move |bytes: &mut Vec<u8>| {
            let start = bytes.len() - 40 * (6 - row);
            bytes[start + at] = value;
        })
    };
    all.push(("chunk-storage", chunk_row(2, 36, 2), "a chunk is stored by method 2"));
    all.push(("chunk-reserved", chunk_row(2, 39, 1), "a reserved byte is not zero"));

    let edited = |change: fn(&mut Index)| {
        let mut index = index.clone();
        change(&mut index);
        samples::assemble(&index, &stored, |_| ())
    };
    all.push(("index-fps-zero", edited(|i| i.fps = 0.0), "a frame rate of 0 is not positive"));
    all.push(("index-fps-nan", edited(|i| i.fps = f64::NAN), "the frame rate is NaN"));
    all.push(("probe-name-path", edited(|i| i.probes[0].name = "../up".into()), "the probe name \"../up\""));
    all.push(("probe-name-empty", edited(|i| i.probes[0].name = String::new()), "the probe name \"\""));
    all.push(("probe-name-hidden", edited(|i| i.probes[0].name = ".a".into()), "the probe name \".a\""));
    all.push(("probe-twice", edited(|i| i.probes.push(i.probes[0].clone())), "two probes are named '00'"));
    all.push(("probe-frames", edited(|i| i.probes[0].frames = [3, 2]), "is active from frame 3 to 2"));
    all.push(("probe-frames-beyond", edited(|i| i.probes[0].frames = [0, 1 << 31]), "is active from frame 0 to"));
    all.push(("probe-position", edited(|i| i.probes[0].position[1] = f64::INFINITY), "position or orientation is inf"));
    all.push(("probe-orientation", edited(|i| i.probes[0].orientation[3] = f64::NAN), "orientation is NaN"));
    all.push(("probe-intrinsics", edited(|i| i.probes[0].intrinsics[0] = f64::NAN), "a probe's intrinsics is NaN"));
    all.push(("stream-kind", edited(|i| i.streams[0].kind = 3), "a stream of kind 3 and face 0 is unknown"));
    all.push(("stream-face", edited(|i| i.streams[0].face = 7), "a stream of kind 1 and face 7 is unknown"));
    all.push(("stream-probe", edited(|i| i.streams[0].probe = 1), "a stream names probe 1, the file has 1"));
    all.push(("stream-no-width", edited(|i| i.streams[0].width = 0), "each must be 1 to 16384"));
    all.push(("stream-too-high", edited(|i| i.streams[0].height = 16_385), "each must be 1 to 16384"));
    all.push(("stream-no-unit", edited(|i| i.streams[0].unit_width = 0), "each must be 1 to 16384"));
    all.push(("stream-unit-too-wide", edited(|i| i.streams[0].unit_width = u32::MAX), "each must be 1 to 16384"));
    all.push(("stream-no-frames", edited(|i| i.streams[0].frame_count = 0), "a stream of 0 frames"));
    all.push(("stream-frames-beyond", edited(|i| i.streams[0].first_frame = u32::MAX), "from frame 4294967295 on"));
    all.push(("stream-twice", edited(|i| i.streams[3].kind = 1), "stream 3 has the kind, probe and face"));
    all.push(("stream-codec", edited(|i| i.streams[0].codec = *b"DQUA"), "uses codec 'DQUA'"));
    all.push(("stream-codec-of-other-kind", edited(|i| i.streams[0].codec = *b"MAAB"), "uses codec 'MAAB'"));
    all.push((
        "stream-larger-than-justified",
        edited(|i| {
            let stream = &mut i.streams[0];
            [stream.width, stream.height, stream.unit_width, stream.unit_height] = [16_384; 4];
        }),
        "more than a file of",
    ));
    all.push(("dataset-name-control", edited(|i| i.name = "a\u{1b}[2J".into()), "control characters"));
    let coverage = "the chunk table breaks off";
    all.push(("stream-more-units", edited(|i| i.streams[0].unit_width = 2), coverage));
    all.push(("chunk-missing", edited(|i| i.chunks.truncate(5)), coverage));
    all.push(("chunk-extra", edited(|i| i.chunks.push(i.chunks[5])), coverage));
    all.push(("chunk-order", edited(|i| i.chunks.swap(0, 1)), coverage));
    all.push(("chunk-gap", edited(|i| i.chunks[1].key.first_frame = 3), coverage));
    all.push(("chunk-overlap", edited(|i| i.chunks[0].key.frame_count = 3), coverage));
    all.push(("chunk-no-frames", edited(|i| i.chunks[0].key.frame_count = 0), coverage));
    all.push(("chunk-beyond-stream", edited(|i| i.chunks[1].key.frame_count = u32::MAX), coverage));
    all.push(("chunk-unit", edited(|i| i.chunks[0].key.unit = 1), coverage));
    all.push(("chunk-stream", edited(|i| i.chunks[5].key.stream = 4), coverage));
    let outside = "lies outside the file's chunks";
    all.push(("chunk-in-head", edited(|i| i.chunks[0].offset = 15), outside));
    all.push(("chunk-in-index", edited(|i| i.chunks[5].stored_bytes += 1), outside));
    all.push(("chunk-offset-wraps", edited(|i| i.chunks[0].offset = u64::MAX), outside));
    let sizes = "cannot mean";
    all.push(("chunk-raw-sizes-differ", edited(|i| i.chunks[0].raw_bytes += 1), sizes));
    let bomb: fn(&mut Index) = |i| {
        i.chunks[0].storage = Storage::Lzma2;
        i.chunks[0].raw_bytes = i.chunks[0].stored_bytes * 16_384 + 1;
    };
    all.push(("chunk-expansion", edited(bomb), sizes));
    let large: fn(&mut Index) = |i| {
        i.chunks[0].storage = Storage::Lzma2;
        i.chunks[0].raw_bytes = (1 << 30) + 1;
    };
    all.push(("chunk-too-large", edited(large), sizes));
    all.push(("chunk-crc", byte(20, good[20] ^ 1), "chunk at byte 16: its CRC-32 does not match"));
    let not_lzma2: fn(&mut Index) = |i| i.chunks[0].storage = Storage::Lzma2;
    all.push(("lzma2-damaged", edited(not_lzma2), "the chunk's LZMA2 stream"));

    let mut smooth = compression::lzma2(&[7; 3000], 6, PayloadKind::Mixed).unwrap();
    let lzma2 = |stored: &[u8], raw_bytes: u32| {
        let mut index = index.clone();
        let chunk = &mut index.chunks[0];
        chunk.offset = 16;
        chunk.storage = Storage::Lzma2;
        (chunk.stored_bytes, chunk.raw_bytes, chunk.crc32) = (stored.len() as u32, raw_bytes, crc32fast::hash(stored));
        for (at, other) in index.chunks.iter_mut().enumerate().skip(1) {
            (other.offset, other.stored_bytes, other.raw_bytes) = (16 + at as u64, 1, 1);
        }
        samples::assemble(&index, stored, |_| ())
    };
    all.push(("lzma2-too-long", lzma2(&smooth, 2999), "does not mean the 2999 bytes"));
    all.push(("lzma2-too-short", lzma2(&smooth, 3001), "does not mean the 3001 bytes"));
    all.push(("lzma2-no-end", lzma2(&smooth[..smooth.len() - 1], 3000), "the chunk's LZMA2 stream is damaged"));
    smooth.push(0);
    all.push(("lzma2-trailing-byte", lzma2(&smooth, 3000), "1 bytes follow the end of the chunk's LZMA2 stream"));

    let header = |stream: usize, at: usize, bytes: &[u8]| {
        let mut index = index.clone();
        Arc::make_mut(&mut index.streams[stream].codec_header)[at..at + bytes.len()].copy_from_slice(bytes);
        samples::assemble(&index, &stored, |_| ())
    };
    let nan = f32::NAN.to_le_bytes();
    all.push(("depth-header-near-beyond-far", header(0, 0, &5f32.to_le_bytes()), "0 < near <= far < inf"));
    all.push(("depth-header-near-zero", header(0, 0, &[0; 4]), "0 < near <= far < inf"));
    all.push(("depth-header-far-nan", header(0, 4, &nan), "0 < near <= far < inf"));
    all.push(("depth-header-background", header(0, 8, &nan), "the background value is not a number"));
    all.push(("depth-header-measure", header(0, 12, &[2]), "depth of kind 2 is unknown"));
    all.push(("depth-header-no-window", header(0, 16, &[0]), "the depth window must be 1 to 255"));
    all.push(("depth-header-window", header(0, 16, &[0, 1]), "a depth window of 256 frames"));
    all.push(("depth-header-no-boxes", header(0, 18, &[0]), "the number of boxes must be 1 to 256"));
    all.push(("depth-header-boxes", header(0, 18, &[1, 1]), "the number of boxes must be 1 to 256"));
    all.push(("depth-header-reserved", header(0, 22, &[1]), "a reserved byte is not zero"));
    all.push(("depth-header-interval", header(0, 24, &[0; 4]), "the keyframe interval must be at least 1"));
    all.push(("material-header-window", header(3, 0, &[0]), "the depth window must be 1 to 255"));
    all.push(("color-header-psnr", header(1, 0, &f64::NAN.to_le_bytes()), "the quality is NaN"));
    all.push(("color-header-exposure", header(1, 8, &33f32.to_le_bytes()), "an exposure of 33 stops"));
    all.push(("color-header-transfer", header(1, 12, &[2]), "transfer function 2 is unknown"));
    all.push(("half-header-white", header(2, 8, &[0; 8]), "a white of 0 cd/m"));
    all.push((
        "header-longer",
        edited(|i| Arc::make_mut(&mut i.streams[2].codec_header).push(0)),
        "1 bytes after the last field",
    ));
    all.push((
        "header-shorter",
        edited(|i| Arc::make_mut(&mut i.streams[0].codec_header).truncate(27)),
        "4 more bytes expected, 3 left",
    ));

    // Payload 1 of depth: two records; the table at 4, the keyframe at 20, the boxes of frame 1 at 36.
    let payload = |chunk: usize, at: usize, bytes: &[u8]| {
        samples::with_payloads(&good, |place, payload| {
            if place == chunk {
                payload[at..at + bytes.len()].copy_from_slice(bytes);
            }
        })
    };
    all.push(("depth-no-records", payload(0, 0, &[0]), "0 records for 2 frames do not fit"));
    all.push(("depth-more-records-than-frames", payload(0, 0, &[3]), "3 records for 2 frames do not fit"));
    all.push(("depth-first-record-late", payload(0, 4, &[1]), "record 0 is for frame 1"));
    all.push(("depth-record-order", payload(0, 12, &[0]), "record 1 is for frame 0"));
    all.push(("depth-record-beyond", payload(0, 12, &[2]), "record 1 is for frame 2"));
    all.push(("depth-record-offset", payload(0, 16, &[37]), "record 1 was announced at offset 37"));
    all.push(("depth-record-kind", payload(0, 36, &[3, 0, 0]), "a record of kind 3"));
    all.push(("depth-record-reserved", payload(0, 37, &[1]), "a reserved byte is not zero"));
    all.push((
        "depth-keyframe-in-boxes",
        payload(0, 20, &[2, 0, 1, 0, 0, 0, 0, 0, 2, 0, 1, 0]),
        "must be a whole picture",
    ));
    all.push(("depth-whole-with-boxes", payload(0, 22, &[1]), "a whole picture announces boxes"));
    all.push(("depth-no-boxes", payload(0, 38, &[0]), "a record of 0 boxes"));
    all.push(("depth-too-many-boxes", payload(0, 38, &[1, 1]), "a record of 257 boxes"));
    all.push(("depth-box-outside", payload(0, 40, &[3]), "is not inside 3x2"));
    all.push(("depth-box-empty", payload(0, 44, &[0]), "is not inside 3x2"));
    all.push(("depth-payload-longer", samples::with_payloads(&good, |_, payload| payload.push(0)), "1 bytes after"));
    all.push((
        "depth-payload-shorter",
        samples::with_payloads(&good, |_, payload| payload.truncate(payload.len() - 1)),
        "expected",
    ));
    all.push((
        "depth-boxes-overlap",
        {
            samples::with_payloads(&good, |place, payload| {
                if place == 0 {
                    payload.truncate(36);
                    payload.extend_from_slice(&[2, 0, 2, 0, 0, 0, 0, 0, 2, 0, 2, 0, 1, 0, 1, 0, 2, 0, 1, 0]);
                    payload.extend_from_slice(&[0; 12]);
                }
            })
        },
        "two boxes of a record overlap",
    ));
    all.push(("color-no-keyframes", payload(2, 0, &[0]), "0 keyframes"));
    all.push(("color-more-keyframes-than-frames", payload(2, 0, &[5]), "5 keyframes"));
    all.push(("color-flags", payload(2, 2, &[2]), "flags 2"));
    all.push(("color-reserved", payload(2, 3, &[1]), "a reserved byte is not zero"));
    all.push(("color-more-weights-than-frames", payload(2, 4, &[5]), "5 weights"));
    all.push(("color-first-keyframe-late", payload(2, 8, &[1]), "keyframe 0 at frame 1"));
    all.push(("color-keyframe-order", payload(2, 12, &[0]), "keyframe 1 at frame 0"));
    all.push(("color-keyframe-beyond", payload(2, 12, &[4]), "keyframe 1 at frame 4"));
    all.push(("color-keyframe-with-weight", payload(2, 16, &[1]), "a weight stands where no two keyframes"));
    all.push(("color-weight-not-closed", payload(2, 2, &[0]), "a weight stands where no two keyframes"));
    all.push(("color-samples-missing", payload(2, 4, &[3]), "keyframes of 12 bytes expected, 13 there"));
    all.push((
        "color-last-leads-nowhere",
        {
            let mut cell = CellBuilder::default();
            cell.push_keyframe::<u8>(&[1, 2, 3]);
            cell.push_weight(7, 1);
            let header = samples::color8_header(&SearchSettings::default());
            one(samples::cells_by_hand(shape(0, [1, 1], [1, 1], 0, 2), &header, vec![cell]))
        },
        "leads to a next one, and there is none",
    ));
    all.extend(vectors_of_nodes::invalid());
    all.extend(vectors_of_blocks::invalid());
    all.extend(vectors_of_limits::invalid());
    all.extend(vectors_of_transforms::invalid());
    all.iter_mut().for_each(|(_, bytes, _)| *bytes = samples::in_rows(std::mem::take(bytes)));
    all.extend(vectors_of_indices::invalid());
    all
}
