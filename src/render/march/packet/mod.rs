//! SIMD form of ray marching: four rays at once.

pub mod color;
pub mod intersect;
pub mod lanes;
pub mod render;
pub mod views;
