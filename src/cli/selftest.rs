//! `lightfold selftest`: whether this machine's graphics devices decode what its CPU decodes.

use serde_json::json;

use crate::cli::device::{self, GpuArgs};
use crate::cli::output;
use crate::cli::progress::Progress;
use crate::cli::{GlobalArgs, Outcome};
use crate::error::{Error, Result};
use crate::gpu::device::{DeviceInfo, Gpu, Pick, list};
use crate::gpu::selftest::hard_cases::{HardCaseReport, test_hard_cases};
use crate::gpu::selftest::streams::{StreamsReport, test_streams};
use crate::gpu::selftest::{KernelReport, ROWS, SEED, test_kernel};
use crate::monitor::Monitor;
use crate::report::table::{Column, Table};

/// Arguments.
#[derive(Debug, clap::Args)]
#[command(after_help = "Exit code 1 where a word differs, 2 where there is no graphics device.\n\nExamples:\n  \
    lightfold selftest\n  lightfold selftest --list-devices\n  \
    lightfold selftest --streams 10000 --seed 7 --json")]
pub struct Args {
    /// Random streams of all codecs that both decoders show, in any order of frames
    #[arg(long, value_name = "N", default_value_t = 500)]
    pub streams: u64,
    /// Other random inputs
    #[arg(long, value_name = "N", default_value_t = SEED)]
    pub seed: u64,
    /// Device; without an option, all of them are tested.
    #[command(flatten)]
    pub gpu: GpuArgs,
    /// Report as JSON
    #[arg(long)]
    pub json: bool,
}

/// What came of a device.
struct Tested {
    info: DeviceInfo,
    kernels: Vec<KernelReport>,
    hard_cases: Vec<HardCaseReport>,
    streams: StreamsReport,
}

impl Tested {
    fn failed(&self) -> bool {
        self.kernels.iter().any(|kernel| kernel.mismatches > 0)
            || self.hard_cases.iter().any(|case| !case.passed())
            || self.streams.verification.mismatched_words > 0
    }
}

/// Tests.
pub fn run(args: &Args, global: &GlobalArgs) -> Result<Outcome> {
    if args.gpu.list_devices {
        return device::list(args.json);
    }
    let picks = match args.gpu.pick() {
        Pick::Best => list().iter().map(|info| Pick::Index(info.index)).collect(),
        pick => vec![pick],
    };
    if picks.is_empty() {
        return Err(Error::unsupported("no graphics device was found: install a Vulkan driver to test one"));
    }
    let mut all = Vec::new();
    for pick in &picks {
        let gpu = Gpu::open(pick)?;
        let progress = Progress::start(global, "testing", ROWS.len() as u64 + args.streams)?;
        let kernel = |row| {
            progress.check()?;
            progress.advance(1);
            test_kernel(&gpu, row, args.seed)
        };
        let kernels = ROWS.iter().map(kernel).collect::<Result<Vec<_>>>()?;
        let hard_cases = test_hard_cases(&gpu, &progress)?;
        let streams = test_streams(&gpu, args.streams, args.seed, &progress)?;
        all.push(Tested { info: gpu.info.clone(), kernels, hard_cases, streams });
    }
    let failed = all.iter().any(Tested::failed);
    if args.json {
        print_json(&all, failed)?
    } else {
        output::print_text(&text(&all))?
    }
    Ok(if failed { Outcome::Differs } else { Outcome::Fine })
}

fn print_json(all: &[Tested], failed: bool) -> Result<()> {
    let kernel = |tested: &Tested, kernel: &KernelReport| {
        json!({
            "name": kernel.name,
            "device": tested.info.name,
            "inputs": kernel.inputs,
            "mismatches": kernel.mismatches,
            "first_mismatch": kernel.first,
            "megapixels_per_second": kernel.megapixels_per_second,
        })
    };
    let hard_case = |tested: &Tested, case: &HardCaseReport| {
        json!({
            "name": case.name,
            "device": tested.info.name,
            "bound": case.bound,
            "measured": case.measured,
            "mismatched_words": case.mismatched_words,
            "passed": case.passed(),
        })
    };
    let streams = |tested: &Tested| {
        json!({
            "device": tested.info.name,
            "streams": tested.streams.streams,
            "images": tested.streams.images,
            "mismatched_words": tested.streams.verification.mismatched_words,
            "first_mismatch": tested.streams.verification.first,
        })
    };
    output::print_json(&json!({
        "devices": all.iter().map(|tested| device::to_json(&tested.info)).collect::<Vec<_>>(),
        "kernels": all.iter().flat_map(|t| t.kernels.iter().map(move |k| kernel(t, k))).collect::<Vec<_>>(),
        "hard_cases": all.iter().flat_map(|t| t.hard_cases.iter().map(move |c| hard_case(t, c))).collect::<Vec<_>>(),
        "streams": all.iter().map(streams).collect::<Vec<_>>(),
        "failed": failed,
    }))
}

fn text(all: &[Tested]) -> String {
    let mut out = String::new();
    for Tested { info, kernels, hard_cases, streams } in all {
        out += &format!("{} ({}, {}, {})\n\n", info.name, info.kind, info.backend, info.driver);
        let mut table = Table::new(&[
            Column::Left("Kernel"),
            Column::Right("Inputs"),
            Column::Right("Mismatches"),
            Column::Right("Mpixel/s"),
        ]);
        for kernel in kernels {
            let speed = format!("{:.0}", kernel.megapixels_per_second);
            table.row([kernel.name.to_owned(), kernel.inputs.to_string(), kernel.mismatches.to_string(), speed]);
        }
        let words = streams.verification.mismatched_words;
        let worst = hard_cases.iter().map(|case| case.measured).max().unwrap_or(0);
        let failed = hard_cases.iter().filter(|case| !case.passed());
        let count = failed.clone().count();
        out += &format!("{table}\n{} hard cases, {count} failed, {worst} codes off at most\n", hard_cases.len());
        out += &format!("{} streams, {} images, {words} words differ\n", streams.streams, streams.images);
        failed.for_each(|case| out += &format!("failed: {case:?}\n"));
        let first = kernels.iter().filter_map(|kernel| Some(format!("{}: {}", kernel.name, kernel.first.as_ref()?)));
        for line in first.chain(streams.verification.first.clone()) {
            out += &format!("first: {line}\n");
        }
    }
    out
}
