//! Which tiles and cells are decoded, and when (CALF 6.2).

use crate::decode::decoder::StreamInfo;

/// Chooses units of streams.
pub trait UnitFilter: Sync {
    /// Whether a unit of a stream is wanted in a frame.
    fn wants(&self, stream: &StreamInfo, unit: u32, frame: u32) -> bool;
}

/// All units, always.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct AllUnits;

impl UnitFilter for AllUnits {
    fn wants(&self, _stream: &StreamInfo, _unit: u32, _frame: u32) -> bool {
        true
    }
}
