//! Block as input of the searches, and the cost of a line and endpoints.

use std::ops::RangeInclusive;

use crate::depth::bc4w::{BYTES, Bc4w, Line, MAX_ENDPOINT, Pair};
use crate::depth::block::{Accuracy, Block};
use crate::depth::quantise::BACKGROUND_CODE;

/// Number of endpoints, of eight codes each, by which a search extends beyond the smallest and the largest surface of a side. The
/// paper pads by 255 codes (algorithm 1). A wider pad can still reduce the error a little, if only a more distant pair rounds to
/// better codes.
pub const PAD: u16 = 8;

/// Pixels of a block. Bit 8y + x of a mask is pixel (x, y).
#[derive(Debug, Clone)]
pub struct Tile {
    pub codes: [u16; 64],
    pub surfaces: u64,
    pub background: u64,
    pub bound: u16,
    pub extremes: Option<[u16; 2]>,
}

/// Line and endpoints of a block, from which the indices follow.
#[derive(Debug, Clone, Copy)]
pub struct Solution {
    pub line: Line,
    pub pairs: [Pair; 2],
}

impl Solution {
    /// A solution that needs no search: code 0 and the background are in both palettes.
    pub const FLAT: Solution = Solution { line: Line::NONE, pairs: [Pair { e0: 0, e1: 0 }; 2] };
}

impl Tile {
    pub fn new(block: &Block<'_>, bound: u16) -> Tile {
        let mut tile = Tile { codes: [0; 64], surfaces: 0, background: 0, bound, extremes: None };
        let (mut low, mut high) = (u16::MAX, 0);
        for (y, row) in block.rows().take(8).enumerate() {
            for (x, &code) in row.iter().take(8).enumerate() {
                tile.codes[8 * y + x] = code;
                let is_background = u64::from(code == BACKGROUND_CODE);
                tile.background |= is_background << (8 * y + x);
                tile.surfaces |= (1 - is_background) << (8 * y + x);
                if code != BACKGROUND_CODE {
                    low = low.min(code);
                    high = high.max(code);
                }
            }
        }
        tile.extremes = (tile.surfaces != 0).then_some([low, high]);
        tile
    }

    /// Returns the endpoints that a search considers for a side; all endpoints if the side has no surface.
    pub fn endpoints(&self, side: u64) -> RangeInclusive<u16> {
        let (mut low, mut high) = (u16::MAX, 0);
        let mut rest = self.surfaces & side;
        if rest == 0 {
            return 0..=MAX_ENDPOINT;
        }
        while rest != 0 {
            let code = self.codes[rest.trailing_zeros() as usize];
            (low, high) = (low.min(code), high.max(code));
            rest &= rest - 1;
        }
        (low >> 3).saturating_sub(PAD)..=((high >> 3) + PAD).min(MAX_ENDPOINT)
    }

    /// Returns the sum of squared differences of the pixels of `side`; `None` if the pair exceeds the bound or lacks a needed
    /// background.
    pub fn cost(&self, side: u64, pair: Pair) -> Option<u64> {
        let palette = pair.palette();
        if self.background & side != 0 && !palette.contains(&BACKGROUND_CODE) {
            return None;
        }
        let levels = surface_codes(palette);
        let (mut sum, mut rest) = (0, self.surfaces & side);
        while rest != 0 {
            let code = self.codes[rest.trailing_zeros() as usize];
            let error = levels.iter().map(|&level| level.abs_diff(code)).min().unwrap_or(0);
            if error > self.bound {
                return None;
            }
            sum += u64::from(error) * u64::from(error);
            rest &= rest - 1;
        }
        Some(sum)
    }

    /// Returns the block of a solution. Each pixel takes the nearest code of its palette, the first of equally near ones; the
    /// background is exact, and no surface becomes background.
    pub fn finish(&self, solution: Solution) -> (Bc4w, Accuracy) {
        let side_b = solution.line.side_b();
        let palettes = solution.pairs.map(Pair::palette);
        let mut indices = [0; 64];
        let mut accuracy = Accuracy::default();
        for (pixel, index) in indices.iter_mut().enumerate() {
            let bit = 1 << pixel;
            if (self.surfaces | self.background) & bit == 0 {
                continue;
            }
            let is_background = self.background & bit != 0;
            let (best, error) = palettes[usize::from(side_b & bit != 0)]
                .iter()
                .enumerate()
                .filter(|&(_, &code)| (code == BACKGROUND_CODE) == is_background)
                .map(|(at, &code)| (at as u8, code.abs_diff(self.codes[pixel])))
                .min_by_key(|&(_, error)| error)
                .unwrap_or((0, 0));
            *index = best;
            accuracy.max_error = accuracy.max_error.max(error);
            accuracy.squared_error += u64::from(error) * u64::from(error);
        }
        (Bc4w::pack(solution.line, solution.pairs, &indices), accuracy)
    }
}

impl Bc4w {
    /// Packs a block. A line of two equal points is written as zeros, so the twelve highest bits are never all ones, and the last
    /// four bytes are never a marker.
    pub fn pack(line: Line, pairs: [Pair; 2], indices: &[u8; 64]) -> Bc4w {
        let [p0, p1] = line.points();
        let line = if p0 == p1 { Line::NONE } else { line };
        let [a, b] = pairs;
        let tail = [(a.e0, 0), (a.e1, 13), (b.e0, 26), (b.e1, 39), (line.bits(), 52)]
            .iter()
            .fold(0, |word, &(bits, shift)| word | u64::from(bits) << shift);
        let mut bytes = [0; BYTES];
        for (bytes, indices) in bytes.chunks_exact_mut(3).zip(indices.chunks_exact(8)) {
            let row = indices.iter().rev().fold(0u32, |row, &index| row << 3 | u32::from(index));
            bytes.copy_from_slice(&row.to_le_bytes()[..3]);
        }
        bytes[24..].copy_from_slice(&tail.to_le_bytes());
        Bc4w(bytes)
    }
}

/// Returns the palette for surfaces: the background is replaced by another code of the palette, which always exists.
pub fn surface_codes(palette: [u16; 8]) -> [u16; 8] {
    let usable = if palette[1] == BACKGROUND_CODE { palette[6] } else { palette[1] };
    palette.map(|code| if code == BACKGROUND_CODE { usable } else { code })
}
