//! glTF 2.0 files: reads documents, buffers, materials and primitives with checks; writes meshes.

pub mod buffers;
pub mod document;
pub mod materials;
pub mod nodes;
pub mod primitives;
mod textures;
pub mod write;
