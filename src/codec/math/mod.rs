//! Cameras, frusta, and conservative intersection tests of frusta.
//!
//! Uses floating point: the results decide only whether a pixel is decoded, not its value.

pub mod camera;
pub mod frustum;
pub mod random;
mod separation;
pub mod sight;

pub use crate::add_members;
pub use camera::{Camera, Lens};
pub use frustum::{Frustum, Window};
pub use sight::{Sight, Viewer};
