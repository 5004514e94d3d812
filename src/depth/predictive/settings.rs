//! What a header says of predictive coding (depth.md 3, 15.1).

use crate::depth::predictive::levels::Levels;
use crate::depth::predictive::projection::Projection;
use crate::depth::predictive::tables::Tables;

/// Chunks have at most this many frames.
pub const MAX_FRAMES: u32 = 4096;
/// Sides of units.
pub const MAX_SIDE: u32 = 1024;

#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PredictiveHeader {
    /// E: residuals are in steps of 2E + 1 codes.
    pub bound: u16,
    /// Change of the source, in codes on top of the bound, below which a pixel is not updated.
    pub epsilon: u16,
    pub keyframe_interval: u32,
    pub projection: Projection,
    /// Table sets that payloads name.
    pub tables: Tables,
    /// Codes that occur; empty where any may. With them the bound is 0, and there is no projection.
    pub levels: Levels,
}
