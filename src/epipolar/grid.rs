//! Grids of views (Epipolar 7.2). The lowest and the highest row are interpolated from source views of their own; the columns
//! between these two rows are then interpolated by the same kernel, turned by 90°.
//!
//! Takes a scene and the rows of a grid, and returns pictures column by column. The reference method is to run
//! [`super::pipeline::interpolate`] for each row, which acquires sources for each row.

use std::ops::Range;
use std::time::Instant;

use super::acquire::acquire;
use super::drawing::DrawnScene;
use super::fill::{Truth, fill, picture};
use super::interpolate::{Coverage, InterpolatedView, Interpolator};
use super::pipeline::{Picture, Request, SourceReport, Summary};
use super::source::{Light, SourcePixel, SourceRow, SourceView};
use super::views::OutputViews;
use codec::error::Result;
use codec::image::Plane;
use codec::monitor::Monitor;

/// Number of columns whose two sources are made at once.
pub const COLUMNS_AT_ONCE: usize = 4;

/// Rows of a grid of views.
#[derive(Debug, Clone)]
pub struct GridViews {
    /// Views of a row at the middle height.
    pub row: OutputViews,
    /// Heights of the rows in metres, in ascending order.
    pub ups_m: Vec<f64>,
}

impl GridViews {
    /// Creates `rows` rows, spread evenly over `height_m` metres around the given row.
    pub fn new(row: OutputViews, rows: u32, height_m: f64) -> GridViews {
        let part = |at: u32| if rows < 2 { 0.0 } else { f64::from(at) / f64::from(rows - 1) - 0.5 };
        GridViews { row, ups_m: (0..rows.max(1)).map(|at| height_m * part(at)).collect() }
    }

    /// Returns the views of a row; row 0 is the lowest.
    pub fn views_of(&self, row: usize) -> Result<OutputViews> {
        self.row.raised(self.ups_m[row])
    }

    pub fn count(&self) -> usize {
        self.ups_m.len() * self.row.offsets_m.len()
    }

    /// Returns the part of `range` that lies in a row, as indices within the row. `range` counts views row by row.
    pub fn in_row(&self, range: &Range<usize>, row: usize) -> Range<usize> {
        let count = self.row.offsets_m.len();
        let place = |at: usize| at.clamp(row * count, (row + 1) * count) - row * count;
        place(range.start)..place(range.end)
    }
}

impl Request<'_, GridViews> {
    /// Returns true if a view is requested, given its row and its index in the row.
    fn wants(&self, row: usize, view: usize) -> bool {
        let number = row * self.views.row.offsets_m.len() + view;
        self.wanted.iter().any(|range| range.contains(&number))
    }
}

/// Returns the number of steps that a run over all columns reports to its monitor: one per line of a column. (The few source
/// views are negligible.)
pub fn steps(grid: &GridViews) -> u64 {
    grid.row.offsets_m.len() as u64 * u64::from(grid.row.size[0])
}

/// Renders the requested views of a grid column by column, and passes each to `take` with its row and its index in the row.
pub fn interpolate_grid<'a>(
    seen: impl Into<DrawnScene<'a>>,
    request: &Request<'_, GridViews>,
    monitor: &dyn Monitor,
    mut take: impl FnMut(usize, usize, Picture) -> Result<()>,
) -> Result<Summary> {
    let Request { views: grid, settings, backend, .. } = request;
    let mut summary = Summary::default();
    let last_row = grid.ups_m.len() - 1;
    let ends = [grid.views_of(0)?, grid.views_of(last_row)?];
    let begun = Instant::now();
    let mut sources = Vec::new();
    let seen = seen.into();
    for views in &ends {
        let (of_row, counters) = acquire(seen, views, &settings.acquire, (*backend, monitor))?;
        summary.counters.add(&counters);
        sources.push(of_row);
    }
    summary.passed.acquire = begun.elapsed();
    summary.sources = sources[0].iter().map(SourceReport::of).collect();
    let interpolators = [0, 1].map(|end| Interpolator::new(&ends[end], &sources[end], settings.interpolate));
    let truth = Truth { scene: seen.scene, samples: &settings.acquire.samples };
    let columns: Vec<usize> =
        (0..grid.row.offsets_m.len()).filter(|&view| (0..=last_row).any(|row| request.wants(row, view))).collect();
    let mut at = 0;
    while at < columns.len() {
        // Consecutive columns, at most [`COLUMNS_AT_ONCE`].
        let first = columns[at];
        let count = columns[at..].iter().zip(first..).take_while(|(column, next)| **column == *next).count();
        let block = first..first + count.min(COLUMNS_AT_ONCE);
        at += block.len();
        let begun = Instant::now();
        let [lowest, highest] = &interpolators;
        let layers = settings.acquire.layers;
        let (of_highest, threads_of_highest) = highest.layered(block.clone(), layers, monitor)?;
        let (of_lowest, threads_of_lowest) = lowest.layered(block.clone(), layers, monitor)?;
        let threads = &mut summary.counters.threads;
        *threads = *threads + threads_of_highest + threads_of_lowest;
        summary.passed.interpolate += begun.elapsed();
        for ((column, high), low) in block.zip(of_highest).zip(of_lowest) {
            let views = grid.row.column(grid.row.offsets_m[column], &grid.ups_m)?;
            let begun = Instant::now();
            let [top_m, bottom_m] = views.ends_m();
            let turned = [turned_source(high, grid.row.size, top_m), turned_source(low, grid.row.size, bottom_m)];
            let interpolator = Interpolator::new(&views, &turned, settings.interpolate);
            let (made, counted) = backend.views(&interpolator, 0..last_row + 1, monitor)?;
            summary.counters.add(&counted);
            summary.passed.interpolate += begun.elapsed();
            for (row, of_view) in made.iter().rev().enumerate().filter(|(row, _)| request.wants(*row, column)) {
                let mut of_view = turned_back(of_view);
                let unfilled = settings.keeps_unfilled.then(|| picture(&of_view)).transpose()?;
                let begun = Instant::now();
                let views = grid.views_of(row)?;
                let place = (&views, views.offsets_m[column]);
                summary.counters.traced_pixels += fill(&mut of_view, Some(truth), place, settings.holes, monitor)?;
                summary.passed.fill += begun.elapsed();
                take(row, column, Picture { filled: picture(&of_view)?, unfilled })?;
            }
        }
    }
    Ok(summary)
}

/// Turns a source view of the given size by 90°: its right column becomes the first row.
fn turned_source(view: SourceView, [width, _]: [u32; 2], offset_m: f64) -> SourceView {
    let mut rows = vec![SourceRow::default(); width as usize];
    for (down, row) in (0..).zip(view.rows) {
        for pixel in row.pixels {
            let out = &mut rows[(width - 1 - pixel.column as u32) as usize];
            let light = match pixel.light {
                Light::Gloss(at) => {
                    out.gloss.push(row.gloss[at as usize].clone());
                    Light::Gloss(out.gloss.len() as u32 - 1)
                }
                other => other,
            };
            out.pixels.push(SourcePixel { column: down, light, ..pixel });
        }
    }
    // The sort is stable, so pixels are sorted by layer, then by column.
    rows.iter_mut().for_each(|row| row.pixels.sort_by_key(|pixel| pixel.layer));
    SourceView { offset_m, rows: rows.into_iter().map(SourceRow::fitted).collect(), layers: view.layers }
}

/// Turns a view back to its upright orientation.
fn turned_back(view: &InterpolatedView) -> InterpolatedView {
    let [height, width] = [view.color.width(), view.color.height()];
    let color = Plane::from_fn(width, height, |x, y| view.color.get(y, width - 1 - x));
    let coverage: Plane<Coverage> = Plane::from_fn(width, height, |x, y| view.coverage.get(y, width - 1 - x));
    InterpolatedView { color, coverage }
}
