//! Header fields of predictive coding (depth.md 3, 15.1).

use crate::depth::predictive::levels::Levels;
use crate::depth::predictive::projection::Projection;
use crate::depth::predictive::tables::Tables;

/// Maximum number of frames of a chunk.
pub const MAX_FRAMES: u32 = 4096;
/// Maximum width and height of a unit, in pixels.
pub const MAX_SIDE: u32 = 1024;

#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PredictiveHeader {
    /// E: residuals are in steps of 2E + 1 codes.
    pub bound: u16,
    /// Change of the source, in codes in addition to the bound, up to which a pixel is not updated.
    pub epsilon: u16,
    pub keyframe_interval: u32,
    pub projection: Projection,
    /// Table sets, which payloads select by number.
    pub tables: Tables,
    /// Codes that occur; empty if any may. With levels the bound is 0, and there is no projection.
    pub levels: Levels,
}
