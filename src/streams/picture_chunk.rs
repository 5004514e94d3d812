//! Chunks of depth and material: a keyframe and changes, by which a picture is updated in place.

use crate::container::Payload;
use crate::error::Result;

/// A parsed chunk whose frames are reached by updating a picture.
pub trait PictureChunk: Sized {
    type Pixel: Copy + Default;
    type Header;

    /// Checks a payload for a unit of `size` (width, height) pixels and `frames` frames.
    ///
    /// # Errors
    /// [`crate::Error::Invalid`] for a payload that breaks the format.
    fn parse(header: &Self::Header, payload: Payload, size: [u32; 2], frames: u32) -> Result<Self>;

    /// Brings `picture`, which shows frame `at` of this chunk (`None`: nothing yet), to frame `target` in steps of at
    /// most `window` frames; returns the number of pixels written.
    fn advance(&self, picture: &mut [Self::Pixel], at: Option<u32>, target: u32, window: u8) -> u64;

    /// Checks the window rule (depth.md 4), which takes the decoding of all `frames` of the chunk.
    ///
    /// # Errors
    /// [`crate::Error::Invalid`] for a chunk whose frames depend on the steps of a decoder.
    fn check_window(&self, window: u8, frames: u32) -> Result<()>;

    /// The payload's memory, for the next chunk.
    fn into_spare(self) -> Vec<u8>;
}
