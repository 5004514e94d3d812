//! Inputs of the box-decoding kernels: adjacent columns that share words, units of odd sizes, whole and constant records, block
//! tiles.

use crate::harness::Case;
use crate::selftest::gathered::Gathered;
use codec::depth::block_tiles::{Layout, tiles_of};
use codec::depth::record_table::TableBuilder;
use codec::depth::{PixelBox, TemporalChunk, Texel};
use codec::math::random::Random;
use kernels::layout::{BoxRow, Record, Unit};
use kernels::pictures::{pack_bytes, pack_codes};
use kernels::prepare::{self, Prepared};

/// A pixel type that boxes store.
pub trait BoxTexel: Texel {
    /// Returns a random value; one of four is a common value.
    fn random(random: &mut Random) -> Self;

    /// Packs a picture into words.
    fn pack(picture: &[Self], width: usize) -> Vec<u32>;
}

/// Appends the data of a random rectangle.
pub fn put_random<T: BoxTexel>(layout: Layout, size: [u32; 2], random: &mut Random, data: &mut Vec<u8>) {
    let pixels = size.map(|side| side as usize);
    if layout == Layout::Values {
        return random_picture::<T>(pixels[0] * pixels[1], random).into_iter().for_each(|value| value.put(data));
    }
    let count = tiles_of(pixels).count();
    let mut map = vec![0; count.div_ceil(8)];
    (0..count).filter(|_| !random.one_in(3)).for_each(|tile| map[tile / 8] |= 1 << (tile % 8));
    let bytes = layout.parts::<T>(&map, pixels).iter().map(|tile| tile.bytes).sum();
    let mut tiles = vec![0; bytes];
    random.fill(&mut tiles);
    data.extend(map);
    data.extend(tiles);
}

/// Returns random boxes of a unit in this layout that do not overlap.
pub fn random_boxes_in(layout: Layout, [width, height]: [u32; 2], random: &mut Random) -> Vec<PixelBox> {
    if layout == Layout::Values {
        return random_boxes([width, height], random);
    }
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

impl BoxTexel for u16 {
    fn random(random: &mut Random) -> u16 {
        if random.one_in(4) { 65535 } else { random.word() as u16 }
    }

    fn pack(picture: &[u16], width: usize) -> Vec<u32> {
        pack_codes(picture, width)
    }
}

impl BoxTexel for [u8; 3] {
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

/// Returns boxes that do not overlap: about half of the parts of a unit that was split repeatedly.
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

/// Adds units to which the first records of a random chunk are applied: a keyframe, then the given boxes.
fn push<T: BoxTexel>(
    all: &mut Gathered,
    layout: Layout,
    size: [u32; 2],
    boxes: &[PixelBox],
    records: usize,
    random: &mut Random,
) {
    let pixels = (size[0] * size[1]) as usize;
    let keyframe = random_picture::<T>(pixels, random);
    let mut builder = TableBuilder::default();
    builder.put_keyframe(&keyframe, |data| put_random::<T>(layout, size, random, data));
    builder.put_boxes(1, boxes, |b, data| {
        put_random::<T>(layout, [b.width, b.height].map(u32::from), random, data);
    });
    let parse = |bytes: Vec<u8>| TemporalChunk::<T>::parse(layout, bytes, size, 2).ok();
    let Some(chunk) = builder.finish().ok().and_then(parse) else { return };
    for at in 0..records {
        let mut picture = random_picture::<T>(pixels, random);
        let Prepared { stream, records, boxes, .. } = prepare::of_boxes(&chunk, size);
        let (bytes, rows) = (4 * all.stream.len() as u32, all.boxes.len() as u32);
        let record = Record { first: records[at].first + rows, ..records[at] };
        all.before.extend(T::pack(&picture, size[0] as usize));
        all.pixels += chunk.apply(&mut picture, chunk.records[at].body);
        all.inputs += u64::from(record.count);
        all.boxes.extend(boxes.iter().map(|row| BoxRow { at: row.at + bytes, ..*row }));
        all.stream.extend(stream);
        let unit = Unit { width: size[0], height: size[1], ..Unit::default() };
        all.push(unit, record, T::pack(&picture, size[0] as usize));
    }
}

pub(super) fn cases<T: BoxTexel>(layout: Layout, seed: u64) -> Vec<Case> {
    let random = &mut Random::new(seed);
    let [mut small, mut odd, mut large] = [(); 3].map(|()| Gathered::default());
    for size in (1..=9).flat_map(|width| (1..=3).map(move |height| [width, height])) {
        // Boxes one column wide, where the layout allows them: every word is shared by two boxes.
        let column = |x| PixelBox { x, y: 0, width: 1, height: size[1] as u16 };
        let columns: Vec<_> = (0..size[0] as u16).filter(|_| !random.one_in(3)).map(column).collect();
        let boxes =
            if columns.is_empty() || layout.grid() > 1 { random_boxes_in(layout, size, random) } else { columns };
        push::<T>(&mut small, layout, size, &boxes, 2, random);
    }
    for _ in 0..150 {
        let size = [1 + random.below(70), 1 + random.below(70)];
        let boxes = random_boxes_in(layout, size, random);
        push::<T>(&mut odd, layout, size, &boxes, 2, random);
    }
    for _ in 0..4 {
        let boxes = random_boxes_in(layout, [1024; 2], random);
        push::<T>(&mut large, layout, [1024; 2], &boxes, 1, random);
    }
    vec![small.case("columns that share words"), odd.case("random boxes"), large.case("units of 1024x1024")]
}
