//! Hard cases of disocclusion: a rectangle before a wall hides part of it from all probes, and the eye looks in from
//! the side.
//!
//! Edges of the rectangle coincide with texel edges of every probe, and eye and probes lie on a line along an edge. So
//! it is known for each ray which region hidden from all probes it enters, and where.

use glam::DVec3;

use crate::case::{Family, Group, HardCase, Measured};
use crate::render::{CODES, SIDE, Setup, camera};
use codec::error::Result;
use codec::math::Camera;
use codec::monitor::Silent;
use render::march::active_views::HOLE_DIFFERENCE;
use render::march::ray::Steps;
use render::march::render::{Rendered, render, render_plainly};
use render::march::settings::RenderSettings;
use render::march::synthetic::{SyntheticProbe, room};
use render::rendered_image::HoleFill;
use render::views::light_field::LightField;

/// Positions of probes and eye on the x axis: multiples of 1/16 m, the width of a texel at 1 m.
const PROBES_M: [f64; 2] = [0.0, -0.5];
const EYE_M: f64 = 1.0;
/// Left and right edge of the rectangle, which is 1 m away, and half its height.
const EDGES_M: [f64; 2] = [-0.5, 0.25];
const HALF_HEIGHT_M: f64 = 0.5;
const WALL_M: f64 = 4.0;
/// Pixels per row. Odd, so that no ray runs along an edge.
const PIXELS: u32 = 33;
/// Number of pixels that show surfaces hidden from all probes: 10 columns of 17.
const HOLES: u64 = 170;
const RED: [u8; 3] = [200, 0, 0];

pub(super) fn cases() -> Vec<HardCase> {
    let hidden = Group::new(Family::Render, "parts that a rectangle hides from all probes", "wrong pixels");
    vec![
        hidden.none("holes blank", || wrong(HoleFill::Blank)),
        hidden.none("holes filled", || wrong(HoleFill::Nearest)),
    ]
}

fn sight(eye: DVec3, direction: DVec3) -> Option<(f64, [u8; 3])> {
    let at = eye + direction / -direction.z;
    let meets = direction.z < 0.0 && (EDGES_M[0]..EDGES_M[1]).contains(&at.x) && at.y.abs() < HALF_HEIGHT_M;
    if meets { Some((1.0 / -direction.z, RED)) } else { room(eye, direction, DVec3::splat(WALL_M), 0.0) }
}

fn setup() -> Setup {
    let view = |x| {
        let position = DVec3::new(x, 0.0, 0.0);
        SyntheticProbe::new(position, SIDE).cube(CODES, &|direction| sight(position, direction))
    };
    let field = LightField { views: PROBES_M.map(view).into(), coding: CODES };
    Setup { field, eye: DVec3::new(EYE_M, 0.0, 0.0), range_m: [0.05, 16.0] }
}

/// True if a ray through a pixel centre ends at a point that no probe sees; `None` if that depends on rounding.
/// `across` and `down` are the ray's slopes per metre ahead. The ray enters the region hidden from a probe at the
/// planar depth where it crosses the line from the probe through the right edge, and stays hidden up to the wall.
fn is_hole([across, down]: [f64; 2]) -> Option<bool> {
    let enters_m = |probe: f64| {
        let narrows = EDGES_M[1] - probe - across;
        if narrows > 0.0 { (EYE_M - probe) / narrows } else { f64::INFINITY }
    };
    let all_m = PROBES_M.map(enters_m).into_iter().fold(0.0, f64::max);
    let away = |surface_m: f64| (all_m / surface_m).ln().abs() - f64::from(HOLE_DIFFERENCE);
    // Rays further right do not enter a hidden region; those further left hit the rectangle or pass it.
    if down.abs() > HALF_HEIGHT_M || !(1.0..WALL_M).contains(&all_m) {
        return Some(false);
    }
    let nearest = away(1.0).min(away(WALL_M));
    (nearest.abs() > 1e-3).then_some(nearest > 0.0)
}

fn settings(setup: &Setup, holes: HoleFill) -> RenderSettings {
    RenderSettings { holes, steps: Steps::new(1024, 0.05, 16.0, 16), ..setup.settings(PIXELS) }
}

fn picture(plainly: bool, holes: HoleFill) -> Result<Rendered> {
    let setup = setup();
    let settings = settings(&setup, holes);
    let how: fn(&_, &Camera, &_, &_) -> _ = if plainly { render_plainly } else { render };
    how(&setup.views(), &camera(setup.eye, DVec3::NEG_Z)?, &settings, &Silent)
}

/// Counts pixels whose alpha or colour is wrong. A hole is black if left blank, and contains the red of the rectangle
/// if filled. Pixels that depend on rounding count as wrong.
fn wrong(holes: HoleFill) -> Result<Measured> {
    let mut wrong = Measured::count(0);
    for plainly in [false, true] {
        let picture = picture(plainly, holes)?;
        wrong.figure += picture.counters.hole_rays.abs_diff(HOLES) as f64;
        for (at, (&alpha, color)) in (0u32..).zip(picture.image.alpha.data().iter().zip(picture.image.color.data())) {
            let [column, row] = [at % PIXELS, at / PIXELS];
            let way = [column, row].map(|at| f64::from(2 * at + 1) / f64::from(PIXELS) - 1.0);
            let right = match is_hole(way) {
                Some(true) if holes == HoleFill::Blank => alpha == 0.0 && *color == [0.0; 3],
                Some(true) => alpha == 0.0 && color[0] > 0.01 && color.iter().all(|light| light.is_finite()),
                Some(false) => alpha == 1.0,
                None => false,
            };
            wrong.count_if(!right, || format!("column {column}, row {row}: alpha {alpha}, colour {color:?}"));
        }
    }
    let setup = setup();
    let settings = settings(&setup, holes);
    Ok(wrong.with_picture(setup.on_device("hidden from all probes", settings)?))
}
