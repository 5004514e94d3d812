//! Definition of a kind of sweep, and the measured values of its points.
//!
//! A [`SweepKind`] is a table of knobs, measures and charts. Stores, pages and charts look measures up by name and
//! contain no code for a particular kind.

use std::collections::BTreeMap;
use std::ffi::OsString;

use super::knob::Knob;
use crate::report::timing::{Spread, median, spread};
use codec::image::StreamKind;

#[derive(Debug)]
pub struct SweepKind {
    /// Stem of the names of the CSV and JSON files.
    pub stem: &'static str,
    /// Title of the page, followed by the name of the input.
    pub title: &'static str,
    pub input_label: &'static str,
    pub knobs: &'static [Knob],
    pub measures: &'static [Measure],
    pub panels: &'static [Panel],
    pub trades: &'static [Trade],
    /// True if studies have a score of bytes and decoding time.
    pub is_scored: bool,
    /// True if the CSV holds all runs, so that a later process can resume the sweep.
    pub is_resumable: bool,
    /// Number of timed runs that the first measurement of a point includes.
    pub survey_runs: u32,
    /// Description of how points were measured, printed at the end of the page.
    pub method: &'static str,
}

impl PartialEq for SweepKind {
    fn eq(&self, other: &SweepKind) -> bool {
        self.stem == other.stem
    }
}

impl SweepKind {
    pub fn knob(&self, name: &str) -> Option<&'static Knob> {
        self.knobs.iter().find(|knob| knob.name == name || knob.former == Some(name))
    }

    /// Returns the key of a knob in CSV and JSON.
    pub fn key(&self, name: &'static str) -> &'static str {
        self.knob(name).map_or(name, Knob::key)
    }

    pub fn measure(&self, name: &str) -> Option<&'static Measure> {
        self.measures.iter().find(|measure| measure.name == name)
    }

    pub fn csv_name(&self) -> String {
        format!("{}.csv", self.stem)
    }

    pub fn json_name(&self) -> String {
        format!("{}.json", self.stem)
    }
}

#[derive(Debug, Clone, Copy)]
pub struct Measure {
    /// CSV column and JSON key.
    pub name: &'static str,
    /// Heading in tables. A measure with an empty heading is not in tables.
    pub heading: &'static str,
    pub format: Format,
    pub source: Source,
    /// Measure of runs of which this measure is the median. Gives its range.
    pub runs: Option<&'static str>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    Bytes,
    /// Fixed number of decimals. Infinity is printed as "lossless".
    Decimals(usize),
    /// Percent with two decimals; a value of 1 is 100%.
    Percent,
    Even,
}

#[derive(Debug, Clone, Copy)]
pub enum Source {
    /// Stored count with this minimum. `None` if it may be missing.
    Count(Option<u64>),
    /// Stored number of at least 0.
    Number {
        is_needed: bool,
        may_be_infinite: bool,
    },
    /// Stored finite number of any sign. It may be missing.
    Signed,
    /// Stored numbers, one per timed run.
    Runs,
    Derived(fn(&Measured) -> Option<f64>),
}

/// Finite number that every point has.
pub const NUMBER: Source = Source::Number { is_needed: true, may_be_infinite: false };
pub const DECIBELS: Source = Source::Number { is_needed: true, may_be_infinite: true };

impl Measure {
    pub const fn new(name: &'static str, source: Source) -> Measure {
        Measure { name, heading: "", format: Format::Decimals(0), source, runs: None }
    }

    /// Returns the factor that values are multiplied by in charts.
    pub fn factor(&self) -> f64 {
        if self.format == Format::Percent { 100.0 } else { 1.0 }
    }

    pub const fn derived(name: &'static str, of: fn(&Measured) -> Option<f64>) -> Measure {
        Measure::new(name, Source::Derived(of))
    }

    pub const fn shown(self, heading: &'static str, format: Format) -> Measure {
        Measure { heading, format, ..self }
    }

    pub const fn median_of(self, runs: &'static str) -> Measure {
        Measure { runs: Some(runs), ..self }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Better {
    Less,
    More,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scale {
    /// Bytes from 0, in the unit of the largest value.
    Bytes,
    Linear,
    /// Linear, from the smallest value.
    WithoutZero,
    /// Linear, from the smallest value. Infinite values are labelled "lossless".
    Decibels,
    Logarithmic,
}

#[derive(Debug, Clone, Copy)]
pub struct PanelLine {
    /// Name in the legend. Empty for a single line.
    pub label: &'static str,
    pub measure: &'static str,
}

impl PanelLine {
    pub const fn of(measure: &'static str) -> PanelLine {
        PanelLine { label: "", measure }
    }
}

#[derive(Debug, Clone, Copy)]
pub struct Panel {
    /// Title with unit. The unit of bytes is chosen from the values.
    pub title: &'static str,
    pub lines: &'static [PanelLine],
    pub scale: Scale,
    /// Kinds of streams that have the panel. Empty if all points have it.
    pub streams: &'static [StreamKind],
    pub map: Option<Better>,
}

impl Panel {
    pub const fn new(title: &'static str, scale: Scale, lines: &'static [PanelLine]) -> Panel {
        Panel { title, lines, scale, streams: &[], map: None }
    }

    pub const fn mapped(self, better: Better) -> Panel {
        Panel { map: Some(better), ..self }
    }

    pub const fn for_streams(self, streams: &'static [StreamKind]) -> Panel {
        Panel { streams, ..self }
    }

    pub fn concerns(&self, stream: Option<StreamKind>) -> bool {
        self.streams.is_empty() || stream.is_some_and(|stream| self.streams.contains(&stream))
    }
}

#[derive(Debug, Clone, Copy)]
pub struct TradeAxis {
    pub label: &'static str,
    pub measure: &'static str,
    pub scale: Scale,
}

/// Plot of all points by two measures, with their Pareto front. Less is better on the horizontal axis.
#[derive(Debug, Clone, Copy)]
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

pub type Setting = (&'static str, String);

/// A setting of the knobs. Knobs that are not listed have their default.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct Point {
    /// Kind of the coded stream, in coding sweeps.
    pub stream: Option<StreamKind>,
    pub settings: Vec<Setting>,
}

impl Point {
    /// Creates a point and sorts its settings into the order of the kind's knobs.
    pub fn new(kind: &SweepKind, stream: Option<StreamKind>, mut settings: Vec<Setting>) -> Point {
        settings.sort_by_key(|(name, _)| kind.knobs.iter().position(|knob| knob.name == *name));
        Point { stream, settings }
    }

    /// Returns the settings as `name=value name=value`, or `default settings` if there are none.
    pub fn words(&self) -> String {
        words(&self.settings).unwrap_or_else(|| "default settings".to_owned())
    }

    pub fn value(&self, knob: &str) -> Option<&str> {
        self.settings.iter().find(|(name, _)| *name == knob).map(|(_, value)| value.as_str())
    }

    /// Returns the settings as command-line options.
    pub fn options(&self) -> impl Iterator<Item = OsString> {
        self.settings.iter().map(|(name, value)| format!("--{name}={value}").into())
    }

    pub fn without(&self, knob: &str) -> Vec<Setting> {
        self.settings.iter().filter(|(name, _)| *name != knob).cloned().collect()
    }
}

impl std::fmt::Display for Point {
    /// Prints, for example, `depth with max-error=50 threads=1`.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.stream {
            Some(stream) => write!(f, "{} with {}", stream.name(), self.words()),
            None => f.write_str(&self.words()),
        }
    }
}

/// Returns settings as `name=value name=value`. `None` without settings.
pub fn words(settings: &[Setting]) -> Option<String> {
    let words: Vec<String> = settings.iter().map(|(name, value)| format!("{name}={value}")).collect();
    (!words.is_empty()).then(|| words.join(" "))
}

#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    Count(u64),
    Number(f64),
    Runs(Vec<f64>),
}

#[derive(Debug, Clone, PartialEq)]
pub struct Measured {
    pub kind: &'static SweepKind,
    pub point: Point,
    values: BTreeMap<&'static str, Value>,
}

impl Measured {
    pub fn new(kind: &'static SweepKind, point: Point) -> Measured {
        Measured { kind, point, values: BTreeMap::new() }
    }

    /// Stores a value. `None` changes nothing.
    pub fn set(&mut self, name: &'static str, value: impl Into<Option<Value>>) {
        debug_assert!(self.kind.measure(name).is_some(), "{name}");
        if let Some(value) = value.into() {
            self.values.insert(name, value);
        }
    }

    pub fn push_run(&mut self, name: &'static str, number: f64) {
        match self.values.get_mut(name) {
            Some(Value::Runs(runs)) => runs.push(number),
            _ => self.set(name, Value::Runs(vec![number])),
        }
    }

    /// Returns a value by the name of its measure. Derived measures are computed.
    pub fn value(&self, name: &str) -> Option<Value> {
        match self.kind.measure(name)?.source {
            Source::Derived(of) => of(self).map(Value::Number),
            Source::Runs => Some(Value::Runs(self.runs(name).to_vec())),
            _ => self.values.get(name).cloned(),
        }
    }

    /// Returns a count or number by the name of its measure.
    pub fn number(&self, name: &str) -> Option<f64> {
        debug_assert!(self.kind.measure(name).is_some(), "{name}");
        match self.value(name)? {
            Value::Count(count) => Some(count as f64),
            Value::Number(number) => Some(number),
            Value::Runs(_) => None,
        }
    }

    pub fn drawn(&self, name: &str) -> Option<f64> {
        Some(self.number(name)? * self.kind.measure(name)?.factor())
    }

    /// Returns a count. 0 if it is missing.
    pub fn count(&self, name: &str) -> u64 {
        match self.values.get(name) {
            Some(Value::Count(count)) => *count,
            _ => 0,
        }
    }

    pub fn runs(&self, name: &str) -> &[f64] {
        match self.values.get(name) {
            Some(Value::Runs(runs)) => runs,
            _ => &[],
        }
    }

    pub fn timed_runs(&self) -> usize {
        let measures = self.kind.measures.iter().filter(|measure| matches!(measure.source, Source::Runs));
        measures.map(|measure| self.runs(measure.name).len()).min().unwrap_or(0)
    }

    /// Returns the range of a median of runs. `None` for other measures and without runs.
    pub fn spread(&self, name: &str) -> Option<Spread> {
        let value = self.number(name)?;
        let runs = self.runs(self.kind.measure(name)?.runs?);
        let (middle, Spread { low, high }) = (median(runs)?, spread(runs)?);
        let factor = if middle > 0.0 { value / middle } else { 1.0 };
        Some(Spread { low: low * factor, high: high * factor })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::tradeoff::coding::CODING;
    use crate::report::tradeoff::tests::sample;

    impl Measured {
        /// Returns the same values for another point.
        pub fn at(&self, point: Point) -> Measured {
            Measured { point, ..self.clone() }
        }

        /// Returns the point without the value of a measure.
        pub fn without(mut self, name: &str) -> Measured {
            self.values.remove(name);
            self
        }
    }

    #[test]
    fn points_have_a_name_for_people() {
        let settings = vec![("threads", "1".to_owned()), ("max-error", "50".to_owned())];
        let point = Point::new(&CODING, Some(StreamKind::Depth), settings);
        assert_eq!(point.to_string(), "depth with max-error=50 threads=1");
        assert_eq!(Point::new(&CODING, Some(StreamKind::Color), vec![]).to_string(), "color with default settings");
    }

    #[test]
    fn medians_and_ranges() {
        let mut of = sample::measured(&[], 1, 1.0);
        of.set("decode_runs", Value::Runs(vec![3.0, 1.5, 2.0]));
        assert_eq!(of.spread("decode_seconds"), Some(Spread { low: 1.5, high: 3.0 }));
        assert_eq!(of.number("decode_ms_per_frame"), Some(2000.0 / 30.0));
        let spread = of.spread("decode_ms_per_frame").unwrap();
        assert!((spread.low - 50.0).abs() < 1e-9 && (spread.high - 100.0).abs() < 1e-9, "{spread:?}");
        assert_eq!((of.spread("psnr_db"), of.timed_runs()), (None, 3));
    }
}
