//! `lightfold train-color IN… -o TABLES` and `train-depth`: train the entropy tables of the transform codec and of
//! predictive depth on containers.

use std::path::{Path, PathBuf};
use std::time::Instant;

use serde::Serialize;

use crate::options::{MemoryArgs, check_report};
use crate::output::{self, human_bytes};
use crate::progress::Progress;
use crate::{ExitStatus, GlobalArgs, refuse};
use codec::decode::Decoder;
use codec::entropy::tables::MAX_OWN;
use codec::error::{Result, counted};
use footage::train::{self, Footage, HeldOut, TrainSettings, TrainSummary, Trained, TrainedCodec};

pub const COLOR_HELP: &str = "Examples:\n  lightfold train-color kitchen.lfold hall.lfold -o house.txt\n  \
    lightfold encode garden/lightfield.json --color-tables house.txt -o garden.lfold\n  \
    lightfold train-color kitchen.lfold -o - --sets 4\n\n\
    Tables suit footage of the same kind, noise and quality; other footage may not become smaller. A container stores \
    them once, in about 1.3 kB, and each cell uses the set that makes it smallest, trained or built in. Containers \
    with trained tables can be used for training.";

pub const DEPTH_HELP: &str = "Examples:\n  lightfold train-depth kitchen.lfold hall.lfold -o house.txt --sets 2\n  \
    lightfold encode garden/lightfield.json --depth-tables house.txt -o garden.lfold\n  \
    lightfold train-depth kitchen.lfold hall.lfold --held-out garden.lfold -o house.txt\n\n\
    A set suits footage of the same kind and error bound. A container stores the sets once per depth stream, in about \
    3 kB each, and each chunk uses the set that makes it smallest, trained or built in.";

#[derive(Debug, clap::Args)]
pub struct Args {
    /// Training containers with streams of this codec, - for standard input
    #[arg(value_name = "IN.lfold", required = true)]
    pub inputs: Vec<PathBuf>,
    /// Output tables as text, - for standard output
    #[arg(long, short, value_name = "TABLES")]
    pub output: PathBuf,
    /// Number of table sets; encode --color-tables uses one, --depth-tables all
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u8).range(1..=MAX_OWN as i64))]
    pub sets: u8,
    /// Container on which to measure the trained sets without the built-in ones; repeatable
    #[arg(long, value_name = "IN.lfold")]
    pub held_out: Vec<PathBuf>,
    /// Report as JSON
    #[arg(long)]
    pub json: bool,
    #[command(flatten)]
    pub memory: MemoryArgs,
}

#[derive(Serialize)]
struct Report {
    #[serde(flatten)]
    summary: TrainSummary,
    seconds: f64,
}

pub fn run<C: TrainedCodec>(args: &Args, global: &GlobalArgs) -> Result<ExitStatus> {
    check_report(&args.output, args.json)?;
    let start = Instant::now();
    if args.inputs.iter().chain(&args.held_out).any(|input| is_same_file(input, &args.output)) {
        return refuse(format!("{}: an input file would be overwritten", args.output.display()));
    }
    if let Some(path) = args.held_out.iter().find(|held| args.inputs.iter().any(|input| is_same_file(input, held))) {
        return refuse(format!(
            "--held-out {}: this container is also used for training: leave it out of one of both",
            path.display()
        ));
    }
    let open = |paths: &[PathBuf]| paths.iter().map(Decoder::open).collect::<Result<Vec<_>>>();
    let (inputs, held_out) = (open(&args.inputs)?, open(&args.held_out)?);
    let footage = Footage::find::<C>(&inputs)?;
    let held_out = (!held_out.is_empty()).then(|| Footage::find::<C>(&held_out)).transpose()?;
    let chunks = footage.chunk_count() + held_out.as_ref().map_or(0, Footage::chunk_count);
    let progress = Progress::start(global, "training", chunks)?;
    let settings = TrainSettings { sets: args.sets.into(), memory: args.memory.get() };
    let Trained { text, summary } = train::train::<C>(footage, held_out, settings, &progress)?;
    drop(progress);
    output::write_file(&args.output, &text)?;
    let report = Report { summary, seconds: start.elapsed().as_secs_f64() };
    global.report(args.json, &report, || words(&args.output, summary))?;
    Ok(ExitStatus::Passed)
}

fn is_same_file(one: &Path, other: &Path) -> bool {
    one.canonicalize().is_ok_and(|one| other.canonicalize().is_ok_and(|other| one == other))
}

fn words(path: &Path, summary: TrainSummary) -> String {
    let TrainSummary { payloads, symbols, sets, payload_bytes, trained_payload_bytes, table_bytes, held_out } = summary;
    let [before, after, stored] = [payload_bytes, trained_payload_bytes, table_bytes].map(human_bytes);
    let (sets, symbols) = (counted(sets as u64, "table set"), counted(symbols, "symbol"));
    let payloads = counted(payloads, "payload");
    let held_out = held_out.map_or(String::new(), |HeldOut { payloads, payload_bytes, trained_payload_bytes }| {
        let [before, after] = [payload_bytes, trained_payload_bytes].map(human_bytes);
        let payloads = counted(payloads, "held-out payload");
        format!("; {payloads} take {before}, with the trained sets alone about {after}")
    });
    format!(
        "{}: {sets} from {symbols} of {payloads}; these take {before}, with the trained tables about {after}, \
         and {stored} for the tables{held_out}",
        path.display()
    )
}
