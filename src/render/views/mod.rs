//! Probe views: texels and poses of a light field's faces, and the tiles and cells of them that cameras see (CALF 6.2).

pub mod backend;
pub mod camera_units;
pub mod catalogue;
pub mod face_cache;
pub mod face_frustum;
pub mod from_images;
pub mod head_box;
pub mod inverse_depth;
pub mod light_field;
pub mod player;
pub mod rects;
pub mod start_view;
pub mod straight;
pub mod visibility;
pub mod visible_set;

pub use backend::{CpuBackend, FaceUpdate, NewFace, TexelBackend};
pub use catalogue::ProbeChoice;
pub use face_cache::{CachedUnit, DepthPart, FaceCache, FaceChanges, FaceStreams, decode_on_cpu};
pub use face_frustum::{DepthSpan, FaceImage};
pub use inverse_depth::InverseDepth;
pub(crate) use light_field::has_specular_weight;
pub use light_field::{BACKGROUND, ColorCoding, ColorTexels, FaceTexels, LightField, Projected, UNKNOWN, View};
pub use player::Change;
pub use rects::{Rect, bounds, overlap};
pub use start_view::start_view;
pub(crate) use straight::straight;
pub use straight::{StraightCodes, finite_half, straight_half};
pub use visibility::{UnitGrid, cull};
pub use visible_set::visible_units;
