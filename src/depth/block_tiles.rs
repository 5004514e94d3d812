//! Rectangles of pixels cut into block tiles of 16x16, each in blocks of a texture format or as values (CALF 5.3; depth.md
//! 14).

#[cfg(feature = "encode")]
pub mod encode;

use crate::block::{self, Bc1, Bc5, BlockFormat, SIDE, TEXELS};
use crate::container::fields::Fields;
use crate::depth::records::Layout;
use crate::depth::texel::Texel;
use crate::error::Result;

pub const TILE_SIDE: usize = 16;

pub trait BlockTexel: Texel {
    type Format: BlockFormat;

    /// The value that a decoded pixel stands for.
    fn of_block(texel: <Self::Format as BlockFormat>::Texel) -> Self;

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
}

/// A material: reflection, refraction and index are the red, green and blue of BC1.
impl BlockTexel for [u8; 3] {
    type Format = Bc1;

    fn of_block(texel: [u8; 3]) -> [u8; 3] {
        texel
    }
}

/// Block tiles after a map of those in blocks.
#[derive(Debug, Clone, Copy)]
pub struct BlockTiles;

#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct BlockTileCount {
    pub blocks: u64,
    pub raw: u64,
}

impl BlockTileCount {
    pub fn add(&mut self, other: BlockTileCount) {
        self.blocks += other.blocks;
        self.raw += other.raw;
    }

    /// Counts the block tiles of a rectangle, whose stored bytes these start with.
    pub fn of_rectangle(bytes: &[u8], size: [usize; 2]) -> BlockTileCount {
        let tiles = tile_count(size);
        let blocks = bytes.iter().take(tiles.div_ceil(8)).map(|byte| u64::from(byte.count_ones())).sum();
        BlockTileCount { blocks, raw: tiles as u64 - blocks }
    }
}

fn tile_count([width, height]: [usize; 2]) -> usize {
    width.div_ceil(TILE_SIDE) * height.div_ceil(TILE_SIDE)
}

/// Left, top, width and height of the block tiles of a rectangle of this width and height, in the order of the format.
pub fn tiles_of([width, height]: [usize; 2]) -> impl Iterator<Item = [usize; 4]> {
    (0..height).step_by(TILE_SIDE).flat_map(move |top| {
        let height = TILE_SIDE.min(height - top);
        (0..width).step_by(TILE_SIDE).map(move |left| [left, top, TILE_SIDE.min(width - left), height])
    })
}

fn in_blocks(map: &[u8], tile: usize) -> bool {
    map[tile / 8] >> (tile % 8) & 1 == 1
}

fn tile_bytes<T: BlockTexel>([_, _, width, height]: [usize; 4], in_blocks: bool) -> usize {
    let [columns, rows] = block::grid(width, height);
    if in_blocks { columns * rows * T::Format::BYTES } else { width * height * T::BYTES }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StoredTile {
    /// Left, top, width and height in its rectangle.
    pub rect: [usize; 4],
    pub in_blocks: bool,
    /// Where its bytes start among those of the rectangle.
    pub start: usize,
    pub bytes: usize,
}

/// The block tiles of a rectangle of this width and height, whose stored bytes these start with.
pub fn stored_tiles<T: BlockTexel>(bytes: &[u8], size: [usize; 2]) -> impl Iterator<Item = StoredTile> {
    let mut start = tile_count(size).div_ceil(8);
    tiles_of(size).enumerate().map(move |(at, rect)| {
        let in_blocks = in_blocks(bytes, at);
        let tile = StoredTile { rect, in_blocks, start, bytes: tile_bytes::<T>(rect, in_blocks) };
        start += tile.bytes;
        tile
    })
}

impl<T: BlockTexel> Layout<T> for BlockTiles {
    const GRID: u32 = SIDE as u32;

    fn take(fields: &mut Fields<'_>, size: [usize; 2]) -> Result<()> {
        let count = tile_count(size);
        let map = fields.bytes(count.div_ceil(8))?;
        if !count.is_multiple_of(8) && map[count / 8] >> (count % 8) != 0 {
            return Err(fields.error("spare bits of a map of pieces are not zero"));
        }
        let bytes = tiles_of(size).enumerate().map(|(at, tile)| tile_bytes::<T>(tile, in_blocks(map, at)));
        let bytes = bytes.sum();
        fields.bytes(bytes).map(drop)
    }

    fn draw(bytes: &[u8], [left, top, width, height]: [usize; 4], picture: &mut [T], stride: usize) {
        for StoredTile { rect, in_blocks, start, bytes: length } in stored_tiles::<T>(bytes, [width, height]) {
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

/// Decodes the blocks of a block tile to the top left of a picture of `stride` columns.
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
