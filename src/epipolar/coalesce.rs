//! Primitive coalescing (Epipolar 3.4.3): runs of lines that move together.
//!
//! A run is a block of 2^n neighbours of one surface, aligned to a multiple of its length, whose disparities differ by no more than the
//! threshold. A view draws it as one primitive: all of its lines move by the middle of their disparities, so that no column is wrong by
//! more than half of the threshold, and keep their own depths. The blocks are the nodes of a pyramid of least and greatest disparities,
//! found from the finest level up.
//!
//! Listings 3.12 and 3.13 of the thesis compare depths, where the error in columns depends on the distance, too; mark what ends a run by
//! a depth of 1, which a pixel may have; and look up the node of the image's width, not of the pixel's column.

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

/// Lines of one surface in columns that follow each other, which move together.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Run {
    /// Index of the first line.
    pub first: u32,
    /// Lines, a power of two.
    pub length: u32,
    /// Column of the first line in its own view, 1/256 pixels.
    pub column: i32,
    /// 1/4096 pixels over the baseline.
    pub disparity: i32,
    pub source: u16,
    /// Whether the next run begins with the next pixel of the same surface.
    pub joins_next: bool,
    /// Whether the lines are of the first layer.
    pub is_first: bool,
}

/// All lines of a scanline, and the runs that they form, both in their order.
#[derive(Debug, Clone, Default)]
pub struct LineRuns {
    pub lines: Vec<Line>,
    pub runs: Vec<Run>,
}

impl LineRuns {
    pub fn new(lines: Vec<Line>, coalescing: Coalescing) -> LineRuns {
        LineRuns { runs: runs(&lines, coalescing), lines }
    }
}

/// Divides lines into the longest runs.
fn runs(lines: &[Line], coalescing: Coalescing) -> Vec<Run> {
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
            let is_joined = block[length - 1..longer - 1].iter().all(|line| line.joins_next)
                && block[length..].iter().all(|line| line.is_first == lines[at].is_first);
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
        let Line { column, source, is_first, .. } = lines[at];
        runs.push(Run {
            first: at as u32,
            length: length as u32,
            column,
            disparity: least.disparity + (most.disparity.abs_diff(least.disparity) / 2) as i32,
            source,
            joins_next: lines[at + length - 1].joins_next,
            is_first,
        });
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

    fn by(pixels: f64) -> Coalescing {
        if pixels > 0.0 { Coalescing::Disparity(pixels) } else { Coalescing::Off }
    }

    fn lengths(lines: &[Line], coalescing: Coalescing) -> Vec<u32> {
        let runs = runs(lines, coalescing);
        let ends = runs.iter().scan(0, |end, run| {
            assert_eq!(run.first, *end);
            *end += run.length;
            Some(*end)
        });
        assert_eq!(ends.last(), Some(lines.len() as u32));
        runs.iter().map(|run| run.length).collect()
    }

    #[test]
    fn runs_are_aligned_blocks_within_the_threshold() {
        let mut disparities = vec![4096; 16];
        disparities[11] += 5000;
        let uneven = lines(&disparities);
        assert_eq!(lengths(&uneven, by(1.0)), [8, 2, 1, 1, 4]);
        // With a larger threshold all are one, in the middle of them.
        assert_eq!(lengths(&uneven, by(2.0)), [16]);
        assert_eq!(runs(&uneven, by(2.0))[0].disparity, 4096 + 2500);
        // Without one, and across an edge, none are.
        assert_eq!(lengths(&uneven, by(0.0)), [1; 16]);
        let mut parted = lines(&[0; 4]);
        parted[0].joins_next = false;
        assert_eq!(lengths(&parted, by(9.0)), [1, 1, 2]);
        assert_eq!(runs(&parted, by(9.0)).iter().map(|run| run.joins_next).collect::<Vec<_>>(), [false, true, false]);
        // A surface that goes on behind another one is not drawn as the first layer there.
        let mut behind = lines(&[0; 4]);
        behind[3].is_first = false;
        assert_eq!(lengths(&behind, by(9.0)), [2, 1, 1]);
    }

    #[test]
    fn depths_join_within_metres_and_bound_no_column() {
        let at_depths = |depths_m: [f32; 4], metres: f64| {
            let mut lines = lines(&[0, 4096, 8192, 12_288]);
            lines.iter_mut().zip(depths_m).for_each(|(line, depth_m)| line.depth = depth_m.to_bits());
            lengths(&lines, Coalescing::Depth(metres))
        };
        assert_eq!(at_depths([1.0, 1.1, 1.2, 1.3], 0.5), [4]);
        assert_eq!(at_depths([1.0, 1.1, 1.6, 1.7], 0.25), [2, 2]);
        assert_eq!(at_depths([f32::INFINITY; 4], 0.0), [4]);
        assert_eq!(at_depths([1.0, 1.1, 1.2, 1.3], 0.0), [1; 4]);
    }
}
