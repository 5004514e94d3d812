//! Hard cases of rendering: eyes in bad places, edges and corners of cubes, fences, steps over the whole depth range,
//! coincident probes, a single distance, no surfaces, all sizes.
//!
//! Measured on the CPU; [`super::device`] also renders the pictures on a device. Light fields are analytic, so that
//! results are known. Cases with an occluder are in [`super::hidden`].

use glam::{DVec3, Vec3};

use crate::case::{Bound, Family, Group, HardCase, Measured};
use codec::error::Result;
use codec::image::cube::{Face, FacePoint, direction_to_face};
use codec::image::{ToneMap, Transfer};
use codec::math::random::Random;
use codec::math::{Camera, Lens};
use codec::monitor::Silent;
use gpu::selftest::pictures::PictureCase;
use render::march::active_views::ActiveViews;
use render::march::counters::Counters;
use render::march::intersect::intersect;
use render::march::ray::{Ray, Steps};
use render::march::render::{Rendered, render, render_plainly};
use render::march::settings::{Acceleration, Refinements, RenderSettings, SpecularMode};
use render::march::synthetic::{Sight, SyntheticProbe, room};
use render::rendered_image::{BackgroundFill, HoleFill};
use render::views::light_field::{BACKGROUND, ColorCoding, ColorTexels, LightField, UNKNOWN};

/// Width and height of faces in texels, unless a case defines another size.
pub(super) const SIDE: u32 = 32;
/// Half the side lengths of the box-shaped scene, in metres.
const ROOM: DVec3 = DVec3::new(4.0, 1.5, 3.0);
const RAYS: usize = 2000;
const STEPS: u32 = 96;
const REFINE: u32 = 12;
pub(super) const CODES: ColorCoding = ColorCoding::Codes(ToneMap { transfer: Transfer::Srgb, exposure_ev: 0.0 });

pub(super) struct Setup {
    pub field: LightField,
    pub eye: DVec3,
    pub range_m: [f32; 2],
}

type Make = fn() -> Setup;

const SETUPS: [(&str, Make); 10] = [
    ("a room", || furnished(&POSITIONS, BESIDE)),
    ("along edges and corners of a cube", || furnished(&POSITIONS[..1], POSITIONS[0])),
    ("the eye in a wall", || furnished(&POSITIONS, DVec3::new(4.0, 0.0, 0.0))),
    ("the eye outside of all walls", || furnished(&POSITIONS, DVec3::new(9.0, 5.0, 0.0))),
    ("coincident probes", || furnished(&[POSITIONS[0]; 3], BESIDE)),
    (FENCE, fence),
    (STEPS_OF_ALL, steps_of_all),
    ("nothing but background", || made(|_| None)),
    ("every other texel unknown", || {
        let mut setup = furnished(&POSITIONS, BESIDE);
        for texels in setup.field.views.iter_mut().flat_map(|view| view.faces.iter_mut().flatten()) {
            texels.inverse_depth.iter_mut().skip(1).step_by(2).for_each(|texel| *texel = UNKNOWN);
        }
        setup
    }),
    ("near = far", || Setup { range_m: [1.0, 1.0], ..furnished(&POSITIONS, DVec3::new(3.5, 0.25, -0.5)) }),
];

const FENCE: &str = "a fence one texel wide";
const STEPS_OF_ALL: &str = "neighbours as far apart as near and far";

/// Positions of probes: multiples of 1/8 m, so that they stay exact far from the origin.
const POSITIONS: [DVec3; 4] = [
    DVec3::new(1.0, 0.0, -1.0),
    DVec3::new(-1.0, 0.5, -1.0),
    DVec3::new(1.0, -0.5, 1.0),
    DVec3::new(-1.125, 0.0, 1.25),
];

const BESIDE: DVec3 = DVec3::new(0.5, 0.25, -0.5);

pub(super) fn cases() -> Vec<HardCase> {
    let group = |pipeline: &str, unit| Group::new(Family::Render, pipeline, unit);
    let mut cases = Vec::new();
    let segments = group("segments of rays against all their points", "hits that differ");
    let packets = group("four rays at once against one by one", "wrong pixels");
    for (name, make) in SETUPS {
        cases.push(segments.none(name, move || Ok(by_segments(&make()))));
        cases.push(packets.none(name, move || {
            let setup = make();
            by_packets(&setup)?.with_picture_of(name, setup)
        }));
    }
    let own = group("the eye in a probe", "codes that differ");
    // A ray deviates from its texel's centre by at most 16 roundings of the side. A neighbouring texel can fit the hit
    // better than the texel itself by at most one step, which is weighted tenfold. 255 · 2 · 64 · 16 · 2⁻²⁴ · 10 < 0.5
    // codes.
    for side in [1, 2, 33, 64] {
        cases.push(own.none(format!("{side}x{side}"), move || own_codes_of(&own_room(side), side)));
    }
    let depths = group("the eye in a probe, rays through its texels", "distances that are not the texels'");
    for (name, make) in [(FENCE, fence as Make), (STEPS_OF_ALL, steps_of_all)] {
        let in_the_probe = move || Setup { eye: DVec3::ZERO, ..make() };
        cases.push(own.none(name, move || own_codes_of(&in_the_probe(), SIDE)));
        cases.push(depths.none(name, move || Ok(own_depths(&in_the_probe()))));
    }
    let near_is_far = || Setup { range_m: [1.0; 2], ..own_room(SIDE) };
    cases.push(depths.none("near = far", move || Ok(own_depths(&near_is_far()))));
    let scaled = group("hits at another size or place", "hits that differ");
    // Powers of two are exact in all operations, and so are positions that far from the origin, as multiples of 1/8 m.
    for (name, size, away) in [("1/1024", 1.0 / 1024.0, 0.0), ("1024", 1024.0, 0.0), ("1048 km away", 1.0, 1_048_576.0)]
    {
        cases.push(scaled.none(name, move || {
            elsewhere(size, away).with_picture_of(name, at_size(&POSITIONS, BESIDE, size, DVec3::splat(away)))
        }));
    }
    let bad = group("rays that can bring nothing", "rays that bring something");
    cases.push(bad.none("the eye outside of all walls", outside));
    let background = group("rays that meet nothing", "rays that meet something");
    cases.push(background.none("nothing but background", empty));
    let last = group("a surface at the last step", "missed");
    cases.push(last.none("walls just before far", || Ok(at_the_last_step())));
    let near = group("points within the near planes of all views", "taken for surfaces");
    cases.push(near.none("walls nearer than near", || {
        within_near().with_picture_of("walls nearer than near", walls_within_near())
    }));
    let copies = group("coincident probes against one", "codes");
    // Three times the terms of a sum of 4 weights, each rounded; colours of up to 255 codes.
    let most = 2.0 * 3.0 * 4.0 * 255.0 * f64::from(f32::EPSILON);
    cases.push(copies.case("three", Bound::AtMost(most), coincident));
    cases
}

fn furnished(positions: &[DVec3], eye: DVec3) -> Setup {
    at_size(positions, eye, 1.0, DVec3::ZERO)
}

fn at_size(positions: &[DVec3], eye: DVec3, size: f64, away: DVec3) -> Setup {
    let view = |&position: &DVec3| {
        let sight =
            |direction| room(position, direction, ROOM, 0.1).map(|(distance_m, color)| (distance_m * size, color));
        let range_m = [0.125, 16.0].map(|metres| metres * size as f32);
        SyntheticProbe { range_m, ..SyntheticProbe::new(position * size + away, SIDE) }.cube(CODES, &sight)
    };
    let field = LightField { views: positions.iter().map(view).collect(), coding: CODES };
    Setup { field, eye: eye * size + away, range_m: [0.0625, 16.0].map(|metres| metres * size as f32) }
}

fn own_room(side: u32) -> Setup {
    let position = POSITIONS[1];
    alone(position, side, &|direction| room(position, direction, ROOM, 0.1))
}

/// A single probe, with the eye at its position.
fn alone(position: DVec3, side: u32, sight: Sight<'_>) -> Setup {
    let view = SyntheticProbe::new(position, side).cube(CODES, sight);
    Setup { field: LightField { views: vec![view], coding: CODES }, eye: position, range_m: [0.0625, 16.0] }
}

fn fence() -> Setup {
    made(|direction| {
        let [u, _] = direction_to_face(direction).plane;
        let column = ((u + 1.0) * f64::from(SIDE) / 2.0) as u32;
        if column.is_multiple_of(2) { Some((1.0, [255; 3])) } else { room(DVec3::ZERO, direction, ROOM, 0.0) }
    })
}

/// Texels alternate between near and far.
fn steps_of_all() -> Setup {
    made(|direction| {
        let [u, v] = direction_to_face(direction).plane;
        let odd = [u, v].map(|at| ((at + 1.0) * f64::from(SIDE) / 2.0) as u32).iter().sum::<u32>() % 2;
        Some(([0.1, 100.0][odd as usize], [255 * odd as u8; 3]))
    })
}

fn made(sight: fn(DVec3) -> Option<(f64, [u8; 3])>) -> Setup {
    Setup { eye: DVec3::new(0.25, 0.125, -0.5), range_m: [0.01, 200.0], ..alone(DVec3::ZERO, SIDE, &sight) }
}

impl Setup {
    pub(super) fn views(&self) -> ActiveViews<'_> {
        let all: Vec<usize> = (0..self.field.views.len()).collect();
        ActiveViews::new(&self.field, &all, self.eye)
    }

    pub(super) fn steps(&self) -> Steps {
        Steps::new(STEPS, self.range_m[0], self.range_m[1], REFINE)
    }

    fn hit(&self, views: &ActiveViews<'_>, direction: Vec3) -> Option<f32> {
        let ray = Ray { origin: Vec3::ZERO, direction };
        intersect(Acceleration::None, views, &ray, &self.steps(), &mut Counters::default())
    }

    pub(super) fn settings(&self, side: u32) -> RenderSettings {
        RenderSettings {
            size: [side; 2],
            steps: self.steps(),
            samples: 1,
            holes: HoleFill::Blank,
            background: BackgroundFill::Opaque,
            specular: SpecularMode::None,
            max_bounces: 0,
            acceleration: Acceleration::Pyramid,
            refinements: Refinements::NONE,
        }
    }

    /// Returns the same settings with all refinements.
    pub(super) fn refined(&self, side: u32) -> RenderSettings {
        RenderSettings { refinements: Refinements::ALL, holes: HoleFill::Behind, ..self.settings(side) }
    }

    pub(super) fn on_device(mut self, label: &'static str, settings: RenderSettings) -> Result<PictureCase> {
        // Devices identify images by probe index.
        self.field.views.iter_mut().enumerate().for_each(|(at, view)| view.probe = at);
        let views = (0..self.field.views.len()).collect();
        Ok(PictureCase { label, views, camera: camera(self.eye, DVec3::NEG_Z)?, field: self.field, settings })
    }

    fn picture(&self) -> Result<Rendered> {
        render(&self.views(), &camera(self.eye, DVec3::X)?, &self.settings(SIDE), &Silent)
    }
}

impl Measured {
    pub(super) fn with_picture_of(self, label: &'static str, setup: Setup) -> Result<Measured> {
        let settings = setup.refined(SIDE);
        Ok(self.with_picture(setup.on_device(label, settings)?))
    }
}

pub(super) fn camera(eye: DVec3, forward: DVec3) -> Result<Camera> {
    let up = if forward.y == 0.0 { DVec3::Y } else { DVec3::X };
    let axes = glam::DMat3::from_cols(forward.cross(up), up, -forward);
    Camera::oriented(eye, glam::DQuat::from_mat3(&axes).normalize().to_array(), Lens::new(90.0))
}

/// Returns directions in all orientations; every tenth is along an axis, an edge or a corner of a cube.
fn directions() -> Vec<Vec3> {
    let mut random = Random::new(8);
    let mut any = |values: [f64; 3]| values[random.below(3) as usize];
    let special: Vec<DVec3> =
        (0..RAYS / 10).map(|_| DVec3::from_array([(); 3].map(|()| any([-1.0, 0.0, 1.0])))).collect();
    let mut random = Random::new(9);
    let mut part = || f64::from(random.word()) / f64::from(u32::MAX) * 2.0 - 1.0;
    let anywhere = (special.len()..RAYS).map(|_| DVec3::new(part(), part(), part()));
    special.iter().copied().chain(anywhere).filter_map(DVec3::try_normalize).map(|at| at.as_vec3()).collect()
}

fn by_segments(setup: &Setup) -> Measured {
    let (views, steps) = (setup.views(), setup.steps());
    let (mut dense, mut few) = (Counters::default(), Counters::default());
    let mut wrong = Measured::count(0);
    for direction in directions() {
        let ray = Ray { origin: Vec3::ZERO, direction };
        let all = intersect(Acceleration::None, &views, &ray, &steps, &mut dense);
        let some = intersect(Acceleration::Pyramid, &views, &ray, &steps, &mut few);
        wrong.count_if(some != all, || format!("towards {direction}: {some:?} instead of {all:?}"));
    }
    let note = format!("{} questions instead of {}", few.march_steps, dense.march_steps);
    wrong.with_note(note)
}

/// Counts pixels whose alpha differs or whose colour differs by more than half a code, and pictures whose counters
/// differ.
fn by_packets(setup: &Setup) -> Result<Measured> {
    let camera = camera(setup.eye, DVec3::NEG_Z)?;
    let (views, mut wrong) = (setup.views(), 0);
    for settings in [setup.settings(SIDE), setup.refined(SIDE)] {
        let fast = render(&views, &camera, &settings, &Silent)?;
        let plain = render_plainly(&views, &camera, &settings, &Silent)?;
        wrong += u64::from(fast.counters != plain.counters);
        for at in 0..fast.image.alpha.data().len() {
            let [a, b] = [&fast, &plain].map(|picture| picture.image.color.data()[at].map(code));
            let alike = (0..3).all(|channel| (a[channel] - b[channel]).abs() <= 0.5);
            wrong += u64::from(!alike || fast.image.alpha.data()[at] != plain.image.alpha.data()[at]);
        }
    }
    Ok(Measured::count(wrong))
}

/// Returns the fractional sRGB code of a linear value.
pub(super) fn code(light: f32) -> f64 {
    Transfer::Srgb.encode(f64::from(light)) * 255.0
}

/// Sums [`own_codes`] without refinements and with all.
fn own_codes_of(setup: &Setup, side: u32) -> Result<Measured> {
    let [plain, refined] = [setup.settings(side), setup.refined(side)].map(|settings| own_codes(setup, &settings, 0.5));
    Ok(Measured::count((plain?.figure + refined?.figure) as u64))
}

/// Counts pixels of pictures rendered from the first probe whose codes differ by at least `off` from the probe's, or
/// whose alpha is wrong. The expected alpha is 1, or 0 for a transparent background.
pub(super) fn own_codes(setup: &Setup, settings: &RenderSettings, off: f64) -> Result<Measured> {
    let side = settings.size[0];
    let mut wrong = Measured::count(0);
    for forward in [DVec3::X, DVec3::Y, DVec3::Z].into_iter().flat_map(|axis| [axis, -axis]) {
        let camera = camera(setup.eye, forward)?;
        let picture = render(&setup.views(), &camera, settings, &Silent)?;
        let pixels = picture.image.color.data().iter().zip(picture.image.alpha.data());
        for (at, (color, &alpha)) in (0..).zip(pixels) {
            let window = [at % side, at / side].map(|at| (f64::from(at) + 0.5) / f64::from(side));
            let FacePoint { face, plane: [u, v] } = direction_to_face(camera.direction(window));
            let [column, row] = [u, v].map(|at| (((at + 1.0) * f64::from(side) / 2.0) as u32).min(side - 1));
            let Some(texels) = &setup.field.views[0].faces[face as usize] else { continue };
            let ColorTexels::Codes(codes) = &texels.color else { continue };
            let texel = (row * side + column) as usize;
            let is_transparent = settings.background == BackgroundFill::Transparent;
            let is_shown = !is_transparent || texels.inverse_depth[texel] != BACKGROUND;
            let expected = if is_shown { codes[texel] } else { [0; 4] };
            let differs = (0..3).any(|channel| (code(color[channel]) - f64::from(expected[channel])).abs() >= off);
            wrong.count_if(differs || alpha != f32::from(u8::from(is_shown)), || {
                format!("{}, column {column}, row {row}", face.name())
            });
        }
    }
    Ok(wrong)
}

/// Counts rays from a probe through its texel centres whose hit is wrong. A hit must lie at the texel's depth or behind
/// it by at most the interval between two steps after all bisections. Surfaces beyond the last step must not be hit.
fn own_depths(setup: &Setup) -> Measured {
    let (views, steps) = (setup.views(), setup.steps());
    let rounding = 1e-5;
    let mut wrong = Measured::count(0);
    for (face, texels) in Face::CUBE.into_iter().zip(setup.field.views[0].faces.iter().flatten()) {
        let [forward, right, down] = face.axes();
        for (at, &inverse_depth) in (0u32..).zip(&texels.inverse_depth) {
            let [u, v] = [at % texels.size[0], at / texels.size[0]]
                .map(|at| (2.0 * f64::from(at) + 1.0) / f64::from(texels.size[0]) - 1.0);
            let way = forward + u * right + v * down;
            let distance_m = way.length() / f64::from(inverse_depth);
            let step = steps.distances_m.iter().position(|&step_m| f64::from(step_m) >= distance_m);
            let found = setup.hit(&views, way.normalize().as_vec3());
            let right = match (step, found) {
                (None, None) => true,
                (Some(step), Some(found)) => {
                    let before_m = step.checked_sub(1).map_or(0.0, |before| steps.distances_m[before]);
                    let interval_m = f64::from(steps.distances_m[step] - before_m);
                    let late_m = f64::from(found) - distance_m;
                    let max_m = interval_m * 0.5f64.powi(REFINE as i32);
                    (-rounding * distance_m..=max_m + rounding * distance_m).contains(&late_m)
                }
                _ => false,
            };
            wrong.count_if(!right, || format!("{} {u} {v}: {found:?} instead of {distance_m} m", face.name()));
        }
    }
    wrong
}

fn elsewhere(size: f64, away: f64) -> Measured {
    let here = at_size(&POSITIONS, BESIDE, 1.0, DVec3::ZERO);
    let there = at_size(&POSITIONS, BESIDE, size, DVec3::splat(away));
    let (views, other_views) = (here.views(), there.views());
    let mut wrong = Measured::count(0);
    for direction in directions() {
        let expected = here.hit(&views, direction).map(|metres| metres * size as f32);
        let found = there.hit(&other_views, direction);
        wrong.count_if(found != expected, || format!("towards {direction}: {found:?} instead of {expected:?}"));
    }
    wrong
}

fn outside() -> Result<Measured> {
    let counters = furnished(&POSITIONS, DVec3::new(9.0, 5.0, 0.0)).picture()?.counters;
    Ok(Measured::count(counters.primary_rays - counters.hole_rays))
}

fn empty() -> Result<Measured> {
    let picture = made(|_| None).picture()?;
    let blank = picture.image.alpha.data().iter().filter(|&&alpha| alpha != 1.0).count() as u64;
    Ok(Measured::count(picture.counters.primary_rays - picture.counters.background_rays + blank))
}

/// The eye is at the centre of a cube with walls at 1.5 m: rays along the axes hit them between the last two steps.
fn at_the_last_step() -> Measured {
    let walls = |direction| room(DVec3::ZERO, direction, DVec3::splat(1.5), 0.0);
    let setup = Setup { range_m: [0.01, 1.5 * 1.0001], ..alone(DVec3::ZERO, SIDE, &walls) };
    let views = setup.views();
    let mut wrong = 0;
    for direction in [Vec3::X, Vec3::Y, Vec3::Z].into_iter().flat_map(|axis| [axis, -axis]) {
        let ray = Ray { origin: Vec3::ZERO, direction };
        for how in [Acceleration::None, Acceleration::Pyramid] {
            wrong += u64::from(intersect(how, &views, &ray, &setup.steps(), &mut Counters::default()).is_none());
        }
    }
    Measured::count(wrong)
}

fn walls_within_near() -> Setup {
    let mut setup = furnished(&POSITIONS[..1], POSITIONS[0]);
    setup.field.views[0].near_m = 8.0;
    setup
}

/// Walls nearer than the views' near planes: points in front of the near planes are no surfaces, all points beyond are.
fn within_near() -> Measured {
    let setup = walls_within_near();
    let views = setup.views();
    // The first step beyond 8 m is a surface; refinement moves back to 8 m, up to rounding.
    let wrong =
        directions().into_iter().filter(|&direction| !setup.hit(&views, direction).is_some_and(|hit| hit > 7.999));
    Measured::count(wrong.count() as u64)
}

fn coincident() -> Result<Measured> {
    let one = furnished(&POSITIONS[..1], BESIDE).picture()?;
    let three = furnished(&[POSITIONS[0]; 3], BESIDE).picture()?;
    let mut worst = Measured::nothing();
    for (at, (a, b)) in one.image.color.data().iter().zip(three.image.color.data()).enumerate() {
        let off = (0..3).map(|channel| (code(a[channel]) - code(b[channel])).abs()).fold(0.0, f64::max);
        let off = if one.image.alpha.data()[at] == three.image.alpha.data()[at] { off } else { f64::NAN };
        worst.greatest(off, || format!("pixel {at}"));
    }
    Ok(worst)
}
