//! Rays and the distances at which they are sampled (CALF 6, equation 13).
//!
//! The logarithms of the distances are evenly spaced from near to far, inclusive. A hit on the last step is a hit, whereas the
//! listing's test for `i = N` discards it.
//!
//! `libm` computes them to the same bits on all machines, so that the page renders the pictures of the program.

use glam::Vec3;

/// Length of an interval before the first step of a ray that starts on a surface, relative to its distance; the length is at
/// least one texel.
pub const GROWTH: f32 = 0.125;
/// Maximum number of intervals of relative length [`GROWTH`] before the first step: they reach about 6,000 texels far.
pub const MAX_BEFORE_STEPS: u32 = 64;

/// A ray in metres relative to the eye, in world axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ray {
    /// In metres.
    pub origin: Vec3,
    /// Unit direction.
    pub direction: Vec3,
}

impl Ray {
    pub fn at(&self, distance_m: f32) -> Vec3 {
        self.origin + self.direction * distance_m
    }
}

#[derive(Debug, Clone, PartialEq)]
pub struct Steps {
    /// Distances in metres, never decreasing; at least one.
    pub distances_m: Vec<f32>,
    refine: u32,
    log_step: f32,
    uncertainty: f32,
}

/// Steps from a first one on; earlier steps are skipped.
#[derive(Debug, Clone, Copy)]
pub struct StepsFrom<'s> {
    pub steps: &'s Steps,
    /// Index of the first step.
    pub first: usize,
}

/// Condition that ends marching along a ray.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Until {
    /// A point that is empty in no view and occupied in at least one.
    Surface,
    /// A point that is empty in no view, occupied or unknown.
    Unknown,
}

impl Steps {
    /// Divides the range from `near_m` to `far_m`, both above 0, into `count` steps (at least 1). If far is not beyond near, near
    /// is the only distance.
    pub fn new(count: u32, near_m: f32, far_m: f32, refine: u32) -> Steps {
        let (near, far) = (f64::from(near_m), f64::from(far_m));
        let distances_m = if far > near {
            let step = libm::log(far / near) / f64::from(count.max(1));
            (0..=count.max(1)).map(|at| (near * libm::exp(step * f64::from(at))) as f32).collect()
        } else {
            vec![near_m]
        };
        let log_step = match distances_m[..] {
            [first, second, ..] => libm::logf(second / first),
            _ => 0.0,
        };
        Steps { distances_m, refine: 0, log_step, uncertainty: 0.0 }.with_refine(refine)
    }

    /// Returns the same steps with another number of bisections.
    pub fn with_refine(&self, refine: u32) -> Steps {
        let left = -libm::expm1f(-self.log_step) * 0.5f32.powi(refine.min(64) as i32);
        Steps { refine, uncertainty: -libm::log1pf(-left), ..self.clone() }
    }

    /// Returns the number of bisections of the interval before a hit.
    pub fn refine(&self) -> u32 {
        self.refine
    }

    /// Returns the distances in metres for a ray that starts on a surface with texels `texel_m` wide, each with its step index if
    /// it is a step: finer distances before the first step, then all steps.
    pub fn off_surface(&self, texel_m: f32) -> impl Iterator<Item = (f32, Option<usize>)> + use<'_> {
        let first_m = self.distances_m[0];
        let next = move |at_m: &f32| Some(at_m + texel_m.max(GROWTH * at_m)).filter(|&at_m| at_m < first_m);
        let nearer = std::iter::successors(next(&0.0), next).take(MAX_BEFORE_STEPS as usize);
        nearer.map(|at_m| (at_m, None)).chain(self.distances_m.iter().enumerate().map(|(at, &at_m)| (at_m, Some(at))))
    }

    /// Returns the interval in metres that ends at a step.
    pub(crate) fn before(&self, step: usize) -> [f32; 2] {
        [step.checked_sub(1).map_or(0.0, |before| self.distances_m[before]), self.distances_m[step]]
    }

    /// Returns the logarithm of the ratio of adjacent distances; 0 if there is only one distance.
    pub fn log_step(&self) -> f32 {
        self.log_step
    }

    /// Returns the maximum distance of a hit behind the surface, as a difference of logarithms: the length of a bisected
    /// interval.
    pub fn uncertainty(&self) -> f32 {
        self.uncertainty
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_unsure_is_the_rest_of_the_interval() {
        for refine in 0..12 {
            let steps = Steps::new(16, 0.01, 10.0, refine);
            let [near_m, far_m] = [steps.distances_m[3], steps.distances_m[4]];
            let open_m = far_m - (far_m - near_m) / 2f32.powi(refine as i32);
            assert!((steps.uncertainty() - (far_m / open_m).ln()).abs() < 1e-5, "{refine}: {}", steps.uncertainty());
        }
        assert_eq!(Steps::new(16, 1.0, 1.0, 0).uncertainty(), 0.0);
        assert!(Steps::new(1, 1e-6, 1e6, u32::MAX).uncertainty() < 1e-6);
    }

    #[test]
    fn rays_from_surfaces_are_looked_at_before_the_steps() {
        let steps = Steps::new(8, 0.5, 4.0, 0);
        let all: Vec<_> = steps.off_surface(0.01).collect();
        assert_eq!(all[0], (0.01, None));
        let before = all.iter().filter(|(_, step)| step.is_none()).count();
        assert!((20..60).contains(&before), "{before}");
        assert!(all.windows(2).all(|pair| pair[0].0 < pair[1].0));
        let rest: Vec<_> =
            steps.distances_m.iter().enumerate().map(|(at, &distance_m)| (distance_m, Some(at))).collect();
        assert_eq!(all[before..], rest);
        assert_eq!(steps.off_surface(0.5).collect::<Vec<_>>(), rest);
        for hostile in [0.0, f32::NAN, f32::INFINITY, 1e-38] {
            assert!(steps.off_surface(hostile).count() <= rest.len() + MAX_BEFORE_STEPS as usize);
        }
    }
}
