//! Image files: EXR, PNG, KTX2, quilts, picture streams, lookup tables.

pub mod color_space;
pub mod exr;
pub mod ktx2;
pub mod lookup_table;
pub mod picture_stream;
pub mod png;
pub mod quilt;

pub use color_space::ColorSpace;
