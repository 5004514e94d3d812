//! A slice: one scanline of all output views (Epipolar 3.3.2).
//!
//! Takes the lines of a scanline, in runs, and finds the line that each pixel of each view shows. The lines of a run cover one
//! pixel each, starting at the pixel that contains the column of the first line. If the next run shows the same surface and has
//! moved apart, the span of pixels between both is covered, too. Of all lines that cover a pixel, the one with the smallest key
//! wins: a line of the first layer in the view of its own source, otherwise the nearest line, with a bias by the distance from
//! its source; ties go to the first run. The lines of a run cover different pixels, so the order of runs is the order of lines.
//!
//! Listing 3.7 of the thesis only replaces the value of pixels that already have one, and never fills an empty pixel. In listing
//! 3.9 the right end of a quad moves in the opposite direction to its left end (appendix B.4 has the correct sign), and the loop
//! over splits runs one iteration too far.

use std::ops::Range;

use super::coalesce::{LineRuns, Run};
use super::counters::Counters;
use super::lines::{COLUMN_BITS, LineSpace, moved};

/// Key of a pixel that no line covers.
const NOTHING: u64 = u64::MAX;
/// Distance between neighbouring lines, in 1/256 pixels, from which weights are computed in whole pixels, so that 255 times the
/// distance fits 32 bits.
const FAR_APART: i32 = 1 << 22;

/// The line that a pixel shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Winner {
    /// Index of the line.
    pub line: u32,
    /// Neighbouring line to blend with, and its weight in 1/255; the weight is 0 without blending.
    pub beside: u32,
    pub weight: u8,
}

/// Drawing of the lines of one scanline into one view at a time.
pub struct Slice<'a> {
    space: &'a LineSpace,
    runs: &'a [Run],
    /// Depth of each line.
    depths: Vec<u32>,
    width: u32,
    /// Column of the first line of each run, in the view.
    columns: Vec<i32>,
    pixels: PixelKeys,
}

/// State of the pixels of a view while runs are drawn, by column.
struct PixelKeys {
    keys: Vec<u64>,
    /// For each pixel, the depth that lines must lie behind; empty if all lines are drawn.
    nearest: Vec<u32>,
}

impl<'a> Slice<'a> {
    pub fn new(space: &'a LineSpace, LineRuns { lines, runs }: &'a LineRuns, width: u32) -> Slice<'a> {
        Slice {
            space,
            runs,
            depths: lines.iter().map(|line| line.depth).collect(),
            width,
            columns: vec![0; runs.len()],
            pixels: PixelKeys { keys: vec![NOTHING; width as usize], nearest: Vec::new() },
        }
    }

    /// Returns the winners in a view, by column; `None` in holes.
    pub fn view(&mut self, view: usize, counters: &mut Counters) -> impl Iterator<Item = Option<Winner>> + '_ {
        self.draw(view, counters);
        (0..self.width).map(|column| self.winner(column))
    }

    /// Returns the winners among the lines that lie behind `depths`, by column. Depths are bits of planar distances, as those of
    /// lines.
    pub fn behind(
        &mut self,
        view: usize,
        depths: &[u32],
        counters: &mut Counters,
    ) -> impl Iterator<Item = Option<Winner>> + '_ {
        self.pixels.nearest.clear();
        self.pixels.nearest.extend_from_slice(depths);
        self.draw(view, counters);
        self.pixels.nearest.clear();
        (0..self.width).map(|column| self.winner(column))
    }

    /// Draws all runs into a view.
    pub fn draw(&mut self, view: usize, counters: &mut Counters) {
        self.pixels.keys.fill(NOTHING);
        let mut at = 0;
        while let Some(first) = self.runs.get(at) {
            let source = first.source;
            let end = at + self.runs[at..].partition_point(|run| run.source == source);
            self.draw_source(at..end, self.space.place(usize::from(source), view), counters);
            at = end;
        }
    }

    /// Draws the runs of one source.
    fn draw_source(&mut self, range: Range<usize>, place: i32, counters: &mut Counters) {
        let bias = self.space.bias_at(place);
        let width = self.width as i32;
        for (column, run) in self.columns[range.clone()].iter_mut().zip(&self.runs[range.clone()]) {
            *column = run.column + moved(run.disparity, place);
        }
        let clipped = |from: i32, to: i32| {
            let from = from.clamp(0, width);
            from as usize..to.clamp(from, width) as usize
        };
        for at in range {
            let run = &self.runs[at];
            let depths = &self.depths[run.first as usize..];
            let first = self.columns[at] >> COLUMN_BITS;
            let end = first + run.length as i32;
            // The source's own view shows the first layer unchanged, whatever is in front of it between pixel centres.
            let is_own = run.is_first && place == 0;
            let word = (at as u64) << 1;
            let columns = clipped(first, end);
            if !columns.is_empty() {
                let depths = &depths[(columns.start as i32 - first) as usize..];
                let key = |depth: u32| u64::from(if is_own { 0 } else { depth.saturating_add(bias) }) << 32 | word;
                self.pixels.put(columns, depths.iter().copied(), key, counters);
            }
            if run.joins_next {
                let next = self.columns[at + 1] >> COLUMN_BITS;
                let farther = depths[run.length as usize - 1].max(depths[run.length as usize]);
                let key = u64::from(farther.saturating_add(bias)) << 32 | word | 1;
                self.pixels.put(clipped(end, next), std::iter::repeat(farther), |_| key, counters);
            }
        }
    }

    fn winner(&self, column: u32) -> Option<Winner> {
        let key = self.pixels.keys[column as usize];
        if key == NOTHING {
            return None;
        }
        let (at, is_span) = (((key as u32) >> 1) as usize, key & 1 == 1);
        let (run, first) = (&self.runs[at], self.columns[at]);
        // The line of the run, and its column. In a span between two runs it is the last line of the first run.
        let last = run.length as i32 - 1;
        let of_run = if is_span { last } else { column as i32 - (first >> COLUMN_BITS) };
        let (line, line_column) = (run.first + of_run as u32, first + (of_run << COLUMN_BITS));
        let middle = ((column as i32) << COLUMN_BITS) + (1 << (COLUMN_BITS - 1));
        let right_of_line = middle - line_column;
        // A line to the left of the pixel's centre is blended with the next line, a line to the right of it with the line before.
        let beside = match right_of_line {
            0 => None,
            1.. if of_run < last => Some((line + 1, 1 << COLUMN_BITS)),
            1.. => run.joins_next.then(|| (line + 1, self.columns[at + 1] - line_column)),
            _ if of_run > 0 => Some((line - 1, -(1 << COLUMN_BITS))),
            _ => at.checked_sub(1).filter(|&before| self.runs[before].joins_next).map(|before| {
                let last = self.runs[before].length as i32 - 1;
                (line - 1, self.columns[before] + (last << COLUMN_BITS) - line_column)
            }),
        };
        // Lines that coincide, or that have changed places, are not blended.
        let parted = beside.filter(|(_, parted)| parted.signum() == right_of_line.signum());
        let Some((beside, parted)) = parted else { return Some(Winner { line, beside: line, weight: 0 }) };
        let shift = if parted.abs() >= FAR_APART { COLUMN_BITS } else { 0 };
        let [part, whole] = [right_of_line, parted].map(|columns| columns.abs() >> shift);
        Some(Winner { line, beside, weight: ((255 * part + whole / 2) / whole).min(255) as u8 })
    }
}

impl PixelKeys {
    /// Covers a range of columns. `depths` has one depth per column, from which `key` computes the key.
    fn put(
        &mut self,
        columns: Range<usize>,
        depths: impl Iterator<Item = u32>,
        key: impl Fn(u32) -> u64,
        counters: &mut Counters,
    ) {
        counters.fragments += columns.len() as u64;
        let held = self.keys[columns.clone()].iter_mut();
        let mut won = 0;
        let mut put = |held: &mut u64, key: u64| {
            won += u64::from(key < *held);
            *held = key.min(*held);
        };
        match self.nearest.get(columns) {
            None => held.zip(depths).for_each(|(held, depth)| put(held, key(depth))),
            Some(nearest) => held.zip(depths.zip(nearest)).for_each(|(held, (depth, nearest))| {
                put(held, if depth > *nearest { key(depth) } else { NOTHING });
            }),
        }
        counters.depth_tests_won += won;
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use half::f16;

    use super::*;
    use crate::coalesce::Coalescing;
    use crate::lines::Line;
    use crate::source::{Light, SourcePixel, SourceRow, SourceView};
    use crate::views::{OutputViews, Spread};
    use codec::math::{Camera, Lens};

    const WIDTH: u32 = 64;

    fn views(count: u32, baseline_m: f64, focus_m: f64) -> OutputViews {
        let camera = Camera::look_at(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, Lens::new(60.0)).unwrap();
        OutputViews::new(
            camera.with_aspect(f64::from(WIDTH) / 48.0),
            [WIDTH, 48],
            count,
            Spread::Baseline(baseline_m),
            focus_m,
        )
        .unwrap()
    }

    fn pixel(column: i32, depth_m: f32, layer: u8) -> SourcePixel {
        let light = [f16::from_f32(depth_m); 3];
        SourcePixel { column, depth_m, layer, light: Light::Steady, steady: light, own: light }
    }

    fn source(offset_m: f64, pixels: Vec<SourcePixel>) -> SourceView {
        SourceView { offset_m, rows: vec![SourceRow { pixels, gloss: Vec::new() }], layers: 1 }
    }

    /// Returns the winners of each view.
    fn winners(views: &OutputViews, sources: &[SourceView]) -> (Vec<Line>, Vec<Vec<Option<Winner>>>, Counters) {
        let (runs, all, counters) = winners_of_runs(views, sources, Coalescing::Off);
        (runs.lines, all, counters)
    }

    fn winners_of_runs(
        views: &OutputViews,
        sources: &[SourceView],
        coalescing: Coalescing,
    ) -> (LineRuns, Vec<Vec<Option<Winner>>>, Counters) {
        let offsets_m: Vec<f64> = sources.iter().map(|source| source.offset_m).collect();
        let space = LineSpace::new(views, &offsets_m);
        let runs = LineRuns::new(space.lines(sources, 0), coalescing);
        let mut counters = Counters::default();
        let mut slice = Slice::new(&space, &runs, WIDTH);
        let all = (0..views.offsets_m.len()).map(|view| slice.view(view, &mut counters).collect()).collect();
        (runs, all, counters)
    }

    #[test]
    fn runs_of_equal_disparities_show_the_same_as_their_lines() {
        // Walls at several distances with a slanted wall between them, and a wall behind; two sources.
        let depth_m = |column: i32| match column.rem_euclid(40) {
            at @ 0..13 => 1.0 + at as f32 * 0.02,
            13..29 => 3.0,
            _ => 0.8,
        };
        let front = (-60..120).map(|column| pixel(column, depth_m(column), 0));
        let behind = (-60..120).filter(|column| column % 7 != 0).map(|column| pixel(column, 5.0, 1));
        let pixels: Vec<SourcePixel> = front.chain(behind).collect();
        for focus_m in [f64::INFINITY, 1.5] {
            let views = views(9, 0.4, focus_m);
            let sources = [source(-0.2, pixels.clone()), source(0.13, pixels.clone())];
            let (alone, expected, plain) = winners_of_runs(&views, &sources, Coalescing::Off);
            let (runs, found, counted) = winners_of_runs(&views, &sources, Coalescing::Disparity(0.0));
            assert!(2 * runs.runs.len() < alone.runs.len(), "{} {}", runs.runs.len(), alone.runs.len());
            assert_eq!((found, counted.fragments), (expected, plain.fragments));
        }
    }

    #[test]
    fn coalesced_columns_are_wrong_by_half_of_the_threshold_at_most() {
        let views = views(9, 0.4, f64::INFINITY);
        let slanted = |column: i32| pixel(column, (1.0 / (1.0 - f64::from(column) * 0.002)) as f32, 0);
        let sources = [source(-0.2, (0..WIDTH as i32).map(slanted).collect())];
        let space = LineSpace::new(&views, &[-0.2]);
        for pixels in [0.25, 1.0] {
            let (LineRuns { lines, runs }, ..) = winners_of_runs(&views, &sources, Coalescing::Disparity(pixels));
            assert!(runs.len() < lines.len() / 2);
            for (run, view) in runs.iter().flat_map(|run| (0..9).map(move |view| (run, view))) {
                for (at, line) in lines[run.first as usize..][..run.length as usize].iter().enumerate() {
                    let place = space.place(0, view);
                    let drawn = run.column + ((at as i32) << COLUMN_BITS) + moved(run.disparity, place);
                    let error = f64::from(drawn - line.column - moved(line.disparity, place)).abs() / 256.0;
                    assert!(error <= 0.5 * pixels + 1.0 / 128.0, "{pixels} {view}: {error}");
                }
            }
        }
    }

    #[test]
    fn a_plane_covers_every_pixel_of_every_view_once() {
        for (count, focus_m) in [(1, f64::INFINITY), (2, f64::INFINITY), (33, 2.0), (400, 7.0)] {
            for depth_m in [0.3f32, 1.0, 1.7, 55.0, 1e6, f32::INFINITY] {
                let views = views(count, 0.2, focus_m);
                // The plane is wide enough for all views.
                let plane = (-600..600).map(|column| pixel(column, depth_m, 0)).collect();
                let (lines, all, counters) = winners(&views, &[source(0.0, plane)]);
                for (view, winners) in all.iter().enumerate() {
                    for (column, winner) in winners.iter().enumerate() {
                        let line = &lines[winner.unwrap().line as usize];
                        let moved = views.offsets_m[view] * views.columns_per_metre(f64::from(depth_m));
                        let expected = column as f64 + 0.5 - moved;
                        let from = f64::from(line.column) / 256.0;
                        assert!(
                            (from - expected).abs() <= 0.5 + 1.0 / 256.0,
                            "{depth_m} {view} {column}: {from} {expected}"
                        );
                    }
                }
                // No pixel is covered twice.
                assert_eq!(counters.fragments, u64::from(WIDTH * count), "{depth_m} {count}");
            }
        }
    }

    #[test]
    fn columns_are_within_a_256th_of_a_pixel_of_exact_ones() {
        let views = views(4096, 1.5, f64::INFINITY);
        let space = LineSpace::new(&views, &[-0.4]);
        for depth_m in [0.35f32, 0.9, 3.3, 171.0] {
            let lines = space.lines(&[source(-0.4, vec![pixel(20, depth_m, 0)])], 0);
            for (view, offset_m) in views.offsets_m.iter().enumerate() {
                let found = f64::from(lines[0].column + moved(lines[0].disparity, space.place(0, view))) / 256.0;
                let exact = 20.5 + (offset_m + 0.4) * views.columns_per_metre(f64::from(depth_m));
                assert!((found - exact).abs() < 1.0 / 256.0, "{depth_m} {view}: {found} {exact}");
            }
        }
    }

    #[test]
    fn a_fence_hides_its_own_columns_and_shows_the_wall_between() {
        // Posts of two pixels at 1 m in front of a wall at 4 m, as the first view sees them, with the wall behind as a second
        // layer.
        let views = views(9, 0.4, f64::INFINITY);
        let is_post = |column: i32| column.rem_euclid(8) < 2;
        let mut pixels: Vec<SourcePixel> =
            (0..WIDTH as i32).map(|column| pixel(column, if is_post(column) { 1.0 } else { 4.0 }, 0)).collect();
        pixels.extend((0..WIDTH as i32).filter(|&column| is_post(column)).map(|column| pixel(column, 4.0, 1)));
        let (lines, all, _) = winners(&views, &[source(-0.2, pixels.clone())]);
        let depth = |winner: &Winner| f32::from_bits(lines[winner.line as usize].depth);
        for (view, winners) in all.iter().enumerate() {
            let moved = (0.2 + views.offsets_m[view]) * views.columns_per_metre(1.0);
            // Posts that leave the image at the left are not followed by others at the right.
            for (column, winner) in winners.iter().enumerate().take(WIDTH as usize - 28) {
                let at = (column as f64 + 0.5 - moved).floor() as i32;
                let expected = if is_post(at) { 1.0 } else { 4.0 };
                assert_eq!(winner.as_ref().map(depth), Some(expected), "view {view}, column {column}");
            }
        }
        // Without the second layer, the wall behind the posts is missing.
        let first: Vec<SourcePixel> = pixels.into_iter().filter(|pixel| pixel.layer == 0).collect();
        let holes = winners(&views, &[source(-0.2, first)]).1[8][..32].iter().filter(|winner| winner.is_none()).count();
        assert!(holes >= 4, "{holes}");
    }

    #[test]
    fn sources_show_themselves_in_their_own_view_and_nearer_ones_win_elsewhere() {
        let views = views(5, 0.2, f64::INFINITY);
        let plane = |depth_m: f32| (-40..100).map(|column| pixel(column, depth_m, 0)).collect::<Vec<_>>();
        // The second source's plane is slightly nearer.
        let sources = [source(-0.1, plane(2.0)), source(0.1, plane(1.999))];
        let (lines, all, _) = winners(&views, &sources);
        let source_of = |view: usize| {
            let first = lines[all[view][20].unwrap().line as usize].source;
            assert!(all[view].iter().all(|winner| lines[winner.unwrap().line as usize].source == first));
            first
        };
        assert_eq!([0, 1, 3, 4].map(source_of), [0, 0, 1, 1]);
        // In the view of its own source, a line is not blended with others.
        assert!(all[0].iter().flatten().all(|winner| winner.weight == 0));
    }

    #[test]
    fn stretched_surfaces_have_no_pinholes_and_edges_grow_no_skirts() {
        // A slanted plane, which the last view sees three times as wide as the first.
        let views = views(3, 0.5, f64::INFINITY);
        let slanted = |column: i32| (1.0 / (2.0 - f64::from(column) * 0.06)) as f32;
        let pixels: Vec<SourcePixel> = (0..30).map(|column| pixel(column, slanted(column), 0)).collect();
        let (_, all, _) = winners(&views, &[source(-0.25, pixels)]);
        let covered: Vec<usize> = (0..WIDTH as usize).filter(|&column| all[2][column].is_some()).collect();
        let (first, last) = (covered[0], covered[covered.len() - 1]);
        assert_eq!(covered, (first..=last).collect::<Vec<_>>());
        // Two surfaces move apart, and the gap between them stays empty.
        let step = (0..40).map(|column| pixel(column, if column < 30 { 1.0 } else { 4.0 }, 0)).collect();
        let (_, all, _) = winners(&views, &[source(-0.25, step)]);
        let holes = all[2][..30].iter().filter(|winner| winner.is_none()).count();
        let parted = 0.5 * (views.columns_per_metre(4.0) - views.columns_per_metre(1.0));
        assert!(holes.abs_diff(parted as usize) <= 1, "{holes} {parted}");
    }

    #[test]
    fn lines_far_outside_stay_there_and_are_blended_across() {
        // The largest position, where the product does not fit 32 bits.
        assert_eq!([moved(1 << 30, 1 << 30), moved(1 << 30, -1 << 30)], [1 << 29, -1 << 29]);
        // A steep plane around the image, whose pixels move apart by more than 100,000 columns.
        let views = views(3, 4000.0, 1.0);
        let steep = |column: i32| pixel(column, (1.0 / (2.5 - f64::from(column))) as f32, 0);
        let (_, all, _) = winners(&views, &[source(-2000.0, (0..3).map(steep).collect())]);
        for winner in all[2].iter() {
            let Winner { line, beside, weight } = winner.unwrap();
            assert!((line, beside) == (1, 2) && weight.abs_diff(128) <= 1, "{winner:?}");
        }
    }
}
