//! How much worse rounding may make an approximation.

use crate::depth::block::Accuracy;

/// Bounds on an approximation's errors.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Limit {
    /// Largest error of a pixel, in codes.
    pub max_error: u16,
    /// Largest sum of squared errors.
    pub squared_error: u64,
}

impl Limit {
    /// Whether an approximation stays within both bounds.
    pub fn allows(&self, accuracy: Accuracy) -> bool {
        accuracy.max_error <= self.max_error && accuracy.squared_error <= self.squared_error
    }
}
