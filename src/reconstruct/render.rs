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
use crate::reconstruct::counters::Counters;
use crate::reconstruct::effects::{Effects, Met};
use crate::reconstruct::interpolate::{Seen, background_color, camera_weights, surface_color};
use crate::reconstruct::light_field::ColorCoding;
use crate::reconstruct::march::{Ray, Steps, intersect};

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

/// Colour and alpha.
type Pixel = ([f32; 3], f32);

/// Renders.
///
/// # Errors
/// When the monitor says to stop.
pub fn render(
    views: &ActiveViews<'_>,
    camera: &Camera,
    settings: &RenderSettings,
    monitor: &dyn Monitor,
) -> Result<Rendered> {
    let [width, height] = settings.size;
    let weights = camera_weights(views);
    let sends_on = sends_on(views, settings.effects);
    let row = |y: u32| -> Result<(Vec<Pixel>, Counters)> {
        monitor.check()?;
        let mut counters = Counters::default();
        let pixels =
            (0..width).map(|x| pixel(views, &weights, (camera, settings, sends_on), [x, y], &mut counters)).collect();
        Ok((pixels, counters))
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

/// Whether rays are sent on in a picture of these views.
pub fn sends_on(views: &ActiveViews<'_>, effects: EffectMode) -> bool {
    match effects {
        EffectMode::None => false,
        EffectMode::Force => views.views.iter().any(|view| view.view.has_material()),
        EffectMode::Auto => views.views.iter().any(|view| view.view.calls_for_effects()),
    }
}

fn pixel(
    views: &ActiveViews<'_>,
    weights: &[f32],
    (camera, settings, sends_on): (&Camera, &RenderSettings, bool),
    [x, y]: [u32; 2],
    counters: &mut Counters,
) -> Pixel {
    let samples = settings.samples.max(1);
    let (mut color, mut colored, mut seen) = (Vec3::ZERO, 0u32, 0u32);
    for at in 0..samples * samples {
        let place = |pixel: u32, sample: u32, size: u32| {
            (f64::from(pixel) + (f64::from(sample) + 0.5) / f64::from(samples)) / f64::from(size)
        };
        let window = [place(x, at % samples, settings.size[0]), place(y, at / samples, settings.size[1])];
        let ray = Ray { origin: Vec3::ZERO, direction: camera.direction(window).as_vec3() };
        counters.primary_rays += 1;
        let light = match outcome(views, weights, &ray, (settings, sends_on), counters) {
            Outcome::Seen(light) => {
                seen += 1;
                Some(light)
            }
            Outcome::Hole(nearest) => {
                counters.hole_rays += 1;
                nearest.filter(|_| settings.holes == HoleFill::Nearest)
            }
        };
        if let Some(light) = light {
            color += light;
            colored += 1;
        }
    }
    ((color / colored.max(1) as f32).to_array(), seen as f32 / (samples * samples) as f32)
}

fn outcome(
    views: &ActiveViews<'_>,
    weights: &[f32],
    ray: &Ray,
    (settings, sends_on): (&RenderSettings, bool),
    counters: &mut Counters,
) -> Outcome {
    let Some(distance_m) = intersect(views, ray, &settings.steps, counters) else {
        counters.background_rays += 1;
        return background_light(views, weights, ray.direction);
    };
    let point = ray.at(distance_m);
    match surface_light(views, weights, point, &settings.steps) {
        Outcome::Seen(light) if sends_on => {
            let met = Met { point, direction: ray.direction, light };
            Outcome::Seen(Effects::new(views, weights, settings).light(&met, counters))
        }
        outcome => outcome,
    }
}

/// What views saw of a surface in a point, `point` in metres from the eye and found with these steps.
pub fn surface_light(views: &ActiveViews<'_>, weights: &[f32], point: Vec3, steps: &Steps) -> Outcome {
    let unsure = if steps.refine == 0 { steps.log_step() } else { 0.0 };
    match surface_color(views, weights, point) {
        Some(seen) if seen.difference <= HOLE_DIFFERENCE + unsure => Outcome::Seen(light(views.coding, &seen)),
        seen => Outcome::Hole(seen.map(|seen| light(views.coding, &seen))),
    }
}

/// What views saw of the background in a direction of length 1.
pub fn background_light(views: &ActiveViews<'_>, weights: &[f32], direction: Vec3) -> Outcome {
    background_color(views, weights, direction)
        .map_or(Outcome::Hole(None), |seen| Outcome::Seen(light(views.coding, &seen)))
}

/// Linear light of what views saw.
fn light(coding: ColorCoding, seen: &Seen) -> Vec3 {
    match coding {
        ColorCoding::Light => seen.color,
        ColorCoding::Codes(tone) => seen.color.to_array().map(|code| decode(tone, code)).into(),
    }
}

fn decode(tone: ToneMap, code: f32) -> f32 {
    (tone.transfer.decode(code.into()) * (-f64::from(tone.exposure_ev)).exp2()) as f32
}
