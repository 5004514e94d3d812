//! Points of a sweep, and their measured values.

use std::collections::BTreeMap;
use std::ffi::OsString;

use super::kind::{Source, SweepKind};
use crate::report::statistics::{Spread, median, spread};
use codec::image::StreamKind;

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

    /// Returns the value of a knob as a number.
    pub fn number(&self, knob: &str) -> Option<f64> {
        self.value(knob).and_then(number)
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

/// Parses a value as a number: `16`, `0.5`, `0.1%` (which is 0.1).
pub fn number(value: &str) -> Option<f64> {
    value.strip_suffix('%').unwrap_or(value).parse().ok().filter(|number: &f64| number.is_finite())
}

/// Computes a formula such as `100 * bytes / frames` from left to right. Divisors are at least 1e-9. `None` if a value
/// is missing.
pub fn compute(formula: &str, value: impl Fn(&str) -> Option<f64>) -> Option<f64> {
    let term = |word: &str| word.parse().ok().or_else(|| value(word));
    let mut words = formula.split(' ');
    let mut result = term(words.next()?)?;
    while let (Some(operator), Some(word)) = (words.next(), words.next()) {
        let next: f64 = term(word)?;
        result = match operator {
            "*" => result * next,
            "/" => result / next.max(1e-9),
            "-" => result - next,
            _ => return None,
        };
    }
    Some(result)
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
        let measure = self.kind.measure(name)?;
        let runs = || self.runs(measure.runs.unwrap_or_default());
        let derived = match measure.source {
            Source::Formula => compute(measure.formula, |name| self.number(name)),
            Source::Median => median(runs()),
            Source::Shortest => spread(runs()).map(|of| of.low),
            Source::Longest => spread(runs()).map(|of| of.high),
            Source::Runs => return Some(Value::Runs(self.runs(name).to_vec())),
            _ => return self.values.get(name).cloned(),
        };
        derived.map(Value::Number)
    }

    /// Returns a count or number by the name of its measure. `None` if the kind of sweep has no such measure.
    pub fn number(&self, name: &str) -> Option<f64> {
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

    /// Returns the measured quality, such as `PSNR 40.00 dB, largest error 3 codes`; empty if none is known.
    pub fn quality_words(&self) -> String {
        if self.number("psnr_db") == Some(f64::INFINITY) {
            return "lossless".to_owned();
        }
        let parts = [
            self.number("psnr_db").map(|db| format!("PSNR {db:.2} dB")),
            self.number("min_psnr_db").map(|db| format!("worst cell {db:.2} dB")),
            self.number("max_error_codes").map(|error| format!("largest error {error} codes")),
        ];
        parts.into_iter().flatten().collect::<Vec<_>>().join(", ")
    }

    pub fn timed_runs(&self) -> usize {
        let measures = self.kind.measures.iter().filter(|measure| measure.source == Source::Runs);
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
    use crate::report::tradeoff::kind::CODING;
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
    fn formulas_are_computed_from_left_to_right() {
        let value = |name: &str| (name == "a/b").then_some(6.0);
        assert_eq!(compute("100 * a/b / 4", value), Some(150.0));
        assert_eq!(compute("a/b - 1e1", value), Some(-4.0));
        assert!(compute("1 / 0", value).is_some_and(f64::is_finite));
        assert_eq!((compute("a/b * c", value), compute("a/b + 1", value)), (None, None));
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
