//! Counters of rendering.

/// Counts over rays: integers, so that sums do not depend on the number of threads.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, serde::Serialize)]
pub struct Counters {
    /// Rays from the eye.
    pub primary_rays: u64,
    /// Occupancy tests of points and segments, without refinement.
    pub march_steps: u64,
    /// Occupancy tests of bisection.
    pub refine_steps: u64,
    /// Reflected and refracted rays.
    pub secondary_rays: u64,
    /// Normals computed from depths or proxies.
    pub normal_evals: u64,
    /// Material lookups.
    pub material_samples: u64,
    /// Primary rays that end in a disocclusion.
    #[serde(skip)]
    pub hole_rays: u64,
    /// Primary rays that meet no surface.
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
