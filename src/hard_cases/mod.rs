//! Cases that are numerically hard: for each a generator, the pipeline that it goes through, the bound that must hold and
//! the figure that was measured.
//!
//! Enters: nothing; every case makes its own input, the same on every machine. Leaves: one [`Measured`] for each case, and
//! the streams and light fields that it was measured on, which [`device`] shows on a graphics device as well. Bounds are derived from the
//! formats and from binary64, where they are written; none was taken from what came out.

mod blocks;
mod clip;
mod color;
pub mod device;
mod fits;
mod geometry;
mod pictures;
mod quantisation;
mod render;
mod report;
mod scene;
mod sight;
mod temporal;

use std::fmt;
use std::time::Instant;

use rayon::prelude::*;

use crate::error::Result;
use crate::gpu::selftest::pictures::PictureCase;
use crate::monitor::Monitor;

pub use clip::Clip;
pub use report::{CaseReport, CaseRow, FamilyReport, FamilyRow, family_rows, notes, number};

/// What cases have in common.
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
    /// All of them.
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

    /// The words for them, in the same order.
    pub const NAMES: [&str; 8] =
        ["quantisation", "temporal", "fits", "blocks", "colour", "geometry", "scene", "render"];

    /// The word for it.
    pub fn name(self) -> &'static str {
        Family::NAMES[self as usize]
    }
}

/// What must hold of a measured figure.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Bound {
    /// It is this or less.
    AtMost(f64),
    /// It is this or more.
    AtLeast(f64),
}

impl Bound {
    /// The number that the figure is compared with.
    pub fn value(self) -> f64 {
        match self {
            Bound::AtMost(value) | Bound::AtLeast(value) => value,
        }
    }

    /// Whether a figure keeps it; NaN keeps none.
    pub fn holds(self, figure: f64) -> bool {
        match self {
            Bound::AtMost(most) => figure <= most,
            Bound::AtLeast(least) => figure >= least,
        }
    }

    /// How much of what is allowed a figure takes: above 1 the bound is broken.
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
        write!(f, "{sign} {}", report::number(self.value()))
    }
}

/// What came of a case.
#[derive(Debug, Clone)]
pub struct Measured {
    /// The worst figure of all that was tried.
    pub figure: f64,
    /// Where it was found.
    pub place: Option<String>,
    /// Other figures, for people.
    pub note: Option<String>,
    /// What it was measured on.
    pub inputs: Inputs,
}

/// What a case was measured on, for devices to show as well.
#[derive(Debug, Clone, Default)]
pub struct Inputs {
    /// Streams.
    pub clips: Vec<Clip>,
    /// Light fields, each with a camera.
    pub pictures: Vec<PictureCase>,
}

impl Measured {
    /// A count of what went wrong, with the first of it.
    fn count(wrong: u64, first: Option<String>) -> Measured {
        Measured { figure: wrong as f64, place: first, note: None, inputs: Inputs::default() }
    }

    fn with_clips(self, clips: Vec<Clip>) -> Measured {
        Measured { inputs: Inputs { clips, ..self.inputs }, ..self }
    }

    fn with_pictures(self, pictures: Vec<PictureCase>) -> Measured {
        Measured { inputs: Inputs { pictures, ..self.inputs }, ..self }
    }

    fn with_note(self, note: String) -> Measured {
        Measured { note: Some(note), ..self }
    }
}

/// Keeps the worst of many figures, and where it was. NaN is worse than all.
#[derive(Debug, Clone)]
struct Worst {
    bound: Bound,
    found: Option<(f64, String)>,
}

impl Worst {
    /// The worst for figures that must stay low.
    fn greatest() -> Worst {
        Worst { bound: Bound::AtMost(0.0), found: None }
    }

    /// The worst for figures that must stay high.
    fn least() -> Worst {
        Worst { bound: Bound::AtLeast(0.0), found: None }
    }

    fn see(&mut self, figure: f64, place: impl FnOnce() -> String) {
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

    fn join(mut self, other: Worst) -> Worst {
        if let Some((figure, place)) = other.found {
            self.see(figure, || place);
        }
        self
    }

    /// The figure; NaN, which no bound allows, where nothing was seen.
    fn measured(self) -> Measured {
        let (figure, place) = self.found.map_or((f64::NAN, None), |(figure, place)| (figure, Some(place)));
        Measured { figure, place, note: None, inputs: Inputs::default() }
    }
}

/// What makes and measures a case.
type Run = Box<dyn Fn() -> Result<Measured> + Send + Sync>;

/// A case: its name is its own in the family.
pub struct HardCase {
    /// What is hard about it.
    pub name: String,
    /// What it belongs to.
    pub family: Family,
    /// What it goes through.
    pub pipeline: String,
    /// What must hold.
    pub bound: Bound,
    /// What bound and figure are counted in.
    pub unit: &'static str,
    run: Run,
}

impl fmt::Debug for HardCase {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {} ({} {})", self.family.name(), self.name, self.bound, self.unit)
    }
}

impl HardCase {
    /// Makes its input and measures what comes out.
    ///
    /// # Errors
    /// Whatever the pipeline refuses: no case has an input that should be.
    pub fn run(&self) -> Result<Measured> {
        (self.run)()
    }
}

/// Makes cases of a family whose pipeline and unit are shared.
#[derive(Debug, Clone)]
struct Shelf {
    family: Family,
    pipeline: String,
    unit: &'static str,
}

impl Shelf {
    fn new(family: Family, pipeline: impl Into<String>, unit: &'static str) -> Shelf {
        Shelf { family, pipeline: pipeline.into(), unit }
    }

    fn case(
        &self,
        name: impl Into<String>,
        bound: Bound,
        run: impl Fn() -> Result<Measured> + Send + Sync + 'static,
    ) -> HardCase {
        let Shelf { family, pipeline, unit } = self.clone();
        HardCase { name: name.into(), family, pipeline, bound, unit, run: Box::new(run) }
    }
}

/// All cases, family by family.
pub fn table() -> Vec<HardCase> {
    let families: [fn() -> Vec<HardCase>; 8] = [
        quantisation::cases,
        temporal::cases,
        fits::cases,
        blocks::cases,
        color::cases,
        geometry::cases,
        scene::cases,
        render::cases,
    ];
    families.into_iter().flat_map(|cases| cases()).collect()
}

/// Runs cases on all threads; the monitor advances by one for each. An error of a case names it.
///
/// # Errors
/// A pipeline refuses a case, or the work was asked to stop.
pub fn run_all(cases: &[HardCase], monitor: &dyn Monitor) -> Result<Vec<(CaseReport, Inputs)>> {
    let run = |case: &HardCase| {
        monitor.check()?;
        let start = Instant::now();
        let measured = case.run().map_err(|error| error.context(format!("hard case '{}'", case.name)))?;
        monitor.advance(1);
        Ok((CaseReport::new(case, &measured, start.elapsed().as_secs_f64()), measured.inputs))
    };
    cases.par_iter().map(run).collect()
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
    fn names_are_their_own() {
        let cases = table();
        let names: std::collections::BTreeSet<_> =
            cases.iter().map(|case| (case.family, case.pipeline.as_str(), case.name.as_str())).collect();
        assert_eq!(names.len(), cases.len());
        for family in Family::ALL {
            assert!(cases.iter().any(|case| case.family == family), "{}", family.name());
        }
    }
}
