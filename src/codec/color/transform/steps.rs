//! Quantiser steps (color.md 6.3): 16 per octave, by channel, by frequency, and by length in time.

use std::ops::RangeInclusive;

use crate::color::transform::basis::LENGTHS;

/// Channels of a pixel: luma, green chroma, orange chroma.
pub const CHANNELS: usize = 3;
/// round(4096·2^(i/16)).
pub const OCTAVE: [u32; 16] =
    [4096, 4277, 4467, 4664, 4871, 5087, 5312, 5547, 5793, 6049, 6317, 6597, 6889, 7194, 7512, 7845];
/// round(4096/√length) of each of [`LENGTHS`].
pub const INVERSE_ROOTS: [u32; LENGTHS.len()] = [4096, 2896, 2365, 2048, 1672, 1448, 1182, 1024, 836];
/// Fraction bits of a step, in addition to those of the domain.
pub const STEP_BITS: u32 = 3;
/// Offsets of the step indices of green and orange from the payload's chroma index.
const CHROMA_OFFSETS: [u8; 2] = [3, 8];

/// Step indices of a payload: index i is a step of 2^(i/16 − 2) keys in a block of one frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StepIndices {
    pub luma: u8,
    pub chroma: u8,
}

/// Offsets of the step index by frequency (color.md 6.3), for luma and for chroma.
pub type FrequencyOffsets = [[u8; 64]; 2];

/// Sets of frequency offsets that a payload selects from: equal steps for all frequencies; coarser steps where the eye is
/// less sensitive.
pub static OFFSET_SETS: [FrequencyOffsets; 2] = [
    [[0; 64]; 2],
    [
        [
            1, 3, 5, 7, 8, 9, 10, 10, 11, 12, 12, 13, 13, 14, 14, 15, 15, 15, 16, 16, 16, 17, 17, 17, 18, 18, 18, 18,
            19, 19, 19, 19, 19, 20, 20, 20, 20, 20, 21, 21, 21, 21, 21, 21, 22, 22, 22, 22, 22, 22, 22, 23, 23, 23, 23,
            23, 23, 23, 23, 24, 24, 24, 24, 24,
        ],
        [
            2, 5, 8, 10, 12, 14, 15, 16, 18, 19, 20, 20, 21, 22, 23, 23, 24, 25, 25, 26, 26, 27, 27, 28, 28, 29, 29,
            29, 30, 30, 30, 31, 31, 31, 32, 32, 32, 33, 33, 33, 34, 34, 34, 34, 35, 35, 35, 35, 36, 36, 36, 36, 36, 37,
            37, 37, 37, 37, 38, 38, 38, 38, 38, 38,
        ],
    ],
];

/// Step indices per unit of a region's delta.
pub const DELTA_UNIT: i32 = 4;
/// Range of a region's delta.
pub const DELTAS: RangeInclusive<i8> = -8..=7;

/// Steps of the coefficients of a region.
#[derive(Debug, Clone)]
pub struct Steps {
    /// Step indices by channel, with the region's delta.
    indices: [i32; CHANNELS],
    offsets: &'static FrequencyOffsets,
    table: &'static StepTable,
}

impl Steps {
    pub fn new(indices: StepIndices, offset_set: usize, delta: i8, table: &'static StepTable) -> Steps {
        let [green, orange] = CHROMA_OFFSETS.map(|offset| i32::from(indices.chroma) + i32::from(offset));
        let moved = |index: i32| index + DELTA_UNIT * i32::from(delta);
        let offsets = &OFFSET_SETS[offset_set.min(OFFSET_SETS.len() - 1)];
        Steps { indices: [indices.luma.into(), green, orange].map(moved), offsets, table }
    }

    /// Step indices of the channels, without frequency offsets.
    pub fn indices(&self) -> [i32; CHANNELS] {
        self.indices
    }

    /// Steps of a channel for blocks of a size class and length.
    #[inline(always)]
    pub fn of(&self, channel: usize, size_class: usize, length_index: usize) -> ChannelSteps {
        ChannelSteps {
            index: self.indices[channel],
            offsets: &self.offsets[usize::from(channel > 0)],
            size_class,
            steps: &self.table[length_index],
        }
    }
}

#[derive(Debug, Clone, Copy)]
pub struct ChannelSteps {
    index: i32,
    offsets: &'static [u8; 64],
    size_class: usize,
    steps: &'static [i32; 256],
}

impl ChannelSteps {
    /// Step of a spatial frequency, which is the sum of the vertical and the horizontal one.
    #[inline(always)]
    pub fn at(&self, frequency: usize) -> i32 {
        let offset = self.offsets[offset_class(self.size_class, frequency)];
        self.steps[(self.index + i32::from(offset)).clamp(0, 255) as usize]
    }

    /// Coefficient of a level, in units of 2^-fraction.
    #[inline(always)]
    pub fn coefficient(&self, frequency: usize, level: i32) -> i32 {
        dequantise(level, self.at(frequency))
    }
}

/// Index in a table of offsets for a frequency in blocks of a size class: the centre of its band, as a frequency of the
/// largest blocks.
#[inline(always)]
pub fn offset_class(size_class: usize, frequency: usize) -> usize {
    ((2 * frequency + 1) << (3 - size_class.min(3)) >> 1) & 63
}

/// Steps by length index and step index.
pub type StepTable = [[i32; 256]; LENGTHS.len()];

/// Step table of samples with `fraction_bits` fraction bits.
pub const fn step_table(fraction_bits: u32) -> StepTable {
    let mut table = [[0; 256]; LENGTHS.len()];
    let mut length = 0;
    while length < LENGTHS.len() {
        let mut index = 0;
        while index < 256 {
            let mantissa = (OCTAVE[index & 15] * INVERSE_ROOTS[length] + 2048) >> 12;
            // Index 32 is a step of 1: 4096 · 2² >> shift = 2^(fraction + 3).
            let shift = 14 - (fraction_bits + STEP_BITS);
            let step = ((mantissa << (index >> 4)) + (1 << (shift - 1))) >> shift;
            table[length][index] = if step == 0 { 1 } else { step as i32 };
            index += 1;
        }
        length += 1;
    }
    table
}

/// Coefficient of a level, in units of 2^-fraction.
#[inline(always)]
pub fn dequantise(level: i32, step: i32) -> i32 {
    level.wrapping_mul(step).wrapping_add(1 << (STEP_BITS - 1)) >> STEP_BITS
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_are_those_of_the_formulas() {
        for (i, &mantissa) in OCTAVE.iter().enumerate() {
            assert_eq!(f64::from(mantissa), (4096.0 * 2f64.powf(i as f64 / 16.0)).round());
        }
        for (length, root) in LENGTHS.into_iter().zip(INVERSE_ROOTS) {
            assert_eq!(f64::from(root), (4096.0 / (length as f64).sqrt()).round());
        }
    }

    #[test]
    fn an_octave_doubles_a_step() {
        static TABLES: [(u32, StepTable); 2] = [(6, step_table(6)), (0, step_table(0))];
        for (fraction_bits, table) in &TABLES {
            let at = |luma| Steps::new(StepIndices { luma, chroma: luma }, 0, 0, table).of(0, 0, 0).at(0);
            assert_eq!(at(32), 1 << (fraction_bits + STEP_BITS));
            assert_eq!(at(64 + 32), 16 * at(32));
            assert!((32..=255).all(|index| at(index) >= at(index - 1)));
        }
    }
}
