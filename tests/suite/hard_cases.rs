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
use lightfold::gpu::selftest::hard_cases::{CASES, compare};
use rayon::prelude::*;

/// Bounds that every case is held to, in codes.
const BOUNDS: [u16; 7] = [0, 1, 10, 30, 100, 300, 1000];

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
