//! Views with highlights: glossy floors and balls under suns and lamps at difficult positions.

use std::time::Instant;

use glam::DVec3;

use super::slices::{self, InterpolationCase};
use crate::Gpu;
use crate::epipolar::GpuInterpolator;
use crate::harness::KernelReport;
use codec::error::Result;
use codec::math::{Camera, Lens};
use codec::monitor::Silent;
use epipolar::acquire::{AcquireSettings, acquire};
use epipolar::backend::{Backend, Cpu};
use epipolar::interpolate::{InterpolateSettings, Interpolator};
use epipolar::views::{OutputViews, Spread};
use scene::capture::SamplePattern;
use scene::{Lamp, Light, Material, Object, Phong, Quad, SceneAtTime, Shape, Sky, Sphere, Texture, Window};

const SIZE: [u32; 2] = [72, 40];
/// Metres from the first view to the last.
const BASELINE_M: f64 = 0.6;

/// Creates a scene of a glossy floor and ball and a matte wall under lamps.
fn scene(exponent: f64, radiance: f64, lamps: &[[f64; 3]]) -> SceneAtTime {
    let phong = Phong { weight: DVec3::new(0.5, 0.4, 0.3), exponent };
    let glossy = Material { phong, ..Material::diffuse(Texture::Solid(DVec3::new(0.2, 0.3, 0.4))) };
    let floor = Quad { corner: DVec3::new(-6.0, -0.8, 2.0), u: DVec3::X * 12.0, v: DVec3::NEG_Z * 12.0 };
    let wall = Quad { corner: DVec3::new(-6.0, -0.8, -5.0), u: DVec3::X * 12.0, v: DVec3::Y * 3.0 };
    let ball = Sphere { center: DVec3::new(0.2, -0.3, -2.2), radius: 0.5 };
    let matt = Material::diffuse(Texture::Solid(DVec3::splat(0.5)));
    let objects = vec![
        Object::new(Shape::Quad(floor), glossy),
        Object::new(Shape::Quad(wall), matt),
        Object::new(Shape::Sphere(ball), glossy),
    ];
    let lamp = |position: &[f64; 3]| Lamp {
        position: DVec3::from_array(*position),
        radiance: DVec3::splat(radiance),
        reach: f64::INFINITY,
        window: Window::Smooth,
        cone: None,
    };
    let lamps = lamps.iter().map(lamp).collect();
    SceneAtTime::new(objects, Light { lamps, sky: Sky::NONE, ..Light::default() })
}

fn case(
    label: &str,
    scene: &SceneAtTime,
    (count, baseline_m, focus_m): (u32, f64, f64),
    splits: usize,
) -> Result<InterpolationCase> {
    let camera = Camera::look_at(DVec3::ZERO, DVec3::new(0.0, -0.15, -1.0), DVec3::Y, Lens::new(50.0))?;
    let camera = camera.with_aspect(f64::from(SIZE[0]) / f64::from(SIZE[1]));
    let views = OutputViews::new(camera, SIZE, count, Spread::Baseline(baseline_m), focus_m)?;
    let settings = AcquireSettings::new(SamplePattern::new(1)?);
    let (sources, _) = acquire(scene, &views, &settings, (&Cpu, &Silent))?;
    let settings = InterpolateSettings { splits, ..InterpolateSettings::default() };
    Ok(InterpolationCase { label: label.to_owned(), views, sources, settings })
}

/// Returns all cases, difficult ones first; the last one is timed.
pub fn cases() -> Result<Vec<InterpolationCase>> {
    let half = 0.5 * BASELINE_M;
    let views = (7, BASELINE_M, f64::INFINITY);
    let lamps = |places: &[[f64; 3]]| scene(60.0, 4.0, places);
    let above = lamps(&[[0.4, 1.5, -1.5], [-1.0, 1.0, -3.0]]);
    Ok(vec![
        case("suns alone", &lamps(&[]), views, 8)?,
        case("a lamp at the first eye", &lamps(&[[-half, 0.0, 0.0]]), views, 8)?,
        case("a lamp at the last eye", &lamps(&[[half, 0.0, 0.0]]), views, 8)?,
        case("lamps on the line beyond its ends", &lamps(&[[-4.0, 0.0, 0.0], [4.0, 0.0, 0.0]]), views, 8)?,
        case("a lamp on the line", &lamps(&[[0.05, 0.0, 0.0]]), views, 8)?,
        case("no splits between the ends", &above, views, 0)?,
        case("one split", &above, views, 1)?,
        case("64 splits", &above, views, 64)?,
        case("one view", &above, (1, 0.0, f64::INFINITY), 8)?,
        case("views in one place", &above, (3, 0.0, f64::INFINITY), 8)?,
        case("views that converge", &above, (5, BASELINE_M, 2.2), 8)?,
        case("the sharpest highlight", &scene(1e4, 4.0, &[[0.4, 1.5, -1.5]]), views, 8)?,
        case("the widest highlight", &scene(1.0, 4.0, &[[0.4, 1.5, -1.5]]), views, 8)?,
        case("brighter than half floats", &scene(60.0, 1e12, &[[0.4, 1.5, -1.5]]), views, 8)?,
        case("darker than half floats", &scene(60.0, 1e-9, &[[0.4, 1.5, -1.5]]), views, 8)?,
        case("all lamps, 33 views", &above, (33, BASELINE_M, 3.0), 8)?,
    ])
}

/// Runs all cases.
pub fn test(gpu: &Gpu, name: &'static str) -> Result<KernelReport> {
    let mut report = KernelReport::new(name);
    let (on_device, cases) = (GpuInterpolator::new(gpu), cases()?);
    for case in &cases {
        let found = slices::run(&on_device, case)?;
        report.inputs += case.views.offsets_m.len() as u64;
        report.mismatches += found.mismatches;
        report.first = report.first.take().or(found.first);
    }
    if let Some(case) = cases.last() {
        let of = Interpolator::new(&case.views, &case.sources, case.settings);
        let views = case.views.offsets_m.len();
        let start = Instant::now();
        on_device.views(&of, 0..views, &Silent)?;
        let pixels = SIZE.map(f64::from).iter().product::<f64>() * views as f64;
        report.megapixels_per_second = pixels / 1e6 / start.elapsed().as_secs_f64().max(1e-9);
    }
    Ok(report)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cases_show_highlights_that_change_from_view_to_view() {
        for case in cases().unwrap() {
            let of = Interpolator::new(&case.views, &case.sources, case.settings);
            let count = case.views.offsets_m.len();
            let (_, counters) = of.views(0..count, &Silent).unwrap();
            // Views at one position coincide with the source, which shows its own radiance without splits.
            let is_own = case.views.baseline_m() == 0.0;
            assert!(is_own || counters.splits > 100, "{}: {counters:?}", case.label);
        }
    }
}
