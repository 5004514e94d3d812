//! Seurat captures: the JSON manifest, its cameras, and the rays of their images (formats/manifest.md 5).

mod camera;
mod json;
mod manifest;
mod view;

pub use camera::{CameraMatrices, DepthType, PixelRay, SeuratCamera};
pub use manifest::{SeuratCapture, is_manifest};
pub use view::{CaptureRay, SeuratView, ViewImage};
