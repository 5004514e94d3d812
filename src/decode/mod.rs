//! Decodes any (stream, unit, frame) of a container, reading only the chunks that it needs.
//!
//! Input: an open container. Output: pixels of a unit ([`UnitDecoder`]) or of an image ([`FaceDecoder`]), in slices of the caller
//! ([`PixelsMut`]) or in files ([`decode_to_files`]).

#![doc(hidden)]

mod cell;
mod chunk_source;
mod damage;
mod decoder;
mod face;
#[cfg(feature = "encode")]
mod files;
#[cfg(feature = "encode")]
mod image_writer;
mod images;
#[cfg(feature = "encode")]
mod manifest;
pub(crate) mod memory;
mod pixels;
#[cfg(feature = "encode")]
mod report;
mod selection;
mod transform;
mod unit;
mod unit_filter;
mod units;
mod window;

pub use crate::streams::StreamInfo;
pub use chunk_source::DecodeCost;
pub use damage::{DamagedChunk, FrameRanges, MissingImages, OnDamage};
pub use decoder::Decoder;
pub use face::{FaceDecoder, Picture};
#[cfg(feature = "encode")]
pub use files::{Destination, decode_to_files, decode_to_stream, file_sequences};
pub use images::{ImageSource, Images, OnCpu};
#[cfg(feature = "encode")]
pub use manifest::{FileCoding, FileFormat, has_decoded};
pub use pixels::{PixelsMut, UnitPixels};
#[cfg(feature = "encode")]
pub use report::{DamagedChunkReport, DecodeReport, DecodeTimes};
pub use selection::{Request, Selection, StreamFrames};
pub use unit::UnitDecoder;
pub use unit_filter::{AllUnits, UnitFilter};
pub use units::{DecodeSummary, Decoded, decode_units, decoded_pixel_bytes, least_bytes, stored_bytes};
pub use window::check_windows;
