//! `lightfold pack IN… -o OUT`: joins containers, recompresses them, packs quadtrees at an error bound.

use std::path::PathBuf;

use crate::options::{BoundArgs, DepthStepArgs, EffortArgs, ModelArgs, OutputArgs, check_stdout};
use crate::output::{self, human_bytes};
use crate::progress::Progress;
use crate::{ExitStatus, GlobalArgs};
use codec::container::Reader;
use codec::error::{Result, counted};
use footage::files::OutputFile;
use footage::pack::{self, FlattenSettings, PackReport, PackSettings, Repack};

#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  lightfold pack px.lfold nx.lfold py.lfold ny.lfold pz.lfold nz.lfold -o probe.lfold\n  \
    lightfold pack film.lfold --lzma2=9 -o film-small.lfold\n  \
    lightfold pack px.tree.lfold --max-error 30 -o px.lfold\n\n\
    With --max-error, quadtrees of the intermediate form are packed. All other streams are copied.",
    mut_arg("optimize", |arg| arg.requires("max_error")),
    mut_arg("min_children", |arg| arg.requires("max_error")),
    mut_arg("depth_window", |arg| arg.requires("max_error")),
    mut_arg("update_threshold", |arg| arg.requires("max_error")),
    mut_arg("effort", |arg| arg.requires("max_error"))
)]
pub struct Args {
    /// Input containers, - for standard input
    #[arg(value_name = "IN.lfold", required = true)]
    pub inputs: Vec<PathBuf>,
    #[command(flatten)]
    pub output: OutputArgs,
    #[command(flatten)]
    pub effort: EffortArgs,
    #[command(flatten)]
    pub bound: BoundArgs,
    #[command(flatten)]
    pub model: ModelArgs,
    #[command(flatten)]
    pub steps: DepthStepArgs,
}

pub fn run(args: &Args, global: &GlobalArgs) -> Result<ExitStatus> {
    check_stdout(&args.output.path, args.output.store.json)?;
    let start = std::time::Instant::now();
    let inputs = args.inputs.iter().map(Reader::open).collect::<Result<Vec<_>>>()?;
    let repack = args.output.store.compression().map_or(Repack::Keep, Repack::As);
    let flatten = args.bound.max_error.map(|error| FlattenSettings {
        error,
        window: args.steps.depth_window,
        epsilon: args.steps.update_threshold.unwrap_or(0),
        decide: args.model.optimize,
        effort: args.effort.effort.unwrap_or_default(),
        min_children: args.model.min_children,
    });
    let settings = PackSettings { repack, flatten, memory: args.output.store.memory.get() };
    let chunks = inputs.iter().map(|reader| reader.index().chunks.len() as u64).sum();
    let progress = Progress::start(global, "packing", chunks)?;
    let path = &args.output.path;
    let file = OutputFile::create(path)?;
    let (mut file, summary) =
        pack::pack(&inputs, &settings, file, &progress).map_err(|error| output::name_output(error, path))?;
    file.commit()?;
    drop(progress);
    let input_bytes: u64 = inputs.iter().map(|reader| reader.file_bytes).sum();
    let report = PackReport { summary, input_bytes, seconds: start.elapsed().as_secs_f64() };
    global.report(args.output.store.json, &report, || {
        let (from, to) = (human_bytes(input_bytes), human_bytes(summary.bytes));
        let streams = counted(summary.streams, "stream");
        let gains_nothing = settings.repack != Repack::Keep && summary.bytes >= input_bytes;
        let words = if gains_nothing { ", no smaller" } else { "" };
        format!("{}: {streams}, {from} became {to}{words}", path.display())
    })?;
    Ok(ExitStatus::Passed)
}
