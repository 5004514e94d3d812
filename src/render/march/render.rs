//! Renders a light field from any eye: Main of algorithm 4 (CALF 6).
//!
//! Takes active views, a camera and settings. Returns an image in linear RGB with alpha, and counters.

use glam::Vec3;
use rayon::prelude::*;

use crate::march::packet::render::PacketScene;
use crate::march::samples::{PixelSum, RaySample, SampleGrid};
use crate::march::specular::secondary_rays::{SecondaryRays, SurfaceHit};
use crate::march::{
    ActiveViews, ClipPlanes, Counters, Layer, Primary, PrimaryHit, Proxies, Ray, RenderSettings, SpecularMode,
    SphereFit, proxies_in_sight,
};
use crate::rendered_image::RenderedImage;
use codec::error::Result;
use codec::image::Plane;
use codec::math::Camera;
use codec::monitor::Monitor;

#[derive(Debug, Clone, PartialEq)]
pub struct Rendered {
    pub image: RenderedImage,
    pub counters: Counters,
}

/// Maximum number of rays of a row in flight, and between two checks of the monitor; more than the first rays of a pixel.
pub(crate) const RAYS_AT_ONCE: usize = 1024;

/// Renders an image. The monitor advances by one per row.
pub fn render(
    views: &ActiveViews<'_>,
    camera: &Camera,
    settings: &RenderSettings,
    monitor: &dyn Monitor,
) -> Result<Rendered> {
    let picture = Picture::new(views, camera, settings, monitor)?;
    let scene = PacketScene::new(&picture.primary);
    picture.rows(|directions, counters| scene.hits(directions, counters))
}

/// Returns the distance in metres along the ray through the middle of each pixel; `+inf` if the ray hits nothing. Checks the
/// monitor for interruption.
pub fn distances_m(
    views: &ActiveViews<'_>,
    camera: &Camera,
    settings: &RenderSettings,
    monitor: &dyn Monitor,
) -> Result<Plane<f32>> {
    first_rays(views, camera, settings, monitor, |_, hit| hit.distance_m().unwrap_or(f32::INFINITY))
}

/// Returns `value` of the direction and the hit of the ray through the middle of each pixel. Checks the monitor for interruption.
pub(crate) fn first_rays<T: Copy + Send>(
    views: &ActiveViews<'_>,
    camera: &Camera,
    settings: &RenderSettings,
    monitor: &dyn Monitor,
    value: impl Fn(Vec3, &PrimaryHit) -> T + Sync,
) -> Result<Plane<T>> {
    let settings = RenderSettings { samples: 1, specular: SpecularMode::None, ..settings.clone() };
    let picture = Picture::new(views, camera, &settings, monitor)?;
    let scene = PacketScene::new(&picture.primary);
    let [width, height] = settings.size;
    let row = |y: usize| -> Result<Vec<T>> {
        monitor.check()?;
        let directions: Vec<Vec3> = (0..width as usize).map(|x| picture.direction([x, y], 0)).collect();
        let hits = scene.hits(&directions, &mut Counters::default());
        Ok(directions.iter().zip(&hits).map(|(&direction, hit)| value(direction, hit)).collect())
    };
    let rows: Vec<Vec<T>> = (0..height as usize).into_par_iter().map(row).collect::<Result<_>>()?;
    Plane::new(width, height, rows.concat())
}

/// Renders ray by ray: the scalar reference for [`render`].
pub fn render_plainly(
    views: &ActiveViews<'_>,
    camera: &Camera,
    settings: &RenderSettings,
    monitor: &dyn Monitor,
) -> Result<Rendered> {
    let picture = Picture::new(views, camera, settings, monitor)?;
    picture.rows(|directions, counters| {
        let rays = directions.iter().map(|&direction| Ray { origin: Vec3::ZERO, direction });
        rays.map(|ray| picture.primary.hit(&ray, counters)).collect()
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
    primary: Primary<'a>,
    grid: SampleGrid,
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
        let primary = Primary::new(views, ClipPlanes::of(camera), settings);
        let grid = SampleGrid::new(settings.samples.max(1) as usize);
        Ok(Picture { views, camera, settings, monitor, primary, grid, proxies })
    }

    /// Renders rows in parallel. `hits` returns the primary hits of adjacent rays, given their directions.
    fn rows(&self, hits: impl Fn(&[Vec3], &mut Counters) -> Vec<PrimaryHit> + Sync) -> Result<Rendered> {
        let [width, height] = self.settings.size;
        let pixels = width as usize * height as usize;
        let (mut color, mut alpha) = (vec![[0.0; 3]; pixels], vec![0.0; pixels]);
        let row = |(y, (color, alpha)): (usize, (&mut [[f32; 3]], &mut [f32]))| -> Result<Counters> {
            let mut row =
                Row { picture: self, hits: &hits, y, secondary: self.secondary(), counters: Counters::default() };
            let mut pixels = color.iter_mut().zip(alpha);
            let at_once = RAYS_AT_ONCE / self.grid.first.len();
            for first in (0..width as usize).step_by(at_once) {
                let mut sums = vec![PixelSum::default(); at_once.min(width as usize - first)];
                row.add_rays((first, &mut sums), &self.grid.first, |_| true)?;
                row.add_rays((first, &mut sums), &self.grid.rest, PixelSum::has_edge)?;
                for (sum, (color, alpha)) in sums.iter().zip(&mut pixels) {
                    row.counters.hole_rays += u64::from(sum.holes());
                    (*color, *alpha) = sum.color_and_alpha();
                }
            }
            self.monitor.advance(1);
            Ok(row.counters)
        };
        let in_row = (width as usize).max(1);
        let rows = color.par_chunks_mut(in_row).zip(alpha.par_chunks_mut(in_row)).enumerate();
        let counters = rows.map(row).try_reduce(Counters::default, |sum, of_row| Ok(sum + of_row))?;
        let image = RenderedImage::new(Plane::new(width, height, color)?, Plane::new(width, height, alpha)?);
        Ok(Rendered { image, counters })
    }

    fn secondary(&self) -> Option<SecondaryRays<'_>> {
        self.proxies.as_ref().map(|proxies| SecondaryRays::new(self.views, self.settings, proxies))
    }

    /// Returns the direction of a ray, given its pixel and its index in the sample grid of the pixel.
    fn direction(&self, [x, y]: [usize; 2], at: usize) -> Vec3 {
        let samples = self.settings.samples.max(1) as usize;
        let place = |pixel: usize, sample: usize, size: u32| {
            (pixel as f64 + (sample as f64 + 0.5) / samples as f64) / f64::from(size)
        };
        let size = self.settings.size;
        let window = [place(x, at % samples, size[0]), place(y, at / samples, size[1])];
        self.camera.direction(window).as_vec3()
    }
}

/// State of a row of pixels that is being rendered.
struct Row<'a, F> {
    picture: &'a Picture<'a>,
    hits: &'a F,
    y: usize,
    /// None without secondary rays.
    secondary: Option<SecondaryRays<'a>>,
    counters: Counters,
}

impl<F: Fn(&[Vec3], &mut Counters) -> Vec<PrimaryHit>> Row<'_, F> {
    /// Adds the rays with these grid indices to the selected pixels of `sums`, which begin at column `first`.
    fn add_rays(
        &mut self,
        (first, sums): (usize, &mut [PixelSum]),
        grid: &[usize],
        takes: impl Fn(&PixelSum) -> bool,
    ) -> Result<()> {
        if grid.is_empty() {
            return Ok(());
        }
        let pixels: Vec<usize> = (0..sums.len()).filter(|&at| takes(&sums[at])).collect();
        for pixels in pixels.chunks((RAYS_AT_ONCE / grid.len()).max(1)) {
            self.picture.monitor.check()?;
            let rays = pixels.iter().flat_map(|&pixel| grid.iter().map(move |&at| (pixel, at)));
            let directions: Vec<Vec3> =
                rays.clone().map(|(pixel, at)| self.picture.direction([first + pixel, self.y], at)).collect();
            self.counters.primary_rays += directions.len() as u64;
            let hits = (self.hits)(&directions, &mut self.counters);
            for ((pixel, _), (hit, direction)) in rays.zip(hits.iter().zip(directions)) {
                let sample = shade(&mut self.secondary, hit, direction, &mut self.counters);
                sums[pixel].add(sample, self.picture.settings.holes);
            }
        }
        Ok(())
    }
}

/// Returns the colour of a ray, including secondary rays from the surfaces that it hits.
fn shade(
    secondary: &mut Option<SecondaryRays<'_>>,
    hit: &PrimaryHit,
    direction: Vec3,
    counters: &mut Counters,
) -> RaySample {
    let mut light_of = |layer: &Layer| match (secondary.as_mut(), layer.distance_m) {
        (Some(secondary), Some(distance_m)) => {
            let point = Ray { origin: Vec3::ZERO, direction }.at(distance_m);
            layer.share * secondary.light(&SurfaceHit { point, direction, light: layer.light }, counters)
        }
        _ => layer.share * layer.light,
    };
    let share = if hit.first.is_some() { 1.0 - hit.transparent } else { 0.0 };
    RaySample { light: hit.layers().map(&mut light_of).sum(), share, is_hole: hit.is_hole }
}
