//! Means of squares of 4×4 pixels, which predict the mean of the next block (color.md 6.5).

use crate::color::transform::basis::{BASIS_BITS, basis};
use crate::color::transform::blocks::{Block, MIN_SIDE, REGION};
use crate::color::transform::domain::CHANNELS;
use crate::color::transform::steps::STEP_BITS;

const SIDE: usize = REGION / MIN_SIDE;

/// Mean of each square of a region in its last decoded frame, in units of 2^-fraction.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Means([[i32; SIDE * SIDE]; CHANNELS]);

impl Default for Means {
    fn default() -> Self {
        Means([[0; SIDE * SIDE]; CHANNELS])
    }
}

impl Means {
    /// Predicts the level of a block's mean from the frame before; in the first frame, from the squares on the left and
    /// above.
    pub fn predict(&self, channel: usize, block: Block, step: i32) -> i32 {
        let means = &self.0[channel];
        let (x, y, squares) = (block.place.x / MIN_SIDE, block.place.y / MIN_SIDE, block.shape.side() / MIN_SIDE);
        let sum_of = |at: &mut dyn Iterator<Item = usize>| at.fold(0i32, |sum, at| sum.wrapping_add(means[at]));
        let mean = if block.place.frame > 0 {
            let mut inside = (y..y + squares).flat_map(|y| (x..x + squares).map(move |x| y * SIDE + x));
            sum_of(&mut inside) >> (2 * block.shape.level)
        } else {
            let left = if x > 0 { sum_of(&mut (y..y + squares).map(|y| y * SIDE + x - 1)) } else { 0 };
            let above = if y > 0 { sum_of(&mut (x..x + squares).map(|x| (y - 1) * SIDE + x)) } else { 0 };
            let both = u32::from(x > 0 && y > 0);
            left.wrapping_add(above) >> (block.shape.level as u32 + both)
        };
        let scaled = mean.wrapping_mul((block.shape.side() as i32) << STEP_BITS);
        scaled.wrapping_add(step >> 1).div_euclid(step)
    }

    /// Stores the mean of a transformed block, from the constant coefficients of its planes.
    pub fn set_block(&mut self, channel: usize, block: Block, coefficients: &[i32]) {
        let frames = block.shape.frames;
        let sum = coefficients.iter().enumerate().fold(0i32, |sum, (plane, &coefficient)| {
            sum.wrapping_add(coefficient.wrapping_mul(basis(frames, plane, frames - 1)))
        });
        let mean = (sum.wrapping_add(1 << (BASIS_BITS - 1)) >> BASIS_BITS) >> (2 + block.shape.level);
        let squares = block.shape.side() / MIN_SIDE;
        for y in block.place.y / MIN_SIDE..block.place.y / MIN_SIDE + squares {
            let first = y * SIDE + block.place.x / MIN_SIDE;
            self.0[channel][first..first + squares].fill(mean);
        }
    }

    /// Stores the means of the square at pixel (x, y) of the region.
    pub fn set_square(&mut self, [x, y]: [usize; 2], means: [i32; CHANNELS]) {
        for (channel, mean) in self.0.iter_mut().zip(means) {
            channel[y / MIN_SIDE * SIDE + x / MIN_SIDE] = mean;
        }
    }
}
