//! Baseline renderers for comparison with ray marching (CALF 7.3).

pub mod reproject;
pub mod splat;
