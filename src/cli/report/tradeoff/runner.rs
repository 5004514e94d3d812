//! Runs commands of this program as processes and reads their reports for a kind of sweep.
//!
//! Each point is measured by commands that a user could type: the peak memory is that of the point, a crash loses only
//! one point, threads and device are ordinary options, and the CSV contains the command of each row. Starting a process
//! takes milliseconds and is not part of any time: commands report their own.

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::path::{Path, PathBuf};

use serde_json::Value as Json;

use super::kind::{Measure, Source, SweepKind, concerns, fill};
use super::point::{Measured, Point, Value, compute};
use crate::child::{Runner, shell_line};
use codec::error::{Error, Result};
use footage::json;
use simplify::{selection, texture_sizes};

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

/// Points that one command measures, and perhaps another compares. The first run of the command is timed, too.
#[derive(Debug, Clone)]
pub struct CommandBench {
    pub kind: &'static SweepKind,
    /// Folder of files of the commands.
    pub work: PathBuf,
    /// Words of each variable of the kind's command lines: `input`; `fixed`, the options of all points; `kept`, those
    /// of them that do not belong to a search; and values of fixed options by name. `work` and `point` are added.
    pub variables: BTreeMap<&'static str, Vec<String>>,
}

impl CommandBench {
    /// Returns a command line of the kind. A variable that is a word of its own stands for any number of words. A word
    /// with a variable that has none is left out.
    fn line(&self, template: &str, point: Option<&Point>, work: &Path) -> Vec<OsString> {
        let word = |word: &str| -> Vec<OsString> {
            let name = word.strip_prefix('{').and_then(|word| word.strip_suffix('}'));
            if let Some(path) = word.strip_prefix("{work}/") {
                vec![work.join(path).into()]
            } else if name == Some("point") {
                point.into_iter().flat_map(Point::options).collect()
            } else if let Some(words) = name.and_then(|name| self.variables.get(name)) {
                words.iter().map(OsString::from).collect()
            } else if self
                .variables
                .iter()
                .any(|(name, words)| words.is_empty() && word.contains(&format!("{{{name}}}")))
            {
                Vec::new()
            } else {
                vec![self.fill(word).into()]
            }
        };
        template.split(' ').flat_map(word).collect()
    }

    /// Replaces the variables of a sentence or word.
    fn fill(&self, text: &str) -> String {
        let values: Vec<_> = self.variables.iter().map(|(name, words)| (*name, words.join(" "))).collect();
        fill(text, &values)
    }

    pub fn about(&self) -> String {
        self.fill(self.kind.about)
    }

    /// Returns the command that runs once before all points, if there is one.
    pub fn preparation(&self, work: &Path) -> Option<Vec<OsString>> {
        (!self.kind.prepare.is_empty()).then(|| self.line(self.kind.prepare, None, work))
    }

    pub fn point_line(&self, point: &Point, work: &Path) -> Vec<OsString> {
        self.line(self.kind.point, Some(point), work)
    }

    /// Returns commands that reproduce the preparation and the first point.
    pub fn examples(&self, points: &[Point]) -> Vec<(&'static str, String)> {
        let before = self.preparation(Path::new("")).map(|words| (self.kind.makes, shell_line(&words)));
        before.into_iter().chain(points.first().map(|point| ("First point", self.command(point)))).collect()
    }
}

impl Bench for CommandBench {
    fn command(&self, point: &Point) -> String {
        let template = if self.kind.user.is_empty() { self.kind.point } else { self.kind.user };
        shell_line(&self.line(template, Some(point), Path::new("")))
    }

    fn prepare(&mut self, runner: &dyn Runner) -> Result<()> {
        self.preparation(&self.work).map_or(Ok(()), |words| runner.run(&words).map(drop))
    }

    fn survey(&mut self, runner: &dyn Runner, point: &Point) -> Result<Survey> {
        let start = runner.now_seconds();
        let mut measured = Measured::new(self.kind, point.clone());
        let mut report = Report::of(runner, &self.point_line(point, &self.work))?;
        report.add_runs(&mut measured)?;
        let run = runner.now_seconds() - start;
        if !self.kind.compared.is_empty() {
            report.value["compared"] = runner.run(&self.line(self.kind.compared, Some(point), &self.work))?;
        }
        report.add_values(&mut measured)?;
        Ok(Survey { measured, cost: Cost { survey: runner.now_seconds() - start, run } })
    }

    fn time(&mut self, runner: &dyn Runner, measured: &mut Measured) -> Result<()> {
        Report::of(runner, &self.point_line(&measured.point, &self.work))?.add_runs(measured)
    }

    fn is_infeasible(&self, error: &Error) -> bool {
        let said = error.to_string();
        selection::says_infeasible(&said) || texture_sizes::says_infeasible(&said)
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

/// JSON report of a command, or of several.
pub struct Report {
    pub value: Json,
    pub command: String,
}

impl Report {
    pub fn of(runner: &dyn Runner, words: &[OsString]) -> Result<Report> {
        Ok(Report { value: runner.run(words)?, command: shell_line(words) })
    }

    /// Adds a timed run, from the paths of the kind's measures.
    pub fn add_runs(&self, measured: &mut Measured) -> Result<()> {
        for measure in measured.kind.measures.iter().filter(|measure| measure.source == Source::Runs) {
            measured.push_run(measure.name, self.number(measure.report)?);
        }
        Ok(())
    }

    /// Sets all other values of a point.
    pub fn add_values(&self, measured: &mut Measured) -> Result<()> {
        let stream = measured.point.stream;
        let is_read =
            |of: &&Measure| of.source != Source::Runs && !of.report.is_empty() && concerns(&of.streams, stream);
        for measure in measured.kind.measures.iter().filter(is_read) {
            let value = match measure.source {
                Source::Count => self.count(measure.report).map(Value::Count),
                // Rounding may make numbers less than 0.
                Source::Number => self.number(measure.report).map(|number| Value::Number(number.max(0.0))),
                _ => self.number(measure.report).map(Value::Number),
            };
            measured.set(measure.name, if measure.optional { value.ok() } else { Some(value?) });
        }
        Ok(())
    }

    /// Returns the number at a path, or that of a formula of paths.
    pub fn number(&self, formula: &str) -> Result<f64> {
        let number = |path: &str| {
            let (object, key) = path.rsplit_once('/').unwrap_or(("", path));
            let object = if object.is_empty() { String::new() } else { format!("/{object}") };
            json::read_number(self.value.pointer(&object)?, key)
        };
        compute(formula, number).ok_or_else(|| self.no_number(formula))
    }

    /// Returns the count at a path: a number, or the length of an array.
    pub fn count(&self, path: &str) -> Result<u64> {
        let found = self.value.pointer(&format!("/{path}"));
        let count = found.and_then(|of| of.as_u64().or_else(|| of.as_array().map(|all| all.len() as u64)));
        count.ok_or_else(|| self.no_number(path))
    }

    fn no_number(&self, path: &str) -> Error {
        Error::invalid(format!("{}: its report has no number {}", self.command, path.replace('/', ".")))
    }
}

#[cfg(test)]
mod tests;
