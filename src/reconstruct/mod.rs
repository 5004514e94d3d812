//! What viewers see of a light field (CALF 6).
//!
//! Enters: an open container and cameras. Leaves: which tiles and cells the cameras see, so that only those are
//! decoded; the texels of what is shown (`player`, `light_field`); pictures from any eye (`render`: `march` says where a ray
//! ends, `interpolate` what colour is there, `effects` what mirrors and glass show there, by `material`, `normal`,
//! `solid`, and of balls of glass `glass_balls`, `surroundings` and `hidden_planes`).

pub mod active_views;
pub mod camera_file;
pub mod clip;
pub mod counters;
pub mod effects;
pub mod face_image;
pub mod glass_balls;
pub mod hidden_planes;
pub mod interpolate;
pub mod key_poses;
mod lanes;
pub mod light_field;
pub mod made;
pub mod march;
pub mod material;
pub mod methods;
pub mod normal;
pub mod pacing;
mod packet;
mod packet_color;
mod packet_march;
mod packet_render;
pub mod path;
pub mod performance;
pub mod playback;
pub mod player;
pub mod pyramid;
pub mod rects;
pub mod reference;
pub mod render;
pub mod rendered_image;
pub mod reproject;
pub mod seen_units;
pub mod selection;
pub mod shown_face;
pub mod similarity;
pub mod solid;
pub mod splat;
pub mod surroundings;
#[cfg(test)]
mod tests;
pub mod trace;
pub mod units_on_device;
pub mod visibility;
pub mod wanted;

pub use camera_file::{CameraFile, TimedCamera};
pub use face_image::{DepthSpan, FaceImage};
pub use seen_units::{SeenCounts, SeenUnits};
pub use visibility::{Culled, UnitGrid, cull, cull_all};
