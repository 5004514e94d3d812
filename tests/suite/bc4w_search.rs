//! Compares the search for BC4w blocks with the literal search of GDC, on random blocks and on footage.

mod literal;

use rayon::prelude::*;

use codec::depth::bc4w::search::{encode, encode_within};
use codec::depth::bc4w::tile::Tile;
use codec::depth::bc4w::{Bc4w, Line, MARKER_BYTES, MAX_ENDPOINT, Pair};
use codec::depth::block::{Accuracy, Block, BlockMut};
use codec::effort::Effort;

/// Maximum mean loss of the faster efforts on adversarial blocks, in dB.
const NORMAL_LOSS_DB: f64 = 0.9;
const FAST_LOSS_DB: f64 = 1.7;
/// The literal search takes minutes for all blocks: it searches one of so many, all of them with `scripts/test all`.
const SAMPLED: usize = 8;
const EFFORTS: [Effort; 3] = [Effort::Fast, Effort::Normal, Effort::Exhaustive];

/// True if the literal search searches a block, by its number.
fn is_sampled(block: usize) -> bool {
    block.is_multiple_of(SAMPLED) || std::env::var_os("LIGHTFOLD_TESTS").is_some_and(|which| which == "all")
}

/// Seeded random numbers.
struct Random(u64);

impl Random {
    fn below(&mut self, end: u32) -> u32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (((self.0 >> 33) * u64::from(end)) >> 31) as u32
    }
}

/// Encodes `codes` with rows of `width` pixels as one block, verifies it, and returns the accuracy that the encoder reports.
fn check(codes: &[u16], width: usize, effort: Effort) -> Accuracy {
    let (coded, accuracy) = encode(&Block::of(codes, width, 1, [0, 0]), effort);
    verify(codes, width, coded, accuracy);
    accuracy
}

/// Decodes the block and compares its accuracy with the one that the encoder reports. No block may be read as a marker.
fn verify(codes: &[u16], width: usize, coded: Bc4w, accuracy: Accuracy) {
    assert_ne!(coded.as_bytes()[MARKER_BYTES], [0xff; 4]);
    assert_eq!(Bc4w::from_bytes(*coded.as_bytes()), Some(coded));
    let mut decoded = vec![0; codes.len()];
    coded.decode(&mut BlockMut::of(&mut decoded, width, 1, [0, 0]));
    assert_eq!(Block::of(codes, width, 1, [0, 0]).accuracy(&decoded), Some(accuracy), "{codes:?}");
}

fn decoded(bytes: [u8; 32]) -> Vec<u16> {
    let mut codes = vec![0; 64];
    Bc4w::from_bytes(bytes).unwrap().decode(&mut BlockMut::of(&mut codes, 8, 1, [0, 0]));
    codes
}

#[test]
fn both_modes_as_written_by_hand() {
    // Each row has the indices 0 to 7. Side A is the right half, with eight codes from 65535 down to 0. Side B, x < 4, has six
    // codes from 8 up to 2000, code 0 and the background.
    let mut bytes = [0; 32];
    bytes[..24].chunks_exact_mut(3).for_each(|row| row.copy_from_slice(&[0x88, 0xc6, 0xfa]));
    let line = 4u64 | 4 << 6 | 7 << 9;
    let tail = 8191 | 1 << 26 | 250 << 39 | line << 52;
    bytes[24..].copy_from_slice(&tail.to_le_bytes());
    assert_eq!(decoded(bytes)[..8], [8, 2000, 406, 805, 37449, 28086, 18724, 9362]);
    assert_eq!(decoded(bytes).chunks_exact(8).filter(|row| *row == &decoded(bytes)[..8]).count(), 8);
    let block = Bc4w::from_bytes(bytes).unwrap();
    assert_eq!(block.pairs(), [Pair { e0: 8191, e1: 0 }, Pair { e0: 1, e1: 250 }]);
    assert_eq!(block.palettes()[1], [8, 2000, 406, 805, 1203, 1602, 0, 65535]);
    assert_eq!(block.line().points(), [[4, 0], [4, 7]]);
    // Equal endpoints select the second mode. Without a line all pixels are on side A.
    bytes[24..].copy_from_slice(&(3000u64 | 3000 << 13 | 7 << 26).to_le_bytes());
    assert_eq!(decoded(bytes)[..8], [24002, 24002, 24002, 24002, 24002, 24002, 0, 65535]);
}

#[test]
fn palettes_end_at_their_endpoints() {
    assert_eq!([0, 1, 1023, 1024, 8190, 8191].map(Pair::code), [0, 8, 8184, 8193, 65527, 65535]);
    for (e0, e1) in [(0, 0), (1, 0), (0, 1), (8191, 8191), (8191, 8190), (8190, 8191), (8191, 0), (0, 8191)] {
        let palette = Pair { e0, e1 }.palette();
        assert_eq!(palette[..2], [Pair::code(e0), Pair::code(e1)]);
        let between = &palette[2..if e0 > e1 { 8 } else { 6 }];
        assert!(between.is_sorted_by(|a, b| if e0 > e1 { a >= b } else { a <= b }), "{palette:?}");
        let [low, high] = [palette[0].min(palette[1]), palette[0].max(palette[1])];
        assert!(between.iter().all(|code| (low..=high).contains(code)), "{palette:?}");
    }
}

#[test]
fn markers_are_none_and_are_not_written() {
    assert_eq!(Bc4w::from_bytes([0xff; 32]), None);
    let mut bytes = [0xff; 32];
    bytes[28] = 0xfe;
    assert!(Bc4w::from_bytes(bytes).is_some());
    // The largest endpoints, with each line of two equal points.
    let pair = Pair { e0: MAX_ENDPOINT, e1: MAX_ENDPOINT };
    for point in 0..64 {
        let packed = Bc4w::pack(Line::from_bits(point | point << 6), [pair; 2], &[7; 64]);
        assert_eq!((packed.line(), packed.as_bytes()[31]), (Line::NONE, 0));
    }
    for bits in 0..4096 {
        let packed = Bc4w::pack(Line::from_bits(bits), [pair; 2], &[7; 64]);
        assert_ne!(packed.as_bytes()[MARKER_BYTES], [0xff; 4]);
        assert_eq!(packed.line().side_b(), Line::from_bits(bits).side_b());
    }
}

#[test]
fn constants() {
    for code in [0, 1, 4, 1000, 65534, 65535] {
        for effort in EFFORTS {
            let accuracy = check(&[code; 64], 8, effort);
            assert!(accuracy.max_error <= 1, "{code} {effort:?} {accuracy:?}");
        }
    }
    assert_eq!(check(&[65535; 64], 8, Effort::Fast).squared_error, 0);
}

#[test]
fn one_odd_pixel() {
    for (most, odd) in [(1000, 60000), (0, 65534), (65534, 0), (65535, 0), (65535, 65534), (0, 65535), (30000, 65535)] {
        for at in [0, 7, 56, 63, 27] {
            let mut codes = [most; 64];
            codes[at] = odd;
            for effort in [Effort::Fast, Effort::Normal] {
                let accuracy = check(&codes, 8, effort);
                assert!(accuracy.max_error <= 7, "{most} {odd} at {at}: {accuracy:?}");
            }
        }
    }
}

#[test]
fn checkerboards_and_steps() {
    let board =
        |a: u16, b: u16| -> Vec<u16> { (0..64).map(|at| if (at ^ at >> 3) & 1 == 0 { a } else { b }).collect() };
    for effort in [Effort::Fast, Effort::Normal] {
        assert_eq!(check(&board(0, 65535), 8, effort).squared_error, 0);
        assert!(check(&board(0, 65534), 8, effort).max_error <= 7);
        assert!(check(&board(20000, 65535), 8, effort).max_error <= 4);
        assert!(check(&board(65534, 65535), 8, effort).max_error <= 7);
        for x in 1..8 {
            let step: Vec<u16> = (0..64).map(|at| if at % 8 < x { 0 } else { 65535 }).collect();
            assert_eq!(check(&step, 8, effort).squared_error, 0);
        }
    }
}

#[test]
fn partial_blocks_are_measured_inside() {
    let mut random = Random(5);
    for width in 1..=8 {
        for height in 1..=8 {
            let codes: Vec<u16> = (0..width * height)
                .map(|_| if random.below(5) == 0 { 65535 } else { 40000 + random.below(50) as u16 })
                .collect();
            let [_, normal] = [Effort::Fast, Effort::Normal].map(|effort| check(&codes, width, effort));
            if width * height <= 2 {
                assert!(normal.max_error <= 2);
            }
        }
    }
}

/// Returns codes that are hard to search: ramps, steps along lines, noise, clusters, ties, scattered background.
fn adversarial(seed: u64) -> Vec<u16> {
    let mut random = Random(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15));
    random.below(2);
    let range = [2, 9, 20, 40, 70, 100][random.below(6) as usize];
    let base = [0, 8150, 20_000, 40_003, 65_534 - range][random.below(5) as usize];
    let kind = random.below(7);
    let line = Line::from_bits(random.below(4096) as u16).side_b();
    let [dx, dy, dxy] = std::array::from_fn(|_| random.below(2 * range + 1) as i32 - range as i32);
    let levels = 2 + random.below(6);
    (0..64)
        .map(|at| {
            let (x, y) = (at & 7, at >> 3);
            let noise = random.below(range + 1);
            let value = match kind {
                0 => ((dx * x + dy * y) / 14).unsigned_abs(),
                1 => range * u32::from(line >> at & 1 != 0) + noise / 4,
                2 => noise,
                3 => (noise * levels / (range + 1)) * range / levels,
                4 => ((dx * x + dy * y) / 14 + dxy * x * y / 49).unsigned_abs() / 2 + noise / 16,
                5 => {
                    if (x + y) & 1 == 0 {
                        range
                    } else {
                        noise / 8
                    }
                }
                _ => (range / 2) * u32::from(line >> at & 1 != 0) + ((dx * x) / 14).unsigned_abs() / 2,
            };
            let background = seed.is_multiple_of(5) && (random.below(4) == 0 || line >> at & 1 != 0);
            if background { 65535 } else { (base + value.min(range)) as u16 }
        })
        .collect()
}

/// Returns the accuracy of the literal search within a bound.
fn literally(codes: &[u16], bound: u16) -> Option<Accuracy> {
    let tile = Tile::new(&Block::of(codes, 8, 1, [0, 0]), bound);
    literal::search(&tile).map(|solution| tile.finish(solution).1)
}

#[test]
fn exhaustive_finds_what_the_literal_search_finds_and_normal_comes_close() {
    let decibels =
        |errors: &mut dyn Iterator<Item = u64>| errors.map(|e| 10.0 * (e.max(1) as f64).log10()).sum::<f64>();
    let errors: Vec<[u64; 3]> = (0..2000)
        .into_par_iter()
        .map(|seed| {
            let codes = adversarial(seed);
            let [fast, normal, exhaustive] = EFFORTS.map(|effort| check(&codes, 8, effort).squared_error);
            if is_sampled(seed as usize) {
                let literal = literally(&codes, u16::MAX).map(|accuracy| accuracy.squared_error);
                assert_eq!(Some(exhaustive), literal, "seed {seed}: {codes:?}");
            }
            assert!(exhaustive <= normal && exhaustive <= fast, "seed {seed}: {codes:?}");
            [fast, normal, exhaustive]
        })
        .collect();
    let [fast, normal, exhaustive] = [0, 1, 2].map(|at| decibels(&mut errors.iter().map(|e| e[at])) / 2000.0);
    println!("loss on adversarial blocks: fast {:.3} dB, normal {:.3} dB", fast - exhaustive, normal - exhaustive);
    assert!(normal - exhaustive < NORMAL_LOSS_DB && fast - exhaustive < FAST_LOSS_DB && normal <= fast);
}

#[test]
fn within_a_bound_exhaustive_finds_what_the_literal_search_finds() {
    (0..60).into_par_iter().for_each(|seed| {
        let codes = adversarial(seed);
        let block = Block::of(&codes, 8, 1, [0, 0]);
        let plain = encode(&block, Effort::Exhaustive).1;
        for bound in [1, plain.max_error - plain.max_error.min(1), plain.max_error, 40] {
            let found = EFFORTS.map(|effort| encode_within(&block, bound, effort));
            for (coded, accuracy) in found.into_iter().flatten() {
                verify(&codes, 8, coded, accuracy);
                assert!(accuracy.max_error <= bound);
            }
            let error = |found: Option<(Bc4w, Accuracy)>| found.map(|(_, accuracy)| accuracy.squared_error);
            let [fast, normal, exhaustive] = found.map(error);
            let literal = literally(&codes, bound).map(|accuracy| accuracy.squared_error);
            assert_eq!(exhaustive, literal, "seed {seed} within {bound}: {codes:?}");
            assert!(exhaustive.is_some() || (fast.is_none() && normal.is_none()));
            assert!(bound < plain.max_error || exhaustive == Some(plain.squared_error));
        }
    });
}

#[cfg_attr(not(all_tests), ignore = "long: scripts/test all runs it")]
#[test]
fn wide_ranges_are_coded_and_never_read_as_markers() {
    (0..3000u64).into_par_iter().for_each(|seed| {
        let mut random = Random(seed);
        let kind = random.below(4);
        let codes: Vec<u16> = (0..64)
            .map(|at| match kind {
                0 => random.below(65536) as u16,
                1 => 65535 - random.below(9) as u16,
                2 => {
                    if at % 8 > at / 8 {
                        65535
                    } else {
                        65534 - random.below(3) as u16
                    }
                }
                _ => [0, 1, 65534, 65535][random.below(4) as usize],
            })
            .collect();
        check(&codes, 8, Effort::Fast);
        check(&codes, 8, Effort::Normal);
    });
}

#[cfg(footage_at_hand)]
fn real_tiles() -> Vec<Vec<u16>> {
    use codec::depth::DepthRange;
    use codec::image::ReadLimits;
    use codec::image::channels::ChannelSelect;
    use footage::image_files::exr;
    let data = std::path::Path::new(env!("LIGHTFOLD_DATA")).join("sponza1k/probe_00");
    let range = DepthRange::new(1.4573, 15.351).unwrap();
    let mut tiles = Vec::new();
    for face in ["face_px", "face_nz"] {
        let file = data.join(face).join("depth.0000.exr");
        let plane = exr::read_depth(&file, &ChannelSelect::Auto, &ReadLimits::default()).unwrap();
        for at in (0..16384).step_by(29) {
            let (left, top) = (at % 128 * 8, at / 128 * 8);
            let row = |y: u32| plane.row(top + y)[left as usize..left as usize + 8].iter().map(|&z| range.code(z));
            tiles.push((0..8).flat_map(row).collect());
        }
    }
    tiles
}

#[cfg(not(footage_at_hand))]
fn real_tiles() -> Vec<Vec<u16>> {
    Vec::new()
}

/// The time of the literal search is proportional to the square of the range of codes, so tiles with a range above 500 codes are
/// skipped.
#[test]
#[cfg_attr(not(footage_at_hand), ignore = "no footage at hand: see LIGHTFOLD_DATA in CONTRIBUTING.md")]
#[cfg_attr(all(footage_at_hand, not(all_tests)), ignore = "long: scripts/test all runs it")]
fn exhaustive_finds_what_the_literal_search_finds_in_real_tiles() {
    let narrow = |codes: &Vec<u16>| codes.iter().max().zip(codes.iter().min()).is_some_and(|(a, b)| a - b <= 500);
    let tiles: Vec<Vec<u16>> = real_tiles().into_iter().filter(narrow).collect();
    assert!(tiles.len() > 500, "{} tiles", tiles.len());
    let losses: Vec<[f64; 2]> = tiles
        .par_iter()
        .enumerate()
        .map(|(at, codes)| {
            let [fast, normal, exhaustive] = EFFORTS.map(|effort| check(codes, 8, effort).squared_error);
            if is_sampled(at) {
                assert_eq!(Some(exhaustive), literally(codes, u16::MAX).map(|a| a.squared_error), "{codes:?}");
            }
            assert!(exhaustive <= normal && exhaustive <= fast);
            [fast, normal].map(|error| 10.0 * (error.max(1) as f64 / exhaustive.max(1) as f64).log10())
        })
        .collect();
    let mean = |at: usize| losses.iter().map(|loss| loss[at]).sum::<f64>() / losses.len() as f64;
    println!("{} real blocks: fast loses {:.3} dB, normal {:.3} dB", losses.len(), mean(0), mean(1));
}
