//! Markers: a shape and a colour for each series, so that series can be told apart without colours.

use super::drawing::{Drawing, Ink, Spot, Stroke};
use super::palette;

const SHAPES: usize = 8;

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Look {
    pub ink: Ink,
    shape: usize,
    dash: Option<[f64; 2]>,
}

impl Look {
    /// Returns the look of a series by its index. It differs from the looks of the previous 60 series.
    pub fn of(number: usize) -> Look {
        let round = number / SHAPES;
        let dash = [None, Some([7.0, 3.0]), Some([2.0, 2.5])][round % 3];
        Look { ink: palette::series(number), shape: (number + round) % SHAPES, dash }
    }

    /// Returns the same look with a dashed line, which leaves lines below it visible. `dash`: lengths of dashes and
    /// gaps in pixels.
    pub fn dashed(self, dash: [f64; 2]) -> Look {
        Look { dash: Some(dash), ..self }
    }

    pub fn stroke(&self, width: f64) -> Stroke {
        Stroke { ink: self.ink, width, dash: self.dash }
    }

    /// Draws a marker of the given radius in pixels, with a thin white border.
    pub fn mark(&self, drawing: &mut Drawing, at: Spot, radius: f64) {
        self.filled(drawing, at, radius + 1.0, Ink::WHITE);
        self.filled(drawing, at, radius, self.ink);
    }

    fn filled(&self, drawing: &mut Drawing, at: Spot, radius: f64, ink: Ink) {
        let corner = |angle_degrees: f64, reach: f64| {
            let (sine, cosine) = angle_degrees.to_radians().sin_cos();
            [at[0] + radius * reach * cosine, at[1] + radius * reach * sine]
        };
        let ring = |count: usize, first: f64, reach: f64| -> Vec<Spot> {
            (0..count).map(|at| corner(first + 360.0 * at as f64 / count as f64, reach)).collect()
        };
        match self.shape {
            0 => drawing.disc(at, radius, ink),
            1 => drawing.polygon(&ring(4, 45.0, 1.25), ink),
            2 => drawing.polygon(&ring(3, -90.0, 1.35), ink),
            3 => drawing.polygon(&ring(4, 0.0, 1.35), ink),
            4 => drawing.polygon(&ring(3, 90.0, 1.35), ink),
            5 => drawing.polygon(&ring(6, 0.0, 1.15), ink),
            6 => {
                let ([x, y], reach, half) = (at, radius * 1.2, radius * 0.42);
                drawing.rectangle([x - reach, y - half], [x + reach, y + half], ink);
                drawing.rectangle([x - half, y - reach], [x + half, y + reach], ink);
            }
            _ => {
                let star: Vec<Spot> =
                    (0..10).map(|at| corner(-90.0 + 36.0 * f64::from(at), [1.5, 0.65][at as usize % 2])).collect();
                drawing.polygon(&star, ink);
            }
        }
    }
}
