//! Ray marching over whole segments that one view proves empty (CALF 6, algorithm 4).
//!
//! Takes active views with pyramids, and a ray. Returns the same step as testing every point, after far fewer tests.
//!
//! If the ends of a segment lie in one face of a view, its points project into the rectangle of texels between the ends, and none
//! is farther than the farther end. If the nearest surface in the rectangle, by the pyramid, is beyond that distance, the segment
//! is empty. A margin for rounding ([`ROUNDING`]) keeps the test conservative. Other segments are halved, down to single points,
//! which [`ActiveViews::is_surface`] classifies.

use glam::Vec3;

use crate::march::{ActiveView, ActiveViews, Counters, MIN_M, Occupancy, Ray, StepsFrom, Until};
use codec::image::Face;

/// Rounding error of a coordinate in a view's axes, relative to the sum of the largest absolute coordinates that it is computed
/// from.
///
/// Multiplying the direction, adding the origin and subtracting the view's position round three times, and the rotation five more
/// times, each by at most 2⁻²⁴ of a sum of these. With a factor of √3 for the three coordinates that each of them affects, the
/// error is less than 16 · 2⁻²⁴.
pub const ROUNDING: f32 = 1.0 / 1_048_576.0;
/// If the product of a planar depth and an inverse depth is below this, it is below 1 regardless of rounding.
pub const SURELY_BELOW_ONE: f32 = 1.0 - ROUNDING;

/// True if a view proves a segment empty. `reach_m` is the sum of the largest absolute coordinates of the ray's origin and of the
/// vector from it to the farther end.
///
/// Points are up to 2e from the segment between the ends, where e is the rounding error of each. This moves a position in the
/// plane at depth 1 by at most 4e (1 + its largest absolute coordinate) divided by the nearer planar depth, as long as that depth
/// is at least 4e. The added [`ROUNDING`] covers the division and later operations.
pub fn is_segment_empty(view: &ActiveView<'_>, ends: [Vec3; 2], reach_m: f32) -> bool {
    let error_m = ROUNDING * (reach_m + view.from_eye.abs().max_element()) + MIN_M;
    let [a, b] = ends.map(|end| view.local(end));
    // A planar depth is the largest absolute coordinate, for any face.
    let farthest_m = a.abs().max_element().max(b.abs().max_element()) + 2.0 * error_m;
    if view.greatest_inverse_depth * farthest_m < SURELY_BELOW_ONE {
        return true;
    }
    let (Some(a), Some(b)) = (view.view.planar_point(a), view.view.planar_point(b)) else { return false };
    let (nearest_m, farthest_m) = (a.planar.min(b.planar), a.planar.max(b.planar) + 2.0 * error_m);
    let face = a.face;
    let texels = match &view.view.faces[face] {
        Some(texels) if face == b.face && nearest_m >= 4.0 * error_m => texels,
        _ => return false,
    };
    let widest = [a, b].map(|end| end.plane[0].abs().max(end.plane[1].abs()));
    let widest = widest[0].max(widest[1]);
    let slack = (1.0 + widest) * (4.0 * error_m / nearest_m + ROUNDING);
    let is_view = face == Face::View as usize;
    if !(is_view || widest + slack <= 1.0) {
        return false;
    }
    let (mut from, mut to) = ([0; 2], [0; 2]);
    let ends = [a, b].map(|end| texels.map.position(end.plane));
    for axis in 0..2 {
        let [one, two] = ends.map(|at| at[axis]);
        let size = texels.size[axis];
        let margin = slack * texels.map.scale[axis].abs() + size as f32 * ROUNDING;
        let (low, high) = (one.min(two) - margin, one.max(two) + margin);
        if is_view && !(low >= 0.0 && high < size as f32) {
            return false;
        }
        let reach = view.footprint.reach();
        (from[axis], to[axis]) = (((low - reach) as u32).min(size - 1), ((high + reach) as u32).min(size - 1));
    }
    view.pyramids.faces[face].greatest_between(texels, from, to) * farthest_m < SURELY_BELOW_ONE
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Walk {
    /// Index of the first point that is not skipped yet.
    at: usize,
    /// Number of points of the next segment.
    length: usize,
    /// A later point that is empty in no view, and whether marching ends at it.
    blocked: Option<(usize, bool)>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Next {
    Hit(usize),
    /// Test the segment from the first to the last point, inclusive; they may be the same point.
    Test(usize, usize),
    End,
}

impl Walk {
    /// Starts at point `first` of `count`, with a segment of about a quarter of all points: the last quarter is rarely reached,
    /// and half of all points are rarely empty.
    pub(crate) fn new(first: usize, count: usize) -> Walk {
        let length = (count.next_power_of_two() / 4).max(1);
        let aligned = if first == 0 { length } else { 1 << first.trailing_zeros() };
        Walk { at: first, length: length.min(aligned), blocked: None }
    }

    /// Returns the next test. A segment whose last point is empty in no view is halved without a test.
    pub(crate) fn next(&mut self, count: usize) -> Next {
        while self.at < count {
            let last = (self.at + self.length).min(count) - 1;
            match self.blocked {
                Some((blocked, occupied)) if blocked == last => {
                    if last > self.at {
                        self.length /= 2;
                    } else if occupied {
                        return Next::Hit(self.at);
                    } else {
                        self.length = 1;
                        self.passed();
                    }
                }
                _ => {
                    if last == self.at {
                        self.length = 1;
                    }
                    return Next::Test(self.at, last);
                }
            }
        }
        Next::End
    }

    /// Skips the segment, which is empty.
    pub(crate) fn passed(&mut self) {
        self.at += self.length;
        if self.at.is_multiple_of(2 * self.length) {
            self.length *= 2;
        }
    }

    /// Halves the segment, which no view proves empty. If its last point is empty in no view, `blocked` is Some, and true if
    /// marching ends at it.
    pub(crate) fn failed(&mut self, last: usize, blocked: Option<bool>) {
        if let Some(occupied) = blocked {
            self.blocked = Some((last, occupied));
        }
        if last > self.at {
            self.length /= 2;
        }
    }
}

/// Returns the index of the first step at which marching ends, the same as by testing every point.
///
/// Segments have 2ⁿ points and begin at a multiple of their length. A segment that no view proves empty is halved; after an empty
/// segment, the length is doubled if the next segment is aligned. The view of the last proof is tested first.
pub(crate) fn first_step(
    views: &ActiveViews<'_>,
    ray: &Ray,
    StepsFrom { steps, first }: StepsFrom<'_>,
    until: Until,
    counters: &mut Counters,
) -> Option<usize> {
    let distances_m = &steps.distances_m[..];
    let (origin, direction) = (ray.origin.abs().max_element(), ray.direction.abs().max_element());
    let (mut walk, mut favourite) = (Walk::new(first, distances_m.len()), 0);
    loop {
        let (from, to) = match walk.next(distances_m.len()) {
            Next::Test(from, to) => (from, to),
            Next::Hit(at) => return Some(at),
            Next::End => return None,
        };
        counters.march_steps += 1;
        let ends = [from, to].map(|at| ray.at(distances_m[at]));
        let reach_m = origin + direction * distances_m[to];
        let (mut sees_past, mut occupied) = (false, false);
        let all = 0..views.views.len();
        let order = all.clone().filter(|&view| view == favourite).chain(all.filter(|&view| view != favourite));
        let proves = |&at: &usize| {
            let view = &views.views[at];
            match view.occupancy(ends[1]) {
                Occupancy::Empty => {
                    sees_past = true;
                    from == to || is_segment_empty(view, ends, reach_m)
                }
                Occupancy::Occupied => {
                    occupied = true;
                    false
                }
                Occupancy::Unknown => false,
            }
        };
        match { order }.find(proves) {
            Some(view) => {
                favourite = view;
                walk.passed();
            }
            None => walk.failed(to, (!sees_past).then_some(occupied || until == Until::Unknown)),
        }
    }
}
