//! Failures as JSON, under `--json`.

use serde::Serialize;

use crate::global::{EXIT_INTERRUPTED, EXIT_RETRY, exit_code};
use crate::output;
use codec::error::Error;

/// JSON document that is printed instead of a report.
#[derive(Debug, Serialize)]
pub struct Failure {
    error: FailureReport,
}

#[derive(Debug, Serialize)]
struct FailureReport {
    message: String,
    /// Exit code.
    code: u8,
    /// True if the same command may succeed later.
    retry: bool,
    file: Option<String>,
}

impl Failure {
    pub fn of(error: &Error) -> Failure {
        let file = error.file().map(|file| file.display().to_string());
        Failure::new(output::with_option_names(&error.to_string()), exit_code(error), file)
    }

    pub fn new(message: String, code: u8, file: Option<String>) -> Failure {
        let retry = matches!(code, EXIT_RETRY | EXIT_INTERRUPTED);
        Failure { error: FailureReport { message, code, retry, file } }
    }

    /// Prints the failure instead of the requested report, unless a report was printed already.
    pub fn print(&self) {
        if !output::has_reported() {
            // An error is ignored: the message is on standard error, and the exit code is set.
            let _ = output::print_json(self);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failure_names_the_file_and_whether_to_try_again() {
        let full = Error::io("a", std::io::ErrorKind::StorageFull.into()).context("frame 7");
        let stopped = Error::Unfinished { cause: Box::new(full), safe: "use `resume`".to_owned() };
        let failure = serde_json::to_value(Failure::of(&stopped)).unwrap();
        let failure = &failure["error"];
        assert_eq!((&failure["code"], &failure["retry"], &failure["file"]), (&75.into(), &true.into(), &"a".into()));
        assert!(failure["message"].as_str().unwrap().ends_with("use --resume"), "{failure}");
    }
}
