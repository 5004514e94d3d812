//! Figures of studies: all panels along one varied knob; heat maps and lines of two (CALF figures 7 and 8); decoding by
//! error bound (GDC figure 8).

use super::common::{KnobAxis, Mark, PanelUnit, axis_of, chart, extents, fixed_words, mark, point_at, subtitle};
use crate::report::plot::chart::{Chart, Rule, Series};
use crate::report::plot::heat::{Cell, HeatMap};
use crate::report::plot::labels::sheet;
use crate::report::plot::marker::Look;
use crate::report::plot::{Drawing, Figure, number};
use crate::report::tradeoff::findings::in_boxes;
use crate::report::tradeoff::kind::{Better, Panel, PanelLine, concerns};
use crate::report::tradeoff::point::{Measured, Setting};
use crate::report::tradeoff::score::{self, Scored};
use crate::report::tradeoff::study::{Axis, Results, Study, capital, product};

/// Returns the figures of a study: none without a varied knob.
pub fn figures(results: &Results, study: &Study) -> Vec<Figure> {
    match study.varied().as_slice() {
        [] => Vec::new(),
        [axis] => row(results, study, axis).into_iter().collect(),
        [rows, columns, others @ ..] => grids(results, study, Axes { rows, columns, others }),
    }
}

const CHART: [u32; 2] = [500, 320];

/// Points of a study along its one varied axis, with their places.
struct Along<'a> {
    study: &'a Study,
    axis: &'a Axis,
    points: Vec<(f64, &'a Measured)>,
}

impl<'a> Along<'a> {
    fn new(results: &'a Results, study: &'a Study, axis: &'a Axis) -> Along<'a> {
        let placed = KnobAxis::new(study, axis).places.into_iter().zip(&axis.values);
        let point = |value: &String| results.of(&point_at(study, [(axis.knob, value.clone())]));
        let mut points: Vec<_> = placed.filter_map(|(x, value)| Some((x, point(value)?))).collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        Along { study, axis, points }
    }

    /// Returns the chart of a panel. `None` without values.
    fn chart(&self, panel: &Panel) -> Option<Chart> {
        let all = self.points.iter().flat_map(|(_, of)| panel.lines.iter().filter_map(|line| of.number(line.measure)));
        let unit = PanelUnit::new(panel.scale, panel.title, all);
        let x = KnobAxis::new(self.study, self.axis);
        let marks = |line: &PanelLine| -> Vec<Mark> {
            self.points.iter().filter_map(|(x, point)| mark(*x, line, unit.size, point)).collect()
        };
        let lines = panel.lines.iter().map(|line| (line, marks(line))).filter(|(_, marks)| !marks.is_empty());
        let series = lines.enumerate().map(|(at, (line, marks))| Series {
            name: line.label.to_owned(),
            kind: x.kind,
            look: Look::of(at),
            marks,
        });
        let series = joined(series.collect());
        let has_value = series.iter().flat_map(|series| &series.marks).any(|mark| !mark.y.is_nan());
        has_value.then(|| chart(x, panel.scale, &unit, series))
    }

    /// Returns a sheet with the chart of each panel.
    fn sheet(&self, results: &Results, title: &str, rows: Vec<Vec<Drawing>>) -> Drawing {
        let lines = subtitle(results, self.study, &[], self.points.iter().map(|(_, point)| *point));
        sheet(title, &lines, rows)
    }
}

/// Fraction of the largest value below which a difference is not visible in a chart.
const UNSEEN: f64 = 0.004;

/// Merges series that would be drawn on top of an earlier one into that one.
fn joined(all: Vec<Series>) -> Vec<Series> {
    let values = all.iter().flat_map(|series| &series.marks).map(|mark| mark.y.abs());
    let near = UNSEEN * values.filter(|y| y.is_finite()).fold(0.0, f64::max);
    let mut kept: Vec<Series> = Vec::new();
    for series in all {
        let covers = |one: &&mut Series| {
            let mut pairs = one.marks.iter().zip(&series.marks);
            let is_same = |(a, b): (&Mark, &Mark)| a.x == b.x && (a.y == b.y || (a.y - b.y).abs() <= near);
            one.marks.len() == series.marks.len() && pairs.all(is_same)
        };
        match kept.iter_mut().find(covers) {
            Some(one) => one.name = format!("{}, {}", one.name, series.name),
            None => kept.push(series),
        }
    }
    kept
}

fn row(results: &Results, study: &Study, axis: &Axis) -> Option<Figure> {
    let along = Along::new(results, study, axis);
    if along.points.is_empty() {
        return None;
    }
    let panels = study.sweep.panels.iter().filter(|panel| concerns(&panel.streams, study.stream));
    let drawn: Vec<_> =
        panels.filter_map(|panel| along.chart(panel)).map(|chart| chart.draw(CHART[0], CHART[1])).collect();
    let caption = format!(
        "{}: all measures by {}. Times are medians; bars span the shortest and the longest run, and a bar without an end is \
         cut.",
        study.title,
        study.label(axis)
    );
    let drawing = along.sheet(results, &study.title, drawn.chunks(3).map(<[_]>::to_vec).collect());
    Some(Figure { name: study.name.clone(), caption, drawing })
}

const MAP: [u32; 2] = [410, 340];
const GRID_CHART: [u32; 2] = [619, 340];
/// Maximum number of figures of a study with more than two axes.
const MAX_OF_A_STUDY: usize = 4;

/// Varied axes of a study: rows and columns of the heat maps.
struct Axes<'a> {
    rows: &'a Axis,
    columns: &'a Axis,
    others: &'a [&'a Axis],
}

struct Grid<'a> {
    results: &'a Results,
    study: &'a Study,
    axes: &'a Axes<'a>,
    points: Vec<Option<&'a Measured>>,
    chosen: Vec<Setting>,
}

/// Returns one figure for each combination of values of the other axes, up to `MAX_OF_A_STUDY`.
fn grids(results: &Results, study: &Study, axes: Axes<'_>) -> Vec<Figure> {
    let combinations = product(&[], axes.others.iter().copied());
    let count = combinations.len();
    let note = match count.saturating_sub(MAX_OF_A_STUDY) {
        0 => String::new(),
        left => format!(" {left} more combinations are in the table only."),
    };
    let figure = |(at, chosen): (usize, Vec<Setting>)| {
        let cell = |row: &String, column: &String| {
            let cell = [(axes.rows.knob, row.clone()), (axes.columns.knob, column.clone())];
            results.of(&point_at(study, chosen.iter().cloned().chain(cell)))
        };
        let rows = axes.rows.values.iter();
        let points: Vec<_> = rows
            .flat_map(|row| axes.columns.values.iter().map(|column| cell(row, column)).collect::<Vec<_>>())
            .collect();
        points.iter().flatten().next()?;
        let name = if count > 1 { format!("{}-{}", study.name, at + 1) } else { study.name.clone() };
        Some(Grid { results, study, axes: &axes, points, chosen }.figure(name, &note))
    };
    combinations.into_iter().take(MAX_OF_A_STUDY).enumerate().filter_map(figure).collect()
}

impl Grid<'_> {
    fn figure(&self, name: String, note: &str) -> Figure {
        let Grid { results, study, axes, points, .. } = self;
        let (mut maps, mut lines, mut titles) = (Vec::new(), Vec::new(), Vec::new());
        for panel in study.sweep.panels.iter().filter(|panel| concerns(&panel.streams, study.stream)) {
            let (Some(line), Some(better)) = (panel.lines.first(), panel.map) else { continue };
            let all = points.iter().flatten().filter_map(|point| point.number(line.measure));
            let unit = PanelUnit::new(panel.scale, panel.title, all);
            let value = |point: &Measured| Some(point.drawn(line.measure)? / unit.size).filter(|of| of.is_finite());
            let values: Vec<Option<f64>> = points.iter().map(|point| point.and_then(value)).collect();
            let sign = if better == Better::Less { 1.0 } else { -1.0 };
            let best = score::best(&values.iter().map(|value| value.map(|value| sign * value)).collect::<Vec<_>>());
            lines.push(self.lines(panel, line, &unit));
            maps.push(self.map(unit, &values, best));
            titles.push(panel.title);
        }
        let (mut score, mut least) = (String::new(), String::new());
        if study.sweep.is_scored {
            let scored = Scored::new(points.clone(), results.weights);
            let [size, time] = [results.weights.compression, results.weights.decoding].map(number::short);
            let count = scored.count();
            score = format!(", and a score of bytes and time relative to the best of {count} points, which has 1");
            least = scored.best.map_or_else(String::new, |at| self.least_words(at, scored.quality_differs()));
            let title = format!("Score: size^{size} × time^{time}");
            maps.push(self.map(PanelUnit { size: 1.0, name: "times the best", title }, &scored.scores, scored.best));
        }
        let caption = format!(
            "{} and {} against each other, {}: {}{score}. The best cell is framed.{least} Bars in the lower charts span the \
             shortest and the longest run, and a bar without an end is cut.{note}",
            capital(study.label(axes.rows)),
            study.label(axes.columns),
            fixed_words(&self.chosen),
            titles.join(", "),
        );
        let subtitle = subtitle(results, study, &self.chosen, points.iter().flatten().copied());
        Figure { name, caption, drawing: sheet(&study.title, &subtitle, vec![maps, lines]) }
    }

    /// Returns a sentence that names the point with the lowest score, and warns if quality differs, which the score
    /// ignores.
    fn least_words(&self, at: usize, quality_differs: bool) -> String {
        let Axes { rows, columns, .. } = self.axes;
        let (row, column) = (&rows.values[at / columns.values.len()], &columns.values[at % columns.values.len()]);
        let settings = format!("{}={row} {}={column}", rows.knob, columns.knob);
        match quality_differs {
            true => format!(
                " The least bytes and time have {settings}, but points differ in quality, which the score ignores."
            ),
            false => format!(" The best score has {settings}."),
        }
    }

    fn map(&self, of: PanelUnit, values: &[Option<f64>], best: Option<usize>) -> Drawing {
        let cell = |value: &Option<f64>| value.map(|value| Cell { value, text: number::even(value) });
        let label = |axis: &Axis| (self.study.label(axis).to_owned(), axis.values.clone());
        let (columns, rows) = (label(self.axes.columns), label(self.axes.rows));
        let cells = values.iter().map(cell).collect();
        HeatMap { title: of.title, columns, rows, cells, best, unit: of.name.to_owned() }.draw(MAP[0], MAP[1])
    }

    fn lines(&self, panel: &Panel, line: &PanelLine, unit: &PanelUnit) -> Drawing {
        let Axes { rows, columns, .. } = self.axes;
        let x = KnobAxis::new(self.study, columns);
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
        Chart { legend, ..chart(x, panel.scale, unit, series) }.draw(GRID_CHART[0], GRID_CHART[1])
    }
}

const BOUND_CHART: [u32; 2] = [500, 330];

/// Returns a figure of decoding time by error bound, compared with depth without modelling functions (GDC figure 8), for
/// each timed study that varies only the error bound.
pub fn bounds(results: &Results) -> Vec<Figure> {
    let of = |study: &Study| match study.varied().as_slice() {
        [axis] if axis.knob == "max-error" => bound(results, study, axis),
        _ => None,
    };
    results.studies.iter().filter_map(of).collect()
}

fn bound(results: &Results, study: &Study, axis: &Axis) -> Option<Figure> {
    let along = Along::new(results, study, axis);
    let base = in_boxes(results, &study.fixed);
    let draw = |panel: &Panel| {
        let mut chart = along.chart(panel)?;
        let base = base.and_then(|base| base.number(panel.lines.first()?.measure)).filter(|y| y.is_finite());
        let marks = chart.series.iter().flat_map(|series| &series.marks);
        chart.y = axis_of(panel.scale, panel.title, &extents(marks).into_iter().chain(base).collect::<Vec<_>>());
        chart.rules = base.into_iter().map(|y| Rule { y, name: "boxes of codes".to_owned() }).collect();
        Some(chart.draw(BOUND_CHART[0], BOUND_CHART[1]))
    };
    let row: Vec<Drawing> = study.sweep.bounds.iter().map(draw).collect::<Option<_>>()?;
    let beside = match base {
        Some(_) => " The dashed line is depth in boxes of codes, without modelling functions.",
        None => " Depth without modelling functions (depth-codec aabb) was not measured.",
    };
    let caption = format!(
        "Time of decoding a frame (all probes and faces), pixels shown in a second and the part of them that was \
         written, by the bound E on the error of every pixel. Points are medians, bars span the shortest and the longest \
         run; a bar without an end is cut.{beside}"
    );
    let drawing = along.sheet(results, "Decoding by error bound (GDC figure 8)", vec![row]);
    Some(Figure { name: format!("{}-decoding", study.name), caption, drawing })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::plot::chart::Kind;

    #[test]
    fn a_series_that_would_hide_another_is_joined_with_it() {
        let series = |name: &str, ys: &[f64]| {
            let marks = ys.iter().zip(0u32..).map(|(&y, x)| Mark { x: x.into(), y, spread: None, name: None });
            Series { name: name.into(), kind: Kind::Line, look: Look::of(0), marks: marks.collect() }
        };
        let names = |all: Vec<Series>| joined(all).into_iter().map(|series| series.name).collect::<Vec<_>>();
        let (one, close) =
            (series("one", &[823.0, f64::INFINITY, 40.0]), series("close", &[822.0, f64::INFINITY, 41.0]));
        assert_eq!(names(vec![one.clone(), close]), ["one, close"]);
        for other in [&[823.0, f64::INFINITY, 60.0][..], &[823.0, f64::INFINITY], &[823.0, 40.0, 40.0]] {
            assert_eq!(names(vec![one.clone(), series("other", other)]), ["one", "other"]);
        }
    }
}
