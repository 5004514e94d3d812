//! Objects that procedural scenes are built of.

use glam::DVec3;

use crate::mesh::AxisBox;
use crate::scene::material::{Material, Texture};
use crate::scene::object::{CastsShadow, Object};
use crate::scene::primitive::{Quad, Shape, Sphere};

pub(super) fn rgb(r: f64, g: f64, b: f64) -> DVec3 {
    DVec3::new(r, g, b)
}

/// A box by its smallest and largest corner.
pub(super) fn block(min: [f64; 3], max: [f64; 3], texture: Texture) -> Object {
    Object::new(Shape::AxisBox(AxisBox { min: min.into(), max: max.into() }), Material::diffuse(texture))
}

/// A sphere, textured in its own coordinates.
pub(super) fn ball(center: DVec3, radius: f64, texture: Texture) -> Object {
    let mut object = Object::new(Shape::Sphere(Sphere { center, radius }), Material::diffuse(texture));
    object.anchor = center;
    object
}

/// A rectangle that casts no shadow: walls of a room that is lit from within, and lights.
pub(super) fn wall(corner: [f64; 3], u: DVec3, v: DVec3, texture: Texture) -> Object {
    let mut object = Object::new(Shape::Quad(Quad { corner: corner.into(), u, v }), Material::diffuse(texture));
    object.casts_shadow = CastsShadow::No;
    object
}

/// Floor, ceiling, and the walls to −X, +X, −Z, +Z of a room.
pub(super) fn room(inside: AxisBox, textures: [Texture; 6]) -> [Object; 6] {
    let AxisBox { min, max } = inside;
    let size = max - min;
    let [x, y, z] = [DVec3::X * size.x, DVec3::Y * size.y, DVec3::Z * size.z];
    let [floor, ceiling, left, right, back, front] = textures;
    let low = min.to_array();
    [
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
            let Shape::Quad(quad) = wall.shape() else { panic!("{wall:?}") };
            assert!(quad.u.cross(quad.v).dot(middle - quad.corner) > 0.0, "{quad:?}");
        }
    }
}
