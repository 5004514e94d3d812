//! Entropy coding with static distributions (entropy.md): rANS with alphabets of at most 16 symbols.
//!
//! Distributions do not adapt during decoding, so that substreams are independent and a GPU decodes each in one lane.

pub mod distribution;
#[cfg(feature = "encode")]
pub mod prices;
pub mod rans;
#[cfg(feature = "encode")]
pub mod table_text;
pub mod tables;
pub mod text_reader;
#[cfg(feature = "encode")]
pub mod training;

pub use distribution::{Distribution, SYMBOLS};
#[cfg(feature = "encode")]
pub use prices::{Counts, PricedTables, Prices};
pub use rans::Decoder;
#[cfg(feature = "encode")]
pub use rans::Encoder;
pub use tables::{Family, Model, TableSet, Tables};
#[cfg(feature = "encode")]
pub use training::{PayloadCounts, Trainer};
