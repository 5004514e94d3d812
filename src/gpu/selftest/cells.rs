//! Inputs of the colour kernels: every pair of bytes at every weight, edge cases of half floats, odd offsets, block-compressed
//! keyframes.

use crate::harness::Case;
use crate::selftest::gathered::Gathered;
use codec::color::cells::builder::CellBuilder;
use codec::color::{CellChunk, CellFormat, HalfKey, KeyframeBlocks, Sample};
use codec::math::random::Random;
use kernels::layout::{Job, Record, Unit};
use kernels::pictures::{pack_bytes, pack_halves};
use kernels::prepare::{self, Prepared};

pub trait CellSample: Sample {
    /// Returns a random value, often an edge case.
    fn random(random: &mut Random) -> Self;

    fn pack(samples: &[Self]) -> Vec<u32>;
}

impl CellSample for u8 {
    fn random(random: &mut Random) -> u8 {
        random.word() as u8
    }

    fn pack(samples: &[u8]) -> Vec<u32> {
        samples.as_chunks().0.iter().map(|&pixel| pack_bytes(pixel)).collect()
    }
}

/// Edge cases of half floats: zeros, subnormals, ones, the largest numbers, infinities, NaNs.
const HALVES: [u16; 16] = [
    0x0000, 0x8000, 0x0001, 0x8001, 0x03ff, 0x0400, 0x3c00, 0xbc00, 0x7bff, 0xfbff, 0x7c00, 0xfc00, 0x7c01, 0xfe00,
    0x7fff, 0xffff,
];

impl CellSample for HalfKey {
    fn random(random: &mut Random) -> HalfKey {
        let edge = random.pick(&HALVES).filter(|_| random.one_in(3));
        HalfKey::from_bits(edge.unwrap_or(random.word() as u16))
    }

    fn pack(samples: &[HalfKey]) -> Vec<u32> {
        samples.as_chunks().0.iter().flat_map(|pixel: &[HalfKey; 3]| pack_halves(pixel.map(HalfKey::to_bits))).collect()
    }
}

#[derive(Clone)]
enum Keyframe<S> {
    Samples(Vec<S>),
    Blocks(Vec<u8>),
}

impl<S: CellSample> Keyframe<S> {
    /// Returns random samples or, for a block-compressed format, usually random blocks.
    fn random(format: &CellFormat<S>, random: &mut Random) -> Keyframe<S> {
        match format.blocks {
            Some(blocks) if !random.one_in(4) => {
                let mut bytes = vec![0; blocks.image_bytes(format.size)];
                random.fill(&mut bytes);
                Keyframe::Blocks(bytes)
            }
            _ => Keyframe::Samples((0..3 * format.pixels()).map(|_| S::random(random)).collect()),
        }
    }

    fn push(&self, format: &CellFormat<S>, builder: &mut CellBuilder) {
        match self {
            Keyframe::Blocks(blocks) => builder.push_keyframe_in_blocks(blocks),
            Keyframe::Samples(samples) if format.blocks.is_some() => builder.push_keyframe_as_samples(samples),
            Keyframe::Samples(samples) => builder.push_keyframe(samples),
        }
    }
}

pub fn push_random_keyframe<S: CellSample>(format: &CellFormat<S>, builder: &mut CellBuilder, random: &mut Random) {
    Keyframe::random(format, random).push(format, builder);
}

struct Between<S> {
    format: CellFormat<S>,
    keyframes: [Keyframe<S>; 2],
}

impl<S: CellSample> Between<S> {
    fn random(size: [usize; 2], blocks: Option<KeyframeBlocks<S>>, random: &mut Random) -> Between<S> {
        let format = CellFormat { size, blocks };
        let mut keyframe = || Keyframe::random(&format, random);
        let keyframes = [keyframe(), keyframe()];
        Between { format, keyframes }
    }
}

/// Adds cells that blend the same pair of keyframes, one per weight. `lead` weights precede the second keyframe, so that its
/// samples start at any byte offset.
fn push<S: CellSample>(all: &mut Gathered, cell: &Between<S>, weights: &[u8], lead: u32) {
    let mut builder = CellBuilder::default();
    cell.keyframes[0].push(&cell.format, &mut builder);
    builder.push_weight(1, lead);
    cell.keyframes[1].push(&cell.format, &mut builder);
    let frames = builder.frame_count();
    let pixels = cell.format.pixels();
    let Ok(payload) = builder.finish() else { return };
    let Ok(chunk) = CellChunk::parse(payload, cell.format, frames) else { return };
    let [a, b] = [0, 1].map(|keyframe| {
        let mut samples = vec![S::default(); 3 * pixels];
        chunk.read_keyframe(keyframe, &mut samples);
        samples
    });
    let Prepared { stream, records, .. } = prepare::of_cells(&chunk);
    let (bytes, first) = (4 * all.stream.len() as u32, all.records.len() as u32);
    all.records.extend(records.iter().map(|row| Record { at: row.at + bytes, ..*row }));
    all.stream.extend(stream);
    let [width, height] = cell.format.size.map(|side| side as u32);
    for &weight in weights {
        let shown: Vec<S> = a.iter().zip(&b).map(|(&a, &b)| S::lerp(a, b, weight)).collect();
        let unit = all.push_unit(Unit { width, height, ..Unit::default() }, S::pack(&shown));
        let job = Job { unit, record: first, next: first + u32::from(weight > 0), weight: weight.into(), end: 0 };
        all.push_job(job, records[0].work);
        all.pixels += pixels as u64;
        all.inputs += 1;
    }
}

/// Returns a case of one pair of keyframes at every weight, then random cases.
fn cases<S: CellSample>(seed: u64, label: &str, cell: &Between<S>, lead: u32) -> Vec<Case> {
    let mut pairs = Gathered::default();
    push(&mut pairs, cell, &(0..=u8::MAX).collect::<Vec<_>>(), lead);
    [vec![pairs.case(label)], random_cases::<S>(seed, None)].concat()
}

pub(super) fn bytes(seed: u64) -> Vec<Case> {
    // Every pair of bytes; the last sample pads the pixel.
    let pair = |half: u32| Keyframe::Samples((0..65_538u32).map(|at| (at >> (8 * half)) as u8).collect());
    let cell = Between { format: CellFormat::of_samples(21_846, 1), keyframes: [pair(1), pair(0)] };
    cases(seed, "every pair of bytes at every weight", &cell, 0)
}

pub(super) fn halves(seed: u64) -> Vec<Case> {
    let half = |at: usize| HalfKey::from_bits(HALVES[at % HALVES.len()]);
    let a = Keyframe::Samples((0..258).map(half).collect());
    let b = Keyframe::Samples((0..258).map(|at| half(at / HALVES.len())).collect());
    let cell = Between { format: CellFormat::of_samples(43, 2), keyframes: [a, b] };
    cases(seed, "every pair of edges at every weight", &cell, 1)
}

/// Returns cases with keyframes of samples or blocks.
pub(super) fn random_cases<S: CellSample>(seed: u64, blocks: Option<KeyframeBlocks<S>>) -> Vec<Case> {
    let random = &mut Random::new(seed);
    let mut odd = Gathered::default();
    for lead in 0..60 {
        let size = [1 + random.below(33) as usize, 1 + random.below(33) as usize];
        let weights = [0, 255, random.word() as u8, random.word() as u8];
        push(&mut odd, &Between::<S>::random(size, blocks, random), &weights, lead);
    }
    let mut large = Gathered::default();
    let side = if blocks.is_some() { 256 } else { 1024 };
    push(&mut large, &Between::<S>::random([side, side], blocks, random), &[17, 254], 1);
    vec![odd.case("odd sizes and offsets"), large.case("large cells")]
}
