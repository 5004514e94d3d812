//! Payloads that no encoder writes: no panic, and no more memory and time than a cell and its frames justify.

use std::time::{Duration, Instant};

use crate::color::HalfKey;
use crate::color::transform::blocks::{MAX_FRAMES, regions};
use crate::color::transform::contexts::{ALPHABETS, NODE};
use crate::color::transform::region::{PALETTE, PARTS, QUARTERS, TRANSFORM};
use crate::color::transform::{Keyed, Tables, TransformChunk};
use crate::container::fields::Fields;
use crate::container::serialize::PutFields;
use crate::error::Result;

/// Tables in which every distribution is certain of one symbol, which takes no bits: `of` says which by cluster.
fn certain(of: impl Fn(usize) -> usize) -> Tables {
    let mut bytes = vec![1];
    for (cluster, alphabet) in ALPHABETS.into_iter().enumerate() {
        for symbol in 0..usize::from(alphabet) - 1 {
            bytes.put_varint(if symbol == of(cluster).min(usize::from(alphabet) - 1) { 4096 } else { 0 });
        }
    }
    Tables::read(&mut Fields::new(&bytes, 0, "")).unwrap()
}

/// A payload of the stream's own set for so many regions, whose substreams are all the same.
fn payload(regions: usize, substream: &[u8]) -> Vec<u8> {
    let mut bytes = vec![4, 80, 80, 3, 0xfd, 0];
    (1..regions).for_each(|_| bytes.put_varint(substream.len() as u64));
    (0..regions).for_each(|_| bytes.extend_from_slice(substream));
    bytes
}

/// What a chunk holds for each region and frame, and for each byte of its payload, at most.
fn check(chunk: &TransformChunk, frames: u32, payload_bytes: usize) {
    for region in chunk.regions() {
        let colors: usize = region.palettes.iter().map(|palette| palette.colors.len()).sum();
        assert!(region.leaves.len() <= 64 * frames as usize && region.leaves.len() + colors <= 64 + 8 * payload_bytes);
        let indices: usize = region.palettes.iter().map(|palette| palette.indices.len()).sum();
        assert!(indices <= 1024 * frames as usize);
        assert!(region.levels.len() <= 8 * payload_bytes);
    }
}

#[test]
fn symbols_that_take_no_bits_end_with_the_tree() {
    let start = Instant::now();
    let mut taken = 0;
    for kind in [TRANSFORM, QUARTERS, PARTS, PALETTE, 4] {
        for other in 0..16 {
            // Of the fourth kind nodes are split and coded by their distribution, in all ways.
            let mixed = |cluster: usize| (other >> (cluster % 3)) + cluster;
            let tables = certain(|cluster| match (cluster < NODE.clusters, kind) {
                (true, 4) => mixed(cluster) % 4,
                (true, kind) => kind,
                (false, _) => other,
            });
            for (size, frames) in [([64, 64], 24), ([33, 5], MAX_FRAMES), ([8, 8], 7), ([1, 1], 1)] {
                let regions = regions(size).len();
                for substream in [&[][..], &[7], &[0, 0, 1, 0], &[1, 2, 3, 4, 5, 6, 7, 8]] {
                    let payload = payload(regions, substream);
                    if let Ok(chunk) = TransformChunk::parse::<HalfKey>(&payload, size, frames, &tables) {
                        check(&chunk, frames, payload.len());
                        chunk.show(0, None, &mut vec![HalfKey(0); 3 * size[0] * size[1]]);
                        taken += 1;
                    }
                }
            }
        }
    }
    assert!(taken > 8, "{taken} payloads are taken");
    assert!(start.elapsed() < Duration::from_secs(60), "{:?}", start.elapsed());
}

#[test]
fn any_bytes_are_refused_or_stay_within_what_they_justify() {
    let mut state = 1u32;
    let mut next = move || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        state >> 8
    };
    let tables = Tables::default();
    let mut refused = 0;
    for round in 0..400 {
        let size = [1 + next() as usize % 70, 1 + next() as usize % 40];
        let frames = 1 + next() % MAX_FRAMES;
        let regions = regions(size).len();
        let mut payload = vec![(round % 4) as u8, next() as u8, next() as u8, next() as u8, next() as u8, 0];
        (1..regions).for_each(|_| payload.put_varint((next() % 40).into()));
        (0..regions * 40).for_each(|_| payload.push(next() as u8));
        fn parse<S: Keyed>(payload: &[u8], size: [usize; 2], frames: u32, tables: &Tables) -> Result<TransformChunk> {
            TransformChunk::parse::<S>(payload, size, frames, tables)
        }
        for parse in [parse::<u8>, parse::<HalfKey>] {
            match parse(&payload, size, frames, &tables) {
                Ok(chunk) => check(&chunk, frames, payload.len()),
                Err(_) => refused += 1,
            }
        }
    }
    assert!(refused > 700, "{refused} are refused");
}

#[test]
fn a_chunk_of_too_many_frames_is_refused_before_it_is_read() {
    let error = TransformChunk::parse::<u8>(&[], [1, 1], MAX_FRAMES + 1, &Tables::default()).unwrap_err();
    assert!(error.to_string().contains("97 frames"), "{error}");
}
