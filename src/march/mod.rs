//! Renders a light field from any eye by ray marching (CALF 6, algorithm 4).

pub mod active_views;
pub mod baseline;
pub mod clip;
pub mod counters;
pub mod interpolate;
pub mod intersect;
pub mod memory;
mod packet;
pub mod playback;
pub mod pyramid;
pub mod ray;
pub mod render;
pub mod segments;
pub mod settings;
pub mod shading;
pub mod specular;
pub mod synthetic;
#[cfg(test)]
mod tests;
