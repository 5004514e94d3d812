//! Charts of a report: one figure per study, and one per pair of measures that a sweep kind trades.

mod common;
mod grid;
mod line;
mod trade;

pub use common::{Figure, Mark, extents, sheet, subtitle};
pub use grid::capital;
pub use line::{Along, along};

use super::study::Results;

pub fn all(results: &Results) -> Vec<Figure> {
    let mut figures = Vec::new();
    for study in &results.studies {
        match study.varied().as_slice() {
            [] => {}
            [axis] => figures.extend(line::figure(results, study, axis)),
            [rows, columns, others @ ..] => {
                figures.extend(grid::figures(results, study, grid::Axes { rows, columns, others }));
            }
        }
    }
    figures.extend(trade::figures(results));
    figures
}

#[cfg(test)]
mod tests;
