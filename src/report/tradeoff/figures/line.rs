//! One knob: all panels along its values.

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

/// The points of a study along its one varied axis.
pub fn along<'a>(results: &'a Results, study: &'a Study, axis: &'a Axis) -> Along<'a> {
    let placed = axis.values.iter().zip(KnobAxis::new(study, axis).places);
    let point = |value: &String| results.of(&point_at(study, [(axis.knob, value.clone())]));
    let mut points: Vec<PlacedPoint<'_>> =
        placed.filter_map(|(value, x)| Some(PlacedPoint { x, point: point(value)? })).collect();
    points.sort_by(|a, b| a.x.total_cmp(&b.x));
    Along { study, axis, points }
}

impl Along<'_> {
    /// The chart of a panel; none without values.
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
        let series: Vec<Series> = series.collect();
        let has_value = series.iter().flat_map(|series| &series.marks).any(|mark| !mark.y.is_nan());
        has_value.then(|| chart(x, panel.scale, &unit, series))
    }
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
