//! lightfold: a codec toolkit for animated light fields.
//!
//! The rooms and the direction in which they may import each other are in `ARCHITECTURE.md`; the
//! meaning of every byte is in `formats/`.

pub mod block;
pub mod cli;
pub mod color;
pub mod compare;
pub mod container;
pub mod convention;
pub mod dataset;
pub mod decode;
pub mod depth;
pub mod effort;
pub mod encode;
pub mod error;
pub mod evaluate;
pub mod files;
pub mod fingerprint;
pub mod gpu;
pub mod hard_cases;
pub mod image;
pub mod inspect;
pub mod march;
pub mod math;
pub mod memory;
pub mod mesh;
pub mod metrics;
pub mod monitor;
pub mod ordered;
pub mod pack;
pub mod placement;
pub mod report;
pub mod scene;
pub mod streams;
pub mod views;

pub use decode::{Decoder, FaceDecoder, PixelsMut, StreamInfo, UnitDecoder};
pub use encode::{EncodeSettings, EncodeSummary, Encoder, EncoderStream, FrameSource, ProbePose};
pub use error::{Error, Result};
pub use half::f16;
pub use image::{Face, FrameRange, StreamKind};
