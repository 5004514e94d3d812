//! Settings of ray marching.

use crate::evaluate::HoleFill;
use crate::march::Steps;

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

#[derive(Debug, Clone, PartialEq)]
pub struct RenderSettings {
    /// Width and height in pixels.
    pub size: [u32; 2],
    pub steps: Steps,
    /// Rays in each row and column of a pixel, at least 1.
    pub samples: u32,
    pub holes: HoleFill,
    pub specular: SpecularMode,
    /// Reflections and refractions of a ray at most.
    pub max_bounces: u32,
    pub acceleration: Acceleration,
}
