//! Compares rendered images with reference images, independently of the renderer: cameras, rendered images, similarity. Also
//! camera files and point clouds.

// Tests write their inputs with `std::fs` (`clippy.toml`).
#![cfg_attr(test, allow(clippy::disallowed_methods))]

pub mod camera_file;
pub mod cameras;
pub mod dataset_views;
pub mod decoded_images;
pub mod point_cloud;
pub mod reference;
pub mod similarity;

/// Hash of the sources of this package.
pub const SOURCES: &str = env!("LIGHTFOLD_SOURCES");
