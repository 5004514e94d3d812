//! Table of all points of a sweep, for the page and for standard output.

use super::kind::{Format, Measure, Measured};
use super::study::Results;
use crate::report::Table;
use crate::report::plot::number;
use codec::image::StreamKind;

/// Table of points, with columns for the knobs and measures that any of them has.
pub struct PointTable<'a> {
    pub headings: Vec<&'a str>,
    pub rows: Vec<PointRow<'a>>,
}

pub struct PointRow<'a> {
    pub point: &'a Measured,
    pub cells: Vec<Cell>,
}

pub struct Cell {
    pub text: String,
    /// Shortest and longest run, if there are several.
    pub range: Option<String>,
}

pub fn of(results: &Results, stream: Option<StreamKind>) -> PointTable<'_> {
    let points: Vec<&Measured> = results.measured.iter().filter(|of| of.point.stream == stream).collect();
    let has = |name: &str| points.iter().any(|of| of.point.value(name).is_some());
    let knobs: Vec<&str> = results.sweep.knobs.iter().map(|knob| knob.name).filter(|name| has(name)).collect();
    let shown = results.sweep.measures.iter().filter(|measure| !measure.heading.is_empty());
    let measures: Vec<&Measure> =
        shown.filter(|measure| points.iter().any(|of| of.number(measure.name).is_some())).collect();
    let row = |point: &&'_ Measured| {
        let values = knobs.iter().map(|name| point.point.value(name).unwrap_or("default").to_owned());
        let values = values.map(|text| Cell { text, range: None });
        values.chain(measures.iter().map(|measure| cell(point, measure))).collect()
    };
    let rows = points.iter().map(|point| PointRow { point, cells: row(point) }).collect();
    let headings = knobs.iter().copied().chain(measures.iter().map(|measure| measure.heading)).collect();
    PointTable { headings, rows }
}

fn cell(point: &Measured, measure: &Measure) -> Cell {
    let Some(value) = point.number(measure.name) else { return Cell { text: "–".to_owned(), range: None } };
    let print = |value: f64| print(value, measure.format);
    let runs = measure.runs.map_or(0, |runs| point.runs(runs).len());
    let spread = point.spread(measure.name).filter(|_| runs > 1);
    Cell { text: print(value), range: spread.map(|spread| format!("{}–{}", print(spread.low), print(spread.high))) }
}

fn print(value: f64, format: Format) -> String {
    match format {
        _ if value.is_infinite() => "lossless".to_owned(),
        Format::Bytes => number::bytes(value),
        Format::Decimals(decimals) => format!("{value:.decimals$}"),
        Format::Percent => format!("{:.2}", 100.0 * value),
        Format::Even => number::even(value),
    }
}

impl PointTable<'_> {
    pub fn text(&self) -> String {
        let mut table = Table::new(&format!(">{}", self.headings.join("|>")));
        for row in &self.rows {
            table.row(row.cells.iter().map(|cell| cell.text.clone()));
        }
        table.to_string()
    }
}

/// Returns all measures of a point that have a heading, as text with their headings.
pub fn words(point: &Measured) -> String {
    let shown = point.kind.measures.iter().filter(|measure| !measure.heading.is_empty());
    let words = shown.filter_map(|measure| {
        Some(format!("{} {}", measure.heading, print(point.number(measure.name)?, measure.format)))
    });
    words.collect::<Vec<_>>().join(", ")
}
