//! Settings of the acquisition of source views.

use std::time::Duration;

use crate::source::MAX_LAYERS;
use crate::views::OutputViews;
use scene::capture::{PixelTracer, SamplePattern};

/// Side in pixels of the square tiles that share a list of objects in view.
pub(super) const TILE: u32 = PixelTracer::TILE;

/// Arrangement of the source views on the line.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Acquisition {
    /// One source in the middle, with a wider window.
    Center,
    /// One source at each end.
    #[default]
    Dual,
    /// Sources at both ends, and between them while pixels are missing. Only the first layer of each is acquired.
    Hierarchical,
}

/// Source positions that are known before any source is acquired.
#[derive(Debug, Clone, PartialEq)]
pub struct Places {
    /// Positions in metres to the right of the middle of the output views, in ascending order.
    pub offsets_m: Vec<f64>,
    /// True if the window of the source is widened, by [`OutputViews::wider_columns`].
    pub is_wide: bool,
}

impl Acquisition {
    /// Returns `None` for a hierarchical acquisition, whose positions depend on the sources at the ends.
    pub fn places(self, views: &OutputViews) -> Option<Places> {
        let [first_m, last_m] = views.ends_m();
        let (offsets_m, is_wide) = match self {
            // All output views are in one place, so one source is enough.
            _ if first_m == last_m => (vec![first_m], false),
            Acquisition::Center => (vec![0.0], true),
            Acquisition::Dual => (vec![first_m, last_m], false),
            Acquisition::Hierarchical => return None,
        };
        Some(Places { offsets_m, is_wide })
    }
}

/// Surfaces that source views leave out because no output view shows them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Culling {
    /// Surfaces too close behind others (3.4.1), and surfaces behind pixels that hide them from all views (3.4.2).
    Full,
    /// Only surfaces too close behind others (3.4.1).
    DepthOffset,
    /// No surfaces.
    Off,
}

#[derive(Debug, Clone)]
pub struct AcquireSettings {
    pub acquisition: Acquisition,
    /// Sample positions within a pixel of the first layer.
    pub samples: SamplePattern,
    /// Maximum number of layers of a source view, 1 to [`MAX_LAYERS`].
    pub layers: usize,
    pub culling: Culling,
    pub hierarchy: Hierarchy,
}

/// Measure that a hierarchical acquisition compares with its threshold.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum StoppingRule {
    /// Pixels that no line covers in a view between two sources.
    #[default]
    Holes,
    /// Estimate from the edges in the sources, without interpolation.
    Erosion,
}

/// Position of the next source between two sources.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum SourcePlacement {
    #[default]
    Midpoint,
    /// The position with the most missing pixels (Epipolar 7.5).
    Clusters,
}

/// Settings of a hierarchical acquisition.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hierarchy {
    pub stop: StoppingRule,
    pub placement: SourcePlacement,
    /// Percentage of missing pixels above which a source is added.
    pub hole_threshold_percent: f64,
    /// Maximum number of sources, 2 or more.
    pub max_sources: usize,
    /// Time after which no further source is started. Results then depend on the clock.
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

/// Dynamic layer reduction (Epipolar 3.4.4): thresholds that derive the number of layers of the next frame from the pixels of the
/// last frame, as percentages of an output view's pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LayerReduction {
    /// The next frame has one layer less if a smaller percentage of pixels shows the last layer.
    pub min_percent: f64,
    /// The next frame has one layer more if a larger percentage of pixels shows the last layer.
    pub max_percent: f64,
}

impl LayerReduction {
    /// Returns the number of layers of the next frame, 1 to `max_layers`. `pixels` is the number of all output pixels.
    pub fn next(&self, layers: usize, max_layers: usize, pixels_by_layer: [u64; MAX_LAYERS], pixels: u64) -> usize {
        let of_last = pixels_by_layer.get(layers.saturating_sub(1)).copied().unwrap_or(0);
        let percent = 100.0 * of_last as f64 / pixels.max(1) as f64;
        let next = if percent < self.min_percent {
            layers - 1
        } else if percent > self.max_percent {
            layers + 1
        } else {
            layers
        };
        next.clamp(1, max_layers)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn layers_that_show_little_are_left_out_one_by_one() {
        let reduction = LayerReduction { min_percent: 0.1, max_percent: 1.0 };
        let mut counts = [0; MAX_LAYERS];
        counts[..3].copy_from_slice(&[9000, 985, 15]);
        assert_eq!(reduction.next(3, 10, counts, 10_000), 3);
        // No pixel shows the fourth layer; more than a percent show the second.
        assert_eq!(reduction.next(4, 10, counts, 10_000), 3);
        assert_eq!(reduction.next(2, 10, counts, 10_000), 3);
        assert_eq!(reduction.next(2, 2, counts, 10_000), 2);
        assert_eq!(reduction.next(1, 10, [0; MAX_LAYERS], 10_000), 1);
    }
}
