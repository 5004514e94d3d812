//! lightfold: a codec toolkit for animated light fields.
//!
//! `ARCHITECTURE.md` lists the modules and the direction of their imports; `formats/` defines every byte of a file.
//!
//! Opens a container and decodes a frame into a slice:
//!
//! ```
//! # fn main() -> lightfold::Result<()> {
//! # use lightfold::{Encoder, Face, ProbePose};
//! # let mut encoder = Encoder::new("film", 24.0);
//! # let probe = encoder.add_probe("00", ProbePose::default())?;
//! # let depth = encoder.add_depth(probe, Face::View, [8, 4])?;
//! # encoder.push_depth(depth, &[1.5; 32])?;
//! # let (file, _) = encoder.finish(Vec::new())?;
//! use lightfold::{Decoder, PixelsMut, StreamKind};
//!
//! let container = Decoder::from_memory(file)?; // or Decoder::open("film.lfold")
//! let stream = container.stream(StreamKind::Depth, "00", Face::View).unwrap();
//! let [width, height] = stream.size();
//! let mut metres = vec![0.0; width as usize * height as usize];
//! container.face(stream).decode_into(stream.frames.first, PixelsMut::DepthMetres(&mut metres))?;
//! assert_eq!(metres, [1.5; 32]);
//! # Ok(())
//! # }
//! ```
//!
//! Decodes from any source of byte ranges:
//!
//! ```
//! # fn main() -> lightfold::Result<()> {
//! # let mut encoder = lightfold::Encoder::new("film", 24.0);
//! # let probe = encoder.add_probe("00", Default::default())?;
//! # let depth = encoder.add_depth(probe, lightfold::Face::View, [8, 4])?;
//! # encoder.push_depth(depth, &[1.5; 32])?;
//! # let (object, _) = encoder.finish(Vec::new())?;
//! use std::io::{Error, ErrorKind, Result};
//!
//! use lightfold::{ByteSource, Decoder};
//!
//! /// An object of a store with range requests.
//! #[derive(Debug)]
//! struct Object(Vec<u8>);
//!
//! impl ByteSource for Object {
//!     fn byte_count(&self) -> Result<u64> {
//!         Ok(self.0.len() as u64)
//!     }
//!
//!     fn read_at(&self, offset: u64, bytes: &mut [u8]) -> Result<()> {
//!         let range = offset as usize..offset as usize + bytes.len();
//!         bytes.copy_from_slice(self.0.get(range).ok_or(Error::from(ErrorKind::UnexpectedEof))?);
//!         Ok(())
//!     }
//! }
//!
//! let container = Decoder::from_source(Object(object), "store/film.lfold")?;
//! assert_eq!(container.streams().len(), 1);
//! # Ok(())
//! # }
//! ```

// Items that only some features or tests use are not gated one by one.
#![cfg_attr(not(all(feature = "cli", feature = "internals")), allow(dead_code, unused_imports))]
// Tests write their inputs with `std::fs` (`clippy.toml`).
#![cfg_attr(test, allow(clippy::disallowed_methods))]
// Items of the hidden modules are documented only where the name is not enough.
#![cfg_attr(feature = "internals", allow(missing_docs))]

#[path = "."]
mod modules {
    #[cfg(feature = "render")]
    pub mod atlas;
    #[cfg(feature = "cli")]
    pub mod cli;
    #[cfg(feature = "encode")]
    pub mod compare;
    #[cfg(feature = "encode")]
    pub mod convention;
    #[cfg(feature = "encode")]
    pub mod dataset;
    #[cfg(feature = "encode")]
    pub mod depth_bound;
    #[cfg(feature = "encode")]
    pub mod encode;
    #[cfg(feature = "epipolar")]
    pub mod epipolar;
    #[cfg(feature = "render")]
    pub mod evaluate;
    #[cfg(feature = "encode")]
    pub mod export;
    #[cfg(feature = "encode")]
    pub mod files;
    #[cfg(feature = "encode")]
    pub mod fingerprint;
    #[cfg(feature = "gpu")]
    pub mod gpu;
    #[cfg(feature = "cli")]
    pub mod hard_cases;
    #[cfg(feature = "encode")]
    pub mod image_files;
    #[cfg(feature = "encode")]
    pub mod inspect;
    #[cfg(feature = "encode")]
    pub mod json;
    #[cfg(feature = "render")]
    pub mod march;
    #[cfg(feature = "scene")]
    pub mod mesh;
    #[cfg(feature = "encode")]
    pub mod metrics;
    #[cfg(feature = "encode")]
    pub mod pack;
    #[cfg(feature = "scene")]
    pub mod placement;
    #[cfg(feature = "cli")]
    pub mod report;
    #[cfg(feature = "scene")]
    pub mod scene;
    #[cfg(feature = "cli")]
    pub mod serve;
    #[cfg(feature = "simplify")]
    pub mod simplify;
    #[cfg(feature = "encode")]
    pub mod train;
    #[cfg(feature = "render")]
    pub mod views;
}

#[cfg(feature = "internals")]
#[doc(hidden)]
pub use modules::*;
#[cfg(not(feature = "internals"))]
use modules::*;

#[cfg(feature = "encode")]
pub use codec::color::Target;
#[cfg(feature = "encode")]
pub use codec::container::Compression;
pub use codec::container::{ByteSource, ProbeEntry};
pub use codec::decode::{DecodeCost, Decoder, FaceDecoder, PixelsMut, StreamInfo, UnitDecoder};
pub use codec::depth::DepthRange;
#[cfg(feature = "encode")]
pub use codec::depth::domain::DomainKind;
#[cfg(feature = "encode")]
pub use codec::depth::mode_decision::Decide;
#[cfg(feature = "encode")]
pub use codec::effort::Effort;
pub use codec::error::{Error, Result};
#[cfg(feature = "encode")]
pub use codec::image::Transfer;
pub use codec::image::{DepthKind, Face, FrameRange, Projection, StreamKind};
#[cfg(feature = "encode")]
pub use codec::monitor::Monitor;
pub use codec::streams::{ColorBlocks, ColorFormat};
pub use half::f16;
#[cfg(feature = "encode")]
pub use modules::dataset::{InvalidDepth, Pose, ProbeInfo, SourceGroup};
#[cfg(feature = "encode")]
pub use modules::encode::{
    ColorBlockSettings, ColorCodec, DepthCodec, DepthSettings, EncodeSettings, EncodeSummary, Encoder, EncoderStream,
    ErrorBound, FrameSource, MaterialSettings, ProbePose, TileSize,
};
#[cfg(feature = "encode")]
pub use modules::inspect::{Inspection, StreamStats, statistics};

#[cfg(feature = "cli")]
#[doc(hidden)]
pub use modules::cli::{freed_memory::restart_within_limit, run as run_command_line};
