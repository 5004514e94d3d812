//! Four rays at once: the SIMD form of the march.

pub mod color;
pub mod intersect;
pub mod lanes;
pub mod render;
pub mod views;
