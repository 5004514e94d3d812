//! Chunks of depth, material and alpha: a keyframe, and changes that update a picture in place.

use crate::container::Payload;
use crate::depth::predictive::{PredictiveChunk, UnitArea};
use crate::depth::records::TemporalChunk;
use crate::error::Result;
use crate::streams::header::{AlphaHeader, MaterialHeader};

/// A parsed chunk whose frames are decoded by updates of a picture.
pub trait PictureChunk: Sized {
    type Pixel: Copy + Default;
    type Header;

    fn parse(header: &Self::Header, payload: Payload, area: UnitArea, frames: u32) -> Result<Self>;

    /// Updates `picture` from frame `at` of this chunk (`None`: undefined content) to frame `target`, in steps of at most
    /// `window` frames. Returns the number of pixels written.
    ///
    /// # Errors
    /// If a chunk that is decoded frame by frame is damaged.
    fn advance(&mut self, picture: &mut [Self::Pixel], at: Option<u32>, target: u32, window: u8) -> Result<u64>;

    fn check_window(&self, window: u8, frames: u32) -> Result<()>;

    fn into_spare(self) -> Vec<u8>;
}

/// A chunk of material.
impl PictureChunk for TemporalChunk<[u8; 3]> {
    type Pixel = [u8; 3];
    type Header = MaterialHeader;

    fn parse(header: &MaterialHeader, payload: Payload, area: UnitArea, frames: u32) -> Result<Self> {
        TemporalChunk::parse(header.layout(), payload, area.size(), frames)
    }

    fn advance(&mut self, picture: &mut [[u8; 3]], at: Option<u32>, target: u32, window: u8) -> Result<u64> {
        Ok(TemporalChunk::advance(self, picture, at, target, window))
    }

    fn check_window(&self, window: u8, frames: u32) -> Result<()> {
        TemporalChunk::check_window(self, window, frames)
    }

    fn into_spare(self) -> Vec<u8> {
        TemporalChunk::into_spare(self)
    }
}

/// A chunk of alpha.
impl PictureChunk for PredictiveChunk {
    type Pixel = u16;
    type Header = AlphaHeader;

    fn parse(header: &AlphaHeader, payload: Payload, area: UnitArea, frames: u32) -> Result<Self> {
        PredictiveChunk::parse(payload, header.predictive(), area, frames)
    }

    fn advance(&mut self, picture: &mut [u16], at: Option<u32>, target: u32, _window: u8) -> Result<u64> {
        PredictiveChunk::advance(self, picture, at, target)
    }

    fn check_window(&self, _window: u8, _frames: u32) -> Result<()> {
        self.check()
    }

    fn into_spare(self) -> Vec<u8> {
        PredictiveChunk::into_spare(self)
    }
}
