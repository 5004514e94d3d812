//! Kinds of sweeps: tables of knobs, measures, charts, commands and claims of papers, read from `kinds/*.json`.
//!
//! Stores, pages and charts look measures up by name and contain no code for a particular kind.

use std::sync::LazyLock;

use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use codec::image::StreamKind;

pub static CODING: LazyLock<SweepKind> = LazyLock::new(|| read(include_str!("kinds/coding.json")));
pub static PLACEMENT: LazyLock<SweepKind> = LazyLock::new(|| read(include_str!("kinds/placement.json")));
pub static RENDERING: LazyLock<SweepKind> = LazyLock::new(|| read(include_str!("kinds/rendering.json")));
pub static SIMPLIFICATION: LazyLock<SweepKind> = LazyLock::new(|| read(include_str!("kinds/simplification.json")));
pub static INTERPOLATION: LazyLock<SweepKind> = LazyLock::new(|| read(include_str!("kinds/interpolation.json")));

/// All kinds of sweeps. A knob shared by several kinds is described by the first.
pub static KINDS: [&LazyLock<SweepKind>; 5] = [&CODING, &PLACEMENT, &RENDERING, &SIMPLIFICATION, &INTERPOLATION];

/// Reads a table of this program. A test parses all of them.
fn read(table: &'static str) -> SweepKind {
    let mut kind: SweepKind = serde_json::from_str(table).unwrap_or_default();
    let unnamed = kind.knobs.iter_mut().filter(|knob| knob.stage.is_empty());
    unnamed.for_each(|knob| knob.stage = kind.command);
    kind
}

#[derive(Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SweepKind {
    /// Stem of the names of the CSV and JSON files.
    pub stem: &'static str,
    /// Title of the page, followed by the name of the input.
    pub title: &'static str,
    pub input_label: &'static str,
    /// Activity in messages, and the same with its object.
    pub doing: &'static str,
    pub doing_what: &'static str,
    /// Command that the knobs are options of, unless they name another.
    pub command: &'static str,
    /// Things that a point consists of, in the list of knobs.
    pub points_of: &'static str,
    /// True if studies have a score of bytes and decoding time.
    pub is_scored: bool,
    /// True if the CSV holds all runs, so that a later process can resume the sweep.
    pub is_resumable: bool,
    /// Number of timed runs that the first measurement of a point includes.
    pub survey_runs: u32,
    /// Sentence below the title of the page.
    pub about: &'static str,
    /// Description of how points were measured, printed at the end of the page.
    pub method: &'static str,
    /// Keys of the JSON report with the variables that they show.
    pub reported: Vec<(&'static str, &'static str)>,
    /// Words that make a command line of fixed options complete.
    pub line: &'static str,
    /// Options of the command that are set by tradeoff.
    pub own: Vec<&'static str>,
    /// Options of a search, which do not apply to the comparison of its results.
    pub search: Vec<&'static str>,
    /// True if fixed options that are knobs are settings of the points.
    pub fixes_knobs: bool,
    /// Output of the preparation.
    pub makes: &'static str,
    /// Command lines: before all points, of a point, the same as a user would type it, and of its comparison. In braces
    /// are variables of [`super::runner::CommandBench`]. Placements are compared by as many surface samples as an
    /// exhaustive search uses; given cameras do not depend on the number of candidates.
    pub prepare: &'static str,
    pub point: &'static str,
    pub user: &'static str,
    pub compared: &'static str,
    pub knobs: Vec<Knob>,
    /// Measures, in the order of columns. Sizes of coding are those of CALF table 1: footage, temporal coding, blocks or
    /// functions, container, container with LZMA2. Errors of depth are in 16-bit log codes, those of material in 8-bit
    /// steps.
    pub measures: Vec<Measure>,
    pub panels: Vec<Panel>,
    /// Panels of decoding by error bound.
    pub bounds: Vec<Panel>,
    pub trades: Vec<Trade>,
    pub presets: Vec<PresetStudy>,
    pub findings: Vec<Claim>,
}

impl PartialEq for SweepKind {
    fn eq(&self, other: &SweepKind) -> bool {
        self.stem == other.stem
    }
}

impl SweepKind {
    pub fn knob(&self, name: &str) -> Option<&Knob> {
        self.knobs.iter().find(|knob| knob.name == name)
    }

    pub fn measure(&self, name: &str) -> Option<&Measure> {
        self.measures.iter().find(|measure| measure.name == name)
    }

    pub fn knob_names(&self) -> String {
        self.knobs.iter().map(|knob| knob.name).collect::<Vec<_>>().join(", ")
    }

    pub fn csv_name(&self) -> String {
        format!("{}.csv", self.stem)
    }

    pub fn json_name(&self) -> String {
        format!("{}.json", self.stem)
    }
}

/// Option that trades quality, bytes or time, under its command-line name.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Knob {
    /// Option name without dashes.
    pub name: &'static str,
    pub label: &'static str,
    /// Kinds of streams that it affects. Empty in sweeps whose points have no stream.
    #[serde(deserialize_with = "streams", rename(serialize = "kinds"), serialize_with = "names")]
    pub streams: Vec<StreamKind>,
    /// Command that it is an option of; `both` is encoding and decoding.
    pub stage: &'static str,
    /// Settings that it requires. They are added unless they are swept or fixed.
    #[serde(skip_serializing)]
    pub implies: Vec<(&'static str, &'static str)>,
    /// Value that stands for omitting the option, if the option itself has no such value.
    #[serde(skip_serializing)]
    without: Option<&'static str>,
    /// Value that completes a command line in which the knob is swept, if the option is required.
    #[serde(skip_serializing)]
    pub required: Option<&'static str>,
    pub default: &'static str,
    pub usual: Vec<&'static str>,
}

impl Knob {
    pub fn usual_values(&self) -> Vec<String> {
        self.usual.iter().map(|value| (*value).to_owned()).collect()
    }

    /// Returns the option with a value. `None` for the value that stands for omitting the option.
    pub fn option(&self, value: &str) -> Option<String> {
        (self.without != Some(value)).then(|| format!("--{}={value}", self.name))
    }

    /// True if points of a kind of stream depend on the knob.
    pub fn concerns(&self, stream: Option<StreamKind>) -> bool {
        stream.is_none_or(|stream| self.streams.contains(&stream))
    }

    /// True if all kinds of streams depend on the knob. Such knobs join every study.
    pub fn is_general(&self) -> bool {
        self.streams == StreamKind::ALL
    }
}

#[derive(Debug, Clone, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Measure {
    /// CSV column and JSON key.
    pub name: &'static str,
    /// Heading in tables. A measure with an empty heading is not in tables.
    pub heading: &'static str,
    pub format: Format,
    pub source: Source,
    /// Smallest valid count.
    pub least: u64,
    /// True if a point may lack it, such as SSIM of half floats or of pictures smaller than its windows.
    pub optional: bool,
    /// Kinds of streams that have it. Empty if all points have it.
    #[serde(deserialize_with = "streams")]
    pub streams: Vec<StreamKind>,
    /// Path in the report of the commands, or a formula of several.
    pub report: &'static str,
    /// Formula of other measures.
    pub formula: &'static str,
    /// Measure of runs of which this measure is the median. Gives its range.
    pub runs: Option<&'static str>,
}

impl Measure {
    /// Returns the factor that values are multiplied by in charts.
    pub fn factor(&self) -> f64 {
        if self.format == Format::Percent { 100.0 } else { 1.0 }
    }
}

#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Format {
    Bytes,
    /// Fixed number of decimals. Infinity is printed as "lossless".
    Decimals(usize),
    /// Percent with two decimals; a value of 1 is 100%.
    Percent,
    #[default]
    Even,
}

#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Source {
    /// Stored count.
    #[default]
    Count,
    /// Stored finite number of at least 0.
    Number,
    /// Stored number of at least 0, which may be infinite.
    Decibels,
    /// Stored finite number of any sign.
    Signed,
    /// Stored numbers, one per timed run.
    Runs,
    /// Median, minimum and maximum of runs.
    Median,
    Shortest,
    Longest,
    Formula,
}

#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Better {
    #[default]
    Less,
    More,
}

#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Scale {
    /// Bytes from 0, in the unit of the largest value.
    Bytes,
    #[default]
    Linear,
    /// Linear, from the smallest value.
    WithoutZero,
    /// Linear, from the smallest value. Infinite values are labelled "lossless".
    Decibels,
    Logarithmic,
}

#[derive(Debug, Clone, Copy, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PanelLine {
    /// Name in the legend. Empty for a single line.
    pub label: &'static str,
    pub measure: &'static str,
}

/// Chart of measures along a knob.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Panel {
    /// Title with unit. The unit of bytes is chosen from the values.
    pub title: &'static str,
    pub lines: Vec<PanelLine>,
    pub scale: Scale,
    /// Kinds of streams that have the panel. Empty if all points have it.
    #[serde(deserialize_with = "streams")]
    pub streams: Vec<StreamKind>,
    /// Better direction, if the panel is a heat map as well.
    pub map: Option<Better>,
}

#[derive(Debug, Clone, Copy, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct TradeAxis {
    pub label: &'static str,
    pub measure: &'static str,
    pub scale: Scale,
}

/// Plot of all points by two measures, with their Pareto front. Less is better on the horizontal axis.
#[derive(Debug, Clone, Copy, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Trade {
    /// Suffix of the file names.
    pub name: &'static str,
    pub title: &'static str,
    pub across: TradeAxis,
    pub up: TradeAxis,
    /// Better direction of the vertical axis.
    pub better: Better,
    /// Sentence of the caption that describes the measures.
    pub note: &'static str,
}

/// Study of a paper's figure.
#[derive(Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PresetStudy {
    pub name: &'static str,
    pub title: &'static str,
    pub figures: &'static str,
    /// Axes; the first knob determines the kind of stream.
    pub axes: Vec<PresetAxis>,
    /// Settings of all points, unless the user gives others.
    pub fixed: Vec<(&'static str, &'static str)>,
}

/// Values of a knob, separated by commas: all, and few.
#[derive(Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PresetAxis {
    pub knob: &'static str,
    pub paper: &'static str,
    pub quick: &'static str,
}

/// Claim of a paper, which is tested on the points of a sweep.
#[derive(Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Claim {
    pub name: &'static str,
    /// The claim with its location.
    pub sentence: &'static str,
    pub rule: &'static str,
    /// Measurements that the test needs.
    pub needs: &'static str,
    /// Rows that the test compares. A claim without them and without `most` has a function in [`super::findings`].
    pub rows: Option<RowTest>,
    /// Formula of measures and knobs, and the limit of its largest value over all points.
    pub most: Option<(&'static str, f64)>,
    /// Sentence with the values on which the verdict rests, in braces.
    pub rests_on: &'static str,
}

/// Test of a claim that holds if most rows of points that differ in one knob only keep a limit.
#[derive(Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct RowTest {
    pub along: &'static str,
    /// Two values of the knob that are compared, instead of the least and the largest.
    pub pair: Option<[&'static str; 2]>,
    /// Number that the least value is below and the largest is not.
    pub across: Option<f64>,
    pub measure: &'static str,
    /// Formula of `first` and `last`, the measure at both ends; `value` and `span`, the last value of the knob and its
    /// distance to the first; and other measures of the last point.
    pub row: &'static str,
    pub keeps: (Limit, f64),
}

#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Limit {
    #[default]
    Above,
    From,
    Below,
    To,
}

/// True if points of a kind of stream have what only these kinds have. An empty list stands for all points.
pub fn concerns(streams: &[StreamKind], stream: Option<StreamKind>) -> bool {
    streams.is_empty() || stream.is_some_and(|stream| streams.contains(&stream))
}

/// Replaces names in braces by their values. Braces around other words are kept.
pub fn fill(template: &str, values: &[(&str, String)]) -> String {
    let mut parts = template.split('{');
    let mut text = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let (name, rest) = part.split_once('}').unwrap_or((part, ""));
        match values.iter().find(|(known, _)| *known == name) {
            Some((_, value)) => text.extend([value, rest]),
            None => text.extend(["{", part]),
        }
    }
    text
}

fn streams<'de, D: Deserializer<'de>>(from: D) -> Result<Vec<StreamKind>, D::Error> {
    let named = |name: &str| StreamKind::from_name(name).ok_or_else(|| D::Error::custom(format!("{name}: no stream")));
    Vec::<&str>::deserialize(from)?.into_iter().map(named).collect()
}

fn names<S: Serializer>(streams: &[StreamKind], to: S) -> Result<S::Ok, S::Error> {
    to.collect_seq(streams.iter().map(|stream| stream.name()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_names_in_braces_are_filled() {
        let values = [("a", "{b}".to_owned()), ("b", "2".to_owned())];
        assert_eq!(fill("x {a}{b} {c} {", &values), "x {b}2 {c} {");
    }

    #[test]
    fn tables_are_read_and_name_measures_and_knobs_that_they_have() {
        for kind in KINDS {
            assert!(!kind.stem.is_empty() && !kind.knobs.is_empty());
            let lines = kind.panels.iter().flat_map(|panel| &panel.lines).map(|line| line.measure);
            let axes = kind.trades.iter().flat_map(|trade| [trade.across.measure, trade.up.measure]);
            let rows = || kind.findings.iter().filter_map(|claim| claim.rows.as_ref());
            let runs = kind.measures.iter().filter_map(|measure| measure.runs);
            for name in lines.chain(axes).chain(runs).chain(rows().map(|rows| rows.measure)) {
                assert!(kind.measure(name).is_some(), "{}: {name}", kind.stem);
            }
            let implied = kind.knobs.iter().flat_map(|knob| &knob.implies).map(|(name, _)| *name);
            let presets = kind.presets.iter().flat_map(|study| &study.axes).map(|axis| axis.knob);
            assert!(kind.findings.iter().all(|claim| claim.rests_on.contains('{')), "{}", kind.stem);
            for name in implied.chain(presets).chain(rows().map(|rows| rows.along)) {
                assert!(kind.knob(name).is_some(), "{}: {name}", kind.stem);
            }
        }
    }
}
