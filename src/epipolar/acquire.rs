//! Source views of a scene (Epipolar 3.3.1).
//!
//! A source view has layers: the nearest surfaces, and those behind them that an output view may see. All hits of a pixel's ray are found
//! at once (Epipolar 7.4), which are the layers of depth peeling, and those are left out that no output view sees.

mod hierarchical;
mod row;

use std::ops::Range;

use rayon::prelude::*;

use super::continuity::Continuity;
use super::counters::Counters;
use super::source::{MAX_LAYERS, SourceRow, SourceView, in_order};
use super::views::OutputViews;
use crate::error::Result;
use crate::monitor::Monitor;
use crate::scene::SceneAtTime;
use crate::scene::capture::{PixelTracer, SamplePattern};
use row::RowAcquisition;

/// Rows and columns of the squares that share a list of objects in view.
const TILE: u32 = 16;

/// Where source views stand.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Acquisition {
    /// One in the middle, with a wider window.
    Center,
    /// One at each end.
    #[default]
    Dual,
    /// At the ends, and between them as long as pixels are missing; the first layer of each.
    Hierarchical,
}

/// What is left out of source views, since no output view shows it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Culling {
    /// Surfaces too close behind others (3.4.1), and those behind pixels that hide them from all views (3.4.2).
    Full,
    /// The former.
    DepthOffset,
    /// Nothing.
    Off,
}

#[derive(Debug, Clone)]
pub struct AcquireSettings {
    pub acquisition: Acquisition,
    /// Sample positions of a pixel of the first layer.
    pub samples: SamplePattern,
    /// Layers of a source view at most, 1 to [`MAX_LAYERS`].
    pub layers: usize,
    pub culling: Culling,
    /// Share of missing pixels, in percent, above which a hierarchical acquisition adds a source.
    pub hole_threshold_percent: f64,
    /// Sources of a hierarchical acquisition at most.
    pub max_sources: usize,
}

impl AcquireSettings {
    pub fn new(samples: SamplePattern) -> AcquireSettings {
        AcquireSettings {
            acquisition: Acquisition::default(),
            samples,
            layers: MAX_LAYERS,
            culling: Culling::Full,
            hole_threshold_percent: 0.5,
            max_sources: 9,
        }
    }
}

/// The source views of a scene, by their places.
pub fn acquire(
    scene: &SceneAtTime,
    views: &OutputViews,
    settings: &AcquireSettings,
    monitor: &dyn Monitor,
) -> Result<(Vec<SourceView>, Counters)> {
    let tracer = SourceTracer { scene, views, settings, monitor };
    let first_m = views.offsets_m.first().copied().unwrap_or(0.0);
    let ends = [first_m, first_m + views.baseline_m()];
    let (sources, mut counters) = match settings.acquisition {
        // Views in one place have one source.
        _ if ends[0] == ends[1] => tracer.views([ends[0]].into_iter(), settings.layers)?,
        Acquisition::Center => {
            let (source, counters) = tracer.center()?;
            (vec![source], counters)
        }
        Acquisition::Dual => tracer.views(ends.into_iter(), settings.layers)?,
        Acquisition::Hierarchical => hierarchical::acquire(&tracer, ends)?,
    };
    let sources = in_order(sources);
    counters.source_views = sources.len() as u64;
    counters.source_layers = sources.iter().map(|source| u64::from(source.layers)).max().unwrap_or(0);
    counters.source_pixels = sources.iter().map(SourceView::pixel_count).sum();
    Ok((sources, counters))
}

/// Makes source views.
#[derive(Clone, Copy)]
struct SourceTracer<'a> {
    scene: &'a SceneAtTime,
    views: &'a OutputViews,
    settings: &'a AcquireSettings,
    monitor: &'a dyn Monitor,
}

impl SourceTracer<'_> {
    fn views(&self, offsets_m: impl Iterator<Item = f64>, layers: usize) -> Result<(Vec<SourceView>, Counters)> {
        let mut counters = Counters::default();
        let mut sources = Vec::new();
        for offset_m in offsets_m {
            let (source, of_view) = self.view(offset_m, 0..self.views.size[0] as i32, layers)?;
            counters.add(&of_view);
            sources.push(source);
        }
        Ok((sources, counters))
    }

    /// A view in the middle, as much wider on each side as what the views at the ends show there, up to half of its width.
    fn center(&self) -> Result<(SourceView, Counters)> {
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
        let [first_m, last_m] =
            [self.views.offsets_m.first(), self.views.offsets_m.last()].map(|at| at.copied().unwrap_or(0.0));
        let acquisition = RowAcquisition {
            pixels,
            settings: self.settings,
            continuity: Continuity::new(focal * (last_m - first_m)),
            layers,
            focal_pixels: focal,
            reach_m: (offset_m - first_m).max(last_m - offset_m),
            reach: super::visibility::Reach { columns: [(offset_m - first_m) * focal, (last_m - offset_m) * focal] },
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
