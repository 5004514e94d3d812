//! Coverage of a scene by cameras, measured independently of the objective that placed them.

use glam::{DMat3, DVec3};
use rayon::prelude::*;
use serde::Serialize;

use super::objective::{Lighting, Problem, VisibleSet};
use super::sequence;

/// Cameras up to this fraction of the viewer distance beyond the viewer distance count as within it: a quarter more metres are a
/// fifth less detail. Z is the exact distance from a surface to the region, so without a tolerance only a camera at the single
/// nearest position would count. Equation 2 has no tolerance.
pub const WITHIN: f64 = 0.25;
/// Number of directions of a hemisphere, one bit each.
const DIRECTIONS: usize = 64;

/// Coverage as fractions of all area and time, 0..=1 each.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Figures {
    /// Diffuse: fraction of the surface that is seen. Specular: fraction of directions above the surface within θ of a camera
    /// that sees it.
    pub coverage: f64,
    /// Fraction of the surface that any camera sees.
    pub seen: f64,
    /// Mean of the best suitability (CALF figure 3, left).
    pub weighted: f64,
    /// Fraction of the surface seen from within the viewer distance (CALF figure 3, right), with the tolerance
    /// [`WITHIN`].
    pub within: f64,
}

#[derive(Debug, Clone, Copy, Default)]
struct Covered {
    is_seen: bool,
    is_within: bool,
    best: f64,
    directions: u64,
}

/// Coverage of all surfels by the cameras so far.
#[derive(Debug, Clone)]
pub struct Coverage<'a> {
    problem: &'a Problem,
    lighting: Lighting,
    near_cosine: f64,
    tolerance_m: f64,
    directions: Vec<DVec3>,
    surfels: Vec<Covered>,
}

impl<'a> Coverage<'a> {
    /// Creates the coverage by no cameras. `tolerance_m` applies where it is more than [`WITHIN`] of the viewer distance.
    pub fn new(problem: &'a Problem, lighting: Lighting, tolerance_m: f64) -> Coverage<'a> {
        let directions = (0..DIRECTIONS).map(|at| sequence::on_hemisphere(at, DIRECTIONS)).collect();
        let surfels = vec![Covered::default(); problem.surfels.len()];
        Coverage { problem, lighting, near_cosine: lighting.near_cosine(), tolerance_m, directions, surfels }
    }

    pub fn add(&mut self, visible_sets: &[&VisibleSet]) {
        let (problem, near_cosine, directions) = (self.problem, self.near_cosine, &self.directions);
        let tolerance_m = self.tolerance_m;
        let of_specular = self.lighting != Lighting::Diffuse;
        self.surfels.par_iter_mut().enumerate().for_each(|(at, covered)| {
            let surfel = &problem.surfels[at];
            let (right, forward) = surfel.normal.any_orthonormal_pair();
            let to_world = DMat3::from_cols(right, surfel.normal, forward);
            let within_m = surfel.viewer_distance_m + tolerance_m.max(WITHIN * surfel.viewer_distance_m);
            for visible in visible_sets.iter().filter(|visible| visible.seen[at / 64] >> (at % 64) & 1 == 1) {
                covered.is_seen = true;
                covered.is_within |= visible.position.distance(surfel.point) <= within_m;
                covered.best = covered.best.max(problem.suitability(visible.position, at));
                if of_specular && covered.directions != u64::MAX {
                    let to_camera = to_world.transpose() * (visible.position - surfel.point).normalize_or_zero();
                    for (bit, direction) in directions.iter().enumerate() {
                        covered.directions |= u64::from(direction.dot(to_camera) > near_cosine) << bit;
                    }
                }
            }
        });
    }

    pub fn figures(&self) -> Figures {
        let sum = |part: fn(&Covered) -> f64| -> f64 {
            let pairs = self.problem.surfels.iter().zip(&self.surfels);
            pairs.map(|(surfel, covered)| surfel.weight * part(covered)).sum()
        };
        let share = |value: f64| value.min(1.0);
        let seen = share(sum(|covered| f64::from(u8::from(covered.is_seen))));
        let of_directions = share(sum(|covered| f64::from(covered.directions.count_ones()) / DIRECTIONS as f64));
        Figures {
            coverage: if self.lighting == Lighting::Diffuse { seen } else { of_directions },
            seen,
            weighted: share(sum(|covered| covered.best)),
            within: share(sum(|covered| f64::from(u8::from(covered.is_within)))),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::objective::Surfel;
    use super::*;

    fn problem() -> Problem {
        let surfel =
            |x: f64, weight: f64| Surfel { point: DVec3::X * x, normal: DVec3::Y, weight, viewer_distance_m: 1.5 };
        Problem::new(vec![surfel(0.0, 0.75), surfel(2.0, 0.25)], 1.0)
    }

    fn figures(lighting: Lighting, visible_sets: &[VisibleSet]) -> Figures {
        let problem = problem();
        let mut coverage = Coverage::new(&problem, lighting, 0.1);
        visible_sets.iter().for_each(|visible| coverage.add(&[visible]));
        coverage.figures()
    }

    #[test]
    fn seen_within_and_weighted() {
        let visible = VisibleSet { position: DVec3::Y, seen: vec![0b11] };
        let found = figures(Lighting::Diffuse, std::slice::from_ref(&visible));
        assert_eq!((found.coverage, found.seen, found.within), (1.0, 1.0, 0.75));
        assert!((found.weighted - (0.75 + 0.25 * (-(5f64.sqrt() - 1.5)).exp())).abs() < 1e-15);
        let half = figures(Lighting::Diffuse, &[VisibleSet { seen: vec![0b10], ..visible }]);
        assert_eq!((half.coverage, half.within), (0.25, 0.0));
        assert_eq!(figures(Lighting::Diffuse, &[]), Figures::default());
    }

    #[test]
    fn within_has_a_tolerance() {
        // A quarter of a viewer distance of 1.5 m is more than 0.1 m, and less than 1 m.
        let within = |distance: f64, tolerance_m: f64| {
            let problem = problem();
            let mut coverage = Coverage::new(&problem, Lighting::Diffuse, tolerance_m);
            coverage.add(&[&VisibleSet { position: DVec3::Y * distance, seen: vec![0b01] }]);
            coverage.figures().within
        };
        assert_eq!([1.5, 1.874, 1.876].map(|distance| within(distance, 0.1)), [0.75, 0.75, 0.0]);
        assert_eq!([2.499, 2.501].map(|distance| within(distance, 1.0)), [0.75, 0.0]);
    }

    #[test]
    fn a_camera_covers_the_cone_around_it() {
        let above = VisibleSet { position: DVec3::Y * 9.0, seen: vec![0b01] };
        let cover = |theta_deg: f64, visible_sets: &[VisibleSet]| {
            figures(Lighting::Specular { theta_deg }, visible_sets).coverage / 0.75
        };
        // A cap of 60 degrees around the normal is half of the hemisphere; one of 90 degrees is all of it.
        assert!((cover(60.0, std::slice::from_ref(&above)) - 0.5).abs() < 0.02);
        assert_eq!([0.0, 90.0, 180.0].map(|theta| cover(theta, std::slice::from_ref(&above))), [0.0, 1.0, 1.0]);
        let aside = VisibleSet { position: DVec3::new(9.0, 3.0, 0.0), seen: vec![0b01] };
        assert!(cover(60.0, &[above.clone(), aside]) > cover(60.0, &[above]) + 0.1);
    }
}
