//! Fit of the plane of a quad tile that displaces points the least ([`super::energy`]).
//!
//! The inverse distance of a plane along a ray is linear in the plane, so displacement is a linear least-squares problem. Its bound
//! is reached by rounds of reweighting (Geman and McClure).

use glam::{DMat3, DVec3};

use super::energy::{EnergyKind, WeightedPoint};
use super::fit::FitBounds;
use super::tile_plane::TilePlane;

/// Number of rounds of reweighting.
const ROUNDS: usize = 3;
/// Weight of the plane across the line of sight, relative to that of all points: it decides where points leave the plane open.
const PRIOR: f64 = 1e-5;
/// Share of a solution outside of the bounds below which it is given up.
const MIN_SHARE: f64 = 0.1;

/// Fits a plane to points, starting from `first`. Returns the plane with the lowest energy among `first`, the plane across the line
/// of sight and the rounds, each moved towards the second until the bounds admit it.
pub fn fit_displacement(points: &[WeightedPoint], bounds: &FitBounds, first: TilePlane) -> TilePlane {
    let weight: f64 = points.iter().map(|point| point.weight).sum();
    if weight.is_nan() || weight <= 0.0 {
        return first;
    }
    let energy = |plane: TilePlane| {
        if bounds.admits(plane) { EnergyKind::Picture.sum(plane, points) } else { f64::INFINITY }
    };
    let inverse_m = points.iter().map(|point| point.weight / point.position.length()).sum::<f64>() / weight;
    let toward: DVec3 = points.iter().map(|point| point.weight * point.position.normalize_or_zero()).sum();
    let toward = toward.normalize_or_zero();
    let flat = TilePlane(toward * inverse_m);
    let mut best = (flat, energy(flat));
    let of_first = energy(first);
    if of_first < best.1 {
        best = (first, of_first);
    }
    if points.len() < 3 {
        return best.0;
    }
    for _ in 0..ROUNDS {
        let Some(solved) = solve(points, best.0, (toward, inverse_m)) else { break };
        let mut share = 1.0;
        let mut next = solved;
        while !bounds.admits(next) && share > MIN_SHARE {
            share *= 0.5;
            next = TilePlane(flat.0.lerp(solved.0, share));
        }
        let found = energy(next);
        if found >= best.1 {
            break;
        }
        best = (next, found);
    }
    best.0
}

/// Solves one round: the sum of squared displacements, weighted by the displacement at `before`.
fn solve(points: &[WeightedPoint], before: TilePlane, (toward, inverse_m): (DVec3, f64)) -> Option<TilePlane> {
    let (mut squares, mut sum, mut weights) = (DMat3::ZERO, DVec3::ZERO, 0.0);
    for point in points {
        let by = point.weight * point.sway_px.powi(2) * point.reweight(before);
        // In units of the mean distance, so that the matrix has no physical unit.
        let p = point.position * inverse_m;
        squares += DMat3::from_cols(p * p.x, p * p.y, p * p.z) * by;
        sum += by * p;
        weights += by;
    }
    if weights.is_nan() || weights <= 0.0 {
        return None;
    }
    let squares = squares * (1.0 / weights) + DMat3::from_diagonal(DVec3::splat(PRIOR));
    let plane = squares.inverse() * (sum / weights + PRIOR * toward) * inverse_m;
    plane.is_finite().then_some(TilePlane(plane))
}
