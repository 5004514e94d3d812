//! Thin objects outdoors: a fence of rods at +Z, wire mesh at −X, wires against the sky at −Z, leaves at +X, and ground up to
//! 300 m away. A ball rolls behind the rods.
//!
//! In 128² faces seen from the centre of the region, a rod is about a pixel wide, a wire of the mesh a fifth of a pixel, and a
//! wire against the sky half a pixel.

use std::f64::consts::TAU;

use glam::{DQuat, DVec3};

use super::parts::{Definition, ball, block, rgb, wall};
use crate::{Fence, Light, Material, Object, Quad, SceneAtTime, Shape, Texture};

pub(super) const SCENE: Definition =
    Definition { name: "fence", region: (DVec3::new(0.0, 1.5, 0.0), DVec3::new(0.4, 0.2, 0.4)), fixed, at };

const GROUND_M: f64 = 300.0;
const FENCE_Z: f64 = 2.0;
const MESH_X: f64 = -2.2;
const MESH_STEP: f64 = 0.15;
const TREE: DVec3 = DVec3::new(3.2, 2.1, 0.3);
const LEAVES: u32 = 240;

fn fixed() -> Vec<Object> {
    let steel = Texture::Solid(rgb(0.42, 0.43, 0.45));
    let dark = Texture::Solid(rgb(0.06, 0.06, 0.065));
    let bark = Texture::Solid(rgb(0.24, 0.17, 0.11));
    let planks = Texture::Stripes { colors: [rgb(0.52, 0.4, 0.27), rgb(0.4, 0.29, 0.18)], wave: DVec3::X * 3.0 };
    let grass = Texture::Checker { colors: [rgb(0.2, 0.3, 0.09), rgb(0.25, 0.34, 0.12)], size: 1.5 };
    let ground = wall([-GROUND_M, 0.0, -GROUND_M], DVec3::Z * (2.0 * GROUND_M), DVec3::X * (2.0 * GROUND_M), grass);
    let rods = Fence {
        foot: DVec3::new(-2.4, 0.0, FENCE_Z),
        posts: 33,
        spacing: 0.15,
        width: 0.03,
        height: 1.9,
        rails: [0.3, 1.7],
    };
    let mut objects = vec![
        ground,
        Object::new(Shape::Fence(rods), Material::diffuse(dark)),
        // A wall of planks and a tower behind the rods.
        block([-3.0, 0.0, 6.0], [0.4, 2.6, 6.2], planks),
        block([1.6, 0.0, 9.0], [3.6, 5.0, 11.0], Texture::Solid(rgb(0.5, 0.42, 0.34))),
        // A shed behind the mesh.
        block([-7.0, 0.0, -2.0], [-5.0, 2.4, 1.0], Texture::Solid(rgb(0.46, 0.18, 0.12))),
        block([TREE.x - 0.07, 0.0, TREE.z - 0.07], [TREE.x + 0.07, TREE.y, TREE.z + 0.07], bark),
    ];
    // Wire mesh between two posts, welded at right angles.
    let [wire, thick] = [0.003, 0.03];
    for at in 0..=20 {
        let z = -1.5 + MESH_STEP * f64::from(at);
        let half = if at % 20 == 0 { thick } else { wire };
        objects.push(block([MESH_X - half, 0.0, z - half], [MESH_X + half, 2.1, z + half], steel));
    }
    for at in 0..=14 {
        let y = MESH_STEP * f64::from(at);
        objects.push(block([MESH_X - wire, y - wire, -1.5], [MESH_X + wire, y + wire, 1.5], steel));
    }
    // Two poles with five wires.
    for x in [-7.0, 6.0] {
        objects.push(block([x - 0.1, 0.0, -5.1], [x + 0.1, 5.4, -4.9], bark));
    }
    for at in 0..5 {
        let [y, z] = [3.0 + 0.5 * f64::from(at), -5.0 + 0.1 * f64::from(at)];
        objects.push(block([-7.0, y - 0.02, z - 0.02], [6.0, y + 0.02, z + 0.02], dark));
    }
    objects.extend((0..LEAVES).map(leaf));
    objects
}

/// Returns a leaf of 10 by 5 cm, one of many in a tree crown.
fn leaf(number: u32) -> Object {
    // Multiples of square roots of primes fill the unit cube evenly.
    let unit = |root: f64| (f64::from(number) * root.sqrt()).fract();
    let [around, up, out, turn, tilt] = [2.0, 3.0, 5.0, 7.0, 11.0].map(unit);
    let (sin, cos) = (TAU * around).sin_cos();
    let radius = 0.9 * out.sqrt();
    let middle = TREE + DVec3::new(radius * cos, 1.4 * up - 0.4, radius * sin);
    let turned = DQuat::from_rotation_y(TAU * turn) * DQuat::from_rotation_x(2.4 * tilt - 1.2);
    let [u, v] = [turned * (DVec3::X * 0.1), turned * (DVec3::Z * 0.05)];
    let green = Texture::Solid(rgb(0.1, 0.26, 0.06).lerp(rgb(0.3, 0.42, 0.1), up));
    Object::new(Shape::Quad(Quad { corner: middle - 0.5 * (u + v), u, v }), Material::diffuse(green))
}

fn at(phase: f64, mut objects: Vec<Object>) -> SceneAtTime {
    let x = 1.2 * (TAU * phase).sin();
    let stripes = Texture::Stripes { colors: [rgb(0.75, 0.08, 0.05), rgb(0.8, 0.78, 0.7)], wave: DVec3::Y * 5.0 };
    let rolling = ball(DVec3::new(x, 0.35, FENCE_Z + 1.2), 0.35, stripes);
    objects.push(Object { texture_from_world: DQuat::from_rotation_z(x / 0.35), ..rolling });
    SceneAtTime::new(objects, Light::default())
}

#[cfg(test)]
mod tests {
    use super::super::{DemoKind, DemoScene};
    use crate::capture_face;
    use codec::image::{DepthPlane, Face};

    fn depth(face: Face, size: u32) -> DepthPlane {
        let scene = DemoScene::new(DemoKind::Fence);
        capture_face(&scene.at(0.0), scene.probe_region().0, face, size).unwrap().1
    }

    /// Returns the lengths of runs of pixels in a row that are nearer than `near_m`.
    fn runs(depth: &DepthPlane, row: u32, near_m: f32) -> Vec<usize> {
        let chunks = depth.row(row).chunk_by(|a, b| (*a < near_m) == (*b < near_m));
        chunks.filter(|run| run[0] < near_m).map(<[f32]>::len).collect()
    }

    #[test]
    fn rods_are_a_pixel_wide_and_wires_of_the_mesh_less() {
        let rods = runs(&depth(Face::Pz, 128), 70, 3.0);
        assert!(rods.len() >= 20 && rods.iter().all(|&run| run <= 2), "{rods:?}");
        let mesh = |size: u32| runs(&depth(Face::Nx, size), size / 2 - size / 32, 3.2).len();
        // In small faces most wires fall between pixel centres.
        assert!(mesh(1024) >= 19 && mesh(128) < 12, "{} {}", mesh(1024), mesh(128));
    }

    #[test]
    fn wires_and_leaves_stand_before_the_sky_and_the_ground_goes_far() {
        let sky = depth(Face::Nz, 512);
        let column: Vec<f32> = (0..256).map(|y| sky.get(256, y)).collect();
        let wires = column.chunk_by(|a, b| a.is_finite() == b.is_finite()).filter(|run| run[0].is_finite()).count();
        assert!(wires >= 5, "{wires}");
        let leaves = depth(Face::Px, 256);
        // Above the horizon there is no ground.
        let above = &leaves.data()[..256 * 128];
        let found = above.iter().filter(|&&metres| metres < 5.0).count();
        assert!((300..3000).contains(&found), "{found}");
        let far = leaves.data().iter().filter(|metres| metres.is_finite()).fold(0.0f32, |a, &b| a.max(b));
        assert!(far > 100.0, "{far}");
    }
}
