//! Pictures of a light field from any eye: Main of algorithm 4 (CALF 6).
//!
//! Enters: active views, a camera, settings. Leaves: a picture in linear light with alpha, and what it came to.

use glam::Vec3;
use rayon::prelude::*;

use crate::error::Result;
use crate::image::plane::Plane;
use crate::image::transfer::ToneMap;
use crate::march::active_views::ActiveViews;
use crate::march::clip::ClipPlanes;
use crate::march::counters::Counters;
use crate::march::interpolate::{Seen, background_color, camera_weights, surface_color};
use crate::march::intersect::{self, Ray, Steps};
use crate::march::packet::render::PacketScene;
use crate::march::segments;
use crate::march::specular::secondary_rays::{Effects, Met};
use crate::march::specular::sphere_fit::GlassBalls;
use crate::math::Camera;
use crate::monitor::Monitor;
use crate::views::light_field::ColorCoding;

/// A hit is a hole where every texel differs from it by more than this in the logarithm of the distance, beyond what the
/// steps leave open: nobody saw a surface there.
pub const HOLE_DIFFERENCE: f32 = 0.1;

/// What is shown where no view saw anything.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum HoleFill {
    /// Nothing: colour 0.
    #[default]
    Blank,
    /// The colour of what comes nearest. Alpha is 0 all the same.
    Nearest,
}

/// Whether rays are sent on by mirrors and glass (CALF 6.1).
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum EffectMode {
    /// Where the light field has materials with weights above 0; else no code for it is in the way.
    #[default]
    Auto,
    /// Never: views are interpolated everywhere.
    None,
    /// Also where no weight of the materials is above 0, for tests: the pictures are the same.
    Force,
}

/// How points of a ray are passed over.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Acceleration {
    /// Every point is looked at.
    None,
    /// Segments that a view proves to be empty are passed over; the hits are the same.
    #[default]
    Pyramid,
}

impl Acceleration {
    /// The distance in metres at which a ray meets a surface, if it does; the same either way.
    pub fn intersect(self, views: &ActiveViews<'_>, ray: &Ray, steps: &Steps, counters: &mut Counters) -> Option<f32> {
        self.intersect_from(views, ray, (steps, 0), counters)
    }

    /// The same from the `first` of the distances on: what is nearer is taken to be open.
    pub fn intersect_from(
        self,
        views: &ActiveViews<'_>,
        ray: &Ray,
        (steps, first): (&Steps, usize),
        counters: &mut Counters,
    ) -> Option<f32> {
        match self {
            Acceleration::None => intersect::intersect_from(views, ray, steps, first, counters),
            Acceleration::Pyramid => segments::intersect_from(views, ray, steps, first, counters),
        }
    }
}

/// How a picture is made.
#[derive(Debug, Clone, PartialEq)]
pub struct RenderSettings {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Where rays are looked at.
    pub steps: Steps,
    /// Rays in each row and column of a pixel, at least 1.
    pub samples: u32,
    /// What is shown in holes.
    pub holes: HoleFill,
    /// Whether mirrors and glass send rays on.
    pub effects: EffectMode,
    /// How often at most a ray is sent on.
    pub max_bounces: u32,
    /// How rays are marched.
    pub acceleration: Acceleration,
}

/// A picture.
#[derive(Debug, Clone, PartialEq)]
pub struct Rendered {
    /// Linear light; the mean of those rays of a pixel that have a colour.
    pub color: Plane<[f32; 3]>,
    /// The part of a pixel's rays that end in something that a view saw: 1, and 0 in holes.
    pub alpha: Plane<f32>,
    /// What it came to.
    pub counters: Counters,
}

/// What a ray from the eye has brought.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Outcome {
    /// A colour in linear light, of a surface or of the background.
    Seen(Vec3),
    /// A hole; the colour of what comes nearest, where there is anything.
    Hole(Option<Vec3>),
}

impl Outcome {
    /// What views saw of a surface: a hole where nothing fits; `unsure` is how far steps leave open where it is.
    pub(crate) fn of_surface(seen: Option<Seen>, unsure: f32, light: impl Fn(&Seen) -> Vec3) -> Outcome {
        match seen {
            Some(seen) if seen.difference <= HOLE_DIFFERENCE + unsure => Outcome::Seen(light(&seen)),
            seen => Outcome::Hole(seen.map(|seen| light(&seen))),
        }
    }
}

/// Rays that are followed before the monitor is asked again whether to stop, and all of a row that is held at once: a
/// multiple of four, so that packets stay whole.
pub(crate) const RAYS_AT_ONCE: usize = 1024;

/// Renders. The monitor advances by one for each row.
///
/// # Errors
/// When the monitor says to stop.
pub fn render(
    views: &ActiveViews<'_>,
    camera: &Camera,
    settings: &RenderSettings,
    monitor: &dyn Monitor,
) -> Result<Rendered> {
    let weights = camera_weights(views);
    let scene = PacketScene::new(views, &weights, ClipPlanes::of(camera));
    let glass = glass(views, &weights, (camera, settings), monitor)?;
    render_rows((camera, settings), monitor, |directions, counters| {
        let mut row = scene.row(settings);
        let mut effects = glass.as_ref().map(|glass| Effects::new(views, &weights, settings, glass));
        let mut all = Vec::with_capacity(directions.len());
        for four in directions.chunks(4) {
            let outcomes = row.outcomes(four, counters);
            all.extend(four.iter().zip(outcomes).map(|(&direction, (distance_m, outcome))| {
                let ray = Ray { origin: Vec3::ZERO, direction };
                sent_on(&mut effects, &ray, distance_m, outcome, counters)
            }));
        }
        all
    })
}

/// Renders with every ray by itself, in the plainest form: what [`render`] is measured against.
///
/// # Errors
/// When the monitor says to stop.
pub fn render_plainly(
    views: &ActiveViews<'_>,
    camera: &Camera,
    settings: &RenderSettings,
    monitor: &dyn Monitor,
) -> Result<Rendered> {
    let weights = camera_weights(views);
    let glass = glass(views, &weights, (camera, settings), monitor)?;
    let clip = ClipPlanes::of(camera);
    render_rows((camera, settings), monitor, |directions, counters| {
        let mut effects = glass.as_ref().map(|glass| Effects::new(views, &weights, settings, glass));
        let of_one = |&direction: &Vec3| {
            let ray = Ray { origin: Vec3::ZERO, direction };
            let (distance_m, outcome) = outcome((views, &weights), clip.as_ref(), &ray, settings, counters);
            sent_on(&mut effects, &ray, distance_m, outcome, counters)
        };
        directions.iter().map(of_one).collect()
    })
}

/// Whether rays are sent on in a picture of these views.
pub fn sends_on(views: &ActiveViews<'_>, effects: EffectMode) -> bool {
    match effects {
        EffectMode::None => false,
        EffectMode::Force => views.views.iter().any(|view| view.view.has_material()),
        EffectMode::Auto => views.views.iter().any(|view| view.view.calls_for_effects()),
    }
}

/// The balls of glass of a picture; None where no rays are sent on.
fn glass(
    views: &ActiveViews<'_>,
    weights: &[f32],
    (camera, settings): (&Camera, &RenderSettings),
    monitor: &dyn Monitor,
) -> Result<Option<GlassBalls>> {
    sends_on(views, settings.effects).then(|| GlassBalls::shown(views, weights, camera, monitor)).transpose()
}

/// What a ray from the eye brings when mirrors and glass have sent it on, where they do.
fn sent_on(
    effects: &mut Option<Effects<'_>>,
    ray: &Ray,
    distance_m: Option<f32>,
    outcome: Outcome,
    counters: &mut Counters,
) -> Outcome {
    match (effects, distance_m, outcome) {
        (Some(effects), Some(distance_m), Outcome::Seen(light)) => {
            let met = Met { point: ray.at(distance_m), direction: ray.direction, light };
            Outcome::Seen(effects.light(&met, counters))
        }
        _ => outcome,
    }
}

/// Renders with what brings the outcomes of rays of a row that follow each other, by their directions.
fn render_rows(
    (camera, settings): (&Camera, &RenderSettings),
    monitor: &dyn Monitor,
    outcomes: impl Fn(&[Vec3], &mut Counters) -> Vec<Outcome> + Sync,
) -> Result<Rendered> {
    let [width, height] = settings.size;
    let samples = settings.samples.max(1) as usize;
    let (rays_of_pixel, rays_of_row) = (samples * samples, samples * samples * width as usize);
    let pixels = width as usize * height as usize;
    let (mut color, mut alpha) = (vec![[0.0; 3]; pixels], vec![0.0; pixels]);
    let row = |(y, (color, alpha)): (usize, (&mut [[f32; 3]], &mut [f32]))| -> Result<Counters> {
        let mut counters = Counters { primary_rays: rays_of_row as u64, ..Counters::default() };
        let (mut pixels, mut brought) = (color.iter_mut().zip(alpha), Brought::default());
        for first in (0..rays_of_row).step_by(RAYS_AT_ONCE) {
            monitor.check()?;
            let some = first..rays_of_row.min(first + RAYS_AT_ONCE);
            let directions: Vec<Vec3> = some.map(|ray| direction(camera, settings, [ray, y])).collect();
            for outcome in outcomes(&directions, &mut counters) {
                brought.add(outcome, settings.holes);
                if brought.rays as usize == rays_of_pixel
                    && let Some((color, alpha)) = pixels.next()
                {
                    counters.hole_rays += u64::from(brought.rays - brought.seen);
                    (*color, *alpha) = std::mem::take(&mut brought).color_and_alpha();
                }
            }
        }
        monitor.advance(1);
        Ok(counters)
    };
    let in_row = (width as usize).max(1);
    let rows = color.par_chunks_mut(in_row).zip(alpha.par_chunks_mut(in_row)).enumerate();
    let counters = rows.map(row).try_reduce(Counters::default, |sum, of_row| Ok(sum.plus(of_row)))?;
    Ok(Rendered { color: Plane::new(width, height, color)?, alpha: Plane::new(width, height, alpha)?, counters })
}

/// Direction of a ray by its number in a row of pixels: pixel by pixel, and in a pixel row by row.
fn direction(camera: &Camera, settings: &RenderSettings, [ray, y]: [usize; 2]) -> Vec3 {
    let samples = settings.samples.max(1) as usize;
    let (x, at) = (ray / (samples * samples), ray % (samples * samples));
    let place = |pixel: usize, sample: usize, size: u32| {
        (pixel as f64 + (sample as f64 + 0.5) / samples as f64) / f64::from(size)
    };
    let window = [place(x, at % samples, settings.size[0]), place(y, at / samples, settings.size[1])];
    camera.direction(window).as_vec3()
}

/// What rays of a pixel have brought.
#[derive(Debug, Clone, Copy, Default)]
struct Brought {
    /// Sum of the light of those that have a colour.
    color: Vec3,
    colored: u32,
    /// Rays that end in something that a view saw.
    seen: u32,
    rays: u32,
}

impl Brought {
    fn add(&mut self, outcome: Outcome, holes: HoleFill) {
        self.rays += 1;
        let light = match outcome {
            Outcome::Seen(light) => {
                self.seen += 1;
                Some(light)
            }
            Outcome::Hole(nearest) => nearest.filter(|_| holes == HoleFill::Nearest),
        };
        if let Some(light) = light {
            self.color += light;
            self.colored += 1;
        }
    }

    fn color_and_alpha(self) -> ([f32; 3], f32) {
        ((self.color / self.colored.max(1) as f32).to_array(), self.seen as f32 / self.rays as f32)
    }
}

fn outcome(
    (views, weights): (&ActiveViews<'_>, &[f32]),
    clip: Option<&ClipPlanes>,
    ray: &Ray,
    settings: &RenderSettings,
    counters: &mut Counters,
) -> (Option<f32>, Outcome) {
    let mut met = settings.acceleration.intersect(views, ray, &settings.steps, counters);
    if let Some(clip) = clip {
        met = met.and_then(|met_m| clip.shown((views, ray), met_m, settings, counters));
    }
    let outcome = match met {
        Some(distance_m) => surface(views, weights, ray.at(distance_m), settings.steps.unsure()),
        None => {
            counters.background_rays += 1;
            background(views, weights, ray.direction)
        }
    };
    (met, outcome)
}

/// What a ray brings that ends in a surface at a point; `unsure` is how far, in the logarithm of the distance, the steps
/// leave open where.
pub fn surface(views: &ActiveViews<'_>, weights: &[f32], point: Vec3, unsure: f32) -> Outcome {
    Outcome::of_surface(surface_color(views, weights, point), unsure, |seen| light(views.coding, seen))
}

/// What a ray brings that meets no surface and goes in this direction, of length 1.
pub fn background(views: &ActiveViews<'_>, weights: &[f32], direction: Vec3) -> Outcome {
    background_color(views, weights, direction)
        .map_or(Outcome::Hole(None), |seen| Outcome::Seen(light(views.coding, &seen)))
}

/// Linear light of what views saw.
fn light(coding: ColorCoding, seen: &Seen) -> Vec3 {
    light_of(coding, seen.color)
}

/// Linear light of a colour as it is coded.
pub fn light_of(coding: ColorCoding, color: Vec3) -> Vec3 {
    match coding {
        ColorCoding::Light => color,
        ColorCoding::Codes(tone) => color.to_array().map(|code| decode(tone, code)).into(),
    }
}

fn decode(tone: ToneMap, code: f32) -> f32 {
    (tone.transfer.decode(code.into()) * (-f64::from(tone.exposure_ev)).exp2()) as f32
}
