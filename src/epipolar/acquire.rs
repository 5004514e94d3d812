//! Source views of a scene (Epipolar 3.3.1).
//!
//! A source view has layers: the nearest surfaces first, then the surfaces behind them that an output view may see. All hits of a
//! pixel's ray are found in one pass (Epipolar 7.4), which gives the layers of depth peeling; hits that no output view sees are
//! left out. Of several hits at the same distance, only one becomes a layer. (Listing 3.2 of the thesis accepts depths that are
//! not less than that of the last layer, and so finds the last layer again.)

mod hierarchical;
mod row;
mod settings;
mod tracer;

use std::ops::Range;

use super::backend::Backend;
use super::counters::Counters;
use super::drawing::{DrawnScene, PixelWindow};
use super::source::{SourceView, in_order};
use super::views::OutputViews;
use codec::error::Result;
use codec::monitor::Monitor;
pub use hierarchical::hierarchical;
use settings::TILE;
pub use settings::{
    AcquireSettings, Acquisition, Culling, Hierarchy, LayerReduction, Places, SourcePlacement, StoppingRule,
};
use tracer::SourceTracer;

/// Acquires whole source views of a scene, sorted by position.
pub fn acquire<'a>(
    seen: impl Into<DrawnScene<'a>>,
    views: &OutputViews,
    settings: &AcquireSettings,
    (backend, monitor): (&dyn Backend, &dyn Monitor),
) -> Result<(Vec<SourceView>, Counters)> {
    let seen = seen.into();
    if let Some(bands) = SourceBands::plan(seen, views, settings, monitor)? {
        return bands.rows(0..views.size[1]);
    }
    let tracer = SourceTracer { seen, views, settings, monitor };
    let window = PixelWindow { columns: 0..views.size[0] as i32, rows: 0..views.size[1] };
    let make = |offsets_m: &[f64]| tracer.views(offsets_m, &window, 1);
    let (sources, counters) = hierarchical(views, &settings.hierarchy, backend, make)?;
    let sources = in_order(sources);
    let counters = counters.of_sources(&sources);
    Ok((sources, counters))
}

/// Source views of a scene that are acquired in bands of scanlines, because their positions are known in advance: the positions,
/// and the columns.
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
