//! Triangulation of polygons: a fan for convex ones, ear clipping for others.

use glam::{DVec2, DVec3};

/// Largest sine of an inward turn of a corner that counts as straight.
const STRAIGHT: f64 = 1e-6;

/// Adds the triangles of a polygon, with the polygon's winding, as indices into its corners.
pub fn triangulate(corners: &[DVec3], mut add: impl FnMut([usize; 3])) {
    let fan = (1..corners.len().saturating_sub(1)).map(|at| [0, at, at + 1]);
    if corners.len() <= 3 {
        return fan.for_each(add);
    }
    let flat = in_plane(corners);
    if is_convex(&flat) {
        return fan.for_each(add);
    }
    let numbers: Vec<f64> = flat.iter().flat_map(|corner| corner.to_array()).collect();
    match earcutr::earcut(&numbers, &[], 2) {
        Ok(triangles) if !triangles.is_empty() => {
            for &[a, b, c] in triangles.as_chunks::<3>().0 {
                let turn = (flat[b] - flat[a]).perp_dot(flat[c] - flat[a]);
                add(if turn < 0.0 { [a, c, b] } else { [a, b, c] });
            }
        }
        // The corners enclose no area.
        _ => fan.for_each(add),
    }
}

/// Returns the corners in the plane of the polygon, counter-clockwise. Its normal is the sum over its edges (Newell's method), so
/// that corners need not be coplanar.
fn in_plane(corners: &[DVec3]) -> Vec<DVec2> {
    let first = corners[0];
    let edges = corners.iter().zip(corners.iter().cycle().skip(1));
    let normal: DVec3 = edges.map(|(&a, &b)| (a - first).cross(b - first)).sum();
    let normal = normal.normalize_or(DVec3::Z);
    let (x, y) = normal.any_orthonormal_pair();
    corners.iter().map(|&corner| DVec2::new((corner - first).dot(x), (corner - first).dot(y))).collect()
}

fn is_convex(corners: &[DVec2]) -> bool {
    let count = corners.len();
    let turn = |at: usize| {
        let [a, b, c] = [0, 1, 2].map(|step| corners[(at + step) % count]);
        let (before, after) = (b - a, c - b);
        before.perp_dot(after) >= -STRAIGHT * before.length() * after.length()
    };
    // A star turns only to the left, too, but more than once around.
    let angle = |at: usize| {
        let [a, b, c] = [0, 1, 2].map(|step| corners[(at + step) % count]);
        (b - a).perp_dot(c - b).atan2((b - a).dot(c - b))
    };
    (0..count).all(turn) && (0..count).map(angle).sum::<f64>() < 1.5 * std::f64::consts::TAU
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the triangles, the sum of their areas and true if all face along +Z.
    fn of(corners: &[[f64; 2]]) -> (Vec<[usize; 3]>, f64, bool) {
        let corners: Vec<DVec3> = corners.iter().map(|&[x, y]| DVec3::new(x, y, 0.5 * x)).collect();
        let (mut triangles, mut area, mut is_up) = (Vec::new(), 0.0, true);
        triangulate(&corners, |triangle| {
            let [a, b, c] = triangle.map(|at| corners[at]);
            let cross = (b - a).cross(c - a);
            area += 0.5 * cross.z.abs();
            is_up &= cross.z >= 0.0;
            triangles.push(triangle);
        });
        (triangles, area, is_up)
    }

    #[test]
    fn convex_polygons_are_fans() {
        assert_eq!(of(&[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]).0, [[0, 1, 2]]);
        let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        assert_eq!(of(&square).0, [[0, 1, 2], [0, 2, 3]]);
        let straight = [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0]];
        assert_eq!(of(&straight).0, [[0, 1, 2], [0, 2, 3], [0, 3, 4]]);
        assert!(of(&[[0.0, 0.0], [1.0, 0.0]]).0.is_empty());
    }

    #[test]
    fn notches_and_windows_stay_open() {
        let arrow = [[0.0, 0.0], [2.0, -1.0], [1.0, 0.0], [2.0, 1.0]];
        for turn in 0..4 {
            let mut arrow = arrow;
            arrow.rotate_left(turn);
            let (triangles, area, is_up) = of(&arrow);
            assert_eq!((triangles.len(), is_up), (2, true));
            assert!((area - 1.0).abs() < 1e-12, "{area}");
        }
        // A square of 4 by 4 with a window of 2 by 2, joined by an edge that is passed twice.
        let window = [
            [0.0, 0.0],
            [4.0, 0.0],
            [4.0, 4.0],
            [0.0, 4.0],
            [0.0, 0.0],
            [1.0, 1.0],
            [1.0, 3.0],
            [3.0, 3.0],
            [3.0, 1.0],
            [1.0, 1.0],
        ];
        let (_, area, is_up) = of(&window);
        assert!((area - 12.0).abs() < 1e-9 && is_up, "{area}");
    }

    #[test]
    fn corners_without_area_are_kept() {
        assert_eq!(of(&[[0.0, 0.0]; 4]).0.len(), 2);
        assert_eq!(of(&[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [1.0, 0.0]]).1, 0.0);
    }
}
