//! Tests that need a graphics device; software Vulkan does. Without one they are reported as ignored.
//!
//! The environment variable `LIGHTFOLD_GPU` picks a device by its number or a part of its name.

use libtest_mimic::{Arguments, Failed, Trial};
use lightfold::gpu::selftest::{self, ROWS, SEED};
use lightfold::gpu::{Gpu, Pick, device};

fn pick() -> Pick {
    Pick::parse(&std::env::var("LIGHTFOLD_GPU").unwrap_or_default())
}

fn with_gpu(test: impl FnOnce(&Gpu) -> Result<(), Failed>) -> Result<(), Failed> {
    test(&Gpu::open(&pick()).map_err(|error| error.to_string())?)
}

fn kernel(row: &'static selftest::Row) -> Result<(), Failed> {
    with_gpu(|gpu| {
        let report = selftest::test_kernel(gpu, row, SEED).map_err(|error| error.to_string())?;
        match report.mismatches {
            0 if report.inputs > 0 => Ok(()),
            count => Err(format!("{count} words differ on {}: {:?}", gpu.info.name, report.first).into()),
        }
    })
}

fn main() {
    let arguments = Arguments::from_args();
    let none = device::list().is_empty();
    if none {
        eprintln!("no graphics device was found: tests of kernels are ignored");
    }
    let trials = ROWS.iter().map(|row| Trial::test(format!("kernel::{}", row.kernel.name), || kernel(row)));
    let trials = trials.map(|trial| trial.with_ignored_flag(none)).collect();
    libtest_mimic::run(&arguments, trials).exit();
}
