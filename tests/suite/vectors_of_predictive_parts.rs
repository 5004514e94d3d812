//! Frozen containers of predictive depth, each named after the part of depth.md 15 that it tests.

use codec::container::Compression;
use codec::depth::predictive::projection::{Projection, Shape as Pixels};
use codec::depth::predictive::{Levels, Predictive, PredictiveChunk, PredictiveHeader, TableSet, Tables, UnitArea};
use codec::entropy::{Counts, Model, Trainer};

use crate::samples::{self, Random, Stream};
use crate::vectors::{one, shape};

const SIDE: u32 = 45;
const FRAMES: u32 = 4;
// Symbol families in the order of depth.md 15.7.
const FRAME: usize = 0;
const MODE: usize = 1;
const SMALL_MODE: usize = 2;
const CHANGE: usize = 3;
const PIXEL: usize = 4;
const ESCAPE: usize = 5;
const CANDIDATE: usize = 6;

/// A stream, and the symbols that must occur in it: families, each with a list of symbols.
struct Part {
    name: &'static str,
    stream: Stream,
    header: PredictiveHeader,
    symbols: &'static [(usize, &'static [usize])],
}

fn header(bound: u16, shape: Pixels, octave: u32) -> PredictiveHeader {
    PredictiveHeader {
        bound,
        epsilon: 0,
        keyframe_interval: 3,
        projection: Projection { shape, octave },
        tables: Tables::default(),
        levels: Levels::default(),
    }
}

fn frames(mut code: impl FnMut(u32, u32, u32) -> f64) -> Vec<Vec<u16>> {
    let mut image = |t: u32| (0..SIDE * SIDE).map(|at| code(at % SIDE, at / SIDE, t).round() as u16).collect();
    (0..FRAMES).map(&mut image).collect()
}

/// Returns codes of planes in space that meet at edges; one plane moves. `octave` is the number of codes per factor of two.
/// Inverse depths are at least 1 − `range`.
fn planes(octave: f64, range: f64) -> Vec<Vec<u16>> {
    frames(|x, y, t| {
        let (x, y, t) = (f64::from(x), f64::from(y), f64::from(t));
        let walls = [0.9 - 0.012 * x, 0.25 + 0.011 * x + 0.002 * y, 0.95 - 0.014 * y + 0.01 * t];
        let inverse = walls.into_iter().fold(f64::INFINITY, f64::min).max(0.02);
        30_000.0 - octave * (1.0 - range * (1.0 - inverse)).log2()
    })
}

/// Returns [`planes`] as distances from the centre of a cube.
fn distances(octave: f64, range: f64) -> Vec<Vec<u16>> {
    let mut images = planes(octave, range);
    for image in &mut images {
        for (at, code) in image.iter_mut().enumerate() {
            let from_axis = |at: u32| f64::from(2 * at + 1) / f64::from(SIDE) - 1.0;
            let [x, y] = [at as u32 % SIDE, at as u32 / SIDE].map(from_axis);
            *code += (octave / 2.0 * (1.0 + x * x + y * y).log2()).round() as u16;
        }
    }
    images
}

/// Encodes images as a part.
fn part(
    name: &'static str,
    images: &[Vec<u16>],
    header: PredictiveHeader,
    symbols: &'static [(usize, &'static [usize])],
) -> Part {
    let stream = samples::predictive(shape(2, [SIDE, SIDE], [24, 32], 3, FRAMES), images, header.clone());
    Part { name, stream, header, symbols }
}

fn parts() -> Vec<Part> {
    let planar = |bound, octave| header(bound, Pixels::Planar, octave);
    let plain = |bound| header(bound, Pixels::None, 0);
    let mut random = Random(23);
    let stripes = frames(|x, y, t| match (x + t / 2) % 4 {
        0 => f64::from(9000 + 30 * x + 7 * y),
        1 => f64::from(31_000 - 41 * y),
        2 if y % 5 == 0 => f64::from(u16::MAX),
        _ => f64::from(52_000 + 3 * x * y / 8),
    });
    let rough = frames(|x, y, _| {
        let spread = 1 << ((x / 5 + y / 9) % 13);
        f64::from(20_000 + random.below(spread))
    });
    let facets = frames(|x, y, t| {
        let [i, j] = [x / 4, y / 4];
        let tilt = |seed: u32| f64::from((i * 37 + j * 91 + seed * 53) % 101) - 50.0;
        let rise = if i % 3 == 0 { 6.0 } else { 2.0 };
        let height = rise * (tilt(1) * f64::from(x % 4) + tilt(2) * f64::from(y % 4));
        30_000.0 + height + 500.0 * f64::from((i + 2 * j) % 5) + f64::from(t / 2)
    });
    let repeats = frames(|x, y, t| match (x, y) {
        (8..16, 8..24) => f64::from(12_000 + 19 * x + 800 * (t / 2)),
        (30.., 20..) if t < 2 || x < 40 => f64::from(u16::MAX),
        (..8, 24..) if t > 1 => f64::from(u16::MAX),
        _ => f64::from(28_000 + x * x + 9 * y),
    });
    let mut noise = Random(5);
    let levels: Vec<u16> = (0..4096).map(|at| 15 * at + at % 7).collect();
    let many = frames(|x, y, t| f64::from(levels[((x * 83 + y * 41 + t * 3 + noise.below(9)) % 4096) as usize]));
    let two = frames(|x, y, t| if (x / 3 + y / 5 + t / 2) % 2 == 0 { 700.0 } else { 60_000.0 });
    let with_levels = |codes: Vec<u16>| PredictiveHeader { levels: Levels::new(codes).unwrap(), ..plain(0) };
    vec![
        part(
            "predictive-planes-of-projection-1",
            &planes(9000.0, 1.0),
            planar(40, 9000),
            &[(MODE, &[4, 5, 6, 7, 8]), (CHANGE, &[0, 1, 2])],
        ),
        part(
            "predictive-planes-of-projection-2",
            &distances(9000.0, 1.0),
            header(40, Pixels::CubeDistance, 9000),
            &[(MODE, &[4, 5, 7, 8]), (CHANGE, &[0, 1, 2])],
        ),
        part(
            "predictive-planes-without-projection",
            &planes(9000.0, 1.0),
            plain(40),
            &[(MODE, &[4, 5, 7, 8]), (CHANGE, &[0, 1, 2])],
        ),
        part("predictive-planes-of-a-small-octave", &planes(512.0, 1.0), planar(4, 512), &[(MODE, &[7, 8])]),
        part("predictive-planes-of-a-large-octave", &planes(131_071.0, 0.05), planar(60, 131_071), &[(MODE, &[7, 8])]),
        part("predictive-planes-of-quarters", &facets, plain(30), &[(MODE, &[3]), (SMALL_MODE, &[0, 4])]),
        part("predictive-candidates", &stripes, plain(2), &[(PIXEL, &[6, 7, 8]), (CANDIDATE, &[0])]),
        part(
            "predictive-escapes",
            &rough,
            plain(1),
            &[(PIXEL, &[0, 1, 2, 3, 4, 10, 11]), (ESCAPE, &[0, 1, 2, 3, 4, 5, 6, 7])],
        ),
        part("predictive-frames-that-repeat", &repeats, plain(0), &[(FRAME, &[0, 1]), (MODE, &[0, 1, 2])]),
        part("predictive-two-levels", &two, with_levels(vec![700, 60_000]), &[(PIXEL, &[0, 1, 2])]),
        part("predictive-most-levels", &many, with_levels(levels.clone()), &[(ESCAPE, &[15])]),
        max_own_sets(&planes(9000.0, 1.0), planar(40, 9000)),
    ]
}

/// Returns a part with eight own table sets, of which the payloads use the last.
fn max_own_sets(images: &[Vec<u16>], header: PredictiveHeader) -> Part {
    let plain = part("", images, header.clone(), &[]);
    let counts = plain.stream.chunks.iter().map(|(unit, chunk)| {
        let area = UnitArea { rect: plain.stream.entry.unit_rect(*unit), image: [SIDE; 2] };
        let chunk = PredictiveChunk::parse(chunk.payload.clone(), header.clone(), area, chunk.frame_count);
        chunk.unwrap().count().unwrap()
    });
    let fitted = Trainer::new(counts.collect()).train(1);
    let own = [vec![TableSet::new(Tables::default().sets()[0].distributions()); 7], fitted].concat();
    let header = PredictiveHeader { tables: Tables::with_own(own), ..header };
    let part = part("predictive-most-own-tables", images, header, &[]);
    assert!(part.stream.chunks.iter().any(|(_, chunk)| chunk.payload[0] == 16));
    part
}

pub fn valid() -> Vec<(&'static str, Vec<u8>)> {
    let of_part = |part: Part| (part.name, one(part.stream));
    let mut all: Vec<_> = parts().into_iter().map(of_part).collect();
    let both = [parts().remove(0), parts().remove(1)].map(|part| part.stream).map(|mut stream| {
        stream.entry.face = if stream.entry.codec_header[24] == 1 { 0 } else { 1 };
        stream
    });
    let file = samples::container(0, samples::probe("00", 10), &both, Compression::Zstd(19));
    all.push(("predictive-in-frames", file));
    all
}

#[test]
fn vectors_have_the_symbols_that_they_are_named_for() {
    let mut wrong = Vec::new();
    for Part { name, stream, header, symbols } in parts() {
        let mut counts: Counts<Predictive> = Counts::default();
        for (unit, chunk) in &stream.chunks {
            let area = UnitArea { rect: stream.entry.unit_rect(*unit), image: [SIDE; 2] };
            let chunk = PredictiveChunk::parse(chunk.payload.clone(), header.clone(), area, chunk.frame_count).unwrap();
            counts.add(&chunk.count().unwrap().counts, 1);
        }
        for (family, expected) in symbols {
            let of_family = Predictive::FAMILIES[*family];
            let clusters = &counts.by_cluster()[of_family.first_cluster..][..of_family.clusters];
            let count = |symbol: usize| clusters.iter().map(|counts| counts[symbol]).sum::<u64>();
            let missing: Vec<_> = expected.iter().filter(|symbol| count(**symbol) == 0).collect();
            let found: Vec<_> = (0..of_family.alphabet).map(count).collect();
            if !missing.is_empty() {
                wrong.push(format!("{name}: family {family} lacks {missing:?} in {found:?}"));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
