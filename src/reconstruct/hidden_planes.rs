//! Planes that go on where nothing sees them, such as walls and the floor behind a ball of glass (CALF 6.1).
//!
//! Enters: points at the edge of what is hidden, seen from one centre. Leaves: the planes that many of them lie on.

use glam::{Mat3, Vec3};

/// A plane counts where it goes through so large a part of the points.
pub const LEAST_PART: f32 = 0.1;
/// A point lies in a plane where their distances in its direction differ by at most this part.
pub const IN_PLANE: f32 = 0.01;
/// At most so many planes.
pub const MOST_PLANES: usize = 8;

/// A plane, by the vector whose product with a direction is 1 over the distance at which it is met.
pub type Plane = Vec3;

/// A point and the direction out of its surface, of length 1; both from the centre, the point in metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Edge {
    /// Where.
    pub point: Vec3,
    /// Which way the surface looks.
    pub normal: Vec3,
}

fn lies_in(plane: Plane, edge: &Edge) -> bool {
    (plane.dot(edge.point) - 1.0).abs() <= IN_PLANE
}

/// The planes of some points, the one with the most points first.
pub fn planes(edges: &[Edge]) -> Vec<Plane> {
    let least = (LEAST_PART * edges.len() as f32).max(3.0) as usize;
    let (mut left, mut found) = (edges.to_vec(), Vec::new());
    while found.len() < MOST_PLANES && left.len() >= least {
        let candidates = left.iter().filter_map(|edge| {
            // The surface looks at the centre, or it would not be seen from there.
            let height_m = edge.normal.dot(edge.point);
            let plane = edge.normal / height_m;
            (height_m < 0.0 && plane.is_finite())
                .then(|| (left.iter().filter(|edge| lies_in(plane, edge)).count(), plane))
        });
        let Some((count, plane)) = candidates.reduce(|best, next| if next.0 > best.0 { next } else { best }) else {
            break;
        };
        if count < least {
            break;
        }
        let fitted = fit(left.iter().filter(|edge| lies_in(plane, edge)));
        let better = fitted.filter(|&fitted| left.iter().filter(|edge| lies_in(fitted, edge)).count() >= count);
        let plane = better.unwrap_or(plane);
        left.retain(|edge| !lies_in(plane, edge));
        found.push(plane);
    }
    found
}

/// The plane that points lie in, by least squares; none where they lie on a line.
fn fit<'a>(edges: impl Iterator<Item = &'a Edge>) -> Option<Plane> {
    let (mut spread, mut sum) = (Mat3::ZERO, Vec3::ZERO);
    for Edge { point, .. } in edges {
        spread += Mat3::from_cols(*point * point.x, *point * point.y, *point * point.z);
        sum += *point;
    }
    let plane = spread.inverse() * sum;
    plane.is_finite().then_some(plane)
}

/// 1 over the distance at which the first of these planes is met in a direction of length 1, as in a room, whose walls hide
/// each other nowhere; none where none of them is met.
pub fn first_met(planes: &[Plane], direction: Vec3) -> Option<f32> {
    planes.iter().map(|plane| plane.dot(direction)).filter(|&inverse| inverse > 0.0).reduce(f32::max)
}

#[cfg(test)]
mod tests {
    use super::*;

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
    fn walls_go_on_and_balls_do_not() {
        let found = planes(&edges());
        assert_eq!(found.len(), 2, "{found:?}");
        assert!(found.iter().any(|plane| plane.distance(Vec3::NEG_Y) < 0.01), "{found:?}");
        assert!(found.iter().any(|plane| plane.distance(Vec3::NEG_X) < 0.01), "{found:?}");
        // Down and to the left beyond all points, where the two walls meet.
        let down = Vec3::new(-0.6, -0.8, 0.0);
        assert!((first_met(&found, down).unwrap() - 0.8).abs() < 0.01);
        assert!((first_met(&found, Vec3::new(-0.8, -0.6, 0.0)).unwrap() - 0.8).abs() < 0.01);
        assert_eq!(first_met(&found, Vec3::X), None);
        assert!(planes(&[]).is_empty());
    }
}
