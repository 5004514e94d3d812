//! Source views of a scene (Epipolar 3.3.1).
//!
//! A source view has layers: the nearest surfaces, and those behind them that an output view may see. All hits of a pixel's ray are found
//! at once (Epipolar 7.4), which are the layers of depth peeling, and those are left out that no output view sees. Of hits at one distance
//! one is a layer: listing 3.2 of the thesis asks for a depth that is not less than that of the last layer, which finds that layer again.

mod hierarchical;
mod row;
mod settings;
mod tracer;

use super::counters::Counters;
use super::source::{SourceView, in_order};
use super::views::OutputViews;
use crate::error::Result;
use crate::monitor::Monitor;
use crate::scene::SceneAtTime;
pub use settings::{AcquireSettings, Acquisition, Culling};
use tracer::SourceTracer;

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
