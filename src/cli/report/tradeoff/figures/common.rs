//! Shared parts of figures: axes of knobs, marks with their range, and words below titles.

use crate::report::plot::chart::{Chart, Kind, Series};
use crate::report::plot::{axis, number};
use crate::report::statistics::runs_in_words;
use crate::report::tradeoff::kind::{PanelLine, Scale};
use crate::report::tradeoff::point::{Measured, Point, Setting, words};
use crate::report::tradeoff::study::{Axis, Results, Study};

pub use crate::report::plot::chart::Mark;

/// Axis of a knob, with the position of each value.
pub struct KnobAxis {
    label: &'static str,
    pub axis: axis::Axis,
    pub places: Vec<f64>,
    /// How series along the axis are drawn. Values that are words are not joined by lines.
    pub kind: Kind,
}

impl KnobAxis {
    /// Places numbers by value and words in their order.
    pub fn new(study: &Study, along: &Axis) -> KnobAxis {
        let label = study.label(along);
        match along.numbers() {
            Some(places) => KnobAxis { label, axis: axis::Axis::of_settings(label, &places), places, kind: Kind::Line },
            None => {
                let places = (0..along.values.len()).map(|at| at as f64).collect();
                KnobAxis { label, axis: axis::Axis::of_words(label, &along.values), places, kind: Kind::Points }
            }
        }
    }
}

/// Returns the point of a study at the given values of its varied axes.
pub fn point_at(study: &Study, values: impl IntoIterator<Item = Setting>) -> Point {
    let single =
        study.axes.iter().filter(|axis| axis.values.len() == 1).map(|axis| (axis.knob, axis.values[0].clone()));
    Point::new(study.sweep, study.stream, study.fixed.iter().cloned().chain(single).chain(values).collect())
}

/// Returns the mark of a point with the range of its runs. Values are divided by `unit`.
pub fn mark(x: f64, line: &PanelLine, unit: f64, point: &Measured) -> Option<Mark> {
    let factor = point.kind.measure(line.measure)?.factor() / unit;
    let spread = point.spread(line.measure).map(|spread| (spread.low * factor, spread.high * factor));
    Some(Mark { x, y: point.number(line.measure)? * factor, spread, name: None })
}

/// Returns the values that an axis must show: marks and their ranges, capped at twice the largest mark, so that one
/// outlier run does not flatten the rest.
pub fn extents<'a>(marks: impl Iterator<Item = &'a Mark> + Clone) -> Vec<f64> {
    let finite = marks.clone().map(|mark| mark.y).filter(|y| y.is_finite());
    let most = 2.0 * finite.fold(0.0, f64::max);
    let values = marks.flat_map(|mark| {
        let (low, high) = mark.spread.unwrap_or((mark.y, mark.y));
        [mark.y, low, high.min(most.max(mark.y))]
    });
    values.filter(|value| !value.is_nan()).collect()
}

pub fn chart(along: KnobAxis, scale: Scale, unit: &PanelUnit, series: Vec<Series>) -> Chart {
    let values = extents(series.iter().flat_map(|series| &series.marks));
    let title = format!("{} by {}", unit.title, along.label);
    Chart { series, ..Chart::new(title, along.axis, axis_of(scale, &unit.title, &values)) }
}

/// Returns a vertical axis for values in the unit that the label names.
pub fn axis_of(scale: Scale, label: &str, values: &[f64]) -> axis::Axis {
    let each = values.iter().copied();
    match scale {
        Scale::Bytes | Scale::Linear => axis::Axis::linear(label, each),
        Scale::Logarithmic => axis::Axis::logarithmic(label, each),
        Scale::WithoutZero => axis::Axis::without_zero(label, each),
        Scale::Decibels => {
            let axis = axis::Axis::without_zero(label, each);
            if values.contains(&f64::INFINITY) { axis.with_infinite("lossless") } else { axis }
        }
    }
}

/// Unit of a panel's values, and its title with the unit.
pub struct PanelUnit {
    pub size: f64,
    pub name: &'static str,
    pub title: String,
}

impl PanelUnit {
    pub fn new(scale: Scale, title: &str, values: impl Iterator<Item = f64>) -> PanelUnit {
        if scale == Scale::Bytes {
            let unit = number::bytes_unit(values.fold(0.0, f64::max));
            PanelUnit { size: unit.size, name: unit.name, title: format!("{title} ({})", unit.name) }
        } else {
            PanelUnit { size: 1.0, name: "", title: title.to_owned() }
        }
    }
}

pub fn fixed_words(settings: &[Setting]) -> String {
    match words(settings) {
        Some(words) => format!("with {words}, other settings by default"),
        None => "other settings by default".to_owned(),
    }
}

pub fn subtitle<'a>(
    results: &Results,
    study: &Study,
    others: &[Setting],
    points: impl IntoIterator<Item = &'a Measured>,
) -> Vec<String> {
    let settings: Vec<Setting> = study.fixed.iter().chain(others).cloned().collect();
    let of = study.stream.map_or_else(String::new, |stream| format!("{} of ", stream.name()));
    let first = format!("{of}{}, {}", results.input, fixed_words(&settings));
    [first].into_iter().chain(times(points)).collect()
}

/// Describes how often points were timed. `None` without runs.
pub fn times<'a>(points: impl IntoIterator<Item = &'a Measured>) -> Option<String> {
    let mut points = points.into_iter().peekable();
    let of_streams = points.peek()?.point.stream.is_some();
    let runs = runs_in_words(points.map(Measured::timed_runs))?;
    let frame = if of_streams { " A frame has the images of all probes and faces." } else { "" };
    Some(format!("Times: {runs}.{frame}"))
}
