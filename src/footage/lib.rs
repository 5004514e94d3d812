//! Image files and datasets of light fields, their encoding, comparison and statistics.
//!
//! No stability is promised: use `lightfold`.

// Tests write their inputs with `std::fs` (`clippy.toml`).
#![cfg_attr(test, allow(clippy::disallowed_methods))]

pub mod account;
pub mod compare;
pub mod convention;
pub mod dataset;
pub mod depth_bound;
pub mod encode;
pub mod export;
pub mod files;
pub mod fingerprint;
pub mod guard;
pub mod image_files;
pub mod inspect;
pub mod json;
pub mod metrics;
pub mod pack;
pub mod text;
pub mod train;

/// Hash of the sources of this package.
pub const SOURCES: &str = env!("LIGHTFOLD_SOURCES");
