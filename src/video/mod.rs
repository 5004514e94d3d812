//! Joins codecs and container: encodes the streams of a dataset, decodes (probe, face, unit, frame), and measures.

pub mod anatomy;
pub mod codec;
pub mod compare;
pub mod comparison;
pub mod convert;
pub mod damage;
pub mod decode;
pub mod depth_chunk;
pub mod difference;
pub mod domain;
pub mod encode;
pub mod error_map;
pub mod export;
pub mod flatten;
pub mod footprint;
pub mod inspect;
pub mod material_chunk;
pub mod pack;
pub mod scan;
pub mod side;
pub mod stream_info;
pub mod tile_quality;
pub mod unit_filter;

pub use codec::{CodecHeader, ColorFormat, ColorHeader, DepthHeader, MaterialHeader};
pub use decode::{Decoder, FaceDecoder, Picture, UnitDecoder};
pub use encode::{EncodeSettings, EncodeSummary, encode};
pub use unit_filter::{AllUnits, UnitFilter};
