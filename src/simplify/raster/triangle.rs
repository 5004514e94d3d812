//! Triangles as seen from one camera: edge functions, and the pixels of a row between them.
//!
//! Coordinates are those of the camera (right, down, forward), in which the ray of a pixel is (u, v, 1). A linear function of
//! these rays is an affine function of the pixel. Triangles are not clipped: all weights of the corners are above 0 only for rays
//! that meet the triangle.

use std::ops::Range;

use glam::DVec3;

use codec::math::Camera;

/// Maximum error of a corner by rounding, in rows.
const ROUNDING_ROWS: f64 = 0.0625;

/// Affine function of the pixel: `constant + across · x + down · y`.
#[derive(Debug, Clone, Copy)]
pub struct Affine {
    constant: f64,
    across: f64,
    down: f64,
}

/// Affine function along a row: `start + across · x`.
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
    /// Unit vectors right, down and forward.
    axes: [DVec3; 3],
    /// Left and top edge of the image at distance 1, and the width and height of a pixel at that distance.
    first: [f64; 2],
    step: [f64; 2],
    /// Near and far distance along the axis, in metres.
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

    /// Returns a point in the coordinates of the camera.
    pub fn seen_from_eye(&self, point: DVec3) -> DVec3 {
        let from_eye = point - self.eye;
        DVec3::from_array(self.axes.map(|axis| axis.dot(from_eye)))
    }

    /// Returns the dot product of a vector with the ray of each pixel.
    fn along(&self, vector: DVec3) -> Affine {
        Affine {
            constant: vector.x * self.first[0] + vector.y * self.first[1] + vector.z,
            across: vector.x * self.step[0],
            down: vector.y * self.step[1],
        }
    }

    /// Returns the rows that a triangle can cover; `None` if it is behind the camera or outside of the image.
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
            // Part of the triangle is behind the eye; edge functions find its pixels.
            return Some([0, self.size[1]]);
        }
        let rows = corners.map(|at| (at.y / at.z - self.first[1]) / self.step[1]);
        let first = (rows.into_iter().fold(f64::INFINITY, f64::min) - ROUNDING_ROWS).floor();
        let last = (rows.into_iter().fold(f64::NEG_INFINITY, f64::max) + ROUNDING_ROWS).ceil();
        let clamp = |at: f64| at.clamp(0.0, f64::from(self.size[1])) as u32;
        Some([clamp(first), clamp(last)])
    }
}

/// A half-plane of pixels: those where its function is above 0, and those where it is 0 if the border is inside.
#[derive(Debug, Clone, Copy)]
struct Edge {
    side: Affine,
    /// Minus the inverse of `across`, in pixels per unit. Multiplied by the value at the start of a row, it gives the column
    /// where the function is 0.
    to_border: f64,
    border: Border,
}

/// Side to which the border of a half-plane belongs, where its function is 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Border {
    Inside,
    Outside,
}

impl Edge {
    fn new(side: Affine, border: Border) -> Edge {
        Edge { side, to_border: -side.across.recip(), border }
    }

    /// Returns true if a column of a row is inside. For the same edge of another triangle, the function has the same value with
    /// the opposite sign.
    #[inline]
    fn is_inside(&self, row: Along, x: f64) -> bool {
        let side = row.at(x);
        side > 0.0 || side == 0.0 && self.border == Border::Inside
    }
}

/// Up to five half-planes, grouped by the slope of their functions along a row: pixels after a border, pixels before a border,
/// and whole rows.
#[derive(Debug, Clone, Copy)]
struct Edges {
    all: [Edge; 5],
    /// End index of the increasing functions, of the decreasing ones, and of the constant ones.
    ends: [usize; 3],
}

impl Default for Edges {
    fn default() -> Edges {
        let side = Affine { constant: 0.0, across: 0.0, down: 0.0 };
        Edges { all: [Edge { side, to_border: 0.0, border: Border::Outside }; 5], ends: [0; 3] }
    }
}

impl Edges {
    fn add(&mut self, edge: Edge) {
        let across = edge.side.across;
        let kind = if across > 0.0 {
            0
        } else if across < 0.0 {
            1
        } else {
            2
        };
        let place = self.ends[kind];
        self.all.copy_within(place..self.ends[2], place + 1);
        self.all[place] = edge;
        self.ends[kind..].iter_mut().for_each(|end| *end += 1);
    }

    /// Returns the columns of a row that are inside all half-planes. `offset` is the position of the sample in its pixel. The
    /// functions are monotone along the row, so each is evaluated only near its border, where rounding may have put a column on
    /// the wrong side.
    fn span(&self, y: f64, width: u32, offset: f64) -> Range<u32> {
        let (growing, others) = self.all[..self.ends[2]].split_at(self.ends[0]);
        let (falling, level) = others.split_at(self.ends[1] - self.ends[0]);
        let is_inside = |edges: &[Edge], column: u32| {
            let x = f64::from(column) + offset;
            edges.iter().all(|edge| edge.is_inside(edge.side.row(y), x))
        };
        if !is_inside(level, 0) {
            return 0..0;
        }
        // In this order of operations, a border that is NaN counts as the side of the image.
        let border = |edge: &Edge| edge.side.row(y).start * edge.to_border - offset;
        let first = growing.iter().fold(0.0, |first, edge| border(edge).max(first)).min(f64::from(width));
        let last = falling.iter().fold(f64::from(width), |last, edge| border(edge).min(last)).max(-1.0);
        let mut start = if first > 0.0 { (first as u32 + 1).min(width) } else { 0 };
        let mut end = ((last + 1.0) as u32).min(width);
        while start > 0 && is_inside(growing, start - 1) {
            start -= 1;
        }
        while start < width && !is_inside(growing, start) {
            start += 1;
        }
        while end < width && is_inside(falling, end) {
            end += 1;
        }
        while end > start && !is_inside(falling, end - 1) {
            end -= 1;
        }
        start..end.max(start)
    }
}

#[derive(Debug)]
pub struct Triangle {
    /// First and end row that the triangle can cover.
    pub rows: [u32; 2],
    /// True if all of its texels are opaque, so that they need not be sampled. Set by the caller.
    pub is_opaque: bool,
    /// Half-planes where the weights of the corners are above 0, and those of the near and far distance if the camera has them.
    edges: Edges,
    /// Sum of the weights of the corners.
    pub sum: Affine,
    /// The sum of weights times the interpolated homogeneous texture coordinates.
    pub stq: [Affine; 3],
    /// Six times the volume spanned by the corners and the eye. Divided by the sum, it is the depth along the axis in metres.
    pub volume: f64,
}

impl Triangle {
    /// Takes the corners in the coordinates of the camera. Returns `None` if the triangle is not visible.
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
            let border = if first.is_some_and(|at| at > 0.0) { Border::Inside } else { Border::Outside };
            Edge::new(weights[at], border)
        };
        let none = Affine { constant: 0.0, across: 0.0, down: 0.0 };
        let total = |factors: [f64; 3]| (0..3).fold(none, |sum, at| sum.plus(weights[at], factors[at]));
        let sum = total([1.0; 3]);
        let [near_m, far_m] = pixels.depth_m;
        let mut edges = Edges::default();
        [0, 1, 2].map(edge).into_iter().for_each(|edge| edges.add(edge));
        if near_m > 0.0 {
            let is_beyond_near = Affine { constant: volume / near_m, ..none }.plus(sum, -1.0);
            edges.add(Edge::new(is_beyond_near, Border::Inside));
        }
        if far_m < f64::INFINITY {
            let is_before_far = Affine { constant: -volume / far_m, ..none }.plus(sum, 1.0);
            edges.add(Edge::new(is_before_far, Border::Inside));
        }
        let stq = [0, 1, 2].map(|axis| total(stq.map(|stq| stq[axis])));
        Some(Triangle { rows, is_opaque: false, edges, sum, stq, volume })
    }

    /// Returns the pixels of a row whose samples the triangle covers; a sample is at `offset` in its pixel.
    pub fn span(&self, row: u32, width: u32, offset: [f64; 2]) -> Range<u32> {
        self.edges.span(f64::from(row) + offset[1], width, offset[0])
    }
}
