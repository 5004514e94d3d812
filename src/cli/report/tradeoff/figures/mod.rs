//! Charts of a report: one figure per study, and one per pair of measures that a sweep kind trades.

mod common;
mod study;
mod tiles;
mod trade;

pub use common::Figure;
pub use study::bounds;
pub use tiles::figure as tiles;

use super::study::Results;

pub fn all(results: &Results) -> Vec<Figure> {
    let studies = results.studies.iter().flat_map(|of| study::figures(results, of));
    studies.chain(trade::figures(results)).collect()
}

#[cfg(test)]
mod tests;
