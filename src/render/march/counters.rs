//! Rendering counters.

use codec::math::add_members;

/// Counts over rays. They are integers, so that sums do not depend on the number of threads.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, serde::Serialize)]
pub struct Counters {
    pub primary_rays: u64,
    /// Occupancy tests of points and segments during marching, without refinement.
    pub march_steps: u64,
    /// Occupancy tests during bisection.
    pub refine_steps: u64,
    /// Reflected and refracted rays.
    pub secondary_rays: u64,
    pub normal_evals: u64,
    pub material_samples: u64,
    /// Primary rays that end in a disocclusion.
    #[serde(skip)]
    pub hole_rays: u64,
    /// Primary rays that meet no surface.
    pub background_rays: u64,
}

add_members!(Counters:
    primary_rays, march_steps, refine_steps, secondary_rays, normal_evals, material_samples, hole_rays, background_rays
);
