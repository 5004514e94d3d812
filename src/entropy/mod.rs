//! Entropy coding with static distributions (color.md 7, depth.md 15): rANS over symbols of at most 16 values.
//!
//! Probabilities are not adapted while decoding, so that substreams are independent and a device decodes each in one lane.

#![doc(hidden)]

pub mod distribution;
pub mod family;
pub mod rans;
pub mod text_reader;

pub use distribution::{Distribution, SYMBOLS};
pub use family::Family;
pub use rans::Decoder;
#[cfg(feature = "encode")]
pub use rans::Encoder;
