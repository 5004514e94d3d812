//! Two knobs against each other: heat maps of bytes, decoding time and score, and lines of the first two (CALF figures
//! 7 and 8).

use super::{
    Figure, Mark, axis_of, extents, fixed_words, label_of, point_at, seconds_per_frame_ms, sheet, subtitle, timed,
};
use crate::report::plot::Drawing;
use crate::report::plot::axis;
use crate::report::plot::chart::{Chart, Kind, Series};
use crate::report::plot::heat::{Cell, HeatMap};
use crate::report::plot::marker::Look;
use crate::report::plot::number::{self, Unit};
use crate::report::tradeoff::point::Measured;
use crate::report::tradeoff::score::{self, Scored};
use crate::report::tradeoff::study::{Axis, Results, Study, product};

/// Sizes of heat maps and of charts in pixels.
const MAP: [u32; 2] = [410, 340];
const CHART: [u32; 2] = [619, 340];

/// The points of one figure: rows of the first axis, in each those of the second.
struct Grid<'a> {
    rows: &'a Axis,
    columns: &'a Axis,
    points: Vec<Option<&'a Measured>>,
    unit: Unit,
}

/// One figure for each combination of the other axes' values, the first few of them.
pub(super) fn figures(
    results: &Results,
    study: &Study,
    (rows, columns): (&Axis, &Axis),
    others: &[&Axis],
) -> Vec<Figure> {
    let combinations = product(&[], others.iter().copied());
    let count = combinations.len();
    let shown = combinations.into_iter().take(super::MOST_OF_A_STUDY);
    shown
        .enumerate()
        .filter_map(|(at, chosen)| {
            let at_cell = |row: &String, column: &String| {
                let cell = [(rows.knob, row.clone()), (columns.knob, column.clone())];
                point_at(study, chosen.iter().cloned().chain(cell))
            };
            let points = rows.values.iter().flat_map(|row| columns.values.iter().map(move |column| (row, column)));
            let points: Vec<Option<&Measured>> =
                points.map(|(row, column)| results.of(&at_cell(row, column))).collect();
            let name = if count > 1 { format!("{}-{}", study.name, at + 1) } else { study.name.clone() };
            let left = count.saturating_sub(super::MOST_OF_A_STUDY);
            let note = match left {
                0 => String::new(),
                _ => format!(" {left} more combinations are in the table only."),
            };
            let largest = points.iter().flatten().map(|point| point.sizes.container).max()?;
            let grid = Grid { rows, columns, points, unit: number::bytes_unit(largest as f64) };
            let (drawing, caption) = grid.figure(results, study, &chosen);
            Some(Figure { name, caption: format!("{caption}{note}"), drawing })
        })
        .collect()
}

impl Grid<'_> {
    /// The picture and what is written under it.
    fn figure(&self, results: &Results, study: &Study, chosen: &[(&'static str, String)]) -> (Drawing, String) {
        let weights = results.weights;
        let scored = Scored::new(self.points.clone(), weights);
        let score_title =
            format!("Score: size^{} × time^{}", number::short(weights.compression), number::short(weights.decoding));
        let of = |value: &dyn Fn(&Measured) -> Option<f64>| -> Vec<Option<f64>> {
            self.points.iter().map(|point| point.and_then(value)).collect()
        };
        let bytes = of(&|point| Some(point.sizes.container as f64 / self.unit.size));
        let decode = of(&Measured::decode_ms_per_frame);
        let size = format!("Container ({})", self.unit.name);
        let time = "Decoding (ms a frame)";
        let maps = vec![
            self.map(&size, &bytes, score::best(&bytes), self.unit.name),
            self.map(time, &decode, score::best(&decode), "ms"),
            self.map(&score_title, &scored.scores, scored.best, "times the best"),
        ];
        let lines = vec![
            self.lines(&size, |point, x| {
                Some(Mark { x, y: point.sizes.container as f64 / self.unit.size, ..Mark::default() })
            }),
            self.lines(time, |point, x| timed(x, &point.decode, seconds_per_frame_ms(point))),
        ];
        let caption = format!(
            "{} and {} against each other, {}: bytes of the container, median time of decoding a frame (all probes and \
             faces), and a score of both in parts of the best of {} points, which has 1; less is better in all three, and \
             the least is framed.{} Bars in the lower charts span the shortest and the longest run, and a bar without an end \
             is cut.",
            capital(&label_of(self.rows)),
            label_of(self.columns),
            fixed_words(chosen),
            scored.count(),
            self.least_words(&scored),
        );
        let measured = self.points.iter().flatten().copied();
        let drawing = sheet(&study.title, &subtitle(results, study, chosen, measured), vec![maps, lines]);
        (drawing, caption)
    }

    /// Which point has the least score, and what that does not tell.
    fn least_words(&self, scored: &Scored<'_>) -> String {
        let Some(at) = scored.best else { return String::new() };
        let Grid { rows, columns, .. } = self;
        let (row, column) = (&rows.values[at / columns.values.len()], &columns.values[at % columns.values.len()]);
        let settings = format!("{}={row} {}={column}", rows.knob, columns.knob);
        if scored.quality_differs() {
            format!(
                " The least bytes and time have {settings}, but points differ in quality, which the score does not know."
            )
        } else {
            format!(" The best score has {settings}.")
        }
    }
    fn map(&self, title: &str, values: &[Option<f64>], best: Option<usize>, unit: &str) -> Drawing {
        let cell = |value: &Option<f64>| value.map(|value| Cell { value, text: number::even(value) });
        let map = HeatMap {
            title: title.to_owned(),
            columns: (label_of(self.columns), self.columns.values.clone()),
            rows: (label_of(self.rows), self.rows.values.clone()),
            cells: values.iter().map(cell).collect(),
            best,
            unit: unit.to_owned(),
        };
        map.draw(MAP[0], MAP[1])
    }

    /// A line for each row, along the columns; words are no way along which a line could go.
    fn lines(&self, title: &str, mark: impl Fn(&Measured, f64) -> Option<Mark>) -> Drawing {
        let (x, numbers) = axis_of(self.columns);
        let kind = if self.columns.numbers().is_some() { Kind::Line } else { Kind::Points };
        let width = self.columns.values.len();
        let series: Vec<Series> = self
            .rows
            .values
            .iter()
            .enumerate()
            .map(|(row, name)| {
                let points = self.points[row * width..(row + 1) * width].iter().zip(&numbers);
                // A hole in the grid is a hole in the line.
                let hole = |x: f64| Mark { x, y: f64::NAN, ..Mark::default() };
                let marks = points.map(|(point, &x)| point.and_then(|point| mark(point, x)).unwrap_or(hole(x)));
                Series { name: name.clone(), kind, look: Look::of(row), marks: marks.collect() }
            })
            .collect();
        let y = axis::Axis::linear(title, extents(series.iter().flat_map(|series| &series.marks)));
        let title = format!("{title} by {}", label_of(self.columns));
        Chart { series, legend: label_of(self.rows), ..Chart::new(title, x, y) }.draw(CHART[0], CHART[1])
    }
}

/// With a capital at the beginning.
fn capital(words: &str) -> String {
    let mut letters = words.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}
