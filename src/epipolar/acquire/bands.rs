//! Source views, some scanlines at a time, where their places are known beforehand.

use std::ops::Range;

use super::settings::{AcquireSettings, Acquisition, TILE};
use super::tracer::SourceTracer;
use crate::epipolar::counters::Counters;
use crate::epipolar::drawing::{DrawnScene, PixelWindow};
use crate::epipolar::source::SourceView;
use crate::epipolar::views::OutputViews;
use crate::error::Result;
use crate::monitor::Monitor;

/// The source views of a scene: their places and columns.
pub struct SourceBands<'a> {
    tracer: SourceTracer<'a>,
    /// Metres to the right of the middle of the output views, rising.
    offsets_m: Vec<f64>,
    columns: Range<i32>,
}

impl<'a> SourceBands<'a> {
    /// Heights of bands are multiples of it, but for the last one: so many scanlines share lists of objects in view.
    pub const ROWS: u32 = TILE;

    /// `None` for a hierarchical acquisition, whose sources follow from whole ones.
    pub fn plan(
        seen: DrawnScene<'a>,
        views: &'a OutputViews,
        settings: &'a AcquireSettings,
        monitor: &'a dyn Monitor,
    ) -> Result<Option<SourceBands<'a>>> {
        let tracer = SourceTracer { seen, views, settings, monitor };
        let ends_m = views.ends_m();
        let columns = 0..views.size[0] as i32;
        Ok(Some(match settings.acquisition {
            // Views in one place have one source.
            _ if ends_m[0] == ends_m[1] => SourceBands { tracer, offsets_m: vec![ends_m[0]], columns },
            Acquisition::Center => SourceBands { tracer, offsets_m: vec![0.0], columns: tracer.wide_columns()? },
            Acquisition::Dual => SourceBands { tracer, offsets_m: ends_m.to_vec(), columns },
            Acquisition::Hierarchical => return Ok(None),
        }))
    }

    /// Some scanlines of all source views.
    pub fn rows(&self, rows: Range<u32>) -> Result<(Vec<SourceView>, Counters)> {
        let window = PixelWindow { columns: self.columns.clone(), rows };
        let (sources, counters) = self.tracer.views(&self.offsets_m, &window, self.tracer.settings.layers)?;
        let counters = counters.of_sources(&sources);
        Ok((sources, counters))
    }
}
