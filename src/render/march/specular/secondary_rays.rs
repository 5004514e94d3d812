//! Secondary rays of reflective and refractive surfaces: CalculateColor_RR of algorithm 4 (CALF 6.1).
//!
//! Takes a surface hit with the colour interpolated from the views. Returns linear RGB.
//!
//! The share of a ray starts at 1 and is only divided, by the weights of the material, among the reflected ray, the refracted ray
//! and the interpolated colour. As in the paper, a ray that finds nothing gives its share to the interpolated colour. Therefore
//! no image is brighter than its brightest input.
//!
//! Surfaces seen through a refractive solid are mostly hidden from the views. A ray that leaves a proxy ([`crate::march::specular::proxy`])
//! ends in the proxy's environment map, with the colour that views see at that point, or that they captured through the solid.
//! For other solids, the interpolated colour of the solid replaces what is hidden.
//!
//! The interpolated colour of a surface contains the reflection and refraction that the view captured. If the eye sees the
//! surface from nearly the same direction as a view, the captured colour is shown (not in the paper), so that images converge to
//! what a probe recorded as the eye approaches the probe.
//!
//! Secondary rays can go anywhere, so all units of the active views must be decoded if a specular one is visible.

use glam::Vec3;

use crate::march::intersect::intersect;
use crate::march::specular::material::Material;
use crate::march::specular::solid::{Refraction, reflect};
use crate::march::{
    ActiveView, ActiveViews, Counters, Patch, Proxies, Ray, RayResult, RenderSettings, StepsFrom, background,
    intersect_from, light_of, patch, surface, surface_color, surface_color_of, surface_material,
};
use crate::views::{BACKGROUND, UNKNOWN};

/// Minimum share of a ray that is traced.
pub const MIN_SHARE: f32 = 1.0 / 256.0;
/// Upper limit of [`RenderSettings::max_bounces`].
pub const MAX_BOUNCES: u32 = 8;
/// Height above a surface at which rays start, in texels of the surface.
pub const LIFT_TEXELS: f32 = 1.0;
/// Maximum length over which a ray may be hidden from all views, in texels of the surface that it leaves. A ray that is hidden
/// for longer is discarded, because it may have met a surface that no view sees.
pub const HIDDEN_TEXELS: f32 = 12.0;

/// Minimum sine of the angle between the eye's and a view's directions to a surface at which the colour captured by the view is
/// not used.
pub const RECORDED_SINE: f32 = 0.05;

#[derive(Debug, Clone, Copy)]
pub struct SurfaceHit {
    /// In metres relative to the eye.
    pub point: Vec3,
    /// Unit direction of the ray.
    pub direction: Vec3,
    /// Interpolated linear RGB.
    pub light: Vec3,
}

/// A surface hit whose share is not divided yet.
#[derive(Debug, Clone, Copy)]
struct Pending {
    hit: SurfaceHit,
    share: f32,
    bounces: u32,
}

#[derive(Debug, Clone, Copy)]
enum Departure {
    /// The ray is in empty space at the step with this index.
    Empty(usize),
    /// The ray meets another surface before the first step, at this distance in metres.
    Hit(f32),
}

pub struct SecondaryRays<'a> {
    views: &'a ActiveViews<'a>,
    settings: &'a RenderSettings,
    proxies: &'a Proxies,
    environments: Vec<ActiveViews<'a>>,
    pending: Vec<Pending>,
}

struct Front {
    point: Vec3,
    patch: Patch,
    proxy: Option<usize>,
}

impl<'a> SecondaryRays<'a> {
    pub fn new(views: &'a ActiveViews<'a>, settings: &'a RenderSettings, proxies: &'a Proxies) -> SecondaryRays<'a> {
        SecondaryRays { views, settings, proxies, environments: proxies.environments(), pending: Vec::new() }
    }

    pub fn light(&mut self, hit: &SurfaceHit, counters: &mut Counters) -> Vec3 {
        let bounces = self.settings.max_bounces.min(MAX_BOUNCES);
        let mut light = self.divide(&Pending { hit: *hit, share: 1.0, bounces }, counters);
        while let Some(next) = self.pending.pop() {
            light += self.divide(&next, counters);
        }
        light
    }

    /// Returns the colour of a point captured by views that look in nearly the eye's direction, and its share: 1 if a view looks
    /// in exactly that direction, 0 if all differ by [`RECORDED_SINE`] or more.
    fn recorded(&self, point: Vec3) -> Option<(f32, Vec3)> {
        let difference = self.settings.tolerance();
        let share = |view: &ActiveView<'_>| {
            let from_view = point - view.from_eye;
            let Some(at) = view.view.project(view.local(point)) else { return 0.0 };
            let surface = view.nearest_inverse_depth(&at);
            let is_seen = surface != BACKGROUND
                && surface != UNKNOWN
                && (surface / at.inverse_depth).ln().abs() <= difference
                && point.dot(from_view) > 0.0;
            if !is_seen {
                return 0.0;
            }
            let sine = point.cross(view.from_eye).length() / (point.length() * from_view.length());
            (1.0 - sine / RECORDED_SINE).clamp(0.0, 1.0)
        };
        let found = surface_color_of(self.views, point, share)?;
        let share = self.views.views.iter().map(share).fold(0.0, f32::max);
        Some((share * share * (3.0 - 2.0 * share), light_of(self.views.coding, found.color)))
    }

    /// Divides the share of a surface among its secondary rays. Returns the RGB, multiplied by its share, that needs no further
    /// rays.
    fn divide(&mut self, next: &Pending, counters: &mut Counters) -> Vec3 {
        let Pending { mut hit, share, bounces } = *next;
        let whole = share * hit.light;
        if bounces == 0 {
            return whole;
        }
        counters.material_samples += 1;
        let Some(material) = surface_material(self.views, hit.point) else { return whole };
        // For primary rays only: surfaces that other rays hit are not seen from the eye.
        let is_primary = bounces == self.settings.max_bounces.min(MAX_BOUNCES);
        if is_primary && self.settings.refinements.edges {
            // A mirror doubles the error of a position.
            let ray = Ray { origin: Vec3::ZERO, direction: hit.direction };
            hit.point = ray.at(self.views.on_texels(&ray, hit.point.length(), counters));
        }
        let recorded = if is_primary { self.recorded(hit.point) } else { None };
        let (recorded_share, recorded_light) = recorded.unwrap_or_default();
        let recorded = share * recorded_share * recorded_light;
        let share = share - share * recorded_share;
        let whole = recorded + share * hit.light;
        if share < MIN_SHARE {
            return whole;
        }
        counters.normal_evals += 1;
        let Some(front) = self.front(&hit, &material) else { return whole };
        let cosine = -hit.direction.dot(front.patch.normal);
        if cosine <= 0.0 {
            return whole;
        }
        let material = material.at_angle(cosine);
        let (mut light, mut left) = (Vec3::ZERO, share);
        if share * material.refract >= MIN_SHARE {
            let proxy = front.proxy.map(|at| self.proxies.proxies[at].sphere);
            let refraction = Refraction { views: self.views, steps: &self.settings.steps, proxy };
            let ray = Ray { origin: front.point, direction: hit.direction };
            for exit in refraction.pass(&ray, &front.patch, material.ior, counters).into_iter().flatten() {
                let share = share * material.refract * exit.part;
                if share < MIN_SHARE {
                    continue;
                }
                if let Some(found) = self.trace(&exit.ray, &front, share, bounces, counters) {
                    light += found;
                    left -= share;
                }
            }
        }
        if share * material.reflect >= MIN_SHARE {
            let origin = front.point + LIFT_TEXELS * front.patch.texel_m * front.patch.normal;
            let ray = Ray { origin, direction: reflect(hit.direction, front.patch.normal) };
            if let Some(found) = self.trace(&ray, &front, share * material.reflect, bounces, counters) {
                light += found;
                left -= share * material.reflect;
            }
        }
        recorded + light + left.max(0.0) * hit.light
    }

    /// Returns the surface at a hit: that of a proxy for a refractive material on one, else a patch fitted to texels.
    fn front(&self, hit: &SurfaceHit, material: &Material) -> Option<Front> {
        let proxy = if material.refract > 0.0 { self.proxies.at(hit.point) } else { None };
        let on_proxy = || {
            let sphere = self.proxies.proxies[proxy?].sphere;
            let point = sphere.entry(&Ray { origin: hit.point, direction: hit.direction })?;
            // No lift: rays that leave a proxy are not compared with its own texels.
            let curvature = Some(sphere.radius_m.recip());
            Some(Front { point, patch: Patch { normal: sphere.normal(point)?, curvature, texel_m: 0.0 }, proxy })
        };
        let on_texels = || Some(Front { point: hit.point, patch: patch(self.views, hit.point)?, proxy: None });
        on_proxy().or_else(on_texels)
    }

    /// Traces a ray that leaves a front. Returns its RGB multiplied by `share`; a surface hit is pushed to `pending` and
    /// contributes 0. None if no view saw what the ray meets.
    fn trace(&mut self, ray: &Ray, front: &Front, share: f32, bounces: u32, counters: &mut Counters) -> Option<Vec3> {
        counters.secondary_rays += 1;
        let (steps, acceleration) = (&self.settings.steps, self.settings.acceleration);
        let hit_m = match front.proxy {
            Some(at) => intersect(acceleration, &self.environments[at], ray, steps, counters),
            None => match self.leave_surface(ray, front.patch.texel_m, counters)? {
                Departure::Hit(distance_m) => Some(distance_m),
                Departure::Empty(first) => {
                    intersect_from(acceleration, self.views, ray, StepsFrom { steps, first }, counters)
                }
            },
        };
        let Some(hit_m) = hit_m else {
            return match background(self.views, ray.direction) {
                RayResult::Light(light) => Some(share * light),
                RayResult::Disoccluded(_) => None,
            };
        };
        let point = ray.at(hit_m);
        match surface(self.views, point, steps.uncertainty()) {
            RayResult::Light(light) => {
                let hit = SurfaceHit { point, direction: ray.direction, light };
                self.pending.push(Pending { hit, share, bounces: bounces - 1 });
                Some(Vec3::ZERO)
            }
            // Hidden from all views, but captured through the solid.
            RayResult::Disoccluded(_) => {
                let seen = surface_color(&self.environments[front.proxy?], point)?;
                Some(share * light_of(self.views.coding, seen.color))
            }
        }
    }

    /// Samples a ray at intervals of texels before its first step: steps are spaced for the eye, and the first one may be beyond
    /// what the ray meets. None if the ray is hidden for too long.
    fn leave_surface(&self, ray: &Ray, texel_m: f32, counters: &mut Counters) -> Option<Departure> {
        let steps = &self.settings.steps;
        let mut empty_m = None;
        for (distance_m, step) in steps.off_surface(texel_m) {
            counters.march_steps += 1;
            match (self.views.is_surface(ray.at(distance_m)), empty_m, step) {
                (true, Some(empty_m), _) => {
                    let interval_m = [empty_m, distance_m];
                    return Some(Departure::Hit(self.views.refine(ray, interval_m, steps.refine(), counters)));
                }
                (true, None, _) if distance_m > HIDDEN_TEXELS * texel_m => return None,
                (true, None, _) => {}
                (false, _, Some(first)) => return Some(Departure::Empty(first)),
                (false, _, None) => empty_m = Some(distance_m),
            }
        }
        None
    }
}
