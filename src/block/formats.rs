//! The five formats as types, and images of blocks (formats/blocks.md 2).

use crate::block::grid::{BlockFormat, SIDE, TEXELS, grid};
use crate::block::{bc1, bc4, bc5, bc6h, bc7};

#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Bc1;

#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Bc4;

#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Bc5;

#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Bc6h;

#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Bc7;

impl BlockFormat for Bc1 {
    type Texel = [u8; 3];
    const BYTES: usize = 8;
    fn decode_block(block: &[u8], out: &mut [[u8; 3]; TEXELS]) {
        if let Some(block) = block.first_chunk() {
            *out = bc1::decode(block);
        }
    }
}

impl BlockFormat for Bc4 {
    type Texel = u8;
    const BYTES: usize = 8;
    fn decode_block(block: &[u8], out: &mut [u8; TEXELS]) {
        if let Some(block) = block.first_chunk() {
            *out = bc4::decode(block);
        }
    }
}

impl BlockFormat for Bc5 {
    type Texel = [u8; 2];
    const BYTES: usize = 16;
    fn decode_block(block: &[u8], out: &mut [[u8; 2]; TEXELS]) {
        if let Some(block) = block.first_chunk() {
            *out = bc5::decode(block);
        }
    }
}

impl BlockFormat for Bc6h {
    type Texel = [u16; 3];
    const BYTES: usize = 16;
    fn decode_block(block: &[u8], out: &mut [[u16; 3]; TEXELS]) {
        if let Some(block) = block.first_chunk() {
            *out = bc6h::decode(block);
        }
    }
}

impl BlockFormat for Bc7 {
    type Texel = [u8; 3];
    const BYTES: usize = 16;
    fn decode_block(block: &[u8], out: &mut [[u8; 3]; TEXELS]) {
        if let Some(block) = block.first_chunk() {
            *out = bc7::decode_rgb(block);
        }
    }
}

/// Decodes an image of `width` x `height` pixels (formats/blocks.md 2).
///
/// `blocks` holds the blocks of [`grid`] row by row, [`BlockFormat::BYTES`] each; `pixels` takes the pixels row by row.
/// What of a block lies past the right or the bottom edge is dropped. Pixels whose block is missing stay as they are.
pub fn decode_image<F: BlockFormat>(blocks: &[u8], width: usize, height: usize, pixels: &mut [F::Texel]) {
    let [columns, rows] = grid(width, height);
    if columns == 0 {
        return;
    }
    let mut texels = [F::Texel::default(); TEXELS];
    let lines = blocks.chunks(columns * F::BYTES).zip(pixels.chunks_mut(SIDE * width));
    for (line, band) in lines.take(rows) {
        for (column, block) in line.chunks_exact(F::BYTES).enumerate() {
            F::decode_block(block, &mut texels);
            let left = column * SIDE;
            let inside = SIDE.min(width - left);
            for (row, source) in band.chunks_exact_mut(width).zip(texels.chunks_exact(SIDE)) {
                if inside == SIDE {
                    row[left..left + SIDE].copy_from_slice(source);
                } else {
                    row[left..].copy_from_slice(&source[..inside]);
                }
            }
        }
    }
}
