//! Heat maps: a grid of cells with printed values, the best cell marked, and a colour bar.

use super::axis::Axis;
use super::drawing::{Anchor, Drawing, Stroke, Text};
use super::font::{self, Weight};
use super::labels::{LONGEST_LABEL, MARGIN, NAME_EM, TICK_EM, TITLE_EM, name, tick, widest, write_title};
use super::{number, palette};

const SMALLEST_CELL: [f64; 2] = [30.0, 22.0];
const SMALLEST_EM: f64 = 7.0;
const BAR: f64 = 14.0;
/// Colours are logarithmic if the largest value exceeds the smallest by more than this factor.
const LOG_FROM: f64 = 12.0;

#[derive(Debug, Clone, PartialEq)]
pub struct Cell {
    /// Value that determines the colour, in the unit of the bar.
    pub value: f64,
    pub text: String,
}

/// A heat map. Smaller values are darker.
#[derive(Debug, Clone, PartialEq)]
pub struct HeatMap {
    pub title: String,
    pub columns: (String, Vec<String>),
    /// Title of the rows and the name of each, from the lowest up.
    pub rows: (String, Vec<String>),
    /// Cells row by row from the lowest row up, each row from left to right. `None` for cells without a value.
    pub cells: Vec<Option<Cell>>,
    pub best: Option<usize>,
    pub unit: String,
}

struct Shades {
    low: f64,
    high: f64,
    log: bool,
}

impl Shades {
    fn of(cells: &[Option<Cell>]) -> Shades {
        let finite = || cells.iter().flatten().map(|cell| cell.value).filter(|value| value.is_finite());
        let (low, high) = (finite().fold(f64::INFINITY, f64::min), finite().fold(f64::NEG_INFINITY, f64::max));
        Shades { low, high, log: low > 0.0 && high > LOG_FROM * low }
    }

    /// Position of a value on the colour scale, 0 for the smallest to 1 for the largest. 0.5 if all are equal.
    fn share(&self, value: f64) -> f64 {
        if value.is_infinite() {
            return 1.0;
        }
        let of = |value: f64| if self.log { value.ln() } else { value };
        let (low, high) = (of(self.low), of(self.high));
        if high > low { (of(value) - low) / (high - low) } else { 0.5 }
    }
}

#[derive(Clone, Copy)]
struct Grid {
    left: f64,
    bottom: f64,
    cell: [f64; 2],
    columns: usize,
}

impl Grid {
    /// Returns left, top, width and height of the cell at index `at`.
    fn cell(&self, at: usize) -> [f64; 4] {
        let ([width, height], column, row) = (self.cell, at % self.columns, at / self.columns);
        [self.left + column as f64 * width, self.bottom - (row + 1) as f64 * height, width, height]
    }
}

impl HeatMap {
    /// Draws the map at the given size in pixels. It grows if the cells need more space.
    pub fn draw(&self, width: u32, height: u32) -> Drawing {
        let (columns, rows) = (self.columns.1.len().max(1), self.rows.1.len().max(1));
        let shades = Shades::of(&self.cells);
        let bar = self.bar_axis(&shades);
        let bar_ticks = bar.as_ref().map_or(0.0, |bar| widest(bar.ticks.iter().map(|(_, label)| label)));
        let left = MARGIN + NAME_EM + 8.0 + widest(&self.rows.1).min(LONGEST_LABEL) + 8.0;
        let beside = 14.0 + BAR + 6.0 + bar_ticks + 8.0 + NAME_EM + MARGIN;
        let grid_width = (f64::from(width) - left - beside).max(SMALLEST_CELL[0] * columns as f64);
        let cell_width = grid_width / columns as f64;
        let column_names = widest(&self.columns.1);
        let upright = if column_names > cell_width - 4.0 { column_names.min(LONGEST_LABEL) } else { 0.0 };
        let under = 6.0 + upright.max(TICK_EM) + 8.0 + NAME_EM + MARGIN;
        let top = MARGIN + TITLE_EM + 14.0;
        let grid_height = (f64::from(height) - top - under).max(SMALLEST_CELL[1] * rows as f64);
        let (width, height) = ((left + grid_width + beside).ceil(), (top + grid_height + under).ceil());
        let mut drawing = Drawing::new(width as u32, height as u32, self.title.clone());

        write_title(&mut drawing, &self.title, width);
        let bottom = top + grid_height;
        let grid = Grid { left, bottom, cell: [cell_width, grid_height / rows as f64], columns };
        for at in 0..rows * columns {
            draw_cell(&mut drawing, grid.cell(at), self.cells.get(at).and_then(Option::as_ref), &shades);
        }
        if let Some(best) = self.best {
            // A white and a coloured frame, visible on dark and on bright cells.
            let [x, y, width, height] = grid.cell(best);
            for (ink, line_width) in [(super::Ink::WHITE, 5.0), (palette::MARK, 2.5)] {
                let stroke = Stroke::solid(ink, line_width);
                drawing.frame([x + 1.5, y + 1.5], [x + width - 1.5, y + height - 1.5], stroke);
            }
        }
        self.names(&mut drawing, grid, upright);
        if let Some(axis) = bar {
            let from = left + grid_width + 14.0;
            self.bar(&mut drawing, &axis, &shades, [from, top, from + BAR, bottom]);
        }
        drawing
    }

    fn names(&self, drawing: &mut Drawing, Grid { left, bottom, cell: [width, height], .. }: Grid, upright: f64) {
        for (row, name) in self.rows.1.iter().enumerate() {
            let y = bottom - (row as f64 + 0.5) * height;
            drawing.text_beside([left - 7.0, y], tick(name).anchor(Anchor::End).fit(LONGEST_LABEL));
        }
        for (column, name) in self.columns.1.iter().enumerate() {
            let x = left + (column as f64 + 0.5) * width;
            if upright > 0.0 {
                let x = x + TICK_EM * font::CAP_PER_EM / 2.0;
                drawing.text([x, bottom + 6.0], tick(name).up().anchor(Anchor::End).fit(upright));
            } else {
                drawing.text([x, bottom + 5.0 + TICK_EM], tick(name).anchor(Anchor::Middle));
            }
        }
        let (across, up) = (width * self.columns.1.len() as f64 / 2.0, height * self.rows.1.len() as f64 / 2.0);
        let lowest = f64::from(drawing.height) - MARGIN - 2.0;
        drawing.text([left + across, lowest], name(&self.columns.0, across * 2.0 + 60.0));
        drawing.text([MARGIN + NAME_EM, bottom - up], name(&self.rows.0, up * 2.0 + 60.0).up());
    }

    fn bar_axis(&self, shades: &Shades) -> Option<Axis> {
        let range = [shades.low, shades.high];
        if !range.iter().all(|value| value.is_finite()) || shades.high <= shades.low {
            return None;
        }
        let mut axis = if shades.log { Axis::logarithmic("", range) } else { Axis::linear("", range) };
        axis.ticks.retain(|&(value, _)| value >= shades.low && value <= shades.high);
        if axis.ticks.len() < 2 {
            axis.ticks = range.map(|value| (value, number::short(value))).to_vec();
        }
        Some(axis)
    }

    fn bar(&self, drawing: &mut Drawing, axis: &Axis, shades: &Shades, [left, top, right, bottom]: [f64; 4]) {
        let steps = (bottom - top).round().max(1.0) as usize;
        let at = |share: f64| bottom - (bottom - top) * share;
        for step in 0..steps {
            let (from, to) = (step as f64 / steps as f64, (step + 1) as f64 / steps as f64);
            // Strips overlap by half a pixel, so that no white line shows between them.
            let upper = (at(to) - 0.5).max(top);
            drawing.rectangle([left, at(from)], [right, upper], palette::viridis((from + to) / 2.0));
        }
        for (value, label) in &axis.ticks {
            let y = at(shades.share(*value));
            drawing.line(&[[right, y], [right + 3.0, y]], Stroke::solid(palette::TEXT, 1.0));
            drawing.text_beside([right + 6.0, y], tick(label));
        }
        let words = [&self.unit[..], if shades.log { "logarithmic" } else { "" }];
        let words = words.into_iter().filter(|words| !words.is_empty()).collect::<Vec<_>>();
        let name = name(&words.join(", "), bottom - top + 60.0).up();
        drawing.text([f64::from(drawing.width) - MARGIN, (top + bottom) / 2.0], name);
    }
}

/// Draws a cell at left, top, width and height. A cell without a value is grey and labelled `none`.
fn draw_cell(drawing: &mut Drawing, [x, y, width, height]: [f64; 4], cell: Option<&Cell>, shades: &Shades) {
    let (from, to) = ([x + 0.5, y + 0.5], [x + width - 0.5, y + height - 0.5]);
    let centre = [x + width / 2.0, y + height / 2.0];
    let Some(cell) = cell.filter(|cell| !cell.value.is_nan()) else {
        drawing.rectangle(from, to, palette::MISSING);
        drawing.text_beside(centre, tick("none").ink(palette::FAINT_TEXT).anchor(Anchor::Middle));
        return;
    };
    let ground = palette::viridis(shades.share(cell.value));
    drawing.rectangle(from, to, ground);
    let ems = [12.0, 11.0, 10.0, 9.0, 8.0, SMALLEST_EM];
    let fitting =
        ems.into_iter().find(|&em| font::width(&cell.text, em, Weight::Regular) <= width - 5.0 && em + 3.0 <= height);
    let text = Text::new(&cell.text, fitting.unwrap_or(SMALLEST_EM)).ink(palette::legible_on(ground));
    drawing.text_beside(centre, text.anchor(Anchor::Middle).fit(width - 2.0));
}

#[cfg(test)]
mod tests {
    use super::*;

    fn map(columns: usize, rows: usize, values: &[f64]) -> HeatMap {
        let names = |count: usize| (0..count).map(|at| at.to_string()).collect();
        HeatMap {
            title: "a map".to_owned(),
            columns: ("columns".to_owned(), names(columns)),
            rows: ("rows".to_owned(), names(rows)),
            cells: values.iter().map(|&value| Some(Cell { value, text: value.to_string() })).collect(),
            best: Some(0),
            unit: "MB".to_owned(),
        }
    }

    #[test]
    fn equal_values_have_the_middle_colour_and_no_bar() {
        let equal = map(2, 1, &[3.0, 3.0]);
        assert_eq!(Shades::of(&equal.cells).share(3.0), 0.5);
        assert_eq!(equal.bar_axis(&Shades::of(&equal.cells)), None);
    }

    #[test]
    fn wide_ranges_are_logarithmic() {
        let wide = map(3, 1, &[1.0, 10.0, 100.0]);
        assert!((Shades::of(&wide.cells).share(10.0) - 0.5).abs() < 1e-9);
        let narrow = map(3, 1, &[0.0, 10.0, 100.0]);
        assert!((Shades::of(&narrow.cells).share(10.0) - 0.1).abs() < 1e-9);
    }

    #[test]
    fn many_cells_make_a_larger_drawing() {
        let many = map(40, 30, &vec![1.0; 1200]).draw(300, 200);
        assert!(many.width > 40 * 30 && many.height > 30 * 22, "{} {}", many.width, many.height);
        let few = map(2, 2, &[1.0, 2.0, f64::NAN, f64::INFINITY]).draw(300, 200);
        assert_eq!((few.width, few.height), (300, 200));
    }
}
