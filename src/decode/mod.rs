//! Decodes any (stream, unit, frame) of a container, reading only the chunks that it needs.

pub mod damage;
pub mod decoder;
pub mod export;
pub mod memory;
pub mod unit_filter;

pub use decoder::{Decoder, FaceDecoder, Picture, UnitDecoder};
pub use unit_filter::{AllUnits, UnitFilter};
