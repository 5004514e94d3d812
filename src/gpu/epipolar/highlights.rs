//! Highlights on a device (Epipolar 3.5): the CPU places splits for the visible lines in double precision, and a kernel
//! interpolates between them.

use std::ops::Range;

use rayon::prelude::*;

use epipolar::coalesce::LineRuns;
use epipolar::interpolate::{Interpolator, Shader};
use epipolar::lines::Line;
use kernels::layout::{LineSplit, words_of};

/// Maximum radiance of a split, which keeps single-precision results finite; far above the range of half floats.
const MAX_RADIANCE: f64 = 1e30;

/// Splits of lines, as words for a kernel.
#[derive(Debug, Default)]
pub struct SplitWords {
    /// First split of each line, then the end of the last line.
    pub starts: Vec<u32>,
    /// Words of [`LineSplit`]s.
    pub splits: Vec<u32>,
}

/// Highlights of some scanlines.
#[derive(Debug)]
pub struct Highlights<'a> {
    /// Lines of each scanline, and its shader; `None` if the scanline has no highlights.
    rows: Vec<(&'a [Line], Option<Shader<'a>>)>,
}

impl<'a> Highlights<'a> {
    /// Prepares the highlights of scanlines starting at `first_row`; `None` if no line has a highlight.
    pub fn new(of: &'a Interpolator<'a>, first_row: usize, lines: &[&'a LineRuns]) -> Option<Highlights<'a>> {
        let shader = |row: usize, lines: &'a [Line]| of.has_gloss(row).then(|| Shader::new(of, lines, row));
        let rows = (first_row..).zip(lines).map(|(row, of_row)| (&of_row.lines[..], shader(row, &of_row.lines)));
        let rows: Vec<_> = rows.collect();
        rows.iter().any(|(_, shader)| shader.is_some()).then_some(Highlights { rows })
    }

    /// Returns the number of splits computed so far.
    pub fn splits(&self) -> u64 {
        self.rows.iter().filter_map(|(_, shader)| shader.as_ref()).map(Shader::splits).sum()
    }

    /// Computes the splits of the wanted lines. `wanted` has one bit per line of all scanlines.
    pub fn words(&mut self, wanted: &[u32]) -> SplitWords {
        let mut first = 0;
        let rows: Vec<_> = self
            .rows
            .iter_mut()
            .map(|(lines, shader)| {
                first += lines.len();
                (first - lines.len()..first, shader)
            })
            .collect();
        let of_row = |(lines, shader): (Range<usize>, &mut Option<Shader<'_>>)| -> Vec<Vec<LineSplit>> {
            let first = lines.start;
            let is_wanted = |line: usize| wanted.get(line / 32).is_some_and(|word| word >> (line % 32) & 1 == 1);
            let highlight = |line: usize| shader.as_ref().filter(|_| is_wanted(line))?.highlight(line - first);
            let split = |&(place, light): &(f64, glam::DVec3)| LineSplit {
                light: light.min(glam::DVec3::splat(MAX_RADIANCE)).as_vec3().to_array(),
                place: place as f32,
            };
            lines
                .map(|line| highlight(line).map_or(&[][..], |found| found.places()).iter().map(split).collect())
                .collect()
        };
        let splits: Vec<Vec<Vec<LineSplit>>> = rows.into_par_iter().map(of_row).collect();
        let mut words = SplitWords { starts: vec![0], ..SplitWords::default() };
        for splits in splits.iter().flatten() {
            words.splits.extend(words_of(splits));
            words.starts.push((words.splits.len() / LineSplit::WORDS) as u32);
        }
        words
    }
}
