//! `lightfold selftest`: compares graphics devices with the CPU, and hard cases with their error bounds.

use serde::Serialize;

use crate::device::{self, GpuArgs};
use crate::progress::Progress;
use crate::report::Table;
use crate::{ExitStatus, GlobalArgs, output};
use codec::error::{Error, Result, counted};
use codec::monitor::Monitor;
use gpu::device::{DeviceInfo, Gpu, Pick, list};
use gpu::selftest::drawings::test_drawing;
use gpu::selftest::streams::{StreamsReport, test_streams};
use gpu::selftest::{KernelReport, ROWS, SEED, test_kernel};
use kernels::DRAWINGS;
use verify::device::DeviceFigures;
use verify::{CaseReport, CaseRow, Family, FamilyReport, FamilyRow, Inputs, family_rows};

#[derive(Debug, clap::Args)]
#[command(after_help = "On software Vulkan a run takes several minutes; fewer --streams shorten it.\n\n\
    Exit code 1: a word differs or a hard case exceeds its bound; 2: no graphics device, unless --hard-cases.\n\n\
    Examples:\n  \
    lightfold selftest\n  lightfold selftest --hard-cases --json\n  lightfold selftest --list-devices\n  \
    lightfold selftest --streams 10000 --seed 7 --json")]
pub struct Args {
    /// Run only the hard cases, on the CPU and on graphics devices if there are any
    #[arg(long)]
    pub hard_cases: bool,
    /// Run only this family of hard cases; repeatable
    #[arg(long, value_name = "NAME", requires = "hard_cases", value_parser = Family::NAMES)]
    pub family: Vec<String>,
    /// Number of random streams to decode on CPU and device, in random frame order
    #[arg(long, value_name = "N", default_value_t = 500, conflicts_with = "hard_cases")]
    pub streams: u64,
    /// Seed of random inputs
    #[arg(long, value_name = "N", default_value_t = SEED, conflicts_with = "hard_cases")]
    pub seed: u64,
    #[command(flatten)]
    pub gpu: GpuArgs,
    /// Report as JSON
    #[arg(long)]
    pub json: bool,
}

struct Tested {
    info: DeviceInfo,
    kernels: Vec<KernelReport>,
    /// One entry per hard case.
    hard_cases: Vec<DeviceFigures>,
    streams: Option<StreamsReport>,
}

impl Tested {
    fn failed(&self) -> bool {
        self.kernels.iter().any(|kernel| kernel.mismatches > 0)
            || self.hard_cases.iter().any(|case| case.mismatched_words > 0)
            || self.streams.as_ref().is_some_and(|streams| streams.verification.mismatched_words > 0)
    }
}

pub fn run(args: &Args, global: &GlobalArgs) -> Result<ExitStatus> {
    if args.gpu.list_devices {
        return device::list(args.json);
    }
    let picks = match args.gpu.index.pick() {
        Pick::Best => list().iter().map(|info| Pick::Index(info.index)).collect(),
        pick => vec![pick],
    };
    if picks.is_empty() && !args.hard_cases {
        return Err(Error::unsupported("no graphics device was found: install a Vulkan driver to test one"));
    }
    let mut cases = verify::table();
    cases.retain(|case| args.family.is_empty() || args.family.iter().any(|name| name == case.family.name()));
    let progress = Progress::start(global, "hard cases", cases.len() as u64)?;
    let (cases, inputs): (Vec<CaseReport>, Vec<Inputs>) = verify::run_all(&cases, &progress)?.into_iter().unzip();
    drop(progress);
    let test = |pick| test_device(&Gpu::open(pick)?, args, &inputs, global);
    let all = picks.iter().map(test).collect::<Result<Vec<_>>>()?;
    let failed = all.iter().any(Tested::failed) || cases.iter().any(|case| !case.passed());
    output::print_either(args.json, &Document::new(&all, &cases, failed), || text(&all, &cases))?;
    Ok(if failed { ExitStatus::Failed } else { ExitStatus::Passed })
}

fn test_device(gpu: &Gpu, args: &Args, inputs: &[Inputs], global: &GlobalArgs) -> Result<Tested> {
    let count = inputs.iter().map(|inputs| inputs.clips.len()).sum::<usize>() as u64;
    let more = if args.hard_cases { 0 } else { (ROWS.len() + DRAWINGS.len()) as u64 + args.streams };
    let progress = Progress::start(global, "testing", count + more)?;
    let hard_cases = verify::device::compare(gpu, inputs, &progress)?;
    let (mut kernels, mut streams) = (Vec::new(), None);
    if !args.hard_cases {
        let kernel = |row| {
            progress.check()?;
            progress.advance(1);
            test_kernel(gpu, row, args.seed)
        };
        kernels = ROWS.iter().map(kernel).collect::<Result<Vec<_>>>()?;
        for drawing in DRAWINGS {
            progress.check()?;
            progress.advance(1);
            kernels.push(test_drawing(gpu, drawing)?);
        }
        streams = Some(test_streams(gpu, args.streams, args.seed, &progress)?);
    }
    Ok(Tested { info: gpu.info.clone(), kernels, hard_cases, streams })
}

#[derive(Serialize)]
struct Document<'a> {
    devices: Vec<&'a DeviceInfo>,
    kernels: Vec<OnDevice<'a, KernelReport>>,
    device_tested: bool,
    hard_cases: Vec<CaseRow<'a>>,
    families: Vec<FamilyReport<'a>>,
    notes: Vec<String>,
    streams: Vec<OnDevice<'a, StreamsReport>>,
    failed: bool,
}

#[derive(Serialize)]
struct OnDevice<'a, T> {
    device: &'a str,
    #[serde(flatten)]
    report: &'a T,
}

impl Tested {
    fn on_device<'a, T>(&'a self, report: &'a T) -> OnDevice<'a, T> {
        OnDevice { device: &self.info.name, report }
    }
}

impl<'a> Document<'a> {
    fn new(all: &'a [Tested], cases: &'a [CaseReport], failed: bool) -> Document<'a> {
        let mut hard_cases = Vec::new();
        for (at, case) in cases.iter().enumerate() {
            if case.streams + case.pictures == 0 || all.is_empty() {
                hard_cases.push(CaseRow::new(case, None, None));
            } else {
                let differ = |of: &Tested| of.hard_cases[at].mismatched_words;
                hard_cases.extend(all.iter().map(|of| CaseRow::new(case, Some(&of.info.name), Some(differ(of)))));
            }
        }
        let kernels = all.iter().flat_map(|tested| tested.kernels.iter().map(|kernel| tested.on_device(kernel)));
        let streams = all.iter().flat_map(|tested| tested.streams.iter().map(|report| tested.on_device(report)));
        Document {
            devices: all.iter().map(|tested| &tested.info).collect(),
            kernels: kernels.collect(),
            device_tested: !all.is_empty(),
            hard_cases,
            families: family_rows(cases).iter().map(FamilyRow::report).collect(),
            notes: verify::notes(cases),
            streams: streams.collect(),
            failed,
        }
    }
}

fn text(all: &[Tested], cases: &[CaseReport]) -> String {
    let mut table = Table::new("Family|Through|>Cases|Bound|>Worst|Unit");
    for row in family_rows(cases) {
        let worst = row.worst;
        let measured = verify::number(worst.measured);
        let cells = [worst.family.name().to_owned(), worst.pipeline.clone(), row.cases.to_string()];
        table.row(cells.into_iter().chain([worst.bound.to_string(), measured, worst.unit.to_owned()]));
    }
    let failed = cases.iter().filter(|case| !case.passed());
    let notes: String = verify::notes(cases).iter().map(|note| format!("{note}\n")).collect();
    let mut out = format!("{table}\n{notes}\n{} hard cases, {} failed\n", cases.len(), failed.clone().count());
    failed.for_each(|case| out += &format!("{}\n", case.sentence()));
    if all.is_empty() {
        out += "no graphics device was found: CPU results only\n";
    }
    all.iter().for_each(|tested| out += &device_text(tested, cases));
    out
}

fn device_text(tested: &Tested, cases: &[CaseReport]) -> String {
    let Tested { info, kernels, hard_cases, streams } = tested;
    let mut out = format!("\n{} ({}, {}, {})\n\n", info.name, info.kind, info.backend, info.driver);
    if !kernels.is_empty() {
        let mut table = Table::new("Kernel|>Inputs|>Mismatches|>Mpixel/s");
        for kernel in kernels {
            let speed = format!("{:.0}", kernel.megapixels_per_second);
            table.row([kernel.name.to_owned(), kernel.inputs.to_string(), kernel.mismatches.to_string(), speed]);
        }
        out += &format!("{table}\n");
    }
    let sum = |of: fn(&DeviceFigures) -> u64| hard_cases.iter().map(of).sum::<u64>();
    let (words, rendered) = (sum(|case| case.mismatched_words), sum(|case| case.rendered));
    let images = sum(|case| case.pictures) - rendered;
    let count = hard_cases.iter().filter(|case| case.pictures > case.rendered).count();
    out += &format!(
        "{} with streams, {}; {}; {words} words or pixels differ\n",
        counted(count as u64, "hard case"),
        counted(images, "image"),
        counted(rendered, "picture"),
    );
    for (case, figures) in cases.iter().zip(hard_cases).filter(|(_, figures)| figures.mismatched_words > 0) {
        let first = figures.first.as_deref().unwrap_or_default();
        out += &format!("differs: {} ({}), {} words, {first}\n", case.name, case.pipeline, figures.mismatched_words);
    }
    let first = kernels.iter().filter_map(|kernel| Some(format!("{}: {}", kernel.name, kernel.first.as_ref()?)));
    let mut firsts: Vec<String> = first.collect();
    if let Some(streams) = streams {
        let words = streams.verification.mismatched_words;
        let (count, images) = (counted(streams.streams, "stream"), counted(streams.images, "image"));
        out += &format!("{count}, {images}, {words} words differ\n");
        firsts.extend(streams.verification.first.clone());
    }
    firsts.iter().for_each(|line| out += &format!("first: {line}\n"));
    out
}
