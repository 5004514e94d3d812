//! Triangles as one camera sees them: edge functions, and the pixels of a row between them.
//!
//! Coordinates are those of the camera (right, down, forward), in which the ray of a pixel is (u, v, 1). What is linear along such rays is
//! an affine function of the pixel. A triangle is not clipped: all weights of its corners are above 0 only on rays that meet it.

use std::ops::Range;

use glam::DVec3;

use crate::math::Camera;

/// A function of the pixel: `constant + across · x + down · y`.
#[derive(Debug, Clone, Copy)]
pub struct Affine {
    constant: f64,
    across: f64,
    down: f64,
}

/// A function along a row: `start + across · x`.
#[derive(Debug, Clone, Copy)]
pub struct Along {
    start: f64,
    across: f64,
}

impl Affine {
    fn plus(self, other: Affine, factor: f64) -> Affine {
        Affine {
            constant: self.constant + factor * other.constant,
            across: self.across + factor * other.across,
            down: self.down + factor * other.down,
        }
    }

    pub fn row(self, y: f64) -> Along {
        Along { start: self.constant + self.down * y, across: self.across }
    }
}

impl Along {
    pub fn at(self, x: f64) -> f64 {
        self.start + self.across * x
    }
}

/// Rays of the pixels of a picture.
#[derive(Debug, Clone, Copy)]
pub struct Pixels {
    size: [u32; 2],
    eye: DVec3,
    /// Right, down, forward.
    axes: [DVec3; 3],
    /// The left and top edge of the image at distance 1, and the sides of a pixel there.
    first: [f64; 2],
    step: [f64; 2],
    /// Near and far along the axis, in metres.
    depth_m: [f64; 2],
}

impl Pixels {
    pub fn new(camera: &Camera, size: [u32; 2]) -> Pixels {
        let [forward, right, down] = camera.axes();
        let window = camera.window();
        let step = |[from, to]: [f64; 2], pixels: u32| (to - from) / f64::from(pixels);
        Pixels {
            size,
            eye: camera.eye(),
            axes: [right, down, forward],
            first: [window.u[0], window.v[0]],
            step: [step(window.u, size[0]), step(window.v, size[1])],
            depth_m: camera.depth_m(),
        }
    }

    /// A point in the coordinates of the camera.
    pub fn seen_from_eye(&self, point: DVec3) -> DVec3 {
        let from_eye = point - self.eye;
        DVec3::from_array(self.axes.map(|axis| axis.dot(from_eye)))
    }

    /// The dot product of a vector with the rays.
    fn along(&self, vector: DVec3) -> Affine {
        Affine {
            constant: vector.x * self.first[0] + vector.y * self.first[1] + vector.z,
            across: vector.x * self.step[0],
            down: vector.y * self.step[1],
        }
    }

    /// Rows that a polygon can cover; none where it lies behind the camera or beside the image.
    fn rows(&self, corners: &[DVec3; 3]) -> Option<[u32; 2]> {
        let end = [0, 1].map(|axis| self.first[axis] + self.step[axis] * f64::from(self.size[axis]));
        let beyond = |outside: &dyn Fn(&DVec3) -> bool| corners.iter().all(outside);
        if beyond(&|at| at.z <= 0.0)
            || beyond(&|at| at.x < self.first[0] * at.z)
            || beyond(&|at| at.x > end[0] * at.z)
            || beyond(&|at| at.y < self.first[1] * at.z)
            || beyond(&|at| at.y > end[1] * at.z)
        {
            return None;
        }
        if corners.iter().any(|at| at.z <= 0.0) {
            // A part of it is behind the eye: edge functions find its pixels.
            return Some([0, self.size[1]]);
        }
        let rows = corners.map(|at| (at.y / at.z - self.first[1]) / self.step[1]);
        // A pixel more than rounding could move it.
        let first = rows.into_iter().fold(f64::INFINITY, f64::min).floor() - 1.0;
        let last = rows.into_iter().fold(f64::NEG_INFINITY, f64::max).ceil() + 1.0;
        let clamp = |at: f64| at.clamp(0.0, f64::from(self.size[1])) as u32;
        Some([clamp(first), clamp(last)])
    }
}

/// A half-plane of pixels: where its function is above 0, and where it is 0 if the border belongs to it.
#[derive(Debug, Clone, Copy)]
struct Edge {
    side: Affine,
    /// Minus the inverse of `across`, in pixels per unit: times the value at the start of a row, the column where the function is 0.
    to_border: f64,
    owns_border: bool,
}

impl Edge {
    fn new(side: Affine, owns_border: bool) -> Edge {
        Edge { side, to_border: -side.across.recip(), owns_border }
    }

    /// The part of a row inside, `offset` being the place of the sample in its pixel.
    fn clip(&self, pixels: Range<u32>, [offset, y]: [f64; 2]) -> Range<u32> {
        let side = self.side.row(y);
        // The same value for the same edge of another triangle, with the opposite sign; it grows or falls along the row.
        let inside = |x: u32| {
            let side = side.at(f64::from(x) + offset);
            side > 0.0 || side == 0.0 && self.owns_border
        };
        let Range { mut start, mut end } = pixels;
        // In this order what is no number is the start. Steps from there find the border, wherever rounding puts it.
        let border = (side.start * self.to_border - offset).max(f64::from(start)).min(f64::from(end)) as u32;
        let border = (border + 1).min(end);
        if side.across > 0.0 {
            let least = start;
            start = border;
            while start > least && inside(start - 1) {
                start -= 1;
            }
            while start < end && !inside(start) {
                start += 1;
            }
        } else if side.across < 0.0 {
            let most = end;
            end = border;
            while end < most && inside(end) {
                end += 1;
            }
            while end > start && !inside(end - 1) {
                end -= 1;
            }
        } else if !inside(start) {
            end = start;
        }
        start..end
    }
}

#[derive(Debug)]
pub struct Triangle {
    /// First and end row that it can cover.
    pub rows: [u32; 2],
    /// Whether all its texels are: the others are looked at. The caller says so.
    pub is_opaque: bool,
    /// Where the weights of its corners are above 0.
    edges: [Edge; 3],
    /// Near and far, where the camera has them.
    range: Option<[Edge; 2]>,
    /// Sum of the weights.
    pub sum: Affine,
    /// The sum times homogeneous texture coordinates.
    pub stq: [Affine; 3],
    /// Volume of its corners and the eye, six times: divided by the sum it is the depth in metres along the axis.
    pub volume: f64,
}

impl Triangle {
    /// Corners in the coordinates of the camera; none where it is not seen.
    pub fn new(corners: &[DVec3; 3], stq: [[f64; 3]; 3], pixels: &Pixels) -> Option<Triangle> {
        let rows = pixels.rows(corners).filter(|[first, end]| first < end)?;
        let [a, b, c] = *corners;
        let normals = [b.cross(c), c.cross(a), a.cross(b)];
        let volume = a.dot(normals[0]);
        if volume == 0.0 || !volume.is_finite() {
            return None;
        }
        let normals = normals.map(|normal| normal * volume.signum());
        let volume = volume.abs();
        let weights = normals.map(|normal| pixels.along(normal));
        let edge = |at: usize| {
            let first = normals[at].to_array().into_iter().find(|at| *at != 0.0);
            Edge::new(weights[at], first.is_some_and(|at| at > 0.0))
        };
        let none = Affine { constant: 0.0, across: 0.0, down: 0.0 };
        let total = |factors: [f64; 3]| (0..3).fold(none, |sum, at| sum.plus(weights[at], factors[at]));
        let sum = total([1.0; 3]);
        let [near_m, far_m] = pixels.depth_m;
        let range = (near_m > 0.0 || far_m < f64::INFINITY).then(|| {
            let is_beyond_near = if near_m > 0.0 {
                Affine { constant: volume / near_m, ..none }.plus(sum, -1.0)
            } else {
                Affine { constant: 1.0, ..none }
            };
            let is_before_far = Affine { constant: -volume / far_m, ..none }.plus(sum, 1.0);
            [is_beyond_near, is_before_far].map(|side| Edge::new(side, true))
        });
        let stq = [0, 1, 2].map(|axis| total(stq.map(|stq| stq[axis])));
        Some(Triangle { rows, is_opaque: false, edges: [0, 1, 2].map(edge), range, sum, stq, volume })
    }

    /// The pixels of a row whose samples it covers; a sample lies at `offset` in its pixel.
    pub fn span(&self, row: u32, width: u32, offset: [f64; 2]) -> Range<u32> {
        let at = [offset[0], f64::from(row) + offset[1]];
        let range = self.range.iter().flatten();
        self.edges.iter().chain(range).fold(0..width, |pixels, edge| edge.clip(pixels, at))
    }
}
