//! What source views are acquired by.

use crate::epipolar::source::MAX_LAYERS;
use crate::scene::capture::SamplePattern;

/// Rows and columns of the squares that share a list of objects in view.
pub(super) const TILE: u32 = 16;

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
