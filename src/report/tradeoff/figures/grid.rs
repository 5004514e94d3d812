//! Two knobs against each other: heat maps of the kind's mapped panels and of the score, and lines of the panels (CALF
//! figures 7 and 8).

use super::common::{
    Figure, KnobAxis, Mark, PanelUnit, axis_of, extents, fixed_words, mark, point_at, sheet, subtitle,
};
use crate::report::plot::Drawing;
use crate::report::plot::chart::{Chart, Kind, Series};
use crate::report::plot::heat::{Cell, HeatMap};
use crate::report::plot::marker::Look;
use crate::report::plot::number;
use crate::report::tradeoff::kind::{Better, Measured, Panel, PanelLine, Setting};
use crate::report::tradeoff::score::{self, Scored};
use crate::report::tradeoff::study::{Axis, Results, Study, product};

/// Sizes of heat maps and of charts in pixels.
const MAP: [u32; 2] = [410, 340];
const CHART: [u32; 2] = [619, 340];
/// Figures of one study at most, where it has more than two axes.
const MOST_OF_A_STUDY: usize = 4;

/// The varied axes of a study.
pub struct Axes<'a> {
    /// Rows of heat maps.
    pub rows: &'a Axis,
    /// Columns of heat maps.
    pub columns: &'a Axis,
    /// One figure for each combination of their values.
    pub others: &'a [&'a Axis],
}

/// The points of one figure: rows of the first axis, in each those of the second.
struct Grid<'a> {
    results: &'a Results,
    study: &'a Study,
    axes: &'a Axes<'a>,
    points: Vec<Option<&'a Measured>>,
    /// Values of the other axes.
    chosen: Vec<Setting>,
}

/// Mapped values of all cells.
struct MapValues {
    title: String,
    unit: &'static str,
    values: Vec<Option<f64>>,
    best: Option<usize>,
}

/// One figure for each combination of the other axes' values, the first few of them.
pub fn figures(results: &Results, study: &Study, axes: Axes<'_>) -> Vec<Figure> {
    let combinations = product(&[], axes.others.iter().copied());
    let count = combinations.len();
    let left = count.saturating_sub(MOST_OF_A_STUDY);
    let note = if left == 0 { String::new() } else { format!(" {left} more combinations are in the table only.") };
    let shown = combinations.into_iter().take(MOST_OF_A_STUDY).enumerate();
    shown
        .filter_map(|(at, chosen)| {
            let at_cell = |row: &String, column: &String| {
                let cell = [(axes.rows.knob, row.clone()), (axes.columns.knob, column.clone())];
                point_at(study, chosen.iter().cloned().chain(cell))
            };
            let cells =
                axes.rows.values.iter().flat_map(|row| axes.columns.values.iter().map(move |column| (row, column)));
            let points: Vec<_> = cells.map(|(row, column)| results.of(&at_cell(row, column))).collect();
            points.iter().flatten().next()?;
            let name = if count > 1 { format!("{}-{}", study.name, at + 1) } else { study.name.clone() };
            Some(Grid { results, study, axes: &axes, points, chosen }.figure(name, &note))
        })
        .collect()
}

impl Grid<'_> {
    fn figure(&self, name: String, note: &str) -> Figure {
        let Grid { results, study, axes, .. } = self;
        let mapped = study.sweep.panels.iter().filter(|panel| panel.concerns(study.stream));
        let mapped = mapped.filter_map(|panel| Some((panel, panel.lines.first()?, panel.map?)));
        let (mut maps, mut lines, mut titles) = (Vec::new(), Vec::new(), Vec::new());
        for (panel, line, better) in mapped {
            maps.push(self.map(&self.values(panel, line, better)));
            lines.push(self.lines(panel, line));
            titles.push(panel.title);
        }
        let scored = study.sweep.is_scored.then(|| Scored::new(self.points.clone(), results.weights));
        if let Some(scored) = &scored {
            maps.push(self.map(&MapValues {
                title: format!(
                    "Score: size^{} × time^{}",
                    number::short(results.weights.compression),
                    number::short(results.weights.decoding)
                ),
                unit: "times the best",
                values: scored.scores.clone(),
                best: scored.best,
            }));
        }
        let caption = format!(
            "{} and {} against each other, {}: {}{}. The best cell is framed.{} Bars in the lower charts span the shortest and \
             the longest run, and a bar without an end is cut.{note}",
            capital(study.label(axes.rows)),
            study.label(axes.columns),
            fixed_words(&self.chosen),
            titles.join(", "),
            scored.as_ref().map_or_else(String::new, |scored| {
                format!(
                    ", and a score of bytes and time relative to the best of {} points, which has 1",
                    scored.count()
                )
            }),
            scored.as_ref().map_or_else(String::new, |scored| self.least_words(scored)),
        );
        let measured = self.points.iter().flatten().copied();
        let subtitle = subtitle(results, study, &self.chosen, measured);
        Figure { name, caption, drawing: sheet(&study.title, &subtitle, vec![maps, lines]) }
    }

    /// Which point has the least score, and that the score ignores quality.
    fn least_words(&self, scored: &Scored<'_>) -> String {
        let Some(at) = scored.best else { return String::new() };
        let Axes { rows, columns, .. } = self.axes;
        let (row, column) = (&rows.values[at / columns.values.len()], &columns.values[at % columns.values.len()]);
        let settings = format!("{}={row} {}={column}", rows.knob, columns.knob);
        if scored.quality_differs() {
            format!(" The least bytes and time have {settings}, but points differ in quality, which the score ignores.")
        } else {
            format!(" The best score has {settings}.")
        }
    }

    fn unit(&self, panel: &Panel, line: &PanelLine) -> PanelUnit {
        let values = self.points.iter().flatten().filter_map(|point| point.number(line.measure));
        PanelUnit::new(panel.scale, panel.title, values)
    }

    fn values(&self, panel: &Panel, line: &PanelLine, better: Better) -> MapValues {
        let unit = self.unit(panel, line);
        let value = |point: &Measured| {
            let value = point.number(line.measure)? * line.factor / unit.size;
            Some(value).filter(|value| value.is_finite())
        };
        let values: Vec<Option<f64>> = self.points.iter().map(|point| point.and_then(value)).collect();
        let best = match better {
            Better::Less => score::best(&values),
            Better::More => score::best(&values.iter().map(|value| value.map(|value| -value)).collect::<Vec<_>>()),
        };
        MapValues { title: unit.title, unit: unit.name, values, best }
    }

    fn map(&self, of: &MapValues) -> Drawing {
        let Axes { rows, columns, .. } = self.axes;
        let cell = |value: &Option<f64>| value.map(|value| Cell { value, text: number::even(value) });
        let label = |axis: &Axis| (self.study.label(axis).to_owned(), axis.values.clone());
        let map = HeatMap {
            title: of.title.clone(),
            columns: label(columns),
            rows: label(rows),
            cells: of.values.iter().map(cell).collect(),
            best: of.best,
            unit: of.unit.to_owned(),
        };
        map.draw(MAP[0], MAP[1])
    }

    /// A line for each row along the columns; values that are words are not joined.
    fn lines(&self, panel: &Panel, line: &PanelLine) -> Drawing {
        let Axes { rows, columns, .. } = self.axes;
        let x = KnobAxis::new(self.study, columns);
        let unit = self.unit(panel, line);
        let kind = if columns.numbers().is_some() { Kind::Line } else { Kind::Points };
        let width = columns.values.len();
        let series: Vec<Series> = rows
            .values
            .iter()
            .enumerate()
            .map(|(row, name)| {
                let points = self.points[row * width..(row + 1) * width].iter().zip(&x.places);
                // A hole in the grid is a hole in the line.
                let hole = |x: f64| Mark { x, y: f64::NAN, ..Mark::default() };
                let of = |(point, &x): (&Option<&Measured>, &f64)| {
                    point.and_then(|point| mark(x, line, unit.size, point)).unwrap_or(hole(x))
                };
                Series { name: name.clone(), kind, look: Look::of(row), marks: points.map(of).collect() }
            })
            .collect();
        let mut values = extents(series.iter().flat_map(|series| &series.marks));
        values.retain(|value| !value.is_nan());
        let y = axis_of(panel.scale, &unit.title, &values);
        let title = format!("{} by {}", unit.title, self.study.label(columns));
        let legend = self.study.label(rows).to_owned();
        Chart { series, legend, ..Chart::new(title, x.axis, y) }.draw(CHART[0], CHART[1])
    }
}

pub fn capital(words: &str) -> String {
    let mut letters = words.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}
