//! Compares rendered pictures with reference images, for every renderer: cameras, rendered images, similarity.

pub mod camera_file;
pub mod camera_path;
pub mod decoded_images;
pub mod frame_requests;
pub mod reference;
pub mod rendered_image;
pub mod similarity;

pub use camera_path::TimedCamera;
pub use rendered_image::{Aov, BackgroundFill, HoleFill, RenderedImage};
