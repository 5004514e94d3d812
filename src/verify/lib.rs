//! Numerically hard cases: each has an input generator, a pipeline, a bound and a measured figure.
//!
//! Every case generates its own input, identical on every machine. Output: one [`Measured`] per case, and the streams
//! and light fields that it was measured on, which [`device`] also decodes and renders on a graphics device. Bounds are
//! derived from the formats and from binary64, never from measured results.

// Tests write their inputs with `std::fs` (`clippy.toml`).
#![cfg_attr(test, allow(clippy::disallowed_methods))]

mod blocks;
mod case;
mod clip;
mod color;
mod compare;
pub mod device;
mod fits;
mod geometry;
mod hidden;
mod interpolate;
mod levels;
mod paths;
mod pictures;
mod quantisation;
mod render;
mod report;
mod scene;
mod seurat;
mod sight;
mod simplify;
mod temporal;
mod thin;

use std::time::Instant;

use rayon::prelude::*;

use codec::error::Result;
use codec::monitor::Monitor;

pub use case::{Bound, Family, HardCase, Inputs, Measured, number};
pub use clip::Clip;
pub use report::{CaseReport, CaseRow, FamilyReport, FamilyRow, family_rows, notes};

pub fn table() -> Vec<HardCase> {
    let families: [fn() -> Vec<HardCase>; 14] = [
        quantisation::cases,
        temporal::cases,
        levels::cases,
        fits::cases,
        blocks::cases,
        color::cases,
        geometry::cases,
        scene::cases,
        render::cases,
        hidden::cases,
        thin::cases,
        seurat::cases,
        simplify::cases,
        interpolate::cases,
    ];
    families.into_iter().flat_map(|cases| cases()).collect()
}

/// Runs cases on all threads. The monitor advances by one per case. Errors name the case.
pub fn run_all(cases: &[HardCase], monitor: &dyn Monitor) -> Result<Vec<(CaseReport, Inputs)>> {
    let run = |case: &HardCase| {
        monitor.check()?;
        let start = Instant::now();
        let measured = (case.run)().map_err(|error| error.context(format!("hard case '{}'", case.name)))?;
        monitor.advance(1);
        Ok((CaseReport::new(case, &measured, start.elapsed().as_secs_f64()), measured.inputs))
    };
    cases.par_iter().map(run).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_their_own() {
        let cases = table();
        let names: std::collections::BTreeSet<_> =
            cases.iter().map(|case| (case.family, case.pipeline.as_str(), case.name.as_str())).collect();
        assert_eq!(names.len(), cases.len());
        for family in Family::NAMES {
            assert!(cases.iter().any(|case| case.family.name() == family), "{family}");
        }
    }
}
