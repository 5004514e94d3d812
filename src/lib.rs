//! lightfold: a codec toolkit for animated light fields.
//!
//! The rooms and the direction in which they may import each other are in `ARCHITECTURE.md`; the
//! meaning of every byte is in `formats/`.

pub mod block;
pub mod cli;
pub mod color;
pub mod container;
pub mod convention;
pub mod dataset;
pub mod depth;
pub mod effort;
pub mod error;
pub mod fingerprint;
pub mod gpu;
pub mod hard_cases;
pub mod image;
pub mod math;
pub mod memory;
pub mod metrics;
pub mod monitor;
pub mod ordered;
pub mod placement;
pub mod reconstruct;
pub mod report;
pub mod scene;
pub mod video;

pub use error::{Error, Result};
