//! What a ray sees: the nearest surface of a scene of shapes and meshes, and its light.
//!
//! Enters: a scene frozen at one time, a ray. Leaves: [`FirstHit`]: what it meets; [`Hit`]: distance in metres and
//! linear radiance, by [`super::shading`]. And whether two points see each other.
//!
//! Nothing here depends on time or on chance: the same scene and ray give the same bits, so that what does not move
//! and is not lit anew is exactly static.

#[cfg(test)]
mod extremes;

use std::sync::Arc;

use glam::{DQuat, DVec3};

use super::bvh::{MeshBvh, MeshHit};
pub use super::light::{Cone, Lamp, Light, Sky, Sun, Window};
use super::material::Material;
use super::mesh::Optics;
use super::primitive::{AxisBox, Intersection, Ray, Shape};
use super::shading::Path;
use super::shadow_grid::ShadowGrid;

/// How far rays start off the surface that they leave, in metres, in a scene that is `size` metres across: a micrometre
/// from 1 to 100 m, which is far above the rounding of f64 and far below a fence post; a millionth of smaller scenes, a
/// hundred-millionth of larger ones.
fn lift_m(size: f64) -> f64 {
    if size < 1.0 { 1e-6 * size } else { f64::max(1e-6, 1e-8 * size) }
}

/// A shape somewhere, with its paint.
#[derive(Debug, Clone, Copy)]
pub struct Object {
    shape: Shape,
    /// A box that contains the shape.
    bounds: AxisBox,
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
            bounds: shape.bounding_box(),
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

    /// A box along the axes that contains it.
    pub fn bounds(&self) -> &AxisBox {
        &self.bounds
    }

    /// Whether it casts shadows; glass never does.
    pub(super) fn keeps_light(&self) -> bool {
        self.casts_shadow == CastsShadow::Yes && !matches!(self.material.optics, Optics::Glass { .. })
    }
}

/// A scene at one moment.
#[derive(Debug, Clone)]
pub struct SceneAtTime {
    objects: Vec<Object>,
    meshes: Vec<Arc<MeshBvh>>,
    light: Light,
    /// One for each sun.
    shadows: Vec<ShadowGrid>,
    bounds: Option<AxisBox>,
    /// Diagonal of the bounds, metres.
    size: f64,
    /// How far rays start off a surface that they leave, metres.
    lift: f64,
}

/// What a ray sees.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// Metres along the ray, `+inf` for nothing.
    pub distance: f64,
    /// Linear Rec. 709 radiance towards the ray's origin.
    pub color: DVec3,
    /// Normal on the ray's side, length 1; zero for nothing. Of triangles whose corners have normals, the one between
    /// them, which may lean away from the ray.
    pub normal: DVec3,
    /// Index into [`SceneAtTime::objects`], `None` for nothing and for a mesh.
    pub object: Option<usize>,
    /// Weight of mirror reflection, weight of refraction, and index of refraction, as a material stream has them:
    /// 0, 0, 1 for what is opaque, and for nothing.
    pub optics: [f64; 3],
}

impl Hit {
    /// Nothing, black.
    const NOTHING: Hit =
        Hit { distance: f64::INFINITY, color: DVec3::ZERO, normal: DVec3::ZERO, object: None, optics: OPAQUE };
}

/// The first thing on a ray.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FirstHit {
    /// Metres along the ray.
    pub distance: f64,
    /// What it is.
    pub thing: Thing,
}

/// What a ray may meet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Thing {
    /// A shape.
    Object {
        /// Index into [`SceneAtTime::objects`].
        index: usize,
        /// Normal of the shape, as [`Intersection::normal`].
        normal: DVec3,
    },
    /// A triangle.
    Mesh {
        /// Index into [`SceneAtTime::meshes`].
        index: usize,
        /// Which of its triangles, and where.
        at: MeshHit,
    },
}

/// [`Hit::optics`] of what neither mirrors nor refracts.
pub const OPAQUE: [f64; 3] = [0.0, 0.0, 1.0];

/// Looks from `origin` along `direction` (any length).
///
/// A direction without length, or anything not finite, sees nothing: distance `+inf` and the horizon's colour.
pub fn trace(scene: &SceneAtTime, origin: DVec3, direction: DVec3) -> Hit {
    let Some(ray) = Ray::new(origin, direction) else {
        return Hit { color: scene.light.sky.horizon, ..Hit::NOTHING };
    };
    scene.look(&ray, 0..scene.objects.len())
}

impl SceneAtTime {
    /// A scene of `objects`. Where two lie equally far along a ray, the earlier one is seen.
    pub fn new(objects: Vec<Object>, light: Light) -> Self {
        Self::with_meshes(objects, Vec::new(), light)
    }

    /// The same with meshes. What moves lies in other meshes than what does not, so that the latter are shared.
    pub fn with_meshes(objects: Vec<Object>, meshes: Vec<Arc<MeshBvh>>, light: Light) -> Self {
        let shadows = light.suns.iter().map(|sun| ShadowGrid::new(&objects, sun.direction)).collect();
        let boxes = objects.iter().map(|object| object.bounds).chain(meshes.iter().filter_map(|mesh| mesh.bounds()));
        // A shape that is not finite is not seen, and does not spoil what depends on the size.
        let boxes = boxes.filter(|bounds| bounds.min.is_finite() && bounds.max.is_finite());
        let bounds = boxes.reduce(AxisBox::join);
        let size = bounds.map_or(0.0, |bounds| (bounds.max - bounds.min).length().min(f64::MAX));
        SceneAtTime { objects, meshes, light, shadows, bounds, size, lift: lift_m(size) }
    }

    /// The smallest box along the axes around the boxes of all objects and meshes; `None` for an empty scene.
    pub fn bounds(&self) -> Option<AxisBox> {
        self.bounds
    }

    /// Whether nothing lies between two points. What is as near to either of them as rays start off surfaces does not
    /// count, since both may be on a surface: a micrometre in scenes of 1 to 100 m across, a millionth of the size of
    /// smaller ones, a hundred-millionth of that of larger ones, and never less than 1e-13 of the point's largest
    /// coordinate. Surfaces hide, the inside of a solid does not. Glass is something; holes in textures are not.
    /// Points that are not finite are not seen, and points nearer to each other than both of these together are.
    pub fn sees(&self, from: DVec3, to: DVec3) -> bool {
        let way = to - from;
        let length = way.length();
        if !length.is_finite() {
            return false;
        }
        let ends = [self.lift(from), length - self.lift(to)];
        if ends[0] >= ends[1] {
            return true;
        }
        let ray = Ray::from_unit(from, way / length);
        let hidden = self.objects.iter().any(|object| {
            object.bounds.intersect(&ray, 0.0).is_some()
                && object.shape.intersect(&ray, ends[0]).is_some_and(|hit| hit.distance < ends[1])
        });
        !hidden && !self.meshes.iter().any(|mesh| mesh.occluded(&ray, ends[0], ends[1]))
    }

    /// Square of the distance from a lamp within which it becomes no brighter, square metres: 10 cm, less in scenes of
    /// less than a metre.
    pub(super) fn lamp_core(&self) -> f64 {
        0.01 * self.size.min(1.0).powi(2)
    }

    /// For each sun, what may keep it off.
    pub(super) fn shadows(&self) -> &[ShadowGrid] {
        &self.shadows
    }

    /// How far a ray starts off the surface at `point` that it leaves, metres: more for points so far from the origin
    /// that f64 resolves less.
    pub(super) fn lift(&self, point: DVec3) -> f64 {
        self.lift.max(1e-13 * point.abs().max_element())
    }

    /// Everything made of triangles.
    pub fn meshes(&self) -> &[Arc<MeshBvh>] {
        &self.meshes
    }

    /// Everything solid.
    pub fn objects(&self) -> &[Object] {
        &self.objects
    }

    /// Everything that shines.
    pub fn light(&self) -> &Light {
        &self.light
    }

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

    /// The first thing on a ray, among all meshes and the `candidates` (indices of objects, rising). Where two are
    /// equally near: objects before meshes, then the lower index. Depth is this, without any shading.
    pub fn first_hit(&self, ray: &Ray, candidates: impl IntoIterator<Item = usize>) -> Option<FirstHit> {
        let mut first = self.nearest(ray, candidates).map(|(index, hit)| FirstHit {
            distance: hit.distance,
            thing: Thing::Object { index, normal: hit.normal },
        });
        for (index, mesh) in self.meshes.iter().enumerate() {
            let limit = first.map_or(f64::INFINITY, |first| first.distance);
            if let Some(at) = mesh.nearest_before(ray, 0.0, limit) {
                first = Some(FirstHit { distance: at.distance, thing: Thing::Mesh { index, at } });
            }
        }
        first
    }

    /// What a ray sees, among all meshes and the `candidates` (indices of objects, rising): [`trace`] where the caller
    /// knows which objects may be met. What reflections and shadows meet are always all of them.
    pub fn look(&self, ray: &Ray, candidates: impl IntoIterator<Item = usize>) -> Hit {
        let Some(hit) = self.first_hit(ray, candidates) else {
            return Hit { color: self.light.sky.radiance(ray.direction()), ..Hit::NOTHING };
        };
        let surface = self.surface(ray, &hit);
        Hit {
            distance: hit.distance,
            color: self.radiance(&surface, ray.direction(), Path::FIRST),
            normal: surface.normal,
            object: match hit.thing {
                Thing::Object { index, .. } => Some(index),
                Thing::Mesh { .. } => None,
            },
            optics: surface.optical_weights(ray.direction()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::material::Texture;
    use super::super::primitive::{Quad, Sphere};
    use super::*;

    const SKY: Sky = Sky { horizon: DVec3::splat(0.5), zenith: DVec3::ONE, ambient: DVec3::splat(0.1) };

    fn white(shape: Shape) -> Object {
        Object::new(shape, Material::diffuse(Texture::Solid(DVec3::ONE)))
    }

    /// A floor at y = 0, a ball of radius 1 above its middle, the sun overhead, a lamp low at x = 4.
    fn scene() -> SceneAtTime {
        let floor = Quad { corner: DVec3::new(-9.0, 0.0, -9.0), u: DVec3::Z * 18.0, v: DVec3::X * 18.0 };
        let objects =
            vec![white(Shape::Quad(floor)), white(Shape::Sphere(Sphere { center: DVec3::Y * 3.0, radius: 1.0 }))];
        let light = Light {
            suns: vec![Sun { direction: DVec3::Y, radiance: DVec3::splat(2.0) }],
            lamps: vec![Lamp {
                position: DVec3::new(4.0, 1.0, 0.0),
                radiance: DVec3::ONE,
                reach: 2.0,
                window: Window::Smooth,
                cone: None,
            }],
            sky: SKY,
        };
        SceneAtTime::new(objects, light)
    }

    fn floor_at(x: f64, z: f64) -> DVec3 {
        let from = DVec3::new(x + 3.0, 1.5, z);
        let hit = trace(&scene(), from, DVec3::new(x, 0.0, z) - from);
        assert_eq!(hit.object, Some(0));
        hit.color
    }

    #[test]
    fn sun_shadow_and_ambient() {
        assert!((floor_at(-2.0, 0.0) - 2.1).abs().max_element() < 1e-12);
        assert!((floor_at(-0.9, 0.0) - 0.1).abs().max_element() < 1e-12);
        // The shadow's edge is the ball's outline, from both sides.
        assert!(floor_at(-1.001, 0.0).x > 2.0 && floor_at(-0.999, 0.0).x < 0.2);
        // On the floor's far corners, outside the shafts of all casters.
        assert!(floor_at(-8.9, 8.9).x > 2.0);
    }

    #[test]
    fn lamp_reaches_just_so_far() {
        // Straight below: 1 m, window (1 − 1/4)².
        assert!((floor_at(4.0, 0.0).x - (2.1 + 0.5625)).abs() < 1e-5);
        assert_eq!(floor_at(4.0, 1.8), floor_at(-4.0, 1.8));
    }

    #[test]
    fn sphere_is_lit_above_and_dark_below() {
        let above = trace(&scene(), DVec3::Y * 8.0, DVec3::NEG_Y);
        assert_eq!((above.distance, above.object, above.normal), (4.0, Some(1), DVec3::Y));
        assert!((above.color.x - 2.1).abs() < 1e-12);
        let below = trace(&scene(), DVec3::Y * 0.5, DVec3::Y);
        assert!((below.color.x - 0.04).abs() < 1e-12);
    }

    #[test]
    fn nothing_is_infinite_and_sky_coloured() {
        let up = trace(&scene(), DVec3::new(5.0, 5.0, 5.0), DVec3::Y);
        assert_eq!((up.distance, up.color, up.object), (f64::INFINITY, DVec3::ONE, None));
        let side = trace(&scene(), DVec3::new(5.0, 5.0, 5.0), DVec3::new(1.0, 1.0, 0.0));
        assert_eq!(side.color, SKY.horizon);
        for (origin, direction) in [(DVec3::NAN, DVec3::X), (DVec3::ZERO, DVec3::ZERO), (DVec3::ZERO, DVec3::NAN)] {
            assert_eq!(trace(&scene(), origin, direction).distance, f64::INFINITY);
        }
    }

    #[test]
    fn points_see_each_other_unless_something_lies_between() {
        let scene = scene();
        let (top, bottom) = (DVec3::Y * 4.0, DVec3::Y * 2.0);
        assert!(scene.sees(DVec3::Y * 8.0, top) && scene.sees(top, DVec3::Y * 8.0));
        assert!(!scene.sees(top + 0.1 * DVec3::Y, bottom) && !scene.sees(DVec3::Y * 8.0, bottom));
        assert!(!scene.sees(DVec3::Y * 8.0, DVec3::ZERO) && scene.sees(DVec3::ZERO, bottom));
        // Through the floor, along it, and at its edge.
        assert!(!scene.sees(DVec3::new(3.0, 1.0, 0.0), DVec3::new(3.0, -1.0, 0.0)));
        assert!(scene.sees(DVec3::new(3.0, 0.0, 0.0), DVec3::new(-5.0, 0.0, 1.0)));
        assert!(scene.sees(DVec3::new(9.1, 1.0, 0.0), DVec3::new(9.1, -1.0, 0.0)));
        assert!(scene.sees(top, top) && !scene.sees(DVec3::NAN, top) && !scene.sees(top, DVec3::INFINITY));
        assert_eq!(scene.bounds(), Some(AxisBox { min: DVec3::new(-9.0, 0.0, -9.0), max: DVec3::new(9.0, 4.0, 9.0) }));
        assert_eq!(SceneAtTime::new(vec![], scene.light().clone()).bounds(), None);
    }

    #[test]
    fn an_empty_scene_is_sky() {
        let empty = SceneAtTime::new(vec![], scene().light().clone());
        assert_eq!(trace(&empty, DVec3::ZERO, DVec3::Z).color, SKY.horizon);
        // And a scene in which nothing casts a shadow is lit everywhere.
        let mut floor = scene().objects()[0];
        floor.casts_shadow = CastsShadow::No;
        let bare = SceneAtTime::new(vec![floor], scene().light().clone());
        assert!((trace(&bare, DVec3::Y, DVec3::new(0.1, -1.0, 0.0)).color.x - 2.1).abs() < 1e-12);
    }
}
