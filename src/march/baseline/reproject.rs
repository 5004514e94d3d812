//! Interpolation at true depths: the ceiling of ray marching.
//!
//! Enters: active views, a camera, and the true distance of each pixel. Leaves: a picture by the interpolation of
//! [`crate::march::render`].

use glam::Vec3;
use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::evaluate::rendered_image::{HoleFill, RenderedImage};
use crate::image::plane::{DepthPlane, Plane};
use crate::march::active_views::ActiveViews;
use crate::march::counters::Counters;
use crate::march::render::Rendered;
use crate::march::shading::{RayResult, background, surface};
use crate::math::Camera;
use crate::monitor::Monitor;

/// Renders with true distances in metres, `+inf` where there is no surface. Secondary rays, several samples, and near and far of the
/// camera are left out: the truth knows none of them. The monitor advances by one for each row.
///
/// # Errors
/// When the monitor says to stop.
pub fn reproject(
    views: &ActiveViews<'_>,
    camera: &Camera,
    distance_m: &DepthPlane,
    holes: HoleFill,
    monitor: &dyn Monitor,
) -> Result<Rendered> {
    let (width, height) = (distance_m.width(), distance_m.height());
    let mut rows = vec![Vec::new(); height as usize];
    rows.par_iter_mut().enumerate().try_for_each(|(y, row)| {
        monitor.check()?;
        let pixel = |(x, distance_m): (usize, &f32)| {
            let middle = |at: usize, size: u32| (at as f64 + 0.5) / f64::from(size);
            let direction: Vec3 = camera.direction([middle(x, width), middle(y, height)]).as_vec3();
            let outcome = match distance_m.is_finite() {
                true => surface(views, direction * *distance_m, 0.0),
                false => background(views, direction),
            };
            (outcome, distance_m.is_finite())
        };
        *row = distance_m.row(y as u32).iter().enumerate().map(pixel).collect();
        monitor.advance(1);
        Ok::<(), Error>(())
    })?;
    let mut counters = Counters { primary_rays: u64::from(width) * u64::from(height), ..Counters::default() };
    let mut pixels = Vec::new();
    for (outcome, is_surface) in rows.into_iter().flatten() {
        counters.background_rays += u64::from(!is_surface);
        pixels.push(match outcome {
            RayResult::Light(light) => (light.to_array(), 1.0),
            RayResult::Disoccluded(nearest) => {
                counters.hole_rays += 1;
                let shown = nearest.filter(|_| holes == HoleFill::Nearest);
                (shown.unwrap_or(Vec3::ZERO).to_array(), 0.0)
            }
        });
    }
    let image = RenderedImage {
        color: Plane::new(width, height, pixels.iter().map(|pixel| pixel.0).collect())?,
        alpha: Plane::new(width, height, pixels.iter().map(|pixel| pixel.1).collect())?,
    };
    Ok(Rendered { image, counters })
}
