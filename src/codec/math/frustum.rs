//! A frustum: the view volume of a camera, or the volume of all surfaces that a rectangle of a probe's pixels can show (CALF
//! 6.2).

use glam::DVec3;

/// A rectangle on the plane at distance 1 from the apex: `forward + u · right + v · down`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Window {
    pub u: [f64; 2],
    pub v: [f64; 2],
}

/// A frustum with precomputed values for intersection tests.
#[derive(Debug, Clone, PartialEq)]
pub struct Frustum {
    pub(super) apex: DVec3,
    /// Forward, right and down.
    axes: [DVec3; 3],
    window: Window,
    /// Near and far planes along the axis, in metres.
    pub(super) depth_m: [f64; 2],
    /// Directions of the four edges, of planar depth 1, in order around the frustum.
    pub(super) corners: [DVec3; 4],
    /// `corners` with length 1.
    pub(super) rays: [DVec3; 4],
    /// Normals of the four sides, of length 1, pointing inwards.
    pub(super) sides: [DVec3; 4],
    /// Maximum length of `corners`.
    pub(super) reach: f64,
}

/// Frusta whose corners or near plane reach this length are unsound, and larger volumes count as intersecting, so that
/// products of lengths stay finite.
pub(super) const MAX_LENGTH: f64 = 1e100;

impl Frustum {
    /// Returns a frustum from its apex; its axes forward, right and down (orthogonal, of length 1); a window; and its near
    /// and far distance along forward: 0 ≤ near ≤ far, in metres, where far may be `+inf`.
    ///
    /// Other non-finite numbers make an unsound frustum: all tests report that it is intersected.
    pub fn new(apex: DVec3, axes: [DVec3; 3], window: Window, depth_m: [f64; 2]) -> Frustum {
        let [forward, right, down] = axes;
        let Window { u: [left, far_right], v: [top, bottom] } = window;
        let corner = |u: f64, v: f64| forward + u * right + v * down;
        let corners = [corner(left, top), corner(far_right, top), corner(far_right, bottom), corner(left, bottom)];
        let sides =
            [down - top * forward, far_right * forward - right, bottom * forward - down, right - left * forward];
        Frustum {
            apex,
            axes,
            window,
            depth_m,
            corners,
            rays: corners.map(DVec3::normalize),
            sides: sides.map(DVec3::normalize),
            reach: corners.iter().fold(0.0, |longest, corner| corner.length().max(longest)),
        }
    }

    /// True if tests are reliable.
    pub(super) fn is_sound(&self) -> bool {
        let unit = |vector: &DVec3| (vector.length() - 1.0).abs() < 1e-6;
        let [near, far] = self.depth_m;
        self.apex.is_finite()
            && self.reach < MAX_LENGTH
            && self.axes.iter().chain(&self.rays).chain(&self.sides).all(unit)
            && (0.0..MAX_LENGTH).contains(&near)
            && near <= far
    }

    /// True if a point lies inside or on the boundary.
    pub fn contains(&self, point: DVec3) -> bool {
        let from_apex = point - self.apex;
        let depth = from_apex.dot(self.axes[0]);
        self.depth_m[0] <= depth && depth <= self.depth_m[1] && self.contains_direction(from_apex)
    }

    /// True if a direction, of any length, lies in the cone of the frustum.
    pub fn contains_direction(&self, direction: DVec3) -> bool {
        self.sides.iter().all(|side| side.dot(direction) >= 0.0)
    }

    /// Normals of the planes; near and far share one.
    pub(super) fn normals(&self) -> [DVec3; 5] {
        let [a, b, c, d] = self.sides;
        [self.axes[0], a, b, c, d]
    }

    /// Directions of the edges, of length 1.
    pub(super) fn edges(&self) -> [DVec3; 6] {
        let [a, b, c, d] = self.rays;
        [self.axes[1], self.axes[2], a, b, c, d]
    }

    /// Returns the frustum with a window that contains all directions within `angle` radians (at most 10⁻⁶) of its own;
    /// `None` if the frustum is already nearly a half space.
    pub(super) fn widened(&self, angle: f64) -> Option<Frustum> {
        // A side moved by `step` is at an angle of step / (√(1 + u²) · length) from a direction of that length, and neither
        // factor exceeds `reach` by much.
        let step = 2.0 * angle * self.reach * self.reach;
        if step.is_nan() || step > 0.2 * self.reach {
            return None;
        }
        let Window { u: [left, right], v: [top, bottom] } = self.window;
        let window = Window { u: [left - step, right + step], v: [top - step, bottom + step] };
        Some(Frustum::new(self.apex, self.axes, window, self.depth_m))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cube_face() -> Frustum {
        let axes = [DVec3::NEG_Z, DVec3::X, DVec3::NEG_Y];
        Frustum::new(DVec3::new(1.0, 2.0, 3.0), axes, Window { u: [-1.0, 1.0], v: [-0.5, 0.25] }, [1.0, 4.0])
    }

    #[test]
    fn points_are_inside_or_not() {
        let frustum = cube_face();
        let at = |u: f64, v: f64, depth: f64| frustum.apex + depth * DVec3::new(u, -v, -1.0);
        for (u, v, depth) in [(0.0, 0.0, 2.0), (0.99, 0.24, 3.9), (-0.99, -0.49, 1.01)] {
            assert!(frustum.contains(at(u, v, depth)), "{u} {v} {depth}");
        }
        for (u, v, depth) in [(1.01, 0.0, 2.0), (0.0, 0.26, 2.0), (0.0, -0.51, 2.0), (0.0, 0.0, 0.99), (0.0, 0.0, 4.1)]
        {
            assert!(!frustum.contains(at(u, v, depth)), "{u} {v} {depth}");
        }
        assert!(frustum.is_sound());
    }

    #[test]
    fn sides_point_inwards_and_hold_their_edges() {
        let frustum = cube_face();
        for (at, side) in frustum.sides.iter().enumerate() {
            assert!(side.dot(DVec3::NEG_Z) > 0.0);
            for edge in [at, (at + 1) % 4] {
                assert!(side.dot(frustum.rays[edge]).abs() < 1e-15, "side {at}, edge {edge}");
            }
            assert!(side.dot(frustum.rays[(at + 2) % 4]) > 0.1 && side.dot(frustum.rays[(at + 3) % 4]) > 0.1);
        }
    }

    #[test]
    fn a_widened_frustum_has_all_directions_around_its_own() {
        let angle = 1e-6;
        for window in [
            Window { u: [-1.0, 1.0], v: [-1.0, 1.0] },
            Window { u: [-100.0, 100.0], v: [-1e-4, 1e-4] },
            Window { u: [-50.0, 50.0], v: [-50.0, 50.0] },
            Window { u: [0.0, 0.0], v: [0.0, 0.0] },
        ] {
            let frustum = Frustum::new(DVec3::ZERO, [DVec3::X, DVec3::Y, DVec3::Z], window, [0.0, 1.0]);
            let wide = frustum.widened(angle).unwrap();
            for ray in frustum.rays {
                assert!(wide.sides.iter().all(|side| side.dot(ray) >= angle.sin()), "{window:?}");
            }
            assert!(wide.reach < 1.3 * frustum.reach);
        }
        let window = Window { u: [-1e6, 1e6], v: [-1.0, 1.0] };
        assert!(Frustum::new(DVec3::ZERO, [DVec3::X, DVec3::Y, DVec3::Z], window, [0.0, 1.0]).widened(angle).is_none());
    }

    #[test]
    fn numbers_that_are_not_finite_are_noticed() {
        let (axes, window) = ([DVec3::X, DVec3::Y, DVec3::Z], Window { u: [0.0, 1.0], v: [0.0, 1.0] });
        let sound = |apex, axes, window, depth_m| Frustum::new(apex, axes, window, depth_m).is_sound();
        assert!(sound(DVec3::ZERO, axes, window, [0.0, f64::INFINITY]));
        assert!(!sound(DVec3::NAN, axes, window, [0.0, 1.0]));
        assert!(!sound(DVec3::ZERO, [DVec3::ZERO; 3], window, [0.0, 1.0]));
        assert!(!sound(DVec3::ZERO, axes, Window { u: [0.0, f64::INFINITY], ..window }, [0.0, 1.0]));
        assert!(!sound(DVec3::ZERO, axes, Window { v: [0.0, 1e200], ..window }, [0.0, 1.0]));
        assert!(!sound(DVec3::ZERO, axes, window, [2.0, 1.0]));
        assert!(!sound(DVec3::ZERO, axes, window, [f64::NAN, 1.0]));
    }
}
