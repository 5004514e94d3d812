//! Commands of this program, run as processes, and what a kind of sweep does with them.
//!
//! Each point is measured by commands that a user could type: the peak of memory is the point's own, a crash loses one
//! point, threads and device are options like any other, and the CSV names the command of each row. Starting a process
//! costs milliseconds and is not in any time: commands report their own.

use std::ffi::{OsStr, OsString};

use serde_json::Value;

use super::kind::{Measured, Point};
use crate::error::{Error, Result};

/// Runs command lines of this program. Implemented by the command line.
pub trait Runner {
    /// Runs a command and returns the JSON that it printed. An error names the command.
    fn run(&self, words: &[OsString]) -> Result<Value>;

    /// Seconds since the program began.
    fn now_seconds(&self) -> f64;
}

/// Measures the points of one kind of sweep.
pub trait Bench {
    /// Configuration hash of the input, the fixed options and the program.
    fn made_of(&self) -> u32 {
        0
    }

    /// The command that a user would give for a point.
    fn command(&self, point: &Point) -> String;

    /// Does what all points need, once.
    ///
    /// # Errors
    /// When a command fails.
    fn prepare(&mut self, runner: &dyn Runner) -> Result<()> {
        let _ = runner;
        Ok(())
    }

    /// Everything but times; the kind's `survey_runs` are included. Serves as warm-up, too.
    ///
    /// # Errors
    /// When a command fails.
    fn survey(&mut self, runner: &dyn Runner, point: &Point) -> Result<Survey>;

    /// Adds a timed run.
    ///
    /// # Errors
    /// When a command fails.
    fn time(&mut self, runner: &dyn Runner, measured: &mut Measured) -> Result<()>;

    /// Cost of a point that an earlier process measured, from its medians.
    fn cost(&self, measured: &Measured) -> Option<Cost> {
        let _ = measured;
        None
    }

    /// Graphics devices that were used.
    fn devices(&self) -> &[String] {
        &[]
    }
}

/// Result of the first measurement of a point.
#[derive(Debug, Clone)]
pub struct Survey {
    pub measured: Measured,
    pub cost: Cost,
}

/// Seconds that measuring a point takes.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Cost {
    pub survey: f64,
    pub run: f64,
}

/// The JSON that a command printed.
pub struct Report {
    /// The JSON, or a part of it.
    pub value: Value,
    command: String,
}

impl Report {
    /// Runs a command.
    ///
    /// # Errors
    /// When it fails.
    pub fn of(runner: &dyn Runner, words: &[OsString]) -> Result<Report> {
        Ok(Report { value: runner.run(words)?, command: shell_line(words) })
    }

    pub fn part(&self, key: &str) -> Report {
        Report { value: self.value[key].clone(), command: self.command.clone() }
    }

    /// A number at a JSON pointer without its first slash; `"inf"` and `"-inf"` are infinite.
    ///
    /// # Errors
    /// When there is none.
    pub fn number(&self, path: &str) -> Result<f64> {
        let value = self.value.pointer(&format!("/{path}"));
        let infinite = match value.and_then(Value::as_str) {
            Some("inf") => Some(f64::INFINITY),
            Some("-inf") => Some(f64::NEG_INFINITY),
            _ => None,
        };
        value.and_then(Value::as_f64).or(infinite).ok_or_else(|| self.lacks(path))
    }

    /// A count, likewise.
    ///
    /// # Errors
    /// When there is none.
    pub fn count(&self, path: &str) -> Result<u64> {
        self.value.pointer(&format!("/{path}")).and_then(Value::as_u64).ok_or_else(|| self.lacks(path))
    }

    fn lacks(&self, path: &str) -> Error {
        Error::invalid(format!("{}: its report has no number {}", self.command, path.replace('/', ".")))
    }
}

/// A command line of this program as a POSIX shell takes it.
pub fn shell_line<S: AsRef<OsStr>>(words: &[S]) -> String {
    let words = words.iter().map(|word| shell_word(&word.as_ref().to_string_lossy()));
    std::iter::once("lightfold".to_owned()).chain(words).collect::<Vec<_>>().join(" ")
}

/// A word as a POSIX shell takes it, quoted if it holds more than plain characters.
pub fn shell_word(text: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "/._-+,:@%=".contains(c);
    if !text.is_empty() && text.chars().all(plain) {
        text.to_owned()
    } else {
        format!("'{}'", text.replace('\'', r"'\''"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn words_of_a_shell() {
        assert_eq!(shell_word("a/b-c_1.%04d"), "a/b-c_1.%04d");
        assert_eq!(shell_word("it's"), r"'it'\''s'");
        assert_eq!(shell_word(""), "''");
    }

    #[test]
    fn a_report_without_a_number_is_refused() {
        let report = Report { value: json!({ "a": { "b": null, "c": "inf" } }), command: "lightfold x".to_owned() };
        assert_eq!(report.number("a/c").unwrap(), f64::INFINITY);
        assert!(report.number("a/b").unwrap_err().to_string().contains("lightfold x: its report has no number a.b"));
    }
}
