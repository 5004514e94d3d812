//! Tests with payloads that no encoder writes: no panic, and no more memory and symbols than a cell and its frames justify.

use crate::color::HalfKey;
use crate::color::transform::basis::length_index;
use crate::color::transform::blocks::{Block, MAX_FRAMES, regions};
use crate::color::transform::coder::{Coder, Reader, SourceCoder};
use crate::color::transform::contexts::BUILT_IN;
use crate::color::transform::contexts::{ALPHABETS, NODE};
use crate::color::transform::payload::Layout;
use crate::color::transform::region::{
    PALETTE, PARTS, QUARTERS, Region, Setting, TRANSFORM, held_bytes, max_items, parsed_bytes,
};
use crate::color::transform::{Keyed, Tables, TransformChunk};
use crate::container::fields::Fields;
use crate::container::serialize::PutFields;
use crate::entropy;
use crate::error::Result;

/// Tables in which every distribution has one certain symbol, which takes no bits; `of` returns the symbol of a cluster.
fn certain(of: impl Fn(usize) -> usize) -> Tables {
    let mut bytes = Vec::new();
    for (cluster, alphabet) in ALPHABETS.into_iter().enumerate() {
        for symbol in 0..usize::from(alphabet) - 1 {
            bytes.put_varint(if symbol == of(cluster).min(usize::from(alphabet) - 1) { 4096 } else { 0 });
        }
    }
    Tables::read(&mut Fields::new(&bytes, 0, ""), 1).unwrap()
}

/// A payload that uses the stream's own set, with `regions` regions whose substreams are equal.
fn payload(regions: usize, substream: &[u8]) -> Vec<u8> {
    let mut bytes = [vec![BUILT_IN as u8, 80, 80, 3, 0xfd, 0x80], vec![0x88; regions.div_ceil(2)]].concat();
    (1..regions).for_each(|_| bytes.put_varint(substream.len() as u64));
    (0..regions).for_each(|_| bytes.extend_from_slice(substream));
    bytes
}

/// Parameters that limit the content of a chunk.
#[derive(Debug, Clone, Copy)]
struct Limits {
    size: [usize; 2],
    frames: u32,
    payload_bytes: usize,
}

impl Limits {
    fn check(self, chunk: &TransformChunk) {
        let Limits { size, frames, payload_bytes } = self;
        for region in chunk.regions() {
            let colors: usize = region.palettes().map(|palette| palette.colors.len()).sum();
            let leaves = region.leaves().count();
            assert!(leaves <= 64 * frames as usize && leaves + colors <= 64 + 8 * payload_bytes);
            let indices: usize = region.palettes().map(|palette| palette.indices.len()).sum();
            assert!(indices <= 1024 * frames as usize);
            assert!(region.levels().len() <= 8 * payload_bytes);
        }
        let allocated: usize = chunk.regions().iter().map(Region::allocated_bytes).sum();
        let [held, parsed] = [held_bytes, parsed_bytes].map(|bytes| bytes(payload_bytes as u64, size, frames));
        let bound = held.min(parsed);
        assert!(allocated as u64 <= bound, "{allocated} bytes for {self:?}, the bound is {bound}");
    }
}

/// Coder that counts symbols and raw values.
struct Counting<'a> {
    coder: Reader<'a>,
    count: &'a mut usize,
}

impl Coder for Counting<'_> {
    fn symbol(&mut self, context: usize, value: usize) -> usize {
        *self.count += 1;
        self.coder.symbol(context, value)
    }

    fn bits(&mut self, value: u32, count: u32) -> u32 {
        *self.count += 1;
        self.coder.bits(value, count)
    }
}

impl SourceCoder for Counting<'_> {
    fn is_short(&self) -> bool {
        self.coder.is_short()
    }

    fn is_finished(&self) -> bool {
        self.coder.is_finished()
    }
}

/// Returns the number of symbols and raw values that are read from a payload's regions, and of pixels of all blocks and
/// frames.
fn work(payload: &[u8], limits: Limits, tables: &Tables) -> (usize, usize) {
    let layout = Layout::parse::<HalfKey>(payload, limits.size, tables).unwrap();
    let (mut count, mut pixels) = (0, 0);
    let places = layout.substreams.iter().zip(&layout.deltas);
    for ([_, _, width, height], (substream, &delta)) in regions(limits.size).zip(places) {
        let root = Block::root([width, height], limits.frames as usize);
        pixels += root.shape.pixels() * root.shape.frames;
        let set = &tables.sets()[layout.header.set];
        let bytes = &payload[substream.clone()];
        let stream = entropy::Decoder::new(bytes);
        let coder = Counting { coder: Reader { stream, tables: set }, count: &mut count };
        // The result is ignored: `TransformChunk::parse` decides whether the payload is legal.
        let setting = Setting { header: &layout.header, delta, domain: &HalfKey::DOMAIN };
        let _ = Region::read_by(coder, max_items(bytes), root, setting);
    }
    (count, pixels)
}

#[test]
fn symbols_that_take_no_bits_end_with_the_tree() {
    // State of a coder before any symbol.
    const EMPTY: &[u8] = &[0, 0, 1, 0];
    for kind in [TRANSFORM, QUARTERS, PARTS, PALETTE, 4] {
        for other in 0..16 {
            // Kind 4: the node symbol depends on the cluster; `other` selects the assignment.
            let mixed = |cluster: usize| (other >> (cluster % 3)) + cluster;
            let tables = certain(|cluster| match (cluster < NODE.clusters, kind) {
                (true, 4) => mixed(cluster) % 4,
                (true, kind) => kind,
                (false, _) => other,
            });
            for (size, frames) in [([64, 64], 24), ([33, 5], MAX_FRAMES), ([8, 8], 7), ([1, 1], 1)] {
                let regions = regions(size).len();
                for substream in [&[][..], &[7], EMPTY, &[1, 2, 3, 4, 5, 6, 7, 8]] {
                    let payload = payload(regions, substream);
                    let limits = Limits { size, frames, payload_bytes: payload.len() };
                    // Each coefficient takes at most a symbol and three raw values; a square of 4×4 pixels takes some more.
                    let (count, pixels) = work(&payload, limits, &tables);
                    assert!(count <= 16 * pixels, "{count} symbols for {limits:?}");
                    let chunk = TransformChunk::parse::<HalfKey>(&payload, size, frames, &tables);
                    if let Ok(chunk) = &chunk {
                        limits.check(chunk);
                        chunk.show(0, None, &mut vec![HalfKey(0); 3 * size[0] * size[1]]);
                    }
                    // No levels, or one colour from the cache: neither takes raw bits.
                    let is_legal = kind == PALETTE || kind == TRANSFORM && length_index(frames as usize).is_some();
                    if other == 0 && is_legal && substream == EMPTY {
                        assert!(chunk.is_ok(), "{limits:?}: {:?}", chunk.err());
                    }
                }
            }
        }
    }
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
        (0..regions.div_ceil(2)).for_each(|_| payload.push(next() as u8));
        (1..regions).for_each(|_| payload.put_varint((next() % 40).into()));
        (0..regions * 40).for_each(|_| payload.push(next() as u8));
        fn parse<S: Keyed>(payload: &[u8], size: [usize; 2], frames: u32, tables: &Tables) -> Result<TransformChunk> {
            TransformChunk::parse::<S>(payload, size, frames, tables)
        }
        for parse in [parse::<u8>, parse::<HalfKey>] {
            match parse(&payload, size, frames, &tables) {
                Ok(chunk) => Limits { size, frames, payload_bytes: payload.len() }.check(&chunk),
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
