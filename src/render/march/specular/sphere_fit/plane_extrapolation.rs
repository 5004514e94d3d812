//! Plane extrapolation: walls and floors that continue behind a refractive solid.
//!
//! Takes surface points next to hidden directions, relative to one centre. Returns the planes that many of the points lie in.

use glam::{DMat3, DVec3, Vec3};
use rayon::prelude::*;

use codec::error::Result;
use codec::monitor::Monitor;

/// Minimum fraction of the points that lie in a plane.
pub const MIN_PART: f32 = 0.1;
/// Maximum relative difference of the distances of a point and of a plane, in the direction of the point, at which the point lies
/// in the plane.
pub const IN_PLANE: f32 = 0.01;
pub const MAX_PLANES: usize = 8;

/// Vector whose product with a unit direction is 1 over the distance of the plane in that direction.
pub type Plane = Vec3;

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Edge {
    /// In metres relative to the centre.
    pub point: Vec3,
    /// Unit normal.
    pub normal: Vec3,
}

fn lies_in(plane: Plane, edge: &Edge) -> bool {
    (plane.dot(edge.point) - 1.0).abs() <= IN_PLANE
}

/// Returns the planes of some points, the one with the most points first. Takes quadratic time.
pub fn planes(edges: &[Edge], monitor: &dyn Monitor) -> Result<Vec<Plane>> {
    let least = (MIN_PART * edges.len() as f32).max(3.0) as usize;
    let (mut left, mut found) = (edges.to_vec(), Vec::new());
    while found.len() < MAX_PLANES && left.len() >= least {
        let count_of = |edge: &Edge| -> Result<Option<(usize, Plane)>> {
            monitor.check()?;
            // Surfaces seen from the centre face it.
            let height_m = edge.normal.dot(edge.point);
            let plane = edge.normal / height_m;
            let count = || left.iter().filter(|edge| lies_in(plane, edge)).count();
            Ok((height_m < 0.0 && plane.is_finite()).then(|| (count(), plane)))
        };
        let candidates: Vec<_> = left.par_iter().map(count_of).collect::<Result<_>>()?;
        let first_most =
            candidates.into_iter().flatten().reduce(|best, next| if next.0 > best.0 { next } else { best });
        let Some((count, plane)) = first_most else { break };
        if count < least {
            break;
        }
        let fitted = fit(left.iter().filter(|edge| lies_in(plane, edge)));
        let better = fitted.filter(|&fitted| left.iter().filter(|edge| lies_in(fitted, edge)).count() >= count);
        let plane = better.unwrap_or(plane);
        left.retain(|edge| !lies_in(plane, edge));
        found.push(plane);
    }
    Ok(found)
}

/// Mean of points, their root mean square distance from it, and their covariance in units of that distance.
pub struct Spread {
    pub middle: DVec3,
    pub unit_m: f64,
    pub covariance: DMat3,
}

impl Spread {
    pub fn of(points: impl Iterator<Item = DVec3> + Clone) -> Spread {
        let count = points.clone().count() as f64;
        let middle = points.clone().sum::<DVec3>() / count;
        let unit_m = (points.clone().map(|point| (point - middle).length_squared()).sum::<f64>() / count).sqrt();
        let add = |sum: DMat3, point: DVec3| {
            let from = (point - middle) / unit_m;
            sum + DMat3::from_cols(from * from.x, from * from.y, from * from.z)
        };
        Spread { middle, unit_m, covariance: points.fold(DMat3::ZERO, add) * count.recip() }
    }
}

/// Fits a plane to points, by least squares of its product with them minus 1. None if the points lie on a line, or in a plane
/// through the centre.
///
/// With the covariance S of the points and their mean m, the normal equations (S + m·mᵀ)·p = m are solved by the Sherman–Morrison
/// formula with the adjugate of S, because S is singular for flat, small or distant sets.
fn fit<'a>(edges: impl Iterator<Item = &'a Edge> + Clone) -> Option<Plane> {
    let Spread { middle, unit_m, covariance } = Spread::of(edges.map(|edge| edge.point.as_dvec3()));
    let (away_m, way) = (middle.length(), middle.try_normalize()?);
    // Columns of the adjugate of a symmetric matrix.
    let [x, y, z] = [covariance.x_axis, covariance.y_axis, covariance.z_axis];
    let across = DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y)) * way;
    let facing = way.dot(across);
    // Points have single precision.
    let rounding = f64::from(f32::EPSILON) * away_m.hypot(unit_m) / unit_m;
    if facing.is_nan() || facing < rounding * rounding {
        return None;
    }
    // p = adj(S)·m / (det S + mᵀ·adj(S)·m), with S in units squared.
    let scale = (unit_m / away_m).powi(2);
    let plane = (across / away_m / (covariance.determinant() * scale + facing)).as_vec3();
    plane.is_finite().then_some(plane)
}

/// Returns 1 over the distance of the nearest plane in a direction of length 1, as inside a convex room.
pub fn nearest_inverse(planes: &[Plane], direction: Vec3) -> Option<f32> {
    planes.iter().map(|plane| plane.dot(direction)).filter(|&inverse| inverse > 0.0).reduce(f32::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use codec::monitor::Silent;

    /// Points of a room of 2 by 2 by 2 metres, and of a small ball.
    fn edges() -> Vec<Edge> {
        let wall = |at: usize| {
            let [a, b] = [at % 10, at / 10].map(|at| at as f32 / 9.0 - 0.5);
            [
                Edge { point: Vec3::new(a, -1.0, b), normal: Vec3::new(0.02 * a, 1.0, 0.02 * b).normalize() },
                Edge { point: Vec3::new(-1.0, a, b), normal: Vec3::X },
            ]
        };
        let on_ball = |at: usize| {
            let normal = Vec3::new(at as f32 / 20.0 - 0.5, (at * 7 % 20) as f32 / 20.0 - 0.5, -1.0).normalize();
            Edge { point: Vec3::new(0.0, 0.0, 0.9) + 0.2 * normal, normal }
        };
        (0..100).flat_map(wall).chain((0..20).map(on_ball)).collect()
    }

    #[test]
    fn walls_are_extrapolated_and_spheres_are_not() {
        let found = planes(&edges(), &Silent).unwrap();
        assert_eq!(found.len(), 2, "{found:?}");
        assert!(found.iter().any(|plane| plane.distance(Vec3::NEG_Y) < 0.01), "{found:?}");
        assert!(found.iter().any(|plane| plane.distance(Vec3::NEG_X) < 0.01), "{found:?}");
        // Down and to the left, beyond all points, where the two walls meet.
        let down = Vec3::new(-0.6, -0.8, 0.0);
        assert!((nearest_inverse(&found, down).unwrap() - 0.8).abs() < 0.01);
        assert!((nearest_inverse(&found, Vec3::new(-0.8, -0.6, 0.0)).unwrap() - 0.8).abs() < 0.01);
        assert_eq!(nearest_inverse(&found, Vec3::X), None);
        assert!(planes(&[], &Silent).unwrap().is_empty());
    }

    /// A small part of a wall, which least squares in single precision around the centre cannot distinguish from a line.
    #[test]
    fn planes_are_scale_free() {
        let wall = Vec3::new(0.3, -0.2, -1.0);
        let part = |at: usize, breadth: f32| {
            let [x, y] = [at % 10, at / 10].map(|at| (at as f32 - 4.5) * breadth);
            Vec3::new(x, y, (1.0 - wall.x * x - wall.y * y) / wall.z)
        };
        for size in [1e-15, 1e-5, 1.0, 1e5, 1e15] {
            for breadth in [0.1, 0.01, 0.003] {
                let edge = |at: usize| Edge { point: size * part(at, breadth), normal: -wall.normalize() };
                let edges: Vec<Edge> = (0..100).map(edge).collect();
                let found = fit(edges.iter()).unwrap();
                // Rounding errors of the plane, and of coordinates near 1 over the 9 breadths that the points cover.
                let most = 4.0 * f32::EPSILON * (1.0 + 1.0 / (9.0 * breadth));
                assert!((size * found).distance(wall) < most, "{size} {breadth}: {found}");
                assert_eq!(fit(edges[..10].iter()), None, "a line, {size} {breadth}");
            }
        }
        assert_eq!((fit([].iter()), fit(edges()[..1].iter())), (None, None));
        // A plane through the centre.
        let through = |at: usize| Edge { point: Vec3::new(at as f32, 1.0 + (at * at) as f32, 0.0), normal: Vec3::Z };
        let edges: Vec<Edge> = (0..9).map(through).collect();
        assert_eq!(fit(edges.iter()), None);
    }
}
