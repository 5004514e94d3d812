//! Reprojection baseline: interpolates colours at the true depths, with the weights of the paper.
//!
//! Takes active views, a camera, and the true distance of each pixel. Returns a rendered image. The ground truth has one surface
//! per pixel, which is treated as opaque.

use std::collections::VecDeque;

use glam::Vec3;
use rayon::prelude::*;

use crate::march::{
    ActiveViews, Counters, PictureOptions, Pyramids, RayResult, Rendered, Renderer, Stage, background, surface,
};
use crate::rendered_image::{HoleFill, RenderedImage};
use codec::error::{Error, Result};
use codec::image::DepthPlane;
use codec::math::Camera;
use codec::monitor::Monitor;

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

/// Renders with true distances in metres; `+inf` marks a pixel without a surface. Secondary rays, supersampling, and the near and
/// far planes of the camera are not supported, because the ground truth does not include them. The monitor advances by one per
/// row.
pub fn reproject(
    views: &ActiveViews<'_>,
    camera: &Camera,
    distance_m: &DepthPlane,
    holes: HoleFill,
    monitor: &dyn Monitor,
) -> Result<Rendered> {
    let (width, height) = (distance_m.width(), distance_m.height());
    let row = |y: u32| -> Result<Vec<(RayResult, bool)>> {
        monitor.check()?;
        let pixel = |(x, distance_m): (usize, &f32)| {
            let middle = |at: f64, size: u32| (at + 0.5) / f64::from(size);
            let direction: Vec3 = camera.direction([middle(x as f64, width), middle(y.into(), height)]).as_vec3();
            match distance_m.is_finite() {
                true => (surface(views, direction * *distance_m, 0.0), true),
                false => (background(views, direction), false),
            }
        };
        monitor.advance(1);
        Ok(distance_m.row(y).iter().enumerate().map(pixel).collect())
    };
    let rows: Vec<_> = (0..height).into_par_iter().map(row).collect::<Result<_>>()?;
    let mut counters = Counters { primary_rays: u64::from(width) * u64::from(height), ..Counters::default() };
    let pixels = rows.into_iter().flatten().map(|(result, is_surface)| {
        counters.background_rays += u64::from(!is_surface);
        match result {
            RayResult::Light(light) => light.extend(1.0).to_array(),
            RayResult::Disoccluded(nearest) => {
                counters.hole_rays += 1;
                let shown = nearest.filter(|_| holes != HoleFill::Blank);
                let is_opaque = shown.is_some() && holes == HoleFill::Behind;
                shown.unwrap_or(Vec3::ZERO).extend(f32::from(u8::from(is_opaque))).to_array()
            }
        }
    });
    let image = RenderedImage::of_pixels([width, height], pixels)?;
    Ok(Rendered { image, counters })
}
