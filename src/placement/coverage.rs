//! What cameras cover, apart from the objective that placed them.
//!
//! Enters: cameras, one after the other. Leaves: [`Figures`], each a part of all area and time of the facets.

use glam::{DMat3, DVec3};
use rayon::prelude::*;
use serde::Serialize;

use super::objective::{Lighting, Problem, View};
use super::sequence;

/// How far beyond the viewer distance a camera still counts as within it, as a part of that distance: a quarter more metres are
/// a fifth less detail. Equation 2 has no such tolerance; without one, only a camera at the one place of the region that is
/// nearest to a surface would count.
pub const WITHIN: f64 = 0.25;
/// Directions of a half sphere, each a bit.
const DIRECTIONS: usize = 64;

/// What cameras cover, 0..=1 each.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Figures {
    /// Diffuse: the part of the surface that is seen. Specular: the part of all directions above it in which a camera sees it, or
    /// one less than θ away.
    pub coverage: f64,
    /// The part of the surface that is seen by any camera.
    pub seen: f64,
    /// The same with what lies beyond the viewer distance fading (CALF figure 3, left): the mean of the best suitability.
    pub weighted: f64,
    /// The part of the surface that is seen from within the viewer distance (CALF figure 3, right), by the tolerance of [`WITHIN`].
    pub within: f64,
}

/// What is known of a facet.
#[derive(Debug, Clone, Copy, Default)]
struct Covered {
    is_seen: bool,
    is_within: bool,
    best: f64,
    directions: u64,
}

/// Keeps account of what cameras cover.
#[derive(Debug, Clone)]
pub struct Coverage<'a> {
    problem: &'a Problem,
    lighting: Lighting,
    near_cosine: f64,
    tolerance_m: f64,
    directions: Vec<DVec3>,
    facets: Vec<Covered>,
}

impl<'a> Coverage<'a> {
    /// Nothing is covered. A camera so many metres beyond the viewer distance is still within it, or [`WITHIN`] of that distance
    /// where this is more.
    pub fn new(problem: &'a Problem, lighting: Lighting, tolerance_m: f64) -> Coverage<'a> {
        let directions = (0..DIRECTIONS).map(|at| sequence::on_hemisphere(at, DIRECTIONS)).collect();
        let facets = vec![Covered::default(); problem.facets().len()];
        Coverage { problem, lighting, near_cosine: lighting.near_cosine(), tolerance_m, directions, facets }
    }

    /// Adds what cameras see.
    pub fn add(&mut self, views: &[&View]) {
        let (problem, near_cosine, directions) = (self.problem, self.near_cosine, &self.directions);
        let tolerance_m = self.tolerance_m;
        let of_specular = self.lighting != Lighting::Diffuse;
        self.facets.par_iter_mut().enumerate().for_each(|(at, covered)| {
            let facet = &problem.facets()[at];
            let (right, forward) = facet.normal.any_orthonormal_pair();
            let to_world = DMat3::from_cols(right, facet.normal, forward);
            let within_m = facet.viewer_distance_m + tolerance_m.max(WITHIN * facet.viewer_distance_m);
            for view in views.iter().filter(|view| view.seen[at / 64] >> (at % 64) & 1 == 1) {
                covered.is_seen = true;
                covered.is_within |= view.position.distance(facet.point) <= within_m;
                covered.best = covered.best.max(problem.suitability(view.position, at));
                if of_specular && covered.directions != u64::MAX {
                    let to_camera = to_world.transpose() * (view.position - facet.point).normalize_or_zero();
                    for (bit, direction) in directions.iter().enumerate() {
                        covered.directions |= u64::from(direction.dot(to_camera) > near_cosine) << bit;
                    }
                }
            }
        });
    }

    /// What is covered now.
    pub fn figures(&self) -> Figures {
        let sum = |part: fn(&Covered) -> f64| -> f64 {
            self.problem.facets().iter().zip(&self.facets).map(|(facet, covered)| facet.weight * part(covered)).sum()
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
    use super::super::objective::Facet;
    use super::*;

    fn problem() -> Problem {
        let facet =
            |x: f64, weight: f64| Facet { point: DVec3::X * x, normal: DVec3::Y, weight, viewer_distance_m: 1.5 };
        Problem::new(vec![facet(0.0, 0.75), facet(2.0, 0.25)], 1.0)
    }

    fn figures(lighting: Lighting, views: &[View]) -> Figures {
        let problem = problem();
        let mut coverage = Coverage::new(&problem, lighting, 0.1);
        views.iter().for_each(|view| coverage.add(&[view]));
        coverage.figures()
    }

    #[test]
    fn seen_within_and_weighted() {
        let view = View { position: DVec3::Y, seen: vec![0b11] };
        let found = figures(Lighting::Diffuse, std::slice::from_ref(&view));
        assert_eq!((found.coverage, found.seen, found.within), (1.0, 1.0, 0.75));
        assert!((found.weighted - (0.75 + 0.25 * (-(5f64.sqrt() - 1.5)).exp())).abs() < 1e-15);
        let half = figures(Lighting::Diffuse, &[View { seen: vec![0b10], ..view }]);
        assert_eq!((half.coverage, half.within), (0.25, 0.0));
        assert_eq!(figures(Lighting::Diffuse, &[]), Figures::default());
    }

    #[test]
    fn within_has_a_tolerance() {
        // Of a viewer distance of 1.5 m a quarter is more than 0.1 m, and less than 1 m.
        let within = |distance: f64, tolerance_m: f64| {
            let problem = problem();
            let mut coverage = Coverage::new(&problem, Lighting::Diffuse, tolerance_m);
            coverage.add(&[&View { position: DVec3::Y * distance, seen: vec![0b01] }]);
            coverage.figures().within
        };
        assert_eq!([1.5, 1.874, 1.876].map(|distance| within(distance, 0.1)), [0.75, 0.75, 0.0]);
        assert_eq!([2.499, 2.501].map(|distance| within(distance, 1.0)), [0.75, 0.0]);
    }

    #[test]
    fn a_camera_covers_the_cone_around_it() {
        let above = View { position: DVec3::Y * 9.0, seen: vec![0b01] };
        let cover = |theta_deg: f64, views: &[View]| figures(Lighting::Specular { theta_deg }, views).coverage / 0.75;
        // A cap of 60 degrees around the normal is half of the half sphere, one of 90 degrees all of it.
        assert!((cover(60.0, std::slice::from_ref(&above)) - 0.5).abs() < 0.02);
        assert_eq!([0.0, 90.0, 180.0].map(|theta| cover(theta, std::slice::from_ref(&above))), [0.0, 1.0, 1.0]);
        let aside = View { position: DVec3::new(9.0, 3.0, 0.0), seen: vec![0b01] };
        assert!(cover(60.0, &[above.clone(), aside]) > cover(60.0, &[above]) + 0.1);
    }
}
