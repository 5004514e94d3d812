//! Source views of a scene (Epipolar 3.3.1).
//!
//! A source view has layers: the nearest surfaces, and those behind them that an output view may see. All hits of a pixel's ray are found
//! at once (Epipolar 7.4), which are the layers of depth peeling, and those are left out that no output view sees. Of hits at one distance
//! one is a layer: listing 3.2 of the thesis asks for a depth that is not less than that of the last layer, which finds that layer again.

mod bands;
mod hierarchical;
mod row;
mod settings;
mod tracer;

use super::backend::Backend;
use super::counters::Counters;
use super::drawing::{DrawnScene, PixelWindow};
use super::source::{SourceView, in_order};
use super::views::OutputViews;
use crate::error::Result;
use crate::monitor::Monitor;
pub use bands::SourceBands;
pub use hierarchical::hierarchical;
pub use settings::{AcquireSettings, Acquisition, Culling, Hierarchy, Places, SourcePlacement, StoppingRule};
use tracer::SourceTracer;

/// Whole source views of a scene, by their places.
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
