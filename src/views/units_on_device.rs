//! Depth and colour that are decoded where pictures are made, and not by the player (CALF 6.2; GDC 5).
//!
//! The player says which units show which frame and which texels are known by it; what the texels are, only the device knows.
//! Materials stay with the player, as they decide which other units are wanted.

use std::sync::Arc;

use crate::error::Result;
use crate::views::light_field::{FaceTexels, InverseDepth};
use crate::views::rects::Rect;

/// A tile of depth or a cell of colour.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct UnitId {
    /// Index of its probe in the container.
    pub probe: usize,
    /// Index of its stream in the container.
    pub stream: u32,
    /// Its number in the stream.
    pub unit: u32,
}

/// A face that comes to be shown; nothing of it is known yet.
#[derive(Debug, Clone, Copy)]
pub struct NewFace<'f> {
    /// Number of the face.
    pub face: usize,
    /// Index of its stream of depth.
    pub depth: u32,
    /// Index of its stream of colour.
    pub color: u32,
    /// Size and projection of its image, without texels.
    pub texels: &'f FaceTexels,
    /// What codes of depth become.
    pub inverse: &'f Arc<InverseDepth>,
}

/// Texels of a tile whose depths are to be written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DepthPart {
    /// The tile.
    pub unit: u32,
    /// Left, top, width and height in texels of the face, within the tile.
    pub rect: Rect,
    /// Whether they become what the tile shows; else they become unknown.
    pub is_known: bool,
}

/// Texels of a face whose depths are to be written; no two parts overlap.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FaceParts {
    /// Index of the probe in the container.
    pub probe: usize,
    /// Number of the face.
    pub face: usize,
    /// Its parts.
    pub parts: Vec<DepthPart>,
}

/// Decodes depth and colour, and keeps the texels. Colours are those that units show; depths only what was written of them.
pub trait UnitsOnDevice {
    /// Takes in the faces of a probe that comes to be shown.
    ///
    /// # Errors
    /// When there is no room for them.
    fn begin(&mut self, probe: usize, faces: &[NewFace<'_>]) -> Result<()>;

    /// Bytes of the device that a probe takes; none where it has not begun.
    fn bytes(&self, probe: usize) -> u64;

    /// Forgets a probe.
    fn give_up(&mut self, probe: usize);

    /// Decodes a frame of some units of probes that have begun; answers for each how many pixels were written.
    ///
    /// # Errors
    /// When one cannot be decoded.
    fn decode(&mut self, frame: u32, units: &[UnitId]) -> Result<Vec<u64>>;

    /// Whether what a unit shows is known to be right for a frame.
    fn shows(&self, unit: UnitId, frame: u32) -> bool;

    /// Brings depths, and what stands above them, to what tiles show.
    ///
    /// # Errors
    /// When the device fails.
    fn write_depths(&mut self, faces: &[FaceParts]) -> Result<()>;

    /// Stored bytes that were read so far.
    fn bytes_read(&self) -> u64;
}
