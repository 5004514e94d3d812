//! Selects the tiles and cells to decode, frame by frame (CALF 6.2).

use crate::streams::StreamInfo;

pub trait UnitFilter: Sync {
    fn wants(&self, stream: &StreamInfo, unit: u32, frame: u32) -> bool;
}

#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct AllUnits;

impl UnitFilter for AllUnits {
    fn wants(&self, _stream: &StreamInfo, _unit: u32, _frame: u32) -> bool {
        true
    }
}
