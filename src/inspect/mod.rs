//! Measures a container: bytes, chunks, nodes and updated pixels by stream, unit and frame.

#![doc(hidden)]

pub mod coding_map;
pub mod container;
mod counts;
pub mod report;
