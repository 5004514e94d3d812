//! Traces a ray through a scene: distance, radiance, normal and optics of the first hit.

#[cfg(test)]
mod tests;

use glam::DVec3;

use super::mesh_scene::Optics;
use super::raycast::{FirstHit, HitSurface, SceneAtTime};
use super::shading::{Gloss, OPAQUE, Path, Radiance};
use crate::mesh::Ray;

/// Hit of a ray, or the background.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// Metres along the ray; `+inf` if nothing is hit.
    pub distance: f64,
    /// Linear Rec. 709 radiance towards the ray's origin.
    pub color: DVec3,
    /// Shading normal on the ray's side, length 1; zero if nothing is hit. An interpolated normal may lean away from the ray.
    pub normal: DVec3,
    /// Index into [`SceneAtTime::objects`]; `None` if nothing or a mesh is hit.
    pub object: Option<usize>,
    /// Weight of reflection, weight of refraction, index of refraction; 0, 0, 1 for opaque surfaces and for the background.
    pub optics: [f64; 3],
}

impl Hit {
    pub(super) const NOTHING: Hit =
        Hit { distance: f64::INFINITY, color: DVec3::ZERO, normal: DVec3::ZERO, object: None, optics: OPAQUE };
}

/// Traces a ray from `origin` along `direction`, which need not be normalised. If the direction is zero or anything is not
/// finite, returns no hit: distance `+inf` and the colour of the horizon.
pub fn trace(scene: &SceneAtTime, origin: DVec3, direction: DVec3) -> Hit {
    let Some(ray) = Ray::new(origin, direction) else {
        return Hit { color: scene.light.sky.horizon, ..Hit::NOTHING };
    };
    scene.trace(&ray, 0..scene.objects.len())
}

/// View dependence of a surface's radiance.
#[derive(Debug, Clone)]
pub enum EyeLight {
    /// The radiance is the same for all eyes.
    None,
    Gloss(Gloss),
    /// A mirror or glass: the radiance must be traced for each eye.
    Traced,
}

impl SceneAtTime {
    /// Returns the radiance of a hit along a ray; that of the sky if there is no hit.
    pub fn shade(&self, ray: &Ray, hit: Option<&FirstHit>) -> Radiance {
        match hit {
            Some(hit) => self.radiance(&self.surface(ray, hit), ray.direction(), Path::FIRST),
            None => Radiance { steady: self.light.sky.radiance(ray.direction()), of_eye: DVec3::ZERO },
        }
    }

    pub fn eye_light(&self, ray: &Ray, hit: &FirstHit) -> EyeLight {
        let surface = self.surface(ray, hit);
        match surface.optics {
            Optics::Opaque => self.gloss(&surface).map_or(EyeLight::None, EyeLight::Gloss),
            Optics::Mirror { .. } | Optics::Glass { .. } => EyeLight::Traced,
        }
    }

    /// [`trace`] against all meshes and the `candidates` (ascending indices of objects); reflected, refracted and shadow rays
    /// are traced against all objects.
    pub fn trace(&self, ray: &Ray, candidates: impl IntoIterator<Item = usize>) -> Hit {
        let Some(hit) = self.first_hit(ray, candidates) else {
            return Hit { color: self.light.sky.radiance(ray.direction()), ..Hit::NOTHING };
        };
        let surface = self.surface(ray, &hit);
        Hit {
            distance: hit.distance,
            color: self.radiance(&surface, ray.direction(), Path::FIRST).total(),
            normal: surface.normal,
            object: match hit.surface {
                HitSurface::Object { index, .. } => Some(index),
                HitSurface::Mesh { .. } => None,
            },
            optics: surface.optical_weights(ray.direction()),
        }
    }
}
