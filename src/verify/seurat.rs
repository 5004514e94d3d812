//! Hard cases of cameras and depths in Seurat manifests.

use std::array::from_fn;

use glam::DVec3;

use crate::case::{Bound, Family, Group, HardCase, Measured, ROUNDING};
use codec::error::Result;
use footage::dataset::seurat::{CameraMatrices, DepthType, SeuratCamera};

const SIDE: u32 = 8;
const IDENTITY: [f64; 16] = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0];
/// The smallest positive float.
const DENORMAL: f32 = 1e-45;

#[derive(Debug, Clone, Copy, PartialEq)]
enum Kind {
    Perspective,
    Orthographic,
}

/// Projection with a field of view of 90 degrees, or with an orthographic window of 2 m.
#[derive(Debug, Clone, Copy)]
struct Projection {
    kind: Kind,
    near: f64,
    far: f64,
    /// −1 if the image is mirrored, else 1.
    across: f64,
}

impl Projection {
    fn new(kind: Kind, near: f64, far: f64) -> Projection {
        Projection { kind, near, far, across: 1.0 }
    }

    fn clip_from_eye(self) -> [f64; 16] {
        let Projection { kind, near, far, across } = self;
        let (z, offset, w) = match kind {
            Kind::Perspective if far.is_infinite() => (-1.0, -2.0 * near, [-1.0, 0.0]),
            Kind::Perspective => ((far + near) / (near - far), 2.0 * far * near / (near - far), [-1.0, 0.0]),
            Kind::Orthographic => (-2.0 / (far - near), (far + near) / (near - far), [0.0, 1.0]),
        };
        [across, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, z, offset, 0.0, 0.0, w[0], w[1]]
    }

    fn camera(self, depth_type: DepthType) -> Result<SeuratCamera> {
        let matrices = CameraMatrices { clip_from_eye: self.clip_from_eye(), world_from_eye: IDENTITY };
        SeuratCamera::new([SIDE; 2], depth_type, &matrices)
    }

    /// Returns the distance in metres from the eye's plane at a window depth.
    fn eye_z(self, window: f64) -> f64 {
        let Projection { kind, near, far, .. } = self;
        match kind {
            Kind::Perspective if far.is_infinite() => near / (1.0 - window),
            Kind::Perspective => near * far / (far - window * (far - near)),
            Kind::Orthographic => near + window * (far - near),
        }
    }
}

fn pixels() -> impl Iterator<Item = [u32; 2]> {
    (0..SIDE * SIDE).map(|at| [at % SIDE, at / SIDE])
}

pub(super) fn cases() -> Vec<HardCase> {
    let group = |pipeline: &str, unit| Group::new(Family::Simplification, pipeline, unit);
    let answers = group("Seurat depths that say little", "wrong answers");
    let projections = [
        ("perspective, near 0.1 m, far 1000 m", Projection::new(Kind::Perspective, 0.1, 1e3)),
        ("perspective, infinitely far", Projection::new(Kind::Perspective, 0.1, f64::INFINITY)),
        ("orthographic", Projection::new(Kind::Orthographic, 0.1, 1e3)),
    ];
    let mut cases = Vec::new();
    for depth_type in DepthType::ALL {
        for (name, projection) in projections {
            let name = format!("{}, {name}: 0, infinite, NaN, negative, the least denormal", depth_type.name());
            cases.push(answers.none(name, move || limits(projection, depth_type)));
        }
    }
    let window = group("WINDOW_Z to distance", "of the distance");
    for (near, far) in [(1.0, 2.0), (0.1, 1e3), (1e-3, 1e6), (0.1, f64::INFINITY)] {
        // Entries of the inverse matrix have up to 18 roundings. Their sum, the reciprocal of eye z, can be as small as
        // 1/far while the terms are 1/near. The largest window depth tested is 1 − 2^-12.
        let farthest = Projection::new(Kind::Perspective, near, far).eye_z(1.0 - 1.0 / 4096.0);
        let most = 18.0 * ROUNDING * (1.0 + farthest / near);
        let name = format!("near {near} m, far {far} m");
        cases.push(
            window.case(name, Bound::AtMost(most), move || distances(Projection::new(Kind::Perspective, near, far))),
        );
    }
    // A sum, a product, and a division by the length of a vector.
    let most = 8.0 * ROUNDING;
    let mirror = group("Seurat rays of a mirrored camera", "of the direction");
    cases.push(mirror.case("every pixel", Bound::AtMost(most), mirrored));
    let parallel = group("Seurat rays of an orthographic camera", "of a metre");
    cases.push(parallel.case("every pixel and depth type", Bound::AtMost(most * 1e3), orthographic));
    let refused = group("Seurat cameras that are none", "accepted");
    cases.push(refused.none("near = far, no extent, all zero, not finite", || Ok(singular())));
    cases
}

/// Counts wrong results for extreme depths: 0, infinite, NaN, negative, window depths above 1, and the smallest
/// positive floats.
fn limits(projection: Projection, depth_type: DepthType) -> Result<Measured> {
    let camera = projection.camera(depth_type)?;
    let mut wrong = Measured::count(0);
    for pixel in pixels() {
        let distance_m = |depth: f32| camera.ray(pixel, depth).ok().map(|ray| ray.distance_m);
        for depth in [0.0, -0.0, f32::INFINITY] {
            wrong.count_if(distance_m(depth) != Some(f64::INFINITY), || {
                format!("{pixel:?}: {depth} is not infinitely far")
            });
        }
        for depth in [f32::NAN, -DENORMAL, -1.0, f32::NEG_INFINITY] {
            wrong.count_if(distance_m(depth).is_some(), || format!("{pixel:?}: {depth} was accepted"));
        }
        if depth_type == DepthType::WindowZ {
            wrong.count_if(distance_m(1f32.next_up()).is_some(), || format!("{pixel:?}: beyond 1 was accepted"));
        }
        for depth in [DENORMAL, f32::MIN_POSITIVE] {
            let is_distance = distance_m(depth).is_some_and(|metres| metres > 0.0 && metres.is_finite());
            wrong.count_if(!is_distance, || format!("{pixel:?}: {depth:e} is no distance"));
        }
    }
    Ok(wrong)
}

/// Returns the largest relative error of distances computed from window depths.
fn distances(projection: Projection) -> Result<Measured> {
    let camera = projection.camera(DepthType::WindowZ)?;
    let mut worst = Measured::nothing();
    for pixel in pixels() {
        for step in 1..4096u32 {
            let depth = step as f32 / 4096.0;
            let ray = camera.ray(pixel, depth)?;
            let place: [f64; 2] = from_fn(|axis| (2.0 * f64::from(pixel[axis]) + 1.0) / f64::from(SIDE) - 1.0);
            let expected = projection.eye_z(f64::from(depth)) * DVec3::new(place[0], place[1], 1.0).length();
            worst.greatest((ray.distance_m / expected - 1.0).abs(), || format!("{pixel:?}, depth {depth}"));
        }
    }
    Ok(worst)
}

/// Returns the largest difference between the direction of a pixel and that of the mirrored pixel of the mirrored
/// camera.
fn mirrored() -> Result<Measured> {
    let plain = Projection::new(Kind::Perspective, 0.1, 1e3);
    let cameras = [plain, Projection { across: -1.0, ..plain }].map(|of| of.camera(DepthType::RayDepth));
    let [plain, mirror] = cameras;
    let (plain, mirror) = (plain?, mirror?);
    let mut worst = Measured::nothing();
    for [column, row] in pixels() {
        let [seen, shown] = [plain.ray([column, row], 2.0)?, mirror.ray([SIDE - 1 - column, row], 2.0)?];
        let difference = (seen.direction - shown.direction).abs().max_element();
        let same = seen.origin == shown.origin && seen.distance_m == shown.distance_m;
        worst.greatest(if same { difference } else { f64::INFINITY }, || format!("column {column}, row {row}"));
    }
    Ok(worst)
}

/// Returns the largest error of the end points of orthographic rays.
fn orthographic() -> Result<Measured> {
    let projection = Projection::new(Kind::Orthographic, 0.5, 1e3);
    let mut worst = Measured::nothing();
    for depth_type in DepthType::ALL {
        let camera = projection.camera(depth_type)?;
        for pixel in pixels() {
            for depth in [0.25, 0.5, 1.0f32] {
                let ray = camera.ray(pixel, depth)?;
                let end = ray.origin + ray.distance_m * ray.direction;
                let eye_z = match depth_type {
                    DepthType::WindowZ => projection.eye_z(f64::from(depth)),
                    DepthType::EyeZ | DepthType::RayDepth => f64::from(depth),
                };
                let place: [f64; 2] = from_fn(|axis| (2.0 * f64::from(pixel[axis]) + 1.0) / f64::from(SIDE) - 1.0);
                let expected = DVec3::new(place[0], -place[1], -eye_z);
                worst.greatest((end - expected).length(), || format!("{}, {pixel:?}", depth_type.name()));
            }
        }
    }
    Ok(worst)
}

/// Counts accepted cameras that have no inverse.
fn singular() -> Measured {
    let mut accepted = Measured::count(0);
    let flat = Projection::new(Kind::Perspective, 1.0, 2.0).clip_from_eye();
    let with = |at: usize, value: f64| {
        let mut matrix = flat;
        matrix[at] = value;
        matrix
    };
    let matrices = [
        ("near = far", Projection::new(Kind::Perspective, 1.0, 1.0).clip_from_eye()),
        ("near = far, orthographic", Projection::new(Kind::Orthographic, 1.0, 1.0).clip_from_eye()),
        ("no width", with(0, 0.0)),
        ("no depth", with(11, 0.0)),
        ("all zero", [0.0; 16]),
        ("an infinite entry", with(5, f64::INFINITY)),
        ("an entry that is no number", with(5, f64::NAN)),
    ];
    for (name, clip_from_eye) in matrices {
        for depth_type in DepthType::ALL {
            let matrices = CameraMatrices { clip_from_eye, world_from_eye: IDENTITY };
            let camera = SeuratCamera::new([SIDE; 2], depth_type, &matrices);
            // A matrix whose inverse is not finite is rejected at its first pixel.
            let is_ray = camera.is_ok_and(|camera| camera.ray([0, 0], 0.5).is_ok());
            accepted.count_if(is_ray, || format!("{name}, {}", depth_type.name()));
        }
    }
    accepted
}
