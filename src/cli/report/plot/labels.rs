//! Labels: sizes and text styles shared by charts, heat maps and legends, titles above several drawings, and placement of short labels beside points so
//! that they hide neither points nor each other.

use super::drawing::{Anchor, Drawing, Spot, Stroke, Text};
use super::font::{self, Weight};
use super::palette;

/// Font sizes of titles, axis names and ticks in pixels.
pub const TITLE_EM: f64 = 14.0;
pub const NAME_EM: f64 = 12.0;
pub const TICK_EM: f64 = 11.0;
pub const MARKER: f64 = 4.0;
pub const MARGIN: f64 = 12.0;
/// Maximum width of a tick or row label in pixels.
pub const LONGEST_LABEL: f64 = 110.0;

pub fn tick(label: &str) -> Text {
    Text::new(label, TICK_EM).ink(palette::TEXT)
}

/// Returns the text of an axis name, centred on its position and shortened to `room` pixels.
pub fn name(label: &str, room: f64) -> Text {
    Text::new(label, NAME_EM).ink(palette::TEXT).anchor(Anchor::Middle).fit(room)
}

pub fn write_title(drawing: &mut Drawing, title: &str, width: f64) {
    let text = Text::new(title, TITLE_EM).bold().ink(palette::TEXT).fit(width - 2.0 * MARGIN);
    drawing.text([MARGIN, MARGIN + TITLE_EM], text);
}

/// Returns the width in pixels of the widest tick label.
pub fn widest<'a>(labels: impl IntoIterator<Item = &'a String>) -> f64 {
    labels.into_iter().map(|label| font::width(label, TICK_EM, Weight::Regular)).fold(0.0, f64::max)
}

/// Heights of the title and of each line below it, in pixels.
const HEAD: f64 = 30.0;
const LINE: f64 = 16.0;
const GAP: f64 = 8.0;

/// Returns a drawing with a title, lines of text below it, and rows of drawings.
pub fn sheet(title: &str, lines: &[String], rows: Vec<Vec<Drawing>>) -> Drawing {
    let head = HEAD + LINE * lines.len() as f64;
    let row_width = |row: &Vec<Drawing>| row.iter().map(|one| f64::from(one.width) + GAP).sum::<f64>();
    let row_height = |row: &Vec<Drawing>| row.iter().map(|one| f64::from(one.height)).fold(0.0, f64::max) + GAP;
    let width = rows.iter().map(row_width).fold(480.0, f64::max);
    let height = head + rows.iter().map(row_height).sum::<f64>();
    let mut all = Drawing::new(width.ceil() as u32, height.ceil() as u32, title);
    let text_width = width - 24.0;
    all.text([12.0, 24.0], Text::new(title, 17.0).bold().ink(palette::TEXT).fit(text_width));
    for (at, line) in lines.iter().enumerate() {
        let baseline = HEAD - 4.0 + LINE * (at + 1) as f64;
        all.text([12.0, baseline], Text::new(line, 12.0).ink(palette::FAINT_TEXT).fit(text_width));
    }
    let mut y = head;
    for row in rows {
        let (mut x, below) = (0.0, y + row_height(&row));
        for drawing in row {
            let next = x + f64::from(drawing.width) + GAP;
            all.place([x, y], drawing);
            x = next;
        }
        y = below;
    }
    all
}

const EM: f64 = 11.0;

type Bounds = [f64; 4];

#[derive(Debug, Clone)]
pub struct Labels {
    inside: Bounds,
    taken: Vec<Bounds>,
    points: Vec<Spot>,
}

impl Labels {
    pub fn inside([left, top]: Spot, [right, bottom]: Spot) -> Labels {
        Labels { inside: [left, top, right, bottom], taken: Vec::new(), points: Vec::new() }
    }

    pub fn keep_off(&mut self, [x, y]: Spot, reach: f64) {
        self.taken.push([x - reach, y - reach, x + reach, y + reach]);
        self.points.push([x, y]);
    }

    /// Draws a label near a point. It takes the nearest free position that is closer to this point than to any other,
    /// else the nearest free position, else the position right of the point. Distant labels get a leader line.
    pub fn write(&mut self, drawing: &mut Drawing, spot: Spot, name: &str) {
        let text = Text::new(name, EM).bold().ink(palette::TEXT).anchor(Anchor::Middle);
        let (half_width, half_height) = (text.width() / 2.0 + 1.5, EM * font::CAP_PER_EM / 2.0 + 2.0);
        let around = |[x, y]: Spot| [x - half_width, y - half_height, x + half_width, y + half_height];
        let candidates = [0.0, 6.0, 14.0, 26.0, 40.0, 56.0].into_iter().flat_map(|gap| {
            DIRECTIONS.map(|[across, down]| {
                let reach = 6.0 + gap;
                [spot[0] + across * (reach + half_width), spot[1] + down * (reach + half_height)]
            })
        });
        let [left, top, right, bottom] = self.inside;
        let free = |at: &Bounds| {
            let is_inside = at[0] >= left && at[1] >= top - 10.0 && at[2] <= right + 10.0 && at[3] <= bottom;
            is_inside && !self.taken.iter().any(|taken| overlap(taken, at))
        };
        let near = [spot[0] + 6.0 + half_width, spot[1]];
        let own = |centre: &Spot| {
            let to = |[x, y]: Spot| (x - centre[0]).hypot(y - centre[1]);
            self.points.iter().all(|&other| to(other) > to(spot) - 1e-6)
        };
        let fitting: Vec<Spot> = candidates.into_iter().filter(|&centre| free(&around(centre))).collect();
        let centre = fitting.iter().find(|centre| own(centre)).or(fitting.first()).copied().unwrap_or(near);
        let (dx, dy) = (centre[0] - spot[0], centre[1] - spot[1]);
        if dx.abs() > half_width + 9.0 || dy.abs() > half_height + 9.0 {
            let end =
                [centre[0] - dx.signum() * half_width.min(dx.abs()), centre[1] - dy.signum() * 4.0f64.min(dy.abs())];
            drawing.line(&[spot, end], Stroke::solid(palette::FAINT_TEXT, 0.7));
        }
        self.taken.push(around(centre));
        drawing.text_beside(centre, text);
    }
}

/// Directions to search for a position, in order of preference: x to the right, y down. A front rises to the right, so
/// the first two directions avoid it.
const DIRECTIONS: [Spot; 8] =
    [[1.0, 1.0], [-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0], [1.0, 0.0], [0.0, -1.0], [0.0, 1.0], [-1.0, 0.0]];

fn overlap(a: &Bounds, b: &Bounds) -> bool {
    a[0] < b[2] && b[0] < a[2] && a[1] < b[3] && b[1] < a[3]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::plot::drawing::Shape;

    #[test]
    fn a_name_is_nearest_to_its_own_point() {
        let mut drawing = Drawing::new(400, 300, "");
        let mut labels = Labels::inside([0.0, 0.0], [400.0, 300.0]);
        let spots = [[151.0, 142.0], [150.0, 150.0]];
        spots.iter().for_each(|&spot| labels.keep_off(spot, 6.0));
        for (number, spot) in spots.iter().enumerate() {
            labels.write(&mut drawing, *spot, &number.to_string());
        }
        for shape in &drawing.shapes {
            let Shape::Text { at, text } = shape else { continue };
            // Centre of the capitals.
            let (x, y) = (at[0], at[1] - EM * font::CAP_PER_EM / 2.0);
            let to = |spot: Spot| (spot[0] - x).hypot(spot[1] - y);
            assert_eq!(text.text == "0", to(spots[0]) < to(spots[1]), "{text:?} at {at:?}");
        }
    }

    #[test]
    fn names_of_near_points_do_not_overlap() {
        let mut drawing = Drawing::new(400, 300, "");
        let mut labels = Labels::inside([0.0, 0.0], [400.0, 300.0]);
        let spots: Vec<Spot> = (0..9).map(|at| [150.0 + 5.0 * f64::from(at), 150.0 - f64::from(at)]).collect();
        spots.iter().for_each(|&spot| labels.keep_off(spot, 5.0));
        spots.iter().enumerate().for_each(|(at, &spot)| labels.write(&mut drawing, spot, &at.to_string()));
        let places: Vec<Spot> = drawing
            .shapes
            .iter()
            .filter_map(|shape| match shape {
                Shape::Text { at, .. } => Some(*at),
                _ => None,
            })
            .collect();
        assert_eq!(places.len(), 9);
        for (at, a) in places.iter().enumerate() {
            for b in &places[at + 1..] {
                assert!((a[0] - b[0]).abs() > 7.0 || (a[1] - b[1]).abs() > 8.0, "{a:?} {b:?}");
            }
        }
    }
}
