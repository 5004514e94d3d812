//! What source views are acquired by.

use std::time::Duration;

use crate::epipolar::source::MAX_LAYERS;
use crate::epipolar::views::OutputViews;
use crate::scene::capture::{PixelTracer, SamplePattern};

/// Rows and columns of the squares that share a list of objects in view.
pub(super) const TILE: u32 = PixelTracer::TILE;

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

/// Where source views stand that are known before any is made.
#[derive(Debug, Clone, PartialEq)]
pub struct Places {
    /// Metres to the right of the middle of the output views, rising.
    pub offsets_m: Vec<f64>,
    /// Whether the window of the source is widened, by [`OutputViews::wider_columns`].
    pub is_wide: bool,
}

impl Acquisition {
    /// `None` for a hierarchical acquisition, whose sources follow from those at the ends.
    pub fn places(self, views: &OutputViews) -> Option<Places> {
        let [first_m, last_m] = views.ends_m();
        let (offsets_m, is_wide) = match self {
            // Views in one place have one source.
            _ if first_m == last_m => (vec![first_m], false),
            Acquisition::Center => (vec![0.0], true),
            Acquisition::Dual => (vec![first_m, last_m], false),
            Acquisition::Hierarchical => return None,
        };
        Some(Places { offsets_m, is_wide })
    }
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
    pub hierarchy: Hierarchy,
}

/// When a hierarchical acquisition ends.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum StoppingRule {
    /// By the pixels that nothing covers in a view between two sources.
    #[default]
    Holes,
    /// By edges of the sources, without interpolation.
    Erosion,
}

/// Where between two sources the next one stands.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum SourcePlacement {
    #[default]
    Midpoint,
    /// Where most pixels are missing (Epipolar 7.5).
    Clusters,
}

/// Settings of a hierarchical acquisition.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hierarchy {
    pub stop: StoppingRule,
    pub placement: SourcePlacement,
    /// Share of missing pixels, in percent, above which a source is added.
    pub hole_threshold_percent: f64,
    /// Sources at most, 2 or more.
    pub max_sources: usize,
    /// After so long no source is begun: results depend on the clock.
    pub time: Option<Duration>,
}

impl Default for Hierarchy {
    fn default() -> Self {
        Hierarchy {
            stop: StoppingRule::default(),
            placement: SourcePlacement::default(),
            hole_threshold_percent: 0.5,
            max_sources: 9,
            time: None,
        }
    }
}

impl AcquireSettings {
    pub fn new(samples: SamplePattern) -> AcquireSettings {
        AcquireSettings {
            acquisition: Acquisition::default(),
            samples,
            layers: MAX_LAYERS,
            culling: Culling::Full,
            hierarchy: Hierarchy::default(),
        }
    }
}
