//! Brute-force rendering of every output view from its own eye: the ground truth, and the baseline of all times.

use half::f16;
use rayon::prelude::*;

use super::drawing::{DrawnScene, PixelWindow};
use super::views::OutputViews;
use codec::error::{Error, Result};
use codec::image::plane::ColorPlane;
use codec::image::{DepthKind, Plane};
use codec::monitor::Monitor;
use scene::SceneAtTime;
use scene::capture::{Pass, PassSettings, PixelTracer, SamplePattern, capture_view, mean_light};

/// Renders the view from a position on the line, with the same result as `capture`.
pub fn render(
    scene: &SceneAtTime,
    (views, offset_m): (&OutputViews, f64),
    samples: &SamplePattern,
    monitor: &dyn Monitor,
) -> Result<ColorPlane> {
    let settings = PassSettings { passes: &[Pass::Color], samples, depth: DepthKind::Distance, far_m: f64::INFINITY };
    let images = capture_view(scene, &views.viewpoint(offset_m), &settings, monitor)?;
    images.color.ok_or_else(|| Error::invalid("a capture of colour without colour"))
}

/// Renders the same view from triangles that a rasteriser draws.
pub fn draw(
    seen: DrawnScene<'_>,
    (views, offset_m): (&OutputViews, f64),
    samples: &SamplePattern,
    monitor: &dyn Monitor,
) -> Result<ColorPlane> {
    let [width, height] = views.size;
    let from = views.viewpoint(offset_m);
    let pixels = PixelTracer::new(seen.scene, &from);
    let mut light = Vec::with_capacity(width as usize * height as usize);
    let at_once = seen.rows_at_once(width as usize, samples.points.len()).min(height.max(1));
    for top in (0..height).step_by(at_once as usize) {
        let rows = top..(top + at_once).min(height);
        let window = PixelWindow { columns: 0..width as i32, rows: rows.clone() };
        let hits = seen.hits(&from, window, 0, &samples.points, monitor)?;
        let of_row = |row: u32| -> Result<Vec<[f16; 3]>> {
            monitor.check()?;
            let mut light = Vec::with_capacity(width as usize);
            for left in (0..width).step_by(PixelTracer::TILE as usize) {
                let columns = left..(left + PixelTracer::TILE).min(width);
                let corner = |column: u32, row: u32| [f64::from(column), f64::from(row)];
                let candidates = pixels.in_view(corner(columns.start, row), corner(columns.end, row + 1));
                light.extend(columns.map(|column| {
                    mean_light(samples.points.iter().enumerate().map(|(sample, [x, y])| {
                        let ray = pixels.ray([f64::from(column) + x, f64::from(row) + y]);
                        let hit = hits.first([column as i32, row as i32], sample, &ray, &candidates);
                        seen.scene.shade(&ray, hit.as_ref()).total()
                    }))
                }));
            }
            Ok(light)
        };
        let band: Vec<Vec<[f16; 3]>> = rows.into_par_iter().map(of_row).collect::<Result<_>>()?;
        light.extend(band.into_iter().flatten());
    }
    Plane::new(width, height, light)
}
