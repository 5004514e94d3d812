//! A hard case: its bound, its pipeline, and how it is measured.

use std::fmt;

use crate::error::Result;
use crate::gpu::selftest::pictures::PictureCase;
use crate::hard_cases::clip::Clip;

/// A group of cases.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Family {
    /// Metres to codes and back; logarithms in integers.
    Quantisation,
    /// Windows, chunks and boxes in time.
    Temporal,
    /// Modelling functions and their fits.
    Fits,
    /// Blocks of texture formats and BC4w.
    Blocks,
    /// Cells of colour.
    Color,
    /// Faces, projections and what cameras see.
    Geometry,
    /// Rays, triangles and what lies between points.
    Scene,
    /// Pictures from any eye.
    Render,
}

impl Family {
    pub const ALL: [Family; 8] = [
        Family::Quantisation,
        Family::Temporal,
        Family::Fits,
        Family::Blocks,
        Family::Color,
        Family::Geometry,
        Family::Scene,
        Family::Render,
    ];

    /// Their names, in the same order.
    pub const NAMES: [&str; 8] =
        ["quantisation", "temporal", "fits", "blocks", "colour", "geometry", "scene", "render"];

    pub fn name(self) -> &'static str {
        Family::NAMES[self as usize]
    }
}

/// A bound on a measured figure.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Bound {
    /// At most this.
    AtMost(f64),
    /// At least this.
    AtLeast(f64),
}

impl Bound {
    /// The number of the bound.
    pub fn value(self) -> f64 {
        match self {
            Bound::AtMost(value) | Bound::AtLeast(value) => value,
        }
    }

    /// Whether a figure keeps the bound; NaN never does.
    pub fn holds(self, figure: f64) -> bool {
        match self {
            Bound::AtMost(most) => figure <= most,
            Bound::AtLeast(least) => figure >= least,
        }
    }

    /// Part of the bound that a figure uses up; infinite where the bound is broken.
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

/// The result of a case.
#[derive(Debug, Clone)]
pub struct Measured {
    pub figure: f64,
    pub place: Option<String>,
    pub note: Option<String>,
    /// Streams and pictures that it was measured on.
    pub inputs: Inputs,
}

/// Streams and pictures of a case, for graphics devices.
#[derive(Debug, Clone, Default)]
pub struct Inputs {
    pub clips: Vec<Clip>,
    pub pictures: Vec<PictureCase>,
}

impl Measured {
    /// A count of failures, and the first of them.
    pub(super) fn count(wrong: u64, first: Option<String>) -> Measured {
        Measured { figure: wrong as f64, place: first, note: None, inputs: Inputs::default() }
    }

    pub(super) fn with_clips(self, clips: Vec<Clip>) -> Measured {
        Measured { inputs: Inputs { clips, ..self.inputs }, ..self }
    }

    pub(super) fn with_pictures(self, pictures: Vec<PictureCase>) -> Measured {
        Measured { inputs: Inputs { pictures, ..self.inputs }, ..self }
    }

    pub(super) fn with_note(self, note: String) -> Measured {
        Measured { note: Some(note), ..self }
    }
}

/// Keeps the worst of many figures, and its place. NaN is the worst.
#[derive(Debug, Clone)]
pub(super) struct Worst {
    bound: Bound,
    found: Option<(f64, String)>,
}

impl Worst {
    /// The worst for figures that must stay low.
    pub(super) fn greatest() -> Worst {
        Worst { bound: Bound::AtMost(0.0), found: None }
    }

    /// The worst for figures that must stay high.
    pub(super) fn least() -> Worst {
        Worst { bound: Bound::AtLeast(0.0), found: None }
    }

    pub(super) fn see(&mut self, figure: f64, place: impl FnOnce() -> String) {
        let worse = match (&self.found, self.bound) {
            (None, _) => true,
            (Some((known, _)), _) if known.is_nan() => false,
            (Some((known, _)), Bound::AtMost(_)) => figure.is_nan() || figure > *known,
            (Some((known, _)), Bound::AtLeast(_)) => figure.is_nan() || figure < *known,
        };
        if worse {
            self.found = Some((figure, place()));
        }
    }

    pub(super) fn join(mut self, other: Worst) -> Worst {
        if let Some((figure, place)) = other.found {
            self.see(figure, || place);
        }
        self
    }

    /// The figure; NaN, which no bound allows, if there was none.
    pub(super) fn measured(self) -> Measured {
        let (figure, place) = self.found.map_or((f64::NAN, None), |(figure, place)| (figure, Some(place)));
        Measured { figure, place, note: None, inputs: Inputs::default() }
    }
}

pub(super) type Run = Box<dyn Fn() -> Result<Measured> + Send + Sync>;

/// A case; its name is unique in its family and pipeline.
pub struct HardCase {
    /// Name: what is hard about it.
    pub name: String,
    pub family: Family,
    /// The code under test.
    pub pipeline: String,
    pub bound: Bound,
    pub unit: &'static str,
    run: Run,
}

impl fmt::Debug for HardCase {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {} ({} {})", self.family.name(), self.name, self.bound, self.unit)
    }
}

impl HardCase {
    /// Makes the input and measures.
    pub fn run(&self) -> Result<Measured> {
        (self.run)()
    }
}

/// Makes cases that share family, pipeline and unit.
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
}

/// A figure with four digits at most, so that tables do not depend on the last bits of a logarithm.
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
        let mut worst = Worst::greatest();
        worst.see(1.0, || "a".into());
        worst.see(3.0, || "b".into());
        worst.see(2.0, || "c".into());
        assert_eq!(worst.clone().measured().place.as_deref(), Some("b"));
        worst.see(f64::NAN, || "d".into());
        assert!(worst.clone().measured().figure.is_nan());
        worst.see(9.0, || "e".into());
        assert_eq!(worst.measured().place.as_deref(), Some("d"));
        let mut least = Worst::least();
        least.see(f64::INFINITY, || "a".into());
        least.see(50.0, || "b".into());
        least.see(60.0, || "c".into());
        assert_eq!(least.measured().figure, 50.0);
        assert!(Worst::least().measured().figure.is_nan(), "a case that looked at nothing has no figure");
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
