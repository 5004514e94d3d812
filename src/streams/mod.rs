//! Typed streams of a container: codec headers, checked chunks, and conversion between metres, light and codes.

pub mod convert;
pub mod depth_chunk;
pub mod header;
pub mod info;
pub mod material_chunk;
