//! Quantiser steps (color.md 6.3): 16 an octave, by channel and by length in time.

use crate::color::transform::basis::LENGTHS;
use crate::color::transform::domain::{CHANNELS, Domain};

/// round(4096·2^(i/16)).
pub const OCTAVE: [u32; 16] =
    [4096, 4277, 4467, 4664, 4871, 5087, 5312, 5547, 5793, 6049, 6317, 6597, 6889, 7194, 7512, 7845];
/// round(4096/√length) of each of [`LENGTHS`].
const INVERSE_ROOTS: [u32; LENGTHS.len()] = [4096, 2896, 2365, 2048, 1672, 1448, 1182, 1024, 836];
/// Bits of the fraction of a step, beyond those of the domain.
pub const STEP_BITS: u32 = 3;
/// What a chroma channel's step index is above the payload's: green, orange.
const CHROMA_OFFSETS: [u8; 2] = [3, 8];

/// Step indices of a payload: index i is a step of 2^(i/16 − 2) sample values.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StepIndices {
    pub luma: u8,
    pub chroma: u8,
}

/// Steps of coefficients by channel and index of the length.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Steps {
    of: [[i32; LENGTHS.len()]; CHANNELS],
}

impl Steps {
    pub fn new(indices: StepIndices, domain: &Domain) -> Steps {
        let [green, orange] = CHROMA_OFFSETS.map(|offset| indices.chroma.saturating_add(offset));
        let of = [indices.luma, green, orange].map(|index| std::array::from_fn(|length| step(index, length, domain)));
        Steps { of }
    }

    #[inline(always)]
    pub fn step(&self, channel: usize, length_index: usize) -> i32 {
        self.of[channel][length_index]
    }
}

fn step(index: u8, length: usize, domain: &Domain) -> i32 {
    let mantissa = (OCTAVE[usize::from(index & 15)] * INVERSE_ROOTS[length] + 2048) >> 12;
    // 4096 · 2^-(fraction + 3) of an index of 32, which is a step of 1.
    let shift = 14 - (domain.fraction_bits + STEP_BITS);
    (((mantissa << (index >> 4)) + (1 << (shift - 1))) >> shift).max(1) as i32
}

/// The coefficient of a level: units of 2^-fraction.
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
        for domain in [Domain::BYTES, Domain::HALVES] {
            let at = |luma| Steps::new(StepIndices { luma, chroma: luma }, &domain).step(0, 0);
            assert_eq!(at(32), 1 << (domain.fraction_bits + STEP_BITS));
            assert_eq!(at(64 + 32), 16 * at(32));
            assert!((32..=255).all(|index| at(index) >= at(index - 1)));
        }
    }
}
