//! What the checks look at: depth as files have it, thinned, with the directions that pixels look along.

use glam::{DQuat, DVec3};

use crate::dataset::DepthKind;
use crate::image::cube::direction_to_face;
use crate::image::{DepthPlane, Face, Plane};

/// Longest side, in samples, of a face that is reprojected; larger ones are thinned.
const MAX_SIDE: u32 = 256;
/// Where the largest distance around a sample is so many times the smallest, there is an edge, and nothing to compare.
const EDGE_RATIO: f32 = 1.15;

/// Depth of one face: every `step`th pixel of every `step`th row.
#[derive(Debug, Clone)]
pub struct Samples {
    /// Which face.
    pub face: Face,
    /// fx, fy, cx, cy of the whole face in pixels; half the side, four times, for the face of a cube.
    lens: [f64; 4],
    /// Size of the whole face in pixels.
    size: [u32; 2],
    step: u32,
    /// As the file has it, times the stated metres per unit: +inf for the background, NaN where nothing is known.
    pub stored: DepthPlane,
    /// Nearest and farthest distance of the samples around each, if the file holds distances.
    distance: Plane<[f32; 2]>,
    /// The same if the file holds planar depth.
    planar: Plane<[f32; 2]>,
}

impl Samples {
    /// Thins a face. `lens` is fx, fy, cx, cy in pixels; for a cube face none is needed.
    pub fn new(face: Face, stored: &DepthPlane, lens: Option<[f64; 4]>) -> Samples {
        let size = [stored.width(), stored.height()];
        let half = f64::from(size[0]) / 2.0;
        let step = size[0].max(size[1]).div_ceil(MAX_SIDE).max(1);
        let offset = step / 2;
        let count = |side: u32| (side.saturating_sub(offset)).div_ceil(step).max(1);
        let at = |index: u32, side: u32| (offset + index * step).min(side - 1);
        let thin = Plane::from_fn(count(size[0]), count(size[1]), |x, y| stored.get(at(x, size[0]), at(y, size[1])));
        let mut samples = Samples {
            face,
            lens: lens.unwrap_or([half; 4]),
            size,
            step,
            distance: Plane::filled(0, 0, [0.0; 2]),
            planar: Plane::filled(0, 0, [0.0; 2]),
            stored: thin,
        };
        samples.distance = samples.around(DepthKind::Distance);
        samples.planar = samples.around(DepthKind::Planar);
        samples
    }

    /// Where the ray of a sample meets the plane at distance 1.
    pub fn plane_point(&self, x: u32, y: u32) -> [f64; 2] {
        let [fx, fy, cx, cy] = self.lens;
        let at = |index: u32| f64::from(self.step / 2 + index * self.step) + 0.5;
        [(at(x) - cx) / fx, (at(y) - cy) / fy]
    }

    /// Distance between neighbouring samples on the plane at distance 1.
    pub fn spacing(&self) -> [f64; 2] {
        [f64::from(self.step) / self.lens[0], f64::from(self.step) / self.lens[1]]
    }

    /// What turns stored depth into distance at a sample.
    pub fn to_distance(&self, kind: DepthKind, x: u32, y: u32) -> f64 {
        let [u, v] = self.plane_point(x, y);
        match kind {
            DepthKind::Distance => 1.0,
            DepthKind::Planar => (1.0 + u * u + v * v).sqrt(),
        }
    }

    /// The point that a sample shows, seen from the probe along its own axes; `None` where there is no surface.
    pub fn point(&self, kind: DepthKind, x: u32, y: u32) -> Option<DVec3> {
        let stored = self.stored.get(x, y);
        if !stored.is_finite() {
            return None;
        }
        let [u, v] = self.plane_point(x, y);
        let [forward, right, down] = self.face.axes();
        let planar = match kind {
            DepthKind::Distance => f64::from(stored) / (1.0 + u * u + v * v).sqrt(),
            DepthKind::Planar => f64::from(stored),
        };
        Some((forward + u * right + v * down) * planar)
    }

    fn around(&self, kind: DepthKind) -> Plane<[f32; 2]> {
        let (width, height) = (self.stored.width(), self.stored.height());
        let distance =
            Plane::from_fn(width, height, |x, y| self.stored.get(x, y) * self.to_distance(kind, x, y) as f32);
        Plane::from_fn(width, height, |x, y| {
            if distance.get(x, y).is_nan() {
                return [f32::NAN; 2];
            }
            let mut range = [f32::INFINITY, 0.0f32];
            for row in y.saturating_sub(1)..=(y + 1).min(height - 1) {
                for col in x.saturating_sub(1)..=(x + 1).min(width - 1) {
                    let value = distance.get(col, row);
                    if !value.is_nan() {
                        range = [range[0].min(value), range[1].max(value)];
                    }
                }
            }
            // Two surfaces, or one and the background.
            if range[0] < range[1] && range[1] > range[0] * EDGE_RATIO { [f32::NAN; 2] } else { range }
        })
    }

    /// Nearest and farthest distance around a point of the plane at distance 1; `None` outside the image, where nothing
    /// is known, and at edges.
    fn range_at(&self, kind: DepthKind, [u, v]: [f64; 2]) -> Option<[f64; 2]> {
        let [fx, fy, cx, cy] = self.lens;
        let (x, y) = (u * fx + cx, v * fy + cy);
        if !(x >= 0.0 && y >= 0.0 && x <= f64::from(self.size[0]) && y <= f64::from(self.size[1])) {
            return None;
        }
        let index = |at: f64, count: u32| {
            let index = (at - 0.5 - f64::from(self.step / 2)) / f64::from(self.step);
            (index.round().max(0.0) as u32).min(count - 1)
        };
        let range = match kind {
            DepthKind::Distance => &self.distance,
            DepthKind::Planar => &self.planar,
        };
        let [near, far] = range.get(index(x, range.width()), index(y, range.height()));
        (!near.is_nan()).then(|| [f64::from(near), f64::from(far)])
    }
}

/// One probe in one frame.
#[derive(Debug, Clone)]
pub struct View {
    /// Name.
    pub name: String,
    /// The frame that was read.
    pub frame: u32,
    /// Centre, metres.
    pub position: DVec3,
    /// Turns the probe's axes into the world's.
    pub turn: DQuat,
    /// What it sees.
    pub faces: Vec<Samples>,
}

impl View {
    /// Nearest and farthest distance around a direction along the probe's own axes.
    pub fn range_towards(&self, kind: DepthKind, direction: DVec3) -> Option<[f64; 2]> {
        if let [only] = self.faces.as_slice()
            && only.face == Face::View
        {
            let [forward, right, down] = Face::View.axes();
            let depth = direction.dot(forward);
            let point = [direction.dot(right) / depth, direction.dot(down) / depth];
            return if depth > 0.0 { only.range_at(kind, point) } else { None };
        }
        let (face, u, v) = direction_to_face(direction);
        self.faces.iter().find(|samples| samples.face == face)?.range_at(kind, [u, v])
    }
}
