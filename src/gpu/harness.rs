//! Runs one kernel over given words, and compares its output with the expected words.

use std::collections::HashMap;
use std::time::{Duration, Instant};

use crate::error::{Error, Result};
use crate::gpu::Gpu;
use crate::gpu::kernels::Kernel;
use crate::gpu::layout::MAX_GROUPS;

/// One dispatch with its expected output; words by the names of bindings.
#[derive(Debug, Clone, Default)]
pub struct Case {
    pub label: String,
    /// Bindings that a kernel does not have count for nothing.
    pub buffers: HashMap<&'static str, Vec<u32>>,
    /// Invocations, rounded up to whole workgroups. With a reader: its invocations, and the kernel's workgroups.
    pub invocations: u32,
    /// Passes of the kernel's reader, where it has one.
    pub passes: u32,
    /// The words that bindings begin with afterwards.
    pub expected: Vec<(&'static str, Vec<u32>)>,
    /// Inputs that it stands for: nodes, boxes, cells, blocks.
    pub inputs: u64,
    pub pixels: u64,
}

#[derive(Debug, Clone, Default, PartialEq, serde::Serialize)]
pub struct KernelReport {
    pub name: &'static str,
    /// Nodes, boxes, cells or blocks that it decoded; pictures that it rendered.
    pub inputs: u64,
    /// Words that differ from the CPU's; of pictures, pixels that do so by more than is allowed.
    pub mismatches: u64,
    /// The first of them, in words.
    #[serde(rename = "first_mismatch")]
    pub first: Option<String>,
    /// Pixels written in a microsecond, without transfers; of the last case that was timed.
    pub megapixels_per_second: f64,
}

/// Workgroups along x and y for `count` in all.
pub fn groups(count: u32) -> [u32; 2] {
    let x = count.clamp(1, MAX_GROUPS);
    [x, count.div_ceil(x).max(1)]
}

/// Runs a kernel once, with buffers by the names of its bindings.
pub fn dispatch<'b>(
    gpu: &Gpu,
    kernel: &'static Kernel,
    workgroups: usize,
    named: impl Fn(&str) -> Option<&'b wgpu::Buffer>,
) -> Result<()> {
    let pipeline = gpu.pipeline(kernel)?;
    gpu.compute(kernel.name, |pass| {
        let group = gpu.bind(&pipeline, |name| Some(named(name)?.as_entire_binding()));
        pass.set_pipeline(&pipeline.pipeline);
        pass.set_bind_group(0, &group, &[]);
        let [x, y] = groups(workgroups as u32);
        pass.dispatch_workgroups(x, y, 1);
    })
}

const MAX_REPEATS: f64 = 100.0;

impl KernelReport {
    pub fn new(name: &'static str) -> KernelReport {
        KernelReport { name, ..KernelReport::default() }
    }

    /// Runs a case and adds its result. With a `clock` it is repeated for about so long, and timed.
    pub fn run(&mut self, gpu: &Gpu, kernel: &'static Kernel, case: &Case, clock: Option<Duration>) -> Result<()> {
        let mut buffers = HashMap::new();
        for binding in kernel.bindings {
            let words = case.buffers.get(binding.name).map_or(&[][..], Vec::as_slice);
            buffers.insert(binding.name, gpu.filled(binding.name, words)?);
        }
        let invocation_groups = case.invocations.div_ceil(kernel.workgroup);
        let part_groups = if kernel.reader.is_some() { case.invocations } else { invocation_groups };
        let mut steps = Vec::new();
        for (kernel, times, workgroups) in
            [(kernel.reader, case.passes, invocation_groups), (Some(kernel), 1, part_groups)]
        {
            let Some(kernel) = kernel else { continue };
            let pipeline = gpu.pipeline(kernel)?;
            let group = gpu.bind(&pipeline, |name| buffers.get(name).map(wgpu::Buffer::as_entire_binding));
            steps.push((group, pipeline, times, groups(workgroups)));
        }
        let dispatch = |times: u32| {
            gpu.compute(kernel.name, |pass| {
                for (group, pipeline, passes, [x, y]) in (0..times).flat_map(|_| &steps) {
                    pass.set_pipeline(&pipeline.pipeline);
                    pass.set_bind_group(0, group, &[]);
                    (0..*passes).for_each(|_| pass.dispatch_workgroups(*x, *y, 1));
                }
            })
        };
        if kernel.reader.is_some() {
            // The second run finds the scratch memory of the first, and the pictures of before.
            dispatch(1)?;
            gpu.write("pictures", &buffers["pictures"], &case.buffers["pictures"])?;
        }
        dispatch(1)?;
        self.inputs += case.inputs;
        for (name, expected) in &case.expected {
            let found = gpu.read(&buffers[name], expected.len())?;
            let differing =
                || found.iter().zip(expected).enumerate().filter(|(_, (found, expected))| found != expected);
            self.mismatches += differing().count() as u64;
            if let (None, Some((word, (found, expected)))) = (&self.first, differing().next()) {
                let label = &case.label;
                self.first = Some(format!("{label}: word {word} of {name} is {found:#010x} and not {expected:#010x}"));
            }
        }
        let Some(clock) = clock else { return Ok(()) };
        let timed = |times: u32| {
            let start = Instant::now();
            dispatch(times)?;
            gpu.wait()?;
            Ok::<_, Error>(start.elapsed().as_secs_f64() / f64::from(times))
        };
        let mut seconds = timed(1)?;
        let repeats = (clock.as_secs_f64() / seconds.max(1e-6)).min(MAX_REPEATS) as u32;
        if repeats > 1 {
            seconds = timed(repeats)?;
        }
        self.megapixels_per_second = case.pixels as f64 / 1e6 / seconds.max(1e-9);
        Ok(())
    }
}
