//! Refractive proxies: closed shapes that replace refractive solids, each with a map of its environment (CALF 6.1).
//!
//! A solid shows mostly what it hides from the views, and it magnifies errors of its shape. Therefore a shape fitted to all its
//! texels replaces normals estimated from a few texels, and an environment map at its centre determines what leaving rays meet.
//!
//! Proxies are made for each image, which takes longer than rendering a small image. None are made for an image without specular
//! texels in its frustum. That test uses texels only, so it gives the same result on all devices.

use std::sync::Arc;

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use crate::march::{ActiveView, ActiveViews, Sphere, ViewPyramids};
use crate::views::{BACKGROUND, ColorCoding, FaceTexels, UNKNOWN, View, has_specular_weight};
use codec::error::Result;
use codec::image::Face;
use codec::math::Camera;
use codec::monitor::Monitor;

/// Maximum distance between a proxy's surface and a point that belongs to the proxy, as a fraction of the radius.
/// [`REACH_TEXELS`] is added.
pub const NEAR_SURFACE: f32 = 0.03;
/// Additional distance, in texels of the view with the smallest texels at the point: rays meet surfaces up to the diagonal of a
/// texel too early, see [`Footprint::Around`](crate::march::Footprint).
pub const REACH_TEXELS: f32 = std::f32::consts::SQRT_2;
/// Margin of a texel in the frustum test, in texel widths: colours and materials are interpolated.
pub const MARGIN_TEXELS: f64 = 4.0;

#[derive(Debug, Clone, PartialEq)]
pub struct Proxy {
    pub sphere: Sphere,
    /// Index of refraction, 1 to 3.
    pub ior: f32,
    /// Maximum distance between the surface and a point that belongs to the proxy, in metres.
    pub reach_m: f32,
    /// Local environment map: a view from the centre, in world axes. Its position is not used.
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
    /// Ordered by size in texels, largest first.
    pub proxies: Vec<Proxy>,
    coding: ColorCoding,
}

impl Proxies {
    pub fn none(coding: ColorCoding) -> Proxies {
        Proxies { proxies: Vec::new(), coding }
    }

    /// Creates the proxies of a provider.
    pub fn of(provider: &dyn ProxyProvider, views: &ActiveViews<'_>, monitor: &dyn Monitor) -> Result<Proxies> {
        Ok(Proxies { proxies: provider.proxies(views, monitor)?, coding: views.coding })
    }

    /// Returns the index of the proxy whose surface is nearest to a point, of those that reach it.
    pub fn at(&self, point: Vec3) -> Option<usize> {
        let distance_m = |sphere: &Sphere| ((point - sphere.centre).length() - sphere.radius_m).abs();
        let of = |(at, proxy): (usize, &Proxy)| (at, distance_m(&proxy.sphere), proxy.reach_m);
        let near = self.proxies.iter().enumerate().map(of).filter(|(_, distance_m, reach_m)| distance_m <= reach_m);
        near.min_by(|(_, a, _), (_, b, _)| a.total_cmp(b)).map(|(at, ..)| at)
    }

    pub fn environments(&self) -> Vec<ActiveViews<'_>> {
        let views = self.proxies.iter().map(|proxy| vec![proxy.environment_view()]);
        views.map(|views| ActiveViews { views, coding: self.coding }).collect()
    }
}

/// Returns [`Proxy::reach_m`] for a sphere.
pub(crate) fn reach_m(views: &ActiveViews<'_>, sphere: &Sphere) -> f32 {
    let texel_m = |view: &ActiveView<'_>| {
        let scale = view.view.faces.iter().flatten().map(|face| face.map.scale[0].abs().max(face.map.scale[1].abs()));
        (sphere.centre - view.from_eye).length() * scale.fold(0.0, f32::max)
    };
    let texel_m = views.views.iter().map(texel_m).fold(f32::INFINITY, f32::min);
    NEAR_SURFACE * sphere.radius_m + if texel_m.is_finite() { REACH_TEXELS * texel_m } else { 0.0 }
}

pub trait ProxyProvider {
    /// Returns the proxies of these views, the most important first.
    fn proxies(&self, views: &ActiveViews<'_>, monitor: &dyn Monitor) -> Result<Vec<Proxy>>;
}

/// Returns the proxies of a provider that a camera's image needs.
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

/// An image with specular texels.
#[derive(Debug, Clone, Copy)]
pub struct SpecularImage<'a> {
    pub view: &'a ActiveView<'a>,
    /// Index of its face.
    pub face: usize,
    pub texels: &'a FaceTexels,
}

impl<'a> SpecularImage<'a> {
    /// Returns the specular images of all views that are decoded on the CPU.
    pub fn all(views: &'a ActiveViews<'a>) -> Vec<SpecularImage<'a>> {
        let of_view = |view: &'a ActiveView<'a>| {
            let faces = view.view.faces.iter().enumerate();
            faces.filter_map(move |(face, texels)| Some(SpecularImage { view, face, texels: texels.as_ref()? }))
        };
        let all = views.views.iter().flat_map(of_view);
        all.filter(|image| image.texels.is_specular && !image.texels.is_in_backend()).collect()
    }

    /// Returns the centre of a texel on its surface, in metres relative to the eye. None if the texel has no surface.
    pub fn point(&self, at: usize) -> Option<DVec3> {
        let inverse = self.texels.inverse_depth[at];
        if inverse == BACKGROUND || inverse == UNKNOWN {
            return None;
        }
        let local = self.texels.direction(Face::from_index(self.face as u8)?, at) / f64::from(inverse);
        let point = self.view.probe_from_world.as_dmat3().transpose() * local + self.view.from_eye.as_dvec3();
        point.is_finite().then_some(point)
    }

    pub fn is_refractive(&self, at: usize) -> bool {
        self.texels.material.as_ref().is_some_and(|material| material[at][1] > 0)
    }
}

/// True if a specular texel, occluded or not, lies in a camera's frustum.
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
