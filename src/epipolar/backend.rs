//! Where views are interpolated: the CPU, or a device above this module.

use std::ops::Range;

use super::counters::Counters;
use super::interpolate::{InterpolatedView, Interpolator};
use crate::error::Result;
use crate::monitor::Monitor;

pub trait Backend {
    /// Some of the views between sources, the same bits on any backend. The monitor advances by one for each scanline.
    fn views(
        &self,
        of: &Interpolator<'_>,
        range: Range<usize>,
        monitor: &dyn Monitor,
    ) -> Result<(Vec<InterpolatedView>, Counters)>;
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
