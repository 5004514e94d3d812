//! Probe views: the texels and poses of a light field's faces, and which tiles and cells cameras see of them (CALF 6.2).

pub mod face_cache;
pub mod face_frustum;
pub mod light_field;
pub mod player;
pub mod rects;
pub mod seen_units;
pub mod units_on_device;
pub mod visibility;
pub mod visible_set;
