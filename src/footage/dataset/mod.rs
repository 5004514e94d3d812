//! Datasets: manifests, and readers that convert EXR or PNG sequences to planes of depth in metres and linear RGB; Seurat
//! captures, read as rays.

pub mod cameras;
pub mod discover;
pub mod manifest;
mod missing;
mod normals;
mod pixels;
pub mod seurat;
pub mod source;
mod timed;

pub use cameras::{CameraSet, PlacedCamera};
pub use codec::image::{DepthKind, Projection, StreamKind};
pub use manifest::{Manifest, Pose};
pub use missing::Missing;
pub use pixels::{DepthRules, InvalidColor, InvalidDepth, planar_to_distance};
pub use source::{Arrangement, ProbeInfo, SequenceLayout, Source, SourceGroup, SourceOptions};
