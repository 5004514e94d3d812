//! Cameras, frusta, and conservative intersection tests of frusta.
//!
//! In floating point, since nothing here decides the value of a decoded pixel, only whether it is decoded.

pub mod camera;
pub mod frustum;
pub mod random;
mod separation;
pub mod sight;
mod sums;

pub use camera::{Camera, Lens};
pub use frustum::{Frustum, Window};
pub use sight::{Sight, Viewer};
pub(crate) use sums::add_members;
