//! Scenes for testing triangle layers on a device: compares drawn surfaces with those hit by rays, layer by layer, and pictures
//! of both.

use std::sync::Arc;
use std::time::Instant;

use glam::{DVec3, Vec2};

use super::rooms::Builder;
use crate::Gpu;
use crate::harness::KernelReport;
use crate::render::agreement::Agreement;
use crate::triangles::GpuTriangles;
use codec::error::Result;
use codec::math::{Camera, Lens};
use codec::monitor::Silent;
use epipolar::brute_force;
use epipolar::drawing::{DrawnScene, MAX_DRAWN, PixelWindow};
use epipolar::views::{OutputViews, Spread};
use render::rendered_image::RenderedImage;
use scene::capture::{PixelTracer, SamplePattern};
use scene::mesh::{ImageTexture, Material, Mesh, Wrap};
use scene::{DemoKind, DemoScene, Light, MeshMaterial, SceneAtTime, SceneMesh};

const SIZE: [u32; 2] = [121, 90];

/// A scene, and views of it.
pub struct TriangleCase {
    pub label: &'static str,
    pub scene: SceneAtTime,
    pub views: OutputViews,
}

pub fn cases() -> Result<Vec<TriangleCase>> {
    let looking = |eye: DVec3, fov_deg: f64, spread: Spread, focus_m: f64| {
        let lens = Lens { aspect: f64::from(SIZE[0]) / f64::from(SIZE[1]), ..Lens::new(fov_deg) };
        let camera = Camera::look_at(eye, eye + DVec3::new(-0.7, -0.15, -0.6), DVec3::Y, lens)?;
        OutputViews::new(camera, SIZE, 2, spread, focus_m)
    };
    let parallel = |eye: DVec3, fov_deg: f64| looking(eye, fov_deg, Spread::Baseline(0.4), f64::INFINITY);
    let away = DVec3::new(1e4, -2e3, 3e4);
    let objects = DemoScene::new(DemoKind::Courtyard).at(0.0).objects;
    let case = |label, meshes: Vec<SceneMesh>, views| {
        let meshes = meshes.into_iter().map(Arc::new).collect();
        TriangleCase { label, scene: SceneAtTime::with_meshes(Vec::new(), meshes, Light::default()), views }
    };
    let mut cases = vec![
        case("no mesh", Vec::new(), parallel(DVec3::ZERO, 70.0)?),
        case("a room", vec![room(DVec3::ZERO)], parallel(DVec3::new(0.3, -0.2, 0.1), 80.0)?),
        case("leaves in a room", vec![leaves(None), room(DVec3::ZERO)], parallel(DVec3::new(0.1, 0.2, 0.3), 80.0)?),
        case("leaves with holes", vec![room(DVec3::ZERO), leaves(Some(0.5))], parallel(DVec3::ZERO, 60.0)?),
        case("a narrow view", vec![leaves(None), room(DVec3::ZERO)], parallel(DVec3::ZERO, 5.0)?),
        case("far from the origin", vec![room(away)], parallel(away + DVec3::X * 0.2, 80.0)?),
        case("views that converge", vec![leaves(None), room(DVec3::ZERO)], {
            looking(DVec3::ZERO, 60.0, Spread::Cone(30.0), 2.0)?
        }),
        case("objects among triangles", vec![leaves(None)], parallel(DVec3::new(0.0, 1.5, 0.2), 70.0)?),
    ];
    let meshes = cases[7].scene.meshes.clone();
    cases[7].scene = SceneAtTime::with_meshes(objects, meshes, Light::default());
    Ok(cases)
}

fn room(middle: DVec3) -> SceneMesh {
    let mut builder = Builder::new();
    builder.room(middle, 4.0);
    SceneMesh::new(builder.into_mesh(), [MeshMaterial::default()].into())
}

/// Returns a mesh of floating squares; with a cutoff they are cut to disks.
fn leaves(cutoff: Option<f64>) -> SceneMesh {
    let mut builder = Builder::new();
    builder.leaves(60);
    let mut mesh: Mesh = builder.into_mesh();
    let corners = [Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y];
    mesh.uvs = (0..mesh.positions.len()).map(|at| corners[at % 4]).collect();
    let side = 32;
    let texel = |at: u32| {
        let [x, y] = [at % side, at / side].map(|at| (f64::from(at) + 0.5) / f64::from(side) - 0.5);
        [90, 160, 60, if x.hypot(y) < 0.4 { u8::MAX } else { 0 }]
    };
    let texture = ImageTexture {
        width: side,
        height: side,
        pixels: (0..side * side).map(texel).collect(),
        wrap: [Wrap::Clamp; 2],
    };
    let plain = Material { base_texture: Some(Arc::new(texture)), alpha_cutoff: cutoff, ..Material::default() };
    SceneMesh::new(mesh, [MeshMaterial { plain, ..MeshMaterial::default() }].into())
}

/// Renders the last view with drawn triangles and with rays, counts the surfaces at all pixel centres in both, and compares.
pub fn run(gpu: &Gpu, case: &TriangleCase) -> Result<Agreement> {
    let (scene, views) = (&case.scene, &case.views);
    let samples = SamplePattern::new(4)?;
    let place = (views, views.ends_m()[1]);
    let triangles = GpuTriangles::new(gpu, scene)?;
    let drawn = DrawnScene { scene, drawing: Some(&triangles) };
    let [found, expected] = [drawn, DrawnScene::from(scene)].map(|seen| {
        let color = brute_force::draw(seen, place, &samples, &Silent)?;
        Ok((RenderedImage::opaque(&color), surfaces(seen, place)?))
    });
    let ((found, found_count), (expected, expected_count)) = (found?, expected?);
    Agreement::of_images(&found, &expected, [found_count, expected_count])
}

/// Returns the total number of surfaces behind the centres of all pixels.
fn surfaces(seen: DrawnScene<'_>, (views, offset_m): (&OutputViews, f64)) -> Result<u64> {
    let from = views.viewpoint(offset_m);
    let [width, height] = views.size;
    let window = PixelWindow { columns: 0..width as i32, rows: 0..height };
    let hits = seen.hits(&from, window, MAX_DRAWN, &[], &Silent)?;
    let pixels = PixelTracer::new(seen.scene, &from);
    let all: Vec<usize> = (0..seen.scene.objects.len()).collect();
    let places = (0..height as i32).flat_map(|row| (0..width as i32).map(move |column| [column, row]));
    let count = |pixel: [i32; 2]| hits.all(pixel, &pixels.ray(pixel.map(|at| f64::from(at) + 0.5)), &all).len() as u64;
    Ok(places.map(count).sum())
}

/// Runs all cases; the last one is timed.
pub fn test(gpu: &Gpu, name: &'static str) -> Result<KernelReport> {
    let mut report = KernelReport::new(name);
    let cases = cases()?;
    for case in &cases {
        let agreement = run(gpu, case)?;
        report.inputs += 1;
        report.mismatches += agreement.mismatches();
        if agreement.mismatches() > 0 && report.first.is_none() {
            report.first = Some(format!("{}: {agreement:?}", case.label));
        }
    }
    if let Some(case) = cases.last() {
        let triangles = GpuTriangles::new(gpu, &case.scene)?;
        let seen = DrawnScene { scene: &case.scene, drawing: Some(&triangles) };
        let start = Instant::now();
        surfaces(seen, (&case.views, case.views.ends_m()[1]))?;
        let pixels = SIZE.map(f64::from).iter().product::<f64>();
        report.megapixels_per_second = pixels / 1e6 / start.elapsed().as_secs_f64().max(1e-9);
    }
    Ok(report)
}
