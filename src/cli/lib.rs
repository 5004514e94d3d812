//! The command-line program: one file per command. Only this module prints, reads arguments and chooses exit codes.

// Tests write their inputs with `std::fs` (`clippy.toml`).
#![cfg_attr(test, allow(clippy::disallowed_methods))]

mod bc4w;
mod cameras;
mod capture;
mod child;
mod command_line;
mod completions;
mod damage;
mod decode;
mod demo;
mod depth_bound;
pub mod device;
mod diff;
mod diff_text;
mod encode;
mod encode_advice;
mod encode_color;
mod encode_depth;
mod failure;
mod film;
pub mod freed_memory;
mod global;
mod init;
mod inspect;
mod interpolate;
mod look;
pub mod man;
mod mistyped;
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
pub mod report;
mod scan;
mod schema;
mod selftest;
pub mod serve;
mod short_help;
mod simplify;
mod tradeoff;
mod train;
mod unfinished_folder;
mod view;

use std::ffi::OsString;
use std::process::ExitCode;

use clap::FromArgMatches;

use codec::color::transform::Transform;
use codec::depth::predictive::Predictive;
use codec::error::{Error, Result};

pub use command_line::{Cli, Command, command};
use failure::Failure;
use global::{EXIT_BROKEN_PIPE, EXIT_FAILED, exit_code};
pub use global::{EXIT_INTERRUPTED, ExitStatus, GlobalArgs, refuse};

/// Runs a command line and returns the exit code of the process.
pub fn run(arguments: impl IntoIterator<Item = OsString>) -> ExitCode {
    child::end_with_parent();
    hide_guarded_panics();
    let arguments: Vec<OsString> = arguments.into_iter().collect();
    let as_json = arguments.iter().any(|word| word == "--json");
    let cli = match parse(&arguments) {
        Ok(cli) => cli,
        Err(error) => return not_parsed(&error, as_json),
    };
    let (cli, outputs) = cli;
    match outputs.and_then(|()| execute(cli)) {
        Ok(ExitStatus::Passed) => ExitCode::SUCCESS,
        Ok(ExitStatus::Failed) => ExitCode::from(EXIT_FAILED),
        Err(error) => {
            let error = mistyped::judge(error, &arguments);
            let code = exit_code(&error);
            // If the reader closed standard output, no message is printed.
            if code != EXIT_BROKEN_PIPE {
                output::note(format_args!("lightfold: {error}"));
                if as_json {
                    Failure::of(&error).print();
                }
            }
            ExitCode::from(code)
        }
    }
}

/// Suppresses the panic message of panics that are caught and turned into errors.
fn hide_guarded_panics() {
    let print = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |panic| {
        if !footage::guard::is_guarded() {
            print(panic);
        }
    }));
}

/// Parses the command line, and checks that its outputs can be written.
fn parse(arguments: &[OsString]) -> Result<(Cli, Result<()>), clap::Error> {
    let matches = short_help::with_short_help(command()).try_get_matches_from(arguments)?;
    let mut cli = Cli::from_arg_matches(&matches)?;
    cli.global.has_result_on_stdout = command_line::has_result_on_stdout(&matches);
    Ok((cli, command_line::check_outputs(&matches)))
}

/// Prints help, version or the error in the arguments.
fn not_parsed(error: &clap::Error, as_json: bool) -> ExitCode {
    // Clap knows which of these are errors, and prints the others to standard output.
    let code = match error.print() {
        Err(broken) if !error.use_stderr() => exit_code(&Error::io("-", broken)),
        _ => error.exit_code() as u8,
    };
    if as_json && error.use_stderr() {
        let text = error.to_string();
        let message = text.split("\n\n").next().unwrap_or_default().trim().trim_start_matches("error: ").to_owned();
        Failure::new(message, code, None).print();
    }
    ExitCode::from(code)
}

fn execute(cli: Cli) -> Result<ExitStatus> {
    if let Some(threads) = cli.global.threads {
        rayon::ThreadPoolBuilder::new()
            .num_threads(threads.into())
            .build_global()
            .map_err(|error| Error::Usage(format!("cannot start {threads} threads: {error}")))?;
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
        Command::Cameras(args) => cameras::run(&args, global),
        Command::Quilt(args) => quilt::run(&args, global),
        Command::Simplify(args) => simplify::run(&args, global),
        Command::Interpolate(args) => interpolate::run(&args, global),
        Command::View(args) => view::run(&args, global),
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
