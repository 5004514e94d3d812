//! Where depth and colour of a light field are decoded and kept: on the processor, or on a graphics device (CALF 6.2; GDC 5).
//!
//! The player decides which units a frame needs and which of their texels are valid. Materials are always decoded on the
//! processor, as they decide which other units are needed.

use std::sync::Arc;

use rayon::prelude::*;

use crate::error::Result;
use crate::ordered::try_map_ordered;
use crate::views::{CachedUnit, FaceCache, FaceChanges, FaceTexels, InverseDepth};

#[derive(Debug, Clone, Copy)]
pub struct NewFace<'f> {
    pub face: usize,
    /// Index of its depth stream.
    pub depth: u32,
    /// Index of its colour stream.
    pub color: u32,
    pub texels: &'f FaceTexels,
    pub inverse: &'f Arc<InverseDepth>,
}

#[derive(Debug)]
pub struct FaceUpdate<'f, 'a> {
    /// Index of the view in the light field.
    pub view: usize,
    /// Index of the probe in the container.
    pub probe: usize,
    pub face: usize,
    pub cache: &'f FaceCache<'a>,
    pub texels: &'f mut FaceTexels,
}

/// Decodes units of depth and colour, and keeps the texels of probes.
pub trait TexelBackend {
    /// Whether depth and colour texels are kept here; else they are in the light field.
    fn keeps_texels(&self) -> bool {
        false
    }

    fn load(&mut self, _probe: usize, _faces: &[NewFace<'_>]) -> Result<()> {
        Ok(())
    }

    /// Bytes kept here of a probe; 0 for one that is not loaded.
    fn bytes(&self, _probe: usize) -> u64 {
        0
    }

    fn unload(&mut self, _probe: usize) {}

    fn decode(&mut self, frame: u32, units: Vec<&mut CachedUnit<'_>>) -> Result<()>;

    fn shows(&self, unit: &CachedUnit<'_>, frame: u32) -> bool;

    /// Brings texels to what the units show; answers what changed in each face, in the same order.
    fn update(&mut self, faces: Vec<FaceUpdate<'_, '_>>) -> Result<Vec<FaceChanges>>;

    /// Stored bytes that were read here so far; units count what they read themselves.
    fn bytes_read(&self) -> u64 {
        0
    }
}

/// Decodes on the processor, in parallel, into the texels of the light field.
#[derive(Debug, Clone, Copy, Default)]
pub struct CpuBackend;

impl TexelBackend for CpuBackend {
    fn decode(&mut self, frame: u32, units: Vec<&mut CachedUnit<'_>>) -> Result<()> {
        try_map_ordered(units, |unit: &mut CachedUnit<'_>| unit.decode(frame)).map(|_| ())
    }

    fn shows(&self, unit: &CachedUnit<'_>, frame: u32) -> bool {
        unit.shows(frame)
    }

    fn update(&mut self, faces: Vec<FaceUpdate<'_, '_>>) -> Result<Vec<FaceChanges>> {
        Ok(faces.into_par_iter().map(|face| face.cache.update(face.texels)).collect())
    }
}
