//! Renderers that ray marching is compared with in a playback (CALF 7.3): point splatting, and reprojection at true distances.

use std::collections::VecDeque;

use crate::march::baseline::reproject::reproject;
use crate::march::baseline::splat::splat;
use crate::march::{ActiveViews, PictureOptions, Pyramids, Rendered, Renderer, Stage};
use codec::error::{Error, Result};
use codec::image::DepthPlane;
use codec::math::Camera;
use codec::monitor::Monitor;

/// Renders every texel as a point.
#[derive(Debug, Clone, Default)]
pub struct SplatRenderer {
    pub options: PictureOptions,
}

impl Renderer for SplatRenderer {
    fn render(&mut self, stage: &Stage<'_>, camera: &Camera, monitor: &dyn Monitor) -> Result<Rendered> {
        let views = ActiveViews::with_pyramids(stage.field, &Pyramids::default(), stage.views, camera.eye());
        splat(&views, camera, &self.options.settings(&views), monitor)
    }
}

/// Interpolates colours at the true surface distances.
#[derive(Debug, Clone, Default)]
pub struct ReprojectRenderer {
    pub options: PictureOptions,
    /// True distances in metres for the next images, one plane per image.
    pub distances_m: VecDeque<DepthPlane>,
}

impl Renderer for ReprojectRenderer {
    fn render(&mut self, stage: &Stage<'_>, camera: &Camera, monitor: &dyn Monitor) -> Result<Rendered> {
        let distance_m = self.distances_m.pop_front();
        let distance_m = distance_m.ok_or_else(|| Error::Usage("this picture has no true distances".into()))?;
        let views = ActiveViews::with_pyramids(stage.field, &Pyramids::default(), stage.views, camera.eye());
        reproject(&views, camera, &distance_m, self.options.holes, monitor)
    }
}
