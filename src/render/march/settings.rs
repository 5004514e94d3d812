//! Settings of ray marching.

use crate::march::{HOLE_DIFFERENCE, Steps};
use crate::rendered_image::{BackgroundFill, HoleFill};

/// Reflection and refraction by secondary rays (CALF 6.1).
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum SpecularMode {
    /// On if any material has a weight above 0; other images run no code for it.
    #[default]
    Auto,
    /// Off: colours of reflective and refractive surfaces are interpolated like others.
    None,
    /// On even if all weights are 0, for tests: the image is the same.
    Force,
}

/// Method of skipping points of a ray.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Acceleration {
    None,
    /// Skips segments that a view proves empty; the hits are the same.
    #[default]
    Pyramid,
}

/// Departures from algorithm 4 that improve image quality. Each takes time only in scenes that need it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Refinements {
    /// Weights views by the angle between their ray to a point and the eye's, and by their distance from the point, instead of by
    /// their distance from the eye.
    pub angles: bool,
    /// Extends a surface to any of the four texels around a point. Coverage is interpolated between texels, and the surfaces
    /// behind show through the rest.
    pub edges: bool,
    /// Shows a surface of the nearest view by the share of the views that have it, even if other views see past it.
    pub thin: bool,
}

impl Refinements {
    /// The algorithm of the paper.
    pub const NONE: Refinements = Refinements { angles: false, edges: false, thin: false };
    pub const ALL: Refinements = Refinements { angles: true, edges: true, thin: true };
}

impl Default for Refinements {
    fn default() -> Refinements {
        Refinements::ALL
    }
}

#[derive(Debug, Clone, PartialEq)]
pub struct RenderSettings {
    /// Width and height in pixels.
    pub size: [u32; 2],
    pub steps: Steps,
    /// Number of rays per row and column of a pixel with an edge, at least 1; see [`samples`](crate::march::samples).
    pub samples: u32,
    pub holes: HoleFill,
    pub background: BackgroundFill,
    pub specular: SpecularMode,
    /// Maximum number of reflections and refractions of a ray.
    pub max_bounces: u32,
    pub acceleration: Acceleration,
    pub refinements: Refinements,
}

impl RenderSettings {
    /// Returns the maximum difference between the log distances of a hit and of a texel that have the same surface.
    pub fn tolerance(&self) -> f32 {
        HOLE_DIFFERENCE + self.steps.uncertainty()
    }
}
