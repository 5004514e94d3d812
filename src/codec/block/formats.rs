//! The block formats as types, images of blocks, and the decoders of BC1 (8 bytes, three channels of 8 bits), BC4 (8 bytes, one
//! channel) and BC5 (16 bytes, two channels); formats/blocks.md 2 to 5.

use crate::block::grid::{BlockFormat, SIDE, TEXELS, grid};
use crate::block::{bc6h, bc7};

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
    Bc1: [[u8; 3]; 8] by decode_bc1;
    Bc4: [u8; 8] by decode_bc4;
    Bc5: [[u8; 2]; 16] by decode_bc5;
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

/// Decodes a block of BC1 (blocks.md 3) into RGB of its 16 pixels, row by row. Alpha is ignored: index 3 of the three-colour
/// mode, which would be transparent, is black.
pub fn decode_bc1(block: &[u8; 8]) -> [[u8; 3]; TEXELS] {
    let colors = bc1_palette(u16::from_le_bytes([block[0], block[1]]), u16::from_le_bytes([block[2], block[3]]));
    let indices = u32::from_le_bytes([block[4], block[5], block[6], block[7]]);
    std::array::from_fn(|texel| colors[(indices >> (2 * texel)) as usize & 3])
}

fn bc1_palette(first: u16, second: u16) -> [[u8; 3]; 4] {
    let [a, b] = [expand(first), expand(second)];
    let mix = |by: fn(u32, u32) -> u32| std::array::from_fn(|channel| by(a[channel], b[channel]) as u8);
    let ends = [mix(|a, _| a), mix(|_, b| b)];
    if first > second {
        [ends[0], ends[1], mix(|a, b| (2 * a + b + 1) / 3), mix(|a, b| (a + 2 * b + 1) / 3)]
    } else {
        [ends[0], ends[1], mix(|a, b| (a + b + 1) >> 1), [0; 3]]
    }
}

/// Expands 5, 6 and 5 bits to 8 bits each; the high bits are repeated as the low bits.
fn expand(color: u16) -> [u32; 3] {
    let color = u32::from(color);
    let [r, g, b] = [color >> 11, color >> 5 & 63, color & 31];
    [r << 3 | r >> 2, g << 2 | g >> 4, b << 3 | b >> 2]
}

/// Decodes a block of BC4 (blocks.md 4) into the values of its 16 pixels, row by row.
pub fn decode_bc4(block: &[u8; 8]) -> [u8; TEXELS] {
    let word = u64::from_le_bytes(*block);
    let values = bc4_palette(word as u8, (word >> 8) as u8);
    std::array::from_fn(|texel| values[(word >> (16 + 3 * texel)) as usize & 7])
}

fn bc4_palette(first: u8, second: u8) -> [u8; 8] {
    let (a, b) = (u32::from(first), u32::from(second));
    std::array::from_fn(|index| {
        let i = index as u32;
        match index {
            0 => first,
            1 => second,
            _ if first > second => (((8 - i) * a + (i - 1) * b + 3) / 7) as u8,
            6 => 0,
            7 => 255,
            _ => (((6 - i) * a + (i - 1) * b + 2) / 5) as u8,
        }
    })
}

/// Decodes a block of BC5 (blocks.md 5), which consists of two of BC4, into red and green of its 16 pixels, row by row.
pub fn decode_bc5(block: &[u8; 16]) -> [[u8; 2]; TEXELS] {
    let half = |at: usize| decode_bc4(&std::array::from_fn(|byte| block[at + byte]));
    let [red, green] = [half(0), half(8)];
    std::array::from_fn(|texel| [red[texel], green[texel]])
}
