//! One knob: all panels along its values.

use super::common::{Figure, KnobAxis, Mark, PanelUnit, Tiling, axis_of, extents, mark, point_at, sheet, subtitle};
use crate::report::plot::chart::{Chart, Kind, Series};
use crate::report::plot::marker::Look;
use crate::report::tradeoff::kind::{Measured, Panel};
use crate::report::tradeoff::study::{Axis, Results, Study};

/// Size of each chart in pixels.
const CHART: [u32; 2] = [500, 320];

/// Measured points of a study along an axis.
pub struct Along<'a> {
    study: &'a Study,
    axis: &'a Axis,
    pub points: Vec<PlacedPoint<'a>>,
}

/// A point and its place on the axis.
pub struct PlacedPoint<'a> {
    pub x: f64,
    pub point: &'a Measured,
}

/// The points of a study along its one varied axis.
pub fn along<'a>(results: &'a Results, study: &'a Study, axis: &'a Axis) -> Along<'a> {
    let places = KnobAxis::new(study, axis).places;
    let point = |value: &String| results.of(&point_at(study, [(axis.knob, value.clone())]));
    let placed = axis.values.iter().zip(places);
    let mut points: Vec<PlacedPoint<'_>> =
        placed.filter_map(|(value, x)| Some(PlacedPoint { x, point: point(value)? })).collect();
    points.sort_by(|a, b| a.x.total_cmp(&b.x));
    Along { study, axis, points }
}

impl Along<'_> {
    /// The chart of a panel; none without values.
    pub fn chart(&self, panel: &Panel) -> Option<Chart> {
        let value = |point: &PlacedPoint<'_>, measure: &str| point.point.number(measure);
        let all = self.points.iter().flat_map(|point| panel.lines.iter().filter_map(|line| value(point, line.measure)));
        let unit = PanelUnit::new(panel.scale, panel.title, all);
        let series: Vec<Series> = panel
            .lines
            .iter()
            .map(|line| {
                self.points.iter().filter_map(|of| mark(of.x, line, unit.size, of.point)).collect::<Vec<Mark>>()
            })
            .zip(panel.lines)
            .filter(|(marks, _)| !marks.is_empty())
            .enumerate()
            .map(|(at, (marks, line))| Series {
                name: line.label.to_owned(),
                kind: if self.axis.numbers().is_some() { Kind::Line } else { Kind::Points },
                look: Look::of(at),
                marks,
            })
            .collect();
        let mut values = extents(series.iter().flat_map(|series| &series.marks));
        values.retain(|value| !value.is_nan());
        if values.is_empty() {
            return None;
        }
        let y = axis_of(panel.scale, &unit.title, &values);
        let title = format!("{} by {}", unit.title, self.study.label(self.axis));
        Some(Chart { series, ..Chart::new(title, KnobAxis::new(self.study, self.axis).axis, y) })
    }
}

/// All panels along the axis.
pub fn figure(results: &Results, study: &Study, axis: &Axis) -> Option<Figure> {
    let along = along(results, study, axis);
    if along.points.is_empty() {
        return None;
    }
    let panels = study.sweep.panels.iter().filter(|panel| panel.concerns(study.stream));
    let charts = panels.filter_map(|panel| along.chart(panel));
    let drawn: Vec<_> = charts.map(|chart| chart.draw(CHART[0], CHART[1])).collect();
    let rows: Tiling = drawn.chunks(3).map(<[_]>::to_vec).collect();
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
