//! Subjects that `render` draws: a light field or a simplified scene.

use super::options::Method;
use super::pictures::Job;
use super::report::Figures;
use super::truth::TruthRun;
use crate::GlobalArgs;
use codec::error::Result;
use codec::image::transfer::ToneMap;
use codec::image::{FrameRange, Plane};
use codec::math::Camera;
use codec::monitor::Monitor;
use gpu::Gpu;
use render::march::playback::trace::FrameTrace;
use render::rendered_image::RenderedImage;

/// An open input.
pub trait Subject {
    fn method(&self) -> Method;

    /// Returns the frames of the input. `None` for a still scene.
    fn frames(&self) -> Option<FrameRange>;

    /// Returns the frames per second of a picture stream.
    fn fps(&self) -> f64;

    /// Returns the frames of a reference to compare, given the requested frames.
    fn reference_frames(&self, asked: Option<FrameRange>) -> Option<FrameRange> {
        asked
    }

    /// Returns the default camera of a frame, and its description.
    fn own_camera(&self, frame: u32) -> Result<(Camera, String)>;

    fn tone(&self) -> ToneMap;

    /// Fails if a picture cannot be drawn. Called before anything is written.
    fn check(&mut self, jobs: &[Job], global: &GlobalArgs) -> Result<()>;

    fn renderer<'s>(&'s mut self, gpu: Option<&'s Gpu>) -> Result<Box<dyn JobRenderer + 's>>;
}

pub trait JobRenderer {
    /// Renders the images of a job. The monitor advances by one for each row.
    fn render(&mut self, job: &Job, truth: Option<&mut TruthRun>, monitor: &dyn Monitor) -> Result<RenderedJob>;

    /// Returns the figures of all jobs so far.
    fn figures(&self) -> Figures;
}

pub struct RenderedJob {
    pub images: Vec<RenderedImage>,
    /// Images to compare with references, if they differ from `images`.
    pub compared: Option<Vec<RenderedImage>>,
    /// For each image, a mask of the pixels near silhouettes of views, if known.
    pub near_silhouettes: Vec<Option<Plane<bool>>>,
    pub trace: Option<FrameTrace>,
}
