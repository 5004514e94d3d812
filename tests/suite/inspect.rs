//! `inspect` against brute force: its counts equal those of a decoder, and its byte counts add up to the size of the file.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use codec::color::Target;
use codec::color::cells::builder::CellBuilder;
use codec::container::{ChunkKey, Compression, PackedChunk, PayloadKind, Reader, Storage, Writer};
use codec::decode::{Decoder, Picture, Request, StreamFrames, check_windows};
use codec::depth::TemporalSettings;
use codec::image::{ColorPlane, DepthPlane, FrameRange, Plane};
use codec::memory::Budget;
use codec::monitor::Silent;
use footage::dataset::manifest::{ColorInfo, Files, MaterialChannels, MaterialInfo, Probe};
use footage::dataset::{Manifest, Projection, Source, SourceOptions, StreamKind};
use footage::encode::{ColorCodec, DepthCodec, EncodeSettings, encode};
use footage::image_files::{ColorSpace, exr};
use footage::inspect::{Check, FrameRows, InspectSettings, Inspection, inspect};
use half::f16;
use tempfile::TempDir;

use crate::input::{assert_says, message};
use crate::samples;

const SIZE: u32 = 32;
const FRAMES: u32 = 10;
/// Number of cells that change, of four cells of 16x16 pixels per face: noise fills the first cell of face px, all others are
/// static.
const MOVING_CELLS: u64 = 1;

fn noise(x: u32, y: u32, frame: u32) -> f32 {
    let mut seed = (x * 73_856_093) ^ (y * 19_349_663) ^ (frame * 83_492_791);
    seed = (seed ^ (seed >> 13)).wrapping_mul(0x5bd1_e995);
    (seed >> 24) as f32 / 255.0
}

fn color(face: &str, frame: u32) -> ColorPlane {
    Plane::from_fn(SIZE, SIZE, |x, y| {
        let still = if face == "px" { 0.25 } else { (x + 40 * y) as f32 / 2000.0 };
        let moves = face == "px" && x < 16 && y < 16;
        let value = if moves { noise(x, y, frame) } else { still };
        [value, value / 2.0, value / 4.0].map(f16::from_f32)
    })
}

/// Returns a ramp with a block that moves one pixel to the right per frame; face nz is all background.
fn depth(face: &str, frame: u32) -> DepthPlane {
    Plane::from_fn(SIZE, SIZE, |x, y| match face {
        "nz" => f32::INFINITY,
        _ if (frame + 2..frame + 7).contains(&x) && (5..9).contains(&y) => 1.5,
        _ => 2.0 + (x + y) as f32 / 10.0,
    })
}

fn dataset(kinds: &[StreamKind]) -> TempDir {
    let folder = TempDir::new().unwrap();
    let pattern = |kind: StreamKind| kinds.contains(&kind).then(|| format!("{{face}}_{}.%04d.exr", kind.name()));
    let files = Files {
        color: pattern(StreamKind::Color),
        depth: pattern(StreamKind::Depth),
        material: pattern(StreamKind::Material),
        alpha: pattern(StreamKind::Alpha),
        normal: None,
    };
    let path =
        |face: &str, kind: StreamKind, frame: u32| folder.path().join(format!("{face}_{}.{frame:04}.exr", kind.name()));
    for face in ["px", "nz"] {
        for frame in 0..FRAMES {
            for &kind in kinds {
                let path = path(face, kind, frame);
                match kind {
                    StreamKind::Color => exr::write_color(&path, &color(face, frame)),
                    StreamKind::Depth => exr::write_depth(&path, &depth(face, frame)),
                    StreamKind::Material => {
                        let plane = Plane::from_fn(SIZE, SIZE, |x, _| [if x == frame { 1.0 } else { 0.0 }, 0.0, 1.0]);
                        exr::write_material(&path, &plane, ["reflect", "refract", "ior"])
                    }
                    StreamKind::Alpha => {
                        let alpha = |x, _| f16::from_f32(if x < frame { 0.5 } else { 1.0 });
                        exr::write_alpha(&path, &Plane::from_fn(SIZE, SIZE, alpha))
                    }
                }
                .unwrap();
            }
        }
    }
    let manifest = Manifest {
        schema: None,
        lightfield: 1,
        name: "small".into(),
        fps: 24.0,
        frames: [0, FRAMES - 1],
        projection: Projection::Cubemap,
        size: [SIZE, SIZE],
        faces: None,
        faces_present: Some(vec!["px".into(), "nz".into()]),
        face_names: None,
        stereo: None,
        depth: None,
        color: Some(ColorInfo { space: Some(ColorSpace::LinearRec709), ..Default::default() }),
        material: files.material.is_some().then(|| MaterialInfo { channels: MaterialChannels::default() }),
        alpha: None,
        missing: None,
        view: None,
        files,
        probes: vec![Probe { name: "00".into(), position: Some([1.0, 2.0, 3.0]), ..Probe::default() }],
        extra: None,
    };
    std::fs::write(folder.path().join("lightfield.json"), manifest.to_json().unwrap()).unwrap();
    folder
}

fn settings() -> EncodeSettings {
    let mut settings = EncodeSettings { cell: 16, near_m: Some(1.0), far_m: Some(10.0), ..EncodeSettings::default() };
    settings.compression = Compression::None;
    settings.temporal = TemporalSettings { keyframe_interval: 4, ..settings.temporal };
    settings.color_codec = ColorCodec::Cells;
    settings.search.target = Target::Psnr(100.0);
    settings.depth.codec = DepthCodec::Boxes;
    settings
}

fn encoded(kinds: &[StreamKind], settings: &EncodeSettings) -> Vec<u8> {
    let folder = dataset(kinds);
    let source = Source::open(folder.path(), &SourceOptions::default()).unwrap();
    encode(&source, settings, Vec::new(), &Silent).unwrap().0
}

fn decoder(bytes: &[u8]) -> Decoder {
    Decoder::new(Reader::from_memory(bytes.to_vec()).unwrap()).unwrap()
}

fn inspected(decoder: &Decoder, settings: InspectSettings) -> lightfold::Result<Inspection<'_>> {
    inspect(decoder, &decoder.streams().iter().collect::<Vec<_>>(), settings, &Silent)
}

const ALL_ROWS: InspectSettings =
    InspectSettings { rows: FrameRows::All, check: Check::StopAtFirst, memory: Budget::UNLIMITED };
const LIST_ALL: InspectSettings =
    InspectSettings { rows: FrameRows::None, check: Check::ListAll, memory: Budget::UNLIMITED };

fn same_inside(a: &Picture, b: &Picture, [left, top, width, height]: [u32; 4]) -> bool {
    fn same<T: Copy + PartialEq>(a: &Plane<T>, b: &Plane<T>, columns: [u32; 2], rows: [u32; 2]) -> bool {
        (rows[0]..rows[1]).all(|y| (columns[0]..columns[1]).all(|x| a.get(x, y) == b.get(x, y)))
    }
    let (columns, rows) = ([left, left + width], [top, top + height]);
    match (a, b) {
        (Picture::Depth(a), Picture::Depth(b)) => same(a, b, columns, rows),
        (Picture::ColorHalf(a), Picture::ColorHalf(b)) => same(a, b, columns, rows),
        (Picture::Alpha(a), Picture::Alpha(b)) => same(a, b, columns, rows),
        (Picture::Color8(a), Picture::Color8(b)) | (Picture::Material(a), Picture::Material(b)) => {
            same(a, b, columns, rows)
        }
        _ => panic!("two pictures of one stream differ in kind"),
    }
}

#[test]
fn rows_of_frames_are_what_a_decoder_does() {
    let mut half = settings();
    half.color = codec::streams::ColorFormat::Half { white_cd_m2: 100.0 };
    let mut blended = settings();
    // A low target gives few keyframes, with weights between them.
    blended.search.target = Target::Psnr(6.0);
    let transform = EncodeSettings { color_codec: ColorCodec::Transform, color_chunk: 4, ..settings() };
    for settings in [settings(), half, blended, transform] {
        let bytes = encoded(&StreamKind::ALL, &settings);
        let decoder = decoder(&bytes);
        let inspection = inspected(&decoder, ALL_ROWS).unwrap();
        assert_eq!(inspection.rows.len(), 8 * FRAMES as usize);
        for stats in &inspection.streams {
            let stream = stats.stream;
            let rows: Vec<_> = inspection.rows.iter().filter(|row| row.stream.index == stream.index).collect();
            let mut units: Vec<_> = (0..stream.entry.unit_count()).map(|unit| decoder.unit(stream, unit)).collect();
            let mut face = decoder.face(stream);
            let pictures: Vec<_> = stream.frames.iter().map(|frame| face.decode(frame).unwrap()).collect();
            let never_changes = |rect: &[u32; 4]| pictures.iter().all(|other| same_inside(&pictures[0], other, *rect));
            let rects: Vec<_> = units.iter().map(|unit| unit.rect()).collect();
            let mut updates = vec![Vec::new(); units.len()];
            for (row, frame) in rows.iter().zip(stream.frames.iter()) {
                assert_eq!(row.frame, frame);
                let updated: Vec<u64> = units.iter_mut().map(|unit| unit.decode(frame).unwrap()).collect();
                assert_eq!(
                    row.cost.updated_pixels,
                    updated.iter().sum::<u64>(),
                    "{} frame {frame}",
                    stream.kind.name()
                );
                for (unit, _) in updated.iter().enumerate().filter(|(_, pixels)| **pixels > 0) {
                    updates[unit].push(frame);
                }
            }
            let sum = |count: fn(&footage::inspect::FrameCost) -> u64| -> u64 {
                rows.iter().map(|row| count(&row.cost)).sum()
            };
            assert_eq!(stats.updated_pixels, sum(|cost| cost.updated_pixels));
            assert_eq!(stats.keyframes, sum(|cost| cost.keyframe_units));
            assert_eq!(stats.aabbs, sum(|cost| cost.aabbs));
            assert_eq!(stats.storage.payload_bytes, sum(|cost| cost.bytes));
            let still: Vec<usize> = (0..rects.len()).filter(|&unit| never_changes(&rects[unit])).collect();
            // With the transform codec, a unit may be written by several blocks in time although its pixels do not change, and
            // chunks of different lengths have different bytes. Such units do not count as static.
            let is_written_once = |unit: &usize| {
                let chunks = decoder.reader().index().unit_chunks(stream.index, *unit as u32);
                updates[*unit].iter().copied().eq(chunks.iter().map(|chunk| chunk.key.first_frame))
                    && chunks
                        .iter()
                        .all(|chunk| (chunk.crc32, chunk.raw_bytes) == (chunks[0].crc32, chunks[0].raw_bytes))
            };
            let written_once = still.iter().filter(|unit| is_written_once(unit)).count();
            assert_eq!(stats.static_units, written_once as u64);
            if settings.color_codec == ColorCodec::Cells {
                assert_eq!(written_once, still.len());
            }
        }
    }
}

#[test]
fn counts_are_those_of_the_picture() {
    let bytes = encoded(&StreamKind::ALL, &settings());
    let decoder = decoder(&bytes);
    let inspection = inspected(&decoder, ALL_ROWS).unwrap();
    let of = |kind: StreamKind| inspection.streams.iter().filter(move |stats| stats.stream.kind == kind);
    let frames = u64::from(FRAMES);
    // At 100 dB every frame of noise is a keyframe; a static cell has one keyframe.
    let [px, nz]: [_; 2] = of(StreamKind::Color).collect::<Vec<_>>().try_into().unwrap();
    assert_eq!((px.keyframes, px.static_units), (MOVING_CELLS * frames + 3, 3));
    assert_eq!((px.keyframes_per_unit.min, px.keyframes_per_unit.max), (1, frames));
    assert_eq!(px.keyframes_per_unit.mean, (frames + 3) as f64 / 4.0);
    assert_eq!((nz.keyframes, nz.static_units, nz.updated_pixels), (4, 4, 32 * 32));
    // Each of the four tiles has keyframes at frames 0, 4 and 8; the block stays within the first tile.
    let [px, nz]: [_; 2] = of(StreamKind::Depth).collect::<Vec<_>>().try_into().unwrap();
    assert_eq!((px.units, px.keyframes, px.constant_units, px.static_units), (4, 12, 0, 3));
    assert_eq!((nz.units, nz.keyframes, nz.constant_units, nz.aabbs), (4, 12, 4, 0));
    assert_eq!(nz.updated_pixels, 3 * 32 * 32);
    assert!(px.aabbs > 0 && px.updated_pixels > nz.updated_pixels);
    for row in inspection.rows.iter().filter(|row| row.stream.kind == StreamKind::Depth) {
        assert_eq!(row.cost.keyframe_units, if row.frame % 4 == 0 { 4 } else { 0 });
        let boxed = row.stream.index == px.stream.index && row.frame % 4 != 0;
        assert_eq!(row.cost.aabbs > 0, boxed, "frame {}", row.frame);
    }
    assert_eq!(inspection.totals(None).frames, 8 * frames);
    assert_eq!(inspection.totals(None).raw_bytes, 2 * frames * 32 * 32 * (3 + 4 + 3 + 1));
}

#[test]
fn bytes_add_up_to_the_file_before_and_after_compression() {
    let plain = encoded(&StreamKind::ALL, &settings());
    let packed = encoded(&StreamKind::ALL, &EncodeSettings { compression: Compression::Lzma2(6), ..settings() });
    let framed = encoded(&StreamKind::ALL, &EncodeSettings { compression: Compression::Zstd(9), ..settings() });
    let mut temporal = Vec::new();
    for bytes in [&plain, &packed, &framed] {
        let decoder = decoder(bytes);
        let inspection = inspected(&decoder, LIST_ALL).unwrap();
        assert_eq!(inspection.damaged, []);
        let all = inspection.totals(None);
        assert_eq!(all.bytes + decoder.reader().overhead_bytes(), bytes.len() as u64);
        // Empty tiles and static material are stored once.
        assert!(all.shared_bytes_saved > 0);
        let of = |storage| decoder.reader().index().chunks.iter().filter(|chunk| chunk.storage == storage).count();
        assert_eq!(
            [all.lzma2_chunks, all.zstd_chunks],
            [Storage::Lzma2, Storage::Zstd].map(|method| of(method) as u64)
        );
        temporal.push((all.temporal_bytes, all.chunks));
        if bytes == &plain {
            assert_eq!((all.temporal_bytes, all.lzma2_chunks + all.zstd_chunks), (all.bytes, 0));
        } else {
            assert_eq!([all.lzma2_chunks > 0, all.zstd_chunks > 0], [bytes == &packed, bytes == &framed]);
            assert!(all.bytes < all.temporal_bytes);
        }
    }
    assert_eq!(temporal[0], temporal[1]);
    assert_eq!(temporal[0], temporal[2]);
}

#[test]
fn verification_finds_records_that_break_the_window_rule() {
    let shape = samples::Shape { face: 0, size: [8, 8], unit: [8, 8], first_frame: 3, frame_count: 6 };
    let settings = TemporalSettings { window: 1, ..TemporalSettings::default() };
    let depth = samples::depth(shape, [0.5, 8.0], &samples::moving_codes([8, 8], 6, 1), settings);
    let wide = samples::Shape { face: 1, size: [24, 8], unit: [24, 8], ..shape };
    let material = samples::material(wide, &samples::patched_materials([24, 8], 6), settings);
    let file = samples::container(0, samples::probe("00", 9), &[depth, material], Compression::None);
    let (mut index, stored) = samples::take_apart(&file);
    let check = |file: &[u8]| {
        let decoder = decoder(file);
        let frames: Vec<_> =
            decoder.streams().iter().map(|stream| StreamFrames { stream, frames: stream.frames }).collect();
        let damaged = inspected(&decoder, LIST_ALL).unwrap().damaged;
        (damaged, check_windows(&decoder, &Request::all(&frames)))
    };
    let (damaged, checked) = check(&file);
    assert!(damaged.is_empty() && checked.is_ok());
    // The same records with a larger window in both headers; depth.md 3 has the offsets of the window.
    Arc::make_mut(&mut index.streams[0].codec_header)[16] = 2;
    Arc::make_mut(&mut index.streams[1].codec_header)[0] = 2;
    let (damaged, checked) = check(&samples::assemble(&index, &stored, |_| {}));
    assert_eq!(damaged.iter().map(|damaged| damaged.chunk.key.stream).collect::<Vec<_>>(), [0, 1]);
    assert_says(&damaged[0].reason, &["does not repeat it", "depth.md 4"]);
    assert_says(&checked.unwrap_err().to_string(), &["stream 0, unit 0, frames 3-8", "does not repeat it"]);
}

#[test]
fn every_damaged_chunk_is_found_and_named() {
    let good = encoded(
        &[StreamKind::Color, StreamKind::Depth],
        &EncodeSettings { compression: Compression::Lzma2(6), ..settings() },
    );
    let chunks = decoder(&good).reader().index().chunks.clone();
    let mut users: BTreeMap<u64, Vec<_>> = BTreeMap::new();
    chunks.iter().for_each(|chunk| users.entry(chunk.offset).or_default().push(chunk.key));
    for chunk in &chunks {
        let mut bad = good.clone();
        bad[chunk.offset as usize + chunk.stored_bytes as usize / 2] ^= 0x10;
        let decoder = decoder(&bad);
        let inspection = inspected(&decoder, LIST_ALL).unwrap();
        let found: Vec<_> = inspection.damaged.iter().map(|damaged| damaged.chunk.key).collect();
        assert_eq!(found, users[&chunk.offset]);
        assert_says(&inspection.damaged[0].reason, &["CRC-32"]);
        let text = message(inspected(&decoder, ALL_ROWS));
        let key = found[0];
        assert_says(&text, &["CRC-32", &format!("stream {}, unit {}", key.stream, key.unit)]);
    }
}

#[test]
fn chunks_with_a_good_crc_and_a_bad_payload_are_found() {
    let good = encoded(&[StreamKind::Color, StreamKind::Depth], &settings());
    let decoder_of_good = decoder(&good);
    let reader = decoder_of_good.reader();
    let index = reader.index();
    let mut writer = Writer::new(Vec::new(), "bad", 24.0, 0).unwrap();
    for probe in &index.probes {
        writer.add_probe(probe.clone()).unwrap();
    }
    for stream in &index.streams {
        writer.add_stream(stream.clone());
    }
    let spoilt = [3, index.chunks.len() - 1];
    for (at, chunk) in index.chunks.iter().enumerate() {
        let mut payload = reader.fetch(chunk).unwrap().into_vec();
        if spoilt.contains(&at) {
            payload.truncate(payload.len() - 1);
        }
        writer.push(&PackedChunk::new(chunk.key, payload, (Compression::None, PayloadKind::Mixed)).unwrap()).unwrap();
    }
    let bytes = writer.finish().unwrap().0;
    let decoder = decoder(&bytes);
    let inspection = inspected(&decoder, LIST_ALL).unwrap();
    let found: Vec<ChunkKey> = inspection.damaged.iter().map(|damaged| damaged.chunk.key).collect();
    assert_eq!(found, spoilt.map(|at| index.chunks[at].key));
    assert!(inspected(&decoder, ALL_ROWS).is_err());
}

#[test]
fn ranges_choose_rows_and_empty_ones_are_refused() {
    let bytes = encoded(&[StreamKind::Depth], &settings());
    let decoder = decoder(&bytes);
    let rows = |first, last| InspectSettings { rows: FrameRows::Range(FrameRange { first, last }), ..LIST_ALL };
    let all = inspected(&decoder, ALL_ROWS).unwrap();
    let some = inspected(&decoder, rows(3, 5)).unwrap();
    assert_eq!(some.streams, all.streams);
    let expected: Vec<_> = all.rows.iter().filter(|row| (3..=5).contains(&row.frame)).copied().collect();
    assert_eq!(some.rows, expected);
    assert_says(&message(inspected(&decoder, rows(10, 12))), &["10-12"]);
}

fn lightfold(arguments: &[&str], folder: &Path) -> std::process::Output {
    assert_cmd::Command::cargo_bin("lightfold").unwrap().args(arguments).current_dir(folder).output().unwrap()
}

fn stdout(output: &std::process::Output) -> String {
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout.clone()).unwrap()
}

fn on_disk(bytes: &[u8]) -> (TempDir, PathBuf) {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("a.lfold");
    std::fs::write(&path, bytes).unwrap();
    (folder, path)
}

#[test]
fn json_has_the_keys_that_scripts_depend_on() {
    let bytes = encoded(&StreamKind::ALL, &settings());
    let (folder, _) = on_disk(&bytes);
    let text = stdout(&lightfold(&["inspect", "a.lfold", "--json", "--per-frame", "--verify"], folder.path()));
    let json: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert_eq!(json["bytes"], bytes.len());
    assert_eq!((&json["frames"], &json["probes"]), (&80.into(), &1.into()));
    for key in ["raw_bytes", "ratio_percent", "name", "fps", "projection", "format_version", "chunks"] {
        assert!(!json[key].is_null(), "{key}");
    }
    let always = "kind probe face frames width height codec bytes raw_bytes ratio_percent temporal_bytes first_frame units \
                  unit_width unit_height chunks lzma2_chunks keyframes updated_pixels updated_percent";
    let temporal = "aabbs error_bound_codes window max_aabbs keyframe_interval constant_units";
    let mut sum = json["overhead_bytes"].as_u64().unwrap();
    for stream in json["streams"].as_array().unwrap() {
        let more = match stream["kind"].as_str().unwrap() {
            "color" => "keyframes_per_cell static_cells min_psnr_db transfer exposure_ev".to_owned(),
            "depth" => format!("{temporal} near_m far_m background depth_kind"),
            "alpha" => "error_bound_codes window keyframe_interval constant_units predicted_blocks".to_owned(),
            _ => temporal.to_owned(),
        };
        for key in always.split_whitespace().chain(more.split_whitespace()) {
            assert!(!stream[key].is_null() || stream[format!("{key}_is")] == "inf", "{key} of {stream}");
        }
        assert!(stream.get("nodes").is_none());
        sum += stream["bytes"].as_u64().unwrap();
    }
    assert_eq!(sum, bytes.len() as u64);
    let depth = &json["streams"][2];
    assert_eq!((&depth["near_m"], &depth["background_is"]), (&1.0.into(), &"inf".into()));
    assert_eq!(json["kinds"]["color"]["temporal_bytes"], json["kinds"]["color"]["bytes"]);
    assert_eq!(json["frame_rows"].as_array().unwrap().len(), 80);
    assert_eq!(json["frame_rows"][0]["keyframe_units"], 4);
    assert_eq!(json["verify"]["damaged"], serde_json::json!([]));
    assert_eq!(json["probe_list"][0]["position"], serde_json::json!([1.0, 2.0, 3.0]));
}

#[test]
fn csv_has_a_row_for_each_stream_or_frame() {
    let (folder, path) = on_disk(&encoded(&StreamKind::ALL, &settings()));
    let parse = |text: String| {
        let mut reader = csv::Reader::from_reader(text.as_bytes());
        let headings = reader.headers().unwrap().clone();
        let rows: Vec<csv::StringRecord> = reader.records().collect::<Result<_, _>>().unwrap();
        (headings, rows)
    };
    let (headings, rows) = parse(stdout(&lightfold(&["inspect", "a.lfold", "--csv"], folder.path())));
    assert_eq!(rows.len(), 8);
    let at = |name: &str| headings.iter().position(|heading| heading == name).unwrap();
    assert_eq!((&rows[0][at("kind")], &rows[0][at("keyframes_per_cell_max")]), ("color", "10"));
    assert_eq!((&rows[2][at("background")], &rows[2][at("static_cells")]), ("inf", ""));
    let arguments = ["inspect", "-", "--csv", "--per-frame", "--frames", "4-5", "--stream", "depth", "--face", "px"];
    let mut command = assert_cmd::Command::cargo_bin("lightfold").unwrap();
    let output = command.args(arguments).pipe_stdin(path).unwrap().output().unwrap();
    let (headings, rows) = parse(stdout(&output));
    assert_eq!(headings.iter().take(4).collect::<Vec<_>>(), ["kind", "probe", "face", "frame"]);
    assert_eq!(rows.iter().map(|row| row[3].to_owned()).collect::<Vec<_>>(), ["4", "5"]);
}

#[test]
fn verify_names_damage_and_exits_with_2() {
    let mut bytes = encoded(&[StreamKind::Depth], &settings());
    let chunk = decoder(&bytes).reader().index().chunks[1];
    bytes[chunk.offset as usize + 9] ^= 1;
    let (folder, _) = on_disk(&bytes);
    let output = lightfold(&["inspect", "a.lfold", "--verify"], folder.path());
    let (out, error) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert_eq!(output.status.code(), Some(2));
    let offset = format!("at byte {}", chunk.offset);
    assert_says(
        &out,
        &["1 of 24 chunks damaged", "depth of probe 00 face px", "unit 0, frames 4-7", &offset, "CRC-32"],
    );
    assert_says(&error, &["a.lfold: damaged: 1 of 24 chunks"]);
    let output = lightfold(&["inspect", "a.lfold", "--verify", "--json"], folder.path());
    assert_eq!(output.status.code(), Some(2));
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(json["verify"]["damaged"][0]["frames"], serde_json::json!([4, 7]));
    assert_eq!(lightfold(&["inspect", "a.lfold"], folder.path()).status.code(), Some(2));
    assert_eq!(lightfold(&["inspect", "a.lfold", "--frames", "1-2"], folder.path()).status.code(), Some(2));
}

#[test]
fn the_report_fits_a_terminal() {
    let (folder, _) = on_disk(&encoded(&StreamKind::ALL, &settings()));
    let text = stdout(&lightfold(&["inspect", "a.lfold", "--verify"], folder.path()));
    assert!(text.lines().all(|line| line.chars().count() <= 100 && !line.ends_with(' ')));
    insta::assert_snapshot!(text, @r"
    small: cubemap at 24 fps, 1 probe, 8 streams, 80 images
    18.59 kB of 225.28 kB raw (8.25%), 62 chunks, 15.89 kB saved by sharing, 393 B head and index

    Kind      Streams  Images        Raw  Temporal      %    Stored      %
    color           2      20   61.44 kB  11.63 kB  18.93  11.63 kB  18.93
    depth           2      20   81.92 kB   3.03 kB   3.70   3.03 kB   3.70
    material        2      20   61.44 kB   3.38 kB   5.49   3.38 kB   5.49
    alpha           2      20   20.48 kB     161 B   0.79     161 B   0.79
    all             8      80  225.28 kB  18.19 kB   8.08  18.19 kB   8.08

    Probe  Kind      Face  Frames   Size   Stored      %  Keys  AABBs  Upd. %  Static  Empty  Units
    00     color     px       0-9  32x32  8.51 kB  27.70    13      -   32.50       3      -      4
    00     color     nz       0-9  32x32  3.12 kB  10.16     4      -   10.00       4      -      4
    00     depth     px       0-9  32x32  3.01 kB   7.35    12     14   30.86       3      0      4
    00     depth     nz       0-9  32x32     18 B   0.04    12      0   30.00       4      4      4
    00     material  px       0-9  32x32  3.38 kB  10.99    12     14   35.62       2      2      4
    00     material  nz       0-9  32x32      0 B   0.00    12     14   35.62       2      2      4
    00     alpha     px       0-9  32x32    161 B   1.57     3      0   47.50       0      0      1
    00     alpha     nz       0-9  32x32      0 B   0.00     3      0   47.50       0      0      1

    Coding         Blocks 8x8  Pixels %  Bytes %  Bits a pixel
    same                  168     52.50     1.38         0.003
    plane                  82     25.62     2.44         0.011
    changed plane           2      0.62     2.41         0.448
    quarters               12      3.75    19.03         0.589
    pixels                 56     17.50    74.74         0.496

    color: 8 bits, srgb, exposure 0 EV, at least 100 dB, cell 16x16
    depth: ±0 codes, window 2, 8 AABBs, keyframe every 4, tile 16x16, distance, 1.000 to 10.00 m
    material: ±0 codes, window 2, 8 AABBs, keyframe every 4, tile 16x16
    alpha: 8 bits, predictive, keyframe every 4, tile 32x32
    depth of 00: within 0.0018% of the distance, 0.018 mm at 1 m, 0.18 mm at 10 m; no surface at 100 m

    62 chunks verified (0 of LZMA2, 0 of Zstandard)
    ");
    let arguments = ["inspect", "a.lfold", "--per-frame", "--frames", "3-5", "--face", "px", "--stream", "color,depth"];
    insta::assert_snapshot!(stdout(&lightfold(&arguments, folder.path())), @r"
    small: cubemap at 24 fps, 1 probe, 2 of 8 streams, 20 images
    11.52 kB of 71.68 kB raw (16.07%), 16 chunks, 5.26 kB saved by sharing, 393 B head and index

    Probe  Kind   Face  Frame  Keys  AABBs  Updated pixels       %  Bytes
    00     color  px        3     1      -             256   25.00    772
    00     color  px        4     1      -             256   25.00    772
    00     color  px        5     1      -             256   25.00    772
    00     depth  px        3     0      2              16    1.56     60
    00     depth  px        4     4      0            1024  100.00   2112
    00     depth  px        5     0      2               8    0.78     44
    ");
    let (folder, _) =
        on_disk(&encoded(&StreamKind::ALL, &EncodeSettings { compression: Compression::Lzma2(6), ..settings() }));
    let text = stdout(&lightfold(&["inspect", "a.lfold", "--verify"], folder.path()));
    assert_says(&text, &["Temporal      %   +LZMA2", "62 chunks verified (32 of LZMA2, 0 of Zstandard)"]);
}

/// Returns a container of one stream, whose only chunk claims `frames` frames.
fn endless(frames: u32) -> lightfold::Result<Vec<u8>> {
    let decoder = decoder(&encoded(&[StreamKind::Color], &EncodeSettings { cell: SIZE, ..settings() }));
    let index = decoder.reader().index();
    let mut writer = Writer::new(Vec::new(), "endless", 24.0, 0).unwrap();
    let mut probe = index.probes[0].clone();
    probe.frames = [0, frames - 1];
    writer.add_probe(probe).unwrap();
    let mut stream = index.streams[0].clone();
    stream.frame_count = frames;
    writer.add_stream(stream);
    let mut builder = CellBuilder::default();
    builder.push_keyframe(&[7u8; (SIZE * SIZE * 3) as usize]);
    let key = ChunkKey { stream: 0, unit: 0, first_frame: 0, frame_count: frames };
    writer
        .push(&PackedChunk::new(key, builder.finish().unwrap(), (Compression::None, PayloadKind::Mixed)).unwrap())
        .unwrap();
    Ok(writer.finish()?.0)
}

#[test]
fn a_file_that_claims_millions_of_frames_costs_nothing_and_gets_no_rows() {
    let error = endless(1 << 30).unwrap_err().to_string();
    assert!(error.contains("could not be opened again"), "{error}");
    let bytes = endless(1 << 26).unwrap();
    let decoder = decoder(&bytes);
    let inspection = inspected(&decoder, LIST_ALL).unwrap();
    let stats = inspection.streams[0];
    assert_eq!((stats.keyframes, stats.static_units, stats.updated_pixels), (1, 1, u64::from(SIZE * SIZE)));
    assert_says(&message(inspected(&decoder, ALL_ROWS)), &["67108864 rows", "select fewer"]);
}

#[test]
fn blocks_of_predictive_depth_are_counted_with_their_bytes() {
    let vectors = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/vectors/valid");
    let mut codings = std::collections::BTreeSet::new();
    for name in ["predictive-coarse", "predictive-lossless", "predictive-odd-sizes"] {
        let file = format!("{name}.lfold");
        let text = stdout(&lightfold(&["inspect", &file, "--json", "--per-frame"], &vectors));
        let json: serde_json::Value = serde_json::from_str(&text).unwrap();
        let rows = json["frame_rows"].as_array().unwrap();
        let of_rows = |key: &str| rows.iter().map(|row| row[key].as_u64().unwrap()).sum::<u64>();
        let (mut payload, mut updated) = (0, 0);
        for stream in json["streams"].as_array().unwrap() {
            let number = |key: &str| stream[key].as_u64().unwrap();
            let sum = |key: &str| stream[key].as_object().unwrap().values().map(|of| of.as_u64().unwrap()).sum::<u64>();
            let shown = number("frames") * number("width") * number("height");
            let (pixels, bytes) = (sum("predicted_pixels"), sum("predicted_bytes"));
            assert!(
                pixels <= shown
                    && pixels - stream["predicted_pixels"]["same"].as_u64().unwrap() <= number("updated_pixels")
            );
            assert!(bytes > 0 && bytes <= number("payload_bytes"), "{name}: {stream}");
            assert_eq!(number("window"), 1);
            let used = stream["predicted_blocks"].as_object().unwrap().iter().filter(|(_, count)| **count != 0);
            codings.extend(used.map(|(coding, _)| coding.clone()));
            (payload, updated) = (payload + number("payload_bytes"), updated + number("updated_pixels"));
        }
        assert_eq!((of_rows("bytes"), of_rows("updated_pixels")), (payload, updated), "{name}");
    }
    assert_eq!(codings.len(), 6, "{codings:?}");
}
