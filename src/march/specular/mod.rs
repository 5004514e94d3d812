//! Reflection and refraction (CALF 6.1).

pub mod environment;
pub mod material;
pub mod normal;
pub mod plane_extrapolation;
pub mod secondary_rays;
pub mod solid;
pub mod sphere_fit;
