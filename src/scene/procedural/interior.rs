//! A closed room, six metres by three by five: brick and striped walls, a table, a shelf, a lattice of thin bars, two lamps.
//! One sphere bounces, one rolls, and one hovers behind the lattice.

use std::f64::consts::TAU;

use glam::{DQuat, DVec3};

use super::parts::{Definition, ball, block, bulb, indoors, lamp, rgb, room};
use crate::mesh::AxisBox;
use crate::{CastsShadow, Cone, Fence, Lamp, Material, Object, Phong, SceneAtTime, Shape, Texture};

pub(super) const SCENE: Definition =
    Definition { name: "interior", region: (DVec3::new(0.0, 1.5, 0.3), DVec3::new(0.3, 0.2, 0.3)), fixed, at };

const INSIDE: AxisBox = AxisBox { min: DVec3::new(-3.0, 0.0, -2.5), max: DVec3::new(3.0, 3.0, 2.5) };
const BULBS: [DVec3; 2] = [DVec3::new(-1.6, 2.6, -0.4), DVec3::new(1.7, 2.6, 0.8)];

fn fixed() -> Vec<Object> {
    let wood = Texture::Stripes { colors: [rgb(0.42, 0.26, 0.14), rgb(0.36, 0.21, 0.11)], wave: DVec3::X * 5.0 };
    let white = Texture::Solid(rgb(0.74, 0.72, 0.68));
    let mut objects = room(
        INSIDE,
        [
            Texture::Bricks { colors: [rgb(0.4, 0.27, 0.16), rgb(0.15, 0.1, 0.07)], size: [1.2, 0.16], joint: 0.008 },
            white,
            Texture::Bricks { colors: [rgb(0.5, 0.24, 0.16), rgb(0.5, 0.47, 0.42)], size: [0.4, 0.13], joint: 0.015 },
            Texture::Stripes { colors: [rgb(0.62, 0.6, 0.46), rgb(0.32, 0.42, 0.46)], wave: DVec3::Z * 3.0 },
            Texture::Solid(rgb(0.5, 0.56, 0.5)),
            Texture::Checker { colors: [rgb(0.6, 0.56, 0.5), rgb(0.4, 0.36, 0.34)], size: 0.5 },
        ],
    );
    // A table.
    objects.push(block([1.2, 0.7, -1.9], [2.6, 0.76, -1.0], wood));
    for x in [1.25, 2.49] {
        for z in [-1.85, -1.11] {
            objects.push(block([x, 0.0, z], [x + 0.06, 0.7, z + 0.06], wood));
        }
    }
    let mut bowl = ball(DVec3::new(1.9, 0.96, -1.45), 0.2, Texture::Solid(rgb(0.1, 0.3, 0.34)));
    bowl.material.phong = Phong { weight: DVec3::splat(0.25), exponent: 60.0 };
    objects.push(bowl);
    // A shelf on the +X wall, with boxes on it.
    for y in [0.5, 1.1, 1.7] {
        objects.push(block([2.7, y, 0.6], [3.0, y + 0.03, 2.2], wood));
    }
    for book in 0..9 {
        let z = 0.66 + 0.16 * f64::from(book);
        let height = 0.3 + 0.02 * f64::from(book * 7 % 5);
        let shade = 0.15 + 0.06 * f64::from(book * 5 % 9);
        let cover = Texture::Solid(rgb(shade, 0.3, 0.7 - shade));
        objects.push(block([2.75, 1.13, z], [2.98, 1.13 + height, z + 0.11], cover));
    }
    let lattice = Fence {
        foot: DVec3::new(-2.6, 0.0, -1.2),
        posts: 24,
        spacing: 0.11,
        width: 0.018,
        height: 1.9,
        rails: [0.1, 1.85],
    };
    objects.push(Object::new(Shape::Fence(lattice), Material::diffuse(Texture::Solid(rgb(0.07, 0.06, 0.05)))));
    for (at, emission) in BULBS.into_iter().zip([rgb(14.0, 11.0, 7.0), rgb(9.0, 9.5, 11.0)]) {
        let (foot, top) = ([at.x - 0.01, at.y, at.z - 0.01], [at.x + 0.01, INSIDE.max.y, at.z + 0.01]);
        objects.push(block(foot, top, Texture::Solid(rgb(0.05, 0.05, 0.05))));
        objects.push(bulb(at, 0.1, emission));
    }
    for object in &mut objects {
        // Its shadow would only fall on the ceiling.
        if object.bounds.max.y >= INSIDE.max.y {
            object.casts_shadow = CastsShadow::No;
        }
    }
    objects
}

fn at(phase: f64, mut objects: Vec<Object>) -> SceneAtTime {
    let (sin, cos) = (TAU * phase).sin_cos();
    let hop = (3.0 * phase).fract();
    let bounce = DVec3::new(1.5 + 0.4 * cos, 0.25 + 2.8 * hop * (1.0 - hop), 1.4 + 0.4 * sin);
    let stripes = Texture::Stripes { colors: [rgb(0.7, 0.1, 0.06), rgb(0.76, 0.74, 0.66)], wave: DVec3::X * 7.0 };
    let mut bouncing = ball(bounce, 0.25, stripes);
    bouncing.texture_from_world = DQuat::from_rotation_y(-TAU * phase);
    bouncing.material.phong = Phong { weight: DVec3::splat(0.15), exponent: 40.0 };
    objects.push(bouncing);

    let roll_x = -1.2 + 1.1 * sin;
    let checker = Texture::Checker { colors: [rgb(0.08, 0.2, 0.55), rgb(0.66, 0.68, 0.7)], size: 0.2 };
    let rolling = ball(DVec3::new(roll_x, 0.22, 1.7), 0.22, checker);
    objects.push(Object { texture_from_world: DQuat::from_rotation_z(roll_x / 0.22), ..rolling });

    let hover = DVec3::new(-1.3 + 0.9 * cos, 1.1 + 0.4 * (2.0 * TAU * phase).sin(), -1.85);
    objects.push(ball(hover, 0.18, Texture::Solid(rgb(0.8, 0.55, 0.12))));

    let cone = Some(Cone { axis: DVec3::NEG_Y, cos_inner: 0.3, cos_outer: -0.7 });
    let lamps = [lamp(BULBS[0], rgb(1.5, 1.2, 0.8)), lamp(BULBS[1], rgb(1.0, 1.05, 1.2))];
    let lamps = lamps.map(|lamp| Lamp { cone, ..lamp }).to_vec();
    SceneAtTime::new(objects, indoors(lamps, rgb(0.16, 0.155, 0.15)))
}
