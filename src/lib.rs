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
//! Encodes frames from memory:
//!
//! ```
//! # fn main() -> lightfold::Result<()> {
//! use lightfold::{Encoder, Face, ProbePose, f16};
//!
//! let mut encoder = Encoder::new("film", 24.0);
//! let probe = encoder.add_probe("00", ProbePose { position: [0.0, 1.5, 0.0], ..ProbePose::default() })?;
//! let depth = encoder.add_depth(probe, Face::Px, [16, 16])?;
//! let color = encoder.add_color(probe, Face::Px, [16, 16])?;
//! for frame in 0..3 {
//!     encoder.push_depth(depth, &[2.0 + frame as f32; 256])?;
//!     encoder.push_color(color, &[[f16::from_f32(0.5); 3]; 256])?;
//! }
//! let (file, summary) = encoder.finish(Vec::new())?;
//! assert_eq!((summary.streams, summary.frames), (2, 6));
//! assert_eq!(summary.bytes, file.len() as u64);
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

#![warn(missing_docs)]

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
#[cfg(feature = "encode")]
pub use footage::dataset::{InvalidDepth, Pose, ProbeInfo, SourceGroup};
#[cfg(feature = "encode")]
pub use footage::encode::{
    ColorBlockSettings, ColorCodec, DepthCodec, DepthSettings, EncodeSettings, EncodeSummary, Encoder, EncoderStream,
    ErrorBound, FrameSource, MaterialSettings, ProbePose, TileSize,
};
#[cfg(feature = "encode")]
pub use footage::inspect::{Inspection, StreamStats, statistics};
pub use half::f16;

#[cfg(feature = "cli")]
#[doc(hidden)]
pub use ::cli::{freed_memory::restart_within_limit, run as run_command_line};
