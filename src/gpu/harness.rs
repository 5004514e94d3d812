//! Runs a kernel on given input words, and compares its output with the expected words.

use std::collections::HashMap;
use std::time::{Duration, Instant};

use crate::Gpu;
use codec::error::{Error, Result};
use kernels::Kernel;
use kernels::layout::MAX_GROUPS;

/// One dispatch with its input and expected output; buffers are given as words by binding name.
#[derive(Debug, Clone, Default)]
pub struct Case {
    pub label: String,
    /// Initial contents. Names that the kernel does not bind are ignored.
    pub buffers: HashMap<&'static str, Vec<u32>>,
    /// Invocations, rounded up to whole workgroups. For a kernel with a reader: invocations of the reader and workgroups of the
    /// kernel.
    pub invocations: u32,
    /// Passes of the kernel's reader, if it has one.
    pub passes: u32,
    /// Expected first words of some bindings after the dispatch.
    pub expected: Vec<(&'static str, Vec<u32>)>,
    /// Number of inputs that the case covers: nodes, boxes, cells or blocks.
    pub inputs: u64,
    pub pixels: u64,
}

#[derive(Debug, Clone, Default, PartialEq, serde::Serialize)]
pub struct KernelReport {
    pub name: &'static str,
    /// Nodes, boxes, cells or blocks decoded; for rendering kernels, pictures.
    pub inputs: u64,
    /// Words that differ from the CPU's; for pictures, pixels outside the tolerance.
    pub mismatches: u64,
    /// Description of the first mismatch.
    #[serde(rename = "first_mismatch")]
    pub first: Option<String>,
    /// Pixels written per microsecond, without transfers, for the last timed case.
    pub megapixels_per_second: f64,
}

/// Returns the numbers of workgroups along x and y for `count` workgroups in total.
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

    /// Runs a case and adds its result. With a `clock`, repeats it for about that duration and measures the time.
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
            // The second run starts with the scratch memory that the first left, and with the original pictures.
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
