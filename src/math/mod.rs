//! Cameras, and the volumes that they and the pixels of a probe look into.
//!
//! Enters: positions in metres, angles in degrees. Leaves: frusta, and whether two of them have something in common,
//! where an answer of no is proved. Floating point: nothing here decides what a decoded pixel is, only whether it is
//! decoded.

pub mod camera;
pub mod frustum;
pub mod random;
mod separation;
pub mod sight;

pub use camera::{Camera, Lens};
pub use frustum::{Frustum, Window};
pub use sight::{Sight, Viewer};
