//! Hard cases of ray intersection: cameras in bad places, degenerate and duplicated triangles, all sizes, edges, large
//! distances.
//!
//! Everything is binary64 on the CPU; nothing runs on a graphics device. The triangulated ball has its corners at
//! integer steps of octants, so that adjacent triangles share bit-identical corners.

use std::sync::Arc;

use glam::DVec3;

use crate::case::{Bound, Family, Group, HardCase, Measured, ROUNDING};
use codec::math::random::Random;
use scene::mesh::{AxisBox, Mesh, Ray};
use scene::{
    Lamp, Light, Material, MeshMaterial, Object, Optics, SceneAtTime, SceneMesh, Shape, Sphere, Texture, Window, trace,
};

/// Scene size in metres, distance from the origin in multiples of the size, and name.
const SIZES: [(f64, f64, &str); 4] =
    [(1.0, 0.0, "1 m"), (1e-6, 0.0, "a micrometre"), (1e6, 0.0, "1000 km"), (1.0, 1e6, "1 m, 1000 km from the origin")];
/// Steps along the edge of an octant of the ball.
const STEPS: u32 = 16;
const RAYS: u32 = 20_000;

pub(super) fn cases() -> Vec<HardCase> {
    let group = |pipeline: &str, unit| Group::new(Family::Scene, pipeline, unit);
    let mut cases = Vec::new();
    let center = group("camera at the centre of a ball", "of the radius");
    let wall = group("camera in a wall", "of the distance");
    let leaks = group("rays at edges and corners of a closed mesh", "leaks");
    let sight = group("sight of points on a closed mesh", "wrong answers");
    for (size, away, name) in SIZES {
        // A square and its root: half a rounding and one rounding.
        cases.push(center.case(name, Bound::AtMost(1.5 * ROUNDING), move || Ok(from_the_center(size, away))));
        // An inverse and a product in the code, a quotient in the reference; the differences in both numerators are the
        // same.
        cases.push(wall.case(name, Bound::AtMost(3.0 * ROUNDING), move || Ok(from_a_wall(size, away))));
        // Adjacent triangles transform shared corners into the ray's frame with the same roundings.
        cases.push(leaks.none(name, move || Ok(at_edges(size, away))));
        // Points deviate from their triangles by the rounding of their coordinates, far less than visibility rays skip
        // at their ends.
        cases.push(sight.none(name, move || Ok(sight_of_surfaces(size, away))));
    }
    let scale = group("distances in a scene of another size", "of the radius, times the cosine");
    // Scaling rounds corners, eye and direction, together by 4 roundings of a radius. In the ray's frame a coordinate
    // of up to 4 radii has 4 roundings. Weights of nearly equilateral triangles have 5 of these relative to their side,
    // for three weights, and so does the distance, since it changes by at most one side: 15 · 16, plus 40 for all other
    // operations.
    let most = (2.0 * 280.0 + 4.0) * ROUNDING;
    for (size, _, name) in SIZES.into_iter().skip(1).take(2) {
        cases.push(scale.case(name, Bound::AtMost(most), move || Ok(against_one_metre(size))));
    }
    let broken = group("nearest triangle among broken ones", "other answers");
    cases.push(broken.none("no area, NaN, infinite and huge corners", || Ok(among_broken())));
    let doubled = group("nearest of coplanar triangles", "answers that are not the first");
    cases.push(doubled.none("each triangle three times", || Ok(among_doubled())));
    let far = group("rays from far away at the middle of a mesh", "missed");
    // The tree is traversed up to a distance of 1e9 half sizes; beyond, all triangles are tested.
    for reach in [1e3, 0.99e9, 1.01e9, 1e12] {
        cases.push(far.none(format!("{reach:e} half sizes"), move || Ok(from_afar(reach))));
    }
    let places = group("light seen from bad places", "not finite, or below 0");
    cases.push(places.none("on triangles, edges, corners, in a plane, in glass, at a lamp", || Ok(bad_places())));
    cases
}

/// Returns triangles on a ball of radius 1.
fn ball() -> Vec<[DVec3; 3]> {
    let mut triangles = Vec::new();
    for octant in 0..8 {
        let at = |a: u32, b: u32, c: u32| {
            let side = |bit: u32, steps: u32| if octant >> bit & 1 == 0 { f64::from(steps) } else { -f64::from(steps) };
            // Adding 0 turns −0 into the 0 of the adjacent octant.
            DVec3::new(side(0, a), side(1, b), side(2, c)).normalize() + 0.0
        };
        for a in 0..STEPS {
            for b in 0..STEPS - a {
                let c = STEPS - a - b;
                triangles.push([at(a, b, c), at(a + 1, b, c - 1), at(a, b + 1, c - 1)]);
                if c > 1 {
                    triangles.push([at(a + 1, b, c - 1), at(a + 1, b + 1, c - 2), at(a, b + 1, c - 1)]);
                }
            }
        }
    }
    triangles
}

fn mesh(triangles: &[[DVec3; 3]]) -> SceneMesh {
    let mesh = Mesh {
        positions: triangles.as_flattened().to_vec(),
        triangles: (0..triangles.len() as u32).map(|number| [3 * number, 3 * number + 1, 3 * number + 2]).collect(),
        material_of: vec![0; triangles.len()],
        ..Mesh::default()
    };
    SceneMesh::new(mesh, [MeshMaterial::default()].into())
}

/// Returns the ball scaled to `size`, offset by `away` sizes along each axis.
fn placed(size: f64, away: f64) -> Vec<[DVec3; 3]> {
    ball().into_iter().map(|corners| corners.map(|corner| size * (corner + away))).collect()
}

fn share(random: &mut Random) -> f64 {
    f64::from(random.word()) / 2_147_483_648.0 - 1.0
}

fn inside(random: &mut Random) -> DVec3 {
    DVec3::new(share(random), share(random), share(random))
}

/// Returns rays with generated origins and directions. Directions of zero length are skipped.
fn rays(seed: u64, mut make: impl FnMut(&mut Random, u32) -> (DVec3, DVec3)) -> Vec<Ray> {
    let mut random = Random::new(seed);
    (0..RAYS).map(|turn| make(&mut random, turn)).filter_map(|(from, along)| Ray::new(from, along)).collect()
}

fn from_the_center(size: f64, away: f64) -> Measured {
    let sphere = Sphere { center: DVec3::splat(size * away), radius: 0.3 * size };
    let mut worst = Measured::nothing();
    for ray in rays(1, |random, _| (sphere.center, inside(random))) {
        let met = sphere.intersect(&ray, 0.0).map_or(f64::NAN, |hit| hit.distance);
        worst.greatest((met - sphere.radius).abs() / sphere.radius, || format!("{:?}", ray.direction()));
    }
    worst
}

fn from_a_wall(size: f64, away: f64) -> Measured {
    let min = DVec3::splat(size * away);
    // Thin, so that most rays leave through the two large faces.
    let wall = AxisBox { min, max: min + size * DVec3::new(1.0, 0.7, 1e-3) };
    let mut worst = Measured::nothing();
    let middle = 0.5 * (wall.min + wall.max);
    for ray in rays(2, |random, _| (middle + 0.49 * (wall.max - wall.min) * inside(random), inside(random))) {
        let (from, along) = (ray.origin(), ray.direction());
        let leaves = |axis: usize| {
            let face = if along[axis] < 0.0 { wall.min[axis] } else { wall.max[axis] };
            if along[axis] == 0.0 { f64::INFINITY } else { (face - from[axis]) / along[axis] }
        };
        let expected = leaves(0).min(leaves(1)).min(leaves(2));
        let met = wall.intersect(&ray, 0.0).map_or(f64::NAN, |hit| hit.distance);
        worst.greatest((met - expected).abs() / expected, || format!("{from:?} along {along:?}"));
    }
    worst
}

fn at_edges(size: f64, away: f64) -> Measured {
    let triangles = placed(size, away);
    let bvh = mesh(&triangles);
    let middle = DVec3::splat(size * away);
    let mut wrong = Measured::count(0);
    for ray in rays(3, |random, turn| {
        let [a, b, _] = triangles[turn as usize % triangles.len()];
        let along = [0.0, 0.5, 0.5 + 0.5 * share(random)][turn as usize % 3];
        let target = a + along * (b - a);
        // From inside, and from outside through the ball.
        let near = if turn % 2 == 0 { middle } else { target + 2.0 * (target - middle) };
        let origin = near + 0.3 * size * inside(random);
        (origin, target - origin)
    }) {
        let leaks = bvh.nearest(&ray, 0.0..f64::INFINITY).is_none() || !bvh.occluded(&ray, 0.0..f64::INFINITY);
        wrong.count_if(leaks, || format!("{:?} along {:?}", ray.origin(), ray.direction()));
    }
    wrong
}

fn sight_of_surfaces(size: f64, away: f64) -> Measured {
    let triangles = placed(size, away);
    let scene = SceneAtTime::with_meshes(Vec::new(), vec![Arc::new(mesh(&triangles))], Light::default());
    let mut wrong = Measured::count(0);
    let mut random = Random::new(4);
    for corners in &triangles {
        let [a, b, c] = *corners;
        let (s, t) = (0.25 + 0.2 * share(&mut random), 0.25 + 0.2 * share(&mut random));
        let point = a + s * (b - a) + t * (c - a);
        let across = ((b - a) / size).cross((c - a) / size).normalize();
        let out = if across.dot(point - size * away) < 0.0 { -across } else { across };
        // A ball is convex: every point straight above is visible, and the far side hides every point below.
        let ways = [(0.01, true), (3.0, true), (-3.0, false), (-1e3, false)];
        for (reach, in_sight) in ways {
            let eye = point + reach * size * out;
            let answers = [scene.sees(eye, point), scene.sees(point, eye)];
            wrong.count_if(answers != [in_sight; 2], || format!("{point:?} from {eye:?}"));
        }
    }
    wrong
}

fn against_one_metre(size: f64) -> Measured {
    let plain = mesh(&ball());
    let other = mesh(&placed(size, 0.0));
    let mut worst = Measured::nothing();
    for ray in rays(5, |random, _| {
        let origin = 1.7 * inside(random);
        (origin, 0.9 * inside(random) - origin)
    }) {
        // Both rays have the same direction; normalising a scaled one could round differently.
        let scaled = Ray::new(size * ray.origin(), ray.direction());
        let nearest = |mesh: &SceneMesh, ray: &Ray| mesh.nearest(ray, 0.0..f64::INFINITY);
        let (a, b) = (nearest(&plain, &ray), scaled.and_then(|ray| nearest(&other, &ray)));
        let (Some(a), Some(b)) = (a, b) else { continue };
        let [p, q, r] = plain.mesh.corners(a.triangle);
        let cosine = (q - p).cross(r - p).normalize().dot(ray.direction()).abs();
        // Skips grazing hits: rounding may select another triangle.
        if cosine > 0.1 {
            worst.greatest((b.distance / size - a.distance).abs() * cosine, || format!("{:?}", ray.origin()));
        }
    }
    worst
}

fn among_broken() -> Measured {
    let sound = ball();
    let mut random = Random::new(6);
    let mut triangles = sound.clone();
    for turn in 0..200 {
        let [a, b, c] = sound[random.below(sound.len() as u32) as usize].map(|corner| 0.5 * corner);
        triangles.push(match turn % 5 {
            0 => [a, a, a],
            1 => [a, b, 2.0 * b - a],
            2 => [a, b, DVec3::new(c.x, f64::NAN, c.z)],
            3 => [a, DVec3::X * f64::INFINITY, c],
            _ => [a, b, 1e200 * c],
        });
    }
    // Nearly collinear corners may form a sliver after rounding, which a ray can hit; these are removed.
    triangles.retain(|[a, b, c]| {
        let across = (*b - *a).cross(*c - *a);
        !(across.is_finite() && across != DVec3::ZERO) || across.length() > 1e-9
    });
    let (plain, other) = (mesh(&sound), mesh(&triangles));
    let mut wrong = Measured::count(0);
    wrong.count_if(plain.bvh.bounds != other.bvh.bounds, || "the box around them".into());
    count_other_answers(wrong, 7, &plain, &other)
}

fn count_other_answers(mut wrong: Measured, seed: u64, plain: &SceneMesh, other: &SceneMesh) -> Measured {
    for ray in rays(seed, |random, _| {
        let origin = 2.0 * inside(random);
        (origin, 0.5 * inside(random) - origin)
    }) {
        let [a, b] = [plain, other].map(|mesh| mesh.nearest(&ray, 0.0..f64::INFINITY));
        wrong.count_if(a != b, || format!("{ray:?}"));
    }
    wrong
}

fn among_doubled() -> Measured {
    let sound = ball();
    let (plain, other) = (mesh(&sound), mesh(&[sound.clone(), sound.clone(), sound].concat()));
    count_other_answers(Measured::count(0), 8, &plain, &other)
}

fn from_afar(reach: f64) -> Measured {
    let bvh = mesh(&ball());
    let mut wrong = Measured::count(0);
    for ray in rays(9, |random, _| {
        let origin = reach * inside(random).normalize_or(DVec3::X);
        (origin, -origin)
    }) {
        // At 1e12 the direction misses the centre by at most a thousandth of the radius.
        let nearest = bvh.nearest(&ray, 0.0..f64::INFINITY);
        let close = nearest.is_some_and(|hit| (hit.distance / reach - 1.0).abs() < 1.1 / reach + 1e-15);
        wrong.count_if(!close || !bvh.occluded(&ray, 0.0..2.0 * reach), || format!("{:?}", ray.origin()));
    }
    wrong
}

fn bad_places() -> Measured {
    let triangles = ball();
    let white = Material::diffuse(Texture::Solid(DVec3::ONE));
    let mut glass = Object::new(Shape::Sphere(Sphere { center: DVec3::ZERO, radius: 0.5 }), white);
    glass.material.optics = Optics::Glass { ior: 1.5, tint: DVec3::ONE };
    let position = DVec3::new(0.0, 0.7, 0.0);
    let lamp = Lamp { position, radiance: DVec3::ONE, reach: 5.0, window: Window::Punctual, cone: None };
    let light = Light { lamps: vec![lamp], ..Light::default() };
    let scene = SceneAtTime::with_meshes(vec![glass], vec![Arc::new(mesh(&triangles))], light);
    let mut wrong = Measured::count(0);
    let mut random = Random::new(10);
    for [a, b, c] in triangles {
        let places = [a, 0.5 * (a + b), (a + b + c) / 3.0, a + 3.0 * (b - a), DVec3::ZERO, 0.5 * a, position];
        for place in places {
            for direction in [inside(&mut random), b - a, c - place, DVec3::X, DVec3::NEG_Y] {
                let hit = trace(&scene, place, direction);
                let is_light = hit.color.is_finite() && hit.color.min_element() >= 0.0;
                let is_sound = is_light && hit.distance > 0.0 && hit.normal.is_finite();
                wrong.count_if(!is_sound, || format!("{place:?} along {direction:?}"));
            }
        }
    }
    wrong
}
