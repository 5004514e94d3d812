//! Drawings as lists of shapes. Coordinates are in pixels, x to the right, y down, origin in the upper left corner.

use super::font::{self, Weight};

pub type Spot = [f64; 2];

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ink {
    pub rgb: [u8; 3],
    /// 0 (transparent) to 1 (opaque).
    pub alpha: f64,
}

impl Ink {
    pub const BLACK: Ink = Ink::opaque([0, 0, 0]);
    pub const WHITE: Ink = Ink::opaque([255, 255, 255]);

    pub const fn opaque(rgb: [u8; 3]) -> Ink {
        Ink { rgb, alpha: 1.0 }
    }

    pub const fn with_alpha(self, alpha: f64) -> Ink {
        Ink { alpha, ..self }
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stroke {
    pub ink: Ink,
    pub width: f64,
    /// Lengths of dashes and gaps in pixels. `None` for a solid line.
    pub dash: Option<[f64; 2]>,
}

impl Stroke {
    pub const fn solid(ink: Ink, width: f64) -> Stroke {
        Stroke { ink, width, dash: None }
    }

    pub const fn dashed(ink: Ink, width: f64) -> Stroke {
        Stroke { ink, width, dash: Some([5.0, 4.0]) }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Anchor {
    Start,
    Middle,
    End,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Direction {
    Across,
    Up,
}

#[derive(Debug, Clone, PartialEq)]
pub struct Text {
    /// Text to draw. Control characters are replaced by spaces.
    pub text: String,
    pub em: f64,
    pub weight: Weight,
    pub ink: Ink,
    /// Part of the baseline that lies at the given position.
    pub anchor: Anchor,
    pub direction: Direction,
}

impl Text {
    pub fn new(text: impl AsRef<str>, em: f64) -> Text {
        let text = text.as_ref().chars().map(|letter| if letter.is_control() { ' ' } else { letter }).collect();
        Text { text, em, weight: Weight::Regular, ink: Ink::BLACK, anchor: Anchor::Start, direction: Direction::Across }
    }

    pub fn bold(self) -> Text {
        Text { weight: Weight::Bold, ..self }
    }

    pub fn ink(self, ink: Ink) -> Text {
        Text { ink, ..self }
    }

    pub fn anchor(self, anchor: Anchor) -> Text {
        Text { anchor, ..self }
    }

    pub fn up(self) -> Text {
        Text { direction: Direction::Up, ..self }
    }

    pub fn fit(self, room: f64) -> Text {
        Text { text: font::fit(&self.text, self.em, self.weight, room), ..self }
    }

    pub fn width(&self) -> f64 {
        font::width(&self.text, self.em, self.weight)
    }
}

#[derive(Debug, Clone, PartialEq)]
pub enum Shape {
    Line { through: Vec<Spot>, stroke: Stroke },
    Rectangle { from: Spot, to: Spot, ink: Ink },
    Polygon { corners: Vec<Spot>, ink: Ink },
    Disc { at: Spot, radius: f64, ink: Ink },
    Text { at: Spot, text: Text },
}

/// Shapes on a white background, in painting order.
#[derive(Debug, Clone, PartialEq)]
pub struct Drawing {
    pub width: u32,
    pub height: u32,
    /// One-line description; the title of an SVG file.
    pub title: String,
    pub shapes: Vec<Shape>,
}

/// A drawing for a page.
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    /// File name without extension.
    pub name: String,
    /// Sentences that explain the figure.
    pub caption: String,
    pub drawing: Drawing,
}

impl Drawing {
    pub fn new(width: u32, height: u32, title: impl Into<String>) -> Drawing {
        Drawing { width, height, title: title.into(), shapes: Vec::new() }
    }

    /// Draws a line through points. Draws nothing for fewer than two points.
    pub fn line(&mut self, through: &[Spot], stroke: Stroke) {
        let through: Vec<Spot> = through.iter().copied().filter(is_place).collect();
        if through.len() < 2 {
            return;
        }
        match stroke.dash {
            None => self.shapes.push(Shape::Line { through, stroke }),
            Some(dash) => {
                let stroke = Stroke { dash: None, ..stroke };
                let dashes = dashes(&through, dash).into_iter();
                self.shapes.extend(dashes.map(|through| Shape::Line { through, stroke }));
            }
        }
    }

    pub fn rectangle(&mut self, a: Spot, b: Spot, ink: Ink) {
        if is_place(&a) && is_place(&b) {
            let (from, to) = ([a[0].min(b[0]), a[1].min(b[1])], [a[0].max(b[0]), a[1].max(b[1])]);
            self.shapes.push(Shape::Rectangle { from, to, ink });
        }
    }

    /// Draws the outline of the rectangle between two opposite corners. The stroke is centred on the edge.
    pub fn frame(&mut self, [left, top]: Spot, [right, bottom]: Spot, stroke: Stroke) {
        self.line(&[[left, top], [right, top], [right, bottom], [left, bottom], [left, top]], stroke);
    }

    pub fn polygon(&mut self, corners: &[Spot], ink: Ink) {
        if corners.len() > 2 && corners.iter().all(is_place) {
            self.shapes.push(Shape::Polygon { corners: corners.to_vec(), ink });
        }
    }

    pub fn disc(&mut self, at: Spot, radius: f64, ink: Ink) {
        if is_place(&at) && radius.is_finite() {
            self.shapes.push(Shape::Disc { at, radius, ink });
        }
    }

    /// Draws a text. `at` is the point of its baseline given by the anchor.
    pub fn text(&mut self, at: Spot, text: Text) {
        if is_place(&at) && !text.text.trim().is_empty() {
            self.shapes.push(Shape::Text { at, text });
        }
    }

    /// Draws a horizontal text whose capitals are vertically centred on `at`.
    pub fn text_beside(&mut self, [x, y]: Spot, text: Text) {
        self.text([x, y + text.em * font::CAP_PER_EM / 2.0], text);
    }

    /// Copies another drawing into this one, its upper left corner at `at`.
    pub fn place(&mut self, [dx, dy]: Spot, other: Drawing) {
        let moved = |[x, y]: Spot| [x + dx, y + dy];
        self.shapes.extend(other.shapes.into_iter().map(|shape| match shape {
            Shape::Line { through, stroke } => {
                Shape::Line { through: through.into_iter().map(moved).collect(), stroke }
            }
            Shape::Rectangle { from, to, ink } => Shape::Rectangle { from: moved(from), to: moved(to), ink },
            Shape::Polygon { corners, ink } => {
                Shape::Polygon { corners: corners.into_iter().map(moved).collect(), ink }
            }
            Shape::Disc { at, radius, ink } => Shape::Disc { at: moved(at), radius, ink },
            Shape::Text { at, text } => Shape::Text { at: moved(at), text },
        }));
    }
}

/// True if both coordinates are finite. Shapes with other coordinates are not drawn.
fn is_place(spot: &Spot) -> bool {
    spot.iter().all(|value| value.is_finite())
}

fn dashes(through: &[Spot], [drawn, left_out]: [f64; 2]) -> Vec<Vec<Spot>> {
    let period = drawn + left_out;
    let mut pieces: Vec<Vec<Spot>> = Vec::new();
    // Position within the current dash period.
    let mut phase = 0.0;
    for pair in through.windows(2) {
        let ([x0, y0], [x1, y1]) = (pair[0], pair[1]);
        let length = (x1 - x0).hypot(y1 - y0);
        let at = |walked: f64| [x0 + (x1 - x0) * walked / length, y0 + (y1 - y0) * walked / length];
        let mut walked = 0.0;
        while length - walked > 1e-6 {
            let drawing = phase < drawn;
            let step = (if drawing { drawn - phase } else { period - phase }).min(length - walked);
            if drawing {
                match pieces.last_mut() {
                    Some(piece) if phase > 0.0 => piece.push(at(walked + step)),
                    _ => pieces.push(vec![at(walked), at(walked + step)]),
                }
            }
            walked += step;
            phase += step;
            if phase > period - 1e-6 {
                phase = 0.0;
            }
        }
    }
    pieces
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dashes_go_round_corners() {
        let corner = [[0.0, 0.0], [6.0, 0.0], [6.0, 10.0]];
        let found = dashes(&corner, [4.0, 1.0]);
        let expected = vec![
            vec![[0.0, 0.0], [4.0, 0.0]],
            vec![[5.0, 0.0], [6.0, 0.0], [6.0, 3.0]],
            vec![[6.0, 4.0], [6.0, 8.0]],
            vec![[6.0, 9.0], [6.0, 10.0]],
        ];
        assert_eq!(found, expected);
        assert!(dashes(&[[1.0, 1.0], [1.0, 1.0]], [4.0, 1.0]).is_empty());
    }

    #[test]
    fn what_has_no_place_is_not_drawn() {
        let mut drawing = Drawing::new(10, 10, "");
        drawing.line(&[[0.0, f64::NAN], [1.0, 1.0]], Stroke::solid(Ink::BLACK, 1.0));
        drawing.rectangle([0.0, f64::INFINITY], [1.0, 1.0], Ink::BLACK);
        drawing.disc([f64::NAN, 0.0], 1.0, Ink::BLACK);
        drawing.text([0.0, f64::NAN], Text::new("a", 10.0));
        assert_eq!(drawing.shapes, []);
    }
}
