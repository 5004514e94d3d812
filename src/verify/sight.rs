//! Visibility of a probe's units from cameras (CALF 6.2), tested with points that are certainly visible: a visible unit
//! must never be missed.

use glam::{DQuat, DVec3};

use crate::case::{Family, Group, HardCase, Measured};
use codec::container::ProbeEntry;
use codec::error::{Error, Result};
use codec::image::{DepthKind, Face};
use codec::math::random::Random;
use codec::math::{Camera, Lens, Viewer};
use render::views::face_frustum::{DepthSpan, FaceImage};
use render::views::visibility::{UnitGrid, cull, cull_all};

/// Number of cameras of a case, and of points tested with each.
const CAMERAS: u64 = 300;
const POINTS: usize = 60;
/// Units along each side of a face, and pixels of the side.
const UNITS: u32 = 8;
const SIDE: u32 = 64;
/// Margin, relative to distance, by which a point must be inside all planes of a camera to count as visible. Far above
/// the rounding errors of the reference.
const INSIDE: f64 = 1e-12;

struct Setup {
    centre: DVec3,
    span: DepthSpan,
}

/// Places a camera for a target point of the probe.
type Place = fn(&mut Random, &Setup, Target) -> Pose;

/// Point on the border of a unit: its direction from the probe, and its position.
#[derive(Clone, Copy)]
struct Target {
    direction: DVec3,
    point: DVec3,
}

/// Camera: eye, the direction `aim` that appears at `border` of the picture, and field of view.
struct Pose {
    eye: DVec3,
    aim: DVec3,
    fov_deg: f64,
    /// Position in the picture at which `aim` appears, −1 to 1 per axis.
    border: [f64; 2],
}

const PLACES: [(&str, Place); 8] = [
    ("cameras at the probe's centre", |random, setup, target| {
        pose(random, (setup.centre, target.direction), [1.0, 120.0])
    }),
    ("cameras nearer than the nearest surface", |random, setup, target| {
        let eye = setup.centre + unit_vector(random) * setup.span.near_m * share(random);
        pose(random, (eye, target.point - eye), [1.0, 170.0])
    }),
    ("cameras among the surfaces", |random, setup, target| {
        let eye = setup.centre + unit_vector(random) * between(random, setup.span.near_m, setup.span.far_m.min(60.0));
        pose(random, (eye, target.point - eye), [1.0, 170.0])
    }),
    ("cameras a thousand times as far away", |random, setup, target| {
        let eye = setup.centre + unit_vector(random) * 1000.0 * setup.span.far_m.min(60.0);
        pose(random, (eye, target.point - eye), [0.01, 2.0])
    }),
    ("borders of a frustum that graze a cell's corner", |random, setup, target| {
        let eye = setup.centre + unit_vector(random) * 7.0;
        let grazing = 1.0 - 1e-11;
        Pose {
            border: [grazing, if random.one_in(2) { grazing } else { 0.3 }],
            ..pose(random, (eye, target.point - eye), [1.0, 120.0])
        }
    }),
    ("cameras that look along an edge of a cell", |random, setup, target| {
        // On the ray itself, before or behind the point, looking along it.
        let eye = setup.centre + target.direction * between(random, -3.0, 3.0);
        let aim = if random.one_in(2) { target.direction } else { target.point - eye };
        Pose { border: [0.0, 0.0], ..pose(random, (eye, aim), [0.001, 90.0]) }
    }),
    ("cameras in the plane of a face's edge", |random, setup, target| {
        let eye = setup.centre + DVec3::new(5.0, 5.0, between(random, -5.0, 5.0));
        pose(random, (eye, target.point - eye), [0.1, 90.0])
    }),
    ("slits of a thousandth of a degree", |random, setup, target| {
        let eye = setup.centre + unit_vector(random) * 4.0;
        pose(random, (eye, target.point - eye), [1e-4, 1e-3])
    }),
];

pub(super) fn cases() -> Vec<HardCase> {
    let group = Group::new(Family::Geometry, "units that cameras see, against points", "units missed");
    let case = |(name, place): (&'static str, Place)| group.none(name, move || missed(place));
    PLACES.into_iter().map(case).collect()
}

fn share(random: &mut Random) -> f64 {
    f64::from(random.word()) / 4_294_967_296.0
}

fn between(random: &mut Random, low: f64, high: f64) -> f64 {
    low + (high - low) * share(random)
}

fn unit_vector(random: &mut Random) -> DVec3 {
    let [x, y, z] = [(); 3].map(|()| between(random, -1.0, 1.0));
    DVec3::new(x, y, z).try_normalize().unwrap_or(DVec3::X)
}

/// Returns a camera whose picture shows `aim` at a random position, with a random field of view between `least` and
/// `most` degrees.
fn pose(random: &mut Random, (eye, aim): (DVec3, DVec3), [least, most]: [f64; 2]) -> Pose {
    let fov_deg = (between(random, least.ln(), most.ln())).exp();
    let border = [(); 2].map(|()| [0.0, 0.5, 1.0 - 1e-9, -1.0 + 1e-9][random.below(4) as usize]);
    Pose { eye, aim, fov_deg, border }
}

impl Setup {
    fn random(random: &mut Random) -> Setup {
        let near_m = between(random, -2.0, 1.0).exp();
        let kind = if random.one_in(2) { DepthKind::Distance } else { DepthKind::Planar };
        let far_m = match random.below(4) {
            0 => f64::INFINITY,
            1 => near_m,
            _ => near_m * between(random, 1.0, 50.0),
        };
        let centre = if random.one_in(3) { DVec3::ZERO } else { unit_vector(random) * between(random, 0.1, 30.0) };
        Setup { centre, span: DepthSpan { near_m, far_m, kind } }
    }

    /// Returns a point of a unit, more often than not on its border and at an end of its depth span.
    fn target(&self, random: &mut Random, face: Face, unit: [u32; 2]) -> Target {
        let [forward, right, down] = face.axes();
        let at = |random: &mut Random, unit: u32| {
            let inside = [0.0, 1.0, share(random)][random.below(3) as usize];
            2.0 * (f64::from(unit) + inside) / f64::from(UNITS) - 1.0
        };
        let direction = forward + at(random, unit[0]) * right + at(random, unit[1]) * down;
        let length = if self.span.kind == DepthKind::Distance { direction.length() } else { 1.0 };
        let far_m = self.span.far_m.min(100.0);
        let depth_m = [self.span.near_m, far_m, between(random, self.span.near_m, far_m)][random.below(3) as usize];
        Target { direction, point: self.centre + direction * (depth_m / length) }
    }
}

fn missed(place: Place) -> Result<Measured> {
    let (mut wrong, mut seen) = (Measured::count(0), 0u64);
    for seed in 0..CAMERAS {
        let mut random = Random::new(seed);
        let setup = Setup::random(&mut random);
        let probe = ProbeEntry {
            name: "p".into(),
            position: setup.centre.to_array(),
            orientation: [0.0, 0.0, 0.0, 1.0],
            frames: [0, 0],
            intrinsics: [0.0; 4],
        };
        let aimed = Face::CUBE[random.below(6) as usize];
        let unit = [(); 2].map(|()| random.below(UNITS));
        let target = setup.target(&mut random, aimed, unit);
        let pose = place(&mut random, &setup, target);
        let Some(camera) = camera_of(&pose)? else { continue };
        let grid = UnitGrid { size: [SIDE; 2], unit: [SIDE / UNITS; 2] };
        let viewers = [Viewer::new(camera.frustum())];
        for face in Face::CUBE {
            let image = FaceImage::new(&probe, face, [SIDE; 2], setup.span)
                .ok_or_else(|| Error::invalid("a cube face without directions"))?;
            let (found, all) = (cull(&image, grid, &viewers), cull_all(&image, grid, &viewers));
            wrong.count_if(found.seen_by != all.seen_by, || {
                format!("camera {seed}: the descent finds other units on {}", face.name())
            });
            for at in 0..POINTS {
                let unit = match at % 3 {
                    0 => unit,
                    _ => [(); 2].map(|()| random.below(UNITS)),
                };
                // The first point is the one that the camera was aimed at.
                let target = if (face, at) == (aimed, 0) { target } else { setup.target(&mut random, face, unit) };
                let surface = sees(&camera, &pose, target.point - pose.eye);
                if surface || sees(&camera, &pose, target.direction) {
                    seen += 1;
                    wrong.count_if(found.seen_by[(unit[1] * UNITS + unit[0]) as usize].is_none(), || {
                        format!("camera {seed}: unit {unit:?} of {}", face.name())
                    });
                }
            }
        }
    }
    // Fails if too few points are visible: the case would test nothing.
    if seen <= CAMERAS / 8 {
        wrong.figure = f64::NAN;
    }
    Ok(wrong.with_note(format!("{seen} points seen")))
}

/// Returns the camera whose picture shows `aim` at `border`. `None` if the eye coincides with the point.
fn camera_of(pose: &Pose) -> Result<Option<Camera>> {
    let Some(aim) = pose.aim.try_normalize() else { return Ok(None) };
    let tangent = (pose.fov_deg.to_radians() / 2.0).tan();
    let [x, y] = pose.border;
    let local = DVec3::new(x * tangent, y * tangent, -1.0).normalize();
    let turn = DQuat::from_rotation_arc(local, aim).normalize();
    Camera::oriented(pose.eye, turn.to_array(), Lens::new(pose.fov_deg)).map(Some)
}

/// True if a vector from the eye is inside the picture by a safe margin.
fn sees(camera: &Camera, pose: &Pose, vector: DVec3) -> bool {
    let [forward, right, down] = camera.axes().map(|axis| axis.dot(vector));
    let tangent = (pose.fov_deg.to_radians() / 2.0).tan();
    let slack = INSIDE * (vector.length() + pose.eye.length());
    let half = tangent * forward - slack;
    forward > slack && right.abs() <= half && down.abs() <= half
}
