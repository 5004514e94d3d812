//! Highlights on a device (Epipolar 3.5): the CPU places the splits of the lines that pixels show, in double precision, and a kernel
//! interpolates between them.

use std::ops::Range;

use rayon::prelude::*;

use crate::epipolar::coalesce::LineRuns;
use crate::epipolar::interpolate::{Interpolator, Shader};
use crate::epipolar::lines::Line;
use crate::gpu::layout::{LineSplit, words_of};

/// Radiance of a split at most, so that floats stay finite: far more than half floats hold.
const MAX_RADIANCE: f64 = 1e30;

/// The splits of lines, for a kernel.
#[derive(Debug, Default)]
pub struct SplitWords {
    /// The first split of each line, and the end of the last.
    pub starts: Vec<u32>,
    /// [`LineSplit`]s.
    pub splits: Vec<u32>,
}

/// Highlights of some scanlines.
#[derive(Debug)]
pub struct Highlights<'a> {
    /// `None` for a scanline without any.
    rows: Vec<(&'a [Line], Option<Shader<'a>>)>,
}

impl<'a> Highlights<'a> {
    /// Of the lines of scanlines from one on; `None` where no line has a highlight.
    pub fn new(of: &'a Interpolator<'a>, first_row: usize, lines: &[&'a LineRuns]) -> Option<Highlights<'a>> {
        let shader = |row: usize, lines: &'a [Line]| of.has_gloss(row).then(|| Shader::new(of, lines, row));
        let rows = (first_row..).zip(lines).map(|(row, of_row)| (&of_row.lines[..], shader(row, &of_row.lines)));
        let rows: Vec<_> = rows.collect();
        rows.iter().any(|(_, shader)| shader.is_some()).then_some(Highlights { rows })
    }

    /// Places where highlights were computed.
    pub fn splits(&self) -> u64 {
        self.rows.iter().filter_map(|(_, shader)| shader.as_ref()).map(Shader::splits).sum()
    }

    /// The splits of the lines that are wanted, by a bit for each line of all scanlines.
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
