use super::*;
use crate::color::blend::HalfKey;
use crate::color::cells::{CellChunk, CellFormat};
use crate::color::keyframe_blocks::encode::KeyframeEncoder;
use crate::color::quality::{EightBit, Pu21, Target};
use crate::effort::Effort;
use half::f16;
use proptest::prelude::*;

type Chunks<S> = Vec<(EncodedChunk, CellChunk<S>)>;

fn encode_with<S: Sample, Q: Quality<S>>(
    frames: &[Vec<S>],
    encoder: CellEncoder<S>,
    format: CellFormat<S>,
    quality: &Q,
) -> Chunks<S> {
    let mut encoder = encoder;
    let mut chunks = Vec::new();
    for frame in frames {
        chunks.extend(encoder.push(frame, quality).unwrap());
    }
    chunks.extend(encoder.finish(quality).unwrap());
    let parsed = chunks.into_iter().map(|chunk| {
        let parsed = CellChunk::parse(chunk.payload.clone(), format, chunk.frame_count).unwrap();
        (chunk, parsed)
    });
    parsed.collect()
}

/// Decodes every frame from scratch, and checks that it reaches `db` dB.
fn check_frames<S: Sample, Q: Quality<S>>(chunks: &Chunks<S>, frames: &[Vec<S>], db: f64, quality: &Q) {
    let samples = frames[0].len();
    let limit = quality.max_squared_error(db, samples);
    let mut frame = 0;
    for (at, (chunk, cell)) in chunks.iter().enumerate() {
        assert_eq!(chunk.first_frame as usize, frame);
        for inside in 0..chunk.frame_count {
            let blend = cell.blend(inside);
            let (mut a, mut b) = (vec![S::default(); samples], vec![S::default(); samples]);
            cell.read_keyframe(blend.keyframe, &mut a);
            if blend.weight != 0 {
                let (next, index) =
                    if cell.is_last(blend.keyframe) { (&chunks[at + 1].1, 0) } else { (cell, blend.keyframe + 1) };
                next.read_keyframe(index, &mut b);
            }
            let error = quality.squared_error(&a, &b, blend.weight, &frames[frame], u64::MAX);
            assert!(error <= limit, "frame {frame}: {error} > {limit}");
            frame += 1;
        }
    }
    assert_eq!(frame, frames.len());
}

fn encode(frames: &[Vec<u8>], settings: SearchSettings) -> Chunks<u8> {
    let format = CellFormat::of_samples(frames[0].len() / 3, 1);
    encode_with(frames, CellEncoder::new(settings, CLOSE_AT_BYTES), format, &EightBit)
}

/// Encodes, checks every frame, and returns the number of keyframes.
fn check(frames: &[Vec<u8>], settings: SearchSettings) -> usize {
    let chunks = encode(frames, settings);
    check_frames(&chunks, frames, settings.target.min_psnr_db(), &EightBit);
    chunks.iter().map(|(_, cell)| cell.keyframes.len()).sum()
}

fn footage(n: usize, samples: usize) -> Vec<Vec<u8>> {
    let mut seed = 11u32;
    (0..n)
        .map(|t| {
            (0..samples)
                .map(|i| {
                    seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                    let noise = if (t / 40) % 2 == 1 { (seed >> 24) % 8 } else { 0 };
                    let cut = if t > n / 2 { 60 } else { 0 };
                    (i + t / 2 + cut + noise as usize) as u8
                })
                .collect()
        })
        .collect()
}

#[test]
fn every_frame_reaches_the_quality_asked_for() {
    for effort in [Effort::Fast, Effort::Normal, Effort::Exhaustive] {
        for (min_psnr_db, lookahead) in [(50.0, 64), (35.0, 64), (50.0, 1), (99.0, 3)] {
            let count =
                check(&footage(160, 60), SearchSettings { target: Target::Psnr(min_psnr_db), effort, lookahead });
            assert!(count > 1 && count <= 160);
        }
    }
}

#[test]
fn a_cell_that_never_changes_has_one_keyframe_and_no_weights() {
    let frames = vec![(0..30).collect::<Vec<u8>>(); 500];
    assert_eq!(check(&frames, SearchSettings::default()), 1);
    assert_eq!(encode(&frames, SearchSettings::default())[0].0.payload.len(), 8 + 4 + 30);
}

#[test]
fn a_cell_that_changes_once_has_two() {
    let mut frames = vec![vec![10u8; 30]; 100];
    frames.extend(vec![vec![200u8; 30]; 100]);
    assert_eq!(check(&frames, SearchSettings::default()), 2);
}

#[test]
fn long_noise_is_split_into_chunks_that_lead_into_each_other() {
    let frames = footage(80, 30_000);
    let settings = SearchSettings { target: Target::Psnr(30.0), lookahead: 8, ..SearchSettings::default() };
    assert!(encode(&frames, SearchSettings { target: Target::Psnr(60.0), ..settings }).len() > 1);
    check(&frames, SearchSettings { target: Target::Psnr(60.0), ..settings });
    check(&frames, settings);
}

/// Encodes with keyframes in blocks, checks every frame, and returns the number of keyframes in blocks and in samples.
fn check_blocks<S: Sample, Q: Quality<S>>(
    frames: &[Vec<S>],
    settings: SearchSettings,
    stage: BlockStage<S>,
    close_at_bytes: usize,
    quality: &Q,
) -> [usize; 2] {
    let format = CellFormat { size: stage.size, blocks: Some(stage.blocks) };
    let encoder = CellEncoder::new(settings, close_at_bytes).with_blocks(stage);
    let chunks = encode_with(frames, encoder, format, quality);
    check_frames(&chunks, frames, stage.final_psnr_db, quality);
    let mut counts = [0; 2];
    for (_, cell) in &chunks {
        (0..cell.keyframes.len()).for_each(|at| counts[usize::from(!cell.in_blocks(at))] += 1);
    }
    counts
}

/// Pictures of a cell: drifting gradients, intermittent noise, cuts, and repeated pictures.
fn pictures(size: [usize; 2], recipe: &[(u8, u8, u8)]) -> Vec<Vec<u8>> {
    let mut seed = 1u32;
    let mut time = 0;
    let mut pictures: Vec<Vec<u8>> = Vec::new();
    for &(what, noise, speed) in recipe {
        time += usize::from(speed % 5);
        if let (0..=1, Some(last)) = (what % 8, pictures.last()) {
            pictures.push(last.clone());
            continue;
        }
        let cut = if what % 8 == 7 { 90 } else { 0 };
        let sample = |at: usize| {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let (x, y, channel) = (at / 3 % size[0], at / 3 / size[0], at % 3);
            let level = 40 + 3 * x + 2 * y + time + cut + channel * 17;
            (level + (seed >> 16) as usize % (usize::from(noise) + 1)).min(255) as u8
        };
        pictures.push((0..size[0] * size[1] * 3).map(sample).collect());
    }
    pictures
}

fn halves(pictures: &[Vec<u8>]) -> Vec<Vec<HalfKey>> {
    let key = |&value: &u8| HalfKey::from_bits(f16::from_f32((f32::from(value) / 40.0).exp2() * 0.05).to_bits());
    pictures.iter().map(|picture| picture.iter().map(key).collect()).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn every_frame_between_keyframes_in_blocks_reaches_the_final_quality(
        width in 1usize..14,
        height in 1usize..14,
        recipe in proptest::collection::vec((any::<u8>(), 0u8..40, any::<u8>()), 1..40),
        [min_psnr_db, loss] in [30f64..60.0, 0f64..25.0],
        effort in 0usize..2,
        lookahead in 1u32..20,
        close_at_bytes in prop_oneof![Just(1usize), Just(400), Just(CLOSE_AT_BYTES)],
    ) {
        let size = [width, height];
        let frames = pictures(size, &recipe);
        let effort = [Effort::Fast, Effort::Normal][effort];
        let settings = SearchSettings { target: Target::Psnr(min_psnr_db), effort, lookahead };
        let final_psnr_db = min_psnr_db - loss;
        for blocks in [KeyframeBlocks::BC1, KeyframeBlocks::BC7] {
            check_blocks(&frames, settings, BlockStage { blocks, size, final_psnr_db }, close_at_bytes, &EightBit);
        }
        let pu21 = Pu21::new(100.0).unwrap();
        let stage = BlockStage { blocks: KeyframeBlocks::BC6H, size, final_psnr_db };
        check_blocks(&halves(&frames), settings, stage, close_at_bytes, &pu21);
    }
}

#[test]
fn keyframes_are_in_blocks_where_these_serve_and_samples_where_they_do_not() {
    let size = [16, 16];
    let flat = vec![vec![100u8; 16 * 16 * 3], vec![200; 16 * 16 * 3]];
    let noise = pictures(size, &[(3, 255, 0), (4, 254, 1)]);
    let settings = SearchSettings::default();
    let stage = |final_psnr_db| BlockStage { blocks: KeyframeBlocks::BC1, size, final_psnr_db };
    let count = |frames: &[Vec<u8>], db| check_blocks(frames, settings, stage(db), CLOSE_AT_BYTES, &EightBit);
    assert_eq!(count(&flat, 40.0), [2, 0]);
    assert_eq!(count(&noise, 40.0), [0, 2]);
    assert_eq!(count(&noise, 5.0), [2, 0]);
}

/// Stores the samples of whole blocks in rows, each reduced by `BIAS`.
const fn biased<const BIAS: u8>() -> KeyframeBlocks<u8> {
    KeyframeBlocks {
        bytes: 48,
        decode: |blocks, _, out| out.copy_from_slice(blocks),
        encoder: KeyframeEncoder {
            encode: |samples, _, _| samples.iter().map(|sample| sample - BIAS).collect(),
            fast: &[Effort::Fast],
        },
    }
}

#[test]
fn a_frame_that_blocks_show_too_badly_becomes_a_keyframe() {
    // Half of the samples rise, half of them fall. Frames between the ends lie 3 above the line, which 38.3 dB allow. The
    // ends may be off by 1 each, but then frames in between are off by 4.
    let sample = |t: usize, at: usize| {
        let above = if t == 0 || t == 19 { 0 } else { 3 };
        (if at.is_multiple_of(2) { 100 + 4 * t } else { 180 - 4 * t } + above) as u8
    };
    let frames: Vec<Vec<u8>> = (0..20).map(|t| (0..48).map(|at| sample(t, at)).collect()).collect();
    let settings = SearchSettings { target: Target::Psnr(38.3), ..SearchSettings::default() };
    let stage = |blocks| BlockStage { blocks, size: [4, 4], final_psnr_db: 38.3 };
    let count = |blocks| check_blocks(&frames, settings, stage(blocks), CLOSE_AT_BYTES, &EightBit);
    assert_eq!(check(&frames, settings), 2);
    assert_eq!(count(biased::<0>()), [2, 0]);
    let [in_blocks, raw] = count(biased::<1>());
    assert!(in_blocks > 2 && raw == 0, "{in_blocks} in blocks, {raw} raw");
    assert_eq!(count(biased::<9>())[0], 0);
}
