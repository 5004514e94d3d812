//! The device that interpolates.

use std::cell::Cell;
use std::ops::Range;

use crate::cli::GlobalArgs;
use crate::cli::device::or_on_cpu;
use crate::epipolar::backend::{Backend, Cpu};
use crate::epipolar::counters::Counters;
use crate::epipolar::interpolate::{InterpolatedView, Interpolator};
use crate::error::Result;
use crate::gpu::Gpu;
use crate::gpu::device::DeviceChoice;
use crate::gpu::epipolar::GpuInterpolator;
use crate::monitor::Monitor;

/// A graphics device, or the CPU. With `--device auto` the CPU takes over from a device that fails.
pub(super) struct Device<'a> {
    gpu: Cell<Option<&'a Gpu>>,
    choice: Option<DeviceChoice>,
    global: &'a GlobalArgs,
}

impl<'a> Device<'a> {
    pub fn new(gpu: Option<&'a Gpu>, choice: Option<DeviceChoice>, global: &'a GlobalArgs) -> Device<'a> {
        Device { gpu: Cell::new(gpu), choice, global }
    }

    /// The name of the graphics device, or `cpu`.
    pub fn name(&self) -> String {
        self.gpu.get().map_or_else(|| "cpu".to_owned(), |gpu| gpu.info.name.clone())
    }
}

impl Backend for Device<'_> {
    fn views(
        &self,
        of: &Interpolator<'_>,
        range: Range<usize>,
        monitor: &dyn Monitor,
    ) -> Result<(Vec<InterpolatedView>, Counters)> {
        let on_gpu = |gpu: &Gpu| GpuInterpolator::new(gpu).views(of, range.clone(), monitor);
        let on_cpu = || Cpu.views(of, range.clone(), monitor);
        let (views, name) = or_on_cpu((self.gpu.get(), self.choice), self.global, on_gpu, on_cpu)?;
        self.gpu.set(self.gpu.get().filter(|gpu| gpu.info.name == name));
        Ok(views)
    }
}
