//! Separating axis tests of frusta and of their direction cones.
//!
//! Two convex polyhedra are disjoint if and only if a face normal of either, or a cross product of an edge of each, separates
//! them. A rounded axis that separates them proves this as well as an exact one, so rounding errors can only hide that they
//! are disjoint.

use glam::DVec3;

use super::frustum::{Frustum, MAX_LENGTH};

/// Gap, relative to the sum of all lengths involved, that may be rounding error; the error of a product of vectors is below 3
/// · 10⁻¹⁵.
const SLACK: f64 = 1e-13;
/// Cosine that may be rounding error.
const COSINE_SLACK: f64 = 1e-14;

/// True if `a` and `b` share no direction, except on the boundary of both: widen one of them for a margin.
pub(super) fn directions_apart(a: &Frustum, b: &Frustum) -> bool {
    let before = |normal: DVec3, rays: &[DVec3; 4]| rays.iter().all(|ray| normal.dot(*ray) >= -COSINE_SLACK);
    let behind = |normal: DVec3, rays: &[DVec3; 4]| rays.iter().all(|ray| normal.dot(*ray) <= COSINE_SLACK);
    if a.sides.iter().any(|side| behind(*side, &b.rays)) || b.sides.iter().any(|side| behind(*side, &a.rays)) {
        return true;
    }
    let across = |edge: &DVec3, other: &DVec3| {
        let Some(normal) = edge.cross(*other).try_normalize() else { return false };
        (before(normal, &a.rays) && behind(normal, &b.rays)) || (behind(normal, &a.rays) && before(normal, &b.rays))
    };
    a.rays.iter().any(|edge| b.rays.iter().any(|other| across(edge, other)))
}

/// True if `a`, up to `far_m[0]` metres along its axis, and `b`, up to `far_m[1]` metres, share no point.
pub(super) fn volumes_apart(a: &Frustum, b: &Frustum, far_m: [f64; 2]) -> bool {
    let offset = b.apex - a.apex;
    let size = far_m[0] * a.reach + far_m[1] * b.reach + offset.length() + a.apex.length() + b.apex.length();
    if size.is_nan() || size > MAX_LENGTH {
        return false;
    }
    let slack = SLACK * size;
    let apart = |axis: &DVec3| {
        let [a_low, a_high] = extent(a, *axis, far_m[0]);
        let [b_low, b_high] = extent(b, *axis, far_m[1]);
        let shift = offset.dot(*axis);
        b_low + shift - a_high > slack || a_low - b_high - shift > slack
    };
    if a.normals().iter().any(apart) || b.normals().iter().any(apart) {
        return true;
    }
    let (a_edges, b_edges) = (a.edges(), b.edges());
    a_edges
        .iter()
        .any(|edge| b_edges.iter().any(|other| edge.cross(*other).try_normalize().is_some_and(|axis| apart(&axis))))
}

/// Minimum and maximum product with `axis` of the points of a frustum up to `far_m`, relative to its apex.
fn extent(frustum: &Frustum, axis: DVec3, far_m: f64) -> [f64; 2] {
    let near_m = frustum.depth_m[0].min(far_m);
    let [mut low, mut high] = [f64::INFINITY, f64::NEG_INFINITY];
    for corner in frustum.corners {
        let product = corner.dot(axis);
        low = low.min(product);
        high = high.max(product);
    }
    [low * if low < 0.0 { far_m } else { near_m }, high * if high < 0.0 { near_m } else { far_m }]
}
