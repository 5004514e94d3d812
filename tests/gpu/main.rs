//! Tests that need a GPU; software Vulkan is sufficient. Without a device they are reported as ignored.
//!
//! The environment variable `LIGHTFOLD_GPU` selects a device by its number or a part of its name.

#![allow(clippy::disallowed_methods)]

mod decoding;
mod drawings;
mod epipolar;
mod pictures;
mod projection;

use std::path::Path;
use std::process::Command;

use cli::GlobalArgs;
use cli::device::or_on_cpu;
use codec::color::cells::MISSING_NEXT_KEYFRAME;
use codec::container::{ChunkKey, Compression, PackedChunk, PayloadKind, ProbeEntry, Reader, StreamEntry, Writer};
use codec::decode::{AllUnits, Decoder, Request, Selection, StreamInfo, UnitFilter};
use codec::depth::{DepthRange, TemporalSettings};
use codec::image::{DepthKind, StreamKind};
use codec::monitor::{Monitor, Silent};
use codec::streams::{CodecHeader, DepthCoding, DepthHeader};
use gpu::decode::GpuDecoder;
use gpu::device::Pick;
use gpu::selftest::{self, ROWS, SEED, streams};
use gpu::{Gpu, device};
use kernels::{DRAWINGS, Kernel, ShaderFile};
use libtest_mimic::{Arguments, Failed, Trial};
use lightfold::Error;

/// Number of random streams that are decoded; `lightfold selftest --streams` accepts more.
const STREAMS: u64 = 400;

fn pick() -> Pick {
    Pick::parse(&std::env::var("LIGHTFOLD_GPU").unwrap_or_default())
}

fn with_gpu(test: impl FnOnce(&Gpu) -> Result<(), Failed>) -> Result<(), Failed> {
    test(&Gpu::open(&pick()).map_err(|error| error.to_string())?)
}

fn kernel(row: &'static selftest::Row) -> Result<(), Failed> {
    with_gpu(|gpu| {
        let report = selftest::test_kernel(gpu, row, SEED).map_err(|error| error.to_string())?;
        match report.mismatches {
            0 if report.inputs > 0 => Ok(()),
            count => Err(format!("{count} words differ on {}: {:?}", gpu.info.name, report.first).into()),
        }
    })
}

fn random_streams() -> Result<(), Failed> {
    with_gpu(|gpu| {
        let report = streams::test_streams(gpu, STREAMS, SEED, &Silent).map_err(|error| error.to_string())?;
        match report.verification.mismatched_words {
            0 if report.streams >= STREAMS && report.images > report.streams => Ok(()),
            count => Err(format!("{count} words differ on {}: {report:?}", gpu.info.name).into()),
        }
    })
}

/// Compares the streams of all hard cases, decoded in order and with random access, and their rendered images.
fn hard_cases() -> Result<(), Failed> {
    with_gpu(|gpu| {
        let cases = verify::table();
        let ran = verify::run_all(&cases, &Silent).map_err(|error| error.to_string())?;
        let inputs: Vec<_> = ran.into_iter().map(|(_, inputs)| inputs).collect();
        let figures = verify::device::compare(gpu, &inputs, &Silent).map_err(|error| error.to_string())?;
        let differs = cases.iter().zip(&figures).find(|(_, figures)| figures.mismatched_words > 0);
        let pictures: u64 = figures.iter().map(|figures| figures.pictures).sum();
        let rendered: u64 = figures.iter().map(|figures| figures.rendered).sum();
        match differs {
            None if pictures > 10_000 && rendered > 10 => Ok(()),
            differs => {
                let differs = differs.map(|(case, figures)| (&case.name, figures));
                let device = &gpu.info.name;
                Err(format!("{pictures} pictures, {rendered} of them rendered, on {device}: {differs:?}").into())
            }
        }
    })
}

/// Omits each unit in one of three frames, so that it lags behind in the next frame.
struct TwoOfThree;

impl UnitFilter for TwoOfThree {
    fn wants(&self, stream: &StreamInfo, unit: u32, frame: u32) -> bool {
        !(stream.index + unit + frame).is_multiple_of(3)
    }
}

/// Compares all frames of the frozen containers in order, with all units and with a part of them.
fn vectors() -> Result<(), Failed> {
    with_gpu(|gpu| {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/vectors/valid");
        let mut count = 0;
        for entry in std::fs::read_dir(folder)? {
            let path = entry?.path();
            if path.extension().is_none_or(|extension| extension != "lfold") {
                continue;
            }
            let decoder = Decoder::open(&path).map_err(|error| error.to_string())?;
            let Ok(chosen) = Selection::default().choose(&decoder) else { continue };
            for filter in [&AllUnits as &dyn UnitFilter, &TwoOfThree] {
                let request = Request { filter, ..Request::all(&chosen) };
                let (_, found) =
                    gpu::verify::verify(gpu, &decoder, request, &Silent).map_err(|error| error.to_string())?;
                if found.mismatched_words > 0 {
                    return Err(format!("{}: {found:?}", path.display()).into());
                }
            }
            count += 1;
        }
        if count > 20 { Ok(()) } else { Err(format!("only {count} vectors were found").into()) }
    })
}

/// Runs the program and returns its standard output. Fails if the command fails.
fn lightfold(arguments: &[&str]) -> Result<String, Failed> {
    let output = Command::new(env!("CARGO_BIN_EXE_lightfold")).args(arguments).output()?;
    let text = |bytes| String::from_utf8_lossy(bytes).into_owned();
    match output.status.success() {
        true => Ok(text(&output.stdout)),
        false => Err(format!("{arguments:?}: {}{}", text(&output.stdout), text(&output.stderr)).into()),
    }
}

/// `decode` writes the same files on both devices, and reports name the device.
fn commands() -> Result<(), Failed> {
    let name = device::list().iter().map(|info| info.name.clone()).collect::<Vec<_>>();
    let folder = tempfile::tempdir()?;
    let path = |name: &str| folder.path().join(name).display().to_string();
    lightfold(&["demo", "--frame-count", "4", "--size", "24", "--probes", "2", "--quiet", "-o", &path("demo")])?;
    let demo = path("demo/demo.lfold");
    for device in ["gpu", "cpu"] {
        lightfold(&["decode", &demo, "--device", device, "-o", &path(device), "--quiet"])?;
    }
    lightfold(&["diff", &path("gpu"), &path("cpu"), "--exact"])?;
    for vector in [
        "material",
        "half-cells-negative",
        "nodes-linear",
        "depth-w3-boxes",
        "blocks",
        "alpha",
        "alpha-beyond-a-byte",
        "predictive",
        "predictive-odd-sizes",
        "transform8-chunks-of-cells",
        "transform8-palettes",
        "transform-half-encoded",
    ] {
        let input = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/vectors/valid").join(vector);
        let input = input.with_extension("lfold").display().to_string();
        let report: serde_json::Value =
            serde_json::from_str(&lightfold(&["decode", &input, "--verify", "--null", "--json"])?)?;
        let known = report["device"].as_str().is_some_and(|device| name.iter().any(|name| name == device));
        if report["mismatched_words"] != 0 || !known {
            return Err(report.to_string().into());
        }
        let on_cpu: serde_json::Value = serde_json::from_str(&lightfold(&["decode", &input, "--null", "--json"])?)?;
        for key in ["frames", "pixels", "updated_pixels", "bytes_out", "bytes_read"] {
            if report[key] != on_cpu[key] {
                return Err(format!("{vector}: {key} is {} and on the CPU {}", report[key], on_cpu[key]).into());
            }
        }
    }
    let report: serde_json::Value = serde_json::from_str(&lightfold(&["selftest", "--streams", "24", "--json"])?)?;
    let kernels = report["kernels"].as_array().map_or(0, Vec::len);
    let passed = |cases: &Vec<serde_json::Value>| {
        cases.len() >= verify::table().len() && cases.iter().all(|c| c["passed"] == true)
    };
    let all_passed = report["hard_cases"].as_array().is_some_and(passed);
    match report["failed"] == false && kernels >= ROWS.len() && all_passed && report["streams"][0]["streams"] == 24 {
        true => Ok(()),
        false => Err(report.to_string().into()),
    }
}

/// Decodes captured footage in every codec.
fn footage() -> Result<(), Failed> {
    let Some(data) = option_env!("LIGHTFOLD_DATA") else { return Err("no footage at hand".into()) };
    let folder = tempfile::tempdir()?;
    let container = folder.path().join("film.lfold").display().to_string();
    let boxes = ["--depth-codec", "aabb", "--update-threshold", "30"];
    let blocks = ["--color-block", "bc7", "--depth-block", "bc5", "--material-block", "bc1"];
    let ways: [Vec<&str>; 6] = [
        vec![],
        vec!["--hdr"],
        vec!["--color-codec", "cells"],
        [boxes.as_slice(), &blocks].concat(),
        [boxes.as_slice(), &["--color-block", "bc1"]].concat(),
        vec!["--hdr", "--color-block", "bc6h", "--depth-domain", "inverse"],
    ];
    for (set, options) in ["glass", "equirect"].iter().flat_map(|set| ways.iter().map(move |way| (set, way))) {
        let manifest = Path::new(data).join(set).join("lightfield.json").display().to_string();
        let encode = ["encode", &manifest, "--clip", "--effort", "fast", "--quiet", "-o", &container];
        lightfold(&[encode.as_slice(), options].concat())?;
        let report = lightfold(&["decode", &container, "--verify", "--json"])?;
        let report: serde_json::Value = serde_json::from_str(&report)?;
        if report["mismatched_words"] != 0 || report["frames"].as_u64() < Some(72) {
            return Err(format!("{set} {options:?}: {report}").into());
        }
    }
    Ok(())
}

/// Returns a container with one chunk of a small tile, in which one pixel changes in every frame; the window is 1.
fn flickering(frames: u32) -> Result<Vec<u8>, Error> {
    let temporal = TemporalSettings { window: 1, keyframe_interval: frames, ..TemporalSettings::default() };
    let header = CodecHeader::Depth(DepthHeader {
        range: DepthRange::new(1.0, 2.0)?,
        background: f32::INFINITY,
        kind: DepthKind::Distance,
        coding: DepthCoding::Boxes(temporal),
    });
    let mut writer = Writer::new(Vec::new(), "flickering", 24.0, 0)?;
    writer.add_probe(ProbeEntry {
        name: "p".into(),
        position: [0.0; 3],
        orientation: [0.0, 0.0, 0.0, 1.0],
        frames: [0, frames - 1],
        intrinsics: [0.0; 4],
    })?;
    writer.add_stream(StreamEntry {
        kind: StreamKind::Depth as u8,
        face: 0,
        probe: 0,
        codec: header.codec(),
        width: 3,
        height: 2,
        first_frame: 0,
        frame_count: frames,
        unit_width: 8,
        unit_height: 8,
        codec_header: header.write().into(),
    });
    // Encoders close chunks earlier (formats/depth.md 4), so the payload is written directly: a record with the whole image, then
    // a record per frame with a box of one pixel.
    let mut records = vec![vec![0u8; 4]];
    records[0].extend([1u16, 2, 3, 4, 5, 6].iter().flat_map(|code| code.to_le_bytes()));
    records.extend(
        (1..frames).map(|frame| [2u16, 1, 0, 0, 1, 1, frame as u16].iter().flat_map(|v| v.to_le_bytes()).collect()),
    );
    let mut payload = frames.to_le_bytes().to_vec();
    let mut offset = 4 + 8 * frames;
    for (frame, record) in (0..).zip(&records) {
        payload.extend([frame, offset].iter().flat_map(|value: &u32| value.to_le_bytes()));
        offset += record.len() as u32;
    }
    payload.extend(records.concat());
    let key = ChunkKey { stream: 0, unit: 0, first_frame: 0, frame_count: frames };
    writer.push(&PackedChunk::new(key, payload, (Compression::None, PayloadKind::Mixed))?)?;
    Ok(writer.finish()?.0)
}

/// Frames thousands of steps ahead are decoded, frames too many steps ahead are refused, and decoding can be interrupted.
fn long_ways() -> Result<(), Failed> {
    /// Requests an interruption immediately.
    struct Stopped;
    impl Monitor for Stopped {
        fn advance(&self, _steps: u64) {}
        fn interrupted(&self) -> bool {
            true
        }
    }
    with_gpu(|gpu| {
        let said = |error: Error| error.to_string();
        let decoder =
            Decoder::new(Reader::from_memory(flickering(20_000).map_err(said)?).map_err(said)?).map_err(said)?;
        let stream = &decoder.streams()[0];
        let mut on_gpu = GpuDecoder::new(gpu, &decoder, &[stream]).map_err(said)?;
        match on_gpu.decode(19_999) {
            Err(error @ Error::Unsupported { .. }) if error.to_string().contains("19999 is 20000 steps behind") => {}
            other => return Err(format!("{other:?}").into()),
        }
        let mut on_cpu = decoder.face(stream);
        for frame in [5000, 9000, 3] {
            on_gpu.decode(frame).map_err(said)?;
            if on_gpu.read().map_err(said)?[0] != on_cpu.decode(frame).map_err(said)? {
                return Err(format!("frame {frame} differs on {}", gpu.info.name).into());
            }
        }
        let mut stopped = GpuDecoder::new(gpu, &decoder, &[stream]).map_err(said)?.watched_by(&Stopped);
        match stopped.decode(5000) {
            Err(Error::Interrupted) => Ok(()),
            other => Err(format!("{other:?}").into()),
        }
    })
}

/// A failure of the device is reported as an error that names the device and suggests the CPU.
fn refusals() -> Result<(), Failed> {
    static BROKEN: Kernel = Kernel {
        name: "broken",
        entry: "main",
        files: &[ShaderFile { path: "broken.wgsl", text: "fn main( {" }],
        bindings: &[],
        workgroup: 1,
        reader: None,
    };
    with_gpu(|gpu| {
        let words = gpu.info.max_binding_bytes as usize / 4 + 1;
        let too_large = gpu.buffer("pictures", words, wgpu::BufferUsages::empty()).map(|_| ());
        let broken = gpu.pipeline(&BROKEN).map(|_| ());
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/vectors/valid/blocks.lfold");
        let decoder = Decoder::open(path).map_err(|error| error.to_string())?;
        let streams: Vec<_> = decoder.streams().iter().collect();
        let mut full = GpuDecoder::new(gpu, &decoder, &streams[..1]).map_err(|error| error.to_string())?;
        full.limit_resident(8).map_err(|error| error.to_string())?;
        let full = full.decode(streams[0].frames.first);
        refuses_what_leads_nowhere(gpu)?;
        for (what, result) in [("pictures", too_large), ("broken", broken), ("a chunk", full)] {
            let said = result.err().map(|error| error.to_string()).unwrap_or_default();
            if ![what, &gpu.info.name, "the CPU"].iter().all(|words| said.contains(words)) {
                return Err(format!("{what}: it said '{said}'").into());
            }
        }
        let quiet = GlobalArgs { quiet: true, ..GlobalArgs::default() };
        // With `auto`, the CPU takes over if the device fails, but not if the file is damaged.
        let fails =
            |error: Error| or_on_cpu((Some(gpu), Some(device::DeviceChoice::Auto)), &quiet, |_| Err(error), || Ok(7));
        let taken_over = fails(gpu.failed("decoding", "it is out of memory"));
        if taken_over.ok() != Some((7, "cpu".to_owned())) || fails(Error::invalid("broken")).is_ok() {
            return Err("auto did not go back to the CPU, or did so for a broken file".into());
        }
        lost_device()?;
        // The device still works after these failures.
        let report = selftest::test_kernel(gpu, &ROWS[0], SEED).map_err(|error| error.to_string())?;
        if report.mismatches == 0 { Ok(()) } else { Err(format!("{report:?}").into()) }
    })
}

/// A last chunk that refers to a following chunk is refused, even if the requested frame does not need that chunk.
fn refuses_what_leads_nowhere(gpu: &Gpu) -> Result<(), Failed> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/vectors/invalid/color-last-leads-nowhere-late.lfold");
    let decoder = Decoder::open(path).map_err(|error| error.to_string())?;
    let streams: Vec<_> = decoder.streams().iter().collect();
    let mut images = GpuDecoder::new(gpu, &decoder, &streams).map_err(|error| error.to_string())?;
    let said = images.decode(0).err().map(|error| error.to_string()).unwrap_or_default();
    if said.contains(MISSING_NEXT_KEYFRAME) { Ok(()) } else { Err(format!("it said '{said}'").into()) }
}

/// Checks the error if the device is lost during use.
fn lost_device() -> Result<(), Failed> {
    with_gpu(|gpu| {
        gpu.device.destroy();
        let said = selftest::test_kernel(gpu, &ROWS[0], SEED).err().map(|error| error.to_string()).unwrap_or_default();
        if said.contains(&gpu.info.name) && said.contains("lost") {
            Ok(())
        } else {
            Err(format!("it said '{said}'").into())
        }
    })
}

fn main() {
    let arguments = Arguments::from_args();
    let none = device::list().is_empty();
    if none {
        eprintln!("no graphics device was found: tests of kernels are ignored");
    }
    let trials = ROWS.iter().map(|row| Trial::test(format!("kernel::{}", row.kernel.name), || kernel(row)));
    let of_drawings =
        DRAWINGS.iter().map(|drawing| Trial::test(format!("drawing::{}", drawing.name), || drawings::drawing(drawing)));
    let others = [
        Trial::test("drawings::commands", drawings::commands),
        Trial::test("drawings::refusals", drawings::refusals),
        Trial::test("drawings::equal_depths_and_many_layers", drawings::equal_depths_and_many_layers),
        Trial::test("epipolar::scenes", epipolar::scenes),
        Trial::test("epipolar::sizes", epipolar::sizes),
        Trial::test("epipolar::sources", epipolar::sources),
        Trial::test("epipolar::erosion", epipolar::erosion),
        Trial::test("epipolar::compaction", epipolar::compaction),
        Trial::test("epipolar::commands", epipolar::commands),
        Trial::test("random_streams", random_streams),
        Trial::test("vectors", vectors),
        Trial::test("commands", commands),
        Trial::test("refusals", refusals),
        Trial::test("long_ways", long_ways),
        Trial::test("decoding::texels", decoding::texels),
        Trial::test("decoding::buffers_of_any_size", decoding::buffers_of_any_size),
        Trial::test("decoding::chunks_that_are_needed", decoding::chunks_that_are_needed),
        Trial::test("decoding::after_errors", decoding::after_errors),
        Trial::test("pictures::playback", pictures::playback),
        Trial::test("pictures::larger_images", pictures::larger_images),
        Trial::test("pictures::refusals", pictures::refusals),
        Trial::test("pictures::no_effects", pictures::no_effects),
        Trial::test("projection::agrees_with_the_model", || with_gpu(projection::agrees_with_the_model)),
    ];
    // Reported as ignored, not as passed, if there is no footage (LIGHTFOLD_DATA in CONTRIBUTING.md).
    let footage = [Trial::test("footage", footage), Trial::test("pictures::footage", pictures::footage)]
        .map(|trial| trial.with_ignored_flag(none || cfg!(not(footage_at_hand))));
    // The command `selftest`, which is tested, runs them too.
    let is_long = std::env::var_os("LIGHTFOLD_TESTS").is_none_or(|which| which != "all");
    let of_cases = [Trial::test("hard_cases", hard_cases).with_ignored_flag(none || is_long)];
    let trials = trials
        .chain(of_drawings)
        .chain(others)
        .map(|trial| trial.with_ignored_flag(none))
        .chain(footage)
        .chain(of_cases)
        .collect();
    libtest_mimic::run(&arguments, trials).exit();
}
