//! Source views in bands of scanlines, for acquisitions whose source positions are known in advance.

use std::ops::Range;

use super::settings::{AcquireSettings, Places, TILE};
use super::tracer::SourceTracer;
use crate::counters::Counters;
use crate::drawing::{DrawnScene, PixelWindow};
use crate::source::SourceView;
use crate::views::OutputViews;
use codec::error::Result;
use codec::monitor::Monitor;

/// Source views of a scene that are acquired in bands: their positions and their columns.
pub struct SourceBands<'a> {
    tracer: SourceTracer<'a>,
    /// Positions in metres to the right of the middle of the output views, in ascending order.
    offsets_m: Vec<f64>,
    columns: Range<i32>,
}

impl<'a> SourceBands<'a> {
    /// Height of a band is a multiple of this, except for the last band: this many scanlines share the lists of objects in view.
    pub const ROWS: u32 = TILE;

    /// Plans the source views. Returns `None` for a hierarchical acquisition, whose source positions depend on whole source
    /// views.
    pub fn plan(
        seen: DrawnScene<'a>,
        views: &'a OutputViews,
        settings: &'a AcquireSettings,
        monitor: &'a dyn Monitor,
    ) -> Result<Option<SourceBands<'a>>> {
        let tracer = SourceTracer { seen, views, settings, monitor };
        let Some(Places { offsets_m, is_wide }) = settings.acquisition.places(views) else { return Ok(None) };
        let columns = if is_wide { tracer.wide_columns()? } else { 0..views.size[0] as i32 };
        Ok(Some(SourceBands { tracer, offsets_m, columns }))
    }

    /// Acquires the given scanlines of all source views.
    pub fn rows(&self, rows: Range<u32>) -> Result<(Vec<SourceView>, Counters)> {
        let window = PixelWindow { columns: self.columns.clone(), rows };
        let (sources, counters) = self.tracer.views(&self.offsets_m, &window, self.tracer.settings.layers)?;
        let counters = counters.of_sources(&sources);
        Ok((sources, counters))
    }
}
