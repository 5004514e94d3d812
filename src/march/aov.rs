//! Planes beside a picture, for whoever composites it: depth, normals, holes, and how many views saw what is shown.
//!
//! Enters: active views, a camera, settings. Leaves: values of the ray through the middle of each pixel, however many rays its
//! colour has.

use glam::Vec3;

use crate::error::Result;
use crate::evaluate::Aov;
use crate::image::Plane;
use crate::march::render::first_rays;
use crate::march::{ActiveView, ActiveViews, Counters, Ray, RenderSettings, patch};
use crate::math::Camera;
use crate::monitor::Monitor;
use crate::views::{BACKGROUND, UNKNOWN};

/// What planes hold.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum AovKind {
    /// `Z`: metres along the ray, `+inf` where background or nothing shows.
    Depth,
    /// `N.X`, `N.Y`, `N.Z`: of length 1 along the world's axes, towards the views; 0 where none is known.
    Normal,
    /// `holes`: 1 where the ray first meets a surface that no view saw, or ends in nothing; else 0.
    Holes,
    /// `views`: the number of views that saw what is shown.
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

/// The planes of these kinds. What counts of several surfaces in a pixel is the one of the greatest share. The monitor is checked.
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

/// Views whose texel at a point has its surface.
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

/// Views that see background in a direction.
fn views_of_background(views: &ActiveViews<'_>, direction: Vec3) -> usize {
    let sees = |view: &&ActiveView<'_>| {
        let at = view.view.project(view.probe_from_world * direction);
        at.is_some_and(|at| view.nearest_inverse_depth(&at) == BACKGROUND)
    };
    views.views.iter().filter(sees).count()
}
