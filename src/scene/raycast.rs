//! What a ray sees: the nearest surface, lit by a sun with hard shadows, an ambient sky and a lamp.
//!
//! Enters: a scene frozen at one time, a ray. Leaves: [`Hit`]: distance in metres and linear radiance.
//!
//! Nothing here depends on time or on chance: the same scene and ray give the same bits, so that what does not move
//! and is not lit anew is exactly static.

use glam::{DQuat, DVec3};

use super::material::Material;
use super::primitive::{Intersection, Ray, Shape, Sphere};

/// How far a shadow ray starts above the surface, metres: far above the rounding of f64 at 100 m, far below a
/// fence post.
const SHADOW_OFFSET_M: f64 = 1e-6;

/// A shape somewhere, with its paint.
#[derive(Debug, Clone, Copy)]
pub struct Object {
    shape: Shape,
    /// A ball that contains the shape.
    bounds: Sphere,
    /// What it is painted with.
    pub material: Material,
    /// Origin of the texture's coordinates in the world, metres.
    pub anchor: DVec3,
    /// Turn from world axes to the texture's axes: what rolls with a ball.
    pub texture_from_world: DQuat,
    /// Whether the sun's light is held up by it. Lamps and the ground do not hold it up.
    pub casts_shadow: CastsShadow,
}

/// Whether an object keeps light from others.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CastsShadow {
    /// It does.
    Yes,
    /// It does not, and no shadow ray is tried against it.
    No,
}

impl Object {
    /// An object that casts shadows, textured in world coordinates.
    pub fn new(shape: Shape, material: Material) -> Self {
        Object {
            shape,
            bounds: shape.bounding_sphere(),
            material,
            anchor: DVec3::ZERO,
            texture_from_world: DQuat::IDENTITY,
            casts_shadow: CastsShadow::Yes,
        }
    }

    /// Its shape.
    pub fn shape(&self) -> &Shape {
        &self.shape
    }

    /// A ball that contains it.
    pub fn bounds(&self) -> &Sphere {
        &self.bounds
    }
}

/// A light at infinity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sun {
    /// Direction towards it, length 1.
    pub direction: DVec3,
    /// Radiance of a white surface that faces it.
    pub radiance: DVec3,
}

/// A light at a point whose reach ends: beyond it, nothing changes when it does.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lamp {
    /// Where, metres.
    pub position: DVec3,
    /// Radiance of a white surface that faces it at 1 m, before the fall-off to the reach.
    pub radiance: DVec3,
    /// Distance in metres from which on it lights nothing.
    pub reach: f64,
}

/// What is seen where there is nothing, and the light that comes from there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sky {
    /// Radiance up to the elevation whose sine is [`Sky::GRADIENT_START`]: one constant.
    pub horizon: DVec3,
    /// Radiance straight up.
    pub zenith: DVec3,
    /// Radiance of a white surface that faces up, without sun.
    pub ambient: DVec3,
}

impl Sky {
    /// Sine of the elevation where the sky starts to change: just above 45°, so that the four horizontal faces of a
    /// cube map see one constant.
    pub const GRADIENT_START: f64 = 0.71;

    /// Radiance in a direction of length 1.
    pub fn radiance(&self, direction: DVec3) -> DVec3 {
        let rise = (direction.y - Sky::GRADIENT_START) / (1.0 - Sky::GRADIENT_START);
        if rise <= 0.0 { self.horizon } else { self.horizon.lerp(self.zenith, rise.min(1.0)) }
    }
}

/// A scene at one moment.
#[derive(Debug, Clone)]
pub struct SceneAtTime {
    /// Everything solid.
    pub objects: Vec<Object>,
    /// The sun.
    pub sun: Sun,
    /// The lamp.
    pub lamp: Lamp,
    /// The background.
    pub sky: Sky,
}

/// What a ray sees.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// Metres along the ray, `+inf` for nothing.
    pub distance: f64,
    /// Linear Rec. 709 radiance towards the ray's origin.
    pub color: DVec3,
    /// Normal on the ray's side, length 1; zero for nothing.
    pub normal: DVec3,
    /// Index into [`SceneAtTime::objects`], `None` for nothing.
    pub object: Option<usize>,
}

/// Looks from `origin` along `direction` (any length).
///
/// A direction without length, or anything not finite, sees nothing: distance `+inf` and the horizon's colour.
pub fn trace(scene: &SceneAtTime, origin: DVec3, direction: DVec3) -> Hit {
    let Some(ray) = Ray::new(origin, direction) else {
        return Hit { distance: f64::INFINITY, color: scene.sky.horizon, normal: DVec3::ZERO, object: None };
    };
    scene.look(&ray, 0..scene.objects.len())
}

impl SceneAtTime {
    /// The nearest of the `candidates` (indices of objects), by order of index where two are equally near.
    pub(super) fn nearest(
        &self,
        ray: &Ray,
        candidates: impl IntoIterator<Item = usize>,
    ) -> Option<(usize, Intersection)> {
        let mut best: Option<(usize, Intersection)> = None;
        for index in candidates {
            if let Some(hit) = self.objects[index].shape.intersect(ray, 0.0)
                && best.is_none_or(|(_, best)| hit.distance < best.distance)
            {
                best = Some((index, hit));
            }
        }
        best
    }

    /// [`trace`] among some of the objects.
    pub(super) fn look(&self, ray: &Ray, candidates: impl IntoIterator<Item = usize>) -> Hit {
        match self.nearest(ray, candidates) {
            None => Hit {
                distance: f64::INFINITY,
                color: self.sky.radiance(ray.direction),
                normal: DVec3::ZERO,
                object: None,
            },
            Some((index, hit)) => {
                // The side that is seen is the side that is lit: quads and rays from inside a solid.
                let normal = if hit.normal.dot(ray.direction) > 0.0 { -hit.normal } else { hit.normal };
                let color = self.shade(index, ray.at(hit.distance), normal);
                Hit { distance: hit.distance, color, normal, object: Some(index) }
            }
        }
    }

    /// Lambert under ambient sky, sun and lamp, and what the surface gives off itself.
    fn shade(&self, index: usize, point: DVec3, normal: DVec3) -> DVec3 {
        let object = &self.objects[index];
        let turn = object.texture_from_world;
        let (local_point, local_normal) = if turn == DQuat::IDENTITY {
            (point - object.anchor, normal)
        } else {
            (turn * (point - object.anchor), turn * normal)
        };
        let albedo = object.material.texture.albedo(local_point, local_normal);
        // A surface that faces down sees ground instead of sky: a bit less than half the light.
        let mut light = self.sky.ambient * (0.7 + 0.3 * normal.y);
        let above = point + SHADOW_OFFSET_M * normal;
        let facing_sun = normal.dot(self.sun.direction);
        if facing_sun > 0.0 && !self.occluded(&Ray { origin: above, direction: self.sun.direction }, f64::INFINITY) {
            light += facing_sun * self.sun.radiance;
        }
        light += self.lamp_light(above, normal);
        object.material.emission + albedo * light
    }

    fn lamp_light(&self, point: DVec3, normal: DVec3) -> DVec3 {
        let to_lamp = self.lamp.position - point;
        let squared = to_lamp.length_squared();
        let reach = self.lamp.reach * self.lamp.reach;
        let cosine = normal.dot(to_lamp);
        // Out of reach, behind the surface, or in the lamp itself, where the direction is lost.
        if squared >= reach || cosine <= 0.0 || squared < 1e-12 {
            return DVec3::ZERO;
        }
        let distance = squared.sqrt();
        if self.occluded(&Ray { origin: point, direction: to_lamp / distance }, distance) {
            return DVec3::ZERO;
        }
        // Inverse square times a window that reaches 0 with slope 0.
        let window = 1.0 - squared / reach;
        self.lamp.radiance * (cosine / distance * window * window / squared.max(0.01))
    }

    /// Whether something that casts shadows lies on the first `length` metres.
    fn occluded(&self, ray: &Ray, length: f64) -> bool {
        self.objects.iter().any(|object| {
            if object.casts_shadow == CastsShadow::No {
                return false;
            }
            // Most objects are far from most rays; their balls say so in a few multiplications.
            let to_center = object.bounds.center - ray.origin;
            let along = to_center.dot(ray.direction);
            let radius = object.bounds.radius;
            if along < -radius || to_center.length_squared() - along * along > radius * radius {
                return false;
            }
            object.shape.intersect(ray, 0.0).is_some_and(|hit| hit.distance < length)
        })
    }
}
