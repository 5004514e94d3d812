//! The way of a ray through glass (CALF 6.1): where it leaves a solid that it entered, and in which direction.
//!
//! Enters: the point of entry, what is known of the surface there, and the ray's direction. Leaves: the ray that goes on.
//!
//! Depths end at the front of a solid. Its back is one of these, the first that holds:
//!
//! - What a view on the other side sees: the ray is followed until a view sees past a point, and a view sees a surface there.
//! - A ball that touches the front and is bent as it is. It is cut off where a view sees past it.
//! - Nothing, where the front is flat or hollow: a pane, behind which the ray goes on as it came.

use glam::Vec3;

use crate::reconstruct::active_views::ActiveViews;
use crate::reconstruct::counters::Counters;
use crate::reconstruct::march::{Ray, Steps, refine};
use crate::reconstruct::material::{fresnel, surface_material};
use crate::reconstruct::normal::{Patch, patch};

/// A front that turns by less than this over a texel is flat.
pub const FLAT: f32 = 2e-3;
/// How far behind a surface the ray is looked at for whether the surface is a pane, in texels.
pub const BEHIND_TEXELS: f32 = 3.0;
/// How often a ray meets the back of a solid before the rest of its light is given up.
pub const MAX_INSIDE: usize = 3;

/// Rays that leave a solid, with their parts of the light that entered.
pub type Exits = [Option<(Ray, f32)>; MAX_INSIDE];

/// The direction behind a surface whose normal is on the side that the ray comes from; `ratio` is the index of refraction
/// before the surface over that behind it. None in total reflection.
pub fn refract(direction: Vec3, normal: Vec3, ratio: f32) -> Option<Vec3> {
    let cosine = (-direction.dot(normal)).clamp(0.0, 1.0);
    let behind_squared = 1.0 - ratio * ratio * (1.0 - cosine * cosine);
    if behind_squared <= 0.0 {
        return None;
    }
    (ratio * direction + (ratio * cosine - behind_squared.sqrt()) * normal).try_normalize()
}

/// The direction in which a mirror sends a ray on.
pub fn reflect(direction: Vec3, normal: Vec3) -> Vec3 {
    direction - 2.0 * direction.dot(normal) * normal
}

/// What is looked at on the way.
#[derive(Debug, Clone, Copy)]
pub struct Inside<'a> {
    /// The views.
    pub views: &'a ActiveViews<'a>,
    /// Their weights ([`super::interpolate::camera_weights`]).
    pub camera_weights: &'a [f32],
    /// Where rays are looked at.
    pub steps: &'a Steps,
}

impl Inside<'_> {
    /// The rays that leave a solid of index `ior` which `ray` meets in its origin, where its surface is `front` with its
    /// normal on the ray's side: the one that goes straight through, and those that are reflected inside before. With each,
    /// its part of the light that entered; those that stay inside are left out.
    pub fn pass(&self, ray: &Ray, front: &Patch, ior: f32, counters: &mut Counters) -> Exits {
        let mut exits = Exits::default();
        let Ray { origin, direction } = *ray;
        let Some(bend) = front.curvature else { return exits };
        let open_behind = !self.views.is_surface(origin + direction * (BEHIND_TEXELS * front.texel_m));
        if open_behind && bend * front.texel_m < -FLAT {
            // A hollow with open space behind it: the ray was inside, and leaves.
            exits[0] = refract(direction, front.normal, ior).map(|direction| (Ray { origin, direction }, 1.0));
            return exits;
        }
        let Some(direction) = refract(direction, front.normal, ior.recip()) else { return exits };
        let mut inside = Ray { origin, direction };
        let ball = (bend * front.texel_m > FLAT).then(|| {
            let radius = bend.recip();
            (origin - radius * front.normal, radius)
        });
        let mut share = 1.0;
        for exit in &mut exits {
            let Some((end, normal)) = self.back(&inside, ball, counters) else {
                // A pane.
                if ball.is_none() && share == 1.0 {
                    *exit = Some((*ray, share));
                }
                break;
            };
            let mut reflected = 1.0;
            if let Some(direction) = refract(inside.direction, -normal, ior) {
                reflected = fresnel(direction.dot(normal), ior);
                *exit = Some((Ray { origin: end, direction }, share * (1.0 - reflected)));
            }
            share *= reflected;
            inside = Ray { origin: end, direction: reflect(inside.direction, -normal) };
        }
        exits
    }

    /// Where a ray inside of a solid meets its back, and the normal there, which points out of the solid.
    fn back(&self, inside: &Ray, ball: Option<(Vec3, f32)>, counters: &mut Counters) -> Option<(Vec3, Vec3)> {
        let chord_m = ball.map(|(centre, _)| 2.0 * inside.direction.dot(centre - inside.origin));
        let open = self.first_open(inside, chord_m.map_or(f32::INFINITY, |chord_m| 2.0 * chord_m), counters);
        if let Some(open_m) = open {
            let end = inside.at(open_m);
            counters.normal_evals += 1;
            let glass = surface_material(self.views, self.camera_weights, end).is_some_and(|seen| seen.refract > 0.0);
            if glass
                && let Some(seen) = patch(self.views, self.camera_weights, end)
                && seen.normal.dot(inside.direction) > 0.0
            {
                return Some((end, seen.normal));
            }
        }
        let (centre, _) = ball?;
        let end = inside.at(chord_m?.min(open.unwrap_or(f32::INFINITY)));
        Some((end, (end - centre).try_normalize()?))
    }

    /// The distance, up to a limit, from which on a view sees past the ray.
    fn first_open(&self, ray: &Ray, limit_m: f32, counters: &mut Counters) -> Option<f32> {
        let mut before_m = 0.0;
        for &distance_m in self.steps.distances_m.iter().take_while(|&&distance_m| distance_m <= limit_m) {
            counters.march_steps += 1;
            if !self.views.is_surface(ray.at(distance_m)) {
                // Refining goes from what is open to a surface, which is from behind here.
                return Some(refine(self.views, ray, [distance_m, before_m], self.steps.refine, counters));
            }
            before_m = distance_m;
        }
        None
    }
}
