//! Options, exit codes and messages of every command.

use serde::Serialize;

use crate::cli::output;
use crate::error::{Error, Result};

#[derive(Debug, Clone, clap::Args)]
pub struct GlobalArgs {
    /// Number of threads; the result does not depend on it [default: one per processor]
    #[arg(long, global = true, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Print results and errors only
    #[arg(long, short, global = true)]
    pub quiet: bool,
}

impl GlobalArgs {
    /// Prints a line on standard error, unless `--quiet`.
    pub fn note(&self, line: impl std::fmt::Display) {
        if !self.quiet {
            output::note(line);
        }
    }

    /// Prints what a command has done: on standard output as JSON, or as a note.
    pub fn report(&self, as_json: bool, report: impl Serialize, text: impl FnOnce() -> String) -> Result<()> {
        if as_json {
            return output::print_json(&output::with_memory(report));
        }
        self.note(text());
        Ok(())
    }
}

/// The error of contradicting or missing options.
pub fn refuse<T>(message: impl Into<String>) -> Result<T> {
    Err(Error::Usage(message.into()))
}

/// Exit code of a command whose check failed ([`ExitStatus::Failed`]).
pub const EXIT_FAILED: u8 = 1;
pub const EXIT_BAD_INPUT: u8 = 2;
/// Exit code after SIGINT, as shells expect it (128 + 2).
pub const EXIT_INTERRUPTED: u8 = 130;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ExitStatus {
    Passed,
    /// A bound is exceeded, devices disagree, or a manifest is suspect.
    Failed,
}

pub fn exit_code(error: &Error) -> u8 {
    match error {
        Error::Interrupted => EXIT_INTERRUPTED,
        Error::Unfinished { cause, .. } => exit_code(cause),
        _ => EXIT_BAD_INPUT,
    }
}
