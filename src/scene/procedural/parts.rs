//! Building blocks of procedural scenes.

use glam::DVec3;

use crate::mesh::AxisBox;
use crate::{CastsShadow, Lamp, Light, Material, Object, Quad, SceneAtTime, Shape, Sky, Sphere, Texture, Window};

pub(super) struct Definition {
    pub name: &'static str,
    /// Region for probes: centre and half size, metres.
    pub region: (DVec3, DVec3),
    pub fixed: fn() -> Vec<Object>,
    /// Returns the scene at a phase of its period, 0..1, given its static objects.
    pub at: fn(f64, Vec<Object>) -> SceneAtTime,
}

pub(super) fn rgb(r: f64, g: f64, b: f64) -> DVec3 {
    DVec3::new(r, g, b)
}

/// Creates a box from its minimum and maximum corner.
pub(super) fn block(min: [f64; 3], max: [f64; 3], texture: Texture) -> Object {
    Object::new(Shape::AxisBox(AxisBox { min: min.into(), max: max.into() }), Material::diffuse(texture))
}

/// Creates a sphere textured in its own coordinates.
pub(super) fn ball(center: DVec3, radius: f64, texture: Texture) -> Object {
    let object = Object::new(Shape::Sphere(Sphere { center, radius }), Material::diffuse(texture));
    Object { anchor: center, ..object }
}

/// Creates an emissive sphere that casts no shadow.
pub(super) fn bulb(center: DVec3, radius: f64, emission: DVec3) -> Object {
    let mut bulb = ball(center, radius, Texture::Solid(DVec3::ZERO));
    bulb.material.emission = emission;
    bulb.casts_shadow = CastsShadow::No;
    bulb
}

/// Creates a lamp of unlimited range that emits in all directions.
pub(super) fn lamp(position: DVec3, radiance: DVec3) -> Lamp {
    Lamp { position, radiance, reach: f64::INFINITY, window: Window::Smooth, cone: None }
}

/// Returns the lighting of a room without sky.
pub(super) fn indoors(lamps: Vec<Lamp>, ambient: DVec3) -> Light {
    Light { suns: vec![], lamps, sky: Sky { ambient, ..Sky::NONE } }
}

/// Creates a rectangle that casts no shadow, for lights and for walls of a room lit from within.
pub(super) fn wall(corner: [f64; 3], u: DVec3, v: DVec3, texture: Texture) -> Object {
    let object = Object::new(Shape::Quad(Quad { corner: corner.into(), u, v }), Material::diffuse(texture));
    Object { casts_shadow: CastsShadow::No, ..object }
}

/// Creates the floor, the ceiling, and the walls at −X, +X, −Z, +Z of a room.
pub(super) fn room(inside: AxisBox, textures: [Texture; 6]) -> Vec<Object> {
    let AxisBox { min, max } = inside;
    let size = max - min;
    let [x, y, z] = [DVec3::X * size.x, DVec3::Y * size.y, DVec3::Z * size.z];
    let [floor, ceiling, left, right, back, front] = textures;
    let low = min.to_array();
    vec![
        wall(low, z, x, floor),
        wall([min.x, max.y, min.z], x, z, ceiling),
        wall(low, y, z, left),
        wall([max.x, min.y, min.z], z, y, right),
        wall(low, x, y, back),
        wall([min.x, min.y, max.z], y, x, front),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn walls_face_into_the_room() {
        let inside = AxisBox { min: DVec3::new(-1.0, 0.0, -2.0), max: DVec3::new(2.0, 3.0, 1.0) };
        let middle = 0.5 * (inside.min + inside.max);
        for wall in room(inside, [Texture::Solid(DVec3::ONE); 6]) {
            let Shape::Quad(quad) = wall.shape else { panic!("{wall:?}") };
            assert!(quad.u.cross(quad.v).dot(middle - quad.corner) > 0.0, "{quad:?}");
        }
    }
}
