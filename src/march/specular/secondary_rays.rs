//! What mirrors and glass show: CalculateColor_RR of algorithm 4 (CALF 6.1).
//!
//! Enters: a ray, the point of a surface that it met, and the colour that views saw there. Leaves: linear light.
//!
//! A ray's share of the light is 1 and is only ever divided: by the weights of the material that it meets, among
//! the reflected ray, the refracted ray and the colour that views saw. What is sent on and finds nothing brings the
//! colour of the point that sent it, as in the paper, where the weight of such a ray goes to the diffuse colour. So a
//! picture is never brighter than the brightest colour that went into it.
//!
//! Of glass, the light that goes straight through is what views see least of: a ball shows what it hides. What leaves a ball that is
//! known as a whole ends where the view from its centre says ([`crate::march::specular::sphere_fit`]), in the colour that views see there, or
//! saw there through the ball. Of other solids, the colour that views saw stays in the place of what no view sees.
//!
//! Rays may go anywhere: everything that active views have must be decoded where effects are in use.

use glam::Vec3;

use crate::march::active_views::ActiveViews;
use crate::march::counters::Counters;
use crate::march::interpolate::surface_color;
use crate::march::intersect::{intersect, intersect_from};
use crate::march::ray::{Ray, StepsFrom};
use crate::march::settings::RenderSettings;
use crate::march::shading::{Outcome, background, light_of, surface};
use crate::march::specular::material::{Material, surface_material};
use crate::march::specular::normal::{Patch, patch};
use crate::march::specular::solid::{Inside, reflect};
use crate::march::specular::sphere_fit::GlassBalls;

/// Rays of a smaller share are not sent: the colour that views saw takes their place.
pub const LEAST_SHARE: f32 = 1.0 / 256.0;
/// Light is sent on at most so often, whatever the settings say.
pub const MAX_BOUNCES: u32 = 8;
/// How far from a surface rays start, in texels of it.
pub const LIFT_TEXELS: f32 = 1.0;
/// What is hidden from all views for longer than this, in texels of the surface that a ray leaves, is not passed through:
/// surfaces that nobody sees are in it.
pub const HIDDEN_TEXELS: f32 = 12.0;

/// A surface that a ray met.
#[derive(Debug, Clone, Copy)]
pub struct Met {
    /// Where, in metres from the eye.
    pub point: Vec3,
    /// In which direction the ray went, of length 1.
    pub direction: Vec3,
    /// What views saw there, in linear light.
    pub light: Vec3,
}

/// A surface whose share of the light is not divided yet.
#[derive(Debug, Clone, Copy)]
struct Pending {
    met: Met,
    share: f32,
    /// How often its light may be sent on.
    bounces: u32,
}

/// How a ray left the surface that sent it on.
#[derive(Debug, Clone, Copy)]
enum Left {
    /// It is in the open at the step of this number.
    Open(usize),
    /// It meets another surface before, at this distance in metres.
    Hit(f32),
}

/// Follows the rays of a pixel.
#[derive(Debug)]
pub struct Effects<'a> {
    views: &'a ActiveViews<'a>,
    camera_weights: &'a [f32],
    settings: &'a RenderSettings,
    glass: &'a GlassBalls,
    /// Of each ball the view from its centre, alone.
    around: Vec<ActiveViews<'a>>,
    pending: Vec<Pending>,
}

/// How the surface lies that light is divided at.
struct Front {
    point: Vec3,
    patch: Patch,
    /// The ball that it is of.
    ball: Option<usize>,
}

impl<'a> Effects<'a> {
    /// Nothing is followed yet. `glass` are the balls of these views.
    pub fn new(
        views: &'a ActiveViews<'a>,
        camera_weights: &'a [f32],
        settings: &'a RenderSettings,
        glass: &'a GlassBalls,
    ) -> Effects<'a> {
        Effects { views, camera_weights, settings, glass, around: glass.around(), pending: Vec::new() }
    }

    /// The light of a surface that a ray from the eye met.
    pub fn light(&mut self, met: &Met, counters: &mut Counters) -> Vec3 {
        let bounces = self.settings.max_bounces.min(MAX_BOUNCES);
        let mut light = self.divide(&Pending { met: *met, share: 1.0, bounces }, counters);
        while let Some(next) = self.pending.pop() {
            light += self.divide(&next, counters);
        }
        light
    }

    /// Divides the share of a surface among the rays that it sends on, and answers the light of what is left and of
    /// those that meet the background.
    fn divide(&mut self, next: &Pending, counters: &mut Counters) -> Vec3 {
        let Pending { met, share, bounces } = *next;
        let whole = share * met.light;
        if bounces == 0 {
            return whole;
        }
        counters.material_samples += 1;
        let Some(material) = surface_material(self.views, self.camera_weights, met.point) else { return whole };
        counters.normal_evals += 1;
        let Some(front) = self.front(&met, &material) else { return whole };
        let cosine = -met.direction.dot(front.patch.normal);
        if cosine <= 0.0 {
            return whole;
        }
        let material = material.towards(cosine);
        let (mut light, mut left) = (Vec3::ZERO, share);
        if share * material.refract >= LEAST_SHARE {
            let inside = Inside {
                views: self.views,
                camera_weights: self.camera_weights,
                steps: &self.settings.steps,
                whole: front.ball.map(|at| self.glass.balls[at].ball),
            };
            let ray = Ray { origin: front.point, direction: met.direction };
            for (ray, part) in inside.pass(&ray, &front.patch, material.ior, counters).into_iter().flatten() {
                let part = share * material.refract * part;
                if part < LEAST_SHARE {
                    continue;
                }
                if let Some(now) = self.follow(&ray, &front, (part, bounces), counters) {
                    light += now;
                    left -= part;
                }
            }
        }
        if share * material.reflect >= LEAST_SHARE {
            let origin = front.point + LIFT_TEXELS * front.patch.texel_m * front.patch.normal;
            let ray = Ray { origin, direction: reflect(met.direction, front.patch.normal) };
            if let Some(now) = self.follow(&ray, &front, (share * material.reflect, bounces), counters) {
                light += now;
                left -= share * material.reflect;
            }
        }
        light + left.max(0.0) * met.light
    }

    /// How the surface lies that a ray met: that of a ball, if it is of glass and on one, else as views have it.
    fn front(&self, met: &Met, material: &Material) -> Option<Front> {
        let at = if material.refract > 0.0 { self.glass.at(met.point) } else { None };
        let on_ball = || {
            let ball = self.glass.balls[at?].ball;
            let point = ball.entry(&Ray { origin: met.point, direction: met.direction })?;
            // Rays that leave a ball need not be lifted: they are not compared with its own texels.
            let patch = Patch { normal: ball.normal(point)?, curvature: Some(ball.radius_m.recip()), texel_m: 0.0 };
            Some(Front { point, patch, ball: at })
        };
        let by_views = || {
            let patch = patch(self.views, self.camera_weights, met.point)?;
            Some(Front { point: met.point, patch, ball: None })
        };
        on_ball().or_else(by_views)
    }

    /// What a ray with a share brings: light of the background, or for now nothing, where it meets a surface. None where
    /// no view saw anything. `front` is the surface that it leaves.
    fn follow(
        &mut self,
        ray: &Ray,
        front: &Front,
        (share, bounces): (f32, u32),
        counters: &mut Counters,
    ) -> Option<Vec3> {
        counters.secondary_rays += 1;
        let steps = &self.settings.steps;
        let acceleration = self.settings.acceleration;
        let hit = match front.ball {
            Some(at) => intersect(acceleration, &self.around[at], ray, steps, counters),
            None => match self.leave(ray, front.patch.texel_m, counters)? {
                Left::Hit(distance_m) => Some(distance_m),
                Left::Open(first) => {
                    intersect_from(acceleration, self.views, ray, StepsFrom { steps, first }, counters)
                }
            },
        };
        let Some(distance_m) = hit else {
            return match background(self.views, self.camera_weights, ray.direction) {
                Outcome::Seen(light) => Some(share * light),
                Outcome::Hole(_) => None,
            };
        };
        let point = ray.at(distance_m);
        match surface(self.views, self.camera_weights, point, steps.unsure()) {
            Outcome::Seen(light) => {
                let met = Met { point, direction: ray.direction, light };
                self.pending.push(Pending { met, share, bounces: bounces - 1 });
                Some(Vec3::ZERO)
            }
            // What is hidden from all views was seen through the ball.
            Outcome::Hole(_) => {
                let seen = surface_color(&self.around[front.ball?], &[1.0], point)?;
                Some(share * light_of(self.views.coding, seen.color))
            }
        }
    }

    /// How a ray that starts in a surface, or shortly behind one, comes into the open. It is looked at in texels before the
    /// steps begin: they are as the eye needs them, and the first may be far beyond what the ray meets. None where it stays
    /// hidden for too long.
    fn leave(&self, ray: &Ray, texel_m: f32, counters: &mut Counters) -> Option<Left> {
        let steps = &self.settings.steps;
        let mut open_m = None;
        for (distance_m, step) in steps.from_surface(texel_m) {
            counters.march_steps += 1;
            match (self.views.is_surface(ray.at(distance_m)), open_m, step) {
                (true, Some(open_m), _) => {
                    let interval_m = [open_m, distance_m];
                    return Some(Left::Hit(self.views.refine(ray, interval_m, steps.refine, counters)));
                }
                (true, None, _) if distance_m > HIDDEN_TEXELS * texel_m => return None,
                (true, None, _) => {}
                (false, _, Some(first)) => return Some(Left::Open(first)),
                (false, _, None) => open_m = Some(distance_m),
            }
        }
        None
    }
}
