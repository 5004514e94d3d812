//! Encodes a dataset: reads frames, feeds the unit encoders, writes chunks.

#![doc(hidden)]

pub mod dataset;
mod fingerprint;
mod memory;
mod resume;
pub mod scan;
pub mod settings;
pub mod tile_quality;
mod unit;

pub use dataset::{EncodeSummary, encode};
pub use settings::EncodeSettings;
