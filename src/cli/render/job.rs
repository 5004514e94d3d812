//! What `render` renders at once.

use super::pictures::PictureName;
use crate::evaluate::frame_requests::FrameRequest;

/// Images to render at once, for one frame.
pub struct Job {
    /// Frame and cameras.
    pub request: FrameRequest,
    /// Name of each image; stereo pairs have one.
    pub names: Vec<PictureName>,
    /// Width and height of each image.
    pub size: [u32; 2],
    /// Indices of reference images, in the order of the cameras.
    pub references: Vec<usize>,
}
