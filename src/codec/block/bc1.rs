//! BC1: three channels of 8 bits, 16 pixels in 8 bytes (formats/blocks.md 3).
//!
//! Takes a block and returns RGB of its 16 pixels, row by row. Alpha is ignored: index 3 of the three-colour mode, which
//! would be transparent, is black.

use super::TEXELS;

pub fn decode(block: &[u8; 8]) -> [[u8; 3]; TEXELS] {
    let colors = palette(u16::from_le_bytes([block[0], block[1]]), u16::from_le_bytes([block[2], block[3]]));
    let indices = u32::from_le_bytes([block[4], block[5], block[6], block[7]]);
    std::array::from_fn(|texel| colors[(indices >> (2 * texel)) as usize & 3])
}

fn palette(first: u16, second: u16) -> [[u8; 3]; 4] {
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
