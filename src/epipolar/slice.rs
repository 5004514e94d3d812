//! A slice: one scanline of all output views (Epipolar 3.3.2).
//!
//! Enters: the lines of a scanline. Leaves: the line that every pixel of every view shows. A line covers the pixel that its column lies
//! in; where the next line shows the same surface and has parted from it, both cover the pixels between them. Of all that cover a pixel
//! the one with the least key wins: a line of the first layer in the view of its own source, else the nearest, with a bias by the
//! distance from the source; then the first in the order of lines.

use super::counters::Counters;
use super::lines::{COLUMN_BITS, Line, LineSpace, moved};

/// Key of a pixel that nothing covers.
const NOTHING: u64 = u64::MAX;

/// What a pixel shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Winner {
    /// Index of the line.
    pub line: u32,
    /// The line beside it that it is blended with, and the weight of that in 255ths; 0 without one.
    pub beside: u32,
    pub weight: u8,
}

/// The winners of one scanline of a view.
pub struct Slice<'a> {
    space: &'a LineSpace,
    lines: &'a [Line],
    width: u32,
    keys: Vec<u64>,
    columns: Vec<i32>,
}

impl<'a> Slice<'a> {
    pub fn new(space: &'a LineSpace, lines: &'a [Line], width: u32) -> Slice<'a> {
        Slice { space, lines, width, keys: vec![NOTHING; width as usize], columns: vec![0; lines.len()] }
    }

    /// The winners in a view, by column; `None` in holes.
    pub fn view(&mut self, view: usize, counters: &mut Counters) -> impl Iterator<Item = Option<Winner>> + '_ {
        self.draw(view, counters);
        (0..self.width).map(|column| self.winner(column))
    }

    /// Draws all lines.
    pub fn draw(&mut self, view: usize, counters: &mut Counters) {
        self.keys.fill(NOTHING);
        let mut at = 0;
        while let Some(first) = self.lines.get(at) {
            let source = first.source;
            let end = at + self.lines[at..].partition_point(|line| line.source == source);
            self.draw_source(at..end, self.space.place(usize::from(source), view), counters);
            at = end;
        }
    }

    /// Draws the lines of one source.
    fn draw_source(&mut self, lines: std::ops::Range<usize>, place: i32, counters: &mut Counters) {
        let bias = self.space.bias_at(place);
        let width = self.width as i32;
        for at in lines.clone() {
            let line = &self.lines[at];
            self.columns[at] = line.column + moved(line.disparity, place);
        }
        let mut cover = |from: i32, to: i32, key: u64| {
            for column in from.max(0)..to.min(width) {
                let held = &mut self.keys[column as usize];
                counters.fragments += 1;
                if key < *held {
                    *held = key;
                    counters.depth_tests_won += 1;
                }
            }
        };
        for at in lines {
            let line = &self.lines[at];
            let column = self.columns[at] >> COLUMN_BITS;
            // Its own view shows the first layer as it was, whatever lies before it between the middles of pixels.
            let depth = if line.is_first && place == 0 { 0 } else { line.depth.saturating_add(bias) };
            cover(column, column + 1, u64::from(depth) << 32 | (at as u64) << 1);
            if line.joins_next {
                let next = self.columns[at + 1] >> COLUMN_BITS;
                let farther = line.depth.max(self.lines[at + 1].depth).saturating_add(bias);
                cover(column + 1, next, u64::from(farther) << 32 | (at as u64) << 1 | 1);
            }
        }
    }

    fn winner(&self, column: u32) -> Option<Winner> {
        let key = self.keys[column as usize];
        if key == NOTHING {
            return None;
        }
        let (at, is_span) = (((key as u32) >> 1) as usize, key & 1 == 1);
        let middle = ((column as i32) << COLUMN_BITS) + (1 << (COLUMN_BITS - 1));
        let right_of_line = middle - self.columns[at];
        // A line before the middle of the pixel is blended with the one after it, and the other way round.
        let beside = match right_of_line {
            0 => None,
            1.. => (self.lines[at].joins_next || is_span).then_some(at + 1),
            _ => at.checked_sub(1).filter(|&before| self.lines[before].joins_next),
        };
        let parted = beside.map(|beside| (self.columns[beside] - self.columns[at], beside));
        // Lines that have come closer, or changed places, are not blended.
        let weight = parted.filter(|(parted, _)| parted.signum() == right_of_line.signum()).map(|(parted, beside)| {
            let weight = (255 * right_of_line.abs() + parted.abs() / 2) / parted.abs();
            (beside as u32, weight.min(255) as u8)
        });
        let (beside, weight) = weight.unwrap_or((at as u32, 0));
        Some(Winner { line: at as u32, beside, weight })
    }
}
