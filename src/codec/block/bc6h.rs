//! BC6H UF16: three channels of unsigned half floats, 16 pixels in 16 bytes (formats/blocks.md 7).
//!
//! Takes a block and returns RGB of its 16 pixels as bit patterns of half floats, row by row. The maximum is 0x7BFF, the
//! largest finite value.

use super::TEXELS;
use super::bptc::{Line, Partition, field, open, weight};

pub(super) struct Mode {
    /// Lowest bits of the block: two bits for modes 0 and 1, five bits for the others.
    pub(super) code: u32,
    pub(super) subsets: u32,
    pub(super) precision: u32,
    /// Bits per channel (red, green, blue) of the endpoints after the first, if they are stored as differences from the
    /// first.
    pub(super) delta: Option<[u32; 3]>,
    /// Bits that follow the code, in the order of the block: a value, which is a channel (r, g, b) of an endpoint (w, x, y,
    /// z) or the partition number (d), and the bits of that value.
    pub(super) layout: &'static str,
}

pub(super) const MODES: [Mode; 14] = [
    mode(0, 10, Some([5, 5, 5]), LAYOUTS[0]),
    mode(1, 7, Some([6, 6, 6]), LAYOUTS[1]),
    mode(2, 11, Some([5, 4, 4]), LAYOUTS[2]),
    mode(6, 11, Some([4, 5, 4]), LAYOUTS[3]),
    mode(10, 11, Some([4, 4, 5]), LAYOUTS[4]),
    mode(14, 9, Some([5, 5, 5]), LAYOUTS[5]),
    mode(18, 8, Some([6, 5, 5]), LAYOUTS[6]),
    mode(22, 8, Some([5, 6, 5]), LAYOUTS[7]),
    mode(26, 8, Some([5, 5, 6]), LAYOUTS[8]),
    mode(30, 6, None, LAYOUTS[9]),
    mode(3, 10, None, LAYOUTS[10]),
    mode(7, 11, Some([9, 9, 9]), LAYOUTS[11]),
    mode(11, 12, Some([8, 8, 8]), LAYOUTS[12]),
    mode(15, 16, Some([4, 4, 4]), LAYOUTS[13]),
];

const LAYOUTS: [&str; 14] = [
    "gy4 by4 bz4 rw0-9 gw0-9 bw0-9 rx0-4 gz4 gy0-3 gx0-4 bz0 gz0-3 bx0-4 bz1 by0-3 ry0-4 bz2 rz0-4 bz3 d0-4",
    "gy5 gz4-5 rw0-6 bz0-1 by4 gw0-6 by5 bz2 gy4 bw0-6 bz3 bz5 bz4 rx0-5 gy0-3 gx0-5 gz0-3 bx0-5 by0-3 ry0-5 rz0-5 d0-4",
    "rw0-9 gw0-9 bw0-9 rx0-4 rw10 gy0-3 gx0-3 gw10 bz0 gz0-3 bx0-3 bw10 bz1 by0-3 ry0-4 bz2 rz0-4 bz3 d0-4",
    "rw0-9 gw0-9 bw0-9 rx0-3 rw10 gz4 gy0-3 gx0-4 gw10 gz0-3 bx0-3 bw10 bz1 by0-3 ry0-3 bz0 bz2 rz0-3 gy4 bz3 d0-4",
    "rw0-9 gw0-9 bw0-9 rx0-3 rw10 by4 gy0-3 gx0-3 gw10 bz0 gz0-3 bx0-4 bw10 by0-3 ry0-3 bz1-2 rz0-3 bz4 bz3 d0-4",
    "rw0-8 by4 gw0-8 gy4 bw0-8 bz4 rx0-4 gz4 gy0-3 gx0-4 bz0 gz0-3 bx0-4 bz1 by0-3 ry0-4 bz2 rz0-4 bz3 d0-4",
    "rw0-7 gz4 by4 gw0-7 bz2 gy4 bw0-7 bz3-4 rx0-5 gy0-3 gx0-4 bz0 gz0-3 bx0-4 bz1 by0-3 ry0-5 rz0-5 d0-4",
    "rw0-7 bz0 by4 gw0-7 gy5 gy4 bw0-7 gz5 bz4 rx0-4 gz4 gy0-3 gx0-5 gz0-3 bx0-4 bz1 by0-3 ry0-4 bz2 rz0-4 bz3 d0-4",
    "rw0-7 bz1 by4 gw0-7 by5 gy4 bw0-7 bz5 bz4 rx0-4 gz4 gy0-3 gx0-4 bz0 gz0-3 bx0-5 by0-3 ry0-4 bz2 rz0-4 bz3 d0-4",
    "rw0-5 gz4 bz0-1 by4 gw0-5 gy5 by5 bz2 gy4 bw0-5 gz5 bz3 bz5 bz4 rx0-5 gy0-3 gx0-5 gz0-3 bx0-5 by0-3 ry0-5 rz0-5 d0-4",
    "rw0-9 gw0-9 bw0-9 rx0-9 gx0-9 bx0-9",
    "rw0-9 gw0-9 bw0-9 rx0-8 rw10 gx0-8 gw10 bx0-8 bw10",
    "rw0-9 gw0-9 bw0-9 rx0-7 rw11-10 gx0-7 gw11-10 bx0-7 bw11-10",
    "rw0-9 gw0-9 bw0-9 rx0-3 rw15-10 gx0-3 gw15-10 bx0-3 bw15-10",
];

/// A row of the table. The number of subsets follows from the layout: only layouts of two subsets end with the partition
/// number.
const fn mode(code: u32, precision: u32, delta: Option<[u32; 3]>, layout: &'static str) -> Mode {
    let two = layout.as_bytes()[layout.len() - 4] == b'd';
    Mode { code, subsets: if two { 2 } else { 1 }, precision, delta, layout }
}

/// Index of the partition number in the values of a block; indices 0 to 11 are the channels of the endpoints w, x, y and z.
const PARTITION: usize = 12;
/// A run of bits in a block that are consecutive bits of one value.
#[derive(Clone, Copy)]
struct Run {
    value: usize,
    /// Lowest bit in the value.
    to: u32,
    from: u32,
    count: u32,
}

const RUNS: usize = 32;

/// Bit runs of each mode; unused entries have `count` 0.
static RUNS_OF: [[Run; RUNS]; MODES.len()] = {
    let mut runs = [[Run { value: 0, to: 0, from: 0, count: 0 }; RUNS]; MODES.len()];
    let mut mode = 0;
    while mode < MODES.len() {
        let code_bits = if MODES[mode].code < 2 { 2 } else { 5 };
        runs[mode] = parse(MODES[mode].layout.as_bytes(), code_bits, runs[mode]);
        mode += 1;
    }
    runs
};

const fn parse(text: &[u8], mut from: u32, mut runs: [Run; RUNS]) -> [Run; RUNS] {
    let (mut at, mut run) = (0, 0);
    while at < text.len() {
        let mut value = PARTITION;
        if text[at] != b'd' {
            let endpoint = (text[at + 1] - b'w') as usize;
            value = 3 * endpoint
                + match text[at] {
                    b'r' => 0,
                    b'g' => 1,
                    _ => 2,
                };
            at += 1;
        }
        at += 1;
        let (mut to, behind) = number(text, at);
        let (mut last, mut next) = (to, behind);
        if behind < text.len() && text[behind] == b'-' {
            (last, next) = number(text, behind + 1);
        }
        // Descending bits become runs of one bit.
        while to > last {
            runs[run] = Run { value, to, from, count: 1 };
            (run, from, to) = (run + 1, from + 1, to - 1);
        }
        let count = last - to + 1;
        runs[run] = Run { value, to, from, count };
        (run, from) = (run + 1, from + count);
        at = next + 1;
    }
    runs
}

const fn number(text: &[u8], mut at: usize) -> (u32, usize) {
    let mut value = 0;
    while at < text.len() && text[at].is_ascii_digit() {
        value = 10 * value + (text[at] - b'0') as u32;
        at += 1;
    }
    (value, at)
}

/// Mode of a block by its lowest five bits; 255 for reserved codes.
const MODE_OF: [u8; 32] = {
    let mut modes = [255; 32];
    let mut mode = 0;
    while mode < MODES.len() {
        let code = MODES[mode].code as usize;
        let mut low = code;
        while low < 32 {
            modes[low] = mode as u8;
            low += if code < 2 { 4 } else { 32 };
        }
        mode += 1;
    }
    modes
};

/// Decodes a block. All bit patterns are legal, except those of the four reserved codes (19, 23, 27, 31), which decode to
/// zeros.
pub fn decode(block: &[u8; 16]) -> [[u16; 3]; TEXELS] {
    let number = MODE_OF[block[0] as usize & 31] as usize;
    let Some(mode) = MODES.get(number) else { return [[0; 3]; TEXELS] };
    let word = u128::from_le_bytes(*block);
    let mut values = [0; PARTITION + 1];
    for run in RUNS_OF[number].iter().take_while(|run| run.count > 0) {
        values[run.value] |= (field(word, run.from, run.count) as u32) << run.to;
    }
    let ends = endpoints(mode, &values);
    let partition = Partition::new(mode.subsets, values[PARTITION]);
    if mode.subsets == 2 {
        let lines = [halves(ends[0], ends[1]), halves(ends[2], ends[3])];
        let indices = partition.anchors().fold((word >> 82) as u64, |indices, texel| open(indices, 3 * texel + 2));
        std::array::from_fn(|texel| finish(lines[partition.subset(texel) & 1], weight(indices, texel, 3)))
    } else {
        let line = halves(ends[0], ends[1]);
        let indices = open((word >> 65) as u64, 3);
        std::array::from_fn(|texel| finish(line, weight(indices, texel, 4)))
    }
}

/// Packs red and green into 32-bit lanes of one line, and blue into another.
fn halves(a: [u32; 3], b: [u32; 3]) -> [Line; 2] {
    let both = |color: [u32; 3]| u64::from(color[0]) | u64::from(color[1]) << 32;
    [Line::new(both(a), both(b), 32 << 32 | 32), Line::new(a[2].into(), b[2].into(), 32)]
}

fn finish(lines: [Line; 2], weight: u64) -> [u16; 3] {
    let [red_green, blue] = lines.map(|line| line.at(weight));
    [red_green, red_green >> 32, blue].map(|value| (((value & 0xFFFF) * 31) >> 6) as u16)
}

/// Returns the endpoints w, x, y and z as 16-bit numbers.
fn endpoints(mode: &Mode, values: &[u32; PARTITION + 1]) -> [[u32; 3]; 4] {
    std::array::from_fn(|endpoint| {
        std::array::from_fn(|channel| {
            let mut value = values[3 * endpoint + channel];
            if let (Some(delta), 1..) = (mode.delta, endpoint) {
                let unused = 32 - delta[channel];
                let difference = (value << unused) as i32 >> unused;
                value = values[channel].wrapping_add(difference as u32) & ((1 << mode.precision) - 1);
            }
            widen(value, mode.precision)
        })
    })
}

fn widen(value: u32, precision: u32) -> u32 {
    if precision >= 15 || value == 0 {
        value
    } else if value == (1 << precision) - 1 {
        0xFFFF
    } else {
        ((value << 16) + 0x8000) >> precision
    }
}
