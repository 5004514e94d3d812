//! What viewers see of a light field (CALF 6).
//!
//! Enters: an open container and cameras. Leaves: which tiles and cells the cameras see, so that only those are
//! decoded.

pub mod camera_file;
pub mod face_image;
pub mod seen_units;
pub mod visibility;

pub use camera_file::{CameraFile, TimedCamera};
pub use face_image::{DepthSpan, FaceImage};
pub use seen_units::{SeenCounts, SeenUnits};
pub use visibility::{Culled, UnitGrid, cull, cull_all};
