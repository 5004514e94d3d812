//! Decoding on graphics devices, bit for bit what the CPU decodes (GDC 5), and rendering as the CPU does it (CALF 6).
//!
//! Enters: an open container. Leaves: its pictures, in the domain of their codecs; of a light field and a camera, what the
//! camera sees. The kernels are in `shaders/`, each a mirror of a file of `depth`, `color` or `reconstruct`; `kernels` is
//! their table and `selftest` runs each against its mirror.

pub mod decode;
pub mod device;
pub mod family;
pub mod harness;
pub mod kernels;
pub mod layout;
pub mod pictures;
pub mod prepare;
pub mod random;
pub mod render;
pub mod resident;
pub mod selftest;
pub mod verify;

pub use decode::GpuDecoder;
pub use device::{DeviceChoice, DeviceInfo, Gpu, Pick};
pub use render::GpuRenderer;
pub use render::playback::DeviceRenderer;
