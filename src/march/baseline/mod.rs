//! Renderers that ray marching is compared with (CALF 7.3).

pub mod reproject;
pub mod splat;
