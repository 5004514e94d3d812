//! Backends that interpolate views: the CPU, or a device backend of a higher module.

use std::ops::Range;

use super::counters::Counters;
use super::erosion::Moves;
use super::interpolate::{InterpolatedView, Interpolator};
use codec::error::Result;
use codec::monitor::Monitor;

pub trait Backend {
    /// Interpolates the views in `range`. All backends return the same bits, except for highlights. The monitor advances by one
    /// per scanline.
    fn views(
        &self,
        of: &Interpolator<'_>,
        range: Range<usize>,
        monitor: &dyn Monitor,
    ) -> Result<(Vec<InterpolatedView>, Counters)>;

    /// Returns [`Moves::eroded`], which is the same number on all backends.
    fn eroded(&self, moves: &Moves) -> Result<u64> {
        Ok(moves.eroded())
    }
}

/// CPU backend, which uses all threads.
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
