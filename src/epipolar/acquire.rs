//! Source views of a scene (Epipolar 3.3.1).
//!
//! A source view has layers: the nearest surfaces first, then the surfaces behind them that an output view may see. All hits of a
//! pixel's ray are found in one pass (Epipolar 7.4), which gives the layers of depth peeling; hits that no output view sees are
//! left out. Of several hits at the same distance, only one becomes a layer. (Listing 3.2 of the thesis accepts depths that are
//! not less than that of the last layer, and so finds the last layer again.)

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
pub use bands::SourceBands;
use codec::error::Result;
use codec::monitor::Monitor;
pub use hierarchical::hierarchical;
pub use settings::{AcquireSettings, Acquisition, Culling, Hierarchy, Places, SourcePlacement, StoppingRule};
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
