//! Writes rectangles in block tiles (depth.md 14).

use crate::block::{Bc1, Bc5, BlockEncoder, SIDE, TEXELS};
use crate::depth::block_tiles::{tile_count, tiles_of};
use crate::depth::texel::Texel;
use crate::effort::Effort;

pub trait EncodeTexel: Texel {
    /// Encodes each group of 16 values as a block; returns the blocks one after the other.
    fn encode(values: &[[Self; TEXELS]], effort: Effort) -> Vec<u8>;
}

impl EncodeTexel for u16 {
    fn encode(values: &[[u16; TEXELS]], effort: Effort) -> Vec<u8> {
        let texels: Vec<[u8; 2]> = values.as_flattened().iter().map(|code| code.to_be_bytes()).collect();
        Bc5.encode(&texels, SIDE, SIDE * values.len(), effort)
    }
}

impl EncodeTexel for [u8; 3] {
    fn encode(values: &[[[u8; 3]; TEXELS]], effort: Effort) -> Vec<u8> {
        Bc1.encode(values.as_flattened(), SIDE, SIDE * values.len(), effort)
    }
}

/// Appends a rectangle. `block` returns the block at a position in pixels, or `None` if the pixels are stored as values, which
/// `value` returns.
pub fn put<'a, T: Texel>(
    size: [usize; 2],
    block: impl Fn(usize, usize) -> Option<&'a [u8]>,
    value: impl Fn(usize, usize) -> T,
    out: &mut Vec<u8>,
) {
    let start = out.len();
    out.resize(start + tile_count(size).div_ceil(8), 0);
    for (at, [left, top, width, height]) in tiles_of(size).enumerate() {
        let places =
            (top..top + height).step_by(SIDE).flat_map(|y| (left..left + width).step_by(SIDE).map(move |x| (x, y)));
        let blocks: Option<Vec<&[u8]>> = places.map(|(x, y)| block(x, y)).collect();
        match blocks {
            Some(blocks) => {
                out[start + at / 8] |= 1 << (at % 8);
                blocks.into_iter().for_each(|block| out.extend_from_slice(block));
            }
            None => {
                (top..top + height).for_each(|y| (left..left + width).for_each(|x| value(x, y).put(out)));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::container::fields::Fields;
    use crate::depth::block_tiles::{BlockTileCount, Layout};

    /// Returns a block of one code, which BC5 represents exactly.
    fn flat(code: u16) -> [u8; 16] {
        let [high, low] = code.to_be_bytes();
        [high, high, 0, 0, 0, 0, 0, 0, low, low, 0, 0, 0, 0, 0, 0]
    }

    #[test]
    fn rectangles_of_any_size_come_back() {
        for size @ [width, height] in [[1, 1], [4, 4], [16, 16], [17, 3], [20, 36], [33, 33]] {
            let code = |x: usize, y: usize| (x / 4 * 500 + y / 4 * 9000) as u16;
            let blocks: Vec<[u8; 16]> = (0..81).map(|at| flat(code(at % 9 * 4, at / 9 * 4))).collect();
            // At least every third block tile has a block for which `block` returns `None`.
            let block = |x: usize, y: usize| {
                let refused = x.is_multiple_of(16) && y.is_multiple_of(16) && (x / 16 + y / 16) % 3 == 1;
                (!refused).then(|| blocks[y / 4 * 9 + x / 4].as_slice())
            };
            let mut stored = Vec::new();
            put(size, block, code, &mut stored);
            let count = BlockTileCount::of_rectangle(&stored, size);
            assert_eq!(count.blocks + count.raw, tiles_of(size).count() as u64);
            let mut fields = Fields::new(&stored, 0, "");
            Layout::BlockTiles.take::<u16>(&mut fields, size).unwrap();
            fields.finish().unwrap();
            let (stride, mut picture) = (width + 7, vec![9u16; (width + 7) * (height + 5)]);
            Layout::BlockTiles.draw(&stored, [3, 2, width, height], &mut picture, stride);
            for (at, &held) in picture.iter().enumerate() {
                let (x, y) = (at % stride, at / stride);
                let inside = (3..3 + width).contains(&x) && (2..2 + height).contains(&y);
                assert_eq!(held, if inside { code(x - 3, y - 2) } else { 9 }, "{size:?} at {x},{y}");
            }
            for length in 0..stored.len() {
                assert!(Layout::BlockTiles.take::<u16>(&mut Fields::new(&stored[..length], 0, ""), size).is_err());
            }
        }
    }

    #[test]
    fn spare_bits_must_be_zero() {
        let stored = |map: u8| [vec![map], vec![0; 16]].concat();
        let take = |map| Layout::BlockTiles.take::<u16>(&mut Fields::new(&stored(map), 0, ""), [4, 4]);
        assert!(take(1).is_ok());
        assert!(take(3).is_err() && take(0x81).is_err());
    }
}
