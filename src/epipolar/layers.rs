//! Dynamic layer reduction (Epipolar 3.4.4): derives the number of source layers of the next frame from the pixels of the last
//! frame.

use super::source::MAX_LAYERS;

/// Thresholds, as percentages of an output view's pixels.
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
