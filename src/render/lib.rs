//! Views of light fields, and their rendering by ray marching (CALF 6). Takes texels of a decoder; reads no files.

// Tests write their inputs with `std::fs` (`clippy.toml`).
#![cfg_attr(test, allow(clippy::disallowed_methods))]

pub mod atlas;
pub mod camera_path;
pub mod frame_requests;
pub mod march;
pub mod rendered_image;
pub mod views;

/// Hash of the sources of this package.
pub const SOURCES: &str = env!("LIGHTFOLD_SOURCES");
