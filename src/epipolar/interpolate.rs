//! Interpolation of whole output views from the lines of source views (Epipolar 3.3.2).

use std::cell::OnceCell;
use std::ops::Range;

use glam::DVec3;
use half::f16;
use rayon::prelude::*;

use super::coalesce::{Coalescing, LineRuns};
use super::counters::Counters;
use super::highlights::{EyeLine, Highlight};
use super::lines::{Line, LineSpace};
use super::slice::{Slice, Winner};
use super::source::{Light, SourcePixel, SourceRow, SourceView};
use super::stages::{Lap, Stages};
use super::views::OutputViews;
use codec::color::blend::{HalfKey, Sample};
use codec::error::Result;
use codec::image::Plane;
use codec::monitor::Monitor;
use scene::shading::Gloss;

/// Coverage of a pixel of an output view.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Coverage {
    Covered,
    /// No line covers the pixel.
    Hole,
    /// The pixel shows a mirror or glass.
    Optical,
}

/// Output view before hole filling.
#[derive(Debug, Clone)]
pub struct InterpolatedView {
    /// Linear RGB; 0 in pixels that are not covered.
    pub color: Plane<[f16; 3]>,
    pub coverage: Plane<Coverage>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InterpolateSettings {
    pub coalesce: Coalescing,
    /// Maximum number of splits of a line, not counting its ends.
    pub splits: usize,
}

impl Default for InterpolateSettings {
    fn default() -> Self {
        InterpolateSettings { coalesce: Coalescing::Off, splits: super::highlights::DEFAULT_SPLITS }
    }
}

/// Interpolator of views between sources, which are sorted by position.
#[derive(Debug)]
pub struct Interpolator<'a> {
    pub views: &'a OutputViews,
    pub sources: &'a [SourceView],
    /// Scanlines of the sources to interpolate.
    pub rows: Range<usize>,
    pub space: LineSpace,
    settings: InterpolateSettings,
    eyes: EyeLine,
}

/// Pixels of a scanline of one view.
type ViewRow = Vec<([f16; 3], Coverage)>;

impl<'a> Interpolator<'a> {
    pub fn new(views: &'a OutputViews, sources: &'a [SourceView], settings: InterpolateSettings) -> Interpolator<'a> {
        let offsets_m: Vec<f64> = sources.iter().map(|source| source.offset_m).collect();
        let space = LineSpace::new(views, &offsets_m);
        let rows = 0..views.size[1] as usize;
        Interpolator { views, sources, rows, settings, space, eyes: EyeLine::new(views) }
    }

    /// Restricts the interpolator to the given scanlines of the sources. Views are then strips of this height.
    #[must_use]
    pub fn of_rows(self, rows: Range<usize>) -> Interpolator<'a> {
        Interpolator { rows, ..self }
    }

    /// Interpolates the views in `range`.
    pub fn views(&self, range: Range<usize>, monitor: &dyn Monitor) -> Result<(Vec<InterpolatedView>, Counters)> {
        let [width, height] = [self.views.size[0], self.rows.len() as u32];
        let rows: Vec<(Vec<ViewRow>, Counters)> = self
            .rows
            .clone()
            .into_par_iter()
            .map(|row| {
                monitor.check()?;
                let of_row = self.row(row, range.clone());
                monitor.advance(1);
                Ok(of_row)
            })
            .collect::<Result<_>>()?;
        let mut counters = Counters::default();
        rows.iter().for_each(|(_, of_row)| counters.add(of_row));
        let view = |at: usize| {
            let (color, coverage) = rows.iter().flat_map(|(views, _)| views[at].iter().copied()).unzip();
            let color = Plane::new(width, height, color)?;
            Ok(InterpolatedView { color, coverage: Plane::new(width, height, coverage)? })
        };
        Ok(((0..range.len()).into_par_iter().map(view).collect::<Result<_>>()?, counters))
    }

    /// Returns the lines of a scanline, and counters of them.
    pub fn lines(&self, row: usize) -> (LineRuns, Counters) {
        let lines = LineRuns::new(self.space.lines(self.sources, row), self.settings.coalesce);
        let drawn = lines.runs.len() as u64;
        let coalesced_pixels = lines.lines.len() as u64 - drawn;
        (lines, Counters { lines: drawn, coalesced_pixels, ..Counters::default() })
    }

    /// Returns the source pixel of a line.
    pub fn source_pixel(&self, row: usize, line: &Line) -> &SourcePixel {
        &self.sources[usize::from(line.source)].rows[row].pixels[line.pixel as usize]
    }

    /// Returns the maximum number of splits of a line, including its ends.
    pub fn max_splits(&self) -> usize {
        self.settings.splits.saturating_add(2)
    }

    /// Returns the position of a view on the line of eyes, from 0 for the first to 1 for the last.
    pub fn eye_place(&self, view: usize) -> f64 {
        let offsets_m = &self.views.offsets_m;
        let baseline_m = self.views.baseline_m();
        if baseline_m > 0.0 { (offsets_m[view] - offsets_m[0]) / baseline_m } else { 0.0 }
    }

    /// Returns true if a scanline has lines with highlights.
    pub fn has_gloss(&self, row: usize) -> bool {
        self.sources.iter().any(|source| !source.rows[row].gloss.is_empty())
    }

    fn row(&self, row: usize, range: Range<usize>) -> (Vec<ViewRow>, Counters) {
        let mut lap = Lap::begin();
        let (lines, mut counters) = self.lines(row);
        counters.threads.filter += lap.time();
        let shader = Shader::new(self, &lines.lines, row);
        let mut slice = Slice::new(&self.space, &lines, self.views.size[0]);
        let mut rows = Vec::with_capacity(range.len());
        for view in range {
            let winners: Vec<Option<Winner>> = slice.view(view, &mut counters).collect();
            counters.threads.interpolate += lap.time();
            for winner in winners.iter().flatten() {
                let layer = shader.source_pixel(&lines.lines[winner.line as usize]).layer;
                counters.pixels_by_layer[usize::from(layer)] += 1;
            }
            let pixels: ViewRow = winners.into_iter().map(|winner| shader.pixel(winner, view)).collect();
            counters.hole_pixels += pixels.iter().filter(|pixel| pixel.1 == Coverage::Hole).count() as u64;
            rows.push(pixels);
            counters.threads.light += lap.time();
        }
        counters.splits = shader.splits();
        (rows, counters)
    }
}

impl Interpolator<'_> {
    /// Returns the views in `range` as source views, with the surfaces behind their pixels (Epipolar 7.2), and the thread time
    /// spent. Uncovered positions have no pixel.
    pub fn layered(
        &self,
        range: Range<usize>,
        layers: usize,
        monitor: &dyn Monitor,
    ) -> Result<(Vec<SourceView>, Stages)> {
        let rows: Vec<(Vec<SourceRow>, Stages)> = self
            .rows
            .clone()
            .into_par_iter()
            .map(|row| {
                monitor.check()?;
                Ok(self.layered_row(row, range.clone(), layers))
            })
            .collect::<Result<_>>()?;
        let mut views = vec![Vec::with_capacity(rows.len()); range.len()];
        let mut threads = Stages::default();
        for (row, of_row) in rows {
            views.iter_mut().zip(row).for_each(|(view, row)| view.push(row));
            threads = threads + of_row;
        }
        Ok((views.into_iter().map(|rows| SourceView::of_rows(0.0, rows)).collect(), threads))
    }

    fn layered_row(&self, row: usize, range: Range<usize>, layers: usize) -> (Vec<SourceRow>, Stages) {
        let mut lap = Lap::begin();
        let (lines, mut counters) = self.lines(row);
        counters.threads.filter += lap.time();
        let shader = Shader::new(self, &lines.lines, row);
        let mut slice = Slice::new(&self.space, &lines, self.views.size[0]);
        let mut rows = Vec::with_capacity(range.len());
        for view in range {
            let mut out = SourceRow::default();
            // All lines are behind a depth of 0.
            let mut nearest = vec![0; self.views.size[0] as usize];
            for layer in 0..layers {
                let winners: Vec<Option<Winner>> = slice.behind(view, &nearest, &mut counters).collect();
                counters.threads.interpolate += lap.time();
                let before = out.pixels.len();
                for ((column, winner), nearest) in (0..).zip(winners).zip(&mut nearest) {
                    let Some(winner) = winner else {
                        *nearest = u32::MAX;
                        continue;
                    };
                    let line = &lines.lines[winner.line as usize];
                    *nearest = self.space.behind(line.depth);
                    out.pixels.push(shader.source_of(winner, (view, layer, column), &mut out.gloss));
                }
                counters.threads.light += lap.time();
                if out.pixels.len() == before {
                    break;
                }
            }
            rows.push(out.fitted());
        }
        (rows, counters.threads)
    }
}

/// Returns the percentage of pixels that no line covers in a view between two sources.
pub fn hole_percent(views: &OutputViews, sources: &[&SourceView], offset_m: f64) -> f64 {
    let offsets_m: Vec<f64> = sources.iter().map(|source| source.offset_m).collect();
    let between = views.at(vec![offsets_m[0], offset_m, offsets_m[offsets_m.len() - 1]]);
    let space = LineSpace::new(&between, &offsets_m);
    let holes = |row: usize| {
        let lines = LineRuns::new(space.lines(sources.iter().copied(), row), Coalescing::Off);
        let mut slice = Slice::new(&space, &lines, views.size[0]);
        slice.view(1, &mut Counters::default()).filter(Option::is_none).count() as u64
    };
    let holes: u64 = (0..views.size[1] as usize).into_par_iter().map(holes).sum();
    100.0 * holes as f64 / views.size.map(f64::from).iter().product::<f64>()
}

/// Shader of the lines of a scanline.
#[derive(Debug)]
pub struct Shader<'a> {
    of: &'a Interpolator<'a>,
    lines: &'a [Line],
    row: usize,
    /// For each line, its highlight, computed when the line first wins a pixel. Empty in a scanline without gloss.
    highlights: Vec<OnceCell<Highlight>>,
}

impl<'a> Shader<'a> {
    pub fn new(of: &'a Interpolator<'a>, lines: &'a [Line], row: usize) -> Shader<'a> {
        let highlights = vec![OnceCell::new(); if of.has_gloss(row) { lines.len() } else { 0 }];
        Shader { of, lines, row, highlights }
    }

    fn source_pixel(&self, line: &Line) -> &SourcePixel {
        self.of.source_pixel(self.row, line)
    }

    /// Returns the number of splits at which highlights were computed.
    pub fn splits(&self) -> u64 {
        self.highlights.iter().filter_map(OnceCell::get).map(|highlight| highlight.splits() as u64).sum()
    }

    /// Returns the linear RGB and the coverage of a pixel of a view.
    pub fn pixel(&self, winner: Option<Winner>, view: usize) -> ([f16; 3], Coverage) {
        let Some(Winner { line: at, beside, weight }) = winner else { return ([f16::ZERO; 3], Coverage::Hole) };
        let line = &self.lines[at as usize];
        let pixel = self.source_pixel(line);
        if line.is_first && self.of.space.place(usize::from(line.source), view) == 0 {
            return (pixel.own, Coverage::Covered);
        }
        if pixel.light == Light::Traced {
            return ([f16::ZERO; 3], Coverage::Optical);
        }
        let steady = self.steady(Winner { line: at, beside, weight });
        let highlight = |at: u32| Some(self.highlight(at as usize)?.at(self.of.eye_place(view)));
        match (highlight(at), highlight(beside)) {
            (None, None) => (steady, Coverage::Covered),
            (a, b) => {
                let light = a.unwrap_or(DVec3::ZERO).lerp(b.unwrap_or(DVec3::ZERO), f64::from(weight) / 255.0);
                let light = DVec3::from_array(steady.map(f16::to_f64)) + light;
                (scene::capture::halves(light), Coverage::Covered)
            }
        }
    }

    /// Returns the radiance without highlights. A mirror or glass beside the line is not blended in.
    fn steady(&self, Winner { line, beside, weight }: Winner) -> [f16; 3] {
        let [pixel, other] = [line, beside].map(|at| self.source_pixel(&self.lines[at as usize]));
        match other.light {
            _ if weight == 0 => pixel.steady,
            Light::Traced => pixel.steady,
            _ => blended(pixel.steady, other.steady, weight),
        }
    }

    /// Converts a pixel of a view, given its view, layer and column, to a source pixel.
    fn source_of(
        &self,
        winner: Winner,
        (view, layer, column): (usize, usize, i32),
        gloss: &mut Vec<Gloss>,
    ) -> SourcePixel {
        let line = &self.lines[winner.line as usize];
        let pixel = self.source_pixel(line);
        let steady = self.steady(winner);
        let light = match pixel.light {
            Light::Gloss(at) => {
                gloss.push(self.of.sources[usize::from(line.source)].rows[self.row].gloss[at as usize].clone());
                Light::Gloss(gloss.len() as u32 - 1)
            }
            other => other,
        };
        let (own, _) = self.pixel(Some(winner), view);
        SourcePixel { column, depth_m: pixel.depth_m, layer: layer as u8, light, steady, own }
    }

    /// Returns the highlight of a line; `None` if it has none.
    pub fn highlight(&self, line: usize) -> Option<&Highlight> {
        let cell = self.highlights.get(line)?;
        let Light::Gloss(gloss) = self.source_pixel(&self.lines[line]).light else { return None };
        let source = &self.of.sources[usize::from(self.lines[line].source)].rows[self.row];
        let of = || Highlight::new(&source.gloss[gloss as usize], &self.of.eyes, self.of.settings.splits);
        Some(cell.get_or_init(of))
    }
}

fn blended(a: [f16; 3], b: [f16; 3], weight: u8) -> [f16; 3] {
    let key = |half: f16| HalfKey::from_bits(half.to_bits());
    std::array::from_fn(|channel| HalfKey::lerp(key(a[channel]), key(b[channel]), weight).to_half())
}
