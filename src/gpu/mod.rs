//! Decoding on graphics devices, equal to the CPU's in every bit (GDC 5), and rendering within a stated bound (CALF 6,
//! Seurat 6); winners of epipolar slices, in every bit (Epipolar 3.3.2).
//!
//! Enters: an open container. Leaves: its pictures, in the domain of their codecs; rendered views of a light field. The kernels
//! are in `shaders/`, each a mirror of a file of `depth`, `color`, `march` or `epipolar`; `kernels` is their table, and `selftest` runs each
//! against its mirror.
//!
//! Decoding kernels have no floats, and the host parses and refuses as it does for the CPU, so that a device is not another
//! decoder. Kernels use only what WebGPU has by default. Units never share a word, as two invocations cannot safely write halves
//! of one.

pub mod decode;
pub mod device;
#[cfg(any(feature = "epipolar", feature = "simplify"))]
pub mod drawing;
#[cfg(feature = "epipolar")]
pub mod epipolar;
pub mod family;
pub mod harness;
pub mod kernels;
pub mod layout;
pub mod pictures;
pub mod prepare;
#[cfg(feature = "simplify")]
pub mod quads;
pub mod render;
pub mod resident;
#[cfg(feature = "scene")]
pub mod selftest;
pub mod transform_tables;
#[cfg(feature = "epipolar")]
pub mod triangles;
pub mod verify;

pub use decode::GpuDecoder;
pub use device::Gpu;
