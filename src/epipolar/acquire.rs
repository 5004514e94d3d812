//! Source views of a scene (Epipolar 3.3.1).
//!
//! A source view has layers: the nearest surfaces, and those behind them that an output view may see. All hits of a pixel's ray are found
//! at once (Epipolar 7.4), which are the layers of depth peeling, and those are left out that no output view sees. Of hits at one distance
//! one is a layer: listing 3.2 of the thesis asks for a depth that is not less than that of the last layer, which finds that layer again.

mod erosion;
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
pub use hierarchical::hierarchical;
pub use settings::{AcquireSettings, Acquisition, Culling, Hierarchy, SourcePlacement, StoppingRule};
use tracer::SourceTracer;

/// The source views of a scene, by their places.
pub fn acquire(
    scene: &SceneAtTime,
    views: &OutputViews,
    settings: &AcquireSettings,
    monitor: &dyn Monitor,
) -> Result<(Vec<SourceView>, Counters)> {
    let tracer = SourceTracer { scene, views, settings, monitor };
    let ends_m = views.ends_m();
    let (sources, mut counters) = match settings.acquisition {
        // Views in one place have one source.
        _ if ends_m[0] == ends_m[1] => tracer.views(ends_m[..1].iter().copied(), settings.layers)?,
        Acquisition::Center => {
            let (source, counters) = tracer.center()?;
            (vec![source], counters)
        }
        Acquisition::Dual => tracer.views(ends_m.into_iter(), settings.layers)?,
        Acquisition::Hierarchical => {
            hierarchical(views, &settings.hierarchy, |offset_m| tracer.whole_view(offset_m, 1))?
        }
    };
    let sources = in_order(sources);
    counters.source_views = sources.len() as u64;
    counters.source_layers = sources.iter().map(|source| u64::from(source.layers)).max().unwrap_or(0);
    counters.source_pixels = sources.iter().map(SourceView::pixel_count).sum();
    Ok((sources, counters))
}
