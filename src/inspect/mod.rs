//! Measures a container: bytes, chunks, nodes and updated pixels by stream, unit and frame.

pub mod coding_map;
pub mod container;
mod counts;
