//! BC4w: 8×8 codes in 32 bytes (depth.md 8).
//!
//! Decodes 32 bytes into the codes of a block of level 1.
//!
//! Based on: GDC 3.3, figure 3, algorithm 1. A line divides the pixels into two sides. Each side has a palette of eight codes
//! between two endpoints, as in BC4, and each pixel has an index into the palette of its side.

#[cfg(feature = "encode")]
pub mod bipartitions;
#[cfg(feature = "encode")]
mod fit;
#[cfg(feature = "encode")]
mod quick;
#[cfg(feature = "encode")]
pub mod search;
#[cfg(feature = "encode")]
mod sums;
#[cfg(feature = "encode")]
pub mod tile;

use std::ops::RangeInclusive;
use std::sync::LazyLock;

use crate::depth::block::BlockMut;
use crate::depth::quantise::BACKGROUND_CODE;

pub const BYTES: usize = 32;
/// Byte range that is all ones in the markers of other functions, and never in a BC4w block (depth.md 7).
pub const MARKER_BYTES: RangeInclusive<usize> = 28..=31;
pub const MAX_ENDPOINT: u16 = 8191;

static SIDES: LazyLock<Vec<u64>> = LazyLock::new(|| (0..4096).map(|bits| Line(bits).by_cross_product()).collect());

/// A block: 64 indices of 3 bits, four endpoints of 13 bits, a line of 12 bits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Bc4w([u8; BYTES]);

/// Two endpoints of 13 bits; their order selects the mode.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Pair {
    pub e0: u16,
    pub e1: u16,
}

impl Pair {
    /// Expands a 13-bit endpoint to a 16-bit code: 0 to 0, 8191 to 65535.
    pub const fn code(endpoint: u16) -> u16 {
        endpoint << 3 | endpoint >> 10
    }

    /// Returns the codes of indices 0 to 7. With e0 > e1 all eight are evenly spaced; otherwise six are, index 6 is code 0, and
    /// index 7 is the background.
    pub fn palette(self) -> [u16; 8] {
        let endpoints = [self.e0, self.e1];
        if self.e0 > self.e1 { Pair::eight(endpoints) } else { Pair::six(endpoints) }
    }

    fn eight(endpoints: [u16; 2]) -> [u16; 8] {
        let [d0, d1] = endpoints.map(|endpoint| u32::from(Pair::code(endpoint)));
        let between = |i: u32| (((8 - i) * d0 + (i - 1) * d1 + 3) / 7) as u16;
        [d0 as u16, d1 as u16, between(2), between(3), between(4), between(5), between(6), between(7)]
    }

    fn six(endpoints: [u16; 2]) -> [u16; 8] {
        let [d0, d1] = endpoints.map(|endpoint| u32::from(Pair::code(endpoint)));
        let between = |i: u32| (((6 - i) * d0 + (i - 1) * d1 + 2) / 5) as u16;
        [d0 as u16, d1 as u16, between(2), between(3), between(4), between(5), 0, BACKGROUND_CODE]
    }
}

impl Bc4w {
    /// Returns the block of 32 bytes; `None` if the last four bytes are the marker of another function.
    pub fn from_bytes(bytes: [u8; BYTES]) -> Option<Bc4w> {
        (bytes[MARKER_BYTES] != [0xff; 4]).then_some(Bc4w(bytes))
    }

    pub fn as_bytes(&self) -> &[u8; BYTES] {
        &self.0
    }

    fn tail(&self) -> u64 {
        self.0[24..].iter().rev().fold(0, |word, &byte| word << 8 | u64::from(byte))
    }

    pub fn line(&self) -> Line {
        Line::from_bits((self.tail() >> 52) as u16)
    }

    pub fn pairs(&self) -> [Pair; 2] {
        let tail = self.tail();
        let endpoint = |shift: u32| (tail >> shift) as u16 & MAX_ENDPOINT;
        [Pair { e0: endpoint(0), e1: endpoint(13) }, Pair { e0: endpoint(26), e1: endpoint(39) }]
    }

    pub fn palettes(&self) -> [[u16; 8]; 2] {
        self.pairs().map(Pair::palette)
    }

    pub fn decode(&self, target: &mut BlockMut<'_>) {
        let [a, b] = self.palettes();
        let mut codes = [0; 16];
        codes[..8].copy_from_slice(&a);
        codes[8..].copy_from_slice(&b);
        let sides = self.line().side_b().to_le_bytes();
        for ((row, indices), side) in target.rows_mut().zip(self.0.chunks_exact(3)).zip(sides) {
            let indices = u32::from(indices[0]) | u32::from(indices[1]) << 8 | u32::from(indices[2]) << 16;
            let side = u32::from(side) << 3;
            for (x, code) in row.iter_mut().enumerate() {
                *code = codes[(indices >> (3 * x) & 7 | side >> x & 8) as usize];
            }
        }
    }
}

/// A line through two pixels, which divides the 64 pixels of a block into two sides; in 12 bits: x0, y0, x1, y1 from the lowest
/// bit on, three bits each.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Line(u16);

impl Line {
    /// The line that does not divide the block: all pixels are on side A.
    pub const NONE: Line = Line(0);

    pub fn from_bits(bits: u16) -> Line {
        Line(bits & 0xfff)
    }

    pub fn bits(self) -> u16 {
        self.0
    }

    pub fn points(self) -> [[u8; 2]; 2] {
        let at = |shift: u32| (self.0 >> shift & 7) as u8;
        [[at(0), at(3)], [at(6), at(9)]]
    }

    /// Returns the mask of side B; bit 8y + x is pixel (x, y).
    pub fn side_b(self) -> u64 {
        SIDES[usize::from(self.0)]
    }

    /// Returns the mask of side B: the pixels with (x1 − x0)(y − y0) − (y1 − y0)(x − x0) > 0. The two points themselves are on
    /// side A.
    fn by_cross_product(self) -> u64 {
        let [[x0, y0], [x1, y1]] = self.points().map(|point| point.map(i32::from));
        (0..64).fold(0, |mask, pixel| {
            let (x, y) = (pixel & 7, pixel >> 3);
            let cross = (x1 - x0) * (y - y0) - (y1 - y0) * (x - x0);
            mask | u64::from(cross > 0) << pixel
        })
    }
}
