//! Settings of ray marching.

use crate::evaluate::{BackgroundFill, HoleFill};
use crate::march::{HOLE_DIFFERENCE, Steps};

/// Reflection and refraction by secondary rays (CALF 6.1).
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum SpecularMode {
    /// Where a material has a weight above 0; other pictures run no code for it.
    #[default]
    Auto,
    /// Never: views are interpolated everywhere.
    None,
    /// For tests, also where all weights are 0: the pictures are the same.
    Force,
}

/// How points of a ray are skipped.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Acceleration {
    None,
    /// Segments that a view proves empty are skipped; the hits are the same.
    #[default]
    Pyramid,
}

/// Departures from algorithm 4 that make better pictures. Each costs time where a scene calls for it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Refinements {
    /// Views have weights by the angle between their ray to a point and the eye's, and by their distance from the point, in place of
    /// their distance from the eye.
    pub angles: bool,
    /// A surface reaches as far as any of the four texels around a point. Coverage is interpolated between texels, and
    /// what is behind a surface shows through the rest.
    pub edges: bool,
    /// A surface of the nearest view shows by the share of the views that have it, though others see past it.
    pub thin: bool,
}

impl Refinements {
    /// The paper's algorithm.
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
    /// Rays in each row and column of a pixel with an edge, at least 1; see [`samples`](crate::march::samples).
    pub samples: u32,
    pub holes: HoleFill,
    pub background: BackgroundFill,
    pub specular: SpecularMode,
    /// Reflections and refractions of a ray at most.
    pub max_bounces: u32,
    pub acceleration: Acceleration,
    pub refinements: Refinements,
}

impl RenderSettings {
    /// A hit has a texel's surface where the logarithms of their distances differ by no more than this.
    pub fn tolerance(&self) -> f32 {
        HOLE_DIFFERENCE + self.steps.uncertainty()
    }
}
