//! What `render` draws: a light field or a simplified scene.

use super::options::Method;
use super::pictures::Job;
use super::report::Figures;
use super::truth::TruthRun;
use crate::cli::GlobalArgs;
use crate::error::Result;
use crate::evaluate::rendered_image::RenderedImage;
use crate::gpu::Gpu;
use crate::image::transfer::ToneMap;
use crate::image::{FrameRange, Plane};
use crate::march::playback::trace::FrameTrace;
use crate::math::Camera;
use crate::monitor::Monitor;

/// An open input.
pub trait Subject {
    fn method(&self) -> Method;

    /// Its frames; none for a still scene.
    fn frames(&self) -> Option<FrameRange>;

    /// Frames per second, of a stream of pictures.
    fn fps(&self) -> f64;

    /// Frames of a reference that are compared, where these are asked for.
    fn reference_frames(&self, asked: Option<FrameRange>) -> Option<FrameRange> {
        asked
    }

    /// The camera of a picture of a frame where none is asked for, and its words.
    fn own_camera(&self, frame: u32) -> Result<(Camera, String)>;

    fn tone(&self) -> ToneMap;

    /// Refuses pictures that it cannot draw, before anything is written.
    fn check(&mut self, jobs: &[Job], global: &GlobalArgs) -> Result<()>;

    fn renderer<'s>(&'s mut self, gpu: Option<&'s Gpu>) -> Result<Box<dyn JobRenderer + 's>>;
}

pub trait JobRenderer {
    /// Renders the images of a job. The monitor advances by one for each row.
    fn render(&mut self, job: &Job, truth: Option<&mut TruthRun>, monitor: &dyn Monitor) -> Result<RenderedJob>;

    /// Figures of all jobs so far.
    fn figures(&self) -> Figures;
}

pub struct RenderedJob {
    pub images: Vec<RenderedImage>,
    /// As they are compared with references, where that differs.
    pub compared: Option<Vec<RenderedImage>>,
    /// Of each image, pixels near silhouettes of views, where they are known.
    pub near_silhouettes: Vec<Option<Plane<bool>>>,
    pub trace: Option<FrameTrace>,
}
