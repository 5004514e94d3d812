//! Options, exit codes and messages common to all commands.

use std::io::ErrorKind;

use serde::Serialize;

use crate::options::{Choices, one_of};
use crate::output;
use codec::error::{Error, Result};

/// Form of progress output.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum ProgressForm {
    #[default]
    Auto,
    Json,
    OpenJd,
    None,
}

const PROGRESS_FORMS: &Choices<ProgressForm> = &[
    ("auto", ProgressForm::Auto, "A bar on a terminal, nothing in a pipe"),
    ("json", ProgressForm::Json, "JSON on standard error: one object per line, at most two per second"),
    (
        "openjd",
        ProgressForm::OpenJd,
        "Open Job Description messages on standard output, or on standard error if the result goes to standard output",
    ),
    ("none", ProgressForm::None, "No progress"),
];

#[derive(Debug, Clone, Default, clap::Args)]
pub struct GlobalArgs {
    /// Number of threads; results do not depend on it [default: one per processor]
    #[arg(long, global = true, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Print results and errors only
    #[arg(long, short, global = true)]
    pub quiet: bool,
    /// Form of the progress display
    #[arg(long, global = true, value_name = "FORM", value_parser = one_of(PROGRESS_FORMS), default_value = "auto")]
    pub progress: ProgressForm,
    /// Whether standard output carries the result, so that progress must not.
    #[arg(skip)]
    pub has_result_on_stdout: bool,
}

impl GlobalArgs {
    /// Prints a line on standard error, unless `--quiet`.
    pub fn note(&self, line: impl std::fmt::Display) {
        if !self.quiet {
            output::note(line);
        }
    }

    /// Reports the result of a command: on standard output as JSON, or as a note.
    pub fn report(&self, as_json: bool, report: impl Serialize, text: impl FnOnce() -> String) -> Result<()> {
        if as_json {
            return output::print_json(&output::with_memory(report));
        }
        self.note(text());
        Ok(())
    }
}

/// Returns the error for contradicting or missing options.
pub fn refuse<T>(message: impl Into<String>) -> Result<T> {
    Err(Error::Usage(message.into()))
}

/// Exit code of a command whose check failed ([`ExitStatus::Failed`]).
pub const EXIT_FAILED: u8 = 1;
/// Exit code for invalid input or options: the same command would fail again.
pub const EXIT_BAD_INPUT: u8 = 2;
/// Exit code for failures after which the same command may succeed later; EX_TEMPFAIL of sysexits.h.
pub const EXIT_RETRY: u8 = 75;
/// Exit code after SIGINT, as shells expect it (128 + 2).
pub const EXIT_INTERRUPTED: u8 = 130;
/// Exit code if the reader of standard output has closed it, as shells expect it (128 + 13, SIGPIPE).
pub const EXIT_BROKEN_PIPE: u8 = 141;

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
        Error::Io { source, .. } => code_of_kind(source.kind()),
        Error::Invalid { .. } | Error::Unsupported { .. } | Error::Usage(_) => EXIT_BAD_INPUT,
    }
}

/// System errors that the same command would hit again are bad input. All others may be temporary: a missing image, a
/// full disk, a lost mount, a lock. Many of these have no name in [`ErrorKind`].
fn code_of_kind(kind: ErrorKind) -> u8 {
    use ErrorKind::{
        AlreadyExists, CrossesDevices, DirectoryNotEmpty, FileTooLarge, InvalidData, InvalidFilename, InvalidInput,
        IsADirectory, NotADirectory, NotSeekable, Other, PermissionDenied, ReadOnlyFilesystem, TooManyLinks,
        UnexpectedEof, Unsupported,
    };
    match kind {
        ErrorKind::BrokenPipe => EXIT_BROKEN_PIPE,
        AlreadyExists | CrossesDevices | DirectoryNotEmpty | FileTooLarge | InvalidData | InvalidFilename
        | InvalidInput | IsADirectory | NotADirectory | NotSeekable | Other | PermissionDenied | ReadOnlyFilesystem
        | TooManyLinks | UnexpectedEof | Unsupported => EXIT_BAD_INPUT,
        _ => EXIT_RETRY,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_say_what_may_be_tried_again() {
        let code = |error: std::io::Error| exit_code(&Error::io("a", error));
        for kind in [ErrorKind::NotFound, ErrorKind::StorageFull, ErrorKind::ResourceBusy, ErrorKind::TimedOut] {
            assert_eq!(code(kind.into()), EXIT_RETRY, "{kind}");
        }
        // EIO, as from a lost mount.
        assert_eq!(code(std::io::Error::from_raw_os_error(5)), EXIT_RETRY);
        for kind in [ErrorKind::PermissionDenied, ErrorKind::UnexpectedEof, ErrorKind::IsADirectory] {
            assert_eq!(code(kind.into()), EXIT_BAD_INPUT, "{kind}");
        }
        let full = Error::io("a", ErrorKind::StorageFull.into()).context("frame 7");
        let stopped = Error::Unfinished { cause: Box::new(full), safe: String::new() };
        assert_eq!(exit_code(&stopped), EXIT_RETRY);
        assert_eq!(exit_code(&Error::Usage(String::new())), EXIT_BAD_INPUT);
    }
}
