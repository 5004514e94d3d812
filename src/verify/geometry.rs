//! Hard cases of directions, cube faces and projections: edges, corners, poles, the date line, wide angles.
//!
//! Visibility from cameras is tested in [`sight`](super::sight).

use std::f64::consts::PI;

use glam::DVec3;
use half::f16;

use crate::case::{Bound, Family, Group, HardCase, Measured, ROUNDING};
use crate::sight;
use codec::error::Result;
use codec::image::Plane;
use codec::image::cube::{Face, FacePoint, direction_to_face};
use codec::image::equirect::{FaceMap, resample_color, resample_nearest};
use codec::image::projection::{ImageProjection, centre_of};
use footage::dataset::planar_to_distance;

const SIDES: [u32; 5] = [1, 2, 3, 1024, 65_535];
const PANORAMAS: [[u32; 2]; 5] = [[1, 1], [2, 1], [7, 3], [512, 256], [16_384, 8192]];
const RESAMPLED: [[u32; 2]; 4] = [[2, 1], [7, 3], [64, 32], [257, 129]];
const LENGTHS: [f64; 5] = [1.0, 1e-300, 1e-150, 1e150, 1e300];

type Directions = fn() -> Vec<DVec3>;

pub(super) fn cases() -> Vec<HardCase> {
    let group = |pipeline: &str, unit| Group::new(Family::Geometry, pipeline, unit);
    let mut cases = Vec::new();
    let pixels = group("pixel of a cube face to direction and back", "of a pixel");
    for side in SIDES {
        // For numbers up to 1: two products in numerator and denominator, and a quotient. A pixel is 2 / N wide.
        let most = 6.0 * ROUNDING * f64::from(side) / 2.0;
        cases.push(pixels.case(format!("{side}x{side}"), Bound::AtMost(most), move || Ok(pixels_and_back(side))));
    }
    let angle = group("direction to cube face and back, unit vectors and all lengths", "radians");
    // Per axis, for numbers up to 1: two quotients, and two products and sums on the way back.
    let most = 6.0 * ROUNDING;
    let directions: [(&str, Directions); 4] = [
        ("edges of faces", edges),
        ("corners of faces", corners),
        ("an ulp beside edges and corners", || beside(&[edges(), corners()].concat())),
        ("thirds, sevenths and elevenths of faces", inside),
    ];
    for (name, make) in directions {
        cases.push(angle.case(name, Bound::AtMost(most), move || Ok(directions_and_back(&make()))));
    }
    let seams = group("pixels on both sides of a seam", "pixels that do not meet");
    let gaps = group("a seam from the faces on both sides", "radians between them");
    // One ulp of 1 outward and half an ulp inward, plus the bound of a direction and back on each side.
    let gap = 1.5 * f64::EPSILON + 2.0 * most;
    for side in [1, 3, 4, 7, 1024, 65_535] {
        let name = format!("{side}x{side}");
        cases.push(seams.none(name.clone(), move || Ok(seams_meet(side))));
        cases.push(gaps.case(name, Bound::AtMost(gap), move || Ok(seams_gape(side))));
    }
    let face = group("direction to cube face", "faces that do not look there");
    cases.push(face.none("edges, corners, thirds, signed zeros, all lengths", || Ok(wrong_faces())));
    let panorama = group("equirectangular pixel to direction and back", "of a pixel");
    for [width, height] in PANORAMAS {
        // Sines, cosines and arctangents with errors of up to 1 ulp each way, for angles of up to π; the width spans
        // 2π.
        let most = 12.0 * f64::EPSILON * f64::from(width);
        let name = format!("{width}x{height}, poles, date line and between");
        cases.push(panorama.case(name, Bound::AtMost(most), move || Ok(panorama_and_back(width, height))));
    }
    let places = group("direction to equirectangular position", "outside of the image");
    cases.push(places.none("poles, date line, signed zeros, all lengths", || Ok(outside_panorama())));
    let mixed = group("panorama resampled to cube faces", "pixels that are none of the source's");
    cases.push(mixed.none("depth: checkerboard of 1 m, 1 km and background", mixed_depth));
    let flat = group("panorama resampled to cube faces", "relative change");
    // Weights sum to 1 up to rounding, and half floats are rounded to the same value again.
    for value in [1.0, 65_504.0, 6e-8, -0.25] {
        let name = format!("colour: {value} everywhere, poles and date line too");
        cases.push(flat.none(name, move || changed_color(value)));
    }
    let planar = group("planar depth to distance and back", "of the distance");
    for (name, fov_deg) in
        [("90 degrees", 90.0), ("170 degrees", 170.0), ("179.9 degrees", 179.9), ("179.9999 degrees", 179.9999)]
    {
        // A factor of four operations, a product, and one rounding to binary32.
        let most = 1.0 / 16_777_216.0 + 8.0 * ROUNDING;
        cases.push(planar.case(name, Bound::AtMost(most), move || planar_and_back(fov_deg)));
    }
    cases.extend(sight::cases());
    cases
}

/// Returns pixel indices from 0 to `count` − 1: all if there are few, else both ends and a sample.
fn some(count: u32) -> Vec<u32> {
    let step = (count / 97).max(1) as usize;
    let ends = (0..count.min(4)).chain(count.saturating_sub(4)..count);
    let mut all: Vec<u32> = (0..count).step_by(step).chain(ends).collect();
    all.sort_unstable();
    all.dedup();
    all
}

fn pixels_and_back(side: u32) -> Measured {
    let mut worst = Measured::nothing();
    for face in Face::CUBE {
        let all = some(side);
        let image = ImageProjection::cube_face(face, side);
        for (&col, &row) in all.iter().flat_map(|col| all.iter().map(move |row| (col, row))) {
            // Normalises: along the exact axes no operation would round.
            let unit = face.direction(col, row, side).normalize();
            for length in LENGTHS {
                let FacePoint { face: found, plane: [u, v] } = direction_to_face(unit * length);
                let half = f64::from(side) / 2.0;
                let [at_u, at_v] = image.plane(centre_of(col, row));
                let off = ((u - at_u).abs() * half).max((v - at_v).abs() * half);
                let error = if found == face { off } else { f64::INFINITY };
                worst.greatest(error, || format!("{} pixel ({col}, {row}) is on {}", face.name(), found.name()));
            }
        }
    }
    worst
}

fn edges() -> Vec<DVec3> {
    let mut found = Vec::new();
    for face in Face::CUBE {
        // Steps of 1/63: thirds, sevenths and ninths, which binary64 cannot represent.
        for step in -63..=63 {
            let t = f64::from(step) / 63.0;
            found.extend([(1.0, t), (-1.0, t), (t, 1.0), (t, -1.0)].map(|(u, v)| on_face(face, [u, v])));
        }
    }
    found
}

fn corners() -> Vec<DVec3> {
    let sign = |bits: u32, at: u32| if bits >> at & 1 == 0 { 1.0 } else { -1.0 };
    (0..8).map(|bits| DVec3::new(sign(bits, 0), sign(bits, 1), sign(bits, 2))).collect()
}

fn inside() -> Vec<DVec3> {
    let mut found = Vec::new();
    for face in Face::CUBE {
        for (parts, (x, y)) in [3, 7, 11].into_iter().flat_map(|n| (0..n * n).map(move |at| (n, (at % n, at / n)))) {
            found.push(on_face(face, [x, y].map(|at: i32| f64::from(2 * at + 1 - parts) / f64::from(parts))));
        }
    }
    found
}

/// Scales a direction so that its largest component is near 1. The factor is a power of two, so nothing is rounded.
fn near_one(direction: DVec3) -> DVec3 {
    direction * (-direction.abs().max_element().log2().floor()).exp2()
}

/// Returns the directions with each component moved up and down by one ulp.
fn beside(directions: &[DVec3]) -> Vec<DVec3> {
    let moved = |value: f64, step: i64| {
        if value == 0.0 {
            f64::from_bits(step.unsigned_abs())
        } else {
            f64::from_bits(value.to_bits().wrapping_add_signed(step))
        }
    };
    let around = |d: &DVec3| {
        let (x, y, z) = (d.x, d.y, d.z);
        [-1, 1].map(|step| {
            [DVec3::new(moved(x, step), y, z), DVec3::new(x, moved(y, step), z), DVec3::new(x, y, moved(z, step))]
        })
    };
    directions.iter().flat_map(around).flatten().collect()
}

/// Returns the direction of a point in the plane of a face at distance 1.
fn on_face(face: Face, [u, v]: [f64; 2]) -> DVec3 {
    let [forward, right, down] = face.axes();
    forward + u * right + v * down
}

/// Returns the angle between a direction and the direction of its face coordinates. Infinite if these point to the
/// opposite side of the probe or lie outside the face.
fn angle_to_face(direction: DVec3) -> f64 {
    let FacePoint { face, plane: [u, v] } = direction_to_face(direction);
    let (back, direction) = (on_face(face, [u, v]), near_one(direction));
    let ahead = back.dot(direction) > 0.0 && u.abs() <= 1.0 && v.abs() <= 1.0;
    if ahead { angle_between(back, direction) } else { f64::INFINITY }
}

/// Computed from the sine, which stays accurate at small angles where the cosine does not.
fn angle_between(a: DVec3, b: DVec3) -> f64 {
    a.cross(b).length() / (a.length() * b.length())
}

fn directions_and_back(directions: &[DVec3]) -> Measured {
    let mut worst = Measured::nothing();
    for &direction in directions {
        let unit = direction.normalize();
        for asked in LENGTHS.map(|length| unit * length).into_iter().chain([direction]) {
            worst.greatest(angle_to_face(asked), || format!("{asked:?}"));
        }
    }
    worst
}

/// A point on the border of a face, at a pixel centre along the border.
struct Border {
    face: Face,
    pixel: u32,
    at: [f64; 2],
    /// Axis direction towards which it lies. The adjacent face looks along it.
    across: DVec3,
}

fn borders(side: u32) -> Vec<Border> {
    let mut found = Vec::new();
    for face in Face::CUBE {
        let [_, right, down] = face.axes();
        for pixel in some(side) {
            let [t, _] = ImageProjection::cube_face(face, side).plane(centre_of(pixel, pixel));
            let places = [([1.0, t], right), ([-1.0, t], -right), ([t, 1.0], down), ([t, -1.0], -down)];
            found.extend(places.map(|(at, across)| Border { face, pixel, at, across }));
        }
    }
    found
}

impl Border {
    fn sides(&self) -> [DVec3; 2] {
        let place = on_face(self.face, self.at);
        // Half an ulp of 1 inward and one ulp outward: the adjacent numbers.
        [place - self.across * ROUNDING, place + self.across * f64::EPSILON]
    }
}

/// Counts points on seams whose two sides do not map to the face and its neighbour, or map to different pixels along
/// the seam.
fn seams_meet(side: u32) -> Measured {
    let mut wrong = Measured::count(0);
    for border in borders(side) {
        let [inner, outer] = border.sides().map(direction_to_face);
        let neighbour = outer.face.axes()[0] == border.across;
        let pixel = |at: f64| (((at + 1.0) / 2.0 * f64::from(side)) as u32).min(side - 1);
        let own = if border.at[0].abs() == 1.0 { inner.plane[1] } else { inner.plane[0] };
        // On the neighbour, one coordinate is at its end on the seam; the other runs along it in either direction.
        let [u, v] = outer.plane;
        let ends = [u, v].map(|at| 1.0 - at.abs() < 1e-15);
        let runs_along = |along: f64| pixel(along) == border.pixel || side - 1 - pixel(along) == border.pixel;
        let meets = (ends[0] && runs_along(v)) || (ends[1] && runs_along(u));
        let is_own = inner.face == border.face && pixel(own) == border.pixel;
        wrong.count_if(!is_own || !neighbour || !meets, || format!("{} at {:?}", border.face.name(), border.at));
    }
    wrong
}

/// Returns the largest angle between the directions that both sides of a seam map to.
fn seams_gape(side: u32) -> Measured {
    let mut worst = Measured::nothing();
    for border in borders(side) {
        let [inner, outer] = border.sides().map(direction_to_face).map(|met| on_face(met.face, met.plane));
        worst.greatest(angle_between(inner, outer), || format!("{} at {:?}", border.face.name(), border.at));
    }
    worst
}

/// Counts directions whose face does not look along their largest component.
fn wrong_faces() -> Measured {
    let mut wrong = Measured::count(0);
    let axes = [DVec3::X, DVec3::Y, DVec3::Z].into_iter().flat_map(|axis| [axis, -axis]);
    let all: Vec<DVec3> = axes.chain(edges()).chain(corners()).chain(inside()).collect();
    for direction in all.iter().chain(&beside(&all)).copied() {
        for length in LENGTHS {
            let scaled = direction * length;
            let FacePoint { face, plane: [u, v] } = direction_to_face(scaled);
            let forward = scaled.dot(face.axes()[0]);
            let right = forward == scaled.abs().max_element() && u.abs() <= 1.0 && v.abs() <= 1.0;
            wrong.count_if(!right, || format!("{scaled:?} is on {} at ({u}, {v})", face.name()));
        }
    }
    wrong
}

fn panorama_and_back(width: u32, height: u32) -> Measured {
    let mut worst = Measured::nothing();
    let panorama = ImageProjection::Equirect { size: [width, height] };
    for &row in &some(height) {
        for &col in &some(width) {
            let [x, y] = panorama.project(panorama.pixel_direction(col, row)).unwrap_or([f64::NAN; 2]);
            let off = (x - f64::from(col) - 0.5).abs().max((y - f64::from(row) - 0.5).abs());
            worst.greatest(off, || format!("pixel ({col}, {row}) came back as ({x}, {y})"));
        }
    }
    worst
}

fn outside_panorama() -> Measured {
    let mut wrong = Measured::count(0);
    let signs = [0.0, -0.0];
    let mut all = vec![DVec3::Y, DVec3::NEG_Y];
    for (a, b) in signs.into_iter().flat_map(|a| signs.map(|b| (a, b))) {
        all.extend([DVec3::new(a, 1.0, b), DVec3::new(a, -1.0, b), DVec3::new(a, b, 1.0), DVec3::new(a, b, -1.0)]);
        all.extend([DVec3::new(a, b, -0.0), DVec3::new(1.0, a, b)]);
    }
    all.extend(beside(&all));
    for direction in all {
        for length in LENGTHS {
            let panorama = ImageProjection::Equirect { size: [64, 32] };
            let [x, y] = panorama.project(direction * length).unwrap_or([f64::NAN; 2]);
            let is_inside = (0.0..=64.0).contains(&x) && (0.0..=32.0).contains(&y);
            wrong.count_if(!is_inside, || format!("{direction:?} times {length:e} is at ({x}, {y})"));
        }
    }
    wrong
}

fn face_maps(width: u32, height: u32) -> Result<Vec<FaceMap>> {
    let faces = Face::CUBE.into_iter().flat_map(|face| [1, width / 4, width / 2].map(|size| (face, size.max(1))));
    faces.map(|(face, size)| FaceMap::new(face, size, width, height)).collect()
}

fn mixed_depth() -> Result<Measured> {
    let mut wrong = Measured::count(0);
    for [width, height] in RESAMPLED {
        let values = [1.0, 1000.0, f32::INFINITY];
        let image = Plane::from_fn(width, height, |x, y| values[(x + y) as usize % 3]);
        for map in face_maps(width, height)? {
            let shown = resample_nearest(&image, &map)?;
            for value in shown.data() {
                let is_mixed = !values.contains(value);
                wrong.count_if(is_mixed, || format!("{value} on {} of {width}x{height}", map.face.name()));
            }
        }
    }
    Ok(wrong)
}

fn changed_color(value: f64) -> Result<Measured> {
    let value = f16::from_f64(value);
    let mut worst = Measured::nothing();
    for [width, height] in RESAMPLED {
        let image = Plane::filled(width, height, [value; 3]);
        for map in face_maps(width, height)? {
            let shown = resample_color(&image, &map)?;
            let (face, size) = (map.face.name(), shown.width());
            for shown in shown.data().as_flattened() {
                let change = (shown.to_f64() / value.to_f64() - 1.0).abs();
                worst.greatest(change, || format!("{face} on a face of {size} pixels of {width}x{height}"));
            }
        }
    }
    Ok(worst)
}

/// Converts planar depth of a view of the given width to distance with the reader of datasets, and compares with
/// binary64.
fn planar_and_back(fov_deg: f64) -> Result<Measured> {
    const SIDE: u32 = 129;
    let focal = f64::from(SIDE) / 2.0 / (fov_deg / 360.0 * PI).tan();
    let intrinsics = [focal, focal, f64::from(SIDE) / 2.0, f64::from(SIDE) / 2.0];
    let mut worst = Measured::nothing();
    for planar_m in [1e-30f32, 0.001, 1.0, 7.3, 12_345.678, 1e30] {
        let mut plane = Plane::filled(SIDE, SIDE, planar_m);
        planar_to_distance(&mut plane, &ImageProjection::Pinhole { size: [SIDE; 2], intrinsics });
        for (row, col) in (0..SIDE).flat_map(|row| (0..SIDE).map(move |col| (row, col))) {
            let side = |pixel: u32| (f64::from(pixel) + 0.5 - f64::from(SIDE) / 2.0) / focal;
            let exact = side(col).hypot(side(row)).hypot(1.0) * f64::from(planar_m);
            let error = (f64::from(plane.get(col, row)) / exact - 1.0).abs();
            worst.greatest(error, || format!("{planar_m:e} m at ({col}, {row})"));
        }
    }
    Ok(worst)
}
