//! Borders of cube faces, and the mismatch of two of them.

use codec::image::Face;
use codec::image::cube::{FacePoint, direction_to_face};

/// Maximum length of a border in samples.
const MAX_SAMPLES: u32 = 256;

/// Sides of an image: first row, last row, first column, last column.
pub const SIDES: usize = 4;

/// Values along the four sides of a face; NaN if unknown.
#[derive(Debug, Clone)]
pub struct Borders {
    /// Top and bottom from left to right, left and right from top to bottom.
    pub sides: [Vec<f32>; SIDES],
}

impl Borders {
    /// Samples the borders of an image of `side`×`side` pixels, subsampled if it is large.
    pub fn new(side: u32, value: impl Fn(u32, u32) -> f32) -> Borders {
        let step = side.div_ceil(MAX_SAMPLES).max(1);
        // Samples are symmetric about the middle, so that a reversed side has the same pixels.
        let count = (side / step).max(1);
        let first = (side - ((count - 1) * step + 1)) / 2;
        let last = side.saturating_sub(1);
        let along = |get: &dyn Fn(u32) -> f32| (0..count).map(|at| get((first + at * step).min(last))).collect();
        Borders {
            sides: [
                along(&|at| value(at, 0)),
                along(&|at| value(at, last)),
                along(&|at| value(0, at)),
                along(&|at| value(last, at)),
            ],
        }
    }
}

/// Mismatch of two sides.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Mismatch {
    /// Sum over samples of 0 (equal) to 1 (different).
    pub cost: f64,
    /// Number of samples for which at least one side has a surface.
    pub samples: u64,
}

impl Mismatch {
    pub fn add(self, other: Mismatch) -> Mismatch {
        Mismatch { cost: self.cost + other.cost, samples: self.samples + other.samples }
    }
}

/// Compares two sides, the second one reversed if `reversed`. Values whose ratio is e^`cap` or more are different; +inf is the
/// background.
pub fn mismatch(a: &[f32], b: &[f32], reversed: bool, cap: f64) -> Mismatch {
    let mut found = Mismatch::default();
    let count = a.len().min(b.len());
    for (at, &x) in a.iter().enumerate().take(count) {
        let y = if reversed { b[count - 1 - at] } else { b[at] };
        if x.is_nan() || y.is_nan() || (x.is_infinite() && y.is_infinite()) {
            continue;
        }
        found.samples += 1;
        found.cost += if x.is_infinite() || y.is_infinite() {
            1.0
        } else {
            ((f64::from(x) / f64::from(y)).ln().abs() / cap).min(1.0)
        };
    }
    found
}

/// A side of a face, as indices of both.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct FaceSide {
    pub face: usize,
    pub side: usize,
}

/// Two sides of different faces that may be the same edge of the cube.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Edge {
    pub a: FaceSide,
    pub b: FaceSide,
    /// True if the sides run in opposite directions.
    pub reversed: bool,
}

/// Returns the point at coordinate `along` of a side; both coordinates of an image are in −1..1.
pub fn side_point(side: usize, along: f64) -> [f64; 2] {
    match side {
        0 => [along, -1.0],
        1 => [along, 1.0],
        2 => [-1.0, along],
        _ => [1.0, along],
    }
}

/// Returns the side of a point on the border of an image, and its coordinate along that side.
pub fn side_of([u, v]: [f64; 2]) -> (usize, f64) {
    if u.abs() > v.abs() { (if u < 0.0 { 2 } else { 3 }, v) } else { (if v < 0.0 { 0 } else { 1 }, u) }
}

/// Returns the twelve edges of the cube, each once.
pub fn edges() -> Vec<Edge> {
    let mut found = Vec::new();
    for face in Face::CUBE {
        let [forward, right, down] = face.axes();
        for side in 0..SIDES {
            // A point slightly beyond the edge, closer to one of its ends.
            let [u, v] = side_point(side, 0.5);
            let beyond = |at: f64| if at.abs() == 1.0 { at * 1.001 } else { at };
            let FacePoint { face: next, plane: [nu, nv] } =
                direction_to_face(forward + beyond(u) * right + beyond(v) * down);
            let (other, along) = side_of([nu, nv]);
            if face < next {
                let (a, b) = (FaceSide { face: face as usize, side }, FaceSide { face: next as usize, side: other });
                found.push(Edge { a, b, reversed: along < 0.0 });
            }
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cube_has_twelve_edges_and_each_side_is_one() {
        let edges = edges();
        assert_eq!(edges.len(), 12);
        let mut sides: Vec<_> = edges.iter().flat_map(|edge| [edge.a, edge.b]).collect();
        sides.sort_unstable();
        sides.dedup();
        assert_eq!(sides.len(), 24);
    }

    #[test]
    fn edges_join_the_pixels_that_lie_side_by_side() {
        let size = 8;
        let pixel = |side: usize, at: u32| match side {
            0 => (at, 0),
            1 => (at, size - 1),
            2 => (0, at),
            _ => (size - 1, at),
        };
        for edge in edges() {
            for at in 0..size {
                let other = if edge.reversed { size - 1 - at } else { at };
                let direction = |FaceSide { face, side }, at: u32| {
                    let (x, y) = pixel(side, at);
                    Face::CUBE[face].direction(x, y, size).normalize()
                };
                let angle = direction(edge.a, at).angle_between(direction(edge.b, other));
                assert!(angle < 0.25, "{edge:?} {at}: {angle}");
            }
        }
    }

    #[test]
    fn sides_that_show_nothing_do_not_count() {
        let far = f32::INFINITY;
        assert_eq!(mismatch(&[far, 1.0, f32::NAN], &[far, 1.0, 2.0], false, 0.1), Mismatch { cost: 0.0, samples: 1 });
        assert_eq!(mismatch(&[far, 1.0], &[1.0, 1.0], false, 0.1), Mismatch { cost: 1.0, samples: 2 });
        assert_eq!(mismatch(&[1.0, 9.0], &[9.0, 1.0], true, 0.1).cost, 0.0);
    }
}
