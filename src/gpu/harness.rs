//! Runs one kernel over given words, and compares its output with the expected words.

use std::time::Instant;

use crate::error::{Error, Result};
use crate::gpu::device::Gpu;
use crate::gpu::kernels::Kernel;
use crate::gpu::layout::MAX_GROUPS;

/// One dispatch with its expected output.
#[derive(Debug, Clone, Default)]
pub struct Case {
    pub label: String,
    /// The words of each binding, in order; written ones start with these.
    pub buffers: Vec<Vec<u32>>,
    /// Invocations, rounded up to whole workgroups.
    pub invocations: u32,
    /// Bindings, and the words that must be in them afterwards.
    pub expected: Vec<(usize, Vec<u32>)>,
    /// Inputs that it stands for: nodes, boxes, cells, blocks.
    pub inputs: u64,
    /// Pixels that it writes.
    pub pixels: u64,
}

/// The result of a case.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct CaseResult {
    /// Words that are not as expected.
    pub mismatches: u64,
    /// The first of them, in words.
    pub first: Option<String>,
    /// Seconds of one dispatch, timed over several; 0 where it was not timed.
    pub seconds: f64,
}

/// The result of a kernel.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct KernelReport {
    pub name: &'static str,
    /// Nodes, boxes, cells or blocks that it decoded; pictures that it rendered.
    pub inputs: u64,
    /// Words that differ from the CPU's; of pictures, pixels that do so by more than is allowed.
    pub mismatches: u64,
    /// The first of them, in words.
    #[serde(rename = "first_mismatch")]
    pub first: Option<String>,
    /// Pixels written in a microsecond, without transfers.
    pub megapixels_per_second: f64,
}

/// Workgroups along x and y for `count` in all.
pub fn groups(count: u32) -> [u32; 2] {
    let x = count.clamp(1, MAX_GROUPS);
    [x, count.div_ceil(x).max(1)]
}

/// Whether a case is also timed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Clock {
    Off,
    /// Repeated for about this many milliseconds.
    Milliseconds(u32),
}

/// Most dispatches that are timed together.
const MOST_REPEATS: f64 = 100.0;

pub fn run(gpu: &Gpu, kernel: &'static Kernel, case: &Case, clock: Clock) -> Result<CaseResult> {
    let pipeline = gpu.pipeline(kernel)?;
    let mut buffers = Vec::new();
    for (binding, words) in kernel.bindings.iter().zip(&case.buffers) {
        let buffer = gpu.buffer(binding.name, words.len(), wgpu::BufferUsages::empty())?;
        gpu.guard(binding.name, || gpu.queue.write_buffer(&buffer, 0, bytemuck::cast_slice(words)))?;
        buffers.push(buffer);
    }
    let dispatch = |times: u32| {
        gpu.guard(kernel.name, || {
            let group = gpu.bind(&pipeline, &buffers.iter().collect::<Vec<_>>());
            let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
            pass.set_pipeline(&pipeline.pipeline);
            pass.set_bind_group(0, &group, &[]);
            let [x, y] = groups(case.invocations.div_ceil(kernel.workgroup));
            (0..times).for_each(|_| pass.dispatch_workgroups(x, y, 1));
            drop(pass);
            gpu.queue.submit([encoder.finish()]);
        })
    };
    dispatch(1)?;
    let mut result = CaseResult::default();
    for (at, expected) in &case.expected {
        let found = gpu.read(&buffers[*at], expected.len())?;
        let differing = || found.iter().zip(expected).enumerate().filter(|(_, (found, expected))| found != expected);
        result.mismatches += differing().count() as u64;
        if let (None, Some((word, (found, expected)))) = (&result.first, differing().next()) {
            let (label, name) = (&case.label, kernel.bindings[*at].name);
            result.first = Some(format!("{label}: word {word} of {name} is {found:#010x} and not {expected:#010x}"));
        }
    }
    if let Clock::Milliseconds(most) = clock {
        let timed = |times: u32| {
            let start = Instant::now();
            dispatch(times)?;
            gpu.wait()?;
            Ok::<_, Error>(start.elapsed().as_secs_f64() / f64::from(times))
        };
        result.seconds = timed(1)?;
        let repeats = (f64::from(most) / 1e3 / result.seconds.max(1e-6)).min(MOST_REPEATS) as u32;
        if repeats > 1 {
            result.seconds = timed(repeats)?;
        }
    }
    Ok(result)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn many_workgroups_lie_in_two_directions() {
        assert_eq!(groups(0), [1, 1]);
        assert_eq!(groups(65535), [65535, 1]);
        assert_eq!(groups(65536), [65535, 2]);
        let [x, y] = groups(1 << 22);
        assert!(x * y >= 1 << 22 && x <= 65535 && y <= 65535);
    }
}
