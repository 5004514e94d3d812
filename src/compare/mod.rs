//! Compares containers, datasets and image sequences stream by stream.

#![doc(hidden)]

pub mod bounds;
pub mod comparison;
pub mod difference;
pub mod domain;
pub mod error_map;
pub mod report;
pub mod side;
pub mod streams;
