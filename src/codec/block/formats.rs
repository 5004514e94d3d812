//! The block formats as types, and images of blocks (formats/blocks.md 2).

use crate::block::grid::{BlockFormat, SIDE, TEXELS, grid};
use crate::block::{bc1, bc4, bc5, bc6h, bc7};

/// Declares the types of formats: texel, bytes of a block, and decoder.
macro_rules! formats {
    ($($name:ident: [$texel:ty; $bytes:literal] by $decode:path;)+) => {$(
        #[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
        pub struct $name;

        impl BlockFormat for $name {
            type Texel = $texel;
            const BYTES: usize = $bytes;

            fn decode_block(block: &[u8], out: &mut [$texel; TEXELS]) {
                if let Some(block) = block.first_chunk() {
                    *out = $decode(block);
                }
            }
        }
    )+};
}

formats! {
    Bc1: [[u8; 3]; 8] by bc1::decode;
    Bc4: [u8; 8] by bc4::decode;
    Bc5: [[u8; 2]; 16] by bc5::decode;
    Bc6h: [[u16; 3]; 16] by bc6h::decode;
    Bc7: [[u8; 3]; 16] by bc7::decode_rgb;
    Bc7Rgba: [[u8; 4]; 16] by bc7::decode;
}

/// Decodes an image of `width` x `height` pixels. Texels past the right and the bottom edge are dropped; pixels of missing
/// blocks are not changed.
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
