//! Compares rendered pictures with the truth: reference cameras, camera files, picture files, similarity.

pub mod camera_file;
pub mod camera_path;
pub mod frame_requests;
pub mod reference;
pub mod rendered_image;
pub mod similarity;
