//! Where a ray meets a surface: RayIntersection of algorithm 4 (CALF 6), in its plain form.
//!
//! Enters: active views and a ray. Leaves: the distance at which it first meets a surface, or that it meets none.
//!
//! Points along the ray are in constant steps of the logarithm of the distance (equation 13), from near to far, both
//! included: a hit on the last step is a hit, where the listing's test for `i = N` throws it away.

use glam::Vec3;

use crate::reconstruct::active_views::ActiveViews;
use crate::reconstruct::counters::Counters;

/// A ray in metres from the eye, along the world's axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ray {
    /// Where it starts.
    pub origin: Vec3,
    /// Where it goes, of length 1.
    pub direction: Vec3,
}

impl Ray {
    /// The point at a distance.
    pub fn at(&self, distance_m: f32) -> Vec3 {
        self.origin + self.direction * distance_m
    }
}

/// The distances at which a ray is looked at.
#[derive(Debug, Clone, PartialEq)]
pub struct Steps {
    /// Metres, never falling; at least one.
    pub distances_m: Vec<f32>,
    /// How often the interval before a hit is halved.
    pub refine: u32,
}

impl Steps {
    /// `count` steps (at least 1) between `near_m` and `far_m`, both above 0; where far is not beyond near, near alone.
    pub fn new(count: u32, near_m: f32, far_m: f32, refine: u32) -> Steps {
        let (near, far) = (f64::from(near_m), f64::from(far_m));
        let distances_m = if far > near {
            let step = (far / near).ln() / f64::from(count.max(1));
            (0..=count.max(1)).map(|at| (near * (step * f64::from(at)).exp()) as f32).collect()
        } else {
            vec![near_m]
        };
        Steps { distances_m, refine }
    }

    /// The logarithm of the ratio of two neighbouring distances; 0 where there is only one.
    pub fn log_step(&self) -> f32 {
        match self.distances_m[..] {
            [first, second, ..] => (second / first).ln(),
            _ => 0.0,
        }
    }
}

impl Steps {
    /// How far, in the logarithm of the distance, a hit may be from its surface: a step where hits are not refined.
    pub fn unsure(&self) -> f32 {
        if self.refine == 0 { self.log_step() } else { 0.0 }
    }
}

/// The distance in metres at which a ray meets a surface, if it does: every point is looked at.
pub fn intersect(views: &ActiveViews<'_>, ray: &Ray, steps: &Steps, counters: &mut Counters) -> Option<f32> {
    let mut before_m = 0.0;
    for &distance_m in &steps.distances_m {
        counters.march_steps += 1;
        if views.is_surface(ray.at(distance_m)) {
            return Some(refine(views, ray, [before_m, distance_m], steps.refine, counters));
        }
        before_m = distance_m;
    }
    None
}

/// Halves the interval in which a surface begins; answers its end that is in the surface.
pub fn refine(views: &ActiveViews<'_>, ray: &Ray, interval_m: [f32; 2], times: u32, counters: &mut Counters) -> f32 {
    let [mut open_m, mut surface_m] = interval_m;
    for _ in 0..times {
        let middle_m = 0.5 * (open_m + surface_m);
        counters.refine_steps += 1;
        if views.is_surface(ray.at(middle_m)) {
            surface_m = middle_m;
        } else {
            open_m = middle_m;
        }
    }
    surface_m
}
