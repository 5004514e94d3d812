//! Frusta of rectangles of pixels of a probe (CALF 6.2).
//!
//! Takes a face or view of a probe, and a rectangle of its pixels. Returns the frustum that contains every surface that the
//! pixels may show; background has the directions of that frustum.

use glam::DVec3;

use codec::container::ProbeEntry;
use codec::image::{DepthKind, Face, ImageProjection};
use codec::math::camera::rotation;
use codec::math::{Frustum, Window};

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DepthSpan {
    /// Minimum, in metres, at least 0.
    pub near_m: f64,
    /// Maximum, in metres, at least `near_m`; may be `+inf`.
    pub far_m: f64,
    /// Kind of depth: planar depth or distance.
    pub kind: DepthKind,
}

impl DepthSpan {
    pub fn unknown() -> DepthSpan {
        DepthSpan { near_m: 0.0, far_m: f64::INFINITY, kind: DepthKind::Planar }
    }
}

#[derive(Debug, Clone, PartialEq)]
pub struct FaceImage {
    centre: DVec3,
    /// Forward, right, down.
    axes: [DVec3; 3],
    projection: ImageProjection,
    depth: DepthSpan,
    /// Margin of every rectangle on each side, in pixels.
    margin_pixels: f64,
}

impl FaceImage {
    /// Creates the image of a face. None if its directions are unknown: a view without intrinsics, or an orientation whose length
    /// is not 1.
    pub fn new(probe: &ProbeEntry, face: Face, size: [u32; 2], depth: DepthSpan) -> Option<FaceImage> {
        let turn = rotation(probe.orientation)?;
        let projection = ImageProjection::of_face(face, size, probe.intrinsics);
        let axes = face.axes().map(|axis| turn * axis);
        let usable = [0.0, 1.0].into_iter().flat_map(|at| projection.plane([at; 2])).all(f64::is_finite);
        usable.then_some(FaceImage {
            centre: DVec3::from_array(probe.position),
            axes,
            projection,
            depth,
            margin_pixels: 0.0,
        })
    }

    #[must_use]
    pub fn with_margin(self, margin_pixels: f64) -> FaceImage {
        FaceImage { margin_pixels, ..self }
    }

    /// Returns the frustum of the pixels from `from` up to, but excluding, `to` (column, row).
    pub fn frustum(&self, from: [u32; 2], to: [u32; 2]) -> Frustum {
        let first = self.projection.plane(from.map(|pixel| f64::from(pixel) - self.margin_pixels));
        let last = self.projection.plane(to.map(|pixel| f64::from(pixel) + self.margin_pixels));
        let edges = |axis: usize| [first[axis].min(last[axis]), first[axis].max(last[axis])];
        let window = Window { u: edges(0), v: edges(1) };
        let DepthSpan { near_m, far_m, kind } = self.depth;
        let depth_m = match kind {
            DepthKind::Planar => [near_m, far_m],
            DepthKind::Distance => {
                let [least, greatest] = length_range(window);
                [near_m / greatest, far_m / least]
            }
        };
        Frustum::new(self.centre, self.axes, window, depth_m)
    }
}

/// Returns the minimum and maximum √(1 + u² + v²) in a window: distance over planar depth.
fn length_range(window: Window) -> [f64; 2] {
    let least = |[low, high]: [f64; 2]| 0f64.clamp(low, high);
    let greatest = |[low, high]: [f64; 2]| low.abs().max(high.abs());
    let length = |u: f64, v: f64| (1.0 + u * u + v * v).sqrt();
    [length(least(window.u), least(window.v)), length(greatest(window.u), greatest(window.v))]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn probe(orientation: [f64; 4], intrinsics: [f64; 4]) -> ProbeEntry {
        ProbeEntry { name: "p".into(), position: [1.0, 2.0, 3.0], orientation, frames: [0, 0], intrinsics }
    }

    #[test]
    fn surfaces_of_a_pixel_lie_in_its_frustum() {
        let half = 0.5f64.sqrt();
        let (near_m, far_m) = (0.5, 20.0);
        for orientation in [[0.0, 0.0, 0.0, 1.0], [0.0, half, 0.0, half], [0.5, -0.5, 0.5, 0.5]] {
            let turn = rotation(orientation).unwrap();
            for kind in [DepthKind::Distance, DepthKind::Planar] {
                let depth = DepthSpan { near_m, far_m, kind };
                for face in Face::CUBE {
                    let image = FaceImage::new(&probe(orientation, [0.0; 4]), face, [8, 8], depth).unwrap();
                    for (col, row) in (0..8).flat_map(|col| (0..8).map(move |row| (col, row))) {
                        let direction = turn * face.direction(col, row, 8);
                        let factor = if kind == DepthKind::Distance { direction.length() } else { 1.0 };
                        let point = |depth_m: f64| DVec3::new(1.0, 2.0, 3.0) + direction * (depth_m / factor);
                        let alone = image.frustum([col, row], [col + 1, row + 1]);
                        let other = image.frustum([(col + 1) % 8, row], [(col + 1) % 8 + 1, row + 1]);
                        // Inside the range by more than rounding.
                        for depth_m in [near_m * (1.0 + 1e-12), 3.0, far_m * (1.0 - 1e-12)] {
                            assert!(alone.contains(point(depth_m)), "{face:?} {col} {row} {depth_m}");
                            assert!(!other.contains(point(depth_m)));
                        }
                        assert!(!alone.contains(point(near_m * 0.7)) && !alone.contains(point(far_m * 1.4)));
                    }
                }
            }
        }
    }

    #[test]
    fn views_use_their_intrinsics() {
        let intrinsics = [40.0, 50.0, 10.0, 7.0];
        let depth = DepthSpan { near_m: 1.0, far_m: 2.0, kind: DepthKind::Distance };
        let image = FaceImage::new(&probe([0.0, 0.0, 0.0, 1.0], intrinsics), Face::View, [32, 24], depth).unwrap();
        for (col, row) in [(0, 0), (31, 23), (9, 7), (10, 6)] {
            let [u, v] = [(f64::from(col) + 0.5 - 10.0) / 40.0, (f64::from(row) + 0.5 - 7.0) / 50.0];
            let metres = 1.5 / (1.0 + u * u + v * v).sqrt();
            let point = DVec3::new(1.0, 2.0, 3.0) + metres * DVec3::new(u, -v, -1.0);
            assert!(image.frustum([col, row], [col + 1, row + 1]).contains(point));
            assert!(!image.frustum([col + 1, row], [col + 2, row + 1]).contains(point));
        }
    }

    #[test]
    fn images_without_directions_are_none() {
        let image = |orientation, intrinsics, face| {
            FaceImage::new(&probe(orientation, intrinsics), face, [8, 8], DepthSpan::unknown())
        };
        let straight = [0.0, 0.0, 0.0, 1.0];
        assert!(image(straight, [0.0; 4], Face::Px).is_some());
        assert!(image(straight, [0.0; 4], Face::View).is_none());
        assert!(image(straight, [1e-310, 1.0, 0.0, 0.0], Face::View).is_none());
        assert!(image([0.0; 4], [0.0; 4], Face::Px).is_none());
    }
}
