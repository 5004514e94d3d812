//! Runs every kernel on a device against its mirror on the CPU: hard cases first, then random inputs.

mod blocks;
mod boxes;
mod cells;
mod nodes;
mod plans;
pub mod streams;

use crate::depth::pieces::Pieces;
use crate::depth::records::Values;
use crate::error::Result;
use crate::gpu::device::Gpu;
use crate::gpu::harness::{self, Case, Clock};
use crate::gpu::kernels::{self, Kernel};

/// The seed of the inputs where none is given.
pub const SEED: u64 = 1;
/// Time for measuring the speed of a kernel.
const CLOCK: Clock = Clock::Milliseconds(200);

/// Inputs of a kernel.
#[derive(Debug)]
pub struct Row {
    /// The kernel.
    pub kernel: &'static Kernel,
    /// Makes its cases from a seed; the last one is what is timed.
    pub cases: fn(u64) -> Vec<Case>,
}

/// Inputs of all kernels.
pub static ROWS: &[Row] = &[
    Row { kernel: &kernels::NODES, cases: nodes::cases },
    Row { kernel: &kernels::BOXES_CODES, cases: boxes::cases::<u16, Values> },
    Row { kernel: &kernels::BOXES_MATERIAL, cases: boxes::cases::<[u8; 3], Values> },
    Row { kernel: &kernels::CELLS_8, cases: cells::bytes },
    Row { kernel: &kernels::CELLS_HALF, cases: cells::halves },
    Row { kernel: &kernels::BOXES_BC5, cases: boxes::cases::<u16, Pieces> },
    Row { kernel: &kernels::BOXES_BC1, cases: boxes::cases::<[u8; 3], Pieces> },
    Row { kernel: &kernels::CELLS_BC1, cases: cells::bc1 },
    Row { kernel: &kernels::CELLS_BC7, cases: cells::bc7 },
    Row { kernel: &kernels::CELLS_BC6H, cases: cells::bc6h },
    Row { kernel: &kernels::PLAN_RECORDS, cases: plans::records },
    Row { kernel: &kernels::PLAN_CELLS, cases: plans::cells },
    Row { kernel: &kernels::BC1, cases: blocks::bc1 },
    Row { kernel: &kernels::BC4, cases: blocks::bc4 },
    Row { kernel: &kernels::BC5, cases: blocks::bc5 },
    Row { kernel: &kernels::BC6H, cases: blocks::bc6h },
    Row { kernel: &kernels::BC7, cases: blocks::bc7 },
];

/// What came of a kernel.
#[derive(Debug, Clone, PartialEq)]
pub struct KernelReport {
    /// Name of the kernel.
    pub name: &'static str,
    /// Nodes, boxes, cells or blocks that it decoded.
    pub inputs: u64,
    /// Words that differ from the CPU's.
    pub mismatches: u64,
    /// The first of them, in words.
    pub first: Option<String>,
    /// Pixels written in a microsecond, without transfers.
    pub megapixels_per_second: f64,
}

/// Runs all cases of a kernel.
///
/// # Errors
/// The device refuses the work or is lost.
pub fn test_kernel(gpu: &Gpu, row: &Row, seed: u64) -> Result<KernelReport> {
    let cases = (row.cases)(seed);
    let mut report =
        KernelReport { name: row.kernel.name, inputs: 0, mismatches: 0, first: None, megapixels_per_second: 0.0 };
    for (at, case) in cases.iter().enumerate() {
        let timed = at + 1 == cases.len();
        let result = harness::run(gpu, row.kernel, case, if timed { CLOCK } else { Clock::Off })?;
        report.inputs += case.inputs;
        report.mismatches += result.mismatches;
        report.first = report.first.or(result.first);
        if timed {
            report.megapixels_per_second = case.pixels as f64 / 1e6 / result.seconds.max(1e-9);
        }
    }
    Ok(report)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::kernels::KERNELS;

    #[test]
    fn every_kernel_has_inputs_that_fit_its_bindings() {
        for kernel in KERNELS {
            let row = ROWS.iter().find(|row| row.kernel.name == kernel.name);
            let row = row.unwrap_or_else(|| panic!("{} has no inputs in selftest", kernel.name));
            let cases = (row.cases)(SEED);
            assert!(cases.len() > 1, "{}", kernel.name);
            for case in cases {
                assert_eq!(case.buffers.len(), kernel.bindings.len(), "{}: {}", kernel.name, case.label);
                assert!(!case.expected.is_empty() && case.inputs > 0, "{}: {}", kernel.name, case.label);
                for (at, _) in &case.expected {
                    assert!(kernel.bindings[*at].is_written(), "{}: {}", kernel.name, case.label);
                }
            }
        }
        assert_eq!(ROWS.len(), KERNELS.len());
    }
}
