//! Decoding on graphics devices, bit-exact with the CPU (GDC 5); rendering within a stated error bound (CALF 6, Seurat 6); and
//! winners of epipolar slices, bit-exact (Epipolar 3.3.2).
//!
//! Takes an open container; returns its pictures in the domain of their codecs, or rendered views of a light field. The kernels
//! are in `shaders/`, each a mirror of a file of `depth`, `color`, `march` or `epipolar`. The package `kernels` has the kernel table, and
//! `selftest` compares each kernel with its CPU counterpart.
//!
//! Decoding kernels have no floats, and the host parses and rejects files with the same code as for the CPU, so a device
//! accepts exactly the same files. Kernels use only the default features of WebGPU. Units never share a word, because two
//! invocations cannot safely write halves of the same word.

// Tests write their inputs with `std::fs` (`clippy.toml`).
#![cfg_attr(test, allow(clippy::disallowed_methods))]

pub mod decode;
pub mod device;
pub mod drawing;
pub mod epipolar;
pub mod family;
pub mod harness;
pub mod quads;
pub mod render;
pub mod resident;
pub mod selftest;
#[cfg(test)]
mod tests;
pub mod triangles;
pub mod verify;

pub use decode::GpuDecoder;
pub use device::Gpu;

/// Hash of the sources of this package.
pub const SOURCES: &str = env!("LIGHTFOLD_SOURCES");
