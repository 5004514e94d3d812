//! How cells are coded in time.

use crate::effort::Effort;

/// What encoded colour keeps (color.md 5).
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Target {
    /// Least quality to the eye of every frame of every cell, 0 to 100. Of the transform codec.
    Quality(f64),
    /// Least PSNR of every frame of every cell, in dB, 0 to 200.
    Psnr(f64),
    /// Nothing: a step index for all cells, 0 to 240. Of the transform codec.
    Step(u8),
}

impl Target {
    /// Least PSNR in dB; 0 for other targets.
    pub fn min_psnr_db(self) -> f64 {
        if let Target::Psnr(db) = self { db } else { 0.0 }
    }

    /// Least quality; 0 for other targets.
    pub fn min_quality(self) -> f64 {
        if let Target::Quality(quality) = self { quality } else { 0.0 }
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SearchSettings {
    pub target: Target,
    /// How hard to look: fast doubles distances, then bisects; normal doubles them, then tries every distance between
    /// the last that served and the first that did not; exhaustive tries every distance, the farthest first, and so
    /// finds the maximum of equation 12 within the lookahead.
    pub effort: Effort,
    /// Distinct pictures that may lie between one keyframe and the next, at least 1: bounds memory and time. Repeats
    /// of the picture before do not count.
    pub lookahead: u32,
}

impl Default for SearchSettings {
    fn default() -> Self {
        SearchSettings { target: Target::Psnr(50.0), effort: Effort::Normal, lookahead: 64 }
    }
}
