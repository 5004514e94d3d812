//! Settings of the coding of cells in time.

use crate::effort::Effort;

/// Quality target of encoded colour (color.md 5).
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Target {
    /// Minimum perceptual quality of every frame of every cell, 0 to 100 (color.md 5.2). Transform codec only.
    Quality(f64),
    /// Minimum PSNR of every frame of every cell, in dB, 0 to 200.
    Psnr(f64),
    /// No quality target: a step index for all cells, 0 to 240. Transform codec only.
    Step(u8),
}

impl Target {
    /// Minimum PSNR in dB; 0 for other targets.
    pub fn min_psnr_db(self) -> f64 {
        if let Target::Psnr(db) = self { db } else { 0.0 }
    }

    /// Minimum perceptual quality; 0 for other targets.
    pub fn min_quality(self) -> f64 {
        if let Target::Quality(quality) = self { quality } else { 0.0 }
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SearchSettings {
    pub target: Target,
    /// Search effort. Fast doubles the distance, then bisects. Normal doubles the distance, then tries every distance between
    /// the last that sufficed and the first that did not. Exhaustive tries every distance, the farthest first, and so finds
    /// the maximum of equation 12 within the lookahead.
    pub effort: Effort,
    /// Maximum number of distinct pictures between one keyframe and the next, at least 1; limits memory and time. Repeats of
    /// the previous picture do not count.
    pub lookahead: u32,
}

impl Default for SearchSettings {
    fn default() -> Self {
        SearchSettings { target: Target::Psnr(50.0), effort: Effort::Normal, lookahead: 64 }
    }
}
