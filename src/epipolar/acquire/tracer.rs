//! Acquisition of source views at given positions.

use std::ops::Range;

use rayon::prelude::*;

use super::row::RowAcquisition;
use super::settings::{AcquireSettings, TILE};
use crate::continuity::Continuity;
use crate::counters::Counters;
use crate::drawing::{DrawnScene, MAX_DRAWN, PixelHits, PixelWindow};
use crate::source::{SourceRow, SourceView};
use crate::views::OutputViews;
use crate::visibility::Reach;
use codec::error::Result;
use codec::monitor::Monitor;
use scene::capture::{PixelTracer, Viewpoint};

/// Inputs of the acquisition of source views.
#[derive(Clone, Copy)]
pub(super) struct SourceTracer<'a> {
    pub seen: DrawnScene<'a>,
    pub views: &'a OutputViews,
    pub settings: &'a AcquireSettings,
    pub monitor: &'a dyn Monitor,
}

impl SourceTracer<'_> {
    /// Returns the columns of a source in the middle whose window is widened on both sides.
    pub fn wide_columns(&self) -> Result<Range<i32>> {
        let [width, height] = self.views.size;
        let from = self.views.viewpoint(0.0);
        let acquisition = self.acquisition((0.0, &from), 1);
        let widths = self.bands(0..height, |rows| acquisition.farthest_columns(rows, 0..width as i32))?;
        let wider = self.views.wider_columns(widths.into_iter().fold(0.0, f64::max)) as i32;
        Ok(-wider..width as i32 + wider)
    }

    /// Acquires the given columns and scanlines of the views from several positions, with at most `layers` layers.
    pub fn views(&self, offsets_m: &[f64], window: &PixelWindow, layers: usize) -> Result<(Vec<SourceView>, Counters)> {
        let mut counters = Counters::default();
        let mut rows: Vec<Vec<SourceRow>> = vec![Vec::new(); offsets_m.len()];
        let samples = &self.settings.samples.points;
        // Surfaces that no view sees are removed later.
        let drawn = if layers == 1 { 1 } else { MAX_DRAWN };
        let at_once = self.seen.rows_at_once(window.columns.len() * offsets_m.len(), drawn + samples.len());
        let mut top = window.rows.start;
        while top < window.rows.end {
            let part = PixelWindow { rows: top..top.saturating_add(at_once).min(window.rows.end), ..window.clone() };
            top = part.rows.end;
            let from = |offset_m: &f64| -> Result<_> {
                let from = self.views.viewpoint(*offset_m);
                let hits = self.seen.hits(&from, part.clone(), drawn, samples, self.monitor)?;
                Ok((*offset_m, from, hits))
            };
            let places: Vec<_> = offsets_m.iter().map(from).collect::<Result<_>>()?;
            let view = |(offset_m, from, hits): &(f64, Viewpoint, PixelHits<'_>)| {
                let acquisition = self.acquisition((*offset_m, from), layers);
                self.bands(part.rows.clone(), |rows| {
                    let of_band = acquisition.band(hits, rows.clone(), part.columns.clone());
                    self.monitor.advance(rows.len() as u64);
                    of_band
                })
            };
            let found: Vec<Vec<(Vec<SourceRow>, Counters)>> = places.par_iter().map(view).collect::<Result<_>>()?;
            for (rows, bands) in rows.iter_mut().zip(found) {
                for (of_band, counted) in bands {
                    rows.extend(of_band);
                    counters.add(&counted);
                }
            }
        }
        let sources = offsets_m.iter().zip(rows).map(|(&offset_m, rows)| SourceView::of_rows(offset_m, rows));
        Ok((sources.collect(), counters))
    }

    fn acquisition<'v>(&'v self, (offset_m, from): (f64, &'v Viewpoint), layers: usize) -> RowAcquisition<'v> {
        let pixels = PixelTracer::new(self.seen.scene, from);
        let focal = self.views.focal_pixels();
        let [first_m, last_m] = self.views.ends_m();
        RowAcquisition {
            pixels,
            views: self.views,
            settings: self.settings,
            continuity: Continuity::new(focal * (last_m - first_m)),
            layers,
            focal_pixels: focal,
            reach_m: (offset_m - first_m).max(last_m - offset_m),
            reach: Reach { columns: [(offset_m - first_m) * focal, (last_m - offset_m) * focal] },
        }
    }

    /// Calls `of_band` for each band of scanlines in parallel, and returns the results in order.
    fn bands<T: Send>(&self, rows: Range<u32>, of_band: impl Fn(Range<u32>) -> T + Sync) -> Result<Vec<T>> {
        let tops = (0..rows.len() as u32).into_par_iter().step_by(TILE as usize);
        tops.map(|top| {
            self.monitor.check()?;
            let top = rows.start + top;
            Ok(of_band(top..(top + TILE).min(rows.end)))
        })
        .collect()
    }
}
