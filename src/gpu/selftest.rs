//! Runs every kernel on a device and compares it with its CPU counterpart: hard cases first, then random inputs.

mod blocks;
mod boxes;
mod cells;
pub mod drawings;
mod gathered;
pub mod highlights;
mod nodes;
pub mod pictures;
mod plans;
mod predictive;
mod rooms;
mod rows;
pub mod slices;
pub mod streams;
mod texels;
pub mod transform;
pub mod triangles;

use std::time::Duration;

use crate::Gpu;
use crate::harness::Case;
pub use crate::harness::KernelReport;
use codec::color::{HalfKey, KeyframeBlocks};
use codec::depth::block_tiles::Layout;
use codec::error::Result;
use kernels::Kernel;

use Inputs::Words;
use plans::Planned;

pub const SEED: u64 = 1;
const CLOCK: Duration = Duration::from_millis(200);

#[derive(Debug)]
pub struct Row {
    pub kernel: &'static Kernel,
    pub inputs: Inputs,
}

#[derive(Debug)]
pub enum Inputs {
    /// Creates cases of input and expected words from a seed. The last case is timed.
    Words(fn(u64) -> Vec<Case>),
    /// Light fields and cameras; the device's pictures must agree with the CPU's within tolerances.
    Pictures,
    /// Views with highlights, which must agree with the CPU's within the same tolerances; without highlights all bits must be
    /// equal.
    Highlights,
}

pub static ROWS: &[Row] = &[
    Row { kernel: &kernels::NODES, inputs: Words(nodes::cases) },
    Row { kernel: &kernels::BOXES_CODES, inputs: Words(|seed| boxes::cases::<u16>(Layout::Values, seed)) },
    Row { kernel: &kernels::BOXES_MATERIAL, inputs: Words(|seed| boxes::cases::<[u8; 3]>(Layout::Values, seed)) },
    Row { kernel: &kernels::CELLS_8BIT, inputs: Words(cells::bytes) },
    Row { kernel: &kernels::CELLS_HALF, inputs: Words(cells::halves) },
    Row { kernel: &kernels::BOXES_BC5, inputs: Words(|seed| boxes::cases::<u16>(Layout::BlockTiles, seed)) },
    Row { kernel: &kernels::BOXES_BC1, inputs: Words(|seed| boxes::cases::<[u8; 3]>(Layout::BlockTiles, seed)) },
    Row { kernel: &kernels::CELLS_BC1, inputs: Words(|seed| cells::random_cases(seed, Some(KeyframeBlocks::BC1))) },
    Row { kernel: &kernels::CELLS_BC7, inputs: Words(|seed| cells::random_cases(seed, Some(KeyframeBlocks::BC7))) },
    Row { kernel: &kernels::CELLS_BC6H, inputs: Words(|seed| cells::random_cases(seed, Some(KeyframeBlocks::BC6H))) },
    Row { kernel: &kernels::TRANSFORM_8BIT, inputs: Words(transform::cases::<u8>) },
    Row { kernel: &kernels::TRANSFORM_HALF, inputs: Words(transform::cases::<HalfKey>) },
    Row { kernel: &kernels::PLAN_RECORDS, inputs: Words(|seed| plans::cases(seed, Planned::push_records)) },
    Row { kernel: &kernels::PLAN_CELLS, inputs: Words(|seed| plans::cases(seed, Planned::push_cell)) },
    Row { kernel: &kernels::BC1, inputs: Words(blocks::bc1) },
    Row { kernel: &kernels::BC4, inputs: Words(blocks::bc4) },
    Row { kernel: &kernels::BC5, inputs: Words(blocks::bc5) },
    Row { kernel: &kernels::BC6H, inputs: Words(blocks::bc6h) },
    Row { kernel: &kernels::BC7, inputs: Words(blocks::bc7) },
    Row { kernel: &kernels::TEXELS, inputs: Words(texels::depths) },
    Row { kernel: &kernels::SQUARES, inputs: Words(texels::squares) },
    Row { kernel: &kernels::RENDER, inputs: Inputs::Pictures },
    Row { kernel: &kernels::RENDER_PYRAMID, inputs: Inputs::Pictures },
    Row { kernel: &kernels::RENDER_EFFECTS, inputs: Inputs::Pictures },
    Row { kernel: &kernels::SLICES, inputs: Words(slices::winners) },
    Row { kernel: &kernels::LINE_LIGHT, inputs: Words(slices::light) },
    Row { kernel: &kernels::LINE_HIGHLIGHTS, inputs: Inputs::Highlights },
    Row { kernel: &kernels::ACTIVE_COUNTS, inputs: Words(rows::active_counts) },
    Row { kernel: &kernels::COMPACT, inputs: Words(rows::compacted) },
    Row { kernel: &kernels::EROSION_EDGES, inputs: Words(rows::erosion_edges) },
    Row { kernel: &kernels::EROSION, inputs: Words(rows::erosion) },
];

pub fn test_kernel(gpu: &Gpu, row: &Row, seed: u64) -> Result<KernelReport> {
    let cases = match row.inputs {
        Words(cases) => cases(seed),
        Inputs::Pictures => return pictures::test(gpu, row.kernel),
        Inputs::Highlights => return highlights::test(gpu, row.kernel.name),
    };
    let mut report = KernelReport::new(row.kernel.name);
    for (at, case) in cases.iter().enumerate() {
        let clock = (at + 1 == cases.len()).then_some(CLOCK);
        report.run(gpu, row.kernel, case, clock)?;
    }
    Ok(report)
}

#[cfg(test)]
mod tests {
    use super::*;
    use kernels::{Binding, KERNELS};

    #[test]
    fn every_kernel_has_inputs_that_fit_its_bindings() {
        let readers: Vec<&Kernel> = KERNELS.iter().filter_map(|kernel| kernel.reader).collect();
        for kernel in KERNELS.into_iter().filter(|kernel| !readers.contains(kernel)) {
            let row = ROWS.iter().find(|row| row.kernel.name == kernel.name);
            let row = row.unwrap_or_else(|| panic!("{} has no inputs in selftest", kernel.name));
            let Words(cases) = row.inputs else { continue };
            let cases = cases(SEED);
            assert!(cases.len() > 1, "{}", kernel.name);
            for case in cases {
                let has_words = kernel.bindings.iter().all(|binding| case.buffers.contains_key(binding.name));
                assert!(has_words && case.inputs > 0, "{}: {}", kernel.name, case.label);
                // Scratch memory is not an output.
                let is_output = |binding: &&Binding| binding.is_written() && binding.name != "scratch";
                let written = kernel.bindings.iter().filter(is_output).map(|binding| binding.name);
                let expected = case.expected.iter().map(|(name, _)| *name);
                assert!(written.eq(expected), "{}: {}", kernel.name, case.label);
            }
        }
        assert_eq!(ROWS.len() + readers.len(), KERNELS.len());
    }
}
