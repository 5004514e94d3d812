//! Fit of the plane of a quad tile to points by the paper's energy (Seurat 4.2, equation 2).
//!
//! Takes weighted points, the bounds of a tile and an initial plane. Returns the plane of minimum energy, found by
//! Levenberg–Marquardt over the centre and the normal of a disk.

use glam::{DMat3, DVec3};
use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt};
use nalgebra::storage::Owned;
use nalgebra::{DVector, Dyn, OMatrix, U6, Vector6};

use super::energy::WeightedPoint;
use super::tile_plane::TilePlane;

/// Bounds within which a plane is fitted.
#[derive(Debug, Clone, Copy)]
pub struct FitBounds {
    /// Unit directions to the corners of the tile.
    pub corners: [DVec3; 4],
    /// Distances in metres beyond which corners are penalised: 1% of the region's radius, and the radius of the geometry.
    pub min_m: f64,
    pub max_m: f64,
}

impl FitBounds {
    /// Returns true if a plane meets all four edges of the frustum in front of the centre, at distances from `min_m` to four
    /// times `max_m`.
    pub fn admits(&self, plane: TilePlane) -> bool {
        self.corners.iter().all(|&corner| {
            let hit = plane.hit(corner);
            hit >= self.min_m && hit <= 4.0 * self.max_m
        })
    }
}

/// Residual of points whose rays miss the plane: as large as that of points 30 times too far away.
const MISSED: f64 = 30.0;
/// Initial value of γ of Seurat 4.2.
const FIRST_GAMMA: f64 = 0.1;

struct Disk<'a> {
    points: &'a [WeightedPoint],
    bounds: &'a FitBounds,
    gamma: f64,
    /// Unit of length in metres, chosen so that the normal and the centre have the same scale.
    scale: f64,
    center: DVec3,
    normal: DVec3,
}

impl Disk<'_> {
    fn plane(&self) -> TilePlane {
        TilePlane(self.normal / (self.center.dot(self.normal) * self.scale))
    }

    fn rows_of_a_point(&self) -> usize {
        if self.gamma > 0.0 { 4 } else { 1 }
    }

    /// Calls `row` with each residual and its derivatives by centre and normal.
    fn rows(&self, mut row: impl FnMut(f64, [DVec3; 2])) {
        let (center, normal) = (self.center, self.normal);
        let offset = center.dot(normal);
        let length = center.length();
        for &WeightedPoint { position, weight, .. } in self.points {
            let point = position / self.scale;
            let weight = weight.sqrt();
            let slope = point.dot(normal);
            if slope * offset <= 0.0 {
                row(weight * MISSED, [DVec3::ZERO; 2]);
                (1..self.rows_of_a_point()).for_each(|_| row(0.0, [DVec3::ZERO; 2]));
                continue;
            }
            let hit = offset / slope;
            let by = [normal / slope, (center - hit * point) / slope];
            row(weight * (1.0 - hit), by.map(|by| -weight * by));
            if self.gamma > 0.0 {
                let weight = weight * self.gamma.sqrt() / length;
                let beside = center - hit * point;
                for axis in 0..3 {
                    let unit = DVec3::from_array(std::array::from_fn(|at| if at == axis { 1.0 } else { 0.0 }));
                    let by_center = unit - point[axis] * by[0] - beside[axis] / (length * length) * center;
                    row(weight * beside[axis], [weight * by_center, -weight * point[axis] * by[1]]);
                }
            }
        }
        let [least, most] = [self.bounds.min_m, self.bounds.max_m].map(|metres| metres / self.scale);
        for corner in self.bounds.corners {
            let slope = corner.dot(normal);
            let hit = offset / slope;
            if slope * offset <= 0.0 {
                row(MISSED, [DVec3::ZERO; 2]);
                continue;
            }
            let by = [normal / slope, (center - hit * corner) / slope];
            if hit < least {
                row(least - hit, by.map(|by| -by));
            } else if hit > most {
                row(hit - most, by);
            } else {
                row(0.0, [DVec3::ZERO; 2]);
            }
        }
    }

    fn row_count(&self) -> usize {
        self.points.len() * self.rows_of_a_point() + 4
    }
}

impl LeastSquaresProblem<f64, Dyn, U6> for Disk<'_> {
    type ParameterStorage = Owned<f64, U6>;
    type ResidualStorage = Owned<f64, Dyn>;
    type JacobianStorage = Owned<f64, Dyn, U6>;

    fn set_params(&mut self, x: &Vector6<f64>) {
        self.center = DVec3::new(x[0], x[1], x[2]);
        self.normal = DVec3::new(x[3], x[4], x[5]);
    }

    fn params(&self) -> Vector6<f64> {
        let (c, n) = (self.center, self.normal);
        Vector6::new(c.x, c.y, c.z, n.x, n.y, n.z)
    }

    fn residuals(&self) -> Option<DVector<f64>> {
        let mut all = Vec::with_capacity(self.row_count());
        self.rows(|value, _| all.push(value));
        Some(DVector::from_vec(all))
    }

    fn jacobian(&self) -> Option<OMatrix<f64, Dyn, U6>> {
        let mut matrix = OMatrix::<f64, Dyn, U6>::zeros(self.row_count());
        let mut at = 0;
        self.rows(|_, [center, normal]| {
            for axis in 0..3 {
                matrix[(at, axis)] = center[axis];
                matrix[(at, axis + 3)] = normal[axis];
            }
            at += 1;
        });
        Some(matrix)
    }
}

/// Fits a plane to points, starting from `first`. If there are fewer than three points, if they lie on a line, or if the bounds
/// do not admit their plane, the plane is perpendicular to the line of sight through their mean. Keeps the better of the result
/// and `first`.
pub fn fit_plane(points: &[WeightedPoint], bounds: &FitBounds, first: TilePlane, evaluations: usize) -> TilePlane {
    let weight: f64 = points.iter().map(|point| point.weight).sum();
    let energy = |plane: TilePlane| -> f64 {
        if !bounds.admits(plane) {
            return f64::INFINITY;
        }
        points.iter().map(|point| point.weight * plane.energy(point.position)).sum()
    };
    if weight.is_nan() || weight <= 0.0 {
        return first;
    }
    let mean_m = points.iter().map(|point| point.weight * point.position.length()).sum::<f64>() / weight;
    let mean_direction: DVec3 = points.iter().map(|point| point.weight * point.position.normalize_or_zero()).sum();
    let flat = TilePlane::fronto_parallel(mean_m * mean_direction.normalize_or_zero());
    let better = |best: TilePlane, plane: TilePlane| if energy(plane) < energy(best) { plane } else { best };
    let mut best = better(if bounds.admits(first) { first } else { flat }, flat);
    if points.len() < 3 {
        return best;
    }
    if let Some(plane) = inverse_distance_plane(points) {
        best = better(best, plane);
    }
    let start = best;
    let gammas: &[f64] = if evaluations > 8 { &[FIRST_GAMMA, 0.0] } else { &[0.0] };
    if evaluations > 0 && bounds.admits(start) {
        let center =
            mean_direction.normalize_or_zero() * start.hit(mean_direction.normalize_or_zero()).min(bounds.max_m);
        let mut disk = Disk {
            points,
            bounds,
            gamma: 0.0,
            scale: mean_m,
            center: center / mean_m,
            normal: start.0.normalize_or_zero(),
        };
        for &gamma in gammas {
            disk.gamma = gamma;
            let solver = LevenbergMarquardt::new().with_ftol(1e-6).with_xtol(1e-6).with_patience(evaluations);
            disk = solver.minimize(disk).0;
        }
        best = better(best, disk.plane());
    }
    best
}

/// Returns the plane that minimises Σ w (1 − p · plane)², which is the energy to first order; `None` if the points lie on a line,
/// or on a plane through the centre of the region.
fn inverse_distance_plane(points: &[WeightedPoint]) -> Option<TilePlane> {
    let scale = points.iter().map(|point| point.position.length()).sum::<f64>() / points.len() as f64;
    let (mut squares, mut sum, mut weights) = (DMat3::ZERO, DVec3::ZERO, 0.0);
    for &WeightedPoint { position, weight, .. } in points {
        let point = position / scale;
        squares += DMat3::from_cols(point * point.x, point * point.y, point * point.z) * weight;
        sum += weight * point;
        weights += weight;
    }
    let squares = squares * (1.0 / weights);
    let determinant = squares.determinant();
    let plane = squares.inverse() * (sum / weights) / scale;
    (determinant.abs() > 1e-14 && plane.is_finite()).then_some(TilePlane(plane))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bounds() -> FitBounds {
        let corners = [[-0.2, -0.2], [0.2, -0.2], [0.2, 0.2], [-0.2, 0.2]];
        FitBounds { corners: corners.map(|[x, y]| DVec3::new(x, y, -1.0).normalize()), min_m: 0.01, max_m: 100.0 }
    }

    fn at(position: DVec3) -> WeightedPoint {
        WeightedPoint { position, weight: 1.0, sway_px: 50.0 / position.length() }
    }

    /// Returns points of a plane, along rays through a grid.
    fn on_plane(plane: TilePlane) -> Vec<WeightedPoint> {
        let steps = || (0..6).map(|at| -0.2 + 0.08 * f64::from(at));
        let directions = steps().flat_map(|x| steps().map(move |y| DVec3::new(x, y, -1.0)));
        directions.map(|direction| at(direction * plane.hit(direction))).collect()
    }

    fn energy(plane: TilePlane, points: &[WeightedPoint]) -> f64 {
        points.iter().map(|point| point.weight * plane.energy(point.position)).sum()
    }

    #[test]
    fn a_slanted_plane_is_found_where_one_across_the_view_is_far_off() {
        // A plane 4 m away, and twice as far on one side as on the other.
        let wanted = TilePlane(DVec3::new(0.4, 0.1, -0.25));
        let points = on_plane(wanted);
        for evaluations in [0, 2, 9, 30] {
            let found =
                fit_plane(&points, &bounds(), TilePlane::fronto_parallel(DVec3::new(0.0, 0.0, -4.0)), evaluations);
            assert!(energy(found, &points) < 1e-9, "{evaluations}: {found:?}");
        }
        let flat = TilePlane::fronto_parallel(DVec3::new(0.0, 0.0, -4.0));
        assert!(energy(flat, &points) > 0.1);
    }

    #[test]
    fn noise_is_fitted_better_by_more_evaluations() {
        let mut random = codec::math::random::Random::new(3);
        let mut points = on_plane(TilePlane(DVec3::new(0.3, 0.2, -0.3)));
        for point in &mut points {
            point.position *= 1.0 + 0.4 * (f64::from(random.word()) / f64::from(u32::MAX) - 0.5);
        }
        let first = TilePlane::fronto_parallel(DVec3::new(0.0, 0.0, -3.0));
        let [none, some] =
            [0, 30].map(|evaluations| energy(fit_plane(&points, &bounds(), first, evaluations), &points));
        assert!(some < none, "{some} {none}");
        // No neighbouring plane has less energy.
        let found = fit_plane(&points, &bounds(), first, 100);
        for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
            for step in [-1e-3, 1e-3] {
                assert!(energy(TilePlane(found.0 + step * axis), &points) >= energy(found, &points) - 1e-9);
            }
        }
    }

    #[test]
    fn points_without_a_plane_of_their_own_get_one_across_the_view() {
        let first = TilePlane::fronto_parallel(DVec3::new(0.0, 0.0, -1.0));
        let at = |x: f64, z: f64| at(DVec3::new(x, 0.0, z));
        // Points on one ray; on a line; a single point; on a plane through the centre of the region.
        let cases = [
            vec![at(0.0, -2.0), at(0.0, -3.0), at(0.0, -4.0)],
            vec![at(0.1, -2.0), at(0.0, -2.0), at(-0.1, -2.0)],
            vec![at(0.0, -2.0)],
            vec![at(0.0, -2.0), at(0.1, -3.0), at(0.2, -2.5), at(-0.1, -3.0)],
        ];
        for points in cases {
            let found = fit_plane(&points, &bounds(), first, 9);
            assert!(
                bounds().admits(found) && energy(found, &points) <= energy(first, &points),
                "{points:?}: {found:?}"
            );
        }
    }
}
