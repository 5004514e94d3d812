//! Where views are interpolated: the CPU, or a device above this module.

use std::ops::Range;

use super::counters::Counters;
use super::erosion::Moves;
use super::interpolate::{InterpolatedView, Interpolator};
use crate::error::Result;
use crate::monitor::Monitor;

pub trait Backend {
    /// Some of the views between sources: the same bits on any backend, but for highlights. The monitor advances by one for each scanline.
    fn views(
        &self,
        of: &Interpolator<'_>,
        range: Range<usize>,
        monitor: &dyn Monitor,
    ) -> Result<(Vec<InterpolatedView>, Counters)>;

    /// [`Moves::eroded`], the same number on any backend.
    fn eroded(&self, moves: &Moves) -> Result<u64> {
        Ok(moves.eroded())
    }
}

/// All threads of the CPU.
#[derive(Debug, Clone, Copy, Default)]
pub struct Cpu;

impl Backend for Cpu {
    fn views(
        &self,
        of: &Interpolator<'_>,
        range: Range<usize>,
        monitor: &dyn Monitor,
    ) -> Result<(Vec<InterpolatedView>, Counters)> {
        of.views(range, monitor)
    }
}
