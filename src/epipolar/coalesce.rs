//! Primitive coalescing (Epipolar 3.4.3): runs of lines that move together.
//!
//! A run is a block of 2^n neighbours of one surface, aligned to a multiple of its length, whose disparities differ by no more than the
//! threshold: all get the middle of them, so that no column is wrong by more than half of the threshold. The blocks are the nodes of a
//! pyramid of least and greatest disparities, found from the finest level up.
//!
//! Listings 3.12 and 3.13 of the thesis compare depths, where the error in columns depends on the distance, too; mark what ends a run by a depth of 1, which a
//! pixel may have; and look up the node of the image's width, not of the pixel's column.

use std::ops::Range;

use super::lines::{COLUMN_BITS, Line};

/// Levels of the pyramid above single pixels.
const LEVELS: u32 = 6;
/// Parts of a pixel in disparities.
const DISPARITY_PARTS: f64 = 4096.0;

/// What the lines of a run have in common.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub enum Coalescing {
    /// Each line is alone.
    #[default]
    Off,
    /// Disparities that differ by so many pixels over the baseline at most, which bounds the error.
    Disparity(f64),
    /// Planar distances that differ by so many metres at most, as in the thesis.
    Depth(f64),
}

impl Coalescing {
    /// Whether lines between these may be one run.
    fn joins(self, [least, most]: [&Line; 2]) -> bool {
        match self {
            Coalescing::Off => false,
            Coalescing::Disparity(pixels) => {
                f64::from(most.disparity.abs_diff(least.disparity)) <= (pixels * DISPARITY_PARTS).floor()
            }
            Coalescing::Depth(metres) => {
                let [a, b] = [least, most].map(|line| f64::from(f32::from_bits(line.depth)));
                a == b || (a - b).abs() <= metres
            }
        }
    }
}

/// Divides the lines of a scanline into runs, and gives the lines of each the same disparity.
pub fn coalesce(lines: &mut [Line], coalescing: Coalescing) -> Vec<Range<usize>> {
    let mut runs = Vec::with_capacity(lines.len());
    let mut at = 0;
    while at < lines.len() {
        let column = lines[at].column >> COLUMN_BITS;
        let mut length = 1;
        // Disparity rises with the distance.
        let [mut least, mut most] = [lines[at]; 2];
        for level in 1..=LEVELS {
            let longer = 1usize << level;
            let is_aligned = column & (longer as i32 - 1) == 0;
            let Some(block) = lines.get(at..at + longer).filter(|_| is_aligned) else { break };
            let is_joined = block[length - 1..longer - 1].iter().all(|line| line.joins_next);
            let [mut low, mut high] = [least, most];
            for line in &block[length..] {
                low = if line.disparity < low.disparity { *line } else { low };
                high = if line.disparity > high.disparity { *line } else { high };
            }
            if !is_joined || !coalescing.joins([&low, &high]) {
                break;
            }
            (length, least, most) = (longer, low, high);
        }
        let middle = least.disparity + (most.disparity.abs_diff(least.disparity) / 2) as i32;
        lines[at..at + length].iter_mut().for_each(|line| line.disparity = middle);
        runs.push(at..at + length);
        at += length;
    }
    runs
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(disparities: &[i32]) -> Vec<Line> {
        let line = |(at, &disparity): (usize, &i32)| Line {
            column: ((at as i32) << COLUMN_BITS) + 128,
            disparity,
            depth: 1,
            pixel: at as u32,
            source: 0,
            joins_next: at + 1 < disparities.len(),
            is_first: true,
        };
        disparities.iter().enumerate().map(line).collect()
    }

    #[test]
    fn runs_are_aligned_blocks_within_the_threshold() {
        let mut disparities = vec![4096; 16];
        disparities[11] += 5000;
        let mut coalesced = lines(&disparities);
        let by = |pixels: f64| if pixels > 0.0 { Coalescing::Disparity(pixels) } else { Coalescing::Off };
        let runs = coalesce(&mut coalesced, by(1.0));
        assert_eq!(runs, [0..8, 8..10, 10..11, 11..12, 12..16]);
        assert_eq!(coalesced, lines(&disparities));
        // With a larger threshold all are one, in the middle of them.
        assert_eq!(coalesce(&mut coalesced, by(2.0)).len(), 1);
        assert!(coalesced.iter().all(|line| line.disparity == 4096 + 2500));
        // Without one, and across an edge, none are.
        let mut alone = lines(&disparities);
        assert_eq!(coalesce(&mut alone, by(0.0)).len(), 16);
        let mut parted = lines(&[0; 4]);
        parted[0].joins_next = false;
        assert_eq!(coalesce(&mut parted, by(9.0)), [0..1, 1..2, 2..4]);
    }

    #[test]
    fn depths_join_within_metres_and_bound_no_column() {
        let at_depths = |depths_m: [f32; 4], metres: f64| {
            let mut lines = lines(&[0, 4096, 8192, 12_288]);
            lines.iter_mut().zip(depths_m).for_each(|(line, depth_m)| line.depth = depth_m.to_bits());
            coalesce(&mut lines, Coalescing::Depth(metres))
        };
        assert_eq!(at_depths([1.0, 1.1, 1.2, 1.3], 0.5).len(), 1);
        assert_eq!(at_depths([1.0, 1.1, 1.6, 1.7], 0.25), [0..2, 2..4]);
        assert_eq!(at_depths([f32::INFINITY; 4], 0.0).len(), 1);
        assert_eq!(at_depths([1.0, 1.1, 1.2, 1.3], 0.0).len(), 4);
    }
}
