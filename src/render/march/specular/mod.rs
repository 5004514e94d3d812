//! Reflection and refraction (CALF 6.1).

pub mod material;
pub mod normal;
pub mod proxy;
pub mod secondary_rays;
pub mod solid;
pub mod sphere;
pub mod sphere_fit;
