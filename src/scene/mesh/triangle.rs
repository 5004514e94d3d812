//! Intersection of a ray with a triangle, and distance of a point from a triangle, in f64.
//!
//! Based on: Woop, Benthin and Wald, "Watertight ray/triangle intersection", JCGT 2013. Shared edges and corners are rounded in
//! the same way for both triangles, and the sign of an edge function is exact, so no ray passes between two triangles of a closed
//! mesh.

use glam::{DVec2, DVec3};

use super::ray::Ray;

/// A ray as its dominant axis (depth) and the shear that aligns the ray with this axis.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RayFrame {
    origin: DVec3,
    depth: usize,
    /// Shear of the other two axes, and metres along the ray, per metre of depth.
    shear: [f64; 3],
}

impl RayFrame {
    pub(crate) fn new(ray: &Ray) -> RayFrame {
        let direction = ray.direction();
        let depth = direction.abs().max_position();
        let per_metre = direction[depth].recip();
        let shear = [direction[(depth + 1) % 3] * per_metre, direction[(depth + 2) % 3] * per_metre, per_metre];
        RayFrame { origin: ray.origin(), depth, shear }
    }

    /// Returns the metres along the ray (of either sign) and the weights of the second and third corner. `None` for a miss and
    /// for triangles seen edge-on. Edges and corners belong to every triangle that has them.
    #[inline]
    pub(crate) fn intersect(&self, corners: &[DVec3; 3]) -> Option<(f64, DVec2)> {
        match self.depth {
            0 => self.intersect_in([1, 2, 0], corners),
            1 => self.intersect_in([2, 0, 1], corners),
            _ => self.intersect_in([0, 1, 2], corners),
        }
    }

    /// Implements [`Self::intersect`] with constant axes.
    #[inline(always)]
    fn intersect_in(&self, axes: [usize; 3], corners: &[DVec3; 3]) -> Option<(f64, DVec2)> {
        let [a, b, c] = corners.map(|corner| {
            let from = (corner - self.origin).to_array();
            let depth = from[axes[2]];
            [from[axes[0]] - self.shear[0] * depth, from[axes[1]] - self.shear[1] * depth, depth]
        });
        let beside = |[u, v, w]: [f64; 3]| (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0);
        let mut weights = [side(c, b), side(a, c), side(b, a)];
        if beside(weights) {
            return None;
        }
        if weights.contains(&0.0) {
            weights = [side_exactly(c, b), side_exactly(a, c), side_exactly(b, a)];
            if beside(weights) {
                return None;
            }
        }
        let [u, v, w] = weights;
        let all = u + v + w;
        if all == 0.0 {
            return None;
        }
        let distance = self.shear[2] * (u * a[2] + v * b[2] + w * c[2]) / all;
        Some((distance, DVec2::new(v / all, w / all)))
    }
}

/// Edge function: twice the signed area between the ray and an edge. The sign is correct or 0, because rounding is monotonic.
#[inline(always)]
fn side(p: [f64; 3], q: [f64; 3]) -> f64 {
    p[0] * q[1] - p[1] * q[0]
}

/// Computes [`side`] if both products round to the same number, from their rounding errors.
#[cold]
fn side_exactly(p: [f64; 3], q: [f64; 3]) -> f64 {
    let rounded = side(p, q);
    if rounded != 0.0 {
        return rounded;
    }
    let (first, second) = (p[0] * q[1], p[1] * q[0]);
    p[0].mul_add(q[1], -first) - p[1].mul_add(q[0], -second)
}

/// True if the cross product of two edges is not 0.
pub(super) fn has_area([a, b, c]: &[DVec3; 3]) -> bool {
    (b - a).cross(c - a) != DVec3::ZERO
}

/// Returns the square of a point's distance, in square metres: from the plane of the triangle if the point projects into the
/// triangle, else from the nearest edge.
pub(super) fn distance_squared([a, b, c]: [DVec3; 3], point: DVec3) -> f64 {
    let normal = (b - a).cross(c - a);
    let above = |from: DVec3, to: DVec3| (to - from).cross(point - from).dot(normal) >= 0.0;
    if above(a, b) && above(b, c) && above(c, a) && normal.length_squared() > 0.0 {
        let height = (point - a).dot(normal.normalize());
        return height * height;
    }
    let edge = |from: DVec3, to: DVec3| {
        let along = to - from;
        let share = (point - from).dot(along) / along.length_squared().max(f64::MIN_POSITIVE);
        (point - (from + share.clamp(0.0, 1.0) * along)).length_squared()
    };
    edge(a, b).min(edge(b, c)).min(edge(c, a))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn meet(corners: [[f64; 3]; 3], origin: [f64; 3], direction: [f64; 3]) -> Option<(f64, DVec2)> {
        let ray = Ray::new(origin.into(), direction.into()).unwrap();
        RayFrame::new(&ray).intersect(&corners.map(DVec3::from))
    }

    const RIGHT: [[f64; 3]; 3] = [[0.0, 0.0, -2.0], [1.0, 0.0, -2.0], [0.0, 1.0, -2.0]];

    #[test]
    fn distance_and_weights_from_both_sides() {
        let (distance, at) = meet(RIGHT, [0.25, 0.5, 0.0], [0.0, 0.0, -1.0]).unwrap();
        assert_eq!((distance, at), (2.0, DVec2::new(0.25, 0.5)));
        let (distance, at) = meet(RIGHT, [0.25, 0.5, -5.0], [0.0, 0.0, 1.0]).unwrap();
        assert_eq!((distance, at), (3.0, DVec2::new(0.25, 0.5)));
        // Behind the origin the distance is negative; callers filter it.
        assert_eq!(meet(RIGHT, [0.25, 0.5, -3.0], [0.0, 0.0, -1.0]).unwrap().0, -1.0);
        assert!(meet(RIGHT, [0.6, 0.6, 0.0], [0.0, 0.0, -1.0]).is_none());
    }

    #[test]
    fn borders_belong_to_it() {
        for [x, y] in [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [0.5, 0.5], [0.5, 0.0], [0.0, 0.3]] {
            assert!(meet(RIGHT, [x, y, 0.0], [0.0, 0.0, -1.0]).is_some(), "{x} {y}");
        }
    }

    #[test]
    fn in_its_plane_it_is_not_seen() {
        assert!(meet(RIGHT, [-1.0, 0.25, -2.0], [1.0, 0.0, 0.0]).is_none());
        assert!(meet(RIGHT, [-1.0, 0.0, -2.0], [1.0, 0.0, 0.0]).is_none());
        assert!(meet([[0.0; 3], [0.0; 3], [0.0; 3]], [0.0, 0.0, 1.0], [0.0, 0.0, -1.0]).is_none());
    }

    #[test]
    fn an_edge_so_near_that_products_round_to_the_same_still_has_two_sides() {
        // The point is off the line by less than the products resolve.
        let (p, q) = ([1.0 + f64::EPSILON, 1.0, 0.0], [1.0, 1.0 - 0.5 * f64::EPSILON, 0.0]);
        let exact = side_exactly(p, q);
        assert!(exact != 0.0 && side_exactly(q, p) == -exact);
        assert_eq!(side_exactly(p, p), 0.0);
    }
}
