//! Pictures of a light field from any eye: Main of algorithm 4 (CALF 6).
//!
//! Enters: active views, a camera, settings. Leaves: a picture in linear light with alpha, and what it came to.

use glam::Vec3;
use rayon::prelude::*;

use crate::error::Result;
use crate::evaluate::rendered_image::{HoleFill, RenderedImage};
use crate::image::plane::Plane;
use crate::march::active_views::ActiveViews;
use crate::march::clip::ClipPlanes;
use crate::march::counters::Counters;
use crate::march::interpolate::camera_weights;
use crate::march::intersect::intersect;
use crate::march::packet::render::PacketScene;
use crate::march::ray::Ray;
use crate::march::settings::{EffectMode, RenderSettings};
use crate::march::shading::{Outcome, background, surface};
use crate::march::specular::secondary_rays::{Effects, Met};
use crate::march::specular::sphere_fit::GlassBalls;
use crate::math::Camera;
use crate::monitor::Monitor;

/// A picture.
#[derive(Debug, Clone, PartialEq)]
pub struct Rendered {
    /// Its pixels.
    pub image: RenderedImage,
    /// Counts over its rays.
    pub counters: Counters,
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
        EffectMode::Auto => views.views.iter().any(|view| view.view.is_specular()),
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
    let image = RenderedImage { color: Plane::new(width, height, color)?, alpha: Plane::new(width, height, alpha)? };
    Ok(Rendered { image, counters })
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
    let mut met = intersect(settings.acceleration, views, ray, &settings.steps, counters);
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
