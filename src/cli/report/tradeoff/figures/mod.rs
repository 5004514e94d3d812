//! Charts of a report: one figure per study, and one per pair of measures that a sweep kind trades.

mod common;
mod study;
mod trade;

pub use study::bounds;

use super::study::Results;
use crate::report::plot::Figure;

pub fn all(results: &Results) -> Vec<Figure> {
    let studies = results.studies.iter().flat_map(|of| study::figures(results, of));
    studies.chain(trade::figures(results)).collect()
}

#[cfg(test)]
mod tests;
