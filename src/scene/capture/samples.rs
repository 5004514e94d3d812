//! Positions of a pixel's colour samples.
//!
//! They are the same in every pixel and frame, so static pixels are bit-identical. A square number of samples forms a regular
//! grid; any other number uses Hammersley points: `k/N` across, the bit-reversed `k` down.

use codec::error::{Error, Result};

pub const MAX_SAMPLES: u32 = 4096;

/// Points in a pixel, with coordinates in 0..1; the pixel centre is (½, ½).
#[derive(Debug, Clone, PartialEq)]
pub struct SamplePattern {
    pub points: Vec<[f64; 2]>,
}

impl SamplePattern {
    pub fn new(count: u32) -> Result<SamplePattern> {
        if count == 0 || count > MAX_SAMPLES {
            return Err(Error::Usage(format!("a pixel has 1 to {MAX_SAMPLES} samples, not {count}")));
        }
        let side = count.isqrt();
        let points = if side * side == count {
            let at = |step: u32| (f64::from(step) + 0.5) / f64::from(side);
            (0..count).map(|k| [at(k % side), at(k / side)]).collect()
        } else {
            // Shifted by half a step, so that their mean is the centre of the pixel.
            let bits = count.next_power_of_two().trailing_zeros();
            let mirrored = |k: u32| f64::from(k.reverse_bits() >> (32 - bits));
            let down = |k: u32| (mirrored(k) + 0.5) / f64::from(1_u32 << bits);
            (0..count).map(|k| [(f64::from(k) + 0.5) / f64::from(count), down(k)]).collect()
        };
        Ok(SamplePattern { points })
    }

    /// True if the pixel centre is the only sample.
    pub fn is_centre(&self) -> bool {
        self.points == [[0.5; 2]]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn squares_are_grids_and_one_is_the_centre() {
        assert!(SamplePattern::new(1).unwrap().is_centre());
        let four = SamplePattern::new(4).unwrap();
        assert_eq!(four.points, [[0.25, 0.25], [0.75, 0.25], [0.25, 0.75], [0.75, 0.75]]);
        assert!(!four.is_centre());
        assert_eq!(SamplePattern::new(16).unwrap().points[6], [0.625, 0.375]);
    }

    #[test]
    fn other_numbers_are_spread_over_both_axes() {
        for count in [2, 3, 5, 8, 12, 99, 1000] {
            let pattern = SamplePattern::new(count).unwrap();
            assert_eq!(pattern.points.len(), count as usize);
            for axis in 0..2 {
                let mut along: Vec<f64> = pattern.points.iter().map(|point| point[axis]).collect();
                along.sort_by(f64::total_cmp);
                // All values are distinct, and no gap is wider than two steps.
                assert!(along.windows(2).all(|pair| pair[0] < pair[1]), "{count}");
                let step = 2.0 / f64::from(count);
                assert!(along[0] > 0.0 && along[0] < step && along[count as usize - 1] < 1.0, "{count}");
                assert!(along.windows(2).all(|pair| pair[1] - pair[0] <= step), "{count}");
            }
        }
        assert!(SamplePattern::new(0).is_err());
        assert!(SamplePattern::new(MAX_SAMPLES + 1).is_err());
    }
}
