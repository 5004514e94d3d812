//! Frozen containers (tests/vectors/README.md): those in `valid/` decode to the images whose CRC-32s are stored with them, by
//! this library and by `decode.py`, which was written from the documents alone; those in `invalid/` and `limits/` are refused for
//! the stated reasons.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use codec::color::cells::builder::CellBuilder;
use codec::color::{HalfKey, SearchSettings, Target};
use codec::container::{Compression, Reader, Storage, Writer};
use codec::decode::Decoder;
use codec::depth::TemporalSettings;
use half::f16;
use lightfold::Error;

use crate::samples::{self, Random, Shape, Stream};
use crate::{
    vectors_of_blocks, vectors_of_damage, vectors_of_indices, vectors_of_limits, vectors_of_nodes,
    vectors_of_predictive, vectors_of_transforms,
};

fn folder(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/vectors").join(name)
}

/// Returns the containers of a folder, sorted by name.
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
    assert_eq!(found, expected, "tests/vectors/valid is not what the list of vectors_of_damage.rs says");
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

/// Runs a script of tests/vectors; returns its standard output and its standard error, which lists refusals.
pub fn python(script: &str, paths: &[PathBuf]) -> (String, String) {
    let script = folder(script);
    let output = ["python3", "python"]
        .iter()
        .find_map(|python| Command::new(python).arg(&script).args(paths).output().ok())
        .expect("this test runs scripts of tests/vectors: install Python 3 so that `python3` can be found");
    let text = |bytes| String::from_utf8(bytes).unwrap().replace("\r\n", "\n");
    let (printed, refusals) = (text(output.stdout), text(output.stderr));
    assert!(matches!(output.status.code(), Some(0 | 2)), "{} broke: {refusals}", script.display());
    (printed, refusals)
}

#[test]
fn the_decoder_written_from_the_documents_agrees() {
    let files = frozen("valid");
    let said = files.iter().map(|path| fs::read_to_string(path.with_extension("crc")).unwrap());
    assert_eq!(python("decode.py", &files), (said.collect(), String::new()));

    let files = frozen("invalid");
    let (printed, refusals) = python("decode.py", &files);
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
        vectors_of_damage::invalid().len(),
        "tests/vectors/invalid and limits are not what the list of vectors_of_damage.rs says"
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

/// Rewrites all vectors, for a new format version or to add a vector. Frozen files must not change otherwise.
#[test]
#[ignore = "writes tests/vectors"]
fn regenerate_vectors() {
    for name in ["valid", "invalid", "limits"] {
        fs::create_dir_all(folder(name)).unwrap();
        for entry in fs::read_dir(folder(name)).unwrap() {
            fs::remove_file(entry.unwrap().path()).unwrap();
        }
    }
    write(valid(), vectors_of_damage::invalid());
}

/// Rewrites the vectors of the transform codec, which depend on the built-in entropy tables.
#[test]
#[ignore = "writes tests/vectors"]
fn regenerate_transform_vectors() {
    write(vectors_of_transforms::valid(), vectors_of_transforms::invalid());
}

/// Rewrites the vectors of predictive depth, which depend on the built-in entropy tables.
#[test]
#[ignore = "writes tests/vectors"]
fn regenerate_predictive_vectors() {
    write(vectors_of_predictive::valid(), vectors_of_predictive::invalid());
}

/// Rewrites the vectors of attributes.
#[test]
#[ignore = "writes tests/vectors"]
fn regenerate_attribute_vectors() {
    write(vectors_of_indices::valid_attributes(), vectors_of_indices::invalid_attributes());
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

pub fn temporal(window: u8, epsilon: u16, max_aabbs: u16, keyframe_interval: u32) -> TemporalSettings {
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

pub fn keys(values: &[f32]) -> Vec<HalfKey> {
    values.iter().map(|&value| HalfKey::from_bits(f16::from_f32(value).to_bits())).collect()
}

/// Returns 8-bit cells whose frames are made from keyframes and weights in every possible way.
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

/// Returns name and bytes of every valid vector.
fn valid() -> Vec<(&'static str, Vec<u8>)> {
    let moving = |size, count, seed| samples::moving_codes(size, count, seed);
    let search = |min_psnr_db| SearchSettings { target: Target::Psnr(min_psnr_db), ..SearchSettings::default() };
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
        // The library's encoder never writes these records, but the format allows them.
        let header = samples::depth_header([1.0, 2.0], temporal(1, 0, 8, 64));
        let mut payload = vec![];
        for value in [4u32, 0, 36, 1, 42, 3, 50, 4, 56] {
            payload.extend_from_slice(&value.to_le_bytes());
        }
        payload.extend_from_slice(&[1, 0, 0, 0, 5, 1]);
        payload.extend_from_slice(&[0, 0, 0, 0, 1, 2, 3, 4]);
        payload.extend_from_slice(&[1, 0, 0, 0, 255, 255]);
        payload.extend_from_slice(&[2, 0, 2, 0, 1, 0, 0, 0, 1, 0, 1, 0, 0, 0, 0, 0, 1, 0, 1, 0, 7, 8, 9, 10]);
        let chunk = codec::container::EncodedChunk { first_frame: 0, frame_count: 7, payload };
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
        let mut bytes = vectors_of_damage::base();
        bytes[10] = 9;
        bytes
    }));
    all.extend(vectors_of_nodes::valid());
    all.extend(vectors_of_blocks::valid());
    all.extend(vectors_of_indices::valid());
    all.extend(vectors_of_transforms::valid());
    all.extend(vectors_of_predictive::valid());
    all
}
