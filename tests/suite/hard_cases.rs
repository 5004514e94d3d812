//! Inputs that are numerically hard, each with the bound that must hold and, printed, what was measured.
//!
//! `cargo test --test suite hard_cases -- --nocapture` prints the table.

use lightfold::depth::block::{Block, BlockMut};
use lightfold::depth::block_chunk::{BlockChunk, BlockEncoder};
use lightfold::depth::domain::{Domain, DomainKind};
use lightfold::depth::mode_decision::Decide;
use lightfold::depth::node_chunk::NodeChunk;
use lightfold::depth::node_encoder::{NodeEncoder, NodeSettings};
use lightfold::depth::nodes::Grid;
use lightfold::depth::{BACKGROUND_CODE, DepthRange};
use lightfold::effort::Effort;
use rayon::prelude::*;

use crate::samples::Random;

/// Bounds that every case is held to, in codes.
const BOUNDS: [u16; 7] = [0, 1, 10, 30, 100, 300, 1000];

/// A picture from a function of column and row.
type Generator = fn(usize, usize) -> f64;

struct Case {
    name: &'static str,
    size: [usize; 2],
    pixel: Generator,
}

const fn case(name: &'static str, size: [usize; 2], pixel: Generator) -> Case {
    Case { name, size, pixel }
}

const BACKGROUND: f64 = 65535.0;

/// A number below `n` that depends on the pixel alone.
fn noise(x: usize, y: usize, n: u32) -> f64 {
    f64::from(Random((x as u64) << 32 | y as u64 ^ 0x9E37_79B9).below(n))
}

const CASES: &[Case] = &[
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

impl Case {
    fn picture(&self) -> Vec<u16> {
        let [width, height] = self.size;
        (0..width * height).map(|at| (self.pixel)(at % width, at / width).clamp(0.0, 65535.0) as u16).collect()
    }

    fn grid(&self) -> Grid {
        Grid { width: self.size[0] as u32, height: self.size[1] as u32 }
    }

    /// Three frames: the picture, the same moved by three columns, and the picture again.
    fn frames(&self) -> Vec<Vec<u16>> {
        let (first, width) = (self.picture(), self.size[0]);
        let mut moved = first.clone();
        moved.chunks_mut(width).for_each(|row| row.rotate_left(3.min(width - 1)));
        vec![first.clone(), moved, first]
    }
}

/// The largest error of a surface, and whether background and surfaces were ever confused.
fn compare(decoded: &[u16], source: &[u16]) -> (u16, bool) {
    let confused = |(a, b): (&u16, &u16)| (*a == BACKGROUND_CODE) != (*b == BACKGROUND_CODE);
    let error = decoded.iter().zip(source).map(|(a, b)| a.abs_diff(*b)).max().unwrap_or(0);
    (error, decoded.iter().zip(source).any(confused))
}

/// Encodes frames as packed nodes and decodes each of them; the largest error of all.
fn round_trip(frames: &[Vec<u16>], grid: Grid, domain: &Domain, settings: NodeSettings) -> (u16, bool) {
    let mut encoder = NodeEncoder::new(grid, domain.clone(), settings);
    let mut chunks = Vec::new();
    for frame in frames {
        chunks.extend(encoder.push(frame, None).unwrap());
    }
    chunks.extend(encoder.finish().unwrap());
    let mut worst = (0, false);
    for chunk in chunks {
        // A decoder has what the header says of the domain, and no more.
        let domain = domain.parts().domain().unwrap();
        let parsed = NodeChunk::parse(chunk.payload, grid, chunk.frame_count, domain).unwrap();
        for frame in 0..chunk.frame_count {
            let mut picture = vec![0; grid.pixel_count() as usize];
            parsed.advance(&mut picture, None, frame, settings.window);
            let (error, confused) = compare(&picture, &frames[(chunk.first_frame + frame) as usize]);
            worst = (worst.0.max(error), worst.1 || confused);
        }
    }
    worst
}

#[test]
fn every_hard_case_keeps_every_bound() {
    let range = DepthRange::new(0.5, 900.0).unwrap();
    let rows: Vec<String> = CASES
        .par_iter()
        .map(|case| {
            let frames = case.frames();
            let mut measured = vec![0u16; BOUNDS.len()];
            for kind in DomainKind::ALL {
                let domain = Domain::new(kind, range).unwrap();
                for decide in [Decide::Mse, Decide::Size] {
                    for (at, &bound) in BOUNDS.iter().enumerate() {
                        let settings = NodeSettings { bound, decide, effort: Effort::Fast, ..NodeSettings::default() };
                        let (error, confused) = round_trip(&frames, case.grid(), &domain, settings);
                        let name = case.name;
                        assert!(error <= bound, "{name}: {error} codes at a bound of {bound}, {kind:?}, {decide:?}");
                        assert!(!confused, "{name}: background confused at a bound of {bound}, {kind:?}, {decide:?}");
                        measured[at] = measured[at].max(error);
                    }
                }
            }
            let measured: Vec<String> = measured.iter().map(|error| format!("{error:>5}")).collect();
            format!("{:<42} {}", case.name, measured.join(" "))
        })
        .collect();
    let head: Vec<String> = BOUNDS.iter().map(|bound| format!("{bound:>5}")).collect();
    println!("{:<42} {}", "largest error in codes at a bound of", head.join(" "));
    rows.iter().for_each(|row| println!("{row}"));
}

#[test]
fn plain_blocks_keep_the_background_of_every_hard_case() {
    CASES.par_iter().for_each(|case| {
        for effort in [Effort::Fast, Effort::Normal] {
            let mut encoder = BlockEncoder::new(case.grid(), effort, 1);
            encoder.push(&case.picture());
            let chunk = encoder.finish().unwrap();
            assert_eq!(chunk.payload.len(), case.size[0].div_ceil(8) * case.size[1].div_ceil(8) * 32);
            let mut picture = vec![0; case.picture().len()];
            BlockChunk::parse(chunk.payload, case.grid(), 1).unwrap().show(&mut picture, 0);
            let (error, confused) = compare(&picture, &case.picture());
            assert!(!confused, "{}", case.name);
            if case.name.starts_with("constant") || case.name.starts_with("checkerboard") {
                // 13 bits of an endpoint are within 4 codes of any code but the last ones: beside the background, which
                // takes endpoint 8191, that is 65527.
                assert!(error <= 7, "{}: {error}", case.name);
            }
        }
    });
}

#[test]
fn a_pixel_that_flickers_and_one_that_creeps_stay_within_bound_and_epsilon() {
    let grid = Grid { width: 24, height: 20 };
    let frames: Vec<Vec<u16>> = (0..600u16)
        .map(|frame| {
            let mut picture: Vec<u16> = (0..480).map(|at| 20_000 + 5 * (at % 24)).collect();
            picture[100] = if frame % 2 == 0 { 0 } else { BACKGROUND_CODE };
            picture[300] = 1000 + frame;
            picture[301] = 1000 + 3 * frame;
            picture
        })
        .collect();
    let domain = Domain::new(DomainKind::Log, DepthRange::new(1.0, 50.0).unwrap()).unwrap();
    for (bound, epsilon, window) in [(0, 0, 2), (10, 0, 1), (10, 7, 3), (100, 20, 2)] {
        let settings = NodeSettings { bound, epsilon, window, keyframe_interval: 1000, ..NodeSettings::default() };
        let (error, confused) = round_trip(&frames, grid, &domain, settings);
        assert!(error <= bound + epsilon && !confused, "{error} codes at {bound} + {epsilon}");
    }
}

#[test]
fn a_block_beyond_the_picture_touches_nothing_outside() {
    let picture = vec![9u16; 5 * 7];
    let block = Block::of(&picture, 5, 2, [0, 0]);
    assert_eq!(block.pixel_count(), 35);
    let mut target = vec![1u16; 5 * 7];
    BlockMut::of(&mut target, 5, 1, [0, 0]).rows_mut().for_each(|row| row.fill(2));
    assert_eq!(target, vec![2; 35]);
    BlockMut::of(&mut target, 5, 1, [4, 4]).rows_mut().for_each(|row| row.fill(3));
    assert_eq!(target.iter().filter(|&&code| code == 3).count(), 3);
}
