//! Decodes any (stream, unit, frame) of a container, reading only the chunks that it needs.
//!
//! Input: an open container. Output: pixels of a unit ([`UnitDecoder`]) or of an image ([`FaceDecoder`]), in slices of the caller
//! ([`PixelsMut`]) or in files (`export` of the package `footage`).

mod cell;
mod chunk_source;
mod damage;
mod decoder;
mod face;
mod images;
pub mod memory;
mod pixels;
mod selection;
mod transform;
mod unit;
mod units;

pub use crate::streams::StreamInfo;
pub use chunk_source::DecodeCost;
pub use damage::{DamagedChunk, FrameRanges, MissingImages, OnDamage};
pub use decoder::Decoder;
pub use face::{AllUnits, FaceDecoder, Picture, UnitFilter};
pub use images::{ImageSource, Images, OnCpu};
pub use pixels::{PixelsMut, UnitPixels};
pub use selection::{Request, Selection, StreamFrames};
pub use unit::UnitDecoder;
pub use units::{
    DecodeSummary, Decoded, DecodedPart, check_windows, decode_units, decoded_pixel_bytes, jobs_at_once, min_bytes,
    stored_bytes,
};
