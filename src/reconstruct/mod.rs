//! What viewers see of a light field (CALF 6).
//!
//! Enters: an open container and cameras. Leaves: which tiles and cells the cameras see, so that only those are
//! decoded; the texels of what is shown (`player`, `light_field`); pictures from any eye (`render`: `march` says where a ray
//! ends, `interpolate` what colour is there).

pub mod active_views;
#[cfg(test)]
mod agreement;
pub mod camera_file;
pub mod counters;
pub mod face_image;
pub mod interpolate;
mod lanes;
pub mod light_field;
pub mod made;
pub mod march;
mod packet;
mod packet_color;
mod packet_march;
mod packet_render;
pub mod player;
pub mod pyramid;
pub mod render;
pub mod seen_units;
pub mod visibility;

pub use camera_file::{CameraFile, TimedCamera};
pub use face_image::{DepthSpan, FaceImage};
pub use seen_units::{SeenCounts, SeenUnits};
pub use visibility::{Culled, UnitGrid, cull, cull_all};
