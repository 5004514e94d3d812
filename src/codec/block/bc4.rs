//! BC4: one channel of 8 bits, 16 pixels in 8 bytes (formats/blocks.md 4).
//!
//! Takes a block and returns the values of its 16 pixels, row by row.

use super::TEXELS;

pub fn decode(block: &[u8; 8]) -> [u8; TEXELS] {
    let word = u64::from_le_bytes(*block);
    let values = palette(word as u8, (word >> 8) as u8);
    std::array::from_fn(|texel| values[(word >> (16 + 3 * texel)) as usize & 7])
}

fn palette(first: u8, second: u8) -> [u8; 8] {
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
