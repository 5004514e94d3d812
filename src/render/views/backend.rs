//! Decoding and storage of the depth and colour of a light field, on the CPU or on a graphics device (CALF 6.2; GDC 5).
//!
//! The player determines which units a frame needs and which of their texels are valid. Materials are always decoded on the CPU,
//! because they determine which other units are needed.

use std::sync::Arc;

use rayon::prelude::*;

use crate::views::{CachedUnit, FaceCache, FaceChanges, FaceTexels, InverseDepth, decode_on_cpu};
use codec::error::Result;

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

/// A decoder of depth and colour units that stores the texels of probes.
pub trait TexelBackend {
    /// True if the backend stores the depth and colour texels; otherwise they are in the light field.
    fn keeps_texels(&self) -> bool {
        false
    }

    fn load(&mut self, _probe: usize, _faces: &[NewFace<'_>]) -> Result<()> {
        Ok(())
    }

    /// Returns the bytes that the backend stores for a probe; 0 if the probe is not loaded.
    fn bytes(&self, _probe: usize) -> u64 {
        0
    }

    fn unload(&mut self, _probe: usize) {}

    fn decode(&mut self, frame: u32, units: Vec<&mut CachedUnit<'_>>) -> Result<()>;

    fn shows(&self, unit: &CachedUnit<'_>, frame: u32) -> bool;

    /// Updates texels from the decoded units. Returns the changes of each face, in the same order.
    fn update(&mut self, faces: Vec<FaceUpdate<'_, '_>>) -> Result<Vec<FaceChanges>>;

    /// Returns the stored bytes that the backend has read so far; units count the bytes that they read themselves.
    fn bytes_read(&self) -> u64 {
        0
    }
}

/// Backend that decodes on the CPU, in parallel, into the texels of the light field.
#[derive(Debug, Clone, Copy, Default)]
pub struct CpuBackend;

impl TexelBackend for CpuBackend {
    fn decode(&mut self, frame: u32, units: Vec<&mut CachedUnit<'_>>) -> Result<()> {
        decode_on_cpu(frame, units)
    }

    fn shows(&self, unit: &CachedUnit<'_>, frame: u32) -> bool {
        unit.shows(frame)
    }

    fn update(&mut self, faces: Vec<FaceUpdate<'_, '_>>) -> Result<Vec<FaceChanges>> {
        Ok(faces.into_par_iter().map(|face| face.cache.update(face.texels)).collect())
    }
}
