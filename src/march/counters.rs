//! What rendering came to: how often each thing was done.

/// Counts over rays. Sums of whole numbers, so that they do not depend on the number of threads.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Counters {
    /// Rays from the eye.
    pub primary_rays: u64,
    /// Points, and segments of several, at which it was asked whether a ray is in the open; refinement is not in it.
    pub march_steps: u64,
    /// Points that were looked at to find hits more exactly.
    pub refine_steps: u64,
    /// Rays that a mirror or glass sent on.
    pub secondary_rays: u64,
    /// Normals that were computed from depths.
    pub normal_evals: u64,
    /// Materials that were looked up.
    pub material_samples: u64,
    /// Rays from the eye that end where no view saw anything.
    pub hole_rays: u64,
    /// Rays from the eye that meet no surface.
    pub background_rays: u64,
}

impl Counters {
    /// The sum of two.
    #[must_use]
    pub fn plus(self, other: Counters) -> Counters {
        Counters {
            primary_rays: self.primary_rays + other.primary_rays,
            march_steps: self.march_steps + other.march_steps,
            refine_steps: self.refine_steps + other.refine_steps,
            secondary_rays: self.secondary_rays + other.secondary_rays,
            normal_evals: self.normal_evals + other.normal_evals,
            material_samples: self.material_samples + other.material_samples,
            hole_rays: self.hole_rays + other.hole_rays,
            background_rays: self.background_rays + other.background_rays,
        }
    }
}
