//! Auxiliary planes of a rendered image, for compositing: depth, normals, holes, and the number of views that saw the visible
//! surface.
//!
//! Takes active views, a camera and settings. Returns the values of the ray through the middle of each pixel, regardless of the
//! number of rays that its colour uses.

use glam::Vec3;

use crate::march::render::first_rays;
use crate::march::{ActiveView, ActiveViews, Counters, Ray, RenderSettings, patch};
use crate::rendered_image::Aov;
use crate::views::{BACKGROUND, UNKNOWN};
use codec::error::Result;
use codec::image::Plane;
use codec::math::Camera;
use codec::monitor::Monitor;

/// Kind of an auxiliary plane.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum AovKind {
    /// `Z`: distance along the ray in metres; `+inf` if the ray shows background or nothing.
    Depth,
    /// `N.X`, `N.Y`, `N.Z`: unit normal in world axes, towards the views; 0 if unknown.
    Normal,
    /// `holes`: 1 if the ray first meets a surface that no view saw, or ends without a known colour; else 0.
    Holes,
    /// `views`: number of views that saw the visible surface or background.
    Views,
}

impl AovKind {
    fn channels(self) -> &'static [&'static str] {
        match self {
            AovKind::Depth => &["Z"],
            AovKind::Normal => &["N.X", "N.Y", "N.Z"],
            AovKind::Holes => &["holes"],
            AovKind::Views => &["views"],
        }
    }
}

/// Renders the planes of these kinds. Depth, normal and number of views are those of the layer with the largest share of the
/// pixel. Checks the monitor for interruption.
pub fn aovs(
    views: &ActiveViews<'_>,
    camera: &Camera,
    settings: &RenderSettings,
    kinds: &[AovKind],
    monitor: &dyn Monitor,
) -> Result<Vec<Aov>> {
    let has_normals = kinds.contains(&AovKind::Normal);
    let pixels = first_rays(views, camera, settings, monitor, |direction, hit| {
        let distance_m = hit.distance_m();
        let ray = Ray { origin: Vec3::ZERO, direction };
        let point = distance_m.map(|distance_m| ray.at(distance_m));
        let on_texels = |distance_m| ray.at(views.on_texels(&ray, distance_m, &mut Counters::default()));
        let normal = distance_m.filter(|_| has_normals).and_then(|distance_m| patch(views, on_texels(distance_m)));
        let [x, y, z] = normal.map_or(Vec3::ZERO, |patch| patch.normal).to_array();
        let seen = match point {
            Some(point) => views_of_surface(views, point, settings.tolerance()),
            None => views_of_background(views, direction),
        };
        [distance_m.unwrap_or(f32::INFINITY), x, y, z, f32::from(u8::from(hit.is_hole)), seen as f32]
    })?;
    let plane = |at: usize| Plane::from_fn(pixels.width(), pixels.height(), |x, y| pixels.get(x, y)[at]);
    let all = [AovKind::Depth, AovKind::Normal, AovKind::Holes, AovKind::Views];
    let channels = all.iter().flat_map(|kind| kind.channels().iter().map(move |channel| (kind, *channel))).enumerate();
    Ok(channels
        .filter(|(_, (kind, _))| kinds.contains(kind))
        .map(|(at, (_, channel))| Aov { channel, plane: plane(at) })
        .collect())
}

/// Returns the number of views whose texel at a point has the point's surface.
fn views_of_surface(views: &ActiveViews<'_>, point: Vec3, tolerance: f32) -> usize {
    let has_it = |inverse_depth: f32, at: f32| {
        inverse_depth != BACKGROUND && inverse_depth != UNKNOWN && (inverse_depth / at).ln().abs() <= tolerance
    };
    let sees = |view: &&ActiveView<'_>| {
        let at = view.view.project(view.local(point));
        at.is_some_and(|at| has_it(view.nearest_inverse_depth(&at), at.inverse_depth))
    };
    views.views.iter().filter(sees).count()
}

/// Returns the number of views that see background in a direction.
fn views_of_background(views: &ActiveViews<'_>, direction: Vec3) -> usize {
    let sees = |view: &&ActiveView<'_>| {
        let at = view.view.project(view.probe_from_world * direction);
        at.is_some_and(|at| view.nearest_inverse_depth(&at) == BACKGROUND)
    };
    views.views.iter().filter(sees).count()
}
