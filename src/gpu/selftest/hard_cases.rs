//! Pictures of depth that are numerically hard: encoded within a bound, and decoded by both devices.
//!
//! `tests/suite/hard_cases.rs` holds the encoder to every bound on them; here the device must show what the CPU shows, and
//! that within the bound.

use rayon::prelude::*;

use crate::container::index::{ProbeEntry, StreamEntry};
use crate::container::writer::Writer;
use crate::container::{ChunkKey, EncodedChunk, PackedChunk, Reader};
use crate::dataset::stream::DepthKind;
use crate::depth::domain::{Domain, DomainKind};
use crate::depth::node_encoder::{NodeEncoder, NodeSettings};
use crate::depth::nodes::Grid;
use crate::depth::{BACKGROUND_CODE, DepthRange};
use crate::effort::Effort;
use crate::error::Result;
use crate::gpu::decode::GpuDecoder;
use crate::gpu::device::Gpu;
use crate::gpu::pictures::mismatched_words;
use crate::gpu::random::Random;
use crate::monitor::Monitor;
use crate::video::codec::{CodecHeader, DepthCoding, DepthHeader, NodeHeader};
use crate::video::decode::{Decoder, FaceDecoder, Picture, StreamInfo};

/// Largest error, in codes, that the encoder is allowed.
const BOUND: u16 = 100;
/// Near and far, in metres.
const RANGE_M: [f32; 2] = [0.5, 900.0];

/// A picture from a function of column and row.
type Generator = fn(usize, usize) -> f64;

/// A picture that is hard to model.
#[derive(Debug, Clone, Copy)]
pub struct HardCase {
    /// What it shows.
    pub name: &'static str,
    /// Width and height in pixels.
    pub size: [usize; 2],
    /// Codes, clamped to 0 to 65535.
    pixel: Generator,
}

const fn case(name: &'static str, size: [usize; 2], pixel: Generator) -> HardCase {
    HardCase { name, size, pixel }
}

const BACKGROUND: f64 = 65535.0;

/// A number below `n` that depends on the pixel alone.
fn noise(x: usize, y: usize, n: u32) -> f64 {
    f64::from(Random::new((x as u64) << 32 | y as u64 ^ 0x9E37_79B9).below(n))
}

/// All of them.
pub const CASES: &[HardCase] = &[
    case("constant 0", [64, 64], |_, _| 0.0),
    case("constant 1", [64, 64], |_, _| 1.0),
    case("constant 65534", [64, 64], |_, _| 65534.0),
    case("constant background", [64, 64], |_, _| BACKGROUND),
    case("one odd pixel in a corner", [64, 64], |x, y| if (x, y) == (0, 0) { 60_000.0 } else { 7.0 }),
    case("one pixel of background", [64, 64], |x, y| if (x, y) == (9, 14) { BACKGROUND } else { 65534.0 }),
    case("one pixel of surface", [64, 64], |x, y| if (x, y) == (9, 14) { 65534.0 } else { BACKGROUND }),
    case("checkerboard of 0 and 65534", [32, 32], |x, y| if (x + y) % 2 == 0 { 0.0 } else { 65534.0 }),
    case("checkerboard of 0 and background", [32, 32], |x, y| if (x + y) % 2 == 0 { 0.0 } else { BACKGROUND }),
    case("checkerboard of 65534 and background", [32, 32], |x, y| if (x + y) % 2 == 0 { 65534.0 } else { BACKGROUND }),
    case("ramp of 1/64 code a pixel", [256, 64], |x, _| 30_000.0 + (x as f64 / 64.0).floor()),
    case("slanted ramp of 1/64 code a pixel", [128, 128], |x, y| ((x + 2 * y) as f64 / 64.0).round()),
    case("ramp down to 0", [64, 64], |x, y| (300.0 - 9.0 * x as f64 - 5.0 * y as f64).max(0.0)),
    case("ramp up to 65534", [64, 64], |x, y| (65_000.0 + 11.0 * x as f64 + 3.0 * y as f64).min(65534.0)),
    case("step of 65534 along a slanted line", [64, 64], |x, y| if 3 * x > 2 * y + 20 { 65534.0 } else { 0.0 }),
    case("step to the background along a line", [64, 64], |x, y| {
        if 5 * x > 7 * y + 3 { BACKGROUND } else { 40_000.0 + 30.0 * x as f64 + 11.0 * y as f64 }
    }),
    case("a line with one pixel on a side", [8, 8], |x, y| if x + y == 0 { 9000.0 } else { 30_000.0 + 8.0 * x as f64 }),
    case(
        "a line with two pixels on a side",
        [8, 8],
        |x, y| if x + 2 * y < 2 { 9000.0 } else { 30_000.0 + 8.0 * y as f64 },
    ),
    case("two pixels, collinear, of another surface", [16, 16], |x, y| {
        if y == 3 && (5..7).contains(&x) { 100.0 } else { 200.0 * x as f64 }
    }),
    case("a plane at a grazing angle, 512x512", [512, 512], |x, y| 5.0 + 100.0 * x as f64 + 27.9 * y as f64),
    case("a bowl, 256x256", [256, 256], |x, y| {
        let (x, y) = (x as f64 - 128.0, y as f64 - 128.0);
        20_000.0 + 1.1 * (x * x + y * y) + 0.3 * x * y
    }),
    case("a steep bowl", [64, 64], |x, y| {
        let (x, y) = (x as f64 - 32.0, y as f64 - 32.0);
        (16.0 * (x * x + y * y)).min(65534.0)
    }),
    case("noise of all codes", [40, 40], |x, y| noise(x, y, 65536)),
    case("noise of 3 codes", [64, 64], |x, y| 1000.0 + noise(x, y, 3)),
    case("noise of 150 codes on a slope", [64, 64], |x, y| 1000.0 + 40.0 * x as f64 + noise(x, y, 150)),
    case("surfaces next to the background's code", [32, 32], |x, y| 65_535.0 - noise(x, y, 4)),
    case("thin fence before the background", [64, 64], |x, y| {
        if x % 7 == 0 || y % 13 == 0 { 12_000.0 + x as f64 } else { BACKGROUND }
    }),
    case("wider than 512, of which leaves change", [521, 9], |x, y| {
        if (500..530).contains(&x) { 40_000.0 + noise(x, y, 900) } else { 20_000.0 + 5.0 * y as f64 }
    }),
    case("higher than 512, of which leaves change", [7, 1024], |x, y| {
        if y > 700 { 40_000.0 + noise(x, y, 9000) } else { 20_000.0 + 5.0 * y as f64 }
    }),
    case("smaller than a leaf", [3, 2], |x, y| 100.0 * x as f64 + 7.0 * y as f64),
    case("one pixel", [1, 1], |_, _| 12_345.0),
    case("one row", [37, 1], |x, _| 3.0 * x as f64),
    case("one column", [1, 53], |_, y| if y < 20 { BACKGROUND } else { 9.0 * y as f64 }),
    case("not divisible by 4", [45, 30], |x, y| 500.0 * (x / 9) as f64 + y as f64),
    case("not divisible by 8, with an edge", [29, 77], |x, y| if x * 3 > y { 60_000.0 } else { 13.0 * x as f64 }),
];

impl HardCase {
    /// Its codes, row by row.
    pub fn picture(&self) -> Vec<u16> {
        let [width, height] = self.size;
        (0..width * height).map(|at| (self.pixel)(at % width, at / width).clamp(0.0, 65535.0) as u16).collect()
    }

    /// Its size.
    pub fn grid(&self) -> Grid {
        Grid { width: self.size[0] as u32, height: self.size[1] as u32 }
    }

    /// Three frames: the picture, the same moved by three columns, and the picture again.
    pub fn frames(&self) -> Vec<Vec<u16>> {
        let (first, width) = (self.picture(), self.size[0]);
        let mut moved = first.clone();
        moved.chunks_mut(width).for_each(|row| row.rotate_left(3.min(width - 1)));
        vec![first.clone(), moved, first]
    }
}

/// The largest error of a surface, and whether background and surfaces were ever confused.
pub fn compare(decoded: &[u16], source: &[u16]) -> (u16, bool) {
    let confused = |(a, b): (&u16, &u16)| (*a == BACKGROUND_CODE) != (*b == BACKGROUND_CODE);
    let error = decoded.iter().zip(source).map(|(a, b)| a.abs_diff(*b)).max().unwrap_or(0);
    (error, decoded.iter().zip(source).any(confused))
}

/// What came of a picture, in all domains and frames.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct HardCaseReport {
    /// Name of the case.
    pub name: &'static str,
    /// Largest error that is allowed, in codes.
    pub bound: u16,
    /// Largest error of what the device shows, in codes.
    pub measured: u16,
    /// Whether a surface was shown as background or the reverse.
    pub confused: bool,
    /// Words that differ from the CPU's.
    pub mismatched_words: u64,
}

impl HardCaseReport {
    /// Whether the device showed what the CPU shows, within the bound.
    pub fn passed(&self) -> bool {
        self.measured <= self.bound && !self.confused && self.mismatched_words == 0
    }
}

/// Decodes all cases on both devices.
///
/// # Errors
/// The device fails, or was asked to stop.
pub fn test_hard_cases(gpu: &Gpu, monitor: &dyn Monitor) -> Result<Vec<HardCaseReport>> {
    let new = |case: &HardCase| HardCaseReport {
        name: case.name,
        bound: BOUND,
        measured: 0,
        confused: false,
        mismatched_words: 0,
    };
    let mut reports: Vec<HardCaseReport> = CASES.iter().map(new).collect();
    for kind in DomainKind::ALL {
        monitor.check()?;
        let decoder = Decoder::new(Reader::from_memory(container(kind)?)?)?;
        let streams: Vec<&StreamInfo> = decoder.streams().iter().collect();
        let mut on_gpu = GpuDecoder::new(gpu, &decoder, &streams)?;
        let mut on_cpu: Vec<FaceDecoder<'_>> = streams.iter().map(|stream| decoder.face(stream)).collect();
        for frame in 0..3 {
            on_gpu.decode(frame)?;
            let pictures = on_gpu.read()?;
            for (at, (case, report)) in CASES.iter().zip(&mut reports).enumerate() {
                report.mismatched_words += mismatched_words(&pictures[at], &on_cpu[at].decode(frame)?);
                let Picture::Depth(shown) = &pictures[at] else { continue };
                let (error, confused) = compare(shown.data(), &case.frames()[frame as usize]);
                report.measured = report.measured.max(error);
                report.confused |= confused;
            }
        }
    }
    Ok(reports)
}

/// A probe for each case, whose one stream has three frames.
fn container(kind: DomainKind) -> Result<Vec<u8>> {
    let range = DepthRange::new(RANGE_M[0], RANGE_M[1])?;
    let domain = Domain::new(kind, range)?;
    let settings = NodeSettings { bound: BOUND, effort: Effort::Fast, ..NodeSettings::default() };
    let NodeSettings { window, epsilon, keyframe_interval, bound, .. } = settings;
    let nodes = NodeHeader { window, epsilon, keyframe_interval, bound, domain: domain.parts() };
    let coding = DepthCoding::Nodes(nodes);
    let header = DepthHeader { range, background: f32::INFINITY, kind: DepthKind::Distance, coding };
    let header = CodecHeader::Depth(header);
    let mut writer = Writer::new(Vec::new(), "hard cases", 24.0, 0)?;
    for (at, case) in (0u16..).zip(CASES) {
        writer.add_probe(ProbeEntry {
            name: format!("{at:02}"),
            position: [0.0; 3],
            orientation: [0.0, 0.0, 0.0, 1.0],
            frames: [0, 2],
            intrinsics: [0.0; 4],
        })?;
        let [width, height] = case.size.map(|side| side as u32);
        writer.add_stream(StreamEntry {
            kind: header.kind() as u8,
            face: 0,
            probe: at,
            codec: header.codec(),
            width,
            height,
            first_frame: 0,
            frame_count: 3,
            unit_width: width,
            unit_height: height,
            codec_header: header.write(),
        });
    }
    let encoded: Result<Vec<Vec<EncodedChunk>>> =
        CASES.par_iter().map(|case| encode(case, NodeEncoder::new(case.grid(), domain.clone(), settings))).collect();
    for (stream, chunks) in (0u32..).zip(encoded?) {
        for EncodedChunk { first_frame, frame_count, payload } in chunks {
            let key = ChunkKey { stream, unit: 0, first_frame, frame_count };
            writer.push(&PackedChunk::new(key, payload, None)?)?;
        }
    }
    Ok(writer.finish()?.0)
}

fn encode(case: &HardCase, mut encoder: NodeEncoder) -> Result<Vec<EncodedChunk>> {
    let mut chunks = Vec::new();
    for frame in case.frames() {
        chunks.extend(encoder.push(&frame, None)?);
    }
    chunks.extend(encoder.finish()?);
    Ok(chunks)
}
