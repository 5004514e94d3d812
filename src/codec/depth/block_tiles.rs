//! Storage of rectangles of pixels: as values, or divided into block tiles of 16x16 pixels, each in blocks of a texture format or
//! as values (CALF 5.3; depth.md 14).

#[cfg(feature = "encode")]
pub mod encode;

use crate::block::{self, BlockFormat, SIDE};
use crate::container::fields::Fields;
use crate::depth::texel::Texel;
use crate::error::Result;

pub const TILE_SIDE: usize = 16;

/// Storage of the pixels of a rectangle, which is a unit or a box.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Layout {
    Values,
    /// A bit map of the block tiles that are in blocks, then the block tiles.
    BlockTiles,
}

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

    pub fn of_rectangle(bytes: &[u8], size: [usize; 2]) -> BlockTileCount {
        let tiles = tile_count(size);
        let blocks = bytes.iter().take(tiles.div_ceil(8)).map(|byte| u64::from(byte.count_ones())).sum();
        BlockTileCount { blocks, raw: tiles as u64 - blocks }
    }
}

fn tile_count([width, height]: [usize; 2]) -> usize {
    width.div_ceil(TILE_SIDE) * height.div_ceil(TILE_SIDE)
}

/// Returns left, top, width and height of the block tiles of a rectangle, in the order of the format.
pub fn tiles_of([width, height]: [usize; 2]) -> impl Iterator<Item = [usize; 4]> {
    (0..height).step_by(TILE_SIDE).flat_map(move |top| {
        let height = TILE_SIDE.min(height - top);
        (0..width).step_by(TILE_SIDE).map(move |left| [left, top, TILE_SIDE.min(width - left), height])
    })
}

fn in_blocks(map: &[u8], tile: usize) -> bool {
    map[tile / 8] >> (tile % 8) & 1 == 1
}

fn tile_bytes<T: Texel>([_, _, width, height]: [usize; 4], in_blocks: bool) -> usize {
    let [columns, rows] = block::grid(width, height);
    if in_blocks { columns * rows * T::Format::BYTES } else { width * height * T::BYTES }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StoredTile {
    /// Left, top, width and height in the rectangle, in pixels.
    pub rect: [usize; 4],
    pub in_blocks: bool,
    pub start: usize,
    pub bytes: usize,
}

/// Returns the block tiles of a rectangle, whose stored bytes are at the start of `bytes`.
fn stored_tiles<T: Texel>(bytes: &[u8], size: [usize; 2]) -> impl Iterator<Item = StoredTile> {
    let mut start = tile_count(size).div_ceil(8);
    tiles_of(size).enumerate().map(move |(at, rect)| {
        let in_blocks = in_blocks(bytes, at);
        let tile = StoredTile { rect, in_blocks, start, bytes: tile_bytes::<T>(rect, in_blocks) };
        start += tile.bytes;
        tile
    })
}

impl Layout {
    /// Returns the alignment of boxes in pixels: a box starts at a multiple of it, and ends at a multiple or at the unit's edge.
    pub fn grid(self) -> u32 {
        match self {
            Layout::Values => 1,
            Layout::BlockTiles => SIDE as u32,
        }
    }

    pub fn take<T: Texel>(self, fields: &mut Fields<'_>, size @ [width, height]: [usize; 2]) -> Result<()> {
        if self == Layout::Values {
            return fields.bytes(width.saturating_mul(height).saturating_mul(T::BYTES)).map(drop);
        }
        let count = tile_count(size);
        let map = fields.bytes(count.div_ceil(8))?;
        if !count.is_multiple_of(8) && map[count / 8] >> (count % 8) != 0 {
            return Err(fields.error("spare bits of a map of pieces are not zero"));
        }
        let bytes = tiles_of(size).enumerate().map(|(at, tile)| tile_bytes::<T>(tile, in_blocks(map, at))).sum();
        fields.bytes(bytes).map(drop)
    }

    /// Returns the parts of a rectangle, whose stored bytes are at the start of `bytes`.
    pub fn parts<T: Texel>(self, bytes: &[u8], size: [usize; 2]) -> Vec<StoredTile> {
        if self == Layout::Values {
            let rect = [0, 0, size[0], size[1]];
            return vec![StoredTile { rect, in_blocks: false, start: 0, bytes: tile_bytes::<T>(rect, false) }];
        }
        stored_tiles::<T>(bytes, size).collect()
    }

    /// Writes a rectangle (left, top, width, height) into a picture of `stride` columns.
    pub fn draw<T: Texel>(self, bytes: &[u8], rect: [usize; 4], picture: &mut [T], stride: usize) {
        if self == Layout::Values {
            return draw_values(bytes, rect, picture, stride);
        }
        let [left, top, width, height] = rect;
        for StoredTile { rect, in_blocks, start, bytes: length } in stored_tiles::<T>(bytes, [width, height]) {
            let [x, y, width, height] = rect;
            let stored = &bytes[start..start + length];
            if in_blocks {
                draw_blocks(stored, [width, height], &mut picture[(top + y) * stride + left + x..], stride);
            } else {
                draw_values(stored, [left + x, top + y, width, height], picture, stride);
            }
        }
    }
}

fn draw_values<T: Texel>(bytes: &[u8], [left, top, width, height]: [usize; 4], picture: &mut [T], stride: usize) {
    if width == stride {
        let pixels = top * stride..(top + height) * stride;
        return T::get_row(&mut picture[pixels], &bytes[..width * height * T::BYTES]);
    }
    let rows = picture[top * stride..].chunks_mut(stride).take(height);
    for (row, bytes) in rows.zip(bytes.chunks(width * T::BYTES)) {
        T::get_row(&mut row[left..left + width], bytes);
    }
}

/// Decodes the blocks of a block tile into the top left of a picture of `stride` columns.
fn draw_blocks<T: Texel>(blocks: &[u8], [width, height]: [usize; 2], picture: &mut [T], stride: usize) {
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
