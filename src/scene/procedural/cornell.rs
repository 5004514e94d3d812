//! The Cornell box: two metres wide, open to +Z, red wall at −X and green wall at +X, a light in the ceiling, two white blocks.

use glam::{DVec2, DVec3};

use super::parts::{Definition, indoors, lamp, rgb, room, wall};
use crate::mesh::AxisBox;
use crate::{Cone, Lamp, Material, Object, SceneAtTime, Shape, Texture, TurnedBox};

pub(super) const SCENE: Definition =
    Definition { name: "cornell", region: (DVec3::new(0.0, 1.3, 0.75), DVec3::new(0.3, 0.15, 0.15)), fixed, at };

const INSIDE: AxisBox = AxisBox { min: DVec3::new(-1.0, 0.0, -1.0), max: DVec3::new(1.0, 2.0, 1.0) };

fn fixed() -> Vec<Object> {
    let white = Texture::Solid(rgb(0.73, 0.73, 0.73));
    let red = Texture::Solid(rgb(0.63, 0.06, 0.05));
    let green = Texture::Solid(rgb(0.15, 0.48, 0.09));
    let mut objects = room(INSIDE, [white, white, red, green, white, white]);
    // The last wall is the open side.
    objects.pop();
    let turned = |center: [f64; 3], half: [f64; 3], degrees: f64| {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let shape = TurnedBox { center: center.into(), half: half.into(), turn: DVec2::new(cos, sin) };
        Object::new(Shape::TurnedBox(shape), Material::diffuse(white))
    };
    objects.push(turned([-0.35, 0.6, -0.3], [0.3, 0.6, 0.3], 18.0));
    objects.push(turned([0.35, 0.3, 0.3], [0.3, 0.3, 0.3], -17.0));
    let mut light = wall([-0.25, 1.999, -0.25], DVec3::X * 0.5, DVec3::Z * 0.5, Texture::Solid(DVec3::ZERO));
    light.material.emission = rgb(12.0, 9.5, 6.5);
    objects.push(light);
    objects
}

fn at(_: f64, objects: Vec<Object>) -> SceneAtTime {
    let cone = Some(Cone { axis: DVec3::NEG_Y, cos_inner: 0.9, cos_outer: -0.1 });
    let lamp = Lamp { cone, ..lamp(DVec3::new(0.0, 1.98, 0.0), rgb(1.2, 1.0, 0.75)) };
    SceneAtTime::new(objects, indoors(vec![lamp], rgb(0.12, 0.11, 0.1)))
}
