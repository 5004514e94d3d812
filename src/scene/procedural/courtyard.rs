//! A paved terrace under an open sky: brick wall at −X, striped wall with a lamp at −Z, pergola above, fence at +Z, nothing at
//! +X. Three spheres and a box move.

use std::f64::consts::TAU;

use glam::{DQuat, DVec2, DVec3};

use super::parts::{Definition, ball, block, bulb, lamp, rgb, wall};
use crate::{Fence, Lamp, Light, Material, Object, SceneAtTime, Shape, Texture, TurnedBox};

pub(super) const SCENE: Definition =
    Definition { name: "courtyard", region: (DVec3::new(0.0, 1.5, 0.0), DVec3::new(0.3, 0.2, 0.3)), fixed, at };

// Layout of the courtyard, in metres. The terrace and the walls end before the field of view of the +X face begins, so that
// face is empty from the whole probe region.
const FENCE_Z: f64 = 1.3;
const TERRACE_EDGE_X: f64 = 0.9;
const WALL: f64 = -4.0;
const PERGOLA_Y: f64 = 2.9;
const LAMP: DVec3 = DVec3::new(-0.9, 1.75, -3.55);

fn fixed() -> Vec<Object> {
    let wood = Texture::Solid(rgb(0.36, 0.22, 0.12));
    let iron = Texture::Solid(rgb(0.05, 0.055, 0.06));
    let stone = Texture::Solid(rgb(0.55, 0.53, 0.5));

    let paving =
        Texture::Bricks { colors: [rgb(0.46, 0.43, 0.38), rgb(0.24, 0.23, 0.21)], size: [0.8, 0.6], joint: 0.025 };
    let bricks =
        Texture::Bricks { colors: [rgb(0.48, 0.2, 0.13), rgb(0.5, 0.47, 0.42)], size: [0.5, 0.16], joint: 0.02 };
    let masonry =
        Texture::Bricks { colors: [rgb(0.5, 0.46, 0.4), rgb(0.33, 0.31, 0.28)], size: [0.45, 0.3], joint: 0.03 };
    let stripes = Texture::Stripes { colors: [rgb(0.72, 0.66, 0.52), rgb(0.3, 0.42, 0.4)], wave: DVec3::X * 2.5 };
    let planks = Texture::Stripes { colors: [rgb(0.5, 0.34, 0.18), rgb(0.38, 0.24, 0.12)], wave: DVec3::Y * 7.0 };
    let across = DVec3::X * (TERRACE_EDGE_X - WALL + 0.2);

    let mut objects = vec![
        // The ground casts no shadow: nothing is below it, and nearly every shadow ray starts on it.
        wall([WALL - 0.2, 0.0, WALL - 0.2], DVec3::Z * 13.0, across, paving),
        block([WALL - 0.2, 0.0, WALL - 0.2], [WALL, 2.6, 4.0], bricks),
        block([WALL, 0.0, WALL - 0.2], [TERRACE_EDGE_X, 2.4, WALL], stripes),
        // A coping on each wall.
        block([WALL - 0.28, 2.6, WALL - 0.28], [WALL + 0.08, 2.7, 4.08], stone),
        block([WALL, 2.4, WALL - 0.28], [TERRACE_EDGE_X, 2.5, WALL + 0.08], stone),
        // The bracket that holds the lamp.
        block([LAMP.x - 0.02, LAMP.y + 0.12, WALL], [LAMP.x + 0.02, LAMP.y + 0.15, LAMP.z + 0.02], iron),
        // A tower and a tree beyond the fence.
        block([-3.4, 0.0, 5.6], [-2.2, 4.6, 6.8], masonry),
        block([-3.55, 4.6, 5.45], [-2.05, 4.8, 6.95], Texture::Solid(rgb(0.42, 0.16, 0.11))),
        block([-0.08, 0.0, 5.92], [0.08, 1.5, 6.08], wood),
        ball(DVec3::new(0.0, 2.3, 6.0), 0.85, Texture::Solid(rgb(0.12, 0.3, 0.08))),
        ball(DVec3::new(-0.55, 1.85, 5.8), 0.5, Texture::Solid(rgb(0.15, 0.36, 0.09))),
        // A crate and a planter on the terrace.
        block([-3.5, 0.0, 0.9], [-2.8, 0.7, 1.6], planks),
        block([-0.2, 0.0, -3.3], [0.5, 0.45, -2.6], Texture::Solid(rgb(0.5, 0.26, 0.16))),
        ball(DVec3::new(0.15, 0.75, -2.95), 0.42, Texture::Solid(rgb(0.1, 0.26, 0.1))),
        Object::new(
            Shape::Fence(Fence {
                foot: DVec3::new(-3.8, 0.0, FENCE_Z),
                posts: 37,
                spacing: 0.12,
                width: 0.022,
                height: 1.1,
                rails: [0.2, 0.98],
            }),
            Material::diffuse(iron),
        ),
    ];
    // The pergola: two beams on posts, five slats across.
    for z in [-1.5, 1.5] {
        objects.push(block([WALL, PERGOLA_Y - 0.12, z - 0.05], [0.35, PERGOLA_Y, z + 0.05], wood));
        objects.push(block([0.1, 0.0, z - 0.05], [0.2, PERGOLA_Y - 0.12, z + 0.05], wood));
    }
    for slat in 0..5 {
        let x = -2.6 + 0.68 * f64::from(slat);
        objects.push(block([x - 0.04, PERGOLA_Y, -1.75], [x + 0.04, PERGOLA_Y + 0.1, 1.75], wood));
    }
    objects
}

fn at(phase: f64, mut objects: Vec<Object>) -> SceneAtTime {
    let (sin, cos) = (TAU * phase).sin_cos();

    // A beach ball moves along a circle and bounces four times, in parabolas.
    let hop = (4.0 * phase).fract();
    let bounce = DVec3::new(-2.1 + 0.5 * cos, 0.32 + 2.6 * hop * (1.0 - hop), -0.1 + 0.8 * sin);
    let stripes = Texture::Stripes { colors: [rgb(0.75, 0.08, 0.05), rgb(0.8, 0.78, 0.7)], wave: DVec3::X * 6.0 };
    objects.push(Object { texture_from_world: DQuat::from_rotation_z(-TAU * phase), ..ball(bounce, 0.32, stripes) });

    // A blue ball rolls back and forth in front of the striped wall without slipping.
    let roll_x = -1.1 + 0.9 * sin;
    let checker = Texture::Checker { colors: [rgb(0.06, 0.16, 0.6), rgb(0.7, 0.72, 0.75)], size: 0.25 };
    let blue_ball = ball(DVec3::new(roll_x, 0.28, -2.0), 0.28, checker);
    objects.push(Object { texture_from_world: DQuat::from_rotation_z(roll_x / 0.28), ..blue_ball });

    // A golden ball hovers beyond the fence, visible between and above the posts.
    let hover = DVec3::new(-0.9 + 0.8 * cos, 1.15 + 0.45 * (2.0 * TAU * phase).sin(), 2.5 + 0.4 * sin);
    objects.push(ball(hover, 0.2, Texture::Solid(rgb(0.8, 0.52, 0.1))));

    // A box rotates in place, once per period.
    let cube = TurnedBox { center: DVec3::new(-2.7, 0.4, -2.5), half: DVec3::splat(0.4), turn: DVec2::new(cos, sin) };
    let tiles = Texture::Checker { colors: [rgb(0.7, 0.6, 0.1), rgb(0.16, 0.1, 0.2)], size: 0.27 };
    let texture_from_world = DQuat::from_rotation_y(-TAU * phase);
    let turning = Object::new(Shape::TurnedBox(cube), Material::diffuse(tiles));
    objects.push(Object { anchor: cube.center, texture_from_world, ..turning });

    // The lamp's radiance is a triangle wave: between two frames on the same slope, lit pixels are linear blends of them.
    let pulse = 1.0 - (2.0 * phase - 1.0).abs();
    let glow = 6.0 + 14.0 * pulse;
    let warm = rgb(1.0, 0.78, 0.45);
    objects.push(bulb(LAMP, 0.12, glow * warm));
    let lamp = Lamp { reach: 2.0, ..lamp(LAMP, 0.12 * glow * warm) };
    SceneAtTime::new(objects, Light { lamps: vec![lamp], ..Light::default() })
}

#[cfg(test)]
mod tests {
    use half::f16;

    use super::super::{DemoKind, DemoScene};
    use super::*;
    use crate::mesh::AxisBox;
    use crate::{capture_face, trace};
    use codec::image::{DepthPlane, Face};

    const TIMES: [f64; 5] = [0.0, 0.7, 1.5, 2.9, 3.95];

    fn courtyard() -> DemoScene {
        DemoScene::new(DemoKind::Courtyard)
    }

    /// Returns the centre and the eight corners of the probe region.
    fn probes() -> Vec<DVec3> {
        let (middle, half) = courtyard().probe_region();
        let region = AxisBox { min: middle - half, max: middle + half };
        [middle].into_iter().chain(region.corners()).collect()
    }

    #[test]
    fn empty_side_is_empty_from_every_probe() {
        for time in TIMES {
            let scene = courtyard().at(time);
            let sky = scene.light.sky.horizon.to_array().map(f16::from_f64);
            for probe in probes() {
                let (color, depth) = capture_face(&scene, probe, Face::Px, 32).unwrap();
                assert!(depth.data().iter().all(|&d| d == f32::INFINITY), "{probe} at {time} s");
                assert!(color.data().iter().all(|&c| c == sky), "{probe} at {time} s");
            }
        }
    }

    #[test]
    fn nothing_comes_near_a_probe() {
        for time in TIMES {
            for probe in probes() {
                for face in Face::CUBE {
                    let (_, depth) = capture_face(&courtyard().at(time), probe, face, 24).unwrap();
                    assert!(depth.data().iter().all(|&d| d > 0.9), "{face:?} of {probe} at {time} s");
                }
            }
        }
    }

    #[test]
    fn pergola_and_sky_never_change() {
        let (probe, _) = courtyard().probe_region();
        let first = capture_face(&courtyard().at(0.0), probe, Face::Py, 64).unwrap();
        assert!(first.1.data().iter().any(|d| d.is_finite()));
        for time in TIMES {
            assert_eq!(capture_face(&courtyard().at(time), probe, Face::Py, 64).unwrap(), first, "{time} s");
        }
    }

    #[test]
    fn most_is_static_and_something_moves() {
        let (probe, _) = courtyard().probe_region();
        for face in [Face::Nx, Face::Pz, Face::Nz] {
            let [a, b] =
                [1.0, 1.0 + 1.0 / 24.0].map(|time| capture_face(&courtyard().at(time), probe, face, 96).unwrap());
            let same_depth = a.1.data().iter().zip(b.1.data()).filter(|(a, b)| a == b).count();
            let same_color = a.0.data().iter().zip(b.0.data()).filter(|(a, b)| a == b).count();
            let all = 96 * 96;
            assert!(same_depth < all && same_depth * 100 > all * 90, "{face:?}: {same_depth}");
            assert!(same_color < all && same_color * 100 > all * 50, "{face:?}: {same_color}");
        }
    }

    #[test]
    fn it_repeats_and_takes_any_time() {
        let (probe, _) = courtyard().probe_region();
        let at = |time: f64| capture_face(&courtyard().at(time), probe, Face::Nx, 24).unwrap();
        assert_eq!(at(1.5), at(1.5 + DemoScene::PERIOD_S));
        assert_eq!(at(-1.0), at(3.0));
        assert_eq!(at(f64::NAN), at(0.0));
        assert_eq!(at(f64::INFINITY), at(0.0));
    }

    #[test]
    fn lamp_changes_the_wall_linearly() {
        let (probe, _) = courtyard().probe_region();
        let target = DVec3::new(-0.4, 2.0, WALL);
        let [a, b, c] = [0.4, 0.9, 1.4].map(|time| trace(&courtyard().at(time), probe, target - probe));
        assert_eq!((a.object, a.distance), (c.object, c.distance));
        assert!((c.color - a.color).min_element() > 0.1, "{} {}", a.color, c.color);
        assert!((0.5 * (a.color + c.color) - b.color).abs().max_element() < 1e-12);
    }

    #[test]
    fn the_lamp_is_far_brighter_than_white() {
        let (probe, _) = courtyard().probe_region();
        let hit = trace(&courtyard().at(2.0), probe, LAMP - probe);
        assert_eq!(hit.color.x, 20.0);
    }

    /// Returns the number of depth changes above 10% between adjacent pixels of a row.
    fn jumps(depth: &DepthPlane, row: u32) -> usize {
        depth.row(row).windows(2).filter(|pair| (pair[0] / pair[1]).ln().abs() > 0.1).count()
    }

    #[test]
    fn fence_posts_are_one_to_three_pixels() {
        let (probe, _) = courtyard().probe_region();
        let (_, depth) = capture_face(&courtyard().at(0.0), probe, Face::Pz, 128).unwrap();
        // Halfway between the rails a 90° view from 1.3 m contains about 13 posts, each with two edges.
        let row = 107;
        assert!(jumps(&depth, row) >= 22, "{}", jumps(&depth, row));
        let near = |d: f32| d < 2.2;
        let runs: Vec<usize> =
            depth.row(row).chunk_by(|a, b| near(*a) == near(*b)).filter(|run| near(run[0])).map(<[f32]>::len).collect();
        // Only the pergola's post is wider.
        assert!(runs.iter().filter(|&&run| run > 3).count() <= 1, "{runs:?}");
        assert!(runs.iter().filter(|&&run| run <= 3).count() >= 11, "{runs:?}");
    }
}
