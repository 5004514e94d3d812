//! A stall within reach: a toy train on tiles, a glass globe, a bottle, oranges, a pinwheel. Also the round bodies of the street.

use std::f64::consts::{FRAC_PI_2, TAU};
use std::sync::{Arc, LazyLock};

use glam::{DVec2, DVec3};

use super::super::lathe::{Lathe, Sides};
use super::super::parts::{ball, block, rgb, wall};
use crate::mesh::{Material, Mesh};
use crate::{MeshMaterial, Object, Optics, Phong, SceneMesh, Shape, Texture, TurnedBox};

/// Height of the table, metres.
const TABLE_Y: f64 = 1.08;
/// Centre of the track on its tray, and its radius, metres.
const TRACK: DVec3 = DVec3::new(-0.32, TABLE_Y + 0.012, -1.25);
const TRACK_M: f64 = 0.235;
const GLOBE: DVec3 = DVec3::new(0.36, TABLE_Y + 0.16, -1.24);
const HUB: DVec3 = DVec3::new(-0.8, 1.5, -1.38);

pub(super) fn objects() -> Vec<Object> {
    let wood =
        Texture::Planks { colors: [rgb(0.45, 0.27, 0.13), rgb(0.27, 0.14, 0.06)], size: [1.9, 0.14], joint: 0.004 };
    let tiles = Texture::Tiles {
        colors: [rgb(0.62, 0.6, 0.52), rgb(0.07, 0.17, 0.42), rgb(0.3, 0.29, 0.27)],
        size: 0.08,
        joint: 0.004,
    };
    let cloth = Texture::Cloth {
        colors: [rgb(0.55, 0.12, 0.1), rgb(0.7, 0.62, 0.48)],
        wave: DVec3::X * 14.0,
        weft: DVec3::new(0.0, 110.0, 110.0),
    };
    let mut objects = vec![
        block([-0.95, TABLE_Y - 0.05, -1.62], [0.95, TABLE_Y, -0.9], wood),
        block([-0.64, TABLE_Y, -1.55], [0.0, TABLE_Y + 0.01, -0.95], tiles),
        block([0.14, TABLE_Y, -1.622], [0.86, TABLE_Y + 0.003, -0.898], cloth),
        wall([0.14, 0.72, -0.897], DVec3::X * 0.72, DVec3::Y * 0.363, cloth),
        block([HUB.x - 0.006, TABLE_Y, HUB.z - 0.04], [HUB.x + 0.006, HUB.y, HUB.z - 0.03], wood),
    ];
    for x in [-0.9, 0.84] {
        for z in [-1.58, -0.98] {
            objects.push(block([x, 0.0, z], [x + 0.06, TABLE_Y - 0.05, z + 0.06], wood));
        }
    }
    // A house inside the track.
    let front = Texture::Solid(rgb(0.7, 0.6, 0.4));
    objects.push(block(
        [TRACK.x - 0.07, TABLE_Y, TRACK.z - 0.08],
        [TRACK.x + 0.03, TABLE_Y + 0.1, TRACK.z + 0.01],
        front,
    ));
    let mut globe = ball(GLOBE, 0.12, Texture::Solid(DVec3::ZERO));
    globe.material.optics = Optics::Glass { ior: 1.5, tint: DVec3::splat(0.98) };
    globe.material.phong = Phong { weight: DVec3::splat(0.04), exponent: 400.0 };
    objects.push(globe);
    for (x, y, z) in [(0.66, 0.075, -1.04), (0.74, 0.075, -1.08), (0.7, 0.075, -1.14), (0.7, 0.125, -1.09)] {
        let peel = Texture::Mottled { colors: [rgb(0.9, 0.4, 0.04), rgb(0.78, 0.29, 0.02)], size: 0.02 };
        let mut orange = ball(DVec3::new(x, TABLE_Y + y, z), 0.042, peel);
        orange.material.phong = Phong { weight: DVec3::splat(0.06), exponent: 30.0 };
        objects.push(orange);
    }
    objects
}

/// Returns the train and the pinwheel at a phase of the period.
pub(super) fn moving(phase: f64) -> Vec<Object> {
    let mut objects = Vec::new();
    let (red, black, blue, green) =
        (rgb(0.6, 0.05, 0.03), rgb(0.04, 0.04, 0.045), rgb(0.05, 0.16, 0.5), rgb(0.08, 0.35, 0.12));
    // Angle behind the engine's middle, height of the middle, half extents across, up and along; colour.
    let parts = [
        (0.0, 0.03, [0.026, 0.012, 0.06], black),
        (0.05, 0.062, [0.02, 0.02, 0.034], red),
        (-0.16, 0.075, [0.025, 0.034, 0.022], red),
        (-0.16, 0.113, [0.03, 0.004, 0.028], black),
        (0.17, 0.09, [0.008, 0.022, 0.008], black),
        (-0.62, 0.05, [0.024, 0.026, 0.05], blue),
        (-1.12, 0.05, [0.024, 0.026, 0.05], green),
    ];
    for (behind, height, half, color) in parts {
        let angle = TAU * phase - 1.3 + behind;
        let (sin, cos) = angle.sin_cos();
        let center = TRACK + DVec3::new(TRACK_M * cos, height, -TRACK_M * sin);
        // Its long side points along the track.
        let turn = DVec2::new(cos, sin);
        let shape = Shape::TurnedBox(TurnedBox { center, half: half.into(), turn });
        let mut part = Object::new(shape, crate::Material::diffuse(Texture::Solid(color)));
        part.material.phong = Phong { weight: DVec3::splat(0.08), exponent: 40.0 };
        objects.push(part);
    }
    for wheel in 0..8 {
        // Blades overlap like those of folded paper.
        let angle = FRAC_PI_2 * 0.5 * f64::from(wheel) - 0.25 * TAU * phase;
        let (sin, cos) = angle.sin_cos();
        let (u, v) = (0.11 * DVec3::new(cos, sin, 0.0), 0.05 * DVec3::new(-sin, cos, 0.0));
        let paper = [rgb(0.75, 0.1, 0.07), rgb(0.85, 0.7, 0.2), rgb(0.1, 0.35, 0.6), rgb(0.8, 0.75, 0.65)];
        let color = paper.iter().cycle().nth(wheel as usize).copied().unwrap_or(DVec3::ONE);
        let corner = HUB + DVec3::Z * (0.002 * f64::from(wheel % 2));
        objects.push(wall(corner.to_array(), u, v, Texture::Solid(color)));
    }
    objects.push(ball(HUB + DVec3::Z * 0.008, 0.014, Texture::Solid(rgb(0.6, 0.45, 0.1))));
    objects
}

/// Returns the round bodies: those on the table, and roofs far away.
pub(super) fn meshes() -> Vec<Arc<SceneMesh>> {
    static MESHES: LazyLock<Vec<Arc<SceneMesh>>> = LazyLock::new(|| vec![bottle(), table_ware(), roofs()]);
    MESHES.clone()
}

fn painted(base_color: DVec3, phong: Phong) -> MeshMaterial {
    MeshMaterial { plain: Material { base_color, ..Material::default() }, phong, ..MeshMaterial::default() }
}

/// Returns the glass bottle, apart from the rest: parts of images with glass are not copied from other frames.
fn bottle() -> Arc<SceneMesh> {
    let phong = Phong { weight: DVec3::splat(0.04), exponent: 300.0 };
    let optics = Optics::Glass { ior: 1.5, tint: rgb(0.8, 0.95, 0.84) };
    let glass = MeshMaterial { optics, ..painted(DVec3::ZERO, phong) };
    // The bottle's outside, lip and inside.
    let bottle = [
        [0.0, 0.004],
        [0.036, 0.004],
        [0.04, 0.01],
        [0.04, 0.17],
        [0.038, 0.185],
        [0.03, 0.205],
        [0.02, 0.222],
        [0.015, 0.24],
        [0.014, 0.29],
        [0.017, 0.292],
        [0.017, 0.305],
        [0.011, 0.305],
        [0.011, 0.24],
        [0.016, 0.22],
        [0.026, 0.203],
        [0.034, 0.184],
        [0.036, 0.17],
        [0.036, 0.018],
        [0.0, 0.018],
    ];
    let foot = DVec3::new(0.56, TABLE_Y, -1.42);
    let mut mesh = Mesh::default();
    Lathe { foot, profile: &bottle, sides: Sides::Round(40), material: 0 }.add_to(&mut mesh);
    Arc::new(SceneMesh::new(mesh, [glass].into()))
}

fn table_ware() -> Arc<SceneMesh> {
    let shine = |weight: f64, exponent: f64| Phong { weight: DVec3::splat(weight), exponent };
    let materials = [
        painted(rgb(0.4, 0.18, 0.09), shine(0.0, 1.0)),
        painted(rgb(0.5, 0.34, 0.1), shine(0.4, 50.0)),
        painted(rgb(0.08, 0.2, 0.06), shine(0.0, 1.0)),
        painted(rgb(0.45, 0.1, 0.06), shine(0.0, 1.0)),
        painted(rgb(0.06, 0.05, 0.045), shine(0.1, 30.0)),
        painted(rgb(0.12, 0.24, 0.42), shine(0.2, 60.0)),
    ];
    let mut mesh = Mesh::default();
    let mut add = |[x, y, z]: [f64; 3], profile: &[[f64; 2]], sides: Sides, material: u32| {
        Lathe { foot: DVec3::new(x, TABLE_Y + y, z), profile, sides, material }.add_to(&mut mesh);
    };
    let pot = [
        [0.0, 0.0],
        [0.05, 0.0],
        [0.07, 0.1],
        [0.078, 0.1],
        [0.078, 0.125],
        [0.066, 0.125],
        [0.062, 0.11],
        [0.0, 0.11],
    ];
    add([HUB.x, 0.0, HUB.z - 0.035], &pot, Sides::Round(32), 0);
    let stand = [
        [0.0, 0.0],
        [0.085, 0.0],
        [0.085, 0.012],
        [0.045, 0.025],
        [0.04, 0.04],
        [0.062, 0.06],
        [0.055, 0.064],
        [0.0, 0.05],
    ];
    add([GLOBE.x, 0.003, GLOBE.z], &stand, Sides::Round(40), 1);
    for ([x, z], size) in [([0.08, -0.06], 1.0), ([0.05, 0.09], 0.8), ([-0.12, 0.08], 0.9)] {
        let tree =
            [[0.0, 0.012], [0.045, 0.02], [0.024, 0.07], [0.036, 0.072], [0.0, 0.14]].map(|at| at.map(|at| size * at));
        add([TRACK.x + x, 0.01, TRACK.z + z], &tree, Sides::Round(20), 2);
    }
    add([TRACK.x - 0.02, 0.1, TRACK.z - 0.035], &[[0.08, 0.0], [0.0, 0.06]], Sides::Flat(4), 3);
    let rails = [[TRACK_M - 0.026, 0.01], [TRACK_M - 0.026, 0.018], [TRACK_M + 0.026, 0.018], [TRACK_M + 0.026, 0.01]];
    let outside_first = [rails[3], rails[2], rails[1], rails[0]];
    add([TRACK.x, 0.0, TRACK.z], &outside_first, Sides::Round(64), 4);
    let bowl = [[0.0, 0.0], [0.04, 0.0], [0.075, 0.03], [0.1, 0.07], [0.096, 0.07], [0.07, 0.035], [0.0, 0.03]];
    add([0.7, 0.003, -1.09], &bowl, Sides::Round(40), 5);
    Arc::new(SceneMesh::new(mesh, materials.into()))
}

fn roofs() -> Arc<SceneMesh> {
    let matt = Phong::default();
    let materials = [
        painted(rgb(0.2, 0.13, 0.11), matt),
        painted(rgb(0.5, 0.36, 0.1), Phong { weight: DVec3::splat(0.3), exponent: 40.0 }),
    ];
    let mut mesh = Mesh::default();
    let foot = DVec3::new(0.95, 7.65, -29.6);
    Lathe { foot, profile: &[[2.5, 0.0], [1.4, 1.1], [0.0, 3.4]], sides: Sides::Flat(4), material: 0 }
        .add_to(&mut mesh);
    let knob = [[0.0, 0.0], [0.12, 0.1], [0.05, 0.25], [0.0, 0.7]];
    Lathe { foot: foot + DVec3::Y * 3.3, profile: &knob, sides: Sides::Round(12), material: 1 }.add_to(&mut mesh);
    Arc::new(SceneMesh::new(mesh, materials.into()))
}
