//! What a ray sees: the nearest surface, lit by suns and lamps with hard shadows, and an ambient sky.
//!
//! Enters: a scene frozen at one time, a ray. Leaves: [`Hit`]: distance in metres and linear radiance.
//!
//! Nothing here depends on time or on chance: the same scene and ray give the same bits, so that what does not move
//! and is not lit anew is exactly static.

use std::sync::Arc;

use glam::{DQuat, DVec2, DVec3};

use super::bvh::MeshBvh;
use super::material::Material;
use super::primitive::{AxisBox, Intersection, Ray, Shape};

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
    /// Distance in metres from which on it lights nothing; may be `+inf`.
    pub reach: f64,
    /// Where it shines to, `None` for all around.
    pub cone: Option<Cone>,
}

/// The light of a spot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cone {
    /// Its middle, length 1.
    pub axis: DVec3,
    /// Cosine of the angle from the axis within which it has its full strength.
    pub cos_inner: f64,
    /// Cosine of the angle from which on it lights nothing, below `cos_inner`.
    pub cos_outer: f64,
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
    objects: Vec<Object>,
    meshes: Vec<Arc<MeshBvh>>,
    light: Light,
    /// One for each sun.
    shadows: Vec<ShadowGrid>,
    bounds: Option<AxisBox>,
    /// How far rays start off a surface that they leave, metres.
    lift: f64,
}

/// All that shines in a scene, but for surfaces.
#[derive(Debug, Clone, PartialEq)]
pub struct Light {
    /// Lights at infinity.
    pub suns: Vec<Sun>,
    /// Lights at points.
    pub lamps: Vec<Lamp>,
    /// The background.
    pub sky: Sky,
}

impl Default for Light {
    /// A bright day, for scenes that bring no light.
    fn default() -> Self {
        let sun = Sun { direction: DVec3::new(0.5, 0.78, 0.38).normalize(), radiance: DVec3::new(1.75, 1.6, 1.35) };
        let sky = Sky {
            horizon: DVec3::new(0.5, 0.66, 0.86),
            zenith: DVec3::new(0.16, 0.32, 0.68),
            ambient: DVec3::new(0.3, 0.36, 0.46),
        };
        Light { suns: vec![sun], lamps: Vec::new(), sky }
    }
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
    /// Index into [`SceneAtTime::objects`], `None` for nothing and for a mesh.
    pub object: Option<usize>,
    /// Weight of mirror reflection, weight of refraction, and index of refraction, as a material stream has them:
    /// 0, 0, 1 for what is opaque, and for nothing.
    pub optics: [f64; 3],
}

/// [`Hit::optics`] of what neither mirrors nor refracts.
pub const OPAQUE: [f64; 3] = [0.0, 0.0, 1.0];

/// Looks from `origin` along `direction` (any length).
///
/// A direction without length, or anything not finite, sees nothing: distance `+inf` and the horizon's colour.
pub fn trace(scene: &SceneAtTime, origin: DVec3, direction: DVec3) -> Hit {
    let Some(ray) = Ray::new(origin, direction) else {
        return Hit {
            distance: f64::INFINITY,
            color: scene.light.sky.horizon,
            normal: DVec3::ZERO,
            object: None,
            optics: OPAQUE,
        };
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
        let bounds = boxes.reduce(|a, b| AxisBox { min: a.min.min(b.min), max: a.max.max(b.max) });
        let size = bounds.map_or(0.0, |bounds| (bounds.max - bounds.min).length());
        SceneAtTime { objects, meshes, light, shadows, bounds, lift: lift_m(size) }
    }

    /// The smallest box along the axes around the boxes of all objects and meshes; `None` for an empty scene.
    pub fn bounds(&self) -> Option<AxisBox> {
        self.bounds
    }

    /// Whether nothing lies between two points. What lies at the points themselves, within a millionth of the scene's
    /// size, does not count: either may be on a surface. Surfaces hide, the
    /// inside of a solid does not. Glass is something; holes in textures are not.
    /// Points that are not finite are not seen, and equal points are.
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

    /// How far a ray starts off the surface at `point` that it leaves, metres: more for points so far from the origin
    /// that f64 resolves less.
    fn lift(&self, point: DVec3) -> f64 {
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

    /// [`trace`] among some of the objects.
    pub(super) fn look(&self, ray: &Ray, candidates: impl IntoIterator<Item = usize>) -> Hit {
        match self.nearest(ray, candidates) {
            None => Hit {
                distance: f64::INFINITY,
                color: self.light.sky.radiance(ray.direction()),
                normal: DVec3::ZERO,
                object: None,
                optics: OPAQUE,
            },
            Some((index, hit)) => {
                // The side that is seen is the side that is lit: quads and rays from inside a solid.
                let normal = if hit.normal.dot(ray.direction()) > 0.0 { -hit.normal } else { hit.normal };
                let color = self.shade(index, ray.at(hit.distance), normal);
                Hit { distance: hit.distance, color, normal, object: Some(index), optics: OPAQUE }
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
        let mut light = self.light.sky.ambient * (0.7 + 0.3 * normal.y);
        let above = point + self.lift(point) * normal;
        for (sun, shadows) in self.light.suns.iter().zip(&self.shadows) {
            let facing_sun = normal.dot(sun.direction);
            if facing_sun > 0.0 && !self.in_sun_shadow(sun, shadows, above) {
                light += facing_sun * sun.radiance;
            }
        }
        for lamp in &self.light.lamps {
            light += self.lamp_light(lamp, above, normal);
        }
        object.material.emission + albedo * light
    }

    fn lamp_light(&self, lamp: &Lamp, point: DVec3, normal: DVec3) -> DVec3 {
        let to_lamp = lamp.position - point;
        let squared = to_lamp.length_squared();
        let reach = lamp.reach * lamp.reach;
        let cosine = normal.dot(to_lamp);
        // Out of reach, behind the surface, or in the lamp itself, where the direction is lost.
        if squared >= reach || cosine <= 0.0 || squared < 1e-12 {
            return DVec3::ZERO;
        }
        let distance = squared.sqrt();
        if self.occluded(&Ray::from_unit(point, to_lamp / distance), distance) {
            return DVec3::ZERO;
        }
        // Inverse square times a window that reaches 0 with slope 0.
        let window = 1.0 - squared / reach;
        lamp.radiance * (cosine / distance * window * window / squared.max(0.01))
    }

    fn in_sun_shadow(&self, sun: &Sun, shadows: &ShadowGrid, point: DVec3) -> bool {
        let ray = Ray::from_unit(point, sun.direction);
        shadows.casters(point).iter().any(|&index| self.objects[index].shape.intersect(&ray, 0.0).is_some())
    }

    /// Whether something that casts shadows lies on the first `length` metres.
    fn occluded(&self, ray: &Ray, length: f64) -> bool {
        self.objects.iter().filter(|object| object.casts_shadow == CastsShadow::Yes).any(|object| {
            object.bounds.intersect(ray, 0.0).is_some()
                && object.shape.intersect(ray, 0.0).is_some_and(|hit| hit.distance < length)
        })
    }
}

/// Who may stand between a point and the sun: the scene cut into shafts parallel to the sun's rays, each with the
/// objects whose bounding boxes reach into it.
#[derive(Debug, Clone)]
struct ShadowGrid {
    /// Two axes across the sun's direction.
    axes: [DVec3; 2],
    /// Smallest coordinates of all casters, and shafts per metre, along those axes.
    min: DVec2,
    per_metre: DVec2,
    /// Indices of objects, row-major.
    shafts: Vec<Vec<usize>>,
}

impl ShadowGrid {
    /// Shafts along each axis.
    const SIDE: usize = 48;

    fn new(objects: &[Object], sun: DVec3) -> Self {
        // Across the sun, and as far as possible along X: the shadows of long beams then fill few shafts.
        let first = (DVec3::X - sun.x * sun).try_normalize().unwrap_or(DVec3::Y);
        let axes = [first, sun.cross(first)];
        let flat = |point: DVec3| DVec2::new(point.dot(axes[0]), point.dot(axes[1]));
        let casters: Vec<(usize, DVec2, DVec2)> = objects
            .iter()
            .enumerate()
            .filter(|(_, object)| object.casts_shadow == CastsShadow::Yes)
            .map(|(index, object)| {
                let corners = object.bounds.corners().map(flat);
                // Ten micrometres for rounding and for the lift of shadow rays.
                let (low, high) = corners
                    .iter()
                    .fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), &p| (low.min(p), high.max(p)));
                (index, low - 1e-5, high + 1e-5)
            })
            .collect();
        let min = casters.iter().fold(DVec2::INFINITY, |min, (_, low, _)| min.min(*low));
        let max = casters.iter().fold(DVec2::NEG_INFINITY, |max, (_, _, high)| max.max(*high));
        let mut grid = ShadowGrid {
            axes,
            min,
            per_metre: Self::SIDE as f64 / (max - min),
            shafts: vec![Vec::new(); Self::SIDE * Self::SIDE],
        };
        for (index, low, high) in casters {
            let (from, to) = (grid.shaft(low), grid.shaft(high));
            for row in from[1]..=to[1] {
                for column in from[0]..=to[0] {
                    grid.shafts[row * Self::SIDE + column].push(index);
                }
            }
        }
        grid
    }

    /// Column and row of a flat point. Casts saturate and NaN (a grid without casters) is 0, so points outside fall
    /// into a border shaft, whose casters they try in vain.
    fn shaft(&self, flat: DVec2) -> [usize; 2] {
        ((flat - self.min) * self.per_metre).to_array().map(|at| (at as usize).min(Self::SIDE - 1))
    }

    fn casters(&self, point: DVec3) -> &[usize] {
        let [column, row] = self.shaft(DVec2::new(point.dot(self.axes[0]), point.dot(self.axes[1])));
        &self.shafts[row * Self::SIDE + column]
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
            lamps: vec![Lamp { position: DVec3::new(4.0, 1.0, 0.0), radiance: DVec3::ONE, reach: 2.0, cone: None }],
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
