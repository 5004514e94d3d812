//! Source views from given places.

use std::ops::Range;

use rayon::prelude::*;

use super::row::RowAcquisition;
use super::settings::{AcquireSettings, TILE};
use crate::epipolar::continuity::Continuity;
use crate::epipolar::counters::Counters;
use crate::epipolar::source::{SourceRow, SourceView};
use crate::epipolar::views::OutputViews;
use crate::epipolar::visibility::Reach;
use crate::error::Result;
use crate::monitor::Monitor;
use crate::scene::SceneAtTime;
use crate::scene::capture::PixelTracer;

/// Makes source views.
#[derive(Clone, Copy)]
pub(super) struct SourceTracer<'a> {
    pub scene: &'a SceneAtTime,
    pub views: &'a OutputViews,
    pub settings: &'a AcquireSettings,
    pub monitor: &'a dyn Monitor,
}

impl SourceTracer<'_> {
    /// Views from several places, of so many layers.
    pub fn views(&self, offsets_m: impl Iterator<Item = f64>, layers: usize) -> Result<(Vec<SourceView>, Counters)> {
        let mut counters = Counters::default();
        let mut sources = Vec::new();
        for offset_m in offsets_m {
            let (source, of_view) = self.whole_view(offset_m, layers)?;
            counters.add(&of_view);
            sources.push(source);
        }
        Ok((sources, counters))
    }

    /// The view from a place, as wide as output views.
    pub fn whole_view(&self, offset_m: f64, layers: usize) -> Result<(SourceView, Counters)> {
        self.view(offset_m, 0..self.views.size[0] as i32, layers)
    }

    /// A view in the middle, as much wider on each side as what the views at the ends show there, up to half of its width.
    pub fn center(&self) -> Result<(SourceView, Counters)> {
        let width = self.views.size[0] as i32;
        let (narrow, _) = self.view(0.0, 0..width, 1)?;
        let pixels = narrow.rows.iter().flat_map(|row| &row.pixels);
        let columns = pixels.map(|pixel| self.views.columns_per_metre(f64::from(pixel.depth_m)).abs());
        let most = columns.fold(0.0, f64::max) * 0.5 * self.views.baseline_m();
        let wider = (most.ceil() as i32).min(width / 2);
        self.view(0.0, -wider..width + wider, self.settings.layers)
    }

    /// The view from a place, of so many layers.
    fn view(&self, offset_m: f64, columns: Range<i32>, layers: usize) -> Result<(SourceView, Counters)> {
        let from = self.views.viewpoint(offset_m);
        let pixels = PixelTracer::new(self.scene, &from);
        let focal = self.views.focal_pixels();
        let [first_m, last_m] = self.views.ends_m();
        let acquisition = RowAcquisition {
            pixels,
            settings: self.settings,
            continuity: Continuity::new(focal * (last_m - first_m)),
            layers,
            focal_pixels: focal,
            reach_m: (offset_m - first_m).max(last_m - offset_m),
            reach: Reach { columns: [(offset_m - first_m) * focal, (last_m - offset_m) * focal] },
        };
        let height = self.views.size[1];
        let bands: Vec<(Vec<SourceRow>, Counters)> = (0..height.div_ceil(TILE))
            .into_par_iter()
            .map(|band| {
                self.monitor.check()?;
                let rows = band * TILE..((band + 1) * TILE).min(height);
                let found = acquisition.band(rows, columns.clone());
                Ok(found)
            })
            .collect::<Result<_>>()?;
        let mut counters = Counters::default();
        let mut rows = Vec::with_capacity(height as usize);
        for (of_band, counted) in bands {
            counters.add(&counted);
            rows.extend(of_band);
        }
        let layer = |row: &SourceRow| row.pixels.last().map_or(0, |pixel| u32::from(pixel.layer) + 1);
        let layers = rows.iter().map(layer).max().unwrap_or(0);
        Ok((SourceView { offset_m, rows, layers }, counters))
    }
}
