//! The pictures of a report, one for each question; each as the papers' figures have it.

mod bound;
mod curves;
mod grid;
mod line;
mod tiles;

use super::knob;
use super::point::{self, Measured, Point, Timing};
use super::study::{Axis, Results, Study};
use crate::report::plot::Drawing;
use crate::report::plot::axis;
use crate::report::plot::chart::Mark;
use crate::report::plot::drawing::Text;
use crate::report::plot::palette;

/// Figures of one study at most, where it has more than two axes.
const MOST_OF_A_STUDY: usize = 4;

/// A picture with what is written under it.
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    /// Name of its files, without an ending.
    pub name: String,
    /// What it shows and how it is read, in sentences.
    pub caption: String,
    /// The picture.
    pub drawing: Drawing,
}

/// All figures that the results have something to show for, in the order of the page.
pub fn all(results: &Results) -> Vec<Figure> {
    let mut figures = Vec::new();
    for study in &results.studies {
        match study.varied().as_slice() {
            [] => {}
            [axis] => {
                figures.extend(line::figure(results, study, axis));
                figures.extend(bound::figure(results, study, axis));
            }
            [rows, columns, others @ ..] => {
                figures.extend(grid::figures(results, study, (rows, columns), others));
            }
        }
    }
    figures.extend(curves::figures(results));
    figures.extend(results.tiles.as_ref().and_then(|tiles| tiles::figure(tiles, &results.tiles_how)));
    figures
}

/// An axis of a chart for the values of a knob, and the number that each value has on it.
fn axis_of(axis: &Axis) -> (axis::Axis, Vec<f64>) {
    let label = knob::find(axis.knob).map_or(axis.knob, |knob| knob.label);
    match axis.numbers() {
        Some(numbers) => (axis::Axis::of_settings(label, &numbers), numbers),
        None => {
            let numbers = (0..axis.values.len()).map(|at| at as f64).collect();
            (axis::Axis::of_words(label, &axis.values), numbers)
        }
    }
}

/// A knob's name with its unit.
fn label_of(axis: &Axis) -> String {
    knob::find(axis.knob).map_or(axis.knob, |knob| knob.label).to_owned()
}

/// The study's point whose axes have these values; axes that have one value only need not be named.
fn point_at(study: &Study, values: impl IntoIterator<Item = (&'static str, String)>) -> Point {
    let single =
        study.axes.iter().filter(|axis| axis.values.len() == 1).map(|axis| (axis.knob, axis.values[0].clone()));
    Point::new(study.kind, study.fixed.iter().cloned().chain(single).chain(values).collect())
}

/// A mark with the spread of what was measured several times, in another unit.
fn timed(x: f64, timing: &Timing, unit: f64) -> Option<Mark> {
    let (low, high) = timing.spread()?;
    Some(Mark { x, y: timing.median()? / unit, spread: Some((low / unit, high / unit)), name: None })
}

/// The values that an axis is to show: those of marks, and of their spreads, from the least on and as far as they are less
/// than twice the largest mark. A run that another program disturbed should not make all others flat.
fn extents<'a>(marks: impl Iterator<Item = &'a Mark> + Clone) -> Vec<f64> {
    let finite = marks.clone().map(|mark| mark.y).filter(|y| y.is_finite());
    let most = 2.0 * finite.fold(0.0, f64::max);
    marks
        .flat_map(|mark| {
            let (low, high) = mark.spread.unwrap_or((mark.y, mark.y));
            [mark.y, low, high.min(most.max(mark.y))]
        })
        .collect()
}

/// Milliseconds of decoding for one point in time, from seconds of a whole run.
fn seconds_per_frame_ms(point: &Measured) -> f64 {
    1e-3 * point.frames.max(1) as f64
}

/// What settings a report's points have besides those of a study's axes.
fn fixed_words(settings: &[(&'static str, String)]) -> String {
    match point::words(settings) {
        Some(words) => format!("with {words}, other settings by default"),
        None => "other settings by default".to_owned(),
    }
}

/// Height of the title, and of each line under it, in pixels.
const HEAD: f64 = 30.0;
const LINE: f64 = 16.0;

/// A picture with a title and lines under it, and rows of drawings below.
fn sheet(title: &str, lines: &[String], rows: Vec<Vec<Drawing>>) -> Drawing {
    let head = HEAD + LINE * lines.len() as f64;
    let gap = 8.0;
    let row_width = |row: &Vec<Drawing>| row.iter().map(|one| f64::from(one.width) + gap).sum::<f64>();
    let row_height = |row: &Vec<Drawing>| row.iter().map(|one| f64::from(one.height)).fold(0.0, f64::max) + gap;
    let width = rows.iter().map(row_width).fold(480.0, f64::max);
    let height = head + rows.iter().map(row_height).sum::<f64>();
    let mut all = Drawing::new(width.ceil() as u32, height.ceil() as u32, title);
    let room = width - 24.0;
    all.text([12.0, 24.0], Text::new(title, 17.0).bold().ink(palette::TEXT).fit(room));
    for (at, line) in lines.iter().enumerate() {
        let baseline = HEAD - 4.0 + LINE * (at + 1) as f64;
        all.text([12.0, baseline], Text::new(line, 12.0).ink(palette::FAINT_TEXT).fit(room));
    }
    let mut y = head;
    for row in rows {
        let below = row_height(&row);
        let mut x = 0.0;
        for drawing in row {
            let next = x + f64::from(drawing.width) + gap;
            all.place([x, y], drawing);
            x = next;
        }
        y += below;
    }
    all
}

/// The lines under a title: what was measured, on what, and what its times are.
fn subtitle<'a>(
    results: &Results,
    study: &Study,
    others: &[(&'static str, String)],
    points: impl IntoIterator<Item = &'a Measured>,
) -> Vec<String> {
    let settings: Vec<(&'static str, String)> = study.fixed.iter().chain(others).cloned().collect();
    let first = format!("{} of {}, {}", study.kind.name(), results.input, fixed_words(&settings));
    [first].into_iter().chain(times(points)).collect()
}

/// What the times of points are; none where none was timed.
fn times<'a>(points: impl IntoIterator<Item = &'a Measured>) -> Option<String> {
    let runs = Timing::runs_in_words(points.into_iter().map(|point| &point.decode))?;
    Some(format!("Times: {runs}. A frame is one moment of the footage (all probes and faces)."))
}

#[cfg(test)]
mod tests;
