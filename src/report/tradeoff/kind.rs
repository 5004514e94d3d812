//! What a kind of sweep is made of, and what was measured of its points.
//!
//! A [`SweepKind`] is a table: knobs, measures, charts. Stores, pages and charts look measures up by name, so they hold no
//! code of a kind.

use std::collections::BTreeMap;
use std::ffi::OsString;

use super::knob::Knob;
use crate::image::StreamKind;
use crate::report::timing::{Spread, median, spread};

#[derive(Debug)]
pub struct SweepKind {
    /// Stem of the names of the CSV and JSON files.
    pub stem: &'static str,
    /// Title of the page, before the name of the input.
    pub title: &'static str,
    pub input_label: &'static str,
    pub knobs: &'static [Knob],
    pub measures: &'static [Measure],
    pub panels: &'static [Panel],
    pub trades: &'static [Trade],
    /// Whether studies have a score of bytes and decoding time.
    pub is_scored: bool,
    /// Whether the CSV holds all runs, so that a later process resumes the sweep.
    pub is_resumable: bool,
    /// Timed runs that the first measurement of a point includes.
    pub survey_runs: u32,
    /// How points were measured, for the foot of the page.
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

    /// The key of a knob in CSV and JSON.
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
    /// Heading of tables; empty where they leave it out.
    pub heading: &'static str,
    pub format: Format,
    pub source: Source,
    /// The measure of runs that it is the median of, for its range.
    pub runs: Option<&'static str>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    Bytes,
    /// With so many decimals; infinite is "lossless".
    Decimals(usize),
    /// In percent of 1, with two decimals.
    Percent,
    Even,
}

#[derive(Debug, Clone, Copy)]
pub enum Source {
    /// A stored count of at least this much; `None` where it may be missing.
    Count(Option<u64>),
    /// A stored number of at least 0.
    Number {
        is_needed: bool,
        may_be_infinite: bool,
    },
    /// A stored finite number of any sign, which may be missing.
    Signed,
    /// Stored, one number for each timed run.
    Runs,
    Derived(fn(&Measured) -> Option<f64>),
}

/// A finite number that every point has.
pub const NUMBER: Source = Source::Number { is_needed: true, may_be_infinite: false };
pub const DECIBELS: Source = Source::Number { is_needed: true, may_be_infinite: true };

impl Measure {
    pub const fn new(name: &'static str, source: Source) -> Measure {
        Measure { name, heading: "", format: Format::Decimals(0), source, runs: None }
    }

    /// What its values are multiplied by in charts.
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
    /// Bytes from 0, in the unit of the largest.
    Bytes,
    Linear,
    /// From the least value.
    WithoutZero,
    /// From the least value; infinite values are "lossless".
    Decibels,
    Logarithmic,
}

#[derive(Debug, Clone, Copy)]
pub struct PanelLine {
    /// Name in the legend; empty for a single line.
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
    /// Title with unit; that of bytes follows from the values.
    pub title: &'static str,
    pub lines: &'static [PanelLine],
    pub scale: Scale,
    /// Kinds of streams that have it; empty for all points.
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

/// All points by two measures, with their Pareto front. Less is better across.
#[derive(Debug, Clone, Copy)]
pub struct Trade {
    /// End of the name of its files.
    pub name: &'static str,
    pub title: &'static str,
    pub across: TradeAxis,
    pub up: TradeAxis,
    /// Which end of the axis up.
    pub better: Better,
    /// Sentence of the caption about the measures.
    pub note: &'static str,
}

pub type Setting = (&'static str, String);

/// A setting of the knobs. Knobs that are not named have their default.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct Point {
    /// The kind of stream that is coded, in sweeps of coding.
    pub stream: Option<StreamKind>,
    pub settings: Vec<Setting>,
}

impl Point {
    /// Sorts settings into the order of the kind's knobs.
    pub fn new(kind: &SweepKind, stream: Option<StreamKind>, mut settings: Vec<Setting>) -> Point {
        settings.sort_by_key(|(name, _)| kind.knobs.iter().position(|knob| knob.name == *name));
        Point { stream, settings }
    }

    /// The settings as `name=value name=value`; `default settings` without any.
    pub fn words(&self) -> String {
        words(&self.settings).unwrap_or_else(|| "default settings".to_owned())
    }

    pub fn value(&self, knob: &str) -> Option<&str> {
        self.settings.iter().find(|(name, _)| *name == knob).map(|(_, value)| value.as_str())
    }

    /// The settings as options of a command that has all of them.
    pub fn options(&self) -> impl Iterator<Item = OsString> {
        self.settings.iter().map(|(name, value)| format!("--{name}={value}").into())
    }

    pub fn without(&self, knob: &str) -> Vec<Setting> {
        self.settings.iter().filter(|(name, _)| *name != knob).cloned().collect()
    }
}

impl std::fmt::Display for Point {
    /// Such as `depth with max-error=50 threads=1`.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.stream {
            Some(stream) => write!(f, "{} with {}", stream.name(), self.words()),
            None => f.write_str(&self.words()),
        }
    }
}

/// Settings as `name=value name=value`; none without settings.
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

    /// Stores a value; `None` changes nothing.
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

    /// A value by the name of its measure, also one that follows from others.
    pub fn value(&self, name: &str) -> Option<Value> {
        match self.kind.measure(name)?.source {
            Source::Derived(of) => of(self).map(Value::Number),
            Source::Runs => Some(Value::Runs(self.runs(name).to_vec())),
            _ => self.values.get(name).cloned(),
        }
    }

    /// A count or number by the name of its measure.
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

    /// A count; 0 where it is missing.
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

    /// The range of a median of runs; none for other measures and without runs.
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
        /// The same values of another point.
        pub fn at(&self, point: Point) -> Measured {
            Measured { point, ..self.clone() }
        }

        /// The point without a value.
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
