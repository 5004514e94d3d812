//! glTF 2.0 files: checked reading of documents, data, materials and primitives; writing of meshes.

pub mod buffers;
pub mod document;
pub mod materials;
pub mod nodes;
pub mod primitives;
mod textures;
// No command writes meshes yet; tests do.
#[cfg_attr(not(feature = "internals"), allow(dead_code))]
pub mod write;
