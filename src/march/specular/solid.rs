//! The way of a ray through glass (CALF 6.1): where it leaves a solid that it entered, and in which direction.
//!
//! Enters: the point of entry, what is known of the surface there, and the ray's direction. Leaves: the ray that goes on.
//!
//! Depths end at the front of a solid. Its back is one of these, the first that holds:
//!
//! - Of a ball that is known as a whole (`glass_balls`), the ball's.
//! - What a view on the other side sees: the ray is followed until a view sees past a point, and a view sees a surface there.
//! - A ball that touches the front and is bent as it is. It is cut off where a view sees past it.
//! - Nothing, where the front is flat or hollow: a pane, behind which the ray goes on as it came.

use glam::Vec3;

use crate::march::active_views::ActiveViews;
use crate::march::counters::Counters;
use crate::march::ray::{Ray, Steps};
use crate::march::specular::material::{fresnel, surface_material};
use crate::march::specular::normal::{Patch, patch};

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

/// A ball that stands for a solid of which only the front is known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ball {
    /// Metres from the eye.
    pub centre: Vec3,
    /// Metres, above 0.
    pub radius_m: f32,
}

impl Ball {
    /// Where a ray that comes from outside first meets the ball, which may be before or behind its origin. None where it
    /// passes by.
    pub fn entry(&self, ray: &Ray) -> Option<Vec3> {
        let from_centre = ray.origin - self.centre;
        let along = ray.direction.dot(from_centre);
        let squared = along * along - (from_centre.length_squared() - self.radius_m * self.radius_m);
        (squared > 0.0).then(|| ray.at(-along - squared.sqrt()))
    }

    /// The direction out of the ball at a point on it, of length 1.
    pub fn normal(&self, point: Vec3) -> Option<Vec3> {
        (point - self.centre).try_normalize()
    }

    /// How far a ray, which need not start on the ball, goes until it leaves it for good. None where it does not go
    /// through it.
    pub fn exit_m(&self, ray: &Ray) -> Option<f32> {
        let from_centre = ray.origin - self.centre;
        let along = ray.direction.dot(from_centre);
        let squared = along * along - (from_centre.length_squared() - self.radius_m * self.radius_m);
        let exit_m = squared.max(0.0).sqrt() - along;
        (squared >= 0.0 && exit_m > 0.0).then_some(exit_m)
    }
}

/// What is looked at on the way.
#[derive(Debug, Clone, Copy)]
pub struct Inside<'a> {
    /// The views.
    pub views: &'a ActiveViews<'a>,
    /// Their weights ([`crate::march::interpolate::camera_weights`]).
    pub camera_weights: &'a [f32],
    /// Where rays are looked at.
    pub steps: &'a Steps,
    /// The ball that the solid is known to be, whole ([`crate::march::specular::sphere_fit`]): no view has to be asked for its back.
    pub whole: Option<Ball>,
}

impl Inside<'_> {
    /// The rays that leave a solid of index `ior` which `ray` meets in its origin, where its surface is `front` with its
    /// normal on the ray's side: the one that goes straight through, and those that are reflected inside before. With each,
    /// its part of the light that entered; those that stay inside are left out.
    pub fn pass(&self, ray: &Ray, front: &Patch, ior: f32, counters: &mut Counters) -> Exits {
        let mut exits = Exits::default();
        let Ray { origin, direction } = *ray;
        let Some(bend) = front.curvature else { return exits };
        let open_behind =
            self.whole.is_none() && !self.views.is_surface(origin + direction * (BEHIND_TEXELS * front.texel_m));
        if open_behind && bend * front.texel_m < -FLAT {
            // A hollow with open space behind it: the ray was inside, and leaves.
            exits[0] = refract(direction, front.normal, ior).map(|direction| (Ray { origin, direction }, 1.0));
            return exits;
        }
        let Some(direction) = refract(direction, front.normal, ior.recip()) else { return exits };
        let mut inside = Ray { origin, direction };
        let touching = || {
            let radius_m = bend.recip();
            Ball { centre: origin - radius_m * front.normal, radius_m }
        };
        let ball = self.whole.or_else(|| (bend * front.texel_m > FLAT).then(touching));
        let mut share = 1.0;
        for (turn, exit) in exits.iter_mut().enumerate() {
            let Some((end, normal)) = self.back(&inside, ball, front.texel_m, counters) else {
                // A pane.
                if ball.is_none() && turn == 0 {
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
    fn back(&self, inside: &Ray, ball: Option<Ball>, texel_m: f32, counters: &mut Counters) -> Option<(Vec3, Vec3)> {
        let chord_m = match ball {
            Some(ball) => Some(ball.exit_m(inside)?),
            None => None,
        };
        let limit_m = chord_m.map_or(f32::INFINITY, |chord_m| 2.0 * chord_m);
        let open = match self.whole {
            Some(_) => None,
            None => self.first_open(inside, texel_m, limit_m, counters),
        };
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
        let end = inside.at(chord_m?.min(open.unwrap_or(f32::INFINITY)));
        Some((end, ball?.normal(end)?))
    }

    /// The distance, up to a limit, from which on a view sees past the ray.
    fn first_open(&self, ray: &Ray, texel_m: f32, limit_m: f32, counters: &mut Counters) -> Option<f32> {
        let mut before_m = 0.0;
        let distances_m = self.steps.from_surface(texel_m).map(|(distance_m, _)| distance_m);
        for distance_m in distances_m.take_while(|&distance_m| distance_m <= limit_m) {
            counters.march_steps += 1;
            if !self.views.is_surface(ray.at(distance_m)) {
                // Refining goes from what is open to a surface, which is from behind here.
                return Some(self.views.refine(ray, [distance_m, before_m], self.steps.refine, counters));
            }
            before_m = distance_m;
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::image::transfer::ToneMap;
    use crate::march::interpolate::camera_weights;
    use crate::march::synthetic::{Made, field};
    use crate::views::light_field::{ColorCoding, LightField};

    #[test]
    fn rays_leave_balls_ahead() {
        let ball = Ball { centre: Vec3::new(0.0, 0.0, -3.0), radius_m: 2.0 };
        let exit = |z: f32, direction: Vec3| ball.exit_m(&Ray { origin: Vec3::new(0.0, 0.0, z), direction });
        // From the ball, from within, and from before it.
        assert_eq!(exit(-1.0, Vec3::NEG_Z), Some(4.0));
        assert_eq!(exit(-4.0, Vec3::NEG_Z), Some(1.0));
        assert_eq!(exit(-4.0, Vec3::Z), Some(3.0));
        assert_eq!(exit(0.0, Vec3::NEG_Z), Some(5.0));
        assert!((exit(-3.0, Vec3::X).unwrap() - 2.0).abs() < 1e-6);
        // Away from it, along it, and beside it.
        assert_eq!(exit(0.0, Vec3::Z), None);
        assert_eq!(exit(-1.0, Vec3::Z), None);
        assert_eq!(exit(0.0, Vec3::X), None);
    }

    #[test]
    fn directions_bend_as_snell_has_it() {
        let sine = 0.6f32;
        let down = Vec3::new(sine, 0.0, -0.8);
        let inside = refract(down, Vec3::Z, 1.0 / 1.5).unwrap();
        assert!((inside.x - sine / 1.5).abs() < 1e-6 && inside.z < 0.0);
        // On the way out it becomes what it was, up to the angle from which on nothing comes out.
        assert!(refract(inside, Vec3::Z, 1.5).unwrap().distance(down) < 1e-6);
        assert_eq!(refract(Vec3::new(0.7, 0.0, -0.51f32.sqrt()), Vec3::Z, 1.5), None);
        assert_eq!(reflect(down, Vec3::Z), Vec3::new(sine, 0.0, 0.8));
    }

    /// A wedge of glass without end: its front is the plane z = 0, which the first view sees, its back x + z = -1, which
    /// the second one sees.
    fn wedge() -> LightField {
        let coding = ColorCoding::Codes(ToneMap::default());
        let plane = |at: DVec3, normal: DVec3, part: f64| {
            let sight = move |to: DVec3| {
                let distance_m = (part - at.dot(normal)) / to.dot(normal);
                (distance_m > 0.0 && distance_m < 90.0).then_some((distance_m, [100, 100, 100]))
            };
            Made::new(at, 64).cube(coding, &sight)
        };
        let slanted = DVec3::new(-1.0, 0.0, -1.0).normalize();
        let mut views = vec![
            plane(DVec3::new(0.0, 0.0, 2.0), DVec3::Z, 0.0),
            plane(DVec3::new(-2.0, 0.0, -2.0), slanted, 0.5f64.sqrt()),
        ];
        for face in views.iter_mut().flat_map(|view| view.faces.iter_mut().flatten()) {
            face.material = Some(vec![[0, 255, 64, 0]; face.inverse_depth.len()]);
            face.update_specular();
        }
        field(views, coding)
    }

    fn through_the_wedge(ior: f32) -> Exits {
        let light_field = wedge();
        let views = ActiveViews::new(&light_field, &[0, 1], DVec3::new(0.0, 0.0, 1.0));
        let weights = camera_weights(&views);
        let steps = Steps::new(512, 0.01, 60.0, 12);
        let inside = Inside { views: &views, camera_weights: &weights, steps: &steps, whole: None };
        let ray = Ray { origin: Vec3::NEG_Z, direction: Vec3::NEG_Z };
        let front = patch(&views, &weights, ray.origin).unwrap();
        assert!(front.normal.distance(Vec3::Z) < 1e-3);
        inside.pass(&ray, &front, ior, &mut Counters::default())
    }

    #[test]
    fn a_wedge_of_no_index_lets_everything_through() {
        let [Some((ray, part)), rest @ ..] = through_the_wedge(1.0) else { panic!("nothing comes out") };
        assert!(ray.direction.distance(Vec3::NEG_Z) < 1e-3 && ray.origin.distance(Vec3::new(0.0, 0.0, -2.0)) < 0.02);
        assert!(part > 0.999);
        assert!(rest.iter().flatten().all(|(_, part)| *part < 1e-3));
    }

    /// What is reflected whole, and then finds no back, has not passed a pane.
    #[test]
    fn total_reflection_lets_nothing_through() {
        assert!(through_the_wedge(1.5).iter().all(Option::is_none));
        // Below the critical angle some comes out, and not in the direction in which it came.
        let [Some((ray, part)), ..] = through_the_wedge(1.2) else { panic!("nothing comes out") };
        assert!(part > 0.5 && ray.direction.angle_between(Vec3::NEG_Z).to_degrees() > 10.0);
    }
}
