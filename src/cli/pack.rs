//! `lightfold pack IN… -o OUT`: several containers into one, recompressed where asked.

use std::path::PathBuf;

use serde_json::json;

use crate::cli::options::OutputArgs;
use crate::cli::output::{self, OutputFile, human_bytes};
use crate::cli::progress::Progress;
use crate::cli::{GlobalArgs, Outcome};
use crate::container::Reader;
use crate::error::Result;
use crate::video::pack::{self, Repack};

/// Arguments.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  lightfold pack px.lfold nx.lfold py.lfold ny.lfold pz.lfold nz.lfold -o probe.lfold\n  \
    lightfold pack film.lfold --lzma2=9 -o film-small.lfold"
)]
pub struct Args {
    /// The containers, - for standard input
    #[arg(value_name = "IN.lfold", required = true)]
    pub inputs: Vec<PathBuf>,
    /// Output.
    #[command(flatten)]
    pub output: OutputArgs,
    /// Undo LZMA2 instead
    #[arg(long, conflicts_with = "lzma2")]
    pub no_lzma2: bool,
}

/// Packs.
pub fn run(args: &Args, global: &GlobalArgs) -> Result<Outcome> {
    args.output.check()?;
    let start = std::time::Instant::now();
    let inputs = args.inputs.iter().map(Reader::open).collect::<Result<Vec<_>>>()?;
    let repack = match args.output.lzma2 {
        Some(level) => Repack::Lzma2(level),
        None if args.no_lzma2 => Repack::Raw,
        None => Repack::Keep,
    };
    let chunks = inputs.iter().map(|reader| reader.index().chunks.len() as u64).sum();
    let progress = Progress::start(global, "packing", chunks)?;
    let file = OutputFile::create(&args.output.path)?;
    let (file, bytes) =
        pack::pack(&inputs, repack, file, &progress).map_err(|error| output::name_output(error, &args.output.path))?;
    file.commit()?;
    drop(progress);
    let streams: usize = inputs.iter().map(|reader| reader.index().streams.len()).sum();
    let input_bytes: u64 = inputs.iter().map(Reader::file_bytes).sum();
    if args.output.json {
        let seconds = start.elapsed().as_secs_f64();
        output::print_json(&json!({
            "seconds": seconds, "bytes": bytes, "input_bytes": input_bytes, "streams": streams, "chunks": chunks,
        }))?;
    } else if !global.quiet {
        let (from, to) = (human_bytes(input_bytes), human_bytes(bytes));
        output::note(format_args!("{}: {streams} streams, {from} became {to}", args.output.path.display()));
    }
    Ok(Outcome::Fine)
}
