//! How cells are coded in time.

use crate::effort::Effort;

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SearchSettings {
    /// Least PSNR of every frame of every cell, in dB.
    pub min_psnr_db: f64,
    /// Step of the transform codec for all cells, 0 to 240; `min_psnr_db` is then 0.
    pub constant_step: Option<u8>,
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
        SearchSettings { min_psnr_db: 50.0, constant_step: None, effort: Effort::Normal, lookahead: 64 }
    }
}
