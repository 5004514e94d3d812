//! BC7: four channels of 8 bits, 16 pixels in 16 bytes (formats/blocks.md 8).
//!
//! Enters: a block. Leaves: RGBA of its 16 pixels, row by row.

use super::TEXELS;
use super::bptc::{Bits, Partition, mix};

/// How the bits of a block are dealt out in one of the eight modes.
pub(super) struct Mode {
    pub(super) subsets: u32,
    pub(super) partition_bits: u32,
    pub(super) rotation_bits: u32,
    pub(super) selection_bits: u32,
    pub(super) color_bits: u32,
    pub(super) alpha_bits: u32,
    /// Lowest bits that all channels of an endpoint share: none, one for each endpoint, one for each pair of them.
    pub(super) low_bits: LowBits,
    pub(super) index_bits: u32,
    pub(super) second_index_bits: u32,
}

#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum LowBits {
    None,
    PerEndpoint,
    PerSubset,
}

pub(super) const MODES: [Mode; 8] = {
    use LowBits::{None, PerEndpoint, PerSubset};
    [
        mode([3, 4, 0, 0, 4, 0], PerEndpoint, [3, 0]),
        mode([2, 6, 0, 0, 6, 0], PerSubset, [3, 0]),
        mode([3, 6, 0, 0, 5, 0], None, [2, 0]),
        mode([2, 6, 0, 0, 7, 0], PerEndpoint, [2, 0]),
        mode([1, 0, 2, 1, 5, 6], None, [2, 3]),
        mode([1, 0, 2, 0, 7, 8], None, [2, 2]),
        mode([1, 0, 0, 0, 7, 7], PerEndpoint, [4, 0]),
        mode([2, 6, 0, 0, 5, 5], PerEndpoint, [2, 0]),
    ]
};

/// A row of the table, its columns in the order of the document's.
const fn mode(counts: [u32; 6], low_bits: LowBits, index_bits: [u32; 2]) -> Mode {
    let [subsets, partition_bits, rotation_bits, selection_bits, color_bits, alpha_bits] = counts;
    let [index_bits, second_index_bits] = index_bits;
    Mode {
        subsets,
        partition_bits,
        rotation_bits,
        selection_bits,
        color_bits,
        alpha_bits,
        low_bits,
        index_bits,
        second_index_bits,
    }
}

/// Decodes a block. Every pattern of bits is legal but those whose first byte is 0, which are reserved and yield zeros.
pub fn decode(block: &[u8; 16]) -> [[u8; 4]; TEXELS] {
    let number = block[0].trailing_zeros();
    let Some(mode) = MODES.get(number as usize) else { return [[0; 4]; TEXELS] };
    let mut bits = Bits::new(block);
    bits.take(number + 1);
    let partition = Partition::new(mode.subsets, bits.take(mode.partition_bits));
    let rotation = bits.take(mode.rotation_bits);
    let selection = bits.take(mode.selection_bits);
    let endpoints = endpoints(mode, &mut bits);
    let first = partition.indices(&mut bits, mode.index_bits);
    if mode.second_index_bits == 0 {
        return std::array::from_fn(|texel| {
            let [a, b] = endpoints[partition.subset(texel)];
            std::array::from_fn(|channel| mix(a[channel], b[channel], first[texel], mode.index_bits) as u8)
        });
    }
    let second = partition.indices(&mut bits, mode.second_index_bits);
    let mut of_color = (first, mode.index_bits);
    let mut of_alpha = (second, mode.second_index_bits);
    if selection == 1 {
        std::mem::swap(&mut of_color, &mut of_alpha);
    }
    let [a, b] = endpoints[0];
    std::array::from_fn(|texel| {
        let mut pixel: [u8; 4] = std::array::from_fn(|channel| {
            let (indices, count) = if channel == 3 { &of_alpha } else { &of_color };
            mix(a[channel], b[channel], indices[texel], *count) as u8
        });
        if rotation > 0 {
            pixel.swap(rotation as usize - 1, 3);
        }
        pixel
    })
}

/// Reads the endpoints of a block: for each subset two colours of four channels, 8 bits each.
fn endpoints(mode: &Mode, bits: &mut Bits) -> [[[u32; 4]; 2]; 3] {
    let mut endpoints = [[[0; 4]; 2]; 3];
    let subsets = &mut endpoints[..mode.subsets as usize];
    for channel in 0..4 {
        let count = if channel == 3 { mode.alpha_bits } else { mode.color_bits };
        for endpoint in subsets.iter_mut().flatten() {
            endpoint[channel] = bits.take(count);
        }
    }
    let mut low = 0;
    for pair in subsets.iter_mut() {
        for (second, endpoint) in pair.iter_mut().enumerate() {
            if mode.low_bits == LowBits::PerEndpoint || mode.low_bits == LowBits::PerSubset && second == 0 {
                low = bits.take(1);
            }
            for (channel, value) in endpoint.iter_mut().enumerate() {
                let mut count = if channel == 3 { mode.alpha_bits } else { mode.color_bits };
                if count == 0 {
                    *value = 255;
                    continue;
                }
                if mode.low_bits != LowBits::None {
                    *value = *value << 1 | low;
                    count += 1;
                }
                *value = *value << (8 - count) | *value >> (2 * count - 8);
            }
        }
    }
    endpoints
}
