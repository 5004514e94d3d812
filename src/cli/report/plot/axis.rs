//! Axes: mapping from values to positions along a line, and ticks with labels.

use super::number;

#[derive(Debug, Clone, Copy, PartialEq)]
enum Scale {
    Linear,
    Log,
    /// Logarithm of 1 + value / unit, so that 0 has a position. The scale changes from linear to logarithmic around
    /// `unit`.
    LogFromZero {
        unit: f64,
    },
}

impl Scale {
    fn of(self, value: f64) -> f64 {
        match self {
            Scale::Linear => value,
            Scale::Log => value.max(f64::MIN_POSITIVE).log10(),
            Scale::LogFromZero { unit } => (1.0 + value / unit).max(1e-3).log10(),
        }
    }

    fn inverse(self, place: f64) -> f64 {
        match self {
            Scale::Linear => place,
            Scale::Log => 10f64.powf(place),
            Scale::LogFromZero { unit } => (10f64.powf(place) - 1.0) * unit,
        }
    }
}

#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    pub label: String,
    pub ticks: Vec<(f64, String)>,
    /// Label of infinite values, which have their own position beyond the last value.
    pub infinite: Option<String>,
    scale: Scale,
    low: f64,
    high: f64,
}

/// Share of the axis reserved for infinite values, if it shows any.
const INFINITE_SHARE: f64 = 0.12;
const TICKS: f64 = 5.0;
/// An axis starts at 0 unless all values are at least this share of the largest.
const FAR_FROM_ZERO: f64 = 0.6;

impl Axis {
    /// Returns an axis without ticks. The label notes a logarithmic scale.
    fn new(label: impl Into<String>, scale: Scale, low: f64, high: f64) -> Axis {
        let mut label = label.into();
        if !label.is_empty() && scale != Scale::Linear {
            label += ", logarithmic";
        }
        Axis { label, ticks: Vec::new(), infinite: None, scale, low, high }
    }

    fn with_ticks(self, ticks: impl IntoIterator<Item = (f64, String)>) -> Axis {
        Axis { ticks: ticks.into_iter().collect(), ..self }
    }

    /// Returns a linear axis. It starts at 0 unless all values are far from it.
    pub fn linear(label: impl Into<String>, values: impl IntoIterator<Item = f64>) -> Axis {
        let (low, high) = range(values);
        let from_zero = low >= 0.0 && low < FAR_FROM_ZERO * high;
        Axis::over(label, if from_zero { 0.0 } else { low }, high)
    }

    /// Returns a linear axis that need not include 0, for values such as decibels whose 0 has no meaning.
    pub fn without_zero(label: impl Into<String>, values: impl IntoIterator<Item = f64>) -> Axis {
        let finite: Vec<f64> = values.into_iter().filter(|value| value.is_finite()).collect();
        let (low, high) = range(finite.iter().copied());
        let axis = Axis::over(label, low, high);
        // If all values are infinite (lossless), no tick applies.
        if finite.is_empty() { axis.with_ticks([]) } else { axis }
    }

    fn over(label: impl Into<String>, mut low: f64, mut high: f64) -> Axis {
        if high - low <= 1e-9 * high.abs().max(low.abs()) {
            let room = if high == 0.0 { 1.0 } else { high.abs() * 0.1 };
            (low, high) = (low - room, high + room);
        }
        let step = nice_step(high - low);
        (low, high) = ((low / step + 1e-9).floor() * step, (high / step - 1e-9).ceil() * step);
        let count = ((high - low) / step).round() as usize;
        Axis::new(label, Scale::Linear, low, high).with_ticks(ticks(low, step, count))
    }

    /// Returns a logarithmic axis, noted in its label. Values that are not positive map to its start.
    pub fn logarithmic(label: impl Into<String>, values: impl IntoIterator<Item = f64>) -> Axis {
        let (low, high) = range(values.into_iter().filter(|&value| value > 0.0));
        let (low, high) = if low > 0.0 { (low, high) } else { (1.0, 1.0) };
        let decades = (high / low).log10();
        // Leaves a margin so that no value lies on the border.
        let room = 10f64.powf((decades * 0.06).max(0.04));
        let (low, high) = (low / room, high * room);
        let axis = Axis::new(label, Scale::Log, low, high);
        if decades < 0.7 {
            let step = nice_step(high - low);
            let first = (low / step).ceil() as i64;
            let values = (first..).map(|at| at as f64 * step).take_while(|&value| value <= high);
            return axis.with_ticks(values.map(|value| (value, number::tick(value, step))));
        }
        let digits: &[f64] = match decades {
            few if few < 2.5 => &[1.0, 2.0, 5.0],
            some if some < 4.5 => &[1.0, 3.0],
            _ => &[1.0],
        };
        let every = (decades / 8.0).ceil().max(1.0) as i32;
        let powers = (low.log10().floor() as i32..=high.log10().ceil() as i32).filter(|power| power % every == 0);
        let values = powers.flat_map(|power| digits.iter().map(move |digit| digit * 10f64.powi(power)));
        axis.with_ticks(
            values.filter(|&value| value >= low && value <= high).map(|value| (value, number::short(value))),
        )
    }

    /// Returns an axis with a tick at each value of a knob. It is logarithmic, noted in its label, if the values span
    /// more than a factor of four, else linear.
    pub fn of_settings(label: impl Into<String>, values: &[f64]) -> Axis {
        let (low, high) = range(values.iter().copied());
        let least = range(values.iter().copied().filter(|&value| value > 0.0)).0;
        let scale = if low > 0.0 && high > 4.0 * low {
            Scale::Log
        } else if low == 0.0 && least > 0.0 && high > 4.0 * least {
            Scale::LogFromZero { unit: least }
        } else {
            Scale::Linear
        };
        let finite = values.iter().filter(|value| value.is_finite());
        Axis::new(label, scale, low, high).widened().with_ticks(finite.map(|&value| (value, number::short(value))))
    }

    pub fn of_words(label: impl Into<String>, words: &[String]) -> Axis {
        let axis = Axis::new(label, Scale::Linear, 0.0, words.len().saturating_sub(1) as f64);
        axis.widened().with_ticks(words.iter().enumerate().map(|(at, word)| (at as f64, word.clone())))
    }

    /// Returns an axis from `low` to `high` with a tick every `step`, starting at `low`.
    pub fn between(label: impl Into<String>, low: f64, high: f64, step: f64) -> Axis {
        let count = ((high - low) / step + 1e-9) as usize;
        Axis::new(label, Scale::Linear, low, high).with_ticks(ticks(low, step, count))
    }

    pub fn with_infinite(self, name: impl Into<String>) -> Axis {
        Axis { infinite: Some(name.into()), ..self }
    }

    /// Returns the position of a value, 0 to 1. Values outside the axis are clamped to its ends. `None` for NaN, and
    /// for infinite values if the axis has no position for them.
    pub fn place(&self, value: f64) -> Option<f64> {
        if value.is_nan() || (value.is_infinite() && (self.infinite.is_none() || value < 0.0)) {
            return None;
        }
        if value.is_infinite() {
            return Some(1.0 - INFINITE_SHARE / 2.0);
        }
        let (low, high) = (self.scale.of(self.low), self.scale.of(self.high));
        let finite_share = if self.infinite.is_some() { 1.0 - INFINITE_SHARE } else { 1.0 };
        Some(((self.scale.of(value) - low) / (high - low)).clamp(0.0, 1.0) * finite_share)
    }

    /// True if a value lies within the axis, so that its position is not clamped.
    pub fn holds(&self, value: f64) -> bool {
        let room = 1e-9 * (self.high - self.low);
        (self.low - room..=self.high + room).contains(&value)
    }

    fn widened(self) -> Axis {
        let (low, high) = (self.scale.of(self.low), self.scale.of(self.high));
        let room = if high > low { (high - low) * 0.06 } else { 1.0 };
        Axis { low: self.scale.inverse(low - room), high: self.scale.inverse(high + room), ..self }
    }
}

fn ticks(low: f64, step: f64, count: usize) -> impl Iterator<Item = (f64, String)> {
    (0..=count).map(move |at| low + at as f64 * step).map(move |value| (value, number::tick(value, step)))
}

fn range(values: impl IntoIterator<Item = f64>) -> (f64, f64) {
    let finite = values.into_iter().filter(|value| value.is_finite());
    let bounds = finite.map(|value| (value, value)).reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)));
    bounds.unwrap_or((0.0, 0.0))
}

/// Returns a step of 1, 2 or 5 times a power of ten that divides `span` into about [`TICKS`] intervals.
fn nice_step(span: f64) -> f64 {
    let rough = (span / TICKS).max(f64::MIN_POSITIVE * 1e10);
    let power = 10f64.powf(rough.log10().floor());
    let digit = [1.0, 2.0, 5.0, 10.0].into_iter().find(|digit| digit * power >= rough * 0.999).unwrap_or(10.0);
    digit * power
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn labels(axis: &Axis) -> Vec<&str> {
        axis.ticks.iter().map(|(_, label)| label.as_str()).collect()
    }

    #[test]
    fn ticks_are_round() {
        assert_eq!(labels(&Axis::linear("", [0.31, 1.9])), ["0", "0.5", "1", "1.5", "2"]);
        assert_eq!(labels(&Axis::linear("", [41.0, 47.0])), ["40", "42", "44", "46", "48"]);
        assert!(Axis::without_zero("", [f64::INFINITY]).ticks.is_empty());
        assert_eq!(labels(&Axis::without_zero("", [41.0, 99.0])), ["40", "60", "80", "100"]);
        assert_eq!(labels(&Axis::linear("", [7.0])), ["6", "6.5", "7", "7.5", "8"]);
        assert_eq!(labels(&Axis::logarithmic("", [1.3, 60.0])), ["2", "5", "10", "20", "50"]);
        assert_eq!(labels(&Axis::of_settings("", &[1.0, 2.0, 4.0, 16.0])), ["1", "2", "4", "16"]);
    }

    #[test]
    fn what_is_not_even_is_named() {
        assert_eq!(Axis::of_settings("E", &[1.0, 2.0]).label, "E");
        assert_eq!(Axis::of_settings("E", &[1.0, 8.0]).label, "E, logarithmic");
        assert_eq!(Axis::of_settings("E", &[0.0, 1.0, 8.0]).label, "E, logarithmic");
        assert_eq!(Axis::logarithmic("bytes", [1.0, 8.0]).label, "bytes, logarithmic");
        assert_eq!(Axis::linear("bytes", [1.0, 8.0]).label, "bytes");
    }

    #[test]
    fn values_beyond_the_ends_are_not_held() {
        let axis = Axis::linear("", [0.31, 1.9]);
        assert_eq!([-0.1, 0.0, 2.0, 2.1, f64::NAN].map(|value| axis.holds(value)), [false, true, true, false, false]);
    }

    #[test]
    fn settings_from_zero_have_places_apart() {
        let values = [0.0, 10.0, 25.0, 50.0, 100.0, 200.0, 400.0, 800.0];
        let axis = Axis::of_settings("", &values);
        let places: Vec<f64> = values.iter().map(|&value| axis.place(value).unwrap()).collect();
        assert!(places.windows(2).all(|pair| pair[1] - pair[0] > 0.08), "{places:?}");
    }

    #[test]
    fn what_is_infinite_lies_beyond_all_else() {
        let axis = Axis::linear("", [10.0, 20.0]);
        assert_eq!((axis.place(f64::INFINITY), axis.place(f64::NAN)), (None, None));
        let axis = axis.with_infinite("lossless");
        assert!(axis.place(f64::INFINITY).unwrap() > axis.place(20.0).unwrap() + 0.05);
    }

    proptest! {
        #[test]
        fn places_are_numbers_between_0_and_1(
            values in prop::collection::vec(prop_oneof![-1e15f64..1e15, 0.0f64..1e-9, Just(0.0), Just(f64::NAN),
                Just(f64::INFINITY), 0.0f64..100.0], 0..9),
        ) {
            let each = || values.iter().copied();
            for axis in [Axis::linear("", each()), Axis::logarithmic("", each()), Axis::of_settings("", &values)] {
                let axis = axis.with_infinite("inf");
                prop_assert!(axis.ticks.len() <= 24, "{axis:?}");
                let ticks: Vec<f64> = axis.ticks.iter().map(|&(value, _)| value).collect();
                for value in each().chain(ticks) {
                    let place = axis.place(value);
                    prop_assert_eq!(place.is_none(), value.is_nan());
                    prop_assert!(place.is_none_or(|place| (0.0..=1.0).contains(&place)), "{axis:?} {value} {place:?}");
                }
            }
        }
    }
}
