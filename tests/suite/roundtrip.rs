//! Round trips of footage through encoder and decoder: sizes, ranges and settings that are easy to get wrong.

use std::path::Path;

use codec::color::cells::builder::CellBuilder;
use codec::color::quality::{EightBit, Pu21, Quality};
use codec::color::{SearchSettings, Target};
use codec::container::{Compression, Reader, Writer};
use codec::decode::{Decoder, OnDamage, Picture, Request, Selection, decode_units};
use codec::depth::quantise::{BACKGROUND_CODE, DepthRange};
use codec::depth::{TemporalEncoder, TemporalSettings};
use codec::effort::Effort;
use codec::image::transfer::{EncodeTable, ToneMap};
use codec::image::{Face, Plane, StreamKind};
use codec::metrics::SquaredError;
use codec::monitor::Silent;
use codec::streams::{CodecHeader, ColorFormat, DepthCoding, convert};
use footage::dataset::{InvalidDepth, SequenceLayout, Source, SourceOptions};
use footage::encode::{ColorCodec, DepthCodec, DepthSettings, EncodeSettings, ErrorBound, TileSize, encode};
use footage::image_files::exr;
use half::f16;

use crate::footage::{Footage, Random, drifting_color};
use crate::samples;

pub fn encoded(source: &Source, settings: &EncodeSettings) -> Vec<u8> {
    let (bytes, summary) = encode(source, settings, Vec::new(), &Silent).unwrap();
    assert_eq!(summary.bytes, bytes.len() as u64);
    bytes
}

pub fn decoder(bytes: &[u8]) -> Decoder {
    Decoder::new(Reader::from_memory(bytes.to_vec()).unwrap()).unwrap()
}

/// Checks that every frame of every cell of a half-float stream reaches the requested PSNR.
pub fn check_half(source: &Source, bytes: &[u8], min_psnr_db: f64) {
    let decoder = decoder(bytes);
    let (stream, metric) = (&decoder.streams()[0], Pu21::new(100.0).unwrap());
    let mut face = decoder.face(stream);
    for frame in stream.frames.iter() {
        let Picture::ColorHalf(shown) = face.decode(frame).unwrap() else { panic!("half floats expected") };
        let wanted = &source.read_color(&source.groups()[0], frame).unwrap()[0];
        for unit in 0..stream.entry.unit_count() {
            let [left, top, width, height] = stream.entry.unit_rect(unit);
            let rows = (top..top + height).map(|y| {
                let row = |plane: &Plane<[f16; 3]>| plane.row(y)[left as usize..(left + width) as usize].to_vec();
                let (squared, _) = metric.between(row(&shown).as_flattened(), row(wanted).as_flattened());
                squared
            });
            let (error, samples) = (rows.sum::<u64>(), (width * height * 3) as usize);
            assert!(error <= metric.max_squared_error(min_psnr_db, samples), "frame {frame} unit {unit}: {error}");
        }
    }
}

/// Returns depth settings of a codec with an error bound in codes.
fn depth_settings(codec: DepthCodec, bound: u16) -> DepthSettings {
    DepthSettings { codec, error: ErrorBound::Codes(bound), ..DepthSettings::default() }
}

/// Codecs that keep an error bound, with bounds in codes.
const BOUNDED: [(DepthCodec, u16); 7] = [
    (DepthCodec::Boxes, 0),
    (DepthCodec::BoxesInBlocks, 0),
    (DepthCodec::Tree, 0),
    (DepthCodec::Quadtree, 0),
    (DepthCodec::Quadtree, 100),
    (DepthCodec::Predictive, 0),
    (DepthCodec::Predictive, 100),
];

/// Checks that every depth pixel of every frame is within `epsilon` codes of its source, and that background is exact.
pub fn check_depth(source: &Source, bytes: &[u8], epsilon: u16) {
    let decoder = decoder(bytes);
    for stream in decoder.streams() {
        let CodecHeader::Depth(header) = &stream.header else { continue };
        let group = source.groups().iter().find(|group| group.faces.contains(&stream.face)).unwrap();
        let mut face = decoder.face(stream);
        for frame in stream.frames.iter() {
            let Picture::Depth(codes) = face.decode(frame).unwrap() else { panic!("depth expected") };
            let at = group.faces.iter().position(|face| *face == stream.face).unwrap();
            let plane = &source.read_depth(group, frame).unwrap()[at];
            for (at, (&z, &code)) in plane.data().iter().zip(codes.data()).enumerate() {
                let wanted = header.range.code(z);
                assert_eq!(wanted == BACKGROUND_CODE, code == BACKGROUND_CODE, "frame {frame} pixel {at}");
                assert!(wanted.abs_diff(code) <= epsilon, "frame {frame} pixel {at}: {wanted} became {code}");
            }
        }
    }
}

/// Checks that every frame of every cell of an 8-bit colour stream reaches the requested PSNR. Returns each PSNR in dB.
pub fn check_color8(source: &Source, bytes: &[u8], min_psnr_db: f64) -> Vec<f64> {
    let mut psnrs_db = Vec::new();
    let decoder = decoder(bytes);
    let table = EncodeTable::new(&ToneMap::default());
    let group = &source.groups()[0];
    for stream in decoder.streams() {
        let mut face = decoder.face(stream);
        for frame in stream.frames.iter() {
            let Picture::Color8(shown) = face.decode(frame).unwrap() else { panic!("colour expected") };
            let (wanted, _) = convert::color_codes(&source.read_color(group, frame).unwrap()[0], &table);
            for unit in 0..stream.entry.unit_count() {
                let [left, top, width, height] = stream.entry.unit_rect(unit);
                let cut = |plane: &Plane<[u8; 3]>| -> Vec<u8> {
                    (top..top + height)
                        .flat_map(|y| (left..left + width).map(move |x| (x, y)))
                        .flat_map(|(x, y)| plane.get(x, y))
                        .collect()
                };
                let (a, b) = (cut(&shown), cut(&wanted));
                let error = EightBit.squared_error(&a, &a, 0, &b, u64::MAX);
                let allowed = EightBit.max_squared_error(min_psnr_db, a.len());
                assert!(error <= allowed, "frame {frame} unit {unit}: {error} > {allowed}");
                psnrs_db.push(SquaredError::of_u8(&a, &b).unwrap().psnr_db());
            }
        }
    }
    psnrs_db
}

#[test]
fn sizes_that_are_no_multiple_of_anything() {
    for (width, height) in [(1, 1), (3, 1), (1, 7), (3, 5), (17, 9), (33, 65), (100, 3)] {
        let folder = tempfile::tempdir().unwrap();
        let mut footage = Footage::new(width, height);
        let depth = |_: Face, frame: u32| {
            Plane::from_fn(width, height, |x, y| {
                if (x + y + frame).is_multiple_of(5) { f32::INFINITY } else { 1.0 + (x * y + frame) as f32 * 0.1 }
            })
        };
        let color = |_: Face, frame: u32| drifting_color(width, height, frame);
        let material =
            |_: Face, frame: u32| Plane::from_fn(width, height, |x, _| [if x == frame { 1.0 } else { 0.0 }, 0.25, 1.5]);
        footage.depth = Some(&depth);
        let source = footage.open(folder.path());
        for (tiles, cell) in [(1, 64), (2, 4), (7, 1)] {
            for (codec, bound) in BOUNDED {
                let depth = depth_settings(codec, bound);
                let tiles = TileSize::PerSide(tiles);
                let settings = EncodeSettings { tiles, cell, depth, ..EncodeSettings::default() };
                check_depth(&source, &encoded(&source, &settings), bound);
            }
        }
        footage.depth = None;
        footage.color = Some(&color);
        let source = footage.open(folder.path());
        let codecs = [ColorCodec::Cells, ColorCodec::Transform];
        for (color_codec, cell) in codecs.into_iter().flat_map(|codec| [64, 4, 1].map(|cell| (codec, cell))) {
            let compression = Compression::Lzma2(1);
            let search = SearchSettings { target: Target::Psnr(40.0), ..SearchSettings::default() };
            let settings = EncodeSettings { color_codec, cell, compression, search, ..EncodeSettings::default() };
            check_color8(&source, &encoded(&source, &settings), settings.search.target.min_psnr_db());
        }
        footage.color = None;
        footage.material = Some(&material);
        let source = footage.open(folder.path());
        let bytes = encoded(&source, &EncodeSettings::default());
        let decoder = decoder(&bytes);
        let stream = &decoder.streams()[0];
        let mut face = decoder.face(stream);
        for frame in stream.frames.iter().rev() {
            let wanted =
                convert::material_codes(&source.read_material(&source.groups()[0], frame).unwrap()[0]).unwrap();
            assert_eq!(face.decode(frame).unwrap(), Picture::Material(wanted));
        }
    }
}

#[test]
fn ranges_from_a_single_depth_to_a_billion_and_denormals() {
    let tiny = f32::from_bits(1);
    let ranges: [&[f32]; 7] = [
        &[f32::INFINITY],
        &[2.5],
        &[1.0, 1.0 + f32::EPSILON],
        &[1e-4, 3.0, 1e5],
        &[tiny, tiny * 2.0, tiny * 900.0],
        &[tiny, 1.0, 9e9],
        &[f32::MIN_POSITIVE, 1e-30, f32::INFINITY],
    ];
    for values in ranges {
        let folder = tempfile::tempdir().unwrap();
        let depth = |_: Face, frame: u32| {
            let mut random = Random(u64::from(frame) + 1);
            Plane::from_fn(20, 12, |_, _| values[random.below(values.len() as u32) as usize])
        };
        let source = Footage { depth: Some(&depth), ..Footage::new(20, 12) }.open(folder.path());
        for (codec, bound) in BOUNDED {
            let settings = EncodeSettings { depth: depth_settings(codec, bound), ..EncodeSettings::default() };
            check_depth(&source, &encoded(&source, &settings), bound);
        }
        let depth = depth_settings(DepthCodec::Quadtree, 0);
        let bytes = encoded(&source, &EncodeSettings { depth, ..EncodeSettings::default() });
        // The minimum and maximum values are decoded to exactly the same floats.
        let decoder = decoder(&bytes);
        let CodecHeader::Depth(header) = &decoder.streams()[0].header else { panic!("depth expected") };
        let surfaces = || values.iter().copied().filter(|z| z.is_finite());
        if let (Some(near), Some(far)) = (surfaces().reduce(f32::min), surfaces().reduce(f32::max)) {
            assert_eq!([header.range.metres(0), header.range.metres(65534)], [near, far]);
        } else {
            assert_eq!(header.range, DepthRange::empty());
        }
    }
}

#[test]
fn a_creeping_pixel_stays_within_epsilon_for_600_frames_whatever_the_path() {
    let folder = tempfile::tempdir().unwrap();
    let range = DepthRange::new(1.0, 100.0).unwrap();
    let depth = |_: Face, frame: u32| {
        Plane::from_fn(8, 8, |x, y| match (x, y) {
            (0, 0) => 1.0,
            (7, 7) => 100.0,
            (3, 3) => range.metres(20_000 + frame as u16 * 3),
            (4, 4) => range.metres(40_000 - frame as u16),
            (5, 5) => {
                if frame % 50 == 49 {
                    f32::INFINITY
                } else {
                    range.metres(100 + frame as u16 % 7)
                }
            }
            _ => 10.0,
        })
    };
    let source = Footage { frames: [0, 599], depth: Some(&depth), ..Footage::new(8, 8) }.open(folder.path());
    let steps = [(1, 4, 1000), (2, 10, 1000), (16, 3, 100), (255, 50, 64)];
    let codecs =
        [(DepthCodec::Boxes, 0), (DepthCodec::BoxesInBlocks, 0), (DepthCodec::Quadtree, 0), (DepthCodec::Quadtree, 20)];
    for ((window, epsilon, keyframe_interval), (codec, bound)) in
        steps.into_iter().flat_map(|steps| codecs.map(|codec| (steps, codec)))
    {
        let temporal = TemporalSettings { window, epsilon, keyframe_interval, max_aabbs: 4 };
        let depth = depth_settings(codec, bound);
        let bytes = encoded(&source, &EncodeSettings { temporal, depth, ..EncodeSettings::default() });
        check_depth(&source, &bytes, bound + epsilon);
        // A frame decoded in random order equals that frame decoded in sequence from the start.
        let decoder = decoder(&bytes);
        let stream = &decoder.streams()[0];
        let mut playing = decoder.face(stream);
        let played: Vec<_> = stream.frames.iter().map(|frame| playing.decode(frame).unwrap()).collect();
        let mut jumping = decoder.face(stream);
        let mut random = Random(9);
        for _ in 0..200 {
            let frame = random.below(600);
            assert_eq!(jumping.decode(frame).unwrap(), played[frame as usize], "frame {frame}");
        }
    }
}

#[test]
fn high_dynamic_range_reaches_its_own_quality() {
    let folder = tempfile::tempdir().unwrap();
    let color = |_: Face, frame: u32| {
        let mut random = Random(u64::from(frame / 4));
        Plane::from_fn(40, 24, |x, y| {
            let noise = random.below(100) as f32 / 4000.0;
            let value = match (x / 10, y / 12) {
                (0, 0) => 6e-8 * (1 + frame) as f32,
                (1, 0) => 60_000.0 - frame as f32 * 32.0,
                (2, 0) => -0.25 + frame as f32 * 0.01,
                (3, _) => 1.0 + noise,
                _ => (x + frame) as f32 * 0.02,
            };
            [value, value * 0.5, value * 0.25].map(f16::from_f32)
        })
    };
    let source = Footage { frames: [0, 23], color: Some(&color), ..Footage::new(40, 24) }.open(folder.path());
    for (min_psnr_db, effort) in [(50.0, Effort::Fast), (35.0, Effort::Normal), (80.0, Effort::Exhaustive)] {
        let settings = EncodeSettings {
            cell: 10,
            color: ColorFormat::Half { white_cd_m2: 100.0 },
            search: SearchSettings { target: Target::Psnr(min_psnr_db), effort, lookahead: 16 },
            ..EncodeSettings::default()
        };
        for color_codec in [ColorCodec::Cells, ColorCodec::Transform] {
            let settings = EncodeSettings { color_codec, ..settings.clone() };
            check_half(&source, &encoded(&source, &settings), min_psnr_db);
        }
    }
}

#[test]
fn the_same_bytes_on_any_number_of_threads() {
    let folder = tempfile::tempdir().unwrap();
    let depth = |_: Face, frame: u32| Plane::from_fn(64, 48, |x, y| 1.0 + ((x + frame * 3) % 64 * (y + 1)) as f32);
    let color = |_: Face, frame: u32| drifting_color(64, 48, frame);
    let footage = Footage { frames: [3, 40], depth: Some(&depth), color: Some(&color), ..Footage::new(64, 48) };
    let source = footage.open(folder.path());
    let settings = EncodeSettings { cell: 16, compression: Compression::Lzma2(3), ..EncodeSettings::default() };
    let once = encoded(&source, &settings);
    for threads in [1, 2, 5] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        assert!(pool.install(|| encoded(&source, &settings)) == once, "{threads} threads give other bytes");
    }
}

#[test]
fn static_and_empty_footage_costs_no_pixels_after_its_first_frame() {
    let folder = tempfile::tempdir().unwrap();
    let depth = |face: Face, _: u32| match face {
        Face::Px => Plane::filled(64, 64, f32::INFINITY),
        _ => Plane::from_fn(64, 64, |x, y| 1.0 + (x * y) as f32),
    };
    let color = |face: Face, _: u32| match face {
        Face::Px => Plane::filled(64, 64, [f16::ZERO; 3]),
        _ => drifting_color(64, 64, 0),
    };
    let faces = [Face::Px, Face::Nx];
    let footage =
        Footage { frames: [0, 99], faces: &faces, depth: Some(&depth), color: Some(&color), ..Footage::new(64, 64) };
    let source = footage.open(folder.path());
    let bytes = encoded(&source, &EncodeSettings { cell: 32, ..EncodeSettings::default() });
    let decoder = decoder(&bytes);
    for stream in decoder.streams() {
        for unit in 0..stream.entry.unit_count() {
            let mut unit_decoder = decoder.unit(stream, unit);
            let first = unit_decoder.decode(0).unwrap();
            let [_, _, width, height] = stream.entry.unit_rect(unit);
            assert_eq!(first, u64::from(width * height));
            // The first frame of a later chunk is written, although its pixels do not change.
            let later: u64 = (1..100).map(|frame| unit_decoder.decode(frame).unwrap()).sum();
            let later_chunks = decoder.reader().index().unit_chunks(stream.index, unit).len() as u64 - 1;
            assert_eq!(later_chunks, if matches!(stream.header, CodecHeader::Depth(_)) { 1 } else { 4 });
            assert_eq!(later, later_chunks * first);
        }
    }
    // Stored pixels: one image of colour, one of depth, one black cell. All other units are shared or have one value.
    let pixels = 64 * 64 * 3 + 64 * 64 * 2 + 32 * 32 * 3;
    assert!(bytes.len() < pixels + 3000, "{} bytes", bytes.len());
}

#[test]
fn a_background_that_a_surface_could_have_is_decoded_as_infinity() {
    for (background, shown) in [(5.0, f32::INFINITY), (0.5, 0.5), (1000.0, 1000.0)] {
        let folder = tempfile::tempdir().unwrap();
        let depth = |_: Face, _: u32| Plane::from_fn(8, 8, |x, y| if x == y { background } else { 1.0 + x as f32 });
        let footage = Footage { frames: [0, 0], depth: Some(&depth), ..Footage::new(8, 8) };
        footage.write(folder.path());
        let options = SourceOptions { background: Some(background), ..SourceOptions::default() };
        let source = Source::open(folder.path(), &options).unwrap();
        let decoder = decoder(&encoded(&source, &EncodeSettings::default()));
        let CodecHeader::Depth(header) = &decoder.streams()[0].header else { panic!("depth expected") };
        assert_eq!(header.background, shown);
    }
}

#[test]
fn a_probe_that_sees_nothing_takes_the_bound_that_is_given() {
    let folder = tempfile::tempdir().unwrap();
    let depth = |_: Face, _: u32| Plane::filled(8, 8, f32::INFINITY);
    let source = Footage { depth: Some(&depth), ..Footage::new(8, 8) }.open(folder.path());
    for (near_m, far_m) in [(Some(5.0), None), (None, Some(3.0)), (None, None), (Some(1.0), Some(1.0))] {
        let bytes = encoded(&source, &EncodeSettings { near_m, far_m, ..EncodeSettings::default() });
        check_depth(&source, &bytes, 0);
    }
}

#[test]
fn invalid_readings_alone_are_no_nearest_surface() {
    let folder = tempfile::tempdir().unwrap();
    let depth = |_: Face, _: u32| Plane::filled(8, 8, -1.0);
    Footage { depth: Some(&depth), ..Footage::new(8, 8) }.write(folder.path());
    let options = SourceOptions { invalid_depth: InvalidDepth::Near, ..SourceOptions::default() };
    let source = Source::open(folder.path(), &options).unwrap();
    let error = encode(&source, &EncodeSettings::default(), Vec::new(), &Silent).unwrap_err().to_string();
    assert!(error.contains("`near`"), "{error}");
    let settings = EncodeSettings { near_m: Some(2.0), ..EncodeSettings::default() };
    encoded(&source, &settings);
}

#[test]
fn a_large_image_of_background_opens_again_and_what_no_reader_takes_is_not_written() {
    let (settings, side) = (TemporalSettings::default(), 1024);
    let shape = samples::Shape { face: 0, size: [8192, 8192], unit: [side, side], first_frame: 0, frame_count: 1 };
    let entry = samples::entry(shape, &samples::depth_header([1.0, 2.0], settings));
    let mut encoder = TemporalEncoder::new(side, settings);
    assert!(encoder.push(&vec![BACKGROUND_CODE; (side * side) as usize]).unwrap().is_none());
    let chunk = encoder.finish().unwrap().unwrap();
    let chunks = (0..64).map(|unit| (unit, chunk.clone())).collect();
    let file = samples::container(0, samples::probe("00", 0), &[samples::Stream { entry, chunks }], Compression::None);
    assert_eq!(decoder(&file).streams().len(), 1);

    let refused = |name: &str, probe: &str| {
        let mut writer = Writer::new(Vec::new(), name, 24.0, 0).unwrap();
        writer.add_probe(samples::probe(probe, 0)).unwrap();
        writer.finish().map(|_| ()).unwrap_err().to_string()
    };
    assert!(refused("a\u{1b}b", "00").contains("control characters"));
    assert!(refused("a", "../b").contains("could not be opened again"));
}

#[test]
fn sequential_colour_reads_each_chunk_once() {
    let search = SearchSettings::default();
    let shape = samples::Shape { face: 0, size: [2, 1], unit: [2, 1], first_frame: 0, frame_count: 9 };
    let cell = |value: u8| {
        let mut cell = CellBuilder::default();
        cell.push_keyframe::<u8>(&[value; 6]);
        cell.push_weight(if value < 30 { 128 } else { 0 }, 2);
        cell
    };
    let stream = samples::cells_by_hand(shape, &samples::color8_header(&search), [10, 20, 30].map(cell).into());
    let decoder = decoder(&samples::container(0, samples::probe("00", 8), &[stream], Compression::None));
    let mut unit = decoder.unit(&decoder.streams()[0], 0);
    (0..9).for_each(|frame| assert!(unit.decode(frame).is_ok()));
    let stored: u64 = decoder.reader().index().chunks.iter().map(|chunk| u64::from(chunk.stored_bytes)).sum();
    assert_eq!((decoder.reader().index().chunks.len(), unit.cost().bytes_read), (3, stored));
}

#[test]
fn of_two_damaged_chunks_the_first_is_named() {
    let settings = TemporalSettings::default();
    let shape = samples::Shape { face: 0, size: [8, 8], unit: [2, 2], first_frame: 0, frame_count: 1 };
    let stream = samples::depth(shape, [1.0, 2.0], &samples::moving_codes([8, 8], 1, 3), settings);
    let file = samples::container(0, samples::probe("00", 0), &[stream], Compression::None);
    let damage = |at: usize, payload: &mut Vec<u8>| payload.truncate(if [3, 12].contains(&at) { 1 } else { 1 << 20 });
    let decoder = decoder(&samples::with_payloads(&file, damage));
    let chosen = Selection::default().choose(&decoder).unwrap();
    for threads in [1, 4] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        for _ in 0..20 {
            let error = pool
                .install(|| decode_units(&decoder, Request::all(&chosen), OnDamage::Stop, &Silent))
                .unwrap_err()
                .to_string();
            assert!(error.contains("unit 3,"), "{error}");
            let error = pool.install(|| decoder.face(chosen[0].stream).decode(0)).unwrap_err().to_string();
            assert!(error.contains("unit 3,"), "{error}");
        }
    }
}

/// Writes depth as of a sensor: few distances, with noise among neighbours. Some pixels have a value that is not a valid depth.
fn sensor(folder: &Path, levels: u32, no_depth: f32) -> Source {
    let mut random = Random(5);
    for frame in 0..3 {
        let metres = |x: u32, y: u32| match (x * 5 + y * 3) % 41 {
            0 => no_depth,
            _ => 0.5 + 0.02 * ((x + y / 2 + random.below(3)) % levels) as f32,
        };
        let plane = Plane::from_fn(80, 60, metres);
        exr::write_depth(&folder.join(format!("z.{frame}.exr")), &plane).unwrap();
    }
    let (spec, layout) = (folder.join("z.%d.exr"), SequenceLayout::default());
    let options = SourceOptions { invalid_depth: InvalidDepth::Near, ..SourceOptions::default() };
    Source::from_sequence(StreamKind::Depth, spec.to_str().unwrap(), &layout, &options).unwrap()
}

/// Returns the number of levels of a predictive depth stream.
fn levels_of(bytes: &[u8]) -> usize {
    let decoder = decoder(bytes);
    let CodecHeader::Depth(header) = &decoder.streams()[0].header else { panic!("depth expected") };
    let DepthCoding::Predictive(predictive) = &header.coding else { panic!("prediction expected") };
    predictive.levels.codes().len()
}

#[test]
fn few_distances_become_levels_without_loss() {
    let folder = tempfile::tempdir().unwrap();
    let source = sensor(folder.path(), 60, f32::INFINITY);
    let levels = |settings: &EncodeSettings| {
        let bytes = encoded(&source, settings);
        check_depth(&source, &bytes, 0);
        levels_of(&bytes)
    };
    let with_bound =
        |bound| EncodeSettings { depth: depth_settings(DepthCodec::Predictive, bound), ..EncodeSettings::default() };
    // Levels are used while 2 · bound + 1 times their number is at most 65535: 1091 · 60 = 65460.
    assert_eq!([0, 100, 545].map(|bound| levels(&with_bound(bound))), [60; 3]);
    // If only one of near and far is given, all images are scanned for the other one and for levels.
    assert_eq!(levels(&EncodeSettings { near_m: Some(0.25), ..with_bound(0) }), 60);
    let mut slow = with_bound(0);
    slow.temporal.epsilon = 1;
    assert_eq!(levels_of(&encoded(&source, &slow)), 0);
    // If both are given, the images are not scanned.
    let given = EncodeSettings { near_m: Some(0.5), far_m: Some(2.0), ..with_bound(0) };
    assert_eq!(levels(&given), 0);
    let bytes = encoded(&source, &with_bound(546));
    check_depth(&source, &bytes, 546);
    assert_eq!(levels_of(&bytes), 0);
}

#[test]
fn invalid_depth_is_coded_exactly_among_levels() {
    let folder = tempfile::tempdir().unwrap();
    let with = |near_m, bound| {
        let depth = depth_settings(DepthCodec::Predictive, bound);
        EncodeSettings { near_m, depth, ..EncodeSettings::default() }
    };
    for no_depth in [0.0, f32::NAN, -1.0] {
        let source = sensor(folder.path(), 60, no_depth);
        // Invalid depth is set to near: the code of the nearest level, or a level of its own if there is no surface at near.
        for (near_m, count) in [(None, 60), (Some(0.25), 61)] {
            let bytes = encoded(&source, &with(near_m, 100));
            check_depth(&source, &bytes, 0);
            assert_eq!(levels_of(&bytes), count);
            let decoder = decoder(&bytes);
            let Picture::Depth(codes) = decoder.face(&decoder.streams()[0]).decode(1).unwrap() else { panic!() };
            assert_eq!([codes.get(0, 0), codes.get(41, 41)], [0, 0]);
        }
        let bytes = encoded(&source, &with(Some(0.25), 1000));
        check_depth(&source, &bytes, 1000);
        assert_eq!(levels_of(&bytes), 0);
    }
}
