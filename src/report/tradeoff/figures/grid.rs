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
use crate::report::tradeoff::score;
use crate::report::tradeoff::study::{Axis, Results, Study};

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
    let mut combinations: Vec<Vec<(&'static str, String)>> = vec![vec![]];
    for axis in others {
        let with = |chosen: &Vec<(&'static str, String)>, value: &String| {
            chosen.iter().cloned().chain([(axis.knob, value.clone())]).collect::<Vec<_>>()
        };
        combinations =
            combinations.iter().flat_map(|chosen| axis.values.iter().map(move |value| with(chosen, value))).collect();
    }
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
            figure(results, study, (rows, columns, points), &chosen).map(|(drawing, caption)| Figure {
                name,
                caption: format!("{caption}{note}"),
                drawing,
            })
        })
        .collect()
}

fn figure(
    results: &Results,
    study: &Study,
    (rows, columns, points): (&Axis, &Axis, Vec<Option<&Measured>>),
    chosen: &[(&'static str, String)],
) -> Option<(Drawing, String)> {
    let largest = points.iter().flatten().map(|point| point.sizes.container).max()?;
    let grid = Grid { rows, columns, points, unit: number::bytes_unit(largest as f64) };
    let scores = score::scores(&grid.points, results.weights);
    let best = score::best(&scores);
    let weights = results.weights;
    let score_title =
        format!("Score: size^{} × time^{}", number::short(weights.compression), number::short(weights.decoding));

    let of = |value: &dyn Fn(&Measured) -> Option<f64>| -> Vec<Option<f64>> {
        grid.points.iter().map(|point| point.and_then(value)).collect()
    };
    let bytes = of(&|point| Some(point.sizes.container as f64 / grid.unit.size));
    let decode = of(&Measured::decode_ms_per_frame);
    let size = format!("Container ({})", grid.unit.name);
    let time = "Decoding (ms a frame)";
    let least = |values: &[Option<f64>]| score::best(values);
    let maps = vec![
        grid.map(&size, &bytes, least(&bytes), grid.unit.name),
        grid.map(time, &decode, least(&decode), "ms"),
        grid.map(&score_title, &scores, best, "times the best"),
    ];
    let lines = vec![
        grid.lines(&size, |point, x| {
            Some(Mark { x, y: point.sizes.container as f64 / grid.unit.size, ..Mark::default() })
        }),
        grid.lines(time, |point, x| timed(x, &point.decode, seconds_per_frame_ms(point))),
    ];
    let timed_points = scores.iter().flatten().count();
    let chosen_best = best.map_or_else(String::new, |at| {
        let (row, column) = (at / columns.values.len(), at % columns.values.len());
        format!(" The best score has {}={} {}={}.", rows.knob, rows.values[row], columns.knob, columns.values[column])
    });
    let caption = format!(
        "{} and {} against each other, {}: bytes of the container, median time of decoding a frame (all probes and \
         faces), and a score of both, in which 1 would be best in both of {timed_points} points; less is better in all \
         three, and the least is framed.{chosen_best} Bars in the lower charts span the shortest and the longest run; what leaves the chart is cut.",
        capital(&label_of(rows)),
        label_of(columns),
        fixed_words(chosen)
    );
    let drawing = sheet(&study.title, &subtitle(results, study, chosen), vec![maps, lines]);
    Some((drawing, caption))
}

impl Grid<'_> {
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

    /// A line for each row, along the columns.
    fn lines(&self, title: &str, mark: impl Fn(&Measured, f64) -> Option<Mark>) -> Drawing {
        let (x, numbers) = axis_of(self.columns);
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
                Series { name: name.clone(), kind: Kind::Line, look: Look::of(row), marks: marks.collect() }
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
