//! Hard cases of rendering with all refinements: surfaces thinner than texels, edges, and probes that disagree.

use glam::DVec3;

use crate::case::{Bound, Family, Group, HardCase, Measured};
use crate::render::{CODES, SIDE, Setup, camera, code, own_codes};
use codec::error::Result;
use codec::monitor::Silent;
use render::march::render::render;
use render::march::settings::RenderSettings;
use render::march::synthetic::{SyntheticProbe, room};
use render::rendered_image::BackgroundFill;
use render::views::light_field::{BACKGROUND, ColorTexels, LightField, UNKNOWN};

const WALL_M: f64 = 4.0;
const RED: [u8; 3] = [220, 20, 20];
const GRAY: [u8; 3] = [90, 120, 200];
/// Positions of probes: multiples of 1/16 m, the width of a texel at 1 m.
const PROBES: [DVec3; 3] = [DVec3::ZERO, DVec3::new(0.25, 0.0, 0.0), DVec3::new(-0.1875, 0.125, 0.0625)];
/// Centre of a texel of the first probe at 1 m.
const ROD_M: f64 = 1.0 / 32.0;
/// Maximum error caused by a probe with wrong depth, the farthest of four from the eye, relative to its error alone.
const PART_OF_ONE: f64 = 0.5;

pub(super) fn cases() -> Vec<HardCase> {
    let own = Group::new(Family::Render, "the eye in a probe among others", "codes more than one off");
    let edge = Group::new(Family::Render, "edges of one colour", "pixels of another");
    let unknown = Group::new(Family::Render, "rays that can bring nothing", "rays that bring something");
    let wrong = Group::new(Family::Render, "a probe whose depth is wrong", "of its error alone");
    let alpha = Group::new(Family::Render, "a transparent background", "pixels of other colour or alpha");
    let still = Group::new(Family::Render, "a rod that moves", "pixels elsewhere that change");
    let mut cases = vec![
        alpha.none("colours without depth, depth without colours", color_without_surface),
        still.none("from one column of texels to another", moving_rod),
        edge.none("a rod before a wall", one_color),
        unknown.none("all texels unknown", nothing_known),
        wrong.case("a metre too near, among four", Bound::AtMost(PART_OF_ONE), || wrong_by_metres(-1.0)),
        wrong.case("a metre too far, among four", Bound::AtMost(PART_OF_ONE), || wrong_by_metres(1.0)),
    ];
    for (name, width_m, seen_by) in [
        ("a rod that it alone saw", 1.0 / 16.0, 1),
        ("a rod of a fifth of a texel that it alone saw", 1.0 / 80.0, 1),
        ("a rod of a fifth of a texel", 1.0 / 80.0, PROBES.len()),
    ] {
        cases.push(own.none(name, move || {
            let setup = rod(ROD_M, width_m, seen_by);
            own_codes(&setup, &setup.refined(SIDE), 1.0)?.with_picture_of(name, Setup { eye: BESIDE, ..setup })
        }));
    }
    cases
}

/// An eye between the probes.
const BESIDE: DVec3 = DVec3::new(0.1, 0.05, -0.03);

/// Returns a red rod 1 m in front of the probes, at `rod_m` right of the first, and a wall behind it. Only the first
/// `seen_by` probes see it.
fn rod(rod_m: f64, width_m: f64, seen_by: usize) -> Setup {
    let view = |(number, &position): (usize, &DVec3)| {
        SyntheticProbe::new(position, SIDE).cube(CODES, &|direction| {
            let at = position + direction * ((-1.0 - position.z) / direction.z);
            let meets = direction.z < 0.0 && (at.x - rod_m).abs() < width_m / 2.0 && at.y.abs() < 0.5;
            match meets && number < seen_by {
                true => Some(((at - position).length(), RED)),
                false => room(position, direction, DVec3::splat(WALL_M), 0.0),
            }
        })
    };
    let views = PROBES.iter().enumerate().map(view).collect();
    Setup { field: LightField { views, coding: CODES }, eye: PROBES[0], range_m: [0.05, 16.0] }
}

/// If rod and wall have the same colour, every pixel must have it, whichever of the two it shows.
fn one_color() -> Result<Measured> {
    let mut setup = rod(ROD_M, 1.0 / 20.0, PROBES.len());
    for texels in setup.field.views.iter_mut().flat_map(|view| view.faces.iter_mut().flatten()) {
        if let ColorTexels::Codes(codes) = &mut texels.color {
            codes.fill([GRAY[0], GRAY[1], GRAY[2], 0]);
        }
    }
    setup.eye = BESIDE;
    let picture = render(&setup.views(), &camera(BESIDE, DVec3::NEG_Z)?, &setup.refined(SIDE), &Silent)?;
    let is_gray = |color: &[f32; 3]| (0..3).all(|at| (code(color[at]) - f64::from(GRAY[at])).abs() < 0.5);
    let pixels = picture.image.color.data().iter().zip(picture.image.alpha.data());
    Ok(Measured::count(pixels.filter(|(color, alpha)| !is_gray(color) || **alpha != 1.0).count() as u64))
}

/// A checkerboard of white background and black surfaces: alpha follows depth, and no white appears next to it.
fn color_without_surface() -> Result<Measured> {
    let view = SyntheticProbe::new(DVec3::ZERO, SIDE).cube(CODES, &|_| Some((2.0, [0; 3])));
    let mut setup =
        Setup { field: LightField { views: vec![view], coding: CODES }, eye: DVec3::ZERO, range_m: [0.05, 16.0] };
    for texels in setup.field.views[0].faces.iter_mut().flatten() {
        let ColorTexels::Codes(codes) = &mut texels.color else { continue };
        for (at, (code, inverse_depth)) in (0..).zip(codes.iter_mut().zip(&mut texels.inverse_depth)) {
            if (at % SIDE / 8 + at / SIDE / 8).is_multiple_of(2) {
                (*code, *inverse_depth) = ([255, 255, 255, 0], BACKGROUND);
            }
        }
    }
    let settings = RenderSettings { background: BackgroundFill::Transparent, ..setup.refined(SIDE) };
    let measured = own_codes(&setup, &settings, 0.5)?;
    let (beside, settings) = (Setup { eye: BESIDE, ..setup }, RenderSettings { samples: 4, ..settings });
    let picture = render(&beside.views(), &camera(BESIDE, DVec3::NEG_Z)?, &settings, &Silent)?;
    let white = picture.image.color.data().iter().flatten().filter(|&&light| code(light) >= 0.5).count();
    let all = Measured::count(measured.figure as u64 + white as u64);
    Ok(all.with_picture(beside.on_device("colours without depth", settings)?))
}

/// Counts pixels that change as a rod moves, although neither the eye nor a probe sees the rod before that part of the
/// wall.
fn moving_rod() -> Result<Measured> {
    // Half a rod, the texels around a point, and one more texel.
    const NEAR_M: f64 = 3.0 / 16.0;
    let rods_m = [ROD_M, ROD_M + 0.25];
    let camera = camera(BESIDE, DVec3::NEG_Z)?;
    let picture = |rod_m: f64| {
        let setup = Setup { eye: BESIDE, ..rod(rod_m, 1.0 / 16.0, PROBES.len()) };
        Ok(render(&setup.views(), &camera, &setup.refined(SIDE), &Silent)?.image)
    };
    let [before, after] = [picture(rods_m[0])?, picture(rods_m[1])?];
    let (mut wrong, mut elsewhere) = (Measured::count(0), 0);
    for (x, y) in (0..SIDE * SIDE).map(|at| (at % SIDE, at / SIDE)) {
        let direction = camera.direction([x, y].map(|at| (f64::from(at) + 0.5) / f64::from(SIDE)));
        let (distance_m, _) = room(BESIDE, direction, DVec3::splat(WALL_M), 0.0).unwrap_or_default();
        let wall = BESIDE + distance_m * direction;
        let is_near = |from: &DVec3| {
            let at = *from + (wall - *from) * ((-1.0 - from.z) / (wall.z - from.z));
            wall.z < -1.0 && rods_m.iter().any(|rod_m| (at.x - rod_m).abs() < NEAR_M)
        };
        if PROBES.iter().chain([&BESIDE]).any(is_near) {
            continue;
        }
        elsewhere += 1;
        wrong.count_if(before.color.get(x, y) != after.color.get(x, y), || format!("column {x}, row {y}"));
    }
    wrong.count_if(elsewhere < SIDE * SIDE / 4, || format!("only {elsewhere} pixels are elsewhere"));
    Ok(wrong.with_note(format!("{elsewhere} of {} pixels", SIDE * SIDE)))
}

fn nothing_known() -> Result<Measured> {
    let mut setup = rod(ROD_M, 1.0 / 16.0, PROBES.len());
    for texels in setup.field.views.iter_mut().flat_map(|view| view.faces.iter_mut().flatten()) {
        texels.inverse_depth.fill(UNKNOWN);
    }
    let picture = render(&setup.views(), &camera(BESIDE, DVec3::NEG_Z)?, &setup.refined(SIDE), &Silent)?;
    let shown = picture.image.alpha.data().iter().filter(|alpha| **alpha != 0.0).count() as u64;
    Ok(Measured::count(shown + picture.counters.primary_rays - picture.counters.hole_rays))
}

/// Returns the RMS error of a scene rendered from four probes, divided by that from the first one alone. The first is
/// the farthest from the eye, and all its surfaces are `metres` too far (negative: too near).
fn wrong_by_metres(metres: f64) -> Result<Measured> {
    let half = DVec3::splat(WALL_M);
    let corners = [[0.5, 0.0, 0.5], [-0.5, 0.0, 0.5], [0.5, 0.0, -0.5], [-0.5, 0.0, -0.5]].map(DVec3::from_array);
    let eye = DVec3::new(-0.125, 0.0, -0.125);
    let view = |(number, &position): (usize, &DVec3)| {
        SyntheticProbe::new(position, SIDE).cube(CODES, &|direction| {
            let (distance_m, color) = room(position, direction, half, 0.0)?;
            Some((distance_m + if number == 0 { metres } else { 0.0 }, color))
        })
    };
    let error = |count: usize| -> Result<f64> {
        let views = corners.iter().enumerate().take(count).map(view).collect();
        let setup = Setup { field: LightField { views, coding: CODES }, eye, range_m: [0.05, 16.0] };
        let camera = camera(eye, DVec3::NEG_Z)?;
        let picture = render(&setup.views(), &camera, &setup.refined(SIDE), &Silent)?;
        let mut sum = 0.0;
        for (at, color) in (0u32..).zip(picture.image.color.data()) {
            let window = [at % SIDE, at / SIDE].map(|at| (f64::from(at) + 0.5) / f64::from(SIDE));
            let (_, truth) = room(eye, camera.direction(window), half, 0.0).unwrap_or_default();
            sum += (0..3).map(|at| (code(color[at]) - f64::from(truth[at])).powi(2)).sum::<f64>();
        }
        Ok(sum)
    };
    let mut worst = Measured::nothing();
    worst.greatest((error(corners.len())? / error(1)?).sqrt(), || "RMS of codes".into());
    Ok(worst)
}
