//! lightfold: a codec toolkit for animated light fields.
//!
//! `ARCHITECTURE.md` lists the modules and the direction of their imports; `formats/` defines every byte of a file.

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
    pub mod block;
    #[cfg(feature = "cli")]
    pub mod cli;
    pub mod color;
    #[cfg(feature = "encode")]
    pub mod compare;
    pub mod container;
    #[cfg(feature = "encode")]
    pub mod convention;
    #[cfg(feature = "encode")]
    pub mod dataset;
    pub mod decode;
    pub mod depth;
    pub mod effort;
    #[cfg(feature = "encode")]
    pub mod encode;
    pub mod entropy;
    #[cfg(feature = "epipolar")]
    pub mod epipolar;
    pub mod error;
    #[cfg(feature = "render")]
    pub mod evaluate;
    #[cfg(feature = "encode")]
    pub mod files;
    #[cfg(feature = "encode")]
    pub mod fingerprint;
    #[cfg(feature = "gpu")]
    pub mod gpu;
    #[cfg(feature = "cli")]
    pub mod hard_cases;
    pub mod image;
    #[cfg(feature = "encode")]
    pub mod inspect;
    #[cfg(feature = "encode")]
    pub mod json;
    #[cfg(feature = "render")]
    pub mod march;
    pub mod math;
    pub mod memory;
    #[cfg(feature = "scene")]
    pub mod mesh;
    pub mod metrics;
    pub mod monitor;
    pub mod ordered;
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
    pub mod streams;
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

pub use half::f16;
#[cfg(feature = "encode")]
pub use modules::color::Target;
#[cfg(feature = "encode")]
pub use modules::container::Compression;
pub use modules::container::{ByteSource, ProbeEntry};
#[cfg(feature = "encode")]
pub use modules::dataset::{InvalidDepth, Pose, ProbeInfo, SourceGroup};
pub use modules::decode::{DecodeCost, Decoder, FaceDecoder, PixelsMut, StreamInfo, UnitDecoder};
pub use modules::depth::DepthRange;
#[cfg(feature = "encode")]
pub use modules::depth::domain::DomainKind;
#[cfg(feature = "encode")]
pub use modules::depth::mode_decision::Decide;
#[cfg(feature = "encode")]
pub use modules::effort::Effort;
#[cfg(feature = "encode")]
pub use modules::encode::{
    ColorBlockSettings, ColorCodec, DepthCodec, DepthSettings, EncodeSettings, EncodeSummary, Encoder, EncoderStream,
    ErrorBound, FrameSource, MaterialSettings, ProbePose, TileSize,
};
pub use modules::error::{Error, Result};
#[cfg(feature = "encode")]
pub use modules::image::Transfer;
pub use modules::image::{DepthKind, Face, FrameRange, Projection, StreamKind};
#[cfg(feature = "encode")]
pub use modules::inspect::{Inspection, StreamStats, statistics};
#[cfg(feature = "encode")]
pub use modules::monitor::Monitor;
pub use modules::streams::{ColorBlocks, ColorFormat};

#[cfg(feature = "cli")]
#[doc(hidden)]
pub use modules::cli::{freed_memory::restart_within_limit, run as run_command_line};
