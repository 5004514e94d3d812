//! Round trips at all bounds, and decoding of arbitrary substreams.

use crate::container::EncodedChunk;
use crate::depth::mode_decision::Decide;
use crate::depth::predictive::contexts::Tables;
use crate::depth::predictive::encoder::PredictiveEncoder;
use crate::depth::predictive::projection::{Projection, Shape};
use crate::depth::predictive::{Levels, PredictiveChunk, PredictiveHeader, UnitArea};
use crate::effort::Effort;
use crate::entropy::Trainer;

const BOUNDS: [u16; 8] = [0, 1, 2, 10, 49, 100, 1000, 65_534];

fn header(bound: u16, shape: Shape) -> PredictiveHeader {
    let octave = if shape == Shape::None { 0 } else { 9731 };
    PredictiveHeader {
        bound,
        epsilon: 0,
        keyframe_interval: 64,
        projection: Projection { shape, octave },
        tables: Tables::default(),
        levels: Levels::default(),
    }
}

fn encode(header: &PredictiveHeader, area: UnitArea, frames: &[Vec<u16>], effort: Effort) -> EncodedChunk {
    let mut encoder = PredictiveEncoder::new(header, area, Decide::Mse, effort).unwrap();
    assert!(frames.iter().all(|frame| encoder.push(&header.levels.numbers(frame).unwrap()).is_none()));
    encoder.finish().unwrap()
}

fn decoder(header: &PredictiveHeader, area: UnitArea, chunk: &EncodedChunk) -> PredictiveChunk {
    PredictiveChunk::parse(chunk.payload.clone(), header.clone(), area, chunk.frame_count).unwrap()
}

/// Encodes frames, decodes them in order, and compares every pixel; returns the payload.
fn check(header: &PredictiveHeader, area: UnitArea, frames: &[Vec<u16>], effort: Effort) -> Vec<u8> {
    let chunk = encode(header, area, frames, effort);
    let mut decoded = decoder(header, area, &chunk);
    let mut picture = vec![7; frames[0].len()];
    for (frame, source) in (0u32..).zip(frames) {
        decoded.advance(&mut picture, frame.checked_sub(1), frame).unwrap();
        for (at, (&code, &wanted)) in picture.iter().zip(source).enumerate() {
            assert_eq!(code == u16::MAX, wanted == u16::MAX, "frame {frame} pixel {at}: {wanted} became {code}");
            let most = header.bound + header.epsilon;
            assert!(code.abs_diff(wanted) <= most, "frame {frame} pixel {at}: {wanted} became {code}");
        }
    }
    chunk.payload
}

fn noise(seed: usize) -> u32 {
    (seed as u32).wrapping_mul(2_654_435_761).rotate_left(13).wrapping_mul(0x9E37_79B1) >> 8
}

/// Returns pictures that are hard to code: slopes, edges, noise, background, the first and last codes.
fn pictures([width, height]: [usize; 2]) -> Vec<Vec<Vec<u16>>> {
    let picture = |of: &dyn Fn(usize, usize, usize) -> u32| -> Vec<Vec<u16>> {
        let frame = |t| (0..width * height).map(|at| of(at % width, at / width, t).min(65_535) as u16).collect();
        (0..4).map(frame).collect()
    };
    vec![
        picture(&|_, _, _| 0),
        picture(&|_, _, _| 65_534),
        picture(&|_, _, _| 65_535),
        picture(&|x, y, t| (20_000 + 31 * x + 17 * y + 3 * t) as u32),
        picture(&|x, y, t| if (x + t) / 5 % 2 == 0 { 65_535 } else { (9000 + 250 * y) as u32 }),
        picture(&|x, y, t| if x + y < 9 + 2 * t { 3000 + x as u32 } else { (40_000 + x * x * 9 + y * 50) as u32 }),
        picture(&|x, y, t| noise(x + 1000 * y + 77_777 * t) % 65_536),
        picture(&|x, y, t| {
            if noise(x + 99 * y + t).is_multiple_of(3) { 65_535 } else { 65_534 * (noise(x * y + t) % 2) }
        }),
        picture(&|x, y, _| if (x + y) % 2 == 0 { 0 } else { 65_534 }),
    ]
}

#[test]
fn every_pixel_is_within_every_bound_and_background_is_exact() {
    for size in [[1, 1], [3, 1], [1, 7], [8, 8], [17, 9], [40, 33]] {
        let area = UnitArea::whole(size.map(|side| side as u32));
        for frames in pictures(size) {
            for bound in BOUNDS {
                check(&header(bound, Shape::None), area, &frames, Effort::Normal);
                check(&header(bound, Shape::Planar), area, &frames, Effort::Fast);
            }
        }
    }
    // Parts of a cube face where distance adds the most and the least to depth.
    for rect in [[0, 0, 24, 24], [500, 500, 24, 20], [1000, 0, 24, 24]] {
        let area = UnitArea { rect, image: [1024, 1024] };
        for frames in pictures([rect[2] as usize, rect[3] as usize]) {
            for bound in BOUNDS {
                check(&header(bound, Shape::CubeDistance), area, &frames, Effort::Exhaustive);
            }
        }
    }
}

#[test]
fn a_threshold_adds_to_the_bound_and_saves_bytes() {
    let area = UnitArea::whole([32, 32]);
    let frames: Vec<Vec<u16>> = (0..8).map(|t| (0..1024).map(|at| (noise(at) % 9000) as u16 + t).collect()).collect();
    let exact = check(&header(0, Shape::None), area, &frames, Effort::Normal);
    let loose = check(&PredictiveHeader { epsilon: 8, ..header(0, Shape::None) }, area, &frames, Effort::Normal);
    assert!(2 * loose.len() < exact.len(), "{} of {}", loose.len(), exact.len());
}

#[test]
fn planes_in_space_take_few_bytes() {
    // A wall at 45 degrees to the axis, in a face of distances from 1 m to 16 m.
    let area = UnitArea { rect: [128, 128, 128, 128], image: [256, 256] };
    let code = |at: usize| {
        let [x, y] = [128 + at % 128, 128 + at / 128].map(|at| (2.0 * at as f64 + 1.0) / 256.0 - 1.0);
        let distance = 4.0 / (1.0 - 0.5 * x) * (1.0 + x * x + y * y).sqrt();
        (65_534.0 * distance.ln() / 16f64.ln()).round() as u16
    };
    let frames = vec![(0..128 * 128).map(code).collect::<Vec<u16>>()];
    let projection = Projection { shape: Shape::CubeDistance, octave: 16_384 };
    let with = PredictiveHeader { projection, ..header(10, Shape::None) };
    let [with, without] = [with, header(10, Shape::None)].map(|header| check(&header, area, &frames, Effort::Normal));
    assert!(with.len() < 160 && 2 * with.len() < without.len(), "{} {}", with.len(), without.len());
}

#[test]
fn any_path_shows_the_same_frames() {
    let area = UnitArea::whole([19, 21]);
    for frames in pictures([19, 21]) {
        let header = header(5, Shape::Planar);
        let chunk = encode(&header, area, &frames, Effort::Normal);
        let mut in_order = decoder(&header, area, &chunk);
        let mut picture = vec![0; 19 * 21];
        let mut shown = Vec::new();
        for frame in 0..4u32 {
            in_order.advance(&mut picture, frame.checked_sub(1), frame).unwrap();
            shown.push(picture.clone());
        }
        let mut other = decoder(&header, area, &chunk);
        let mut at = None;
        for frame in [2, 2, 0, 3, 1, 0, 3] {
            other.advance(&mut picture, at, frame).unwrap();
            assert_eq!(picture, shown[frame as usize]);
            at = Some(frame);
        }
        // A picture that shows no frame yet, with a chunk that was decoded before.
        let mut fresh = vec![1; 19 * 21];
        other.advance(&mut fresh, None, 3).unwrap();
        assert_eq!(fresh, shown[3]);
    }
}

#[test]
fn frames_take_the_bits_of_the_payload_and_say_what_they_write() {
    let area = UnitArea::whole([19, 21]);
    for frames in pictures([19, 21]) {
        let chunk = encode(&header(5, Shape::Planar), area, &frames, Effort::Normal);
        let (mut bits, mut before, mut pixels) = (0.0, Vec::new(), Vec::new());
        let decoded = decoder(&header(5, Shape::Planar), area, &chunk);
        decoded
            .for_each_frame(|frame| {
                bits += frame.bits;
                let of_blocks: f64 = frame.blocks.iter().map(|block| block.bits).sum();
                assert!(of_blocks <= frame.bits + 1e-6);
                let mut written = vec![false; 19 * 21];
                for [left, top, width, height] in frame.written() {
                    for (x, y) in (top..top + height).flat_map(|y| (left..left + width).map(move |x| (x, y))) {
                        assert!(!std::mem::replace(&mut written[(y * 19 + x) as usize], true));
                    }
                }
                let count = written.iter().filter(|written| **written).count() as u64;
                assert_eq!((frame.frame == 0, frame.updated_pixels), (before.is_empty(), count));
                let mut pairs = frame.picture.iter().zip(&before).zip(&written);
                assert!(pairs.all(|((now, before), written)| now == before || *written));
                before = frame.picture.to_vec();
                pixels.push(frame.updated_pixels);
                Ok(())
            })
            .unwrap();
        assert_eq!((pixels.len(), pixels[0]), (4, 19 * 21));
        // One byte is the number of the table set, and the state takes 16 bits in a decoder at the end of the substream.
        let stored = 8.0 * (chunk.payload.len() as f64 - 1.0);
        assert!(bits <= stored && bits >= stored - 32.0, "{bits} of {stored}");
    }
}

#[test]
fn a_substream_that_is_cut_or_goes_on_is_refused() {
    let area = UnitArea::whole([16, 16]);
    let frames = pictures([16, 16]).remove(6);
    let header = header(0, Shape::None);
    let chunk = encode(&header, area, &frames, Effort::Normal);
    let parse = |payload: Vec<u8>, area, frames| PredictiveChunk::parse(payload, header.clone(), area, frames);
    let with = |payload: Vec<u8>| parse(payload, area, 4).and_then(|chunk| chunk.check());
    with(chunk.payload.clone()).unwrap();
    assert!(with([&chunk.payload[..], &[0, 0]].concat()).is_err());
    for length in (0..chunk.payload.len()).step_by(7) {
        assert!(with(chunk.payload[..length].to_vec()).is_err(), "{length}");
    }
    assert!(with([&[8], &chunk.payload[1..]].concat()).is_err());
    assert!(parse(chunk.payload.clone(), UnitArea::whole([1025, 1]), 4).is_err());
    assert!(parse(chunk.payload, area, 4097).is_err());
}

#[test]
fn any_bytes_are_decoded_or_refused_in_one_sentence() {
    let area = UnitArea { rect: [240, 240, 16, 12], image: [256, 256] };
    for seed in 0..400 {
        let shape = [Shape::None, Shape::Planar, Shape::CubeDistance][seed % 3];
        let header = PredictiveHeader {
            projection: Projection { shape, octave: if shape == Shape::None { 0 } else { [512, 131_071][seed % 2] } },
            ..header(BOUNDS[seed % BOUNDS.len()], shape)
        };
        let levels = Levels::new(vec![9, 700, 701]).unwrap();
        let header = if seed % 4 == 0 { PredictiveHeader { levels, ..self::header(0, Shape::None) } } else { header };
        let mut payload: Vec<u8> = (0..600).map(|at| noise(seed * 1009 + at) as u8).collect();
        payload[0] %= 9;
        let mut chunk = PredictiveChunk::parse(payload, header, area, 100).unwrap();
        let mut picture = vec![0; 16 * 12];
        let failed = (0..100).find_map(|frame: u32| chunk.advance(&mut picture, frame.checked_sub(1), frame).err());
        let message = failed.expect("random bytes do not end where frames do").to_string();
        assert!(message.contains("a substream that"), "{message}");
    }
}

#[test]
fn few_codes_far_apart_take_fewer_bytes_by_number() {
    let area = UnitArea::whole([40, 24]);
    let codes: Vec<u16> = (0..90).map(|at| 2000 + at * 153 + at * at).collect();
    let code = |at: usize, t: usize| match at % 97 {
        0..7 => u16::MAX,
        _ => codes[at % 40 + at / 80 + noise(at + 1000 * t) as usize % 2],
    };
    let frames: Vec<Vec<u16>> = (0..3).map(|t| (0..960).map(|at| code(at, t)).collect()).collect();
    let plain = check(&header(0, Shape::None), area, &frames, Effort::Normal);
    let levels = PredictiveHeader { levels: Levels::new(codes.clone()).unwrap(), ..header(0, Shape::None) };
    let by_number = check(&levels, area, &frames, Effort::Normal);
    assert!(2 * by_number.len() < plain.len(), "{} and {} bytes", by_number.len(), plain.len());
}

#[test]
fn a_chunk_is_closed_before_its_symbols_take_much_memory() {
    let area = UnitArea::whole([64, 64]);
    let header = PredictiveHeader { keyframe_interval: 1000, ..header(0, Shape::None) };
    let mut encoder = PredictiveEncoder::new(&header, area, Decide::Size, Effort::Fast).unwrap();
    let mut frames = Vec::new();
    for t in 0..40 {
        let picture: Vec<u16> = (0..4096).map(|at| noise(at + 5000 * t) as u16).collect();
        frames.extend(encoder.push(&picture).map(|chunk| chunk.frame_count));
    }
    frames.extend(encoder.finish().map(|chunk| chunk.frame_count));
    assert!(frames.len() > 1 && frames.iter().sum::<u32>() == 40, "{frames:?}");
}

#[test]
fn chunks_are_counted_and_take_the_cheapest_of_own_sets() {
    let area = UnitArea::whole([40, 24]);
    let frames: Vec<Vec<u16>> =
        (0..3).map(|t| (0..960).map(|at| (9000 + at % 40 * 90 + (at * at * 31 + t) % 61) as u16).collect()).collect();
    let plain = header(2, Shape::None);
    let chunk = encode(&plain, area, &frames, Effort::Normal);
    let counted = decoder(&plain, area, &chunk).count().unwrap();
    assert_eq!(counted.bytes, chunk.payload.len() as u64);
    // Symbols take most of the payload, because raw bits are few in these frames.
    let part = counted.bits / 8.0 / counted.bytes as f64;
    assert!((0.5..=1.0).contains(&part), "{part}");
    let own = Trainer::new(vec![counted]).train(1);
    let with_own = PredictiveHeader { tables: Tables::with_own(own), ..plain };
    let smaller = encode(&with_own, area, &frames, Effort::Normal);
    assert_eq!(smaller.payload[0], 9, "the own set is the cheapest");
    assert!(smaller.payload.len() < chunk.payload.len(), "{} and {} bytes", smaller.payload.len(), chunk.payload.len());
    check(&with_own, area, &frames, Effort::Normal);
}
