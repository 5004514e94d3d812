//! BC6H and BC7 decoded faster, as images are: the results of [`bc6h::decode`] and of [`bc7::decode`] without alpha.
//!
//! Where the plain decoders take bits one after the other, here each mode is a function of its own in which the places of all
//! bits are known; indices are brought to an even spacing first; and all channels of a pixel are mixed in one product, in lanes
//! of a 64-bit number.

use super::TEXELS;
use super::bc6h;
use super::bc7::{LowBits, MODES, Mode};
use super::bptc::{Partition, WEIGHTS};

/// A one in each of four lanes of 16 bits.
const ONES: u64 = 0x0001_0001_0001_0001;
/// The low eight bits of each lane.
const BYTES: u64 = 0xFF * ONES;
/// Where red, green, blue and alpha begin in a number of four lanes.
const LANES: [u32; 4] = [0, 16, 32, 48];

/// Two endpoints, ready for mixing: 64 times the first and what rounds, and what a 64th of the way to the second adds.
#[derive(Clone, Copy, Default)]
struct Line {
    start: u64,
    step: u64,
}

impl Line {
    /// `half` is a 32 in each lane.
    fn new(a: u64, b: u64, half: u64) -> Self {
        // Lanes of the step may be negative and borrow from those above; what borrows is given back in the sum.
        Line { start: (a << 6) + half, step: b.wrapping_sub(a) }
    }

    fn at(self, weight: u64) -> u64 {
        self.start.wrapping_add(self.step.wrapping_mul(weight)) >> 6
    }
}

pub(super) fn bc7(block: &[u8; 16]) -> [[u8; 3]; TEXELS] {
    let word = u128::from_le_bytes(*block);
    match block[0].trailing_zeros() {
        0 => several_subsets::<0, 3>(word),
        1 => several_subsets::<1, 3>(word),
        2 => several_subsets::<2, 2>(word),
        3 => several_subsets::<3, 2>(word),
        4 => two_indices::<4>(word),
        5 => two_indices::<5>(word),
        6 => one_subset(word),
        7 => several_subsets::<7, 2>(word),
        _ => [[0; 3]; TEXELS],
    }
}

/// `count` bits of a block from bit `at` on.
#[inline(always)]
fn field(word: u128, at: u32, count: u32) -> u64 {
    (word >> at) as u64 & ((1 << count) - 1)
}

/// The first bit behind the mode, partition, rotation and selection.
const fn endpoints_at(number: usize, mode: &Mode) -> u32 {
    number as u32 + 1 + mode.partition_bits + mode.rotation_bits + mode.selection_bits
}

/// Bits of endpoints, their lowest bits included.
const fn endpoint_bits(mode: &Mode) -> u32 {
    let low = match mode.low_bits {
        LowBits::None => 0,
        LowBits::PerEndpoint => 2,
        LowBits::PerSubset => 1,
    };
    mode.subsets * (2 * (3 * mode.color_bits + mode.alpha_bits) + low)
}

/// Endpoint `number` of mode `MODE`, each channel in 8 bits of its lane.
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

/// Lanes of `bits` bits brought to 8, the high bits repeated below.
#[inline(always)]
fn widen(lanes: u64, bits: u32) -> u64 {
    (lanes << (8 - bits)) | ((lanes >> (2 * bits - 8)) & (((1 << (8 - bits)) - 1) * ONES))
}

/// Puts a 0 in front of bit `at`: the highest bit of an anchor's index, which is not stored.
#[inline(always)]
fn open(indices: u64, at: u32) -> u64 {
    let below = indices & ((1 << at) - 1);
    (indices ^ below) << 1 | below
}

/// The weight of index `texel` of indices of `BITS` bits.
#[inline(always)]
fn weight<const BITS: u32>(indices: u64, texel: usize) -> u64 {
    let index = (indices >> (texel as u32 * BITS)) as usize & ((1 << BITS) - 1);
    u64::from(WEIGHTS[BITS as usize][index])
}

#[inline(always)]
fn rgb(lanes: u64) -> [u8; 3] {
    [lanes as u8, (lanes >> LANES[1]) as u8, (lanes >> LANES[2]) as u8]
}

fn several_subsets<const MODE: usize, const BITS: u32>(word: u128) -> [[u8; 3]; TEXELS] {
    let mode = const { &MODES[MODE] };
    let partition = Partition::new(mode.subsets, field(word, MODE as u32 + 1, mode.partition_bits) as u32);
    let mut lines = [Line::default(); 4];
    for subset in 0..mode.subsets {
        let [a, b] = [endpoint::<MODE>(word, 2 * subset), endpoint::<MODE>(word, 2 * subset + 1)];
        lines[subset as usize] = Line::new(a, b, 32 * ONES);
    }
    let at = const { endpoints_at(MODE, &MODES[MODE]) + endpoint_bits(&MODES[MODE]) };
    let indices = partition.anchors().fold((word >> at) as u64, |indices, texel| open(indices, (texel + 1) * BITS - 1));
    std::array::from_fn(|texel| rgb(lines[partition.subset(texel)].at(weight::<BITS>(indices, texel))))
}

fn one_subset(word: u128) -> [[u8; 3]; TEXELS] {
    let line = Line::new(endpoint::<6>(word, 0), endpoint::<6>(word, 1), 32 * ONES);
    let at = const { endpoints_at(6, &MODES[6]) + endpoint_bits(&MODES[6]) };
    let indices = open((word >> at) as u64, 3);
    std::array::from_fn(|texel| rgb(line.at(weight::<4>(indices, texel))))
}

fn two_indices<const MODE: usize>(word: u128) -> [[u8; 3]; TEXELS] {
    let mode = const { &MODES[MODE] };
    let rotation = field(word, MODE as u32 + 1, 2) as usize;
    let selection = field(word, MODE as u32 + 3, mode.selection_bits);
    let line = Line::new(endpoint::<MODE>(word, 0), endpoint::<MODE>(word, 1), 32 * ONES);
    let at = const { endpoints_at(MODE, &MODES[MODE]) + endpoint_bits(&MODES[MODE]) };
    let first = open(field(word, at, 31), 1);
    let second = open(field(word, at + 31, 16 * mode.second_index_bits - 1), mode.second_index_bits - 1);
    // Of RGB, one channel changes places with alpha: none for rotation 0.
    let lane = LANES[(rotation + 3) & 3];
    std::array::from_fn(|texel| {
        let second = match mode.second_index_bits {
            2 => weight::<2>(second, texel),
            _ => weight::<3>(second, texel),
        };
        let first = weight::<2>(first, texel);
        let [of_color, of_alpha] = if selection == 0 { [first, second] } else { [second, first] };
        let alpha = line.at(of_alpha) >> LANES[3] & 0xFF;
        rgb(line.at(of_color) & BYTES & !(0xFF << lane) | alpha << lane)
    })
}

/// A run of bits of a block of BC6H that go to neighbouring bits of one value.
#[derive(Clone, Copy)]
struct Run {
    value: usize,
    /// Lowest bit of the value, and lowest bit of the block.
    to: u32,
    from: u32,
    count: u32,
}

/// Most runs of a mode.
const RUNS: usize = 32;

/// [`bc6h::TARGETS`] in runs; what is left of a row moves no bits.
static RUNS_OF: [[Run; RUNS]; bc6h::MODES.len()] = {
    let mut runs = [[Run { value: 0, to: 0, from: 0, count: 0 }; RUNS]; bc6h::MODES.len()];
    let mut mode = 0;
    while mode < runs.len() {
        let code_bits = if bc6h::MODES[mode].code < 2 { 2 } else { 5 };
        let (mut bit, mut run, mut before) = (0, 0, bc6h::NOTHING);
        while bit < bc6h::LAYOUT_BITS && bc6h::TARGETS[mode][bit] != bc6h::NOTHING {
            let target = bc6h::TARGETS[mode][bit];
            if bit == 0 || target != before + 1 {
                let from = bit as u32 + code_bits;
                runs[mode][run] = Run { value: target as usize >> 4, to: target as u32 & 15, from, count: 0 };
                run += 1;
            }
            runs[mode][run - 1].count += 1;
            before = target;
            bit += 1;
        }
        mode += 1;
    }
    runs
};

/// The mode by the lowest five bits of a block; 255 where they are reserved.
const MODE_OF: [u8; 32] = {
    let mut modes = [255; 32];
    let mut mode = 0;
    while mode < bc6h::MODES.len() {
        let code = bc6h::MODES[mode].code as usize;
        let mut low = code;
        while low < 32 {
            modes[low] = mode as u8;
            low += if code < 2 { 4 } else { 32 };
        }
        mode += 1;
    }
    modes
};

pub(super) fn bc6h(block: &[u8; 16]) -> [[u16; 3]; TEXELS] {
    let number = MODE_OF[block[0] as usize & 31] as usize;
    let Some(mode) = bc6h::MODES.get(number) else { return [[0; 3]; TEXELS] };
    let word = u128::from_le_bytes(*block);
    let mut values = [0; bc6h::PARTITION + 1];
    for run in RUNS_OF[number].iter().take_while(|run| run.count > 0) {
        values[run.value] |= (field(word, run.from, run.count) as u32) << run.to;
    }
    let ends = bc6h::endpoints(mode, &values);
    let partition = Partition::new(mode.subsets, values[bc6h::PARTITION]);
    if mode.subsets == 2 {
        let lines = [halves(ends[0], ends[1]), halves(ends[2], ends[3])];
        let indices = partition.anchors().fold((word >> 82) as u64, |indices, texel| open(indices, 3 * texel + 2));
        std::array::from_fn(|texel| finish(lines[partition.subset(texel) & 1], weight::<3>(indices, texel)))
    } else {
        let line = halves(ends[0], ends[1]);
        let indices = open((word >> 65) as u64, 3);
        std::array::from_fn(|texel| finish(line, weight::<4>(indices, texel)))
    }
}

/// Red and green in the lanes of one number, 32 bits each, and blue in another.
fn halves(a: [u32; 3], b: [u32; 3]) -> [Line; 2] {
    let both = |color: [u32; 3]| u64::from(color[0]) | u64::from(color[1]) << 32;
    [Line::new(both(a), both(b), 32 << 32 | 32), Line::new(a[2].into(), b[2].into(), 32)]
}

fn finish(lines: [Line; 2], weight: u64) -> [u16; 3] {
    let [red_green, blue] = lines.map(|line| line.at(weight));
    [red_green, red_green >> 32, blue].map(|value| (((value & 0xFFFF) * 31) >> 6) as u16)
}
