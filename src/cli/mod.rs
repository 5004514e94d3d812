//! The program: one file for each command. Only this module prints, reads arguments and chooses exit codes.

mod bc4w;
mod capture;
mod command_line;
mod completions;
mod damage;
mod decode;
mod demo;
pub mod device;
mod diff;
mod diff_text;
mod encode;
mod encode_advice;
mod encode_color;
mod encode_depth;
mod global;
mod init;
mod inspect;
mod interpolate;
pub mod man;
mod options;
mod output;
mod outputs;
mod pack;
mod picture_files;
mod place;
mod progress;
mod quadtree;
mod quilt;
mod render;
mod scan;
mod schema;
mod selftest;
mod simplify;
mod tradeoff;
mod train;
mod unfinished_folder;

use std::ffi::OsString;
use std::io::ErrorKind;
use std::process::ExitCode;

use clap::Parser;

use crate::color::transform::tables::Transform;
use crate::depth::predictive::tables::Predictive;
use crate::error::{Error, Result};

pub use command_line::{Cli, Command, command};
use global::{EXIT_FAILED, exit_code};
pub use global::{EXIT_INTERRUPTED, ExitStatus, GlobalArgs, refuse};

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
        // The reader of our output has closed it.
        Err(Error::Io { source, .. }) if source.kind() == ErrorKind::BrokenPipe => ExitCode::SUCCESS,
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
        Command::Init(args) => init::run(&args, global),
        Command::Encode(args) => encode::run(&args, global),
        Command::Scan(args) => scan::run(&args, global),
        Command::EncodeColor(args) => encode::run_on(&args, global),
        Command::EncodeDepth(args) => encode::run_on(&args, global),
        Command::Quadtree(args) => encode::run_on(&args, global),
        Command::Bc4w(args) => bc4w::run(&args, global),
        Command::Pack(args) => pack::run(&args, global),
        Command::Inspect(args) => inspect::run(&args, global),
        Command::Decode(args) => decode::run(&args, global),
        Command::Render(args) => render::run(&args, global),
        Command::Quilt(args) => quilt::run(&args, global),
        Command::Simplify(args) => simplify::run(&args, global),
        Command::Interpolate(args) => interpolate::run(&args, global),
        Command::Diff(args) => diff::run(&args, global),
        Command::Tradeoff(args) => tradeoff::run(&args, global),
        Command::TrainColor(args) => train::run::<Transform>(&args, global),
        Command::TrainDepth(args) => train::run::<Predictive>(&args, global),
        Command::Selftest(args) => selftest::run(&args, global),
        Command::Schema(args) => schema::run(&args),
        Command::Completions(args) => completions::run(&args, command()),
        Command::Man(args) => man::run(&args, command()),
    }
}
