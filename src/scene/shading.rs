//! Radiance of a surface: Lambert and Phong under suns, lamps and an ambient sky, with hard shadows; mirrors and clear glass by
//! recursive rays.
//!
//! Reflected and refracted rays are traced only for mirrors and glass. Shadow rays pass clear glass, and there are no caustics:
//! real glass refracts light, so a straight shadow would be too dark nearly everywhere.

mod occlusion;
#[cfg(test)]
mod tests;

use glam::DVec3;

use super::light::Lamp;
use super::mesh_scene::{Optics, Phong};
use super::object::Object;
use super::raycast::SceneAtTime;
use super::shadow_cube::ShadowCube;
use super::surface::Surface;
use crate::mesh::Ray;

/// Maximum reflections and refractions on a path; longer paths end in the ambient light.
pub const MAX_BOUNCES: u32 = 8;
/// Paths of less weight also end in the ambient light.
const MIN_WEIGHT: f64 = 1e-4;

/// Weight of reflection, weight of refraction and index of refraction of an opaque surface.
pub const OPAQUE: [f64; 3] = [0.0, 0.0, 1.0];

/// State of a path.
#[derive(Debug, Clone, Copy)]
pub(super) struct Path {
    bounces: u32,
    /// Fraction of the path's radiance that reaches the eye.
    weight: f64,
}

impl Path {
    pub(super) const FIRST: Path = Path { bounces: 0, weight: 1.0 };
}

#[cfg(test)]
thread_local! {
    /// Number of reflected and refracted rays traced by this thread.
    pub(super) static SECONDARY_RAYS: std::cell::Cell<u64> = const { std::cell::Cell::new(0) };
}

/// Radiance of a surface towards an eye.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Radiance {
    /// View-independent part: emission and diffuse reflection.
    pub steady: DVec3,
    /// View-dependent part: highlights; all radiance of mirrors and glass.
    pub of_eye: DVec3,
}

impl Radiance {
    pub fn total(&self) -> DVec3 {
        self.steady + self.of_eye
    }
}

/// Highlights of an opaque surface, for any eye on the side that it was seen from; stores the lights that reach the surface.
#[derive(Debug, Clone)]
pub struct Gloss {
    pub point: DVec3,
    /// Shading normal, length 1.
    pub normal: DVec3,
    phong: Phong,
    /// Radiance that each sun and lamp causes on a white matte surface, and the direction towards the light.
    lights: Box<[(DVec3, DVec3)]>,
    ambient: DVec3,
}

impl Gloss {
    /// Returns its size in bytes.
    pub fn bytes(&self) -> u64 {
        (size_of::<Gloss>() + size_of_val(&self.lights[..])) as u64
    }

    /// Returns the radiance of the highlights towards an eye.
    pub fn towards(&self, eye: DVec3) -> DVec3 {
        let Some(direction) = (self.point - eye).try_normalize() else { return DVec3::ZERO };
        let mirrored = reflect(direction, self.normal);
        let lobes = self.lights.iter().map(|&(light, towards)| self.phong.lobe(mirrored.dot(towards)) * light);
        self.phong.weight * (lobes.sum::<DVec3>() + ambient(self.ambient, mirrored))
    }

    /// Returns the unit mirror directions of the lights: an eye in one of them sees that light's highlight at its peak.
    pub fn mirrored(&self) -> impl Iterator<Item = DVec3> + '_ {
        self.lights.iter().map(|&(_, towards)| -reflect(towards, self.normal))
    }
}

/// Radiance reflected by a white matte surface, and by a Phong lobe of weight 1.
struct Reflected {
    matt: DVec3,
    gloss: DVec3,
}

impl SceneAtTime {
    /// Returns the radiance towards the origin of a ray in `direction`.
    pub(super) fn radiance(&self, surface: &Surface, direction: DVec3, path: Path) -> Radiance {
        let of_eye = match surface.optics {
            Optics::Opaque => return self.lit(surface, direction),
            Optics::Mirror { tint } => {
                let normal = surface.optical_normal(direction);
                let reflected = reflect(direction, normal);
                let seen = self.along(surface, surface.side, reflected, path.on(tint.max_element()));
                surface.emission + tint * seen + self.highlights(surface, direction)
            }
            Optics::Glass { ior, tint } => {
                let normal = surface.optical_normal(direction);
                let Fresnel { reflectance: share, refracted } = surface.fresnel(direction, normal, ior);
                let mut light = surface.emission + self.highlights(surface, direction);
                if share > 0.0 {
                    let reflected = reflect(direction, normal);
                    light += share * self.along(surface, surface.side, reflected, path.on(share));
                }
                if let Some(refracted) = refracted {
                    let passes = (1.0 - share) * tint;
                    let path = path.on(passes.max_element());
                    light += passes * self.along(surface, -surface.side, refracted, path);
                }
                light
            }
        };
        Radiance { steady: DVec3::ZERO, of_eye }
    }

    /// Returns the highlights of a surface; `None` if it has none, or is a mirror or glass.
    pub(super) fn gloss(&self, surface: &Surface) -> Option<Gloss> {
        if surface.unlit || surface.phong.is_matt() || surface.optics != Optics::Opaque {
            return None;
        }
        let mut lights = Vec::new();
        self.direct_lights(surface, |light, towards| lights.push((light, towards)));
        let Surface { point, normal, phong, .. } = *surface;
        let lights = lights.into_boxed_slice();
        Some(Gloss { point, normal, phong, lights, ambient: self.light.sky.ambient })
    }

    /// Returns the radiance that arrives from `direction` on the side of `out`.
    fn along(&self, surface: &Surface, out: DVec3, direction: DVec3, path: Path) -> DVec3 {
        if path.bounces > MAX_BOUNCES || path.weight < MIN_WEIGHT {
            return self.light.sky.ambient;
        }
        #[cfg(test)]
        SECONDARY_RAYS.with(|count| count.set(count.get() + 1));
        let ray = Ray::from_unit(surface.point + self.lift(surface.point) * out, direction);
        match self.first_hit(&ray, self.on_path(&ray)) {
            None => self.light.sky.radiance(direction),
            Some(hit) => self.radiance(&self.surface(&ray, &hit), direction, path).total(),
        }
    }

    fn lit(&self, surface: &Surface, direction: DVec3) -> Radiance {
        if surface.unlit {
            return Radiance { steady: surface.emission + surface.albedo, of_eye: DVec3::ZERO };
        }
        let light = self.arriving(surface, direction);
        let steady = surface.emission + surface.albedo * light.matt;
        Radiance { steady, of_eye: surface.phong.weight * light.gloss }
    }

    /// Returns the Phong highlights of mirrors and glass.
    fn highlights(&self, surface: &Surface, direction: DVec3) -> DVec3 {
        if surface.phong.is_matt() {
            return DVec3::ZERO;
        }
        surface.phong.weight * self.direct_upon(surface, direction, DVec3::ZERO).gloss
    }

    /// Returns the ambient and direct light, reflected by a white matte surface and by a Phong lobe of weight 1. The ambient
    /// light is uniform, so a lobe reflects as much of it as a matte surface.
    fn arriving(&self, surface: &Surface, direction: DVec3) -> Reflected {
        let sky = self.light.sky.ambient;
        let open = occlusion::open_part(self, surface);
        let mut light = self.direct_upon(surface, direction, ambient(sky, surface.normal) * open);
        if !surface.phong.is_matt() {
            light.gloss += ambient(sky, reflect(direction, surface.normal));
        }
        light
    }

    /// Adds the direct light of each sun and lamp to `matt`; also returns its glossy reflection.
    fn direct_upon(&self, surface: &Surface, direction: DVec3, mut matt: DVec3) -> Reflected {
        let mut gloss = DVec3::ZERO;
        let mirrored = (!surface.phong.is_matt()).then(|| reflect(direction, surface.normal));
        self.direct_lights(surface, |light, towards| {
            matt += light;
            if let Some(mirrored) = mirrored {
                gloss += surface.phong.lobe(mirrored.dot(towards)) * light;
            }
        });
        Reflected { matt, gloss }
    }

    /// Calls `add` for each sun and lamp that reaches a surface, with the radiance on a white matte surface and the direction
    /// towards the light.
    fn direct_lights(&self, surface: &Surface, mut add: impl FnMut(DVec3, DVec3)) {
        let above = surface.point + self.lift(surface.point) * surface.side;
        for (sun, shadows) in self.light.suns.iter().zip(&self.shadows) {
            let facing = surface.normal.dot(sun.direction);
            // Interpolated normals may face a light that is behind the surface.
            let lit = facing > 0.0 && surface.side.dot(sun.direction) > 0.0;
            if lit && !(self.light_rays.shadows && self.in_sun_shadow(sun.direction, shadows, above)) {
                add(facing * sun.radiance, sun.direction);
            }
        }
        for (lamp, shadows) in self.light.lamps.iter().zip(&self.lamp_shadows) {
            if let Some((light, towards)) = self.lamp_light((lamp, shadows), above, surface) {
                add(light, towards);
            }
        }
    }

    /// Returns the radiance that a lamp causes on a white matte surface, and the direction to the lamp.
    fn lamp_light(
        &self,
        (lamp, shadows): (&Lamp, &ShadowCube),
        point: DVec3,
        surface: &Surface,
    ) -> Option<(DVec3, DVec3)> {
        let to_lamp = lamp.position - point;
        let squared = to_lamp.length_squared();
        let reach = lamp.reach * lamp.reach;
        let cosine = surface.normal.dot(to_lamp);
        // Out of range, behind the surface, or so close to the lamp that there is no direction.
        let lift = self.lift(point);
        if squared >= reach || cosine <= 0.0 || surface.side.dot(to_lamp) <= 0.0 || squared < lift * lift {
            return None;
        }
        let distance = squared.sqrt();
        let towards = to_lamp / distance;
        let strength = lamp.cone.map_or(1.0, |cone| cone.strength(-towards));
        let is_shadowed = || {
            let casters = shadows.casters(point).iter().map(|&index| &self.objects[index]);
            self.light_rays.shadows && self.any_stops(casters, &Ray::from_unit(point, towards), distance)
        };
        if strength <= 0.0 || is_shadowed() {
            return None;
        }
        let [one, other] = lamp.window.factors(squared, reach);
        let fall_off = cosine / distance * one * other / squared.max(self.lamp_core());
        Some((lamp.radiance * fall_off * strength, towards))
    }

    /// True if a shadow caster is within the first `length` metres of a ray.
    fn light_stopped(&self, ray: &Ray, length: f64) -> bool {
        let casters = self.objects.iter().filter(|object| object.is_occluder());
        self.any_stops(casters, ray, length)
    }

    /// True if one of the casters or a mesh is within the first `length` metres of a ray.
    fn any_stops<'a>(&self, mut casters: impl Iterator<Item = &'a Object>, ray: &Ray, length: f64) -> bool {
        casters.any(|object| {
            object.bounds.intersect(ray, 0.0).is_some()
                && object.shape.intersect(ray, 0.0).is_some_and(|hit| hit.distance < length)
        }) || self.meshes.iter().any(|mesh| mesh.casts_shadow(ray, 0.0..length))
    }

    fn in_sun_shadow(&self, sun: DVec3, shadows: &super::shadow_grid::ShadowGrid, point: DVec3) -> bool {
        let ray = Ray::from_unit(point, sun);
        shadows.casters(point).iter().any(|&index| self.objects[index].shape.intersect(&ray, 0.0).is_some())
            || self.meshes.iter().any(|mesh| mesh.casts_shadow(&ray, 0.0..f64::INFINITY))
    }
}

impl Path {
    fn on(self, share: f64) -> Path {
        Path { bounces: self.bounces + 1, weight: self.weight * share }
    }
}

impl Phong {
    pub fn is_matt(&self) -> bool {
        self.weight == DVec3::ZERO
    }

    /// Returns the reflectance at this cosine from the mirror direction, relative to a white surface.
    fn lobe(&self, cosine: f64) -> f64 {
        if cosine <= 0.0 { 0.0 } else { 0.5 * (self.exponent + 2.0) * cosine.powf(self.exponent) }
    }
}

/// Reflection and refraction at the surface of glass.
struct Fresnel {
    /// Reflectance for unpolarised light.
    reflectance: f64,
    /// Refracted direction; `None` in total internal reflection.
    refracted: Option<DVec3>,
}

impl Surface {
    /// Returns the shading normal, or the geometric one if the reflection would enter the surface.
    fn optical_normal(&self, direction: DVec3) -> DVec3 {
        let sound = direction.dot(self.normal) < 0.0 && reflect(direction, self.normal).dot(self.side) > 0.0;
        if sound { self.normal } else { self.side }
    }

    fn fresnel(&self, direction: DVec3, normal: DVec3, ior: f64) -> Fresnel {
        // Indices from files are clamped so that the result is finite.
        let ior = if ior > 1.0 { ior.min(1e3) } else { 1.0 };
        let ratio = if self.from_within { ior } else { ior.recip() };
        let cos_in = (-direction.dot(normal)).clamp(0.0, 1.0);
        let sin_out_squared = ratio * ratio * (1.0 - cos_in * cos_in);
        if sin_out_squared >= 1.0 {
            return Fresnel { reflectance: 1.0, refracted: None };
        }
        let cos_out = (1.0 - sin_out_squared).sqrt();
        let parallel = (cos_in - ratio * cos_out) / (cos_in + ratio * cos_out);
        let across = (ratio * cos_in - cos_out) / (ratio * cos_in + cos_out);
        let refracted = ratio * direction + (ratio * cos_in - cos_out) * normal;
        // With a shading normal, the refracted ray could leave on the wrong side of the surface.
        let refracted = refracted.try_normalize().filter(|refracted| refracted.dot(self.side) < 0.0);
        let reflectance = 0.5 * (parallel * parallel + across * across);
        Fresnel { reflectance, refracted: refracted.or(Some(direction)) }
    }

    /// Returns the weights of reflection and refraction and the index of refraction, as in a material stream.
    pub(super) fn optical_weights(&self, direction: DVec3) -> [f64; 3] {
        match self.optics {
            Optics::Opaque => OPAQUE,
            Optics::Mirror { .. } => [1.0, 0.0, 1.0],
            Optics::Glass { ior, .. } => {
                let share = self.fresnel(direction, self.optical_normal(direction), ior).reflectance;
                [share, 1.0 - share, ior]
            }
        }
    }
}

/// Returns the ambient light of a sky for a normal; the ground reflects 40% of it.
fn ambient(sky: DVec3, normal: DVec3) -> DVec3 {
    sky * (0.7 + 0.3 * normal.y)
}

fn reflect(direction: DVec3, normal: DVec3) -> DVec3 {
    direction - 2.0 * direction.dot(normal) * normal
}
