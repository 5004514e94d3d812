//! Subsampled stored depth of probes, with the directions of the samples.

use glam::{DQuat, DVec3};

use crate::dataset::DepthKind;
use codec::image::cube::{FacePoint, direction_to_face};
use codec::image::{DepthPlane, Face, ImageProjection, Plane};

/// Maximum side of a face in samples.
const MAX_SIDE: u32 = 256;
/// A sample is at a depth edge, and is not compared, if distances in its neighbourhood differ by more than this factor.
const EDGE_RATIO: f32 = 1.15;

/// Subsampled depth of one face: every `step`th pixel of every `step`th row.
#[derive(Debug, Clone)]
pub struct FaceSamples {
    pub face: Face,
    projection: ImageProjection,
    step: u32,
    /// Stored depth times the declared metres per unit: +inf for the background, NaN if unknown.
    pub stored: DepthPlane,
    /// Nearest and farthest distance in the 3x3 neighbourhood of each sample, if the file stores distance; NaN at edges.
    distance: Plane<[f32; 2]>,
    /// As `distance`, if the file stores planar depth.
    planar: Plane<[f32; 2]>,
}

impl FaceSamples {
    /// Samples an image whose pixel values are given by `stored`.
    pub fn new(face: Face, stored: impl Fn(u32, u32) -> f32, projection: ImageProjection) -> FaceSamples {
        let size = projection.size();
        let step = size[0].max(size[1]).div_ceil(MAX_SIDE).max(1);
        let offset = step / 2;
        let count = |side: u32| (side.saturating_sub(offset)).div_ceil(step).max(1);
        let at = |index: u32, side: u32| (offset + index * step).min(side - 1);
        let stored = Plane::from_fn(count(size[0]), count(size[1]), |x, y| stored(at(x, size[0]), at(y, size[1])));
        let unknown = || Plane::filled(0, 0, [0.0; 2]);
        let mut samples = FaceSamples { face, projection, step, stored, distance: unknown(), planar: unknown() };
        samples.distance = samples.around(DepthKind::Distance);
        samples.planar = samples.around(DepthKind::Planar);
        samples
    }

    /// Returns (u, v) of a sample on the image plane at distance 1.
    pub fn plane_point(&self, x: u32, y: u32) -> [f64; 2] {
        self.projection.plane([x, y].map(|index| f64::from(self.step / 2 + index * self.step) + 0.5))
    }

    /// Distance between neighbouring samples in u and v.
    pub fn spacing(&self) -> [f64; 2] {
        let (first, next) = (self.projection.plane([0.0; 2]), self.projection.plane([f64::from(self.step); 2]));
        [next[0] - first[0], next[1] - first[1]]
    }

    /// Returns the factor from stored depth to distance at a sample.
    pub fn to_distance(&self, kind: DepthKind, x: u32, y: u32) -> f64 {
        let [u, v] = self.plane_point(x, y);
        match kind {
            DepthKind::Distance => 1.0,
            DepthKind::Planar => (1.0 + u * u + v * v).sqrt(),
        }
    }

    /// Returns the surface point of a sample in the probe's axes; `None` if there is no surface.
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
            // Mark samples between two surfaces, or between a surface and the background.
            if range[0] < range[1] && range[1] > range[0] * EDGE_RATIO { [f32::NAN; 2] } else { range }
        })
    }

    /// Returns the nearest and farthest distance around an image position in pixels; `None` if unknown, and at edges.
    fn range_at(&self, kind: DepthKind, [x, y]: [f64; 2]) -> Option<[f64; 2]> {
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

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    /// Centre in metres.
    pub position: DVec3,
    /// Rotation from the probe's axes to the world's.
    pub turn: DQuat,
}

#[derive(Debug, Clone)]
pub struct ProbeSamples {
    pub name: String,
    pub frame: u32,
    pub pose: Pose,
    pub faces: Vec<FaceSamples>,
}

impl ProbeSamples {
    /// Returns the nearest and farthest distance around a direction in the probe's axes.
    pub fn range_towards(&self, kind: DepthKind, direction: DVec3) -> Option<[f64; 2]> {
        if let [only] = self.faces.as_slice()
            && only.face == Face::View
        {
            return only.range_at(kind, only.projection.project(direction)?);
        }
        let FacePoint { face, plane } = direction_to_face(direction);
        let samples = self.faces.iter().find(|samples| samples.face == face)?;
        samples.range_at(kind, samples.projection.position(plane))
    }
}
