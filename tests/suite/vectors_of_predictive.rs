//! Frozen containers of [`crate::vectors`] with predictive depth or alpha (formats/depth.md 15 and 16).

use codec::container::{Compression, EncodedChunk, StreamEntry};
use codec::depth::predictive::projection::{Projection, Shape as Pixels};
use codec::depth::predictive::{Levels, Predictive, PredictiveChunk, PredictiveHeader, TableSet, Tables, UnitArea};
use codec::entropy::{Distribution, Model, SYMBOLS, Trainer};
use codec::streams::AlphaHeader;

use crate::samples::{self, Random, Stream};
use crate::vectors::{one, shape};
use crate::vectors_of_predictive_parts;

fn header(bound: u16, pixels: Pixels) -> PredictiveHeader {
    let octave = if pixels == Pixels::None { 0 } else { 16_384 };
    PredictiveHeader {
        bound,
        epsilon: 0,
        keyframe_interval: 3,
        projection: Projection { shape: pixels, octave },
        tables: Tables::default(),
        levels: Levels::default(),
    }
}

/// Returns depth codes of surfaces in front of a wall, with a moving edge and a hole.
fn surfaces(side: u32, frames: u32) -> Vec<Vec<u16>> {
    let code = |x: u32, y: u32, t: u32| -> u16 {
        match (x, y) {
            _ if 3 * x + y > 130 => u16::MAX,
            _ if x + 2 * y < 20 + 4 * (t / 2) => (4000 + 40 * x + 11 * y + t) as u16,
            _ if (20..27).contains(&x) && (9..30).contains(&y) => (9000 + (x * 7919 + y * 389 + t / 3) % 700) as u16,
            _ => (30_000 + 9 * x * x + 170 * y) as u16,
        }
    };
    (0..frames).map(|t| (0..side * side).map(|at| code(at % side, at / side, t)).collect()).collect()
}

fn random(size: [u32; 2], frames: u32) -> Vec<Vec<u16>> {
    let mut random = Random(7);
    let mut codes = || (0..size[0] * size[1]).map(|_| random.below(65_536) as u16).collect();
    (0..frames).map(|_| codes()).collect()
}

pub fn valid() -> Vec<(&'static str, Vec<u8>)> {
    let mut all = Vec::new();
    let images = surfaces(45, 7);
    for (name, bound, pixels) in [
        ("predictive-lossless", 0, Pixels::CubeDistance),
        ("predictive-fine", 10, Pixels::Planar),
        ("predictive", 100, Pixels::CubeDistance),
        ("predictive-coarse", 1000, Pixels::None),
    ] {
        let shape = shape(2, [45, 45], [24, 32], 3, 7);
        all.push((name, one(samples::predictive(shape, &images, header(bound, pixels)))));
    }
    let moving = |size, seed| samples::moving_codes(size, 9, seed);
    all.push(("predictive-odd-sizes", {
        let stream = |face: u8, size: [u32; 2], unit| {
            let header = PredictiveHeader { epsilon: 2, ..header(1, Pixels::None) };
            samples::predictive(shape(face, size, unit, 2, 9), &moving(size, u64::from(face) + 3), header)
        };
        let streams = [
            stream(0, [1, 1], [8, 8]),
            stream(1, [3, 5], [2, 2]),
            stream(2, [17, 9], [8, 16]),
            stream(3, [1, 17], [8, 8]),
            stream(4, [33, 1], [64, 64]),
        ];
        samples::container(0, samples::probe("odd", 10), &streams, Compression::None)
    }));
    all.push(("predictive-noise", {
        let image = random([20, 12], 3);
        one(samples::predictive(shape(0, [20, 12], [16, 16], 0, 3), &image, header(0, Pixels::Planar)))
    }));
    all.push(("predictive-own-tables", {
        // Two own sets: one of equal frequencies, and one trained on the footage, which the payloads use.
        let equal = |&alphabet: &u8| {
            let mut counts = [0; SYMBOLS];
            counts[..usize::from(alphabet)].fill(1);
            Distribution::of_counts(&counts, alphabet.into())
        };
        let equal: Vec<Distribution> = Predictive::ALPHABETS.iter().map(equal).collect();
        let (shape, image) = (shape(1, [40, 24], [24, 24], 2, 3), random([40, 24], 3));
        let plain = samples::predictive(shape, &image, header(10, Pixels::Planar));
        let count = |unit: u32, chunk: &EncodedChunk| {
            let area = UnitArea { rect: plain.entry.unit_rect(unit), image: [40, 24] };
            let payload = chunk.payload.clone();
            PredictiveChunk::parse(payload, header(10, Pixels::Planar), area, chunk.frame_count)
                .unwrap()
                .count()
                .unwrap()
        };
        let counts = plain.chunks.iter().map(|(unit, chunk)| count(*unit, chunk)).collect();
        let own = [vec![TableSet::new(&equal)], Trainer::new(counts).train(1)].concat();
        let header = PredictiveHeader { tables: Tables::with_own(own), ..header(10, Pixels::Planar) };
        let stream = samples::predictive(shape, &image, header);
        assert!(stream.chunks.iter().all(|(_, chunk)| chunk.payload[0] == 10));
        one(stream)
    }));
    all.push(("predictive-background", {
        let image = vec![vec![u16::MAX; 90]; 4];
        one(samples::predictive(shape(6, [10, 9], [16, 16], 0, 4), &image, header(100, Pixels::None)))
    }));
    all.push(("predictive-levels", {
        let codes: Vec<u16> = (0..70).map(|at| 300 + at * at * 13 + at % 3).collect();
        let mut random = Random(3);
        let mut number = |x: u32, y: u32, t: u32| (x / 3 + y / 4 + t + random.below(2)) as usize % codes.len();
        let mut code = |x: u32, y: u32, t: u32| if x + y < 9 + t { u16::MAX } else { codes[number(x, y, t / 2)] };
        let mut image = |t: u32| (0..37 * 21).map(|at| code(at % 37, at / 37, t)).collect();
        let images: Vec<Vec<u16>> = (0..5).map(&mut image).collect();
        let header = PredictiveHeader { levels: Levels::new(codes.clone()).unwrap(), ..header(0, Pixels::None) };
        let stream = samples::predictive(shape(6, [37, 21], [24, 16], 4, 5), &images, header);
        assert!(stream.chunks.iter().any(|(_, chunk)| chunk.payload[0] == 8));
        one(stream)
    }));
    all.push(("alpha", {
        // A soft moving disc with noise at its edge.
        let mut random = Random(11);
        let mut code = |x: u32, y: u32, t: u32| {
            let square = (x as i32 - 20 - t as i32).pow(2) + (y as i32 - 13).pow(2);
            (255 - (square - 100).clamp(0, 255) + random.below(2) as i32 * i32::from(square > 100)).clamp(0, 255) as u16
        };
        let mut image = |t: u32| (0..43 * 26).map(|at| code(at % 43, at / 43, t)).collect();
        let images: Vec<Vec<u16>> = (0..5).map(&mut image).collect();
        one(samples::alpha(shape(6, [43, 26], [24, 16], 4, 5), &images, AlphaHeader { keyframe_interval: 3 }))
    }));
    all.push(("alpha-beyond-a-byte", {
        let image = vec![(0..12 * 9).map(|at| [0, 254, 255, 256, 300, 65_534, u16::MAX][at % 7]).collect()];
        one(samples::alpha(shape(0, [12, 9], [16, 16], 0, 1), &image, AlphaHeader { keyframe_interval: 1 }))
    }));
    all.extend(vectors_of_predictive_parts::valid());
    all
}

pub fn invalid() -> Vec<(&'static str, Vec<u8>, &'static str)> {
    let shape = shape(0, [20, 20], [24, 24], 0, 3);
    let images = surfaces(20, 3);
    let good = samples::predictive(shape, &images, header(0, Pixels::CubeDistance));
    let payload = |change: &dyn Fn(&mut Vec<u8>)| {
        let mut payload = good.chunks[0].1.payload.clone();
        change(&mut payload);
        let chunk = EncodedChunk { first_frame: 0, frame_count: 3, payload };
        one(Stream { entry: good.entry.clone(), chunks: vec![(0, chunk)] })
    };
    let codec = |at: usize, values: &[u8]| {
        let mut entry = good.entry.clone();
        let mut bytes = entry.codec_header.to_vec();
        bytes[at..at + values.len()].copy_from_slice(values);
        entry.codec_header = bytes.into();
        one(Stream { entry, chunks: good.chunks.clone() })
    };
    let with_levels = |levels: &[u8]| {
        let mut entry = good.entry.clone();
        let mut bytes = entry.codec_header.to_vec();
        // No projection, and levels.
        (bytes[24], bytes[26]) = (0, 1);
        bytes[28..32].fill(0);
        bytes.extend(levels);
        entry.codec_header = bytes.into();
        one(Stream { entry, chunks: good.chunks.clone() })
    };
    let resized = |width: u32, unit: u32| {
        let mut entry = good.entry.clone();
        (entry.width, entry.unit_width) = (width, unit);
        one(Stream { entry, chunks: good.chunks.clone() })
    };
    let alpha = |change: fn(&mut StreamEntry)| {
        let image = vec![vec![255; 400]; 3];
        let mut stream = samples::alpha(shape, &image, AlphaHeader { keyframe_interval: 1 });
        change(&mut stream.entry);
        one(stream)
    };
    let short = "a substream that ends too early";
    let cut = |count: usize| payload(&move |payload| payload.truncate(payload.len() - count));
    vec![
        ("predictive-empty", payload(&|payload| payload.clear()), "1 more bytes expected, 0 left"),
        ("predictive-set", payload(&|payload| payload[0] = 9), "table set 9 is unknown"),
        ("predictive-cut", cut(2), short),
        ("predictive-cut-in-half", cut(101), short),
        (
            "predictive-longer",
            payload(&|payload| payload.extend([0, 0])),
            "a substream that does not end with its last frame",
        ),
        ("predictive-bound", codec(16, &[0xFF, 0xFF]), "a bound of 65535 codes"),
        ("predictive-projection", codec(24, &[3]), "projection 3 is unknown"),
        ("predictive-levels-unknown", codec(26, &[2]), "levels of kind 2 are unknown"),
        (
            "predictive-levels-of-a-cube",
            codec(26, &[1]),
            "levels in a stream with a bound, a threshold or a projection",
        ),
        (
            "alpha-keyframe-interval",
            alpha(|entry| entry.codec_header = vec![0; 4].into()),
            "a keyframe interval of 0 frames",
        ),
        ("alpha-header-longer", alpha(|entry| entry.codec_header = vec![1; 5].into()), "1 bytes after the last field"),
        ("alpha-as-depth", alpha(|entry| entry.kind = 1), "a stream of kind 1 uses codec 'APRD'"),
        ("alpha-tiles", alpha(|entry| entry.unit_width = 1025), "tiles of more than 1024 pixels"),
        ("predictive-levels-missing", with_levels(&[]), "2 more bytes expected, 0 left"),
        ("predictive-levels-none", with_levels(&[0, 0]), "0 levels, 1 to 4096 are legal"),
        ("predictive-levels-too-few", with_levels(&[2, 0, 1, 0]), "2 more bytes expected, 0 left"),
        ("predictive-levels-descend", with_levels(&[2, 0, 9, 0, 8, 0]), "level 8 follows 9, but levels must ascend"),
        ("predictive-levels-background", with_levels(&[1, 0, 0xFF, 0xFF]), "background cannot be a level"),
        ("predictive-own-tables-missing", codec(27, &[1]), "1 more bytes expected, 0 left"),
        ("predictive-own-tables-too-many", codec(27, &[9]), "9 table sets, at most 8 are legal"),
        ("predictive-octave", codec(29, &[1]), "projection 2 with 256 codes"),
        ("predictive-octave-of-none", codec(24, &[0]), "projection 0 with 16384 codes"),
        ("predictive-interval", codec(20, &[0]), "a keyframe interval of 0 frames"),
        ("predictive-not-square", resized(21, 24), "a cube face that is not square"),
        ("predictive-tile", resized(20, 1032), "tiles of more than 1024 pixels"),
    ]
}
