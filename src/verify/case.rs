//! Definition of a hard case: its bound, its pipeline, and its measurement.

use std::fmt;

use serde::Serialize;

use crate::clip::Clip;
use codec::error::Result;
use gpu::selftest::pictures::PictureCase;
use gpu::selftest::slices::InterpolationCase;

/// Unit roundoff of binary64.
pub(super) const ROUNDING: f64 = f64::EPSILON / 2.0;

#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Family {
    Quantisation,
    Temporal,
    Fits,
    Blocks,
    #[serde(rename = "colour")]
    Color,
    Geometry,
    Scene,
    Render,
    Simplification,
    Interpolation,
}

impl Family {
    /// Names in the order of the variants.
    pub const NAMES: [&str; 10] = [
        "quantisation",
        "temporal",
        "fits",
        "blocks",
        "colour",
        "geometry",
        "scene",
        "render",
        "simplification",
        "interpolation",
    ];

    pub fn name(self) -> &'static str {
        Family::NAMES[self as usize]
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(tag = "must_be", content = "bound")]
pub enum Bound {
    #[serde(rename = "at most")]
    AtMost(f64),
    #[serde(rename = "at least")]
    AtLeast(f64),
}

impl Bound {
    pub fn value(self) -> f64 {
        match self {
            Bound::AtMost(value) | Bound::AtLeast(value) => value,
        }
    }

    /// True if a figure satisfies the bound. Always false for NaN.
    pub fn holds(self, figure: f64) -> bool {
        match self {
            Bound::AtMost(most) => figure <= most,
            Bound::AtLeast(least) => figure >= least,
        }
    }

    /// Fraction of the bound that a figure uses. Infinite if the bound is violated.
    pub fn share(self, figure: f64) -> f64 {
        match self {
            _ if !self.holds(figure) => f64::INFINITY,
            Bound::AtMost(most) if most > 0.0 => (figure / most).max(0.0),
            Bound::AtLeast(least) if figure > 0.0 => (least / figure).max(0.0),
            _ => 0.0,
        }
    }
}

impl fmt::Display for Bound {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let sign = if matches!(self, Bound::AtMost(_)) { "<=" } else { ">=" };
        write!(f, "{sign} {}", number(self.value()))
    }
}

#[derive(Debug, Clone)]
pub struct Measured {
    pub figure: f64,
    pub place: Option<String>,
    pub note: Option<String>,
    pub inputs: Inputs,
}

#[derive(Debug, Clone, Default)]
pub struct Inputs {
    pub clips: Vec<Clip>,
    pub pictures: Vec<PictureCase>,
    pub interpolations: Vec<InterpolationCase>,
}

impl Inputs {
    /// Number of rendered pictures, including interpolated views.
    pub fn picture_count(&self) -> usize {
        let views = self.interpolations.iter().map(|case| case.views.offsets_m.len());
        self.pictures.len() + views.sum::<usize>()
    }
}

impl Measured {
    /// No figure yet: NaN, which violates every bound.
    pub(super) fn nothing() -> Measured {
        Measured { figure: f64::NAN, place: None, note: None, inputs: Inputs::default() }
    }

    /// Count of failures; [`Self::count_if`] adds to it.
    pub(super) fn count(wrong: u64) -> Measured {
        Measured { figure: wrong as f64, ..Measured::nothing() }
    }

    /// Counts a failure. Keeps the place of the first.
    pub(super) fn count_if(&mut self, is_wrong: bool, place: impl FnOnce() -> String) {
        if is_wrong {
            self.figure += 1.0;
            self.place.get_or_insert_with(place);
        }
    }

    /// Keeps the largest figure and its place. NaN counts as the worst.
    pub(super) fn greatest(&mut self, figure: f64, place: impl FnOnce() -> String) {
        self.keep(figure, figure > self.figure, place);
    }

    /// Keeps the smallest figure and its place. NaN counts as the worst.
    pub(super) fn least(&mut self, figure: f64, place: impl FnOnce() -> String) {
        self.keep(figure, figure < self.figure, place);
    }

    fn keep(&mut self, figure: f64, is_worse: bool, place: impl FnOnce() -> String) {
        if self.place.is_none() || is_worse || (figure.is_nan() && !self.figure.is_nan()) {
            (self.figure, self.place) = (figure, Some(place()));
        }
    }

    /// Keeps the larger of two figures, and the streams of both.
    pub(super) fn join(mut self, other: Measured) -> Measured {
        if let Some(place) = other.place {
            self.greatest(other.figure, || place);
        }
        self.inputs.clips.extend(other.inputs.clips);
        self
    }

    pub(super) fn with_clip(mut self, clip: Clip) -> Measured {
        self.inputs.clips.push(clip);
        self
    }

    pub(super) fn with_picture(mut self, picture: PictureCase) -> Measured {
        self.inputs.pictures.push(picture);
        self
    }

    pub(super) fn with_interpolations(mut self, cases: impl IntoIterator<Item = InterpolationCase>) -> Measured {
        self.inputs.interpolations.extend(cases);
        self
    }

    pub(super) fn with_note(self, note: String) -> Measured {
        Measured { note: Some(note), ..self }
    }
}

/// A hard case. Its name is unique within its family and pipeline.
pub struct HardCase {
    /// Description of the difficulty.
    pub name: String,
    pub family: Family,
    /// Code under test.
    pub pipeline: String,
    pub bound: Bound,
    pub unit: &'static str,
    pub(super) run: Box<dyn Fn() -> Result<Measured> + Send + Sync>,
}

/// Builds cases that share family, pipeline and unit.
#[derive(Debug, Clone)]
pub(super) struct Group {
    family: Family,
    pipeline: String,
    unit: &'static str,
}

impl Group {
    pub(super) fn new(family: Family, pipeline: impl Into<String>, unit: &'static str) -> Group {
        Group { family, pipeline: pipeline.into(), unit }
    }

    pub(super) fn case(
        &self,
        name: impl Into<String>,
        bound: Bound,
        run: impl Fn() -> Result<Measured> + Send + Sync + 'static,
    ) -> HardCase {
        let Group { family, pipeline, unit } = self.clone();
        HardCase { name: name.into(), family, pipeline, bound, unit, run: Box::new(run) }
    }

    /// Returns a case that counts failures. Its bound is 0.
    pub(super) fn none(
        &self,
        name: impl Into<String>,
        run: impl Fn() -> Result<Measured> + Send + Sync + 'static,
    ) -> HardCase {
        self.case(name, Bound::AtMost(0.0), run)
    }
}

/// Formats a figure with at most four digits, so that tables do not depend on the last bits of a logarithm.
pub fn number(value: f64) -> String {
    match value {
        _ if value.is_nan() => "nothing".to_owned(),
        _ if value.is_infinite() => if value > 0.0 { "inf" } else { "-inf" }.to_owned(),
        _ if value.fract() == 0.0 && value.abs() < 1e9 => format!("{value:.0}"),
        _ if (0.001..1e6).contains(&value.abs()) => {
            let digits = (3 - value.abs().log10().floor() as i32).clamp(0, 6) as usize;
            format!("{value:.digits$}")
        }
        _ => format!("{value:.3e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_are_kept_or_broken() {
        assert!(Bound::AtMost(2.0).holds(2.0) && !Bound::AtMost(2.0).holds(2.0001));
        assert!(Bound::AtLeast(50.0).holds(f64::INFINITY) && !Bound::AtLeast(50.0).holds(49.9));
        assert!(!Bound::AtMost(1.0).holds(f64::NAN) && !Bound::AtLeast(1.0).holds(f64::NAN));
        assert_eq!(Bound::AtMost(4.0).share(1.0), 0.25);
        assert_eq!(Bound::AtLeast(50.0).share(100.0), 0.5);
        assert_eq!(Bound::AtMost(0.0).share(0.0), 0.0);
        assert_eq!(Bound::AtMost(0.0).share(1.0), f64::INFINITY);
        assert_eq!(Bound::AtLeast(50.0).share(f64::INFINITY), 0.0);
    }

    #[test]
    fn the_worst_is_kept() {
        let mut worst = Measured::nothing();
        worst.greatest(1.0, || "a".into());
        worst.greatest(3.0, || "b".into());
        worst.greatest(2.0, || "c".into());
        assert_eq!(worst.place.as_deref(), Some("b"));
        worst.greatest(f64::NAN, || "d".into());
        assert!(worst.figure.is_nan());
        worst.greatest(9.0, || "e".into());
        assert_eq!(worst.place.as_deref(), Some("d"));
        let mut least = Measured::nothing();
        least.least(f64::INFINITY, || "a".into());
        least.least(50.0, || "b".into());
        least.least(60.0, || "c".into());
        assert_eq!(least.figure, 50.0);
        assert!(Measured::nothing().figure.is_nan(), "a case that looked at nothing has no figure");
    }

    #[test]
    fn figures_have_four_digits() {
        let shown =
            [0.0, 100.0, 65535.0, 0.5, 0.012_345, 53.217_9, 1.0e-7, 2.2e12, f64::INFINITY, f64::NAN].map(number);
        assert_eq!(
            shown,
            ["0", "100", "65535", "0.5000", "0.01235", "53.22", "1.000e-7", "2.200e12", "inf", "nothing"]
        );
    }
}
