//! Compares rendered pictures with the truth: reference cameras, camera files, picture files, similarity.

pub mod camera_file;
pub mod key_poses;
pub mod path;
pub mod reference;
pub mod rendered_image;
pub mod similarity;
