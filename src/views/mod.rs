//! Probe views: the texels and poses of a light field's faces, and which tiles and cells cameras see of them (CALF 6.2).

pub mod backend;
pub mod camera_units;
pub mod catalogue;
pub mod face_cache;
pub mod face_frustum;
pub mod from_images;
pub mod inverse_depth;
pub mod light_field;
pub mod player;
pub mod rects;
pub mod visibility;
pub mod visible_set;
