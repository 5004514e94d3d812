//! Units that culling reports as visible, compared with points and rays: no visible unit is missing, and few are reported
//! although they are not visible (CALF 6.2).

use std::sync::atomic::{AtomicU64, Ordering};

use codec::container::ProbeEntry;
use codec::image::cube::{FacePoint, direction_to_face};
use codec::image::{DepthKind, Face};
use codec::math::camera::rotation;
use codec::math::{Camera, Lens, Sight, Viewer};
use glam::{DQuat, DVec3};
use rayon::prelude::*;
use render::views::face_frustum::{DepthSpan, FaceImage};
use render::views::visibility::{Culled, UnitGrid, cull, cull_all};

use crate::footage::Random;

fn visible_units(culled: &Culled) -> u64 {
    culled.seen_by.iter().flatten().count() as u64
}

/// Number of cameras.
const CAMERAS: u64 = 24_000;
/// Number of points per camera.
const POINTS: usize = 160;
/// Number of cameras for which false positives are counted.
const ALARM_CAMERAS: u64 = 800;

impl Random {
    /// Returns a number in 0..1.
    fn share(&mut self) -> f64 {
        f64::from(self.next()) / f64::from(1u32 << 31)
    }

    fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.share()
    }

    /// Returns a number with a uniformly distributed logarithm.
    fn scale(&mut self, low: f64, high: f64) -> f64 {
        self.within(low.ln(), high.ln()).exp()
    }

    fn direction(&mut self) -> DVec3 {
        loop {
            let point = DVec3::new(self.within(-1.0, 1.0), self.within(-1.0, 1.0), self.within(-1.0, 1.0));
            if (0.1..1.0).contains(&point.length()) {
                return point.normalize();
            }
        }
    }
}

/// A probe's images and the range of their depths.
struct Setup {
    probe: ProbeEntry,
    faces: Vec<Face>,
    grid: UnitGrid,
    span: DepthSpan,
}

impl Setup {
    fn random(random: &mut Random) -> Setup {
        let view = random.below(8) == 0;
        let orientation = match random.below(3) {
            0 => DQuat::from_axis_angle(random.direction(), random.within(-3.0, 3.0)),
            _ => DQuat::IDENTITY,
        };
        let position = match random.below(3) {
            0 => DVec3::ZERO,
            1 => DVec3::new(-0.6, 1.7, -0.4),
            _ => random.direction() * random.scale(0.1, 1000.0),
        };
        let near_m = random.scale(1e-3, 10.0);
        let kind = if random.below(2) == 0 { DepthKind::Distance } else { DepthKind::Planar };
        let span = match random.below(6) {
            0 => DepthSpan::unknown(),
            1 => DepthSpan { near_m, far_m: near_m, kind },
            _ => DepthSpan { near_m, far_m: near_m * random.scale(1.0, 300.0), kind },
        };
        let size = if view { [80, 60] } else { [64, 64] };
        let side = [8, 9, 16, 64][random.below(4) as usize];
        let intrinsics = if view { [random.within(20.0, 200.0), 50.0, 41.0, 25.0] } else { [0.0; 4] };
        Setup {
            probe: ProbeEntry {
                name: "p".into(),
                position: position.to_array(),
                orientation: orientation.to_array(),
                frames: [0, 0],
                intrinsics,
            },
            faces: if view { vec![Face::View] } else { Face::CUBE.to_vec() },
            grid: UnitGrid { size, unit: [side, side] },
            span,
        }
    }

    fn centre(&self) -> DVec3 {
        DVec3::from_array(self.probe.position)
    }

    /// Returns the direction of a point of a face's image, given in pixels; its component along the face's axis is 1.
    fn direction(&self, face: Face, [x, y]: [f64; 2]) -> DVec3 {
        let [forward, right, down] = face.axes();
        let [u, v] = if face == Face::View {
            let [fx, fy, cx, cy] = self.probe.intrinsics;
            [(x - cx) / fx, (y - cy) / fy]
        } else {
            [2.0 * x / f64::from(self.grid.size[0]) - 1.0, 2.0 * y / f64::from(self.grid.size[1]) - 1.0]
        };
        rotation(self.probe.orientation).unwrap() * (forward + u * right + v * down)
    }

    /// Returns the minimum and maximum multiple of a [`Setup::direction`] at which a surface may be.
    fn reach(&self, direction: DVec3) -> [f64; 2] {
        let length = if self.span.kind == DepthKind::Distance { direction.length() } else { 1.0 };
        [self.span.near_m / length, self.span.far_m / length]
    }

    /// Returns the face and unit that show a point relative to the centre, and the point's multiple as in [`Setup::reach`].
    fn find(&self, from_centre: DVec3) -> Option<(Face, usize, f64)> {
        let local = rotation(self.probe.orientation).unwrap().inverse() * from_centre;
        let (face, pixel) = if self.faces == [Face::View] {
            let [fx, fy, cx, cy] = self.probe.intrinsics;
            if local.z >= 0.0 {
                return None;
            }
            (Face::View, [fx * local.x / -local.z + cx, fy * -local.y / -local.z + cy])
        } else {
            let FacePoint { face, plane: [u, v] } = direction_to_face(local);
            (face, [u, v].map(|at| (at + 1.0) / 2.0 * f64::from(self.grid.size[0])))
        };
        let [width, height] = self.grid.size.map(f64::from);
        let inside = pixel[0] >= 0.0 && pixel[0] <= width && pixel[1] >= 0.0 && pixel[1] <= height;
        inside.then(|| (face, self.unit_at(pixel), local.dot(face.axes()[0])))
    }

    fn unit_at(&self, pixel: [f64; 2]) -> usize {
        let [columns, rows] = self.grid.shape();
        let at = |axis: usize, count: u32| {
            ((pixel[axis] / f64::from(self.grid.unit[axis])).floor() as u32).min(count - 1) as usize
        };
        at(1, rows) * columns as usize + at(0, columns)
    }

    fn images(&self) -> Vec<FaceImage> {
        let image = |face: &Face| FaceImage::new(&self.probe, *face, self.grid.size, self.span).unwrap();
        self.faces.iter().map(image).collect()
    }

    /// Returns a point of an image: anywhere, or on the border of a unit.
    fn pixel(&self, random: &mut Random) -> [f64; 2] {
        [0, 1].map(|axis| {
            let size = f64::from(self.grid.size[axis]);
            let at = random.within(0.0, size);
            match random.below(4) {
                0 => (at / f64::from(self.grid.unit[axis])).round() * f64::from(self.grid.unit[axis]),
                1 => at.round(),
                _ => at,
            }
            .min(size)
        })
    }

    /// Returns a multiple within [`Setup::reach`]: anywhere, or at an end.
    fn multiple(&self, random: &mut Random, direction: DVec3) -> f64 {
        let [near, far] = self.reach(direction);
        match random.below(4) {
            0 => near,
            1 if far.is_finite() => far,
            _ => random.scale(near.max(1e-4), far.clamp(1e-4, 1e3)).clamp(near, far),
        }
    }
}

/// A camera and the half size of its image at distance 1, from which visibility is computed without culling code.
struct Eye {
    camera: Camera,
    half: [f64; 2],
}

impl Eye {
    fn new(eye: DVec3, turn: DQuat, fov_y_deg: f64, aspect: f64) -> Eye {
        let lens = Lens { aspect, ..Lens::new(fov_y_deg) };
        let camera = Camera::oriented(eye, turn.normalize().to_array(), lens).unwrap();
        let tangent = (fov_y_deg.to_radians() / 2.0).tan();
        Eye { camera, half: [tangent * aspect, tangent] }
    }

    /// True if a direction is in the image.
    fn sees(&self, direction: DVec3) -> bool {
        let [forward, right, down] = self.camera.axes().map(|axis| axis.dot(direction));
        forward > 0.0 && right.abs() <= self.half[0] * forward && down.abs() <= self.half[1] * forward
    }

    /// True if a point `from + t · along`, with t between two bounds, is in the image.
    fn sees_some(&self, from: DVec3, along: DVec3, [mut low, mut high]: [f64; 2]) -> bool {
        let [forward, right, down] = self.camera.axes();
        let [x, y] = self.half;
        for normal in [forward, x * forward + right, x * forward - right, y * forward + down, y * forward - down] {
            let (start, slope) = (normal.dot(from - self.camera.eye()), normal.dot(along));
            if slope > 0.0 {
                low = low.max(-start / slope);
            } else if slope < 0.0 {
                high = high.min(-start / slope);
            } else if start < 0.0 {
                return false;
            }
        }
        low <= high
    }

    fn random(random: &mut Random, setup: &Setup, kind: u64) -> Eye {
        let near_m = setup.span.near_m.max(1e-3);
        let far_m = if setup.span.far_m.is_finite() { setup.span.far_m } else { 50.0 };
        let turn = DQuat::from_axis_angle(random.direction(), random.within(-3.2, 3.2));
        let around = random.direction();
        let (eye, fov) = match kind {
            0 => (around * random.scale(0.01, 3.0 * far_m), random.within(1.0, 170.0)),
            // At the centre, inside the nearest surface, near the farthest surface, and far beyond it.
            1 => (DVec3::ZERO, random.within(1.0, 170.0)),
            2 => (around * near_m * random.share(), random.within(1.0, 170.0)),
            3 => (around * far_m * random.within(0.9, 1.1), random.within(1.0, 170.0)),
            4 => (around * far_m * random.scale(10.0, 1e4), random.scale(0.01, 60.0)),
            // Narrow and wide.
            5 => (around * random.scale(0.01, 3.0 * far_m), random.scale(1e-4, 1.0)),
            6 => (around * random.scale(0.01, 3.0 * far_m), random.within(170.0, 179.99)),
            // Aligned with the faces.
            7 => (DVec3::new(f64::from(random.below(3)) - 1.0, f64::from(random.below(3)) - 1.0, 0.0), 90.0),
            // Aimed below so that a point is at the border of the image.
            _ => (around * random.scale(1e-6, 3.0 * far_m), random.scale(0.01, 179.0)),
        };
        let aspect = if kind == 7 { 1.0 } else { random.scale(0.3, 3.0) };
        let eye = setup.centre() + eye;
        let turn = match kind {
            7 => {
                rotation(setup.probe.orientation).unwrap()
                    * DQuat::from_rotation_y(std::f64::consts::FRAC_PI_2 * f64::from(random.below(4)))
            }
            0..=2 => turn,
            _ => {
                // A point on the border of a unit is placed at the border of the image or inside it.
                let face = setup.faces[random.below(setup.faces.len() as u32) as usize];
                let direction = setup.direction(face, setup.pixel(random));
                let point = setup.centre() + direction * setup.multiple(random, direction);
                let aim = if random.below(4) == 0 { direction } else { point - eye };
                let tangent = (f64::to_radians(fov) / 2.0).tan();
                let edge = |random: &mut Random| match random.below(4) {
                    0 => random.within(-1.0, 1.0),
                    1 => -(1.0 - 1e-9),
                    _ => 1.0 - 1e-9,
                };
                let local = DVec3::new(edge(random) * tangent * aspect, edge(random) * tangent, -1.0).normalize();
                match aim.try_normalize() {
                    Some(aim) => {
                        let roll = DQuat::from_axis_angle(aim, random.within(-3.2, 3.2));
                        roll * DQuat::from_rotation_arc(local, aim)
                    }
                    None => turn,
                }
            }
        };
        Eye::new(eye, turn, fov, aspect)
    }
}

fn culled(setup: &Setup, eye: &Eye) -> Vec<Culled> {
    let viewers = [Viewer::new(eye.camera.frustum())];
    let one = |image: &FaceImage| {
        let (all, descended) = (cull_all(image, setup.grid, &viewers), cull(image, setup.grid, &viewers));
        assert_eq!(all.seen_by, descended.seen_by, "the descent finds other units");
        descended
    };
    setup.images().iter().map(one).collect()
}

#[test]
fn no_unit_that_a_ray_sees_is_missed() {
    let (hits, grazing) = (AtomicU64::new(0), AtomicU64::new(0));
    (0..CAMERAS).into_par_iter().for_each(|seed| {
        let mut random = Random(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15));
        random.next();
        let setup = Setup::random(&mut random);
        let kind = seed % 12;
        let eye = Eye::random(&mut random, &setup, kind);
        let culled = culled(&setup, &eye);
        let mut seen = 0;
        let mut check = |face: Face, unit: usize, what: &str| {
            let at = setup.faces.iter().position(|other| *other == face).unwrap();
            assert!(culled[at].seen_by[unit].is_some(), "seed {seed}: {face:?}, unit {unit} is seen by {what}");
            seen += 1;
        };
        for _ in 0..POINTS / 2 {
            // Points along directions from the probe: a surface in a unit, and the background behind it.
            let face = setup.faces[random.below(setup.faces.len() as u32) as usize];
            let pixel = setup.pixel(&mut random);
            let direction = setup.direction(face, pixel);
            let from_centre = direction * setup.multiple(&mut random, direction);
            if eye.sees(setup.centre() + from_centre - eye.camera.eye()) {
                check(face, setup.unit_at(pixel), "a surface");
            }
            if eye.sees(direction) {
                check(face, setup.unit_at(pixel), "the background");
            }
            // Points along rays of the camera: a surface on a ray, and the background at its end.
            let [forward, right, down] = eye.camera.axes();
            let [x, y] = eye.half.map(|half| half * random.within(-1.0, 1.0));
            let along = forward + x * right + y * down;
            let point = eye.camera.eye() + along * random.scale(1e-4, 1e3) - setup.centre();
            if let Some((face, unit, multiple)) = setup.find(point) {
                let [near, far] = setup.reach(point / multiple);
                if near <= multiple && multiple <= far {
                    check(face, unit, "a surface along a ray");
                }
            }
            if let Some((face, unit, _)) = setup.find(along) {
                check(face, unit, "the background along a ray");
            }
        }
        hits.fetch_add(seen, Ordering::Relaxed);
        if kind > 7 && seen > 0 {
            grazing.fetch_add(1, Ordering::Relaxed);
        }
    });
    let (hits, grazing) = (hits.into_inner(), grazing.into_inner());
    println!("{CAMERAS} cameras, {hits} points seen; {grazing} grazing cameras saw some");
    assert!(hits > 1_000_000 && grazing > CAMERAS / 5, "{hits} points, {grazing} cameras: too few to mean anything");
}

#[test]
fn few_units_are_seen_in_vain() {
    // Steps of a grid of rays over the unit, including its borders.
    const SIDE: u32 = 24;
    let (seen, vain) = (AtomicU64::new(0), AtomicU64::new(0));
    (0..ALARM_CAMERAS).into_par_iter().for_each(|seed| {
        let mut random = Random(seed.wrapping_mul(0x2545_f491_4f6c_dd1d));
        random.next();
        let setup = Setup::random(&mut random);
        let eye = Eye::random(&mut random, &setup, [0, 0, 0, 1, 2, 3, 6][seed as usize % 7]);
        let columns = setup.grid.shape()[0] as usize;
        for (face, culled) in setup.faces.iter().zip(culled(&setup, &eye)) {
            for (unit, _) in culled.seen_by.iter().enumerate().filter(|(_, seen_by)| seen_by.is_some()) {
                let first = [unit % columns, unit / columns].map(|at| at as u32);
                let edges = [0, 1].map(|axis| {
                    let from = first[axis] * setup.grid.unit[axis];
                    [from, (from + setup.grid.unit[axis]).min(setup.grid.size[axis])].map(f64::from)
                });
                let sees = (0..=SIDE).flat_map(|x| (0..=SIDE).map(move |y| [x, y])).any(|step| {
                    let pixel = [0, 1].map(|axis| {
                        let [from, to] = edges[axis];
                        from + (to - from) * f64::from(step[axis]) / f64::from(SIDE)
                    });
                    let direction = setup.direction(*face, pixel);
                    eye.sees(direction) || eye.sees_some(setup.centre(), direction, setup.reach(direction))
                });
                seen.fetch_add(1, Ordering::Relaxed);
                vain.fetch_add(u64::from(!sees), Ordering::Relaxed);
            }
        }
    });
    let (seen, vain) = (seen.into_inner(), vain.into_inner());
    let share = vain as f64 / seen as f64;
    println!("{ALARM_CAMERAS} cameras, {seen} units seen, {vain} by no ray ({:.3}%)", 100.0 * share);
    assert!(seen > 20_000, "{seen}");
    assert!(share < 0.01, "{vain} of {seen} units are seen by no ray");
}

/// Returns nine probes, at the centre and the corners of a cube of one metre, as in the footage sponza9.
fn nine_probes() -> Vec<ProbeEntry> {
    let centre = DVec3::new(-0.6, 1.7, -0.4);
    let corner = |at: u32| DVec3::from_array([0, 1, 2].map(|axis| f64::from(at >> axis & 1) - 0.5));
    let places = std::iter::once(centre).chain((0..8).map(|at| centre + corner(at)));
    let probe = |(at, place): (usize, DVec3)| ProbeEntry {
        name: at.to_string(),
        position: place.to_array(),
        orientation: [0.0, 0.0, 0.0, 1.0],
        frames: [0, 0],
        intrinsics: [0.0; 4],
    };
    places.enumerate().map(probe).collect()
}

/// Returns the number of tests of the paper's descent, which tests the four children of a node even if the node is entirely
/// visible.
fn descend(image: &FaceImage, leaves: u32, viewers: &[Viewer]) -> u64 {
    let (mut nodes, mut tests) = (vec![[0, 0, 0]], 0);
    for level in 0..=leaves {
        let side = 1024 >> level;
        let mut next = Vec::new();
        for [column, row, first] in nodes {
            let frustum = image.frustum([column * side, row * side], [(column + 1) * side, (row + 1) * side]);
            for (at, viewer) in (first..).zip(&viewers[first as usize..]) {
                tests += 1;
                if viewer.sight(&frustum) != Sight::Missed {
                    next.extend((0..4).map(|child| [2 * column + child % 2, 2 * row + child / 2, at]));
                    break;
                }
            }
        }
        nodes = next;
    }
    tests
}

/// Table 4: a pair of eyes that moves among nine probes and looks around.
#[test]
fn the_descent_takes_a_third_of_the_tests() {
    const STEPS: u32 = 90;
    // Distances of the nearest surface in the footage for each of the nine probes; the farthest surface is 16 m from all of them.
    let near_m = [1.41, 0.81, 1.23, 1.23, 1.23, 0.93, 1.35, 1.43, 0.9];
    let images: Vec<FaceImage> = nine_probes()
        .iter()
        .zip(near_m)
        .flat_map(|(probe, near_m)| {
            let span = DepthSpan { near_m, far_m: 16.0, kind: DepthKind::Distance };
            Face::CUBE.map(|face| FaceImage::new(probe, face, [1024, 1024], span).unwrap())
        })
        .collect();
    println!("level  visible %  regular  hierarchical  without whole nodes");
    for level in 1..=4u32 {
        let grid = |level: u32| UnitGrid { size: [1024; 2], unit: [1024 >> level; 2] };
        let (mut visible, mut regular, mut hierarchical, mut culling_only) = (0, 0, 0, 0);
        for step in 0..STEPS {
            let turn = f64::from(step) / f64::from(STEPS) * std::f64::consts::TAU;
            let middle = DVec3::new(-0.6 + 0.3 * turn.cos(), 1.7 + 0.1 * (3.0 * turn).sin(), -0.4 + 0.3 * turn.sin());
            let target = middle + DVec3::new((2.0 * turn).cos(), 0.4 * turn.sin(), (2.0 * turn).sin());
            let aside = (target - middle).cross(DVec3::Y).normalize() * 0.032;
            let viewers = [-1.0, 1.0].map(|side| {
                let (eye, target) = (middle + side * aside, target + side * aside);
                Viewer::new(Camera::look_at(eye, target, DVec3::Y, Lens::new(90.0)).unwrap().frustum())
            });
            for image in &images {
                let (all, found) = (cull_all(image, grid(level), &viewers), cull(image, grid(level), &viewers));
                assert_eq!(all.seen_by, found.seen_by);
                assert_eq!(all.tests, found.regular_tests(viewers.len()));
                visible += visible_units(&all);
                regular += all.tests;
                hierarchical += found.tests;
                culling_only += descend(image, level, &viewers);
            }
        }
        let units = u64::from(STEPS) * images.len() as u64 * 4u64.pow(level);
        println!(
            "{level:>5}  {:>9.1}  {:>7}  {:>12}  {:>19}",
            100.0 * visible as f64 / units as f64,
            regular / u64::from(STEPS),
            hierarchical / u64::from(STEPS),
            culling_only / u64::from(STEPS),
        );
        assert!(hierarchical <= culling_only && regular <= 2 * units);
        if level == 4 {
            assert!(3 * hierarchical <= regular, "{hierarchical} of {regular}");
            assert!(3 * culling_only <= regular, "{culling_only} of {regular}");
        }
    }
}

#[test]
fn cameras_are_told_apart_and_edges_are_kept() {
    let probe = &nine_probes()[0];
    let span = DepthSpan { near_m: 0.3, far_m: 30.0, kind: DepthKind::Distance };
    let image = FaceImage::new(probe, Face::Px, [100, 50], span).unwrap();
    let centre = DVec3::from_array(probe.position);
    let look = |direction: DVec3, fov| {
        Viewer::new(Camera::look_at(centre, centre + direction, DVec3::Y, Lens::new(fov)).unwrap().frustum())
    };
    // Viewers that look away from the face, at one corner of it, and at all of it.
    let viewers = [look(DVec3::NEG_X, 90.0), look(DVec3::new(1.0, 0.99, 0.99), 0.3), look(DVec3::X, 120.0)];
    for unit in [[16, 16], [7, 50], [100, 50], [1000, 1000], [1, 1], [33, 3]] {
        let grid = UnitGrid { size: [100, 50], unit };
        let found = cull(&image, grid, &viewers);
        assert_eq!(found.seen_by, cull_all(&image, grid, &viewers).seen_by, "{unit:?}");
        let [columns, rows] = grid.shape();
        assert_eq!(found.seen_by.len() as u32, columns * rows);
        // The right of face +X is −Z and its top +Y, so the corner of +Y and +Z is in the first unit.
        assert_eq!(found.seen_by[0], Some(1), "{unit:?}");
        assert!(found.seen_by[1..].iter().all(|first| *first == Some(2)), "{unit:?}");
        let [none, all] = [&viewers[..1], &viewers[2..]].map(|viewers| cull(&image, grid, viewers));
        assert_eq!((visible_units(&none), none.tests), (0, 1), "one test of the root");
        assert_eq!((visible_units(&all), all.tests), (u64::from(columns * rows), 1), "one test of the root");
    }
    assert_eq!(cull(&image, UnitGrid { size: [100, 50], unit: [10, 10] }, &[]).tests, 0);
    let whole = image.frustum([0, 0], [100, 50]);
    assert_eq!(viewers.map(|viewer| viewer.sight(&whole)), [Sight::Missed, Sight::Partly, Sight::Inside]);
}
