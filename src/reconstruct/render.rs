//! Pictures of a light field from any eye: Main of algorithm 4 (CALF 6).
//!
//! Enters: active views, a camera, settings. Leaves: a picture in linear light with alpha, and what it came to.

use glam::Vec3;
use rayon::prelude::*;

use crate::error::Result;
use crate::image::plane::Plane;
use crate::image::transfer::ToneMap;
use crate::math::Camera;
use crate::monitor::Monitor;
use crate::reconstruct::active_views::ActiveViews;
use crate::reconstruct::clip::ClipPlanes;
use crate::reconstruct::counters::Counters;
use crate::reconstruct::effects::{Effects, Met};
use crate::reconstruct::glass_balls::GlassBalls;
use crate::reconstruct::interpolate::{Seen, background_color, camera_weights, surface_color};
use crate::reconstruct::light_field::ColorCoding;
use crate::reconstruct::march::{self, Ray, Steps};
use crate::reconstruct::packet_render::PacketScene;
use crate::reconstruct::pyramid;

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
            Acceleration::None => march::intersect_from(views, ray, steps, first, counters),
            Acceleration::Pyramid => pyramid::intersect_from(views, ray, steps, first, counters),
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

/// Colour and alpha.
type Pixel = ([f32; 3], f32);

/// Rays after which the monitor is asked whether to stop, also within a row: a multiple of four, so that packets stay whole.
const RAYS_AT_ONCE: usize = 1024;

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

/// Renders with what brings the outcomes of the rays of a row, by their directions.
fn render_rows(
    (camera, settings): (&Camera, &RenderSettings),
    monitor: &dyn Monitor,
    outcomes: impl Fn(&[Vec3], &mut Counters) -> Vec<Outcome> + Sync,
) -> Result<Rendered> {
    let [width, height] = settings.size;
    let samples = settings.samples.max(1) as usize;
    let row = |y: u32| -> Result<(Vec<Pixel>, Counters)> {
        let mut counters = Counters::default();
        let directions = directions(camera, settings, y);
        counters.primary_rays += directions.len() as u64;
        let mut brought = Vec::with_capacity(directions.len());
        for some in directions.chunks(RAYS_AT_ONCE) {
            monitor.check()?;
            brought.extend(outcomes(some, &mut counters));
        }
        monitor.advance(1);
        let pixels = brought.chunks(samples * samples).map(|of_pixel| pixel(of_pixel, settings.holes, &mut counters));
        Ok((pixels.collect(), counters))
    };
    let rows: Vec<_> = (0..height).into_par_iter().map(row).collect::<Result<_>>()?;
    let counters = rows.iter().fold(Counters::default(), |sum, (_, counters)| sum.plus(*counters));
    let pixels = || rows.iter().flat_map(|(row, _)| row);
    Ok(Rendered {
        color: Plane::new(width, height, pixels().map(|pixel| pixel.0).collect())?,
        alpha: Plane::new(width, height, pixels().map(|pixel| pixel.1).collect())?,
        counters,
    })
}

/// Directions of the rays of a row, pixel by pixel, and in a pixel row by row.
fn directions(camera: &Camera, settings: &RenderSettings, y: u32) -> Vec<Vec3> {
    let samples = settings.samples.max(1);
    let place = |pixel: u32, sample: u32, size: u32| {
        (f64::from(pixel) + (f64::from(sample) + 0.5) / f64::from(samples)) / f64::from(size)
    };
    let direction = |x: u32, at: u32| {
        let window = [place(x, at % samples, settings.size[0]), place(y, at / samples, settings.size[1])];
        camera.direction(window).as_vec3()
    };
    (0..settings.size[0]).flat_map(|x| (0..samples * samples).map(move |at| direction(x, at))).collect()
}

/// A pixel of what its rays brought.
fn pixel(outcomes: &[Outcome], holes: HoleFill, counters: &mut Counters) -> Pixel {
    let (mut color, mut colored, mut seen) = (Vec3::ZERO, 0u32, 0u32);
    for outcome in outcomes {
        let light = match *outcome {
            Outcome::Seen(light) => {
                seen += 1;
                Some(light)
            }
            Outcome::Hole(nearest) => {
                counters.hole_rays += 1;
                nearest.filter(|_| holes == HoleFill::Nearest)
            }
        };
        if let Some(light) = light {
            color += light;
            colored += 1;
        }
    }
    ((color / colored.max(1) as f32).to_array(), seen as f32 / outcomes.len() as f32)
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
