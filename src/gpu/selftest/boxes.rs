//! Inputs of the kernels of boxes: columns that share words, units of odd sizes, whole and constant records,
//! pieces in blocks.

use crate::depth::block_tiles::{BlockTexel, BlockTiles, stored_tiles, tiles_of};
use crate::depth::boxes::PixelBox;
use crate::depth::records::builder::ChunkBuilder;
use crate::depth::records::{TemporalChunk, Values};
use crate::depth::texel::Texel;
use crate::gpu::harness::Case;
use crate::gpu::layout::{BoxRow, Job, Record, Unit, words_of};
use crate::gpu::pictures::{code_stride, pack_bytes, pack_codes};
use crate::gpu::prepare::{self, Parts, Prepared};
use crate::math::random::Random;

/// A pixel that boxes hold.
pub trait BoxTexel: Texel {
    /// Words of a row of this width.
    fn stride(width: u32) -> u32;

    /// A random one, often one that others are like.
    fn random(random: &mut Random) -> Self;

    /// A picture as words.
    fn pack(picture: &[Self], width: usize) -> Vec<u32>;
}

/// How boxes are stored, with what may stand in them.
pub trait RandomLayout<T: BoxTexel>: Parts<T> {
    /// Appends a random rectangle.
    fn put(size: [u32; 2], random: &mut Random, data: &mut Vec<u8>);

    /// Boxes of a unit that do not overlap.
    fn boxes(size: [u32; 2], random: &mut Random) -> Vec<PixelBox>;
}

impl<T: BoxTexel> RandomLayout<T> for Values {
    fn put([width, height]: [u32; 2], random: &mut Random, data: &mut Vec<u8>) {
        random_picture::<T>((width * height) as usize, random).into_iter().for_each(|value| value.put(data));
    }

    fn boxes(size: [u32; 2], random: &mut Random) -> Vec<PixelBox> {
        random_boxes(size, random)
    }
}

impl<T: BoxTexel + BlockTexel> RandomLayout<T> for BlockTiles {
    fn put(size: [u32; 2], random: &mut Random, data: &mut Vec<u8>) {
        let size = size.map(|side| side as usize);
        let count = tiles_of(size).count();
        let mut map = vec![0; count.div_ceil(8)];
        (0..count).filter(|_| !random.one_in(3)).for_each(|piece| map[piece / 8] |= 1 << (piece % 8));
        let bytes = stored_tiles::<T>(&map, size).map(|piece| piece.bytes).sum();
        let mut pieces = vec![0; bytes];
        random.fill(&mut pieces);
        data.extend(map);
        data.extend(pieces);
    }

    fn boxes([width, height]: [u32; 2], random: &mut Random) -> Vec<PixelBox> {
        let whole = random_boxes([width.div_ceil(4), height.div_ceil(4)], random);
        let inside = |start: u16, size: u16, end: u32| (4 * size).min(end as u16 - 4 * start);
        let on_grid = |b: PixelBox| PixelBox {
            x: 4 * b.x,
            y: 4 * b.y,
            width: inside(b.x, b.width, width),
            height: inside(b.y, b.height, height),
        };
        whole.into_iter().map(on_grid).collect()
    }
}

impl BoxTexel for u16 {
    fn stride(width: u32) -> u32 {
        code_stride(width)
    }

    fn random(random: &mut Random) -> u16 {
        if random.one_in(4) { 65535 } else { random.word() as u16 }
    }

    fn pack(picture: &[u16], width: usize) -> Vec<u32> {
        pack_codes(picture, width)
    }
}

impl BoxTexel for [u8; 3] {
    fn stride(width: u32) -> u32 {
        width
    }

    fn random(random: &mut Random) -> [u8; 3] {
        if random.one_in(4) { [0; 3] } else { std::array::from_fn(|_| random.word() as u8) }
    }

    fn pack(picture: &[[u8; 3]], _: usize) -> Vec<u32> {
        picture.iter().map(|&pixel| pack_bytes(pixel)).collect()
    }
}

pub fn random_picture<T: BoxTexel>(pixels: usize, random: &mut Random) -> Vec<T> {
    if random.one_in(5) {
        return vec![T::random(random); pixels];
    }
    (0..pixels).map(|_| T::random(random)).collect()
}

/// Boxes that do not overlap: some of the parts of a unit that was split again and again.
pub fn random_boxes(size: [u32; 2], random: &mut Random) -> Vec<PixelBox> {
    let mut parts = vec![PixelBox { x: 0, y: 0, width: size[0] as u16, height: size[1] as u16 }];
    for _ in 0..random.below(24) {
        let part = parts.swap_remove(random.below(parts.len() as u32) as usize);
        let PixelBox { x, y, width, height } = part;
        if (random.one_in(2) || height < 2) && width > 1 {
            let left = 1 + random.below(u32::from(width) - 1) as u16;
            parts.push(PixelBox { width: left, ..part });
            parts.push(PixelBox { x: x + left, width: width - left, ..part });
        } else if height > 1 {
            let top = 1 + random.below(u32::from(height) - 1) as u16;
            parts.push(PixelBox { height: top, ..part });
            parts.push(PixelBox { y: y + top, height: height - top, ..part });
        } else {
            parts.push(part);
        }
    }
    parts.retain(|_| random.one_in(2));
    if parts.is_empty() {
        parts.push(PixelBox { x: 0, y: 0, width: 1, height: 1 });
    }
    parts
}

#[derive(Default)]
struct Gathered {
    units: Vec<Unit>,
    records: Vec<Record>,
    boxes: Vec<BoxRow>,
    jobs: Vec<Job>,
    stream: Vec<u32>,
    before: Vec<u32>,
    expected: Vec<u32>,
    inputs: u64,
    pixels: u64,
}

impl Gathered {
    /// Adds a unit to which record `at` of a chunk is applied, over a random picture.
    fn push<T, L>(&mut self, chunk: &TemporalChunk<T, L>, at: usize, size: [u32; 2], random: &mut Random)
    where
        T: BoxTexel,
        L: RandomLayout<T>,
    {
        let mut picture = random_picture::<T>((size[0] * size[1]) as usize, random);
        let width = size[0] as usize;
        let unit = Unit {
            picture: self.before.len() as u32,
            width: size[0],
            height: size[1],
            stride: T::stride(size[0]),
            ..Unit::default()
        };
        self.before.extend(T::pack(&picture, width));
        self.pixels += chunk.apply(&mut picture, chunk.records()[at].body);
        self.expected.extend(T::pack(&picture, width));
        let Prepared { stream, records, boxes, .. } = prepare::of_boxes(chunk, size);
        let (bytes, rows) = (4 * self.stream.len() as u32, self.boxes.len() as u32);
        self.boxes.extend(boxes.iter().map(|row| BoxRow { at: row.at + bytes, ..*row }));
        let record = Record { first: records[at].first + rows, ..records[at] };
        self.inputs += u64::from(record.count);
        let end = self.jobs.last().map_or(0, |job| job.end) + record.work;
        let number = self.units.len() as u32;
        self.jobs.push(Job { unit: number, end, record: self.records.len() as u32, ..Job::default() });
        self.units.push(unit);
        self.records.push(record);
        self.stream.extend(stream);
    }

    fn case(self, label: &str) -> Case {
        let invocations = self.jobs.last().map_or(0, |job| job.end);
        let mut jobs = vec![invocations, self.jobs.len() as u32];
        jobs.extend(words_of(&self.jobs));
        Case {
            label: label.to_owned(),
            buffers: vec![
                words_of(&self.units),
                words_of(&self.records),
                jobs,
                words_of(&self.boxes),
                self.stream,
                self.before,
            ],
            invocations,
            expected: vec![(5, self.expected)],
            inputs: self.inputs,
            pixels: self.pixels,
        }
    }
}

/// A chunk with a keyframe and a record of boxes.
fn chunk<T, L>(size: [u32; 2], boxes: &[PixelBox], random: &mut Random) -> Option<TemporalChunk<T, L>>
where
    T: BoxTexel,
    L: RandomLayout<T>,
{
    let keyframe = random_picture::<T>((size[0] * size[1]) as usize, random);
    let mut builder = ChunkBuilder::starting_with(&keyframe, |data| L::put(size, random, data));
    builder.put_boxes(1, boxes, |b, data| L::put([b.width, b.height].map(u32::from), random, data));
    TemporalChunk::parse(builder.finish().ok()?, size, 2).ok()
}

/// All cases of one kind of pixel, stored in one way.
pub(super) fn cases<T: BoxTexel, L: RandomLayout<T>>(seed: u64) -> Vec<Case> {
    let random = &mut Random::new(seed);
    let mut small = Gathered::default();
    for width in 1..=9 {
        for height in 1..=3 {
            let size = [width, height];
            // Boxes of one column each, where that is allowed: every word is shared.
            let column = |x| PixelBox { x, y: 0, width: 1, height: height as u16 };
            let columns: Vec<_> = (0..width as u16).filter(|_| !random.one_in(3)).map(column).collect();
            let boxes = if columns.is_empty() || L::GRID > 1 { L::boxes(size, random) } else { columns };
            if let Some(chunk) = chunk::<T, L>(size, &boxes, random) {
                (0..2).for_each(|record| small.push(&chunk, record, size, random));
            }
        }
    }
    let mut odd = Gathered::default();
    for _ in 0..150 {
        let size = [1 + random.below(70), 1 + random.below(70)];
        let boxes = L::boxes(size, random);
        if let Some(chunk) = chunk::<T, L>(size, &boxes, random) {
            (0..2).for_each(|record| odd.push(&chunk, record, size, random));
        }
    }
    let mut large = Gathered::default();
    let size = [1024, 1024];
    for _ in 0..4 {
        let boxes = L::boxes(size, random);
        if let Some(chunk) = chunk::<T, L>(size, &boxes, random) {
            large.push(&chunk, 0, size, random);
        }
    }
    vec![small.case("columns that share words"), odd.case("random boxes"), large.case("units of 1024x1024")]
}
