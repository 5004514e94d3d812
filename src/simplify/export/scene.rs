//! Input of the file writers.

use crate::simplify::cost::TextureCoordinates;
use crate::simplify::gbuffer::SurfaceAtlas;
use crate::simplify::quad_mesh::QuadMesh;
use crate::simplify::region::ViewingRegion;
use crate::simplify::selection::Budgets;

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
