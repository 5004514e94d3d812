//! Primitive coalescing (Epipolar 3.4.3): merges lines that move together into runs.
//!
//! A run is a block of 2^n neighbouring lines of one surface, aligned to a multiple of its length, whose disparities differ by at
//! most the threshold. A view draws it as one primitive: all of its lines move by the midpoint of the block's minimum and maximum
//! disparity, so that no column is off by more than half of the threshold. Lines keep their own depths. The blocks are the nodes
//! of a pyramid of minimum and maximum disparities, which is searched from the finest level up.
//!
//! Listings 3.12 and 3.13 of the thesis compare depths, although the error in columns also depends on the distance; mark the end
//! of a run by a depth of 1, which a pixel may have; and look up the pyramid node at the image's width instead of the pixel's
//! column.

use super::lines::{COLUMN_BITS, Line};

/// Number of pyramid levels above single pixels.
const LEVELS: u32 = 6;
/// Disparity units per pixel.
const DISPARITY_PARTS: f64 = 4096.0;

/// Condition under which lines are merged into a run.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub enum Coalescing {
    /// Each line is a run of its own.
    #[default]
    Off,
    /// Maximum difference of disparities, in pixels over the baseline. This bounds the error in columns.
    Disparity(f64),
    /// Maximum difference of planar distances, in metres, as in the thesis.
    Depth(f64),
}

impl Coalescing {
    /// Returns true if lines whose disparities lie between these two may form one run.
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

/// Lines of one surface in consecutive columns, which move together.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Run {
    /// Index of the first line.
    pub first: u32,
    /// Number of lines, a power of two.
    pub length: u32,
    /// Column of the first line in its own view, in 1/256 pixels.
    pub column: i32,
    /// Disparity in 1/4096 pixels over the baseline.
    pub disparity: i32,
    pub source: u16,
    /// True if the next run begins with the next pixel of the same surface.
    pub joins_next: bool,
    /// True if the lines belong to the first layer.
    pub is_first: bool,
}

/// All lines of a scanline, and the runs that they form, in the same order.
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

/// Divides lines into runs of maximum length.
fn runs(lines: &[Line], coalescing: Coalescing) -> Vec<Run> {
    let mut runs = Vec::with_capacity(lines.len());
    let mut at = 0;
    while at < lines.len() {
        let column = lines[at].column >> COLUMN_BITS;
        let mut length = 1;
        // Disparity increases with distance, so these lines also have the minimum and maximum depth.
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
        // With a larger threshold all lines form one run, at the midpoint of their disparities.
        assert_eq!(lengths(&uneven, by(2.0)), [16]);
        assert_eq!(runs(&uneven, by(2.0))[0].disparity, 4096 + 2500);
        // Lines are not merged with a threshold of 0, nor across an edge.
        assert_eq!(lengths(&uneven, by(0.0)), [1; 16]);
        let mut parted = lines(&[0; 4]);
        parted[0].joins_next = false;
        assert_eq!(lengths(&parted, by(9.0)), [1, 1, 2]);
        assert_eq!(runs(&parted, by(9.0)).iter().map(|run| run.joins_next).collect::<Vec<_>>(), [false, true, false]);
        // A surface that continues behind another one is a new run, as it is no longer in the first layer.
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
