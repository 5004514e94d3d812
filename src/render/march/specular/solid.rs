//! Refraction through a solid (CALF 6.1): where a ray that has entered the solid leaves it, and in which direction.
//!
//! Depths show the front of a solid. Its back is the first of these that applies:
//!
//! - The back of the refractive proxy, if the solid has one.
//! - The surface that a view on the other side sees: the first point of the ray that is empty in a view, if it lies on a
//!   refractive surface.
//! - A sphere that touches the front and has its curvature, cut off where a view sees past it.
//! - None, if the front is flat or concave: the solid is a pane, which the ray passes unchanged.

use glam::Vec3;

use crate::march::{ActiveViews, Counters, Patch, Ray, Sphere, Steps, fresnel, patch, surface_material};

/// Maximum rotation of the normal over a texel of a flat front, in radians.
pub const FLAT: f32 = 2e-3;
/// Distance behind a concave front, in texels, at which empty space means that the ray was inside the solid and leaves it.
pub const BEHIND_TEXELS: f32 = 3.0;
/// Maximum number of times that a ray meets the back of a solid, including the first; the remaining light is discarded.
pub const MAX_INSIDE: usize = 3;

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Exit {
    /// The origin is on the back of the solid.
    pub ray: Ray,
    /// Fraction of the light that entered the solid.
    pub part: f32,
}

/// Returns the refracted direction behind a surface whose normal is on the ray's side. `ratio` is the index of refraction before
/// the surface over that behind it. None in total internal reflection.
pub fn refract(direction: Vec3, normal: Vec3, ratio: f32) -> Option<Vec3> {
    let cosine = (-direction.dot(normal)).clamp(0.0, 1.0);
    let behind_squared = 1.0 - ratio * ratio * (1.0 - cosine * cosine);
    if behind_squared <= 0.0 {
        return None;
    }
    (ratio * direction + (ratio * cosine - behind_squared.sqrt()) * normal).try_normalize()
}

pub fn reflect(direction: Vec3, normal: Vec3) -> Vec3 {
    direction - 2.0 * direction.dot(normal) * normal
}

/// Point where a ray inside a solid meets its back.
struct Back {
    point: Vec3,
    /// Outward unit normal.
    normal: Vec3,
}

#[derive(Debug, Clone, Copy)]
pub struct Refraction<'a> {
    pub views: &'a ActiveViews<'a>,
    pub steps: &'a Steps,
    pub proxy: Option<Sphere>,
}

impl Refraction<'_> {
    /// Returns the rays that leave a solid of index `ior`: the direct one, then those after internal reflections. `ray` enters
    /// the solid at its origin; `front` is the surface at that point, with the normal on the ray's side.
    pub fn pass(&self, ray: &Ray, front: &Patch, ior: f32, counters: &mut Counters) -> [Option<Exit>; MAX_INSIDE] {
        let mut exits = [None; MAX_INSIDE];
        let Ray { origin, direction } = *ray;
        let Some(curvature) = front.curvature else { return exits };
        let bend = curvature * front.texel_m;
        let behind = || origin + direction * (BEHIND_TEXELS * front.texel_m);
        if self.proxy.is_none() && bend < -FLAT && !self.views.is_surface(behind()) {
            // Concave with empty space behind it: the ray was inside and leaves.
            let leaves = refract(direction, front.normal, ior);
            exits[0] = leaves.map(|direction| Exit { ray: Ray { origin, direction }, part: 1.0 });
            return exits;
        }
        let Some(direction) = refract(direction, front.normal, ior.recip()) else { return exits };
        let mut inside = Ray { origin, direction };
        let touching = || {
            let radius_m = curvature.recip();
            Sphere { centre: origin - radius_m * front.normal, radius_m }
        };
        let sphere = self.proxy.or_else(|| (bend > FLAT).then(touching));
        let mut share = 1.0;
        for (turn, exit) in exits.iter_mut().enumerate() {
            let Some(Back { point, normal }) = self.back(&inside, sphere, front.texel_m, counters) else {
                if sphere.is_none() && turn == 0 {
                    *exit = Some(Exit { ray: *ray, part: share });
                }
                break;
            };
            let mut reflected = 1.0;
            if let Some(direction) = refract(inside.direction, -normal, ior) {
                reflected = fresnel(direction.dot(normal), ior);
                *exit = Some(Exit { ray: Ray { origin: point, direction }, part: share * (1.0 - reflected) });
            }
            share *= reflected;
            inside = Ray { origin: point, direction: reflect(inside.direction, -normal) };
        }
        exits
    }

    fn back(&self, inside: &Ray, sphere: Option<Sphere>, texel_m: f32, counters: &mut Counters) -> Option<Back> {
        let chord_m = match sphere {
            Some(sphere) => Some(sphere.exit_m(inside)?),
            None => None,
        };
        let limit_m = chord_m.map_or(f32::INFINITY, |chord_m| 2.0 * chord_m);
        let empty_m = match self.proxy {
            Some(_) => None,
            None => self.first_empty(inside, texel_m, limit_m, counters),
        };
        if let Some(empty_m) = empty_m {
            let point = inside.at(empty_m);
            counters.normal_evals += 1;
            if surface_material(self.views, point).is_some_and(|seen| seen.refract > 0.0)
                && let Some(seen) = patch(self.views, point)
                && seen.normal.dot(inside.direction) > 0.0
            {
                return Some(Back { point, normal: seen.normal });
            }
        }
        let point = inside.at(chord_m?.min(empty_m.unwrap_or(f32::INFINITY)));
        Some(Back { point, normal: sphere?.normal(point)? })
    }

    /// Returns the distance, up to a limit, of the first point that is empty in a view.
    fn first_empty(&self, ray: &Ray, texel_m: f32, limit_m: f32, counters: &mut Counters) -> Option<f32> {
        let mut before_m = 0.0;
        let distances_m = self.steps.off_surface(texel_m).map(|(distance_m, _)| distance_m);
        for distance_m in distances_m.take_while(|&distance_m| distance_m <= limit_m) {
            counters.march_steps += 1;
            if !self.views.is_surface(ray.at(distance_m)) {
                // The surface is at the near end of this interval.
                return Some(self.views.refine(ray, [distance_m, before_m], self.steps.refine(), counters));
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
    use crate::march::synthetic::SyntheticProbe;
    use crate::march::tests::field;
    use crate::views::light_field::{ColorCoding, LightField};
    use codec::image::transfer::ToneMap;

    #[test]
    fn directions_bend_as_snell_has_it() {
        let sine = 0.6f32;
        let down = Vec3::new(sine, 0.0, -0.8);
        let inside = refract(down, Vec3::Z, 1.0 / 1.5).unwrap();
        assert!((inside.x - sine / 1.5).abs() < 1e-6 && inside.z < 0.0);
        // On leaving, the ray regains its original direction, up to the critical angle.
        assert!(refract(inside, Vec3::Z, 1.5).unwrap().distance(down) < 1e-6);
        assert_eq!(refract(Vec3::new(0.7, 0.0, -0.51f32.sqrt()), Vec3::Z, 1.5), None);
        assert_eq!(reflect(down, Vec3::Z), Vec3::new(sine, 0.0, 0.8));
    }

    /// An infinite wedge of glass. Its front is the plane z = 0, which the first view sees; its back is the plane x + z = −1,
    /// which the second view sees.
    fn wedge() -> LightField {
        let coding = ColorCoding::Codes(ToneMap::default());
        let plane = |at: DVec3, normal: DVec3, part: f64| {
            let sight = move |to: DVec3| {
                let distance_m = (part - at.dot(normal)) / to.dot(normal);
                (distance_m > 0.0 && distance_m < 90.0).then_some((distance_m, [100, 100, 100]))
            };
            SyntheticProbe::new(at, 64).cube(coding, &sight)
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

    fn through_the_wedge(ior: f32) -> [Option<Exit>; MAX_INSIDE] {
        let light_field = wedge();
        let views = ActiveViews::new(&light_field, &[0, 1], DVec3::new(0.0, 0.0, 1.0));
        let steps = Steps::new(512, 0.01, 60.0, 12);
        let refraction = Refraction { views: &views, steps: &steps, proxy: None };
        let ray = Ray { origin: Vec3::NEG_Z, direction: Vec3::NEG_Z };
        let front = patch(&views, ray.origin).unwrap();
        assert!(front.normal.distance(Vec3::Z) < 1e-3);
        refraction.pass(&ray, &front, ior, &mut Counters::default())
    }

    #[test]
    fn a_wedge_of_no_index_lets_everything_through() {
        let [Some(Exit { ray, part }), rest @ ..] = through_the_wedge(1.0) else { panic!("nothing comes out") };
        assert!(ray.direction.distance(Vec3::NEG_Z) < 1e-3 && ray.origin.distance(Vec3::new(0.0, 0.0, -2.0)) < 0.02);
        assert!(part > 0.999);
        assert!(rest.iter().flatten().all(|exit| exit.part < 1e-3));
    }

    /// A ray that is totally reflected and then finds no back has not passed through a pane.
    #[test]
    fn total_reflection_lets_nothing_through() {
        assert!(through_the_wedge(1.5).iter().all(Option::is_none));
        // Below the critical angle some light leaves, in a different direction.
        let [Some(Exit { ray, part }), ..] = through_the_wedge(1.2) else { panic!("nothing comes out") };
        assert!(part > 0.5 && ray.direction.angle_between(Vec3::NEG_Z).to_degrees() > 10.0);
    }
}
