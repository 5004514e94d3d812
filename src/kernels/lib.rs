//! The kernel table, the layout of its buffers, and chunks in the form that kernels read. Needs no graphics device: the page's
//! decoder prepares chunks, too.

// Tests write their inputs with `std::fs` (`clippy.toml`).
#![cfg_attr(test, allow(clippy::disallowed_methods))]

pub mod layout;
pub mod pictures;
pub mod prepare;
mod table;
pub mod transform_tables;

pub use table::*;

/// Hash of the sources and shaders of this package.
pub const SOURCES: &str = env!("LIGHTFOLD_SOURCES");
