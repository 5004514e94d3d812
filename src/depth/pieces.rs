//! Rectangles of pixels cut into pieces of 16x16, each in blocks of a texture format or as values (CALF 5.3; depth.md 14).

use crate::block::{self, Bc1, Bc5, BlockEncoder, BlockFormat, SIDE, TEXELS};
use crate::container::fields::Fields;
use crate::depth::records::Layout;
use crate::depth::texel::Texel;
use crate::effort::Effort;
use crate::error::Result;

/// Pixels along the side of a piece.
pub const PIECE_SIDE: usize = 16;

/// A value that blocks can hold.
pub trait BlockTexel: Texel {
    /// The format of its blocks.
    type Format: BlockFormat;

    /// The value that a decoded pixel stands for.
    fn of_block(texel: <Self::Format as BlockFormat>::Texel) -> Self;

    /// Blocks of 16 values each, one after the other.
    fn encode(values: &[[Self; TEXELS]], effort: Effort) -> Vec<u8>;

    /// Decodes a block.
    fn decode(block: &[u8]) -> [Self; TEXELS] {
        let mut texels = [<Self::Format as BlockFormat>::Texel::default(); TEXELS];
        Self::Format::decode_block(block, &mut texels);
        texels.map(Self::of_block)
    }
}

/// A depth code: its high byte is the red of BC5, its low byte the green.
impl BlockTexel for u16 {
    type Format = Bc5;

    fn of_block(texel: [u8; 2]) -> u16 {
        u16::from_be_bytes(texel)
    }

    fn encode(values: &[[u16; TEXELS]], effort: Effort) -> Vec<u8> {
        let texels: Vec<[u8; 2]> = values.as_flattened().iter().map(|code| code.to_be_bytes()).collect();
        Bc5.encode(&texels, SIDE, SIDE * values.len(), effort)
    }
}

/// A material: reflection, refraction and index are the red, green and blue of BC1.
impl BlockTexel for [u8; 3] {
    type Format = Bc1;

    fn of_block(texel: [u8; 3]) -> [u8; 3] {
        texel
    }

    fn encode(values: &[[[u8; 3]; TEXELS]], effort: Effort) -> Vec<u8> {
        Bc1.encode(values.as_flattened(), SIDE, SIDE * values.len(), effort)
    }
}

/// Pieces, after a map that tells which of them are in blocks.
#[derive(Debug, Clone, Copy)]
pub struct Pieces;

/// How many pieces are stored in which way.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct PieceCount {
    /// In blocks.
    pub blocks: u64,
    /// As values.
    pub raw: u64,
}

impl PieceCount {
    /// Adds another count.
    pub fn add(&mut self, other: PieceCount) {
        self.blocks += other.blocks;
        self.raw += other.raw;
    }

    /// Pieces of a rectangle of this width and height, whose stored bytes these start with.
    pub fn of_rectangle(bytes: &[u8], size: [usize; 2]) -> PieceCount {
        let pieces = piece_count(size);
        let blocks = bytes.iter().take(pieces.div_ceil(8)).map(|byte| u64::from(byte.count_ones())).sum();
        PieceCount { blocks, raw: pieces as u64 - blocks }
    }
}

/// Pieces of a rectangle.
fn piece_count([width, height]: [usize; 2]) -> usize {
    width.div_ceil(PIECE_SIDE) * height.div_ceil(PIECE_SIDE)
}

/// Left, top, width and height of the pieces of a rectangle of this width and height, in the order of the format.
pub fn pieces_of([width, height]: [usize; 2]) -> impl Iterator<Item = [usize; 4]> {
    (0..height).step_by(PIECE_SIDE).flat_map(move |top| {
        let height = PIECE_SIDE.min(height - top);
        (0..width).step_by(PIECE_SIDE).map(move |left| [left, top, PIECE_SIDE.min(width - left), height])
    })
}

/// Whether the map has a 1 for a piece.
fn in_blocks(map: &[u8], piece: usize) -> bool {
    map[piece / 8] >> (piece % 8) & 1 == 1
}

/// Bytes of a piece.
fn piece_bytes<T: BlockTexel>([_, _, width, height]: [usize; 4], in_blocks: bool) -> usize {
    let [columns, rows] = block::grid(width, height);
    if in_blocks { columns * rows * T::Format::BYTES } else { width * height * T::BYTES }
}

/// A piece as it is stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StoredPiece {
    /// Left, top, width and height in its rectangle.
    pub rect: [usize; 4],
    /// Whether it is in blocks.
    pub in_blocks: bool,
    /// Where its bytes start among those of the rectangle.
    pub start: usize,
    /// Their number.
    pub bytes: usize,
}

/// The pieces of a rectangle of this width and height, whose stored bytes these start with.
pub fn stored_pieces<T: BlockTexel>(bytes: &[u8], size: [usize; 2]) -> impl Iterator<Item = StoredPiece> {
    let mut start = piece_count(size).div_ceil(8);
    pieces_of(size).enumerate().map(move |(at, rect)| {
        let in_blocks = in_blocks(bytes, at);
        let piece = StoredPiece { rect, in_blocks, start, bytes: piece_bytes::<T>(rect, in_blocks) };
        start += piece.bytes;
        piece
    })
}

impl<T: BlockTexel> Layout<T> for Pieces {
    const GRID: u32 = SIDE as u32;

    fn take(fields: &mut Fields<'_>, size: [usize; 2]) -> Result<()> {
        let count = piece_count(size);
        let map = fields.bytes(count.div_ceil(8))?;
        if !count.is_multiple_of(8) && map[count / 8] >> (count % 8) != 0 {
            return Err(fields.error("spare bits of a map of pieces are not zero"));
        }
        let bytes = pieces_of(size).enumerate().map(|(at, piece)| piece_bytes::<T>(piece, in_blocks(map, at)));
        let bytes = bytes.sum();
        fields.bytes(bytes).map(drop)
    }

    fn draw(bytes: &[u8], [left, top, width, height]: [usize; 4], picture: &mut [T], stride: usize) {
        for StoredPiece { rect, in_blocks, start, bytes: length } in stored_pieces::<T>(bytes, [width, height]) {
            let [x, y, width, height] = rect;
            let stored = &bytes[start..start + length];
            let target = &mut picture[(top + y) * stride + left + x..];
            if in_blocks {
                draw_blocks(stored, [width, height], target, stride);
            } else {
                for (row, values) in target.chunks_mut(stride).zip(stored.chunks(width * T::BYTES)) {
                    T::get_row(&mut row[..width], values);
                }
            }
        }
    }
}

/// Decodes the blocks of a piece to the top left of a picture of `stride` columns.
fn draw_blocks<T: BlockTexel>(blocks: &[u8], [width, height]: [usize; 2], picture: &mut [T], stride: usize) {
    let columns = width.div_ceil(SIDE);
    for (at, block) in blocks.chunks_exact(T::Format::BYTES).enumerate() {
        let (x, y) = (at % columns * SIDE, at / columns * SIDE);
        let inside = SIDE.min(width - x);
        let texels = T::decode(block);
        let rows = texels.chunks(SIDE).take(height - y);
        for (row, texels) in picture[y * stride + x..].chunks_mut(stride).zip(rows) {
            row[..inside].copy_from_slice(&texels[..inside]);
        }
    }
}

/// Appends a rectangle: `block` answers the bytes of the block at a place in pixels, counted in the rectangle, or nothing
/// where its pixels must be stored as values; `value` answers these.
pub fn put<'a, T: BlockTexel>(
    size: [usize; 2],
    block: impl Fn(usize, usize) -> Option<&'a [u8]>,
    value: impl Fn(usize, usize) -> T,
    out: &mut Vec<u8>,
) {
    let start = out.len();
    out.resize(start + piece_count(size).div_ceil(8), 0);
    for (at, [left, top, width, height]) in pieces_of(size).enumerate() {
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

    /// A block of one code, which BC5 holds exactly.
    fn flat(code: u16) -> [u8; 16] {
        let [high, low] = code.to_be_bytes();
        [high, high, 0, 0, 0, 0, 0, 0, low, low, 0, 0, 0, 0, 0, 0]
    }

    #[test]
    fn rectangles_of_any_size_come_back() {
        for size @ [width, height] in [[1, 1], [4, 4], [16, 16], [17, 3], [20, 36], [33, 33]] {
            let code = |x: usize, y: usize| (x / 4 * 500 + y / 4 * 9000) as u16;
            let blocks: Vec<[u8; 16]> = (0..81).map(|at| flat(code(at % 9 * 4, at / 9 * 4))).collect();
            // Every third piece at least has a block that is not to be had.
            let block = |x: usize, y: usize| {
                let refused = x.is_multiple_of(16) && y.is_multiple_of(16) && (x / 16 + y / 16) % 3 == 1;
                (!refused).then(|| blocks[y / 4 * 9 + x / 4].as_slice())
            };
            let mut stored = Vec::new();
            put(size, block, code, &mut stored);
            let count = PieceCount::of_rectangle(&stored, size);
            assert_eq!(count.blocks + count.raw, pieces_of(size).count() as u64);
            let mut fields = Fields::new(&stored, 0, "");
            <Pieces as Layout<u16>>::take(&mut fields, size).unwrap();
            fields.finish().unwrap();
            let (stride, mut picture) = (width + 7, vec![9u16; (width + 7) * (height + 5)]);
            <Pieces as Layout<u16>>::draw(&stored, [3, 2, width, height], &mut picture, stride);
            for (at, &held) in picture.iter().enumerate() {
                let (x, y) = (at % stride, at / stride);
                let inside = (3..3 + width).contains(&x) && (2..2 + height).contains(&y);
                assert_eq!(held, if inside { code(x - 3, y - 2) } else { 9 }, "{size:?} at {x},{y}");
            }
            for length in 0..stored.len() {
                assert!(<Pieces as Layout<u16>>::take(&mut Fields::new(&stored[..length], 0, ""), size).is_err());
            }
        }
    }

    #[test]
    fn spare_bits_must_be_zero() {
        let stored = |map: u8| [vec![map], vec![0; 16]].concat();
        let take = |map| <Pieces as Layout<u16>>::take(&mut Fields::new(&stored(map), 0, ""), [4, 4]);
        assert!(take(1).is_ok());
        assert!(take(3).is_err() && take(0x81).is_err());
    }
}
