//! Tests that need a graphics device; software Vulkan does. Without one they are reported as ignored.
//!
//! The environment variable `LIGHTFOLD_GPU` picks a device by its number or a part of its name.

use std::path::Path;

use libtest_mimic::{Arguments, Failed, Trial};
use lightfold::gpu::selftest::{self, ROWS, SEED, streams};
use lightfold::gpu::{Gpu, Pick, device, verify};
use lightfold::monitor::Silent;
use lightfold::video::decode::Decoder;
use lightfold::video::export::Selection;

/// Random streams that are decoded; `lightfold selftest --streams` takes more.
const STREAMS: u64 = 400;

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

fn random_streams() -> Result<(), Failed> {
    with_gpu(|gpu| {
        let report = streams::test_streams(gpu, STREAMS, SEED, &Silent).map_err(|error| error.to_string())?;
        match report.verification.mismatched_words {
            0 if report.streams >= STREAMS && report.images > report.streams => Ok(()),
            count => Err(format!("{count} words differ on {}: {report:?}", gpu.info.name).into()),
        }
    })
}

/// Frozen containers, all their frames in order.
fn vectors() -> Result<(), Failed> {
    with_gpu(|gpu| {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/vectors/valid");
        let mut count = 0;
        for entry in std::fs::read_dir(folder)? {
            let path = entry?.path();
            if path.extension().is_none_or(|extension| extension != "lfold") {
                continue;
            }
            let decoder = Decoder::open(&path).map_err(|error| error.to_string())?;
            let Ok(chosen) = Selection::default().choose(&decoder) else { continue };
            let (_, found) = verify::verify(gpu, &decoder, &chosen, &Silent).map_err(|error| error.to_string())?;
            if found.mismatched_words > 0 {
                return Err(format!("{}: {found:?}", path.display()).into());
            }
            count += 1;
        }
        if count > 20 { Ok(()) } else { Err(format!("only {count} vectors were found").into()) }
    })
}

fn main() {
    let arguments = Arguments::from_args();
    let none = device::list().is_empty();
    if none {
        eprintln!("no graphics device was found: tests of kernels are ignored");
    }
    let trials = ROWS.iter().map(|row| Trial::test(format!("kernel::{}", row.kernel.name), || kernel(row)));
    let others = [Trial::test("random_streams", random_streams), Trial::test("vectors", vectors)];
    let trials = trials.chain(others).map(|trial| trial.with_ignored_flag(none)).collect();
    libtest_mimic::run(&arguments, trials).exit();
}
