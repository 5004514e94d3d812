//! Common parts of BC6H and BC7 (formats/blocks.md 6): partitions of the pixels into subsets, indices, and interpolation
//! between two endpoints. The tables are those of BPTC in the Khronos Data Format Specification.

use super::TEXELS;

/// Subset, and therefore pair of endpoints, of each pixel of a block.
#[derive(Clone, Copy)]
pub(super) struct Partition {
    /// Bits 2t and 2t + 1 are the subset of pixel t.
    map: u32,
    /// Bit t is set if pixel t is the anchor of its subset; the index of an anchor is stored without its highest bit.
    anchors: u32,
}

static PARTITIONS: [[Partition; 64]; 3] = {
    let mut partitions = [[Partition { map: 0, anchors: 1 }; 64]; 3];
    let mut number = 0;
    while number < 64 {
        let mut texel = 0;
        while texel < TEXELS {
            partitions[1][number].map |= (TWO[number] as u32 >> texel & 1) << (2 * texel);
            texel += 1;
        }
        partitions[1][number].anchors |= 1 << ANCHOR_OF_TWO[number];
        let [second, third] = [ANCHORS_OF_THREE[0][number], ANCHORS_OF_THREE[1][number]];
        partitions[2][number] = Partition { map: THREE[number], anchors: 1 | 1 << second | 1 << third };
        number += 1;
    }
    partitions
};

impl Partition {
    /// Returns partition `number` into `subsets` (1, 2 or 3) subsets.
    pub(super) fn new(subsets: u32, number: u32) -> Self {
        PARTITIONS[subsets as usize - 1][number as usize & 63]
    }

    pub(super) fn anchors(&self) -> impl Iterator<Item = u32> {
        let mut left = self.anchors;
        std::iter::from_fn(move || {
            let next = left.checked_ilog2().map(|_| left.trailing_zeros());
            left &= left.wrapping_sub(1);
            next
        })
    }

    pub(super) fn subset(&self, texel: usize) -> usize {
        (self.map >> (2 * texel)) as usize & 3
    }
}

/// Interpolation between two endpoints, in lanes: `start` is 64 times the first endpoint plus 32, `step` the difference of
/// the endpoints.
#[derive(Clone, Copy, Default)]
pub(super) struct Line {
    start: u64,
    step: u64,
}

impl Line {
    /// `half` has 32 in each lane.
    pub(super) fn new(a: u64, b: u64, half: u64) -> Self {
        // Lanes of the step may be negative and borrow from the lane above; the sum in `at` cancels the borrow.
        Line { start: (a << 6) + half, step: b.wrapping_sub(a) }
    }

    pub(super) fn at(self, weight: u64) -> u64 {
        self.start.wrapping_add(self.step.wrapping_mul(weight)) >> 6
    }
}

/// Returns `count` bits of a block from bit `at` on.
#[inline(always)]
pub(super) fn field(word: u128, at: u32, count: u32) -> u64 {
    (word >> at) as u64 & ((1 << count) - 1)
}

/// Inserts a 0 at bit `at`: the highest bit of an anchor's index, which is not stored.
#[inline(always)]
pub(super) fn open(indices: u64, at: u32) -> u64 {
    let below = indices & ((1 << at) - 1);
    (indices ^ below) << 1 | below
}

#[inline(always)]
pub(super) fn weight(indices: u64, texel: usize, bits: u32) -> u64 {
    let index = (indices >> (texel as u32 * bits)) as usize & ((1 << bits) - 1);
    u64::from(WEIGHTS[bits as usize & 7][index])
}

/// Partitions into two subsets: bit t is the subset of pixel t. BC6H uses the first 32.
pub(super) const TWO: [u16; 64] = [
    0xcccc, 0x8888, 0xeeee, 0xecc8, 0xc880, 0xfeec, 0xfec8, 0xec80, 0xc800, 0xffec, 0xfe80, 0xe800, 0xffe8, 0xff00,
    0xfff0, 0xf000, 0xf710, 0x008e, 0x7100, 0x08ce, 0x008c, 0x7310, 0x3100, 0x8cce, 0x088c, 0x3110, 0x6666, 0x366c,
    0x17e8, 0x0ff0, 0x718e, 0x399c, 0xaaaa, 0xf0f0, 0x5a5a, 0x33cc, 0x3c3c, 0x55aa, 0x9696, 0xa55a, 0x73ce, 0x13c8,
    0x324c, 0x3bdc, 0x6996, 0xc33c, 0x9966, 0x0660, 0x0272, 0x04e4, 0x4e40, 0x2720, 0xc936, 0x936c, 0x39c6, 0x639c,
    0x9336, 0x9cc6, 0x817e, 0xe718, 0xccf0, 0x0fcc, 0x7744, 0xee22,
];

/// Partitions into three subsets: bits 2t and 2t + 1 are the subset of pixel t.
pub(super) const THREE: [u32; 64] = [
    0xaa685050, 0x6a5a5040, 0x5a5a4200, 0x5450a0a8, 0xa5a50000, 0xa0a05050, 0x5555a0a0, 0x5a5a5050, 0xaa550000,
    0xaa555500, 0xaaaa5500, 0x90909090, 0x94949494, 0xa4a4a4a4, 0xa9a59450, 0x2a0a4250, 0xa5945040, 0x0a425054,
    0xa5a5a500, 0x55a0a0a0, 0xa8a85454, 0x6a6a4040, 0xa4a45000, 0x1a1a0500, 0x0050a4a4, 0xaaa59090, 0x14696914,
    0x69691400, 0xa08585a0, 0xaa821414, 0x50a4a450, 0x6a5a0200, 0xa9a58000, 0x5090a0a8, 0xa8a09050, 0x24242424,
    0x00aa5500, 0x24924924, 0x24499224, 0x50a50a50, 0x500aa550, 0xaaaa4444, 0x66660000, 0xa5a0a5a0, 0x50a050a0,
    0x69286928, 0x44aaaa44, 0x66666600, 0xaa444444, 0x54a854a8, 0x95809580, 0x96969600, 0xa85454a8, 0x80959580,
    0xaa141414, 0x96960000, 0xaaaa1414, 0xa05050a0, 0xa0a5a5a0, 0x96000000, 0x40804080, 0xa9a8a9a8, 0xaaaaaa44,
    0x2a4a5254,
];

/// Anchor of subset 1 of each partition into two subsets; the anchor of subset 0 is pixel 0.
pub(super) const ANCHOR_OF_TWO: [u8; 64] = [
    15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 2, 8, 2, 2, 8, 8, 15, 2, 8, 2, 2, 8, 8, 2, 2,
    15, 15, 6, 8, 2, 8, 15, 15, 2, 8, 2, 2, 2, 15, 15, 6, 6, 2, 6, 8, 15, 15, 2, 2, 15, 15, 15, 15, 15, 2, 2, 15,
];

/// Anchors of subset 1 and of subset 2 of each partition into three subsets.
pub(super) const ANCHORS_OF_THREE: [[u8; 64]; 2] = [
    [
        3, 3, 15, 15, 8, 3, 15, 15, 8, 8, 6, 6, 6, 5, 3, 3, 3, 3, 8, 15, 3, 3, 6, 10, 5, 8, 8, 6, 8, 5, 15, 15, 8, 15,
        3, 5, 6, 10, 8, 15, 15, 3, 15, 5, 15, 15, 15, 15, 3, 15, 5, 5, 5, 8, 5, 10, 5, 10, 8, 13, 15, 12, 3, 3,
    ],
    [
        15, 8, 8, 3, 15, 15, 3, 8, 15, 15, 15, 15, 15, 15, 15, 8, 15, 8, 15, 3, 15, 8, 15, 8, 3, 15, 6, 10, 15, 15, 10,
        8, 15, 3, 15, 10, 10, 8, 9, 10, 6, 15, 8, 15, 3, 6, 6, 8, 15, 3, 15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 3, 15,
        15, 8,
    ],
];

/// Weight of the second endpoint in 64ths, by the number of bits of an index and by the index.
pub(super) const WEIGHTS: [&[u32]; 5] = [
    &[0],
    &[0],
    &[0, 21, 43, 64],
    &[0, 9, 18, 27, 37, 46, 55, 64],
    &[0, 4, 9, 13, 17, 21, 26, 30, 34, 38, 43, 47, 51, 55, 60, 64],
];
