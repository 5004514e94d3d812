//! Figures of two varied knobs: heat maps of the mapped panels and of the score, and line charts of the panels (CALF
//! figures 7 and 8).

use super::common::{Figure, KnobAxis, Mark, PanelUnit, chart, fixed_words, mark, point_at, sheet, subtitle};
use crate::report::plot::chart::{Chart, Series};
use crate::report::plot::heat::{Cell, HeatMap};
use crate::report::plot::marker::Look;
use crate::report::plot::{Drawing, number};
use crate::report::tradeoff::kind::{Better, Measured, Panel, PanelLine, Setting};
use crate::report::tradeoff::score::{self, Scored};
use crate::report::tradeoff::study::{Axis, Results, Study, product};

const MAP: [u32; 2] = [410, 340];
const CHART: [u32; 2] = [619, 340];
/// Maximum number of figures of a study with more than two axes.
const MAX_OF_A_STUDY: usize = 4;

/// Varied axes of a study: rows and columns of the heat maps.
pub struct Axes<'a> {
    pub rows: &'a Axis,
    pub columns: &'a Axis,
    pub others: &'a [&'a Axis],
}

struct Grid<'a> {
    results: &'a Results,
    study: &'a Study,
    axes: &'a Axes<'a>,
    points: Vec<Option<&'a Measured>>,
    chosen: Vec<Setting>,
}

struct MapValues {
    title: String,
    unit: &'static str,
    values: Vec<Option<f64>>,
    best: Option<usize>,
}

/// Returns one figure for each combination of values of the other axes, up to `MAX_OF_A_STUDY`.
pub fn figures(results: &Results, study: &Study, axes: Axes<'_>) -> Vec<Figure> {
    let combinations = product(&[], axes.others.iter().copied());
    let count = combinations.len();
    let left = count.saturating_sub(MAX_OF_A_STUDY);
    let note = if left == 0 { String::new() } else { format!(" {left} more combinations are in the table only.") };
    let shown = combinations.into_iter().take(MAX_OF_A_STUDY).enumerate();
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
        let (mut score, mut least) = (String::new(), String::new());
        if study.sweep.is_scored {
            let scored = Scored::new(self.points.clone(), results.weights);
            let [size, time] = [results.weights.compression, results.weights.decoding].map(number::short);
            let count = scored.count();
            score = format!(", and a score of bytes and time relative to the best of {count} points, which has 1");
            least = self.least_words(&scored);
            maps.push(self.map(&MapValues {
                title: format!("Score: size^{size} × time^{time}"),
                unit: "times the best",
                values: scored.scores,
                best: scored.best,
            }));
        }
        let caption = format!(
            "{} and {} against each other, {}: {}{score}. The best cell is framed.{least} Bars in the lower charts span the \
             shortest and the longest run, and a bar without an end is cut.{note}",
            capital(study.label(axes.rows)),
            study.label(axes.columns),
            fixed_words(&self.chosen),
            titles.join(", "),
        );
        let measured = self.points.iter().flatten().copied();
        let subtitle = subtitle(results, study, &self.chosen, measured);
        Figure { name, caption, drawing: sheet(&study.title, &subtitle, vec![maps, lines]) }
    }

    /// Returns a sentence that names the point with the lowest score, and warns if quality differs, which the score
    /// ignores.
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
            let value = point.drawn(line.measure)? / unit.size;
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

    fn lines(&self, panel: &Panel, line: &PanelLine) -> Drawing {
        let Axes { rows, columns, .. } = self.axes;
        let x = KnobAxis::new(self.study, columns);
        let unit = self.unit(panel, line);
        // A missing point interrupts the line.
        let hole = |x: f64| Mark { x, y: f64::NAN, ..Mark::default() };
        let of = |(point, &x): (&Option<&Measured>, &f64)| {
            point.and_then(|point| mark(x, line, unit.size, point)).unwrap_or(hole(x))
        };
        let each = rows.values.iter().zip(self.points.chunks(columns.values.len())).enumerate();
        let series = each.map(|(row, (name, points))| {
            let marks = points.iter().zip(&x.places).map(of).collect();
            Series { name: name.clone(), kind: x.kind, look: Look::of(row), marks }
        });
        let series = series.collect();
        let legend = self.study.label(rows).to_owned();
        Chart { legend, ..chart(x, panel.scale, &unit, series) }.draw(CHART[0], CHART[1])
    }
}

pub fn capital(words: &str) -> String {
    let mut letters = words.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}
