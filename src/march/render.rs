//! Rendering a light field from any eye: Main of algorithm 4 (CALF 6).
//!
//! Enters: active views, a camera, settings. Leaves: a picture in linear light with alpha, and counters.

use glam::Vec3;
use rayon::prelude::*;

use crate::error::Result;
use crate::evaluate::{HoleFill, RenderedImage};
use crate::image::Plane;
use crate::march::packet::render::PacketScene;
use crate::march::specular::secondary_rays::{SecondaryRays, SurfaceHit};
use crate::march::{
    ActiveViews, ClipPlanes, Counters, Layer, Primary, PrimaryHit, Proxies, Ray, RenderSettings, SpecularMode,
    SphereFit, proxies_in_sight,
};
use crate::math::Camera;
use crate::monitor::Monitor;

#[derive(Debug, Clone, PartialEq)]
pub struct Rendered {
    pub image: RenderedImage,
    pub counters: Counters,
}

/// Rays of a row in flight at once, and between two checks of the monitor; packets stay whole with a multiple of four.
pub(crate) const RAYS_AT_ONCE: usize = 1024;

/// Renders. The monitor advances by one for each row.
pub fn render(
    views: &ActiveViews<'_>,
    camera: &Camera,
    settings: &RenderSettings,
    monitor: &dyn Monitor,
) -> Result<Rendered> {
    let primary = Primary::new(views, ClipPlanes::of(camera), settings);
    let scene = PacketScene::new(&primary);
    let picture = Picture::new(views, camera, settings, monitor)?;
    picture.rows(|directions, counters| {
        let mut row = scene.row();
        let hits = directions.chunks(4).flat_map(|four| row.hits(four, counters).into_iter().take(four.len()));
        hits.collect()
    })
}

/// Distance in metres along the ray through the middle of each pixel, `+inf` where it meets nothing. The monitor is checked.
pub fn distances_m(
    views: &ActiveViews<'_>,
    camera: &Camera,
    settings: &RenderSettings,
    monitor: &dyn Monitor,
) -> Result<Plane<f32>> {
    first_rays(views, camera, settings, monitor, |_, hit| hit.distance_m().unwrap_or(f32::INFINITY))
}

/// What the rays through the middles of pixels hit, by their directions. The monitor is checked.
pub(crate) fn first_rays<T: Copy + Send>(
    views: &ActiveViews<'_>,
    camera: &Camera,
    settings: &RenderSettings,
    monitor: &dyn Monitor,
    value: impl Fn(Vec3, &PrimaryHit) -> T + Sync,
) -> Result<Plane<T>> {
    let settings = RenderSettings { samples: 1, specular: SpecularMode::None, ..settings.clone() };
    let primary = Primary::new(views, ClipPlanes::of(camera), &settings);
    let scene = PacketScene::new(&primary);
    let picture = Picture::new(views, camera, &settings, monitor)?;
    let [width, height] = settings.size;
    let row = |y: usize| -> Result<Vec<T>> {
        monitor.check()?;
        let directions: Vec<Vec3> = (0..width as usize).map(|x| picture.direction([x, y])).collect();
        let (mut row, mut counters) = (scene.row(), Counters::default());
        let hits = directions.chunks(4).flat_map(|four| row.hits(four, &mut counters).into_iter().take(four.len()));
        Ok(hits.zip(&directions).map(|(hit, &direction)| value(direction, &hit)).collect())
    };
    let rows: Vec<Vec<T>> = (0..height as usize).into_par_iter().map(row).collect::<Result<_>>()?;
    Plane::new(width, height, rows.concat())
}

/// Renders ray by ray, in the plainest form: the reference for [`render`].
pub fn render_plainly(
    views: &ActiveViews<'_>,
    camera: &Camera,
    settings: &RenderSettings,
    monitor: &dyn Monitor,
) -> Result<Rendered> {
    let primary = Primary::new(views, ClipPlanes::of(camera), settings);
    let picture = Picture::new(views, camera, settings, monitor)?;
    picture.rows(|directions, counters| {
        let rays = directions.iter().map(|&direction| Ray { origin: Vec3::ZERO, direction });
        rays.map(|ray| {
            let hits = primary.first_hits(&ray, counters);
            primary.follow(&ray, &hits, counters)
        })
        .collect()
    })
}

pub fn has_secondary_rays(views: &ActiveViews<'_>, specular: SpecularMode) -> bool {
    match specular {
        SpecularMode::None => false,
        SpecularMode::Force => views.views.iter().any(|view| view.view.has_material()),
        SpecularMode::Auto => views.views.iter().any(|view| view.view.is_specular()),
    }
}

struct Picture<'a> {
    views: &'a ActiveViews<'a>,
    camera: &'a Camera,
    settings: &'a RenderSettings,
    monitor: &'a dyn Monitor,
    /// None without secondary rays.
    proxies: Option<Proxies>,
}

impl<'a> Picture<'a> {
    fn new(
        views: &'a ActiveViews<'a>,
        camera: &'a Camera,
        settings: &'a RenderSettings,
        monitor: &'a dyn Monitor,
    ) -> Result<Picture<'a>> {
        let specular = has_secondary_rays(views, settings.specular);
        let proxies = specular.then(|| proxies_in_sight(&SphereFit, views, camera, monitor)).transpose()?;
        Ok(Picture { views, camera, settings, monitor, proxies })
    }

    /// Renders rows in parallel, with the primary hits of adjacent rays by their directions.
    fn rows(&self, hits: impl Fn(&[Vec3], &mut Counters) -> Vec<PrimaryHit> + Sync) -> Result<Rendered> {
        let [width, height] = self.settings.size;
        let samples = self.settings.samples.max(1) as usize;
        let (rays_of_pixel, rays_of_row) = (samples * samples, samples * samples * width as usize);
        let pixels = width as usize * height as usize;
        let (mut color, mut alpha) = (vec![[0.0; 3]; pixels], vec![0.0; pixels]);
        let row = |(y, (color, alpha)): (usize, (&mut [[f32; 3]], &mut [f32]))| -> Result<Counters> {
            let mut counters = Counters { primary_rays: rays_of_row as u64, ..Counters::default() };
            let (mut pixels, mut sum) = (color.iter_mut().zip(alpha), PixelSum::default());
            let new = |proxies| SecondaryRays::new(self.views, self.settings, proxies);
            let mut secondary = self.proxies.as_ref().map(new);
            for first in (0..rays_of_row).step_by(RAYS_AT_ONCE) {
                self.monitor.check()?;
                let chunk = first..rays_of_row.min(first + RAYS_AT_ONCE);
                let directions: Vec<Vec3> = chunk.map(|ray| self.direction([ray, y])).collect();
                for (hit, &direction) in hits(&directions, &mut counters).into_iter().zip(&directions) {
                    let light = shade(&mut secondary, &hit, direction, &mut counters);
                    sum.add(light, hit.is_hole, self.settings.holes);
                    if sum.rays as usize == rays_of_pixel
                        && let Some((color, alpha)) = pixels.next()
                    {
                        counters.hole_rays += u64::from(sum.holes);
                        (*color, *alpha) = std::mem::take(&mut sum).color_and_alpha();
                    }
                }
            }
            self.monitor.advance(1);
            Ok(counters)
        };
        let in_row = (width as usize).max(1);
        let rows = color.par_chunks_mut(in_row).zip(alpha.par_chunks_mut(in_row)).enumerate();
        let counters = rows.map(row).try_reduce(Counters::default, |sum, of_row| Ok(sum + of_row))?;
        let image = RenderedImage::new(Plane::new(width, height, color)?, Plane::new(width, height, alpha)?);
        Ok(Rendered { image, counters })
    }

    /// Direction of a ray by its number in a row of pixels: pixel by pixel, in a pixel row by row.
    fn direction(&self, [ray, y]: [usize; 2]) -> Vec3 {
        let samples = self.settings.samples.max(1) as usize;
        let (x, at) = (ray / (samples * samples), ray % (samples * samples));
        let place = |pixel: usize, sample: usize, size: u32| {
            (pixel as f64 + (sample as f64 + 0.5) / samples as f64) / f64::from(size)
        };
        let size = self.settings.size;
        let window = [place(x, at % samples, size[0]), place(y, at / samples, size[1])];
        self.camera.direction(window).as_vec3()
    }
}

/// The light of a ray, with that of secondary rays where it hits surfaces; none where it ends in nothing.
fn shade(
    secondary: &mut Option<SecondaryRays<'_>>,
    hit: &PrimaryHit,
    direction: Vec3,
    counters: &mut Counters,
) -> Option<Vec3> {
    let mut light_of = |layer: &Layer| match (secondary.as_mut(), layer.distance_m) {
        (Some(secondary), Some(distance_m)) => {
            let point = Ray { origin: Vec3::ZERO, direction }.at(distance_m);
            layer.share * secondary.light(&SurfaceHit { point, direction, light: layer.light }, counters)
        }
        _ => layer.share * layer.light,
    };
    hit.first?;
    Some(hit.layers().map(&mut light_of).sum())
}

#[derive(Debug, Clone, Copy, Default)]
struct PixelSum {
    color: Vec3,
    /// Rays in `color`.
    colored: u32,
    /// Rays that count in alpha.
    opaque: u32,
    /// Rays that first meet what no view saw, or end in nothing.
    holes: u32,
    rays: u32,
}

impl PixelSum {
    fn add(&mut self, light: Option<Vec3>, is_hole: bool, fill: HoleFill) {
        self.rays += 1;
        self.holes += u32::from(is_hole);
        if let Some(light) = light.filter(|_| !is_hole || fill != HoleFill::Blank) {
            self.color += light;
            self.colored += 1;
            self.opaque += u32::from(!is_hole || fill == HoleFill::Behind);
        }
    }

    fn color_and_alpha(self) -> ([f32; 3], f32) {
        ((self.color / self.colored.max(1) as f32).to_array(), self.opaque as f32 / self.rays as f32)
    }
}
