//! Compares optimised implementations with scalar references: hits and counts are the same bits, and images are the same.

use std::sync::atomic::{AtomicU64, Ordering};

use glam::{DQuat, DVec3, Vec3};

use crate::march::active_views::ActiveViews;
use crate::march::baseline::splat::splat;
use crate::march::counters::Counters;
use crate::march::intersect::{intersect, intersect_from};
use crate::march::layers::{FirstHits, Primary};
use crate::march::packet::render::PacketScene;
use crate::march::pyramid::{DepthPyramid, Pyramids};
use crate::march::ray::{Ray, Steps, StepsFrom};
use crate::march::render::{Rendered, render, render_plainly};
use crate::march::samples::{EDGE_BLACK, EDGE_CONTRAST};
use crate::march::settings::{Acceleration, Refinements, RenderSettings, SpecularMode};
use crate::march::synthetic::{SyntheticProbe, room, set_alpha, set_alpha_of_blocks};
use crate::rendered_image::{BackgroundFill, HoleFill};
use crate::views::light_field::{BACKGROUND, ColorCoding, FaceTexels, LightField, UNKNOWN, View};
use codec::error::Error;
use codec::image::transfer::{ToneMap, Transfer};
use codec::image::{Face, TexelMap};
use codec::math::{Camera, Lens};
use codec::monitor::{Monitor, Silent};

pub fn field(views: Vec<View>, coding: ColorCoding) -> LightField {
    LightField { views, coding }
}

const CODES: ColorCoding = ColorCoding::Codes(ToneMap { transfer: Transfer::Srgb, exposure_ev: 0.0 });

/// Reproducible pseudorandom numbers in 0..1.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    fn below(&mut self, count: u32) -> u32 {
        (self.next() * f64::from(count)) as u32
    }

    fn vector(&mut self) -> DVec3 {
        DVec3::new(self.next(), self.next(), self.next()) * 2.0 - 1.0
    }

    fn unit(&mut self) -> DVec3 {
        self.vector().try_normalize().unwrap_or(DVec3::X)
    }

    fn turn(&mut self) -> DQuat {
        if self.below(2) == 0 { DQuat::IDENTITY } else { DQuat::from_axis_angle(self.unit(), 6.0 * self.next()) }
    }
}

/// A room seen by views of various sizes and orientations, with noise, background, unknown texels, and missing faces.
fn random_field(random: &mut Random, coding: ColorCoding) -> LightField {
    let half = DVec3::new(1.0 + 5.0 * random.next(), 1.0 + random.next(), 1.0 + 5.0 * random.next());
    let origin = if random.below(4) == 0 { DVec3::splat(1e6) } else { DVec3::ZERO };
    let count = 1 + random.below(6);
    let views = (0..count).map(|_| random_view(random, half, origin, coding)).collect();
    field(views, coding)
}

fn random_view(random: &mut Random, half: DVec3, origin: DVec3, coding: ColorCoding) -> View {
    let within = half * random.vector() * 0.9;
    let is_cube = random.below(5) != 0;
    let side = 1 + random.below(48);
    let size = if is_cube && random.below(3) != 0 { [side; 2] } else { [side, 1 + random.below(48)] };
    let made = SyntheticProbe { position: origin + within, turn: random.turn(), size, range_m: [0.05, 50.0] };
    let noise = [0.0, 0.01, 0.8][random.below(3) as usize];
    let seed = std::cell::RefCell::new(Random(random.0));
    let sight = |direction: DVec3| {
        let (distance_m, color) = room(within, direction, half, 0.1)?;
        Some(((distance_m * (1.0 + noise * (seed.borrow_mut().next() - 0.5))).max(0.05), color))
    };
    let mut view = if is_cube {
        made.cube(coding, &sight)
    } else {
        let focal = size.map(|pixels| pixels as f32 * (0.2 + random.next() as f32));
        let centre = size.map(|pixels| pixels as f32 * random.next() as f32);
        let mut view = made.view();
        let map = TexelMap { scale: focal, centre };
        view.faces[Face::View as usize] = Some(made.face(Face::View, map, coding, &sight));
        view
    };
    for face in &mut view.faces {
        let Some(texels) = face else { continue };
        if random.below(20) == 0 {
            *face = None;
            continue;
        }
        for _ in 0..random.below(3) {
            let value = [UNKNOWN, BACKGROUND, 15.0][random.below(3) as usize];
            let [left, top] = texels.size.map(|size| random.below(size));
            let [right, bottom] = [left, top].map(|at| at + 1 + random.below(9));
            let (columns, rows) = (left..right.min(texels.size[0]), top..bottom.min(texels.size[1]));
            for row in rows {
                for column in columns.clone() {
                    texels.inverse_depth[(row * texels.size[0] + column) as usize] = value;
                }
            }
        }
    }
    view
}

/// Returns the first hits of packets, with their counts of march and refinement steps.
fn of_packets(views: &ActiveViews<'_>, directions: &[Vec3], settings: &RenderSettings) -> (Vec<FirstHits>, Counters) {
    let primary = Primary::new(views, None, settings);
    let scene = PacketScene::new(&primary);
    let (mut row, mut counters) = (scene.row(), Counters::default());
    let first_hits = |four: &[Vec3]| row.first_hits(four, &mut counters).into_iter().take(four.len());
    let hits = directions.chunks(4).flat_map(first_hits).collect();
    (hits, counters)
}

/// Like [`of_packets`], ray by ray.
fn of_rays(views: &ActiveViews<'_>, directions: &[Vec3], settings: &RenderSettings) -> (Vec<FirstHits>, Counters) {
    let (primary, mut counters) = (Primary::new(views, None, settings), Counters::default());
    let hits =
        directions.iter().map(|&direction| primary.first_hits(&Ray { origin: Vec3::ZERO, direction }, &mut counters));
    let hits = hits.collect();
    (hits, counters)
}

fn settings_of(steps: Steps, acceleration: Acceleration, refinements: Refinements) -> RenderSettings {
    RenderSettings {
        size: [1; 2],
        steps,
        samples: 1,
        holes: HoleFill::Blank,
        background: BackgroundFill::Opaque,
        specular: SpecularMode::None,
        max_bounces: 0,
        acceleration,
        refinements,
    }
}

#[test]
fn hits_are_the_same_bits() {
    let mut random = Random(1);
    let (mut rays, mut met) = (0, 0);
    for _ in 0..400 {
        let light_field = random_field(&mut random, CODES);
        let indices: Vec<usize> = (0..light_field.views.len()).collect();
        let at = light_field.views[random.below(indices.len() as u32) as usize].position;
        let eye = match random.below(3) {
            0 => at,
            1 => at + 0.01 * random.vector(),
            _ => at + 3.0 * random.vector(),
        };
        // Empty pyramids prove no segment empty.
        let views = match random.below(4) {
            0 => ActiveViews::with_pyramids(&light_field, &Pyramids::default(), &indices, eye),
            _ => ActiveViews::new(&light_field, &indices, eye),
        };
        let near_m = [0.005, 0.3][random.below(2) as usize];
        let count = [1, 7, 64, 65, 200][random.below(5) as usize];
        let steps = Steps::new(count, near_m, [20.0, near_m][usize::from(random.below(9) == 0)], random.below(10));
        let axis = |random: &mut Random| {
            [DVec3::X, -DVec3::Y, DVec3::Z, DVec3::new(1.0, 1.0, 0.0).normalize()][random.below(4) as usize]
        };
        // Rays of a packet diverge, or are adjacent like those of an image.
        let (spread, mut middle) = ([2.0, 0.1, 0.002][random.below(3) as usize], DVec3::X);
        let direction = |at: u32| {
            if at.is_multiple_of(16) {
                return axis(&mut random).as_vec3();
            }
            if at.is_multiple_of(4) {
                middle = random.unit();
            }
            (middle + spread * random.vector()).try_normalize().unwrap_or(DVec3::Y).as_vec3()
        };
        let directions: Vec<Vec3> = (0..257).map(direction).collect();
        let bits = |hits: &[FirstHits]| {
            let of = |hits: &FirstHits| [hits.nearest_m, hits.all_m].map(|hit_m| hit_m.map(f32::to_bits));
            hits.iter().map(of).collect::<Vec<_>>()
        };
        let refined = refinements(random.below(8));
        let [plain, fast] = [Acceleration::None, Acceleration::Pyramid]
            .map(|how| of_rays(&views, &directions, &settings_of(steps.clone(), how, refined)));
        assert_eq!(bits(&fast.0), bits(&plain.0));
        let hits: Vec<Option<f32>> = plain.0.iter().map(|hits| hits.all_m).collect();
        for (how, expected) in [(Acceleration::None, plain), (Acceleration::Pyramid, fast)] {
            let (of_packets, counts) = of_packets(&views, &directions, &settings_of(steps.clone(), how, refined));
            assert_eq!(bits(&of_packets), bits(&expected.0), "{how:?}");
            assert_eq!(counts, expected.1, "{how:?}");
        }
        let (mut plain, mut fast) = (Counters::default(), Counters::default());
        // Rays from other origins, starting at a later step.
        for direction in directions.iter().take(16) {
            let ray = Ray { origin: random.vector().as_vec3(), direction: *direction };
            let first = random.below(count + 2) as usize;
            let hit =
                intersect_from(Acceleration::Pyramid, &views, &ray, StepsFrom { steps: &steps, first }, &mut fast);
            let nearer = if first == 0 { 0.0 } else { steps.distances_m[(first - 1).min(steps.distances_m.len() - 1)] };
            let rest =
                steps.distances_m.get(first..).unwrap_or_default().iter().position(|&m| views.is_surface(ray.at(m)));
            let expected = rest.map(|at| {
                let before_m = if at == 0 { nearer } else { steps.distances_m[first + at - 1] };
                views.refine(&ray, [before_m, steps.distances_m[first + at]], steps.refine(), &mut plain)
            });
            assert_eq!(hit, expected);
        }
        rays += directions.len();
        met += hits.iter().flatten().count();
    }
    assert!(rays >= 100_000 && met > rays / 5 && met < rays, "{met} of {rays}");
}

fn furnished() -> LightField {
    let half = DVec3::new(4.0, 1.5, 3.0);
    let position =
        |at: u32| DVec3::new(f64::from(at % 3) - 1.0, 0.3 * f64::from(at % 2), 0.8 * f64::from(at / 3) - 1.7);
    let view =
        |at| SyntheticProbe::new(position(at), 64).cube(CODES, &|direction| room(position(at), direction, half, 0.1));
    field((0..9).map(view).collect(), CODES)
}

#[test]
fn segments_save_most_steps() {
    let light_field = furnished();
    let views = ActiveViews::new(&light_field, &[0, 1, 2, 3, 4, 5, 6, 7, 8], DVec3::new(0.5, 0.1, -1.2));
    let mut random = Random(2);
    let directions: Vec<Vec3> = (0..4000).map(|_| random.unit().as_vec3()).collect();
    for (count, times) in [(64, 3), (256, 8), (512, 15)] {
        let steps = Steps::new(count, 0.02, views.far_m(), 0);
        let steps_of =
            |how| of_packets(&views, &directions, &settings_of(steps.clone(), how, Refinements::NONE)).1.march_steps;
        let (dense, few) = (steps_of(Acceleration::None), steps_of(Acceleration::Pyramid));
        assert!(few * times <= dense, "{count}: {few} of {dense}");
    }
}

/// Returns one of the eight combinations.
fn refinements(at: u32) -> Refinements {
    Refinements { angles: at & 1 == 0, edges: at & 2 == 0, thin: at & 4 == 0 }
}

#[test]
fn pictures_are_the_same_to_a_hundredth_of_a_code() {
    let mut random = Random(3);
    let mut differing = 0;
    for at in 0..120 {
        let coding = if at % 3 == 0 { ColorCoding::Light } else { CODES };
        let mut light_field = random_field(&mut random, coding);
        let has_alpha = at >= 60;
        if has_alpha {
            light_field.views.iter_mut().skip(1).for_each(|view| set_alpha_of_blocks(view, [3, 5]));
        }
        let indices: Vec<usize> = (0..light_field.views.len()).collect();
        let eye = light_field.views[0].position + 0.3 * random.vector();
        let views = ActiveViews::new(&light_field, &indices, eye);
        let [near_m, far_m] = if at % 5 == 1 { [1.5, 4.0] } else { [0.0, f64::INFINITY] };
        let lens = Lens { aspect: 1.5, near_m, far_m, ..Lens::new(70.0) };
        let camera = Camera::look_at(eye, eye + random.unit(), DVec3::new(0.1, 1.0, 0.2), lens).unwrap();
        let settings = RenderSettings {
            size: [21, 14],
            steps: Steps::new(64, 0.01, 20.0, at % 9),
            samples: 1 + at / 3 % 4,
            holes: [HoleFill::Behind, HoleFill::Nearest, HoleFill::Blank][at as usize % 3],
            background: [BackgroundFill::Opaque, BackgroundFill::Transparent][at as usize / 8 % 2],
            specular: SpecularMode::None,
            max_bounces: 4,
            acceleration: if at % 4 == 0 { Acceleration::None } else { Acceleration::Pyramid },
            refinements: refinements(at),
        };
        let plain = render_plainly(&views, &camera, &settings, &Silent).unwrap();
        let fast = render(&views, &camera, &settings, &Silent).unwrap();
        assert_eq!(fast.counters, plain.counters);
        if !has_alpha {
            assert_eq!(fast.image.alpha, plain.image.alpha);
        }
        let code = |light: f32| Transfer::Srgb.encode(f64::from(light)) * 255.0;
        let alphas = fast.image.alpha.data().iter().zip(plain.image.alpha.data());
        let colors = fast.image.color.data().iter().zip(plain.image.color.data());
        for ((a, b), (alpha, other)) in colors.zip(alphas) {
            let are_same =
                (alpha - other).abs() < 1e-4 && a.iter().zip(b).all(|(a, b)| (code(*a) - code(*b)).abs() < 0.01);
            assert!(are_same || has_alpha, "{a:?} {b:?}");
            differing += u32::from(!are_same);
        }
    }
    // If the depth of a texel is just within the tolerance of a surface, the last bit of a logarithm decides whether its alpha
    // counts.
    assert!(differing <= 10, "{differing} of {} pixels with alpha", 60 * 21 * 14);
}

/// An image from the position of a probe has the probe's alpha.
#[test]
fn alpha_of_a_picture_is_that_of_what_it_shows() {
    let pane = |direction: DVec3| {
        let at = direction / -direction.z;
        (direction.z < 0.0 && at.x.abs() < 0.5 && at.y.abs() < 0.5)
            .then(|| (direction.length() / -direction.z, [255, 0, 0]))
    };
    let mut view = SyntheticProbe::new(DVec3::ZERO, 32).cube(CODES, &pane);
    set_alpha(&mut view, |texels, at| if texels.inverse_depth[at] == BACKGROUND { 0 } else { 51 });
    let light_field = field(vec![view], CODES);
    let views = ActiveViews::new(&light_field, &[0], DVec3::ZERO);
    let camera = Camera::look_at(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, Lens::new(90.0)).unwrap();
    let settings = settings_of(Steps::new(64, 0.01, 20.0, 8), Acceleration::Pyramid, Refinements::ALL);
    for background in [BackgroundFill::Opaque, BackgroundFill::Transparent] {
        let settings = RenderSettings { size: [32; 2], holes: HoleFill::Behind, background, ..settings.clone() };
        let Rendered { image, counters } = render(&views, &camera, &settings, &Silent).unwrap();
        assert_eq!(counters.hole_rays, 0);
        // The background itself is transparent.
        assert!([[2, 2], [16, 3], [30, 16]].iter().all(|&[x, y]| image.alpha.get(x, y) == 0.0));
        let known = if background == BackgroundFill::Transparent { 0.2 } else { 1.0 };
        for [x, y] in [[10, 10], [16, 16], [21, 12]] {
            assert!(Vec3::from(image.color.get(x, y)).distance(Vec3::X) < 1e-6);
            assert!((image.alpha.get(x, y) - known).abs() < 1e-6, "{}", image.alpha.get(x, y));
        }
    }
}

/// Pixels without an edge take only the first five rays. The image differs from one with all rays by less than the contrast of an
/// edge.
#[test]
fn pixels_without_an_edge_take_fewer_rays() {
    const SAMPLES: u32 = 4;
    let light_field = furnished();
    let eye = DVec3::new(0.5, 0.1, -1.2);
    let views = ActiveViews::new(&light_field, &[0, 1], eye);
    let camera = Camera::look_at(eye, eye + DVec3::X, DVec3::Y, Lens::new(70.0)).unwrap();
    let picture = |side: u32, samples| {
        let steps = Steps::new(256, 0.01, 20.0, 8);
        let settings = settings_of(steps, Acceleration::Pyramid, Refinements::ALL);
        render(&views, &camera, &RenderSettings { size: [side; 2], samples, ..settings }, &Silent).unwrap()
    };
    let side = 160;
    let (fewer, all) = (picture(side, SAMPLES), picture(side * SAMPLES, 1));
    let rays = fewer.counters.primary_rays as f64 / f64::from(side * side);
    assert!((5.1..12.0).contains(&rays), "{rays} rays a pixel");
    let mut differing = 0;
    for (x, y) in (0..side * side).map(|at| (at % side, at / side)) {
        let grid = (0..SAMPLES * SAMPLES).map(|at| (SAMPLES * x + at % SAMPLES, SAMPLES * y + at / SAMPLES));
        let mean = grid.map(|(x, y)| Vec3::from(all.image.color.get(x, y))).sum::<Vec3>() / (SAMPLES * SAMPLES) as f32;
        let shown = Vec3::from(fewer.image.color.get(x, y));
        let most = EDGE_CONTRAST * (mean + shown + 2.0 * EDGE_BLACK);
        differing += u32::from((mean - shown).abs().cmpgt(most).any());
    }
    assert!(differing <= side * side / 200, "{differing} pixels differ");
}

/// Monitor that counts steps and checks, and interrupts after this number of checks.
struct Counting {
    rows: AtomicU64,
    asked: AtomicU64,
    stop_at: u64,
}

impl Monitor for Counting {
    fn advance(&self, steps: u64) {
        self.rows.fetch_add(steps, Ordering::Relaxed);
    }

    fn interrupted(&self) -> bool {
        self.asked.fetch_add(1, Ordering::Relaxed) + 1 >= self.stop_at
    }
}

#[test]
fn rows_are_told_and_a_picture_is_given_up_within_one() {
    let light_field = furnished();
    let eye = DVec3::new(0.5, 0.1, -1.2);
    let views = ActiveViews::new(&light_field, &[0, 1], eye);
    let camera = Camera::look_at(eye, eye + DVec3::X, DVec3::Y, Lens::new(70.0)).unwrap();
    let settings = |size| RenderSettings {
        size,
        steps: Steps::new(8, 0.01, 20.0, 0),
        samples: 1,
        holes: HoleFill::Blank,
        background: BackgroundFill::Opaque,
        specular: SpecularMode::None,
        max_bounces: 0,
        acceleration: Acceleration::Pyramid,
        refinements: Refinements::NONE,
    };
    let counting = |stop_at| Counting { rows: AtomicU64::new(0), asked: AtomicU64::new(0), stop_at };
    let all = counting(u64::MAX);
    render(&views, &camera, &settings([9, 17]), &all).unwrap();
    render_plainly(&views, &camera, &settings([9, 17]), &all).unwrap();
    splat(&views, &camera, &settings([9, 17]), &all).unwrap();
    assert_eq!(all.rows.into_inner(), 3 * 17);
    // The monitor is checked for each row, and more than once in a long row.
    let few = counting(5);
    assert!(matches!(render(&views, &camera, &settings([3, 4000]), &few), Err(Error::Interrupted)));
    assert!(few.rows.into_inner() <= 4);
    let one = counting(3);
    assert!(matches!(render(&views, &camera, &settings([8192, 1]), &one), Err(Error::Interrupted)));
    assert_eq!(one.asked.into_inner(), 3);
}

#[test]
fn pyramids_follow_what_changes() {
    let mut random = Random(4);
    for _ in 0..200 {
        let size = [1 + random.below(40), 1 + random.below(40)];
        let mut depths: Vec<f32> = (0..size[0] * size[1]).map(|_| random.next() as f32).collect();
        let mut followed = DepthPyramid::default();
        assert_eq!(followed.greatest(), UNKNOWN);
        followed.update(size, &depths, 0..0, 0..0);
        for _ in 0..5 {
            let from = size.map(|size| random.below(size));
            let to = [0, 1].map(|axis| from[axis] + 1 + random.below(size[axis] - from[axis]));
            for row in from[1]..to[1] {
                for column in from[0]..to[0] {
                    depths[(row * size[0] + column) as usize] = random.next() as f32;
                }
            }
            followed.update(size, &depths, from[0]..to[0], from[1]..to[1]);
            let mut anew = DepthPyramid::default();
            anew.update(size, &depths, 0..size[0], 0..size[1]);
            assert_eq!(followed, anew);
            assert_eq!(anew.greatest(), depths.iter().copied().fold(0.0, f32::max));
            let inside = (from[1]..to[1]).flat_map(|row| (from[0]..to[0]).map(move |column| [column, row]));
            let greatest = inside.map(|[column, row]| depths[(row * size[0] + column) as usize]).fold(0.0, f32::max);
            let map = TexelMap::cube_face(size);
            let texels = FaceTexels { inverse_depth: depths.clone(), ..FaceTexels::unknown(size, map, CODES) };
            assert!(anew.greatest_between(&texels, from, to.map(|end| end - 1)) >= greatest);
        }
    }
}

/// A ray along a face, in the plane of its surface: whether a point on it is occupied depends on rounding.
#[test]
fn rounding_is_allowed_for() {
    let mut random = Random(5);
    let mut mixed = 0;
    for _ in 0..400 {
        let turn = DQuat::from_axis_angle(random.unit(), 6.0 * random.next());
        let (forward, along) = (turn * DVec3::X, turn * DVec3::new(0.0, 0.6, 0.8));
        let depth_m = 1.0 + random.next();
        let made =
            SyntheticProbe { turn, ..SyntheticProbe::new(-depth_m * forward - 0.5 * along, 1 + random.below(4)) };
        let mut light_field = field(vec![made.cube(CODES, &|_| Some((depth_m, [0; 3])))], CODES);
        let steps = Steps::new(64, 0.01, 1.0, 0);
        let ray = Ray { origin: Vec3::ZERO, direction: along.as_vec3() };
        let view = ActiveViews::new(&light_field, &[0], DVec3::ZERO).views.swap_remove(0);
        let local = view.local(ray.at(steps.distances_m[random.below(65) as usize]));
        let surface = view.view.project(local).unwrap().inverse_depth;
        for texels in light_field.views[0].faces.iter_mut().flatten() {
            texels.inverse_depth.fill(surface);
        }
        let views = ActiveViews::new(&light_field, &[0], DVec3::ZERO);
        let mut counters = Counters::default();
        let hit = intersect(Acceleration::None, &views, &ray, &steps, &mut counters);
        assert_eq!(intersect(Acceleration::Pyramid, &views, &ray, &steps, &mut counters), hit);
        let settings = settings_of(steps.clone(), Acceleration::Pyramid, Refinements::NONE);
        assert_eq!(of_packets(&views, &[ray.direction], &settings).0[0].all_m, hit);
        mixed += u32::from(hit.is_some_and(|hit| hit > steps.distances_m[0]));
    }
    assert!(mixed > 40, "{mixed}");
}
