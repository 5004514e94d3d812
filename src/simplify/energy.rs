//! Energy of tiles: the error that their planes minimise.
//!
//! The paper's energy is the squared relative distance of points to planes (Seurat equation 2). It does not predict pictures: a
//! surface ten times as far away moves a tenth as much when the eye moves, and nothing is visible where colour does not change. The
//! default energy is the squared displacement in pictures from the region, weighted by contrast.

use super::points::MergedPoint;
use super::tile_plane::TilePlane;
use glam::DVec3;

/// Displacement in pixels at which the energy reaches half of its bound: farther away, a wrong place is not more wrong.
const HALF_BOUND_PX: f64 = 3.0;

/// Error of a tile that is minimised.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum EnergyKind {
    /// Squared displacement in pixels, in mean over eyes in the region, weighted by contrast and bounded.
    #[default]
    Picture,
    /// Squared relative distance (equation 2).
    Paper,
}

/// A point that a plane is fitted to.
#[derive(Debug, Clone, Copy)]
pub struct WeightedPoint {
    /// Position relative to the centre of the region, in metres.
    pub position: DVec3,
    /// Weight of its energy.
    pub weight: f64,
    /// Displacement in pixels where the inverse distance has a relative error of 1, in root mean square over eyes in the region.
    pub sway_px: f64,
}

impl WeightedPoint {
    /// `sway_px_m` is the product of distance and displacement, see [`super::candidates::Extent`].
    pub fn new(point: &MergedPoint, sway_px_m: f64, kind: EnergyKind) -> WeightedPoint {
        let position = point.position.as_dvec3();
        let weight = match kind {
            EnergyKind::Picture => point.contrast,
            EnergyKind::Paper => f64::from(point.samples),
        };
        WeightedPoint { position, weight, sway_px: sway_px_m / position.length() }
    }

    /// Returns the squared displacement of the point on a plane, in pixels. A point whose ray misses the plane is displaced as if it
    /// were infinitely far away.
    fn squared_px(&self, plane: TilePlane) -> f64 {
        (self.sway_px * (1.0 - self.position.dot(plane.0).max(0.0))).powi(2)
    }

    /// Returns the factor by which a round of reweighted least squares weights the point, before its own weight.
    pub fn reweight(&self, plane: TilePlane) -> f64 {
        (1.0 + self.squared_px(plane) / HALF_BOUND_PX.powi(2)).powi(-2)
    }
}

impl EnergyKind {
    /// Returns the energy of a point, before its weight.
    pub fn of(self, plane: TilePlane, point: &WeightedPoint) -> f64 {
        match self {
            EnergyKind::Picture => {
                let squared = point.squared_px(plane);
                squared / (1.0 + squared / HALF_BOUND_PX.powi(2))
            }
            EnergyKind::Paper => plane.energy(point.position),
        }
    }

    /// Returns the sum over points.
    pub fn sum(self, plane: TilePlane, points: &[WeightedPoint]) -> f64 {
        points.iter().map(|point| point.weight * self.of(plane, point)).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(distance_m: f64) -> WeightedPoint {
        let point = MergedPoint { position: glam::Vec3::new(0.0, 0.0, -distance_m as f32), samples: 3, contrast: 0.5 };
        WeightedPoint::new(&point, 100.0, EnergyKind::Picture)
    }

    #[test]
    fn displacement_falls_with_the_square_of_distance() {
        // 1% of the inverse distance is a displacement of 1 px at 1 m and of 0.1 px at 10 m.
        let energy = |distance_m: f64| {
            let plane = TilePlane(DVec3::new(0.0, 0.0, -1.01 / distance_m));
            EnergyKind::Picture.of(plane, &at(distance_m))
        };
        assert!((energy(1.0) - 1.0 / (1.0 + 1.0 / 9.0)).abs() < 1e-5, "{}", energy(1.0));
        assert!((energy(10.0) - 0.01 / (1.0 + 0.01 / 9.0)).abs() < 1e-6, "{}", energy(10.0));
        let paper = |distance_m: f64| {
            EnergyKind::Paper.of(TilePlane(DVec3::new(0.0, 0.0, -1.01 / distance_m)), &at(distance_m))
        };
        assert!((paper(1.0) - paper(10.0)).abs() < 1e-9);
        assert_eq!(
            (
                at(1.0).weight,
                WeightedPoint::new(
                    &MergedPoint { position: glam::Vec3::X, samples: 3, contrast: 0.5 },
                    1.0,
                    EnergyKind::Paper
                )
                .weight
            ),
            (0.5, 3.0)
        );
    }

    #[test]
    fn energy_is_bounded_also_where_rays_miss_the_plane() {
        let behind = TilePlane(DVec3::new(0.0, 0.0, 1.0));
        let energy = EnergyKind::Picture.of(behind, &at(1.0));
        assert!(energy < 9.0 && energy > 8.9, "{energy}");
        assert_eq!(EnergyKind::Paper.of(behind, &at(1.0)), f64::INFINITY);
    }
}
