//! Compares rendered images with reference images, independently of the renderer: cameras, rendered images, similarity. Also
//! camera files and point clouds.

pub mod camera_file;
pub mod camera_path;
#[cfg(feature = "scene")]
pub mod cameras;
pub mod decoded_images;
pub mod frame_requests;
pub mod point_cloud;
pub mod reference;
pub mod rendered_image;
pub mod similarity;

pub use camera_path::TimedCamera;
pub use rendered_image::{Aov, BackgroundFill, HoleFill, RenderedImage};
