//! Planes of quad tiles.

use glam::DVec3;

/// A plane that does not contain the centre of the viewing region, as its normal divided by its distance from that centre: the
/// ray of direction v meets it at v / (v · plane).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TilePlane(pub DVec3);

impl TilePlane {
    /// Returns the plane through a point that is perpendicular to the line of sight. The point must not be the centre of the
    /// region.
    pub fn fronto_parallel(point: DVec3) -> TilePlane {
        TilePlane(point / point.length_squared())
    }

    /// Returns the factor of a direction's length at which its ray meets the plane; `+inf` if it does not.
    pub fn hit(self, direction: DVec3) -> f64 {
        let inverse = direction.dot(self.0);
        if inverse > 0.0 { 1.0 / inverse } else { f64::INFINITY }
    }

    /// Returns the value of equation 2: the squared relative distance of a point to the plane, along the ray to the point.
    pub fn energy(self, point: DVec3) -> f64 {
        (1.0 - self.hit(point)).powi(2)
    }
}
