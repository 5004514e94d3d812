//! Settings of ray marching.

use crate::evaluate::rendered_image::HoleFill;
use crate::march::ray::Steps;

/// Whether rays are sent on by mirrors and glass (CALF 6.1).
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum EffectMode {
    /// Where the light field has materials with weights above 0; else no code for it is in the way.
    #[default]
    Auto,
    /// Never: views are interpolated everywhere.
    None,
    /// Also where no weight of the materials is above 0, for tests: the pictures are the same.
    Force,
}

/// How points of a ray are passed over.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Acceleration {
    /// Every point is looked at.
    None,
    /// Segments that a view proves to be empty are passed over; the hits are the same.
    #[default]
    Pyramid,
}

/// How a picture is made.
#[derive(Debug, Clone, PartialEq)]
pub struct RenderSettings {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Where rays are looked at.
    pub steps: Steps,
    /// Rays in each row and column of a pixel, at least 1.
    pub samples: u32,
    /// What is shown in holes.
    pub holes: HoleFill,
    /// Whether mirrors and glass send rays on.
    pub effects: EffectMode,
    /// How often at most a ray is sent on.
    pub max_bounces: u32,
    /// How rays are marched.
    pub acceleration: Acceleration,
}
