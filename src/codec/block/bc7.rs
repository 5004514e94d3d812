//! BC7: four channels of 8 bits, 16 pixels in 16 bytes (formats/blocks.md 8).
//!
//! Takes a block and returns RGBA, or RGB, of its 16 pixels, row by row. Functions are specialised by mode, so that all bit
//! positions are constants, and the four channels of a pixel are interpolated by one multiplication, in 16-bit lanes of a
//! 64-bit number.

use super::TEXELS;
use super::bptc::{Line, Partition, field, open, weight};

pub(super) struct Mode {
    pub(super) subsets: u32,
    pub(super) partition_bits: u32,
    pub(super) rotation_bits: u32,
    pub(super) selection_bits: u32,
    pub(super) color_bits: u32,
    pub(super) alpha_bits: u32,
    /// Lowest bits that all channels of an endpoint share (P bits): none, one per endpoint, or one per pair of endpoints.
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

/// A row of the table, with the columns in the order of the document (formats/blocks.md 8).
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

/// The value 1 in each of four 16-bit lanes.
const ONES: u64 = 0x0001_0001_0001_0001;
const BYTES: u64 = 0xFF * ONES;
/// Bit positions of red, green, blue and alpha in a number of four lanes.
const LANES: [u32; 4] = [0, 16, 32, 48];

/// Decodes a block. All bit patterns are legal, except those whose first byte is 0, which are reserved and decode to zeros.
pub fn decode(block: &[u8; 16]) -> [[u8; 4]; TEXELS] {
    pixels(block, |pixel| LANES.map(|lane| (pixel >> lane) as u8))
}

pub(super) fn decode_rgb(block: &[u8; 16]) -> [[u8; 3]; TEXELS] {
    pixels(block, |pixel| [pixel as u8, (pixel >> LANES[1]) as u8, (pixel >> LANES[2]) as u8])
}

/// Decodes a block and maps each pixel by `of`; a pixel has a channel in the low eight bits of each lane.
#[inline(always)]
fn pixels<P: Copy>(block: &[u8; 16], of: impl Fn(u64) -> P) -> [P; TEXELS] {
    let word = u128::from_le_bytes(*block);
    match block[0].trailing_zeros() {
        0 => several_subsets::<0, P>(word, of),
        1 => several_subsets::<1, P>(word, of),
        2 => several_subsets::<2, P>(word, of),
        3 => several_subsets::<3, P>(word, of),
        4 => two_indices::<4, P>(word, of),
        5 => two_indices::<5, P>(word, of),
        6 => one_subset(word, of),
        7 => several_subsets::<7, P>(word, of),
        _ => [of(0); TEXELS],
    }
}

/// Position of the first bit after mode, partition, rotation and selection.
const fn endpoints_at(number: usize, mode: &Mode) -> u32 {
    number as u32 + 1 + mode.partition_bits + mode.rotation_bits + mode.selection_bits
}

const fn endpoint_bits(mode: &Mode) -> u32 {
    let low = match mode.low_bits {
        LowBits::None => 0,
        LowBits::PerEndpoint => 2,
        LowBits::PerSubset => 1,
    };
    mode.subsets * (2 * (3 * mode.color_bits + mode.alpha_bits) + low)
}

/// Returns endpoint `number` of mode `MODE`, each channel in the low 8 bits of its lane.
#[inline(always)]
fn endpoint<const MODE: usize>(word: u128, number: u32) -> u64 {
    let mode = const { &MODES[MODE] };
    let at = const { endpoints_at(MODE, &MODES[MODE]) };
    let low_at = at + 2 * mode.subsets * (3 * mode.color_bits + mode.alpha_bits);
    let (low, extra) = match mode.low_bits {
        LowBits::None => (0, 0),
        LowBits::PerEndpoint => (field(word, low_at + number, 1), 1),
        LowBits::PerSubset => (field(word, low_at + number / 2, 1), 1),
    };
    let channel =
        |lane: u32, bits: u32| field(word, at + 2 * mode.subsets * lane * mode.color_bits + number * bits, bits);
    let color =
        channel(0, mode.color_bits) | channel(1, mode.color_bits) << LANES[1] | channel(2, mode.color_bits) << LANES[2];
    let color = widen((color << extra) | (low * (ONES >> 16)), mode.color_bits + extra);
    let alpha = if mode.alpha_bits == 0 {
        255
    } else {
        widen(channel(3, mode.alpha_bits) << extra | low, mode.alpha_bits + extra)
    };
    color | alpha << LANES[3]
}

/// Expands lanes of `bits` bits to 8 bits; the high bits are repeated as the low bits.
#[inline(always)]
fn widen(lanes: u64, bits: u32) -> u64 {
    (lanes << (8 - bits)) | ((lanes >> (2 * bits - 8)) & (((1 << (8 - bits)) - 1) * ONES))
}

fn several_subsets<const MODE: usize, P>(word: u128, of: impl Fn(u64) -> P) -> [P; TEXELS] {
    let mode = const { &MODES[MODE] };
    let partition = Partition::new(mode.subsets, field(word, MODE as u32 + 1, mode.partition_bits) as u32);
    let mut lines = [Line::default(); 4];
    for subset in 0..mode.subsets {
        let [a, b] = [endpoint::<MODE>(word, 2 * subset), endpoint::<MODE>(word, 2 * subset + 1)];
        lines[subset as usize] = Line::new(a, b, 32 * ONES);
    }
    let at = const { endpoints_at(MODE, &MODES[MODE]) + endpoint_bits(&MODES[MODE]) };
    let bits = const { MODES[MODE].index_bits };
    let indices = partition.anchors().fold((word >> at) as u64, |indices, texel| open(indices, (texel + 1) * bits - 1));
    std::array::from_fn(|texel| of(lines[partition.subset(texel)].at(weight(indices, texel, bits))))
}

fn one_subset<P>(word: u128, of: impl Fn(u64) -> P) -> [P; TEXELS] {
    let line = Line::new(endpoint::<6>(word, 0), endpoint::<6>(word, 1), 32 * ONES);
    let at = const { endpoints_at(6, &MODES[6]) + endpoint_bits(&MODES[6]) };
    let indices = open((word >> at) as u64, 3);
    std::array::from_fn(|texel| of(line.at(weight(indices, texel, 4))))
}

fn two_indices<const MODE: usize, P>(word: u128, of: impl Fn(u64) -> P) -> [P; TEXELS] {
    let mode = const { &MODES[MODE] };
    let rotation = field(word, MODE as u32 + 1, 2) as usize;
    let selection = field(word, MODE as u32 + 3, mode.selection_bits);
    let line = Line::new(endpoint::<MODE>(word, 0), endpoint::<MODE>(word, 1), 32 * ONES);
    let at = const { endpoints_at(MODE, &MODES[MODE]) + endpoint_bits(&MODES[MODE]) };
    let first = open(field(word, at, 31), 1);
    let second = open(field(word, at + 31, 16 * mode.second_index_bits - 1), mode.second_index_bits - 1);
    // Swaps one channel with alpha; rotation 0 swaps alpha with itself.
    let lane = LANES[(rotation + 3) & 3];
    std::array::from_fn(|texel| {
        let (first, second) = (weight(first, texel, 2), weight(second, texel, const { MODES[MODE].second_index_bits }));
        let [of_color, of_alpha] = if selection == 0 { [first, second] } else { [second, first] };
        let alpha = line.at(of_alpha) >> LANES[3] & 0xFF;
        let color = line.at(of_color) & BYTES;
        let other = color >> lane & 0xFF;
        of((color & !(0xFF << LANES[3]) | other << LANES[3]) & !(0xFF << lane) | alpha << lane)
    })
}
