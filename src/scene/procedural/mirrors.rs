//! A closed room, four metres by three by four, with a static glass sphere and a mirror sphere that orbits it.

use std::f64::consts::TAU;

use glam::DVec3;

use super::parts::{Definition, ball, block, bulb, indoors, lamp, rgb, room};
use crate::mesh::AxisBox;
use crate::{Object, Optics, Phong, SceneAtTime, Texture};

pub(super) const SCENE: Definition =
    Definition { name: "mirrors", region: (DVec3::new(0.0, 1.6, 1.1), DVec3::new(0.3, 0.15, 0.2)), fixed, at };

const INSIDE: AxisBox = AxisBox { min: DVec3::new(-2.0, 0.0, -2.0), max: DVec3::new(2.0, 3.0, 2.0) };
const BULB: DVec3 = DVec3::new(0.3, 2.7, 0.2);

fn fixed() -> Vec<Object> {
    let mut objects = room(
        INSIDE,
        [
            Texture::Checker { colors: [rgb(0.7, 0.68, 0.62), rgb(0.12, 0.13, 0.15)], size: 0.5 },
            Texture::Solid(rgb(0.72, 0.72, 0.7)),
            Texture::Solid(rgb(0.55, 0.12, 0.1)),
            Texture::Solid(rgb(0.12, 0.3, 0.5)),
            Texture::Stripes { colors: [rgb(0.62, 0.58, 0.48), rgb(0.38, 0.36, 0.33)], wave: DVec3::X * 2.0 },
            Texture::Bricks { colors: [rgb(0.44, 0.4, 0.34), rgb(0.24, 0.22, 0.2)], size: [0.6, 0.3], joint: 0.02 },
        ],
    );
    objects.push(block([-1.5, 0.0, -1.7], [-0.9, 0.6, -1.1], Texture::Solid(rgb(0.6, 0.45, 0.12))));
    let mut glass = ball(DVec3::new(0.1, 0.5, -0.5), 0.45, Texture::Solid(DVec3::ZERO));
    glass.material.optics = Optics::Glass { ior: 1.5, tint: DVec3::splat(0.98) };
    glass.material.phong = Phong { weight: DVec3::splat(0.04), exponent: 400.0 };
    objects.push(glass);
    objects.push(bulb(BULB, 0.12, rgb(16.0, 14.5, 12.0)));
    objects
}

fn at(phase: f64, mut objects: Vec<Object>) -> SceneAtTime {
    let (sin, cos) = (TAU * phase).sin_cos();
    let mut mirror = ball(DVec3::new(0.1 + 1.2 * cos, 0.4, -0.5 + 0.95 * sin), 0.4, Texture::Solid(DVec3::ZERO));
    mirror.material.optics = Optics::Mirror { tint: DVec3::splat(0.95) };
    objects.push(mirror);
    SceneAtTime::new(objects, indoors(vec![lamp(BULB, rgb(1.8, 1.65, 1.4))], rgb(0.2, 0.2, 0.2)))
}
