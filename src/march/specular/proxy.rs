//! Refractive proxies: closed shapes that stand for refractive solids, each with a map of its environment (CALF 6.1).
//!
//! A solid shows mostly what it hides, and magnifies errors of its shape. So a shape fitted to all its texels replaces
//! normals from a few, and an environment map at its centre says what leaving rays meet.
//!
//! Proxies are made anew for each picture, and take longer than a small picture does. So none are made for a picture
//! without specular texels in its frustum; that test uses texels alone, and so is the same on all devices.

use std::sync::Arc;

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use crate::error::Result;
use crate::march::{ActiveView, ActiveViews, SpecularImage, Sphere, ViewPyramids};
use crate::math::Camera;
use crate::monitor::Monitor;
use crate::views::{ColorCoding, View, has_specular_weight};

/// A point belongs to a proxy where it is at most this far from its surface, in parts of its radius, and [`REACH_TEXELS`].
pub const NEAR_SURFACE: f32 = 0.03;
/// Rays meet surfaces up to the diagonal of a texel too early, in the view with the smallest texels there: see
/// [`Footprint::Around`](crate::march::Footprint).
pub const REACH_TEXELS: f32 = std::f32::consts::SQRT_2;
/// Margin of a texel in the frustum test, in widths of it: colours and materials are interpolated.
pub const MARGIN_TEXELS: f64 = 4.0;

#[derive(Debug, Clone, PartialEq)]
pub struct Proxy {
    pub sphere: Sphere,
    /// Index of refraction, 1 to 3.
    pub ior: f32,
    /// A point belongs to the proxy where it is at most this far from its surface, in metres.
    pub reach_m: f32,
    /// Local environment map: a view from the centre, along the world's axes. Its position is not used.
    pub environment: View,
    pub(crate) pyramids: Arc<ViewPyramids>,
}

impl Proxy {
    pub fn environment_view(&self) -> ActiveView<'_> {
        ActiveView::new(&self.environment, Arc::clone(&self.pyramids), self.sphere.centre)
    }
}

#[derive(Debug, Clone, PartialEq)]
pub struct Proxies {
    /// By size in texels, greatest first.
    pub proxies: Vec<Proxy>,
    coding: ColorCoding,
}

impl Proxies {
    pub fn none(coding: ColorCoding) -> Proxies {
        Proxies { proxies: Vec::new(), coding }
    }

    /// The proxies that a provider finds.
    pub fn of(provider: &dyn ProxyProvider, views: &ActiveViews<'_>, monitor: &dyn Monitor) -> Result<Proxies> {
        Ok(Proxies { proxies: provider.proxies(views, monitor)?, coding: views.coding })
    }

    /// The proxy whose surface contains a point.
    pub fn at(&self, point: Vec3) -> Option<usize> {
        self.proxies.iter().position(|Proxy { sphere, reach_m, .. }| {
            ((point - sphere.centre).length() - sphere.radius_m).abs() <= *reach_m
        })
    }

    pub fn environments(&self) -> Vec<ActiveViews<'_>> {
        let views = self.proxies.iter().map(|proxy| vec![proxy.environment_view()]);
        views.map(|views| ActiveViews { views, coding: self.coding }).collect()
    }
}

/// [`Proxy::reach_m`] of a sphere.
pub(crate) fn reach_m(views: &ActiveViews<'_>, sphere: &Sphere) -> f32 {
    let texel_m = |view: &ActiveView<'_>| {
        let scale = view.view.faces.iter().flatten().map(|face| face.map.scale[0].abs().max(face.map.scale[1].abs()));
        (sphere.centre - view.from_eye).length() * scale.fold(0.0, f32::max)
    };
    let texel_m = views.views.iter().map(texel_m).fold(f32::INFINITY, f32::min);
    NEAR_SURFACE * sphere.radius_m + if texel_m.is_finite() { REACH_TEXELS * texel_m } else { 0.0 }
}

pub trait ProxyProvider {
    /// The proxies of these views, the most important first.
    fn proxies(&self, views: &ActiveViews<'_>, monitor: &dyn Monitor) -> Result<Vec<Proxy>>;
}

/// The proxies of a provider that a camera's picture needs.
pub fn proxies_in_sight(
    provider: &dyn ProxyProvider,
    views: &ActiveViews<'_>,
    camera: &Camera,
    monitor: &dyn Monitor,
) -> Result<Proxies> {
    monitor.check()?;
    match has_specular_in_frustum(views, camera) {
        true => Proxies::of(provider, views, monitor),
        false => Ok(Proxies::none(views.coding)),
    }
}

/// Whether a specular texel, occluded or not, lies in a camera's frustum.
pub fn has_specular_in_frustum(views: &ActiveViews<'_>, camera: &Camera) -> bool {
    let [forward, right, down] = camera.axes();
    let window = camera.window();
    let edges = [window.u, window.v].map(|edges| edges.map(|edge| (edge, (1.0 + edge * edge).sqrt())));
    let is_near_frustum = |point: DVec3, margin_m: f64| {
        if camera.is_panorama() {
            return true;
        }
        let depth_m = point.dot(forward);
        let beside_m = [point.dot(right), point.dot(down)];
        depth_m >= -margin_m
            && beside_m.iter().zip(edges).all(|(beside_m, [low, high])| {
                // Distances from the side planes.
                beside_m - high.0 * depth_m <= high.1 * margin_m && low.0 * depth_m - beside_m <= low.1 * margin_m
            })
    };
    SpecularImage::all(views).into_par_iter().any(|image| {
        let texels = image.texels;
        let scale = f64::from(texels.map.scale[0].abs().min(texels.map.scale[1].abs()));
        texels.material.as_ref().is_some_and(|material| {
            (0..material.len()).filter(|&at| has_specular_weight(&material[at])).any(|at| {
                let margin_m = || MARGIN_TEXELS / (f64::from(texels.inverse_depth[at]) * scale);
                image.point(at).is_some_and(|point| is_near_frustum(point, margin_m()))
            })
        })
    })
}
