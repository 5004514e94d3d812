//! Options after `--`, which apply to all points.

use std::ffi::OsString;

use clap::parser::ValueSource;
use clap::{CommandFactory, Parser};

use crate::report::tradeoff::kind::SweepKind;
use crate::report::tradeoff::point::Setting;
use crate::report::tradeoff::study::Axis;
use crate::{Cli, refuse};
use codec::error::{Error, Result};

#[derive(Debug, PartialEq)]
pub struct FixedOption {
    pub name: String,
    pub values: Vec<String>,
}

impl FixedOption {
    pub fn words(&self) -> Vec<String> {
        match self.values.is_empty() {
            true => vec![format!("--{}", self.name)],
            false => self.values.iter().map(|value| format!("--{}={value}", self.name)).collect(),
        }
    }

    pub fn value(&self) -> Option<String> {
        (!self.values.is_empty()).then(|| self.values.join(","))
    }
}

/// Parses the options of a command among `words`. Returns them in the order of the help. `line` are further words that
/// make the command line complete; `own` are options that may not be given; `also` is another subcommand, with those of its
/// options that are accepted as well.
pub fn read(
    command: &str,
    words: &[String],
    axes: &[Axis],
    (line, own): (&[&str], &[&str]),
    also: Option<(&str, &[&str])>,
) -> Result<Vec<FixedOption>> {
    let mut root = Cli::command();
    root.build();
    let arguments = |command: &str| {
        let found = root.find_subcommand(command).into_iter().flat_map(clap::Command::get_arguments);
        found.filter(|argument| argument.get_long().is_some()).cloned().collect::<Vec<_>>()
    };
    let mut known = arguments(command);
    let mut more = also.map_or(Vec::new(), |(command, _)| arguments(command));
    more.retain(|argument| {
        also.is_some_and(|(_, names)| argument.get_long().is_some_and(|name| names.contains(&name)))
    });
    let parser = Cli::command().mut_subcommand(command, |command| command.args(more.clone()));
    known.extend(more);
    let whole = [&["lightfold", command], line].concat();
    let whole = whole.into_iter().map(str::to_owned).chain(words.iter().cloned());
    let matches = parser.try_get_matches_from(whole).map_err(|error| refused(&error))?;
    let Some((_, matches)) = matches.subcommand() else { return Ok(Vec::new()) };
    let mut found = Vec::new();
    for argument in &known {
        let (id, Some(name)) = (argument.get_id().as_str(), argument.get_long()) else { continue };
        let option = format!("--{name}");
        let is_given = matches!(matches.try_contains_id(id), Ok(true))
            && matches.value_source(id) == Some(ValueSource::CommandLine);
        let is_of_line =
            line.contains(&option.as_str()) && words.iter().all(|word| word.split('=').next() != Some(&option));
        if !is_given || is_of_line || name == "output" {
            continue;
        }
        if own.contains(&name) {
            return refuse(format!("{option} after --: tradeoff sets this option itself: leave it out"));
        }
        if axes.iter().any(|axis| axis.knob == name) {
            return refuse(format!("{option}: this option is swept and cannot be fixed: leave it out"));
        }
        let mut values = Vec::new();
        if argument.get_action().takes_values() {
            for each in matches.get_raw_occurrences(id).into_iter().flatten() {
                let each: Vec<_> = each.map(|value| value.to_string_lossy().into_owned()).collect();
                values.push(each.join(","));
            }
        }
        found.push(FixedOption { name: name.to_owned(), values });
    }
    Ok(found)
}

/// Returns the settings that swept knobs require, if they are neither swept nor given as options.
pub fn implied(kind: &SweepKind, axes: &[Axis], options: &[FixedOption]) -> Vec<Setting> {
    let knobs = axes.iter().filter_map(|axis| kind.knob(axis.knob));
    let is_open =
        |name: &str| axes.iter().all(|axis| axis.knob != name) && options.iter().all(|option| option.name != name);
    let settings = knobs.flat_map(|knob| &knob.implies).filter(|(name, _)| is_open(name));
    let mut settings: Vec<Setting> = settings.map(|&(name, value)| (name, value.to_owned())).collect();
    settings.dedup();
    settings
}

pub fn parse(words: &[OsString]) -> Result<Cli> {
    let words = std::iter::once("lightfold".into()).chain(words.iter().cloned());
    Cli::try_parse_from(words).map_err(|error| refused(&error))
}

/// Returns the first sentence of a parser's message.
fn refused(error: &clap::Error) -> Error {
    use clap::error::ErrorKind::{DisplayHelp, DisplayVersion};
    if matches!(error.kind(), DisplayHelp | DisplayVersion) {
        return Error::Usage("--help and --version do not apply to points: use them before --".into());
    }
    let text = error.to_string();
    let text = text.strip_prefix("error: ").unwrap_or(&text);
    let sentence: Vec<&str> = text.split("\n\n").next().unwrap_or(text).lines().map(str::trim).collect();
    Error::Usage(sentence.join(" "))
}
