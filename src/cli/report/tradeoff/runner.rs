//! Runs commands of this program as processes and reads their reports for a kind of sweep.
//!
//! Each point is measured by commands that a user could type: the peak memory is that of the point, a crash loses only
//! one point, threads and device are ordinary options, and the CSV contains the command of each row. Starting a process
//! takes milliseconds and is not part of any time: commands report their own.

use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};

use serde_json::Value;

use super::findings::Finding;
use super::kind::{Measured, Point, SweepKind};
use super::study::{ExampleCommand, Results};
use codec::error::{Error, Result};
use footage::json;

/// Runs command lines of this program. Implemented by the command line.
pub trait Runner {
    /// Runs a command and returns the JSON that it printed. Errors name the command.
    fn run(&self, words: &[OsString]) -> Result<Value>;

    /// Returns the seconds since the program began.
    fn now_seconds(&self) -> f64;
}

/// Measures the points of one kind of sweep.
pub trait Bench {
    /// Returns the configuration hash of the input, the fixed options and the program.
    fn made_of(&self) -> u32 {
        0
    }

    /// Returns the command that a user would give for a point.
    fn command(&self, point: &Point) -> String;

    /// Does once what all points need.
    fn prepare(&mut self, _runner: &dyn Runner) -> Result<()> {
        Ok(())
    }

    /// Measures everything except further timed runs; the kind's `survey_runs` are included. Also serves as warm-up.
    fn survey(&mut self, runner: &dyn Runner, point: &Point) -> Result<Survey>;

    /// Adds a timed run.
    fn time(&mut self, runner: &dyn Runner, measured: &mut Measured) -> Result<()>;

    /// Returns the cost of a point that an earlier process measured, from its medians.
    fn cost(&self, _measured: &Measured) -> Option<Cost> {
        None
    }

    fn devices(&self) -> &[String] {
        &[]
    }

    /// True if an error of a point means that its settings admit no result. Such a point is left out, and the sweep
    /// counts as complete without it.
    fn is_infeasible(&self, _error: &Error) -> bool {
        false
    }
}

/// A point that one command measures. The first run of the command is timed, too.
pub trait CommandBench {
    fn kind(&self) -> &'static SweepKind;

    fn about(&self) -> String;

    /// Returns the description of the input in the JSON report.
    fn input(&self) -> Value;

    /// Returns a command that runs once before all points, with its files in `work`, and a description of its output.
    fn preparation(&self, _work: &Path) -> Option<(&'static str, Vec<OsString>)> {
        None
    }

    /// Returns the command of a point, with its files in `work`.
    fn line(&self, point: &Point, work: &Path) -> Vec<OsString>;

    /// Returns the same command as a user would give it.
    fn user_line(&self, point: &Point) -> String {
        shell_line(&self.line(point, Path::new("")))
    }

    /// Adds a timed run.
    fn add_run(&self, report: &Report, measured: &mut Measured) -> Result<()> {
        measured.push_run("runs", report.number("seconds")?);
        Ok(())
    }

    /// Adds all other values of a point. Its files are in the folder of `commands`.
    fn add_values(&self, commands: &Lines<'_>, report: &Report, measured: &mut Measured) -> Result<()>;

    /// See [`Bench::is_infeasible`].
    fn is_infeasible(&self, _error: &Error) -> bool {
        false
    }

    /// Tests the claims of the papers on the results.
    fn findings(_results: &Results) -> Vec<Finding>
    where
        Self: Sized,
    {
        Vec::new()
    }

    /// Returns commands that reproduce the preparation and the first point.
    fn examples(&self, points: &[Point]) -> Vec<ExampleCommand> {
        let before = self.preparation(Path::new(""));
        let before = before.map(|(makes, words)| ExampleCommand { makes, line: shell_line(&words) });
        let first = points.first().map(|point| ExampleCommand { makes: "First point", line: self.user_line(point) });
        before.into_iter().chain(first).collect()
    }
}

/// Returns a command with its input, the options of all points, then those of a point.
pub fn words_of([command, input]: [&str; 2], fixed: &[String], point: &Point) -> Vec<OsString> {
    let words = [command, input].into_iter().chain(fixed.iter().map(String::as_str));
    words.map(OsString::from).chain(point.options()).collect()
}

/// Runner of commands, and the folder of their files.
pub struct Lines<'a> {
    pub runner: &'a dyn Runner,
    pub work: &'a Path,
}

pub struct Commands<B> {
    pub bench: B,
    pub work: PathBuf,
}

impl<B: CommandBench> Bench for Commands<B> {
    fn command(&self, point: &Point) -> String {
        self.bench.user_line(point)
    }

    fn prepare(&mut self, runner: &dyn Runner) -> Result<()> {
        let before = self.bench.preparation(&self.work);
        before.map_or(Ok(()), |(_, words)| runner.run(&words).map(drop))
    }

    fn survey(&mut self, runner: &dyn Runner, point: &Point) -> Result<Survey> {
        let start = runner.now_seconds();
        let mut measured = Measured::new(self.bench.kind(), point.clone());
        let report = Report::of(runner, &self.bench.line(point, &self.work))?;
        self.bench.add_run(&report, &mut measured)?;
        let run = runner.now_seconds() - start;
        self.bench.add_values(&Lines { runner, work: &self.work }, &report, &mut measured)?;
        Ok(Survey { measured, cost: Cost { survey: runner.now_seconds() - start, run } })
    }

    fn time(&mut self, runner: &dyn Runner, measured: &mut Measured) -> Result<()> {
        let report = Report::of(runner, &self.bench.line(&measured.point, &self.work))?;
        self.bench.add_run(&report, measured)
    }

    fn is_infeasible(&self, error: &Error) -> bool {
        self.bench.is_infeasible(error)
    }
}

#[derive(Debug, Clone)]
pub struct Survey {
    pub measured: Measured,
    pub cost: Cost,
}

/// Time to measure a point, in seconds.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Cost {
    pub survey: f64,
    pub run: f64,
}

/// JSON report of a command, or a part of it.
pub struct Report {
    pub value: Value,
    command: String,
}

impl Report {
    pub fn of(runner: &dyn Runner, words: &[OsString]) -> Result<Report> {
        Ok(Report { value: runner.run(words)?, command: shell_line(words) })
    }

    pub fn part(&self, key: &str) -> Report {
        Report { value: self.value[key].clone(), command: self.command.clone() }
    }

    /// Returns the number at a JSON pointer, given without its first slash.
    pub fn number(&self, path: &str) -> Result<f64> {
        let (object, key) = path.rsplit_once('/').unwrap_or(("", path));
        let object = if object.is_empty() { String::new() } else { format!("/{object}") };
        let found = self.value.pointer(&object).and_then(|object| json::read_number(object, key));
        found.ok_or_else(|| self.no_number(path))
    }

    fn no_number(&self, path: &str) -> Error {
        Error::invalid(format!("{}: its report has no number {}", self.command, path.replace('/', ".")))
    }

    pub fn count(&self, path: &str) -> Result<u64> {
        self.value.pointer(&format!("/{path}")).and_then(Value::as_u64).ok_or_else(|| self.no_number(path))
    }
}

/// Returns a command line of this program, quoted for a POSIX shell.
pub fn shell_line<S: AsRef<OsStr>>(words: &[S]) -> String {
    let words = words.iter().map(|word| shell_word(&word.as_ref().to_string_lossy()));
    std::iter::once("lightfold".to_owned()).chain(words).collect::<Vec<_>>().join(" ")
}

/// Returns a word for a POSIX shell. It is quoted if it contains special characters.
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
        let report = Report {
            value: json!({ "a": { "b": null, "c": null, "c_is": "inf" } }),
            command: "lightfold x".to_owned(),
        };
        assert_eq!(report.number("a/c").unwrap(), f64::INFINITY);
        assert!(report.number("a/b").unwrap_err().to_string().contains("lightfold x: its report has no number a.b"));
    }
}
