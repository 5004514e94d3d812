//! Figures of one varied knob: all panels along its values.

use super::common::{Figure, KnobAxis, Mark, PanelUnit, chart, mark, point_at, sheet, subtitle};
use crate::report::plot::chart::{Chart, Series};
use crate::report::plot::marker::Look;
use crate::report::tradeoff::kind::{Measured, Panel};
use crate::report::tradeoff::study::{Axis, Results, Study};

const CHART: [u32; 2] = [500, 320];

pub struct Along<'a> {
    study: &'a Study,
    axis: &'a Axis,
    pub points: Vec<PlacedPoint<'a>>,
}

pub struct PlacedPoint<'a> {
    pub x: f64,
    pub point: &'a Measured,
}

/// Returns the points of a study along its one varied axis.
pub fn along<'a>(results: &'a Results, study: &'a Study, axis: &'a Axis) -> Along<'a> {
    let placed = axis.values.iter().zip(KnobAxis::new(study, axis).places);
    let point = |value: &String| results.of(&point_at(study, [(axis.knob, value.clone())]));
    let mut points: Vec<PlacedPoint<'_>> =
        placed.filter_map(|(value, x)| Some(PlacedPoint { x, point: point(value)? })).collect();
    points.sort_by(|a, b| a.x.total_cmp(&b.x));
    Along { study, axis, points }
}

impl Along<'_> {
    /// Returns the chart of a panel. `None` without values.
    pub fn chart(&self, panel: &Panel) -> Option<Chart> {
        let lines = || panel.lines.iter();
        let all = self.points.iter().flat_map(|of| lines().filter_map(|line| of.point.number(line.measure)));
        let unit = PanelUnit::new(panel.scale, panel.title, all);
        let x = KnobAxis::new(self.study, self.axis);
        let marks = lines().map(|line| {
            let marks = self.points.iter().filter_map(|of| mark(of.x, line, unit.size, of.point));
            (line, marks.collect::<Vec<Mark>>())
        });
        let marks = marks.filter(|(_, marks)| !marks.is_empty()).enumerate();
        let series = marks.map(|(at, (line, marks))| {
            let (name, look) = (line.label.to_owned(), Look::of(at));
            Series { name, kind: x.kind, look, marks }
        });
        let series = joined(series.collect());
        let has_value = series.iter().flat_map(|series| &series.marks).any(|mark| !mark.y.is_nan());
        has_value.then(|| chart(x, panel.scale, &unit, series))
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

pub fn figure(results: &Results, study: &Study, axis: &Axis) -> Option<Figure> {
    let along = along(results, study, axis);
    if along.points.is_empty() {
        return None;
    }
    let panels = study.sweep.panels.iter().filter(|panel| panel.concerns(study.stream));
    let charts = panels.filter_map(|panel| along.chart(panel));
    let drawn: Vec<_> = charts.map(|chart| chart.draw(CHART[0], CHART[1])).collect();
    let rows = drawn.chunks(3).map(<[_]>::to_vec).collect();
    let caption = format!(
        "{}: all measures by {}. Times are medians; bars span the shortest and the longest run, and a bar without an end is \
         cut.",
        study.title,
        study.label(axis)
    );
    let measured = along.points.iter().map(|of| of.point);
    let drawing = sheet(&study.title, &subtitle(results, study, &[], measured), rows);
    Some(Figure { name: study.name.clone(), caption, drawing })
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
