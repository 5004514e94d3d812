//! Captures scenes as cube maps, panoramas and perspective images, and writes them as datasets.

pub mod images;
pub mod pixels;
pub mod plan;
pub mod reference;
pub mod samples;
#[cfg(test)]
pub(crate) mod tests;
pub mod view;
pub mod write;

pub use images::Images;
pub use pixels::{PixelTracer, Viewpoint, halves, mean_light};
pub use plan::{CapturePlan, FrameRequest, frames_of_animation};
pub use reference::Reference;
pub use samples::{MAX_SAMPLES, SamplePattern};
pub use view::{MAX_FACE_SIZE, Pass, PassSettings, capture_view};
pub use write::{CaptureReport, CaptureSummary};

/// Default number of colour samples per pixel.
pub const COLOR_SAMPLES: u32 = 16;
