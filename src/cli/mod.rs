//! The command line: one file for each subcommand. Only this room prints, reads arguments and chooses exit codes.

pub mod bc4w;
pub mod capture;
pub mod completions;
mod damage;
pub mod decode;
pub mod demo;
pub mod device;
pub mod diff;
mod diff_text;
pub mod encode;
pub mod encode_color;
pub mod encode_depth;
pub mod inspect;
pub mod man;
pub mod options;
pub mod output;
pub mod pack;
pub mod place;
pub mod progress;
pub mod quadtree;
pub mod render;
pub mod selftest;
pub mod tradeoff;

use std::ffi::OsString;
use std::process::ExitCode;

use clap::{CommandFactory, Parser, Subcommand};

use crate::error::{Error, Result};

/// What every subcommand may be given.
#[derive(Debug, Clone, clap::Args)]
pub struct GlobalArgs {
    /// Threads to work with; the result does not depend on it [default: one for each processor]
    #[arg(long, global = true, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Print nothing but results and errors
    #[arg(long, short, global = true)]
    pub quiet: bool,
}

/// Codec toolkit for animated light fields: encodes, inspects, decodes and compares probes of colour and depth.
#[derive(Debug, Parser)]
#[command(
    name = "lightfold",
    version,
    propagate_version = true,
    max_term_width = 100,
    after_help = "Exit codes: 0 fine, 1 a bound given to diff is broken, devices disagree, inspect --check suspects\n\
        something, or no point of tradeoff meets what is asked, 2 bad input or usage, 130 interrupted.\n\n\
        Examples:\n  lightfold demo -o out/demo\n  lightfold encode lightfield.json -o film.lfold\n  \
        lightfold inspect film.lfold\n  lightfold decode film.lfold -o frames\n  \
        lightfold diff lightfield.json film.lfold --max-error 1 --min-psnr 50"
)]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
    /// Options of every subcommand.
    #[command(flatten)]
    pub global: GlobalArgs,
}

/// The subcommands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Capture, encode, decode and compare a built-in scene
    Demo(demo::Args),
    /// Find where cameras see a scene best, one after the other
    Place(place::Args),
    /// Capture a scene as a dataset: colour, depth, normals, materials
    Capture(capture::Args),
    /// Encode a dataset: all its streams into one container
    Encode(encode::Args),
    /// Encode one colour sequence
    EncodeColor(encode_color::Args),
    /// Encode one depth sequence
    EncodeDepth(encode_depth::Args),
    /// Build the quadtrees of one depth sequence, to be packed at any bound
    Quadtree(quadtree::Args),
    /// Encode one depth sequence as plain BC4w blocks at a fixed 4:1, and measure them
    Bc4w(bc4w::Args),
    /// Join containers into one, compress one further, or pack quadtrees at a bound
    Pack(pack::Args),
    /// Show what a container holds and what it costs, and verify it; check a dataset's conventions; show a scene's size
    Inspect(inspect::Args),
    /// Decode a container into image files, or into nothing to time it
    Decode(decode::Args),
    /// Render pictures of a light field from anywhere, and compare them with the truth
    Render(Box<render::Args>),
    /// Compare two of anything: containers, datasets, sequences
    Diff(diff::Args),
    /// Show what settings cost in bytes, time and quality on footage of your own
    Tradeoff(tradeoff::Args),
    /// Test graphics devices against the CPU, and hard cases against their bounds
    Selftest(selftest::Args),
    /// Print a completion script for a shell
    Completions(completions::Args),
    /// Write the man pages
    #[command(hide = true)]
    Man(man::Args),
}

/// Exit code of a command whose check failed ([`ExitStatus::Failed`]).
const EXIT_FAILED: u8 = 1;
/// Exit code for bad input, bad usage and I/O errors.
const EXIT_BAD_INPUT: u8 = 2;
/// Exit code after SIGINT, as shells expect it (128 + 2).
const EXIT_INTERRUPTED: u8 = 130;

/// Result of a command that ran to its end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ExitStatus {
    /// Everything checked is within its bounds.
    Passed,
    /// A bound is exceeded, devices disagree, or a manifest is suspect.
    Failed,
}

fn exit_code(error: &Error) -> u8 {
    match error {
        Error::Interrupted => EXIT_INTERRUPTED,
        Error::Unfinished { cause, .. } => exit_code(cause),
        _ => EXIT_BAD_INPUT,
    }
}

/// Runs a command line and answers the process's exit code.
pub fn run(arguments: impl IntoIterator<Item = OsString>) -> ExitCode {
    tradeoff::end_with_parent();
    let cli = match Cli::try_parse_from(arguments) {
        Ok(cli) => cli,
        Err(error) => {
            // Help and version are no errors and go to standard output; clap knows which.
            let _ = error.print();
            return ExitCode::from(error.exit_code() as u8);
        }
    };
    match execute(cli) {
        Ok(ExitStatus::Passed) => ExitCode::SUCCESS,
        Ok(ExitStatus::Failed) => ExitCode::from(EXIT_FAILED),
        Err(error) if output::is_broken_pipe(&error) => ExitCode::SUCCESS,
        Err(error) => {
            output::note(format_args!("lightfold: {error}"));
            ExitCode::from(exit_code(&error))
        }
    }
}

fn execute(cli: Cli) -> Result<ExitStatus> {
    if let Some(threads) = cli.global.threads {
        rayon::ThreadPoolBuilder::new()
            .num_threads(threads.into())
            .build_global()
            .map_err(|error| Error::Usage(format!("{threads} threads could not be started: {error}")))?;
    }
    let global = &cli.global;
    match cli.command {
        Command::Demo(args) => demo::run(&args, global),
        Command::Place(args) => place::run(&args, global),
        Command::Capture(args) => capture::run(&args, global),
        Command::Encode(args) => encode::run(&args, global),
        Command::EncodeColor(args) => encode_color::run(&args, global),
        Command::EncodeDepth(args) => encode_depth::run(&args, global),
        Command::Quadtree(args) => quadtree::run(&args, global),
        Command::Bc4w(args) => bc4w::run(&args, global),
        Command::Pack(args) => pack::run(&args, global),
        Command::Inspect(args) => inspect::run(&args, global),
        Command::Decode(args) => decode::run(&args, global),
        Command::Render(args) => render::run(&args, global),
        Command::Diff(args) => diff::run(&args, global),
        Command::Tradeoff(args) => tradeoff::run(&args, global),
        Command::Selftest(args) => selftest::run(&args, global),
        Command::Completions(args) => completions::run(&args),
        Command::Man(args) => man::run(&args),
    }
}

/// Replaces settings in backquotes, as messages of the library name them, by options: `` `depth_window` `` by
/// `--depth-window`.
fn with_option_names(message: &str) -> String {
    let command = Cli::command();
    let is_option = |name: &str| {
        let mut options = command.get_subcommands().flat_map(clap::Command::get_arguments);
        options.any(|option| option.get_long() == Some(name))
    };
    let mut text = String::new();
    let mut parts = message.split('`');
    text.push_str(parts.next().unwrap_or_default());
    while let Some(setting) = parts.next() {
        let name = setting.replace('_', "-");
        match parts.next() {
            Some(rest) if is_option(&name) => text += &format!("--{name}{rest}"),
            Some(rest) => text += &format!("`{setting}`{rest}"),
            None => text += &format!("`{setting}"),
        }
    }
    text
}

/// The whole command line, for man pages and completions.
pub fn command() -> clap::Command {
    Cli::command()
}
