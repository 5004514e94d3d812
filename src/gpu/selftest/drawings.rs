//! Simplified scenes and cameras for testing the drawings: a tiled room, leaves in front of it, triangles through the eye.

use std::time::Instant;

use glam::DVec3;

use super::rooms::Builder;
use crate::Gpu;
use crate::harness::KernelReport;
use crate::quads::GpuQuads;
use crate::render::agreement::Agreement;
use codec::error::Result;
use codec::math::{Camera, Lens};
use codec::monitor::Silent;
use kernels::Drawing;
use simplify::quad_mesh::QuadMesh;
use simplify::raster::{Compositing, DrawSettings, Drawn, draw_picture};

/// Width of a picture in pixels.
const SIZE: u32 = 96;

#[derive(Debug)]
pub struct DrawingCase {
    pub label: &'static str,
    pub scene: QuadMesh,
    pub camera: Camera,
    pub settings: DrawSettings,
}

/// Returns all cases; the last one is timed.
pub fn cases(compositing: Compositing) -> Result<Vec<DrawingCase>> {
    let settings = DrawSettings { size: [SIZE, SIZE - 11], compositing, samples: 1 };
    let (in_room, away) = (DVec3::new(0.3, -0.2, 0.1), DVec3::new(1e5, -2e4, 3e5));
    let case = |label, scene: &dyn Fn(&mut Builder), camera: Camera| {
        let mut builder = Builder::new();
        scene(&mut builder);
        DrawingCase { label, scene: builder.finish(), camera, settings }
    };
    let room = |builder: &mut Builder| builder.room(DVec3::ZERO, 4.0);
    let leaves = |builder: &mut Builder| {
        builder.room(DVec3::ZERO, 4.0);
        builder.leaves(60);
    };
    let homogeneous = |builder: &mut Builder| {
        builder.room(DVec3::ZERO, 4.0);
        // Homogeneous weights that differ by corner: texture coordinates are not affine within a tile.
        builder.stq =
            (0..).zip(&builder.mesh.uvs).map(|(at, uv)| uv.extend(1.0) * (1.0 + 0.3 * (at % 4) as f32)).collect();
    };
    let clipped = Lens { near_m: 1.5, far_m: 4.5, ..Lens::new(80.0) };
    let mut cases = vec![
        case("no triangle in sight", &|builder| builder.square(DVec3::Z * 2.0, 0.5, 0), looking(DVec3::ZERO, 80.0)?),
        case("room", &room, looking(in_room, 80.0)?),
        case("leaves in a room", &leaves, looking(DVec3::new(0.1, 0.2, 0.3), 80.0)?),
        case("a narrow view", &leaves, looking(DVec3::ZERO, 4.0)?),
        case("tiles beside and behind the eye", &leaves, looking(DVec3::new(3.9, 3.9, -3.9), 130.0)?),
        case("far from the origin", &|builder| builder.room(away, 4.0), looking(away + in_room, 80.0)?),
        case("near and far planes", &leaves, {
            Camera::look_at(DVec3::ZERO, DVec3::new(-0.7, -0.15, -0.6), DVec3::Y, clipped)?
        }),
        case("an image off its axis", &leaves, looking(DVec3::ZERO, 70.0)?.off_axis([0.3, -0.2])?),
        case("homogeneous texture coordinates", &homogeneous, looking(DVec3::ZERO, 70.0)?),
        case("several samples", &leaves, looking(DVec3::new(0.1, 0.2, 0.3), 80.0)?),
        case("leaves, four times as wide", &leaves, looking(DVec3::new(-0.2, 0.1, 0.3), 80.0)?),
    ];
    cases[9].settings.samples = 2;
    cases[10].settings.size = [4 * SIZE, 4 * SIZE];
    Ok(cases)
}

#[derive(Debug, Clone)]
pub struct DrawingResult {
    pub agreement: Agreement,
    pub on_device: Drawn,
    pub on_cpu: Drawn,
}

pub fn run(gpu: &Gpu, case: &DrawingCase) -> Result<DrawingResult> {
    let on_device = GpuQuads::new(gpu, &case.scene)?.draw(&case.camera, &case.settings, &Silent)?;
    let on_cpu = draw_picture(&case.scene, &case.camera, &case.settings, &Silent)?;
    let [found, expected] = [&on_device, &on_cpu].map(|drawn| drawn.over_black(case.settings.size));
    let agreement = Agreement::of_images(&found?, &expected?, [on_device.fragments, on_cpu.fragments])?;
    Ok(DrawingResult { agreement, on_device, on_cpu })
}

/// Renders all pictures that use a drawing, and compares them with the CPU's.
pub fn test_drawing(gpu: &Gpu, drawing: &'static Drawing) -> Result<KernelReport> {
    if drawing.name == kernels::TRIANGLES.name {
        return super::triangles::test(gpu, drawing.name);
    }
    let mut report = KernelReport::new(drawing.name);
    // With a z-buffer a separate drawing counts fragments, because the depth test hides some.
    let is_painter = drawing.name == kernels::QUADS_PAINTER.name;
    let cases = cases(if is_painter { Compositing::Painter } else { Compositing::ZBuffer })?;
    for case in &cases {
        let agreement = run(gpu, case)?.agreement;
        report.inputs += 1;
        report.mismatches += agreement.mismatches();
        if agreement.mismatches() > 0 && report.first.is_none() {
            report.first = Some(format!("{}: {agreement:?}", case.label));
        }
    }
    if let Some(case) = cases.last() {
        let quads = GpuQuads::new(gpu, &case.scene)?;
        let start = Instant::now();
        quads.draw(&case.camera, &case.settings, &Silent)?;
        let pixels = f64::from(case.settings.size[0]) * f64::from(case.settings.size[1]);
        report.megapixels_per_second = pixels / 1e6 / start.elapsed().as_secs_f64().max(1e-9);
    }
    Ok(report)
}

fn looking(eye: DVec3, fov_y_deg: f64) -> Result<Camera> {
    let lens = Lens { aspect: 1.13, ..Lens::new(fov_y_deg) };
    Camera::look_at(eye, eye + DVec3::new(-0.7, -0.15, -0.6), DVec3::Y, lens)
}
