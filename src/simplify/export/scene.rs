//! Input of the file writers.

use crate::cost::TextureCoordinates;
use crate::gbuffer::SurfaceAtlas;
use crate::quad_mesh::QuadMesh;
use crate::region::ViewingRegion;
use crate::selection::Budgets;

/// A scene, and the metadata that files store with it.
#[derive(Debug)]
pub struct Scene<'a> {
    pub quads: &'a QuadMesh,
    pub region: &'a ViewingRegion,
    pub budgets: &'a Budgets,
    /// Frame of the capture.
    pub frame: u32,
    /// Maximum side of the atlas, in texels.
    pub atlas: u32,
    pub coordinates: TextureCoordinates,
    pub surfaces: Option<&'a SurfaceAtlas>,
}
