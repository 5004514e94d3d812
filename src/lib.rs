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
