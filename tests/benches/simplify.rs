//! Rendering speed of simplified scenes, compared with marching the light fields that they were made from, on one thread:
//! millions of pixels per second, and the ratio to marching.
//!
//! `cargo bench --bench simplify [-- DATASET..]` encodes and simplifies each dataset (20,000 triangles, an atlas of 2048 texels),
//! by default a built-in room of nine probes. Both are drawn from a point between the probes, as six faces of a cube map. Times
//! are medians over `TURNS` runs; columns are separated by two spaces. Below the table are the time to read and merge the samples
//! relative to reading them, and the time of twice the samples.

#![allow(clippy::disallowed_methods)]

mod clock;

use std::hint::black_box;
use std::path::Path;
use std::process::Command;

use clock::Clock;
use codec::decode::{AllUnits, Decoder};
use codec::effort::Effort;
use codec::error::{Error, Result};
use codec::image::cube::Face;
use codec::math::{Camera, Lens};
use codec::monitor::Silent;
use glam::DVec3;
use render::march::active_views::ActiveViews;
use render::march::playback::frames::PictureOptions;
use render::march::render::render;
use render::march::settings::SpecularMode;
use render::views::catalogue::ProbeChoice;
use render::views::light_field::LightField;
use render::views::player::Player;
use simplify::budgets::Budgets;
use simplify::capture::Capture;
use simplify::pipeline::simplify;
use simplify::points::{MAX_POINTS, PointMerger};
use simplify::quad_mesh::QuadMesh;
use simplify::raster::{Compositing, DrawSettings, draw_picture, draw_plainly};
use simplify::read_glb::read_glb;
use simplify::region::ViewingRegion;
use simplify::samples::{Background, BakedLight, Inside, SampleRules};
use simplify::settings::Settings;

/// Number of runs of each measurement.
const TURNS: usize = 3;
const SIZES: [u32; 2] = [256, 512];

fn main() -> Result<()> {
    rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread().build_global().ok();
    let folder = tempfile::tempdir().map_err(|error| Error::io("a temporary folder", error))?;
    let mut datasets: Vec<String> = std::env::args().skip(1).filter(|word| !word.starts_with("--")).collect();
    if datasets.is_empty() {
        let room = folder.path().join("room").display().to_string();
        let line = ["capture", "interior", "--size", "192", "--samples", "1", "--frames", "0", "-q", "-o", &room];
        let position = |at: u32| {
            format!(
                "--position={},{},{}",
                0.3 * f64::from(at % 3),
                1.5 + 0.1 * f64::from(at % 2),
                0.3 * f64::from(at / 3)
            )
        };
        run(line.map(str::to_owned).into_iter().chain((0..9).map(position)))?;
        datasets.push(room);
    }
    for dataset in datasets {
        let path = |name: &str| folder.path().join(name).display().to_string();
        let (container, scene) = (path("a.lfold"), path("a.glb"));
        let words = |line: &[&str]| line.iter().map(|word| (*word).to_owned()).collect::<Vec<_>>();
        run(words(&["encode", &dataset, "--clip", "--frames", "0", "-q", "-o", &container]))?;
        let budgets = ["--triangles", "20000", "--atlas", "2048", "--effort", "fast", "-q", "-o", &scene];
        run(words(&[&["simplify", &dataset], &budgets[..]].concat()))?;
        measure(&dataset, &container, &scene)?;
        merge(&dataset)?;
        simplify_half(&dataset)?;
    }
    Ok(())
}

/// Runs the program; fails if it does not succeed.
fn run(words: impl IntoIterator<Item = String>) -> Result<()> {
    let words: Vec<String> = words.into_iter().collect();
    let output = Command::new(env!("CARGO_BIN_EXE_lightfold")).args(&words).output();
    let output = output.map_err(|error| Error::io("lightfold", error))?;
    match output.status.success() {
        true => Ok(()),
        false => Err(Error::invalid(format!("{words:?}: {}", String::from_utf8_lossy(&output.stderr)))),
    }
}

fn measure(name: &str, container: &str, scene: &str) -> Result<()> {
    let decoder = Decoder::open(container)?;
    let mut player = Player::new(&decoder, &ProbeChoice::default())?;
    let all: Vec<usize> = (0..player.field.views.len()).collect();
    player.show(player.frames().first, &all, &AllUnits)?;
    let scene = read_glb(Path::new(scene))?.quads;
    println!("{name}: {} views, {} triangles", all.len(), scene.mesh.triangles.len());
    println!("{:<28}  {:>9}  {:>10}  {:>8}", "", "Mpixel/s", "x marching", "overdraw");
    for size in SIZES {
        let marching = marched(&player.field, size)?;
        print(&format!("{size}²; marching"), marching, marching, None);
        for (label, compositing, samples) in
            [("painter", Compositing::Painter, 1), ("z-buffer, 2x2 samples", Compositing::ZBuffer, 2)]
        {
            let settings = DrawSettings { size: [size; 2], compositing, samples };
            let (speed, overdraw) = drawn(&player.field, size, |camera| {
                Ok(draw_picture(&scene, camera, &settings, &Silent)?.fragments / u64::from(samples * samples))
            })?;
            print(&format!("{size}²; {label}"), speed, marching, Some(overdraw));
        }
        let (speed, overdraw) = drawn(&player.field, size, |camera| plainly(&scene, camera, size))?;
        print(&format!("{size}²; painter, plain"), speed, marching, Some(overdraw));
    }
    println!();
    Ok(())
}

/// Measures the time to read all files and merge their samples, relative to reading alone.
fn merge(dataset: &str) -> Result<()> {
    let mut capture = Capture::open(Path::new(dataset), Some(0))?;
    let region = ViewingRegion::around(capture.images.iter().map(|image| image.eye));
    let rules =
        SampleRules { region: &region, background: Background::Sky, inside: Inside::Drop, baked: BakedLight::Mean };
    let images = 0..capture.images.len();
    let read = median(|| {
        images.clone().try_for_each(|image| capture.rays(image).map(|rays| rays.iter().map(black_box).for_each(|_| ())))
    })?;
    let merged = median(|| {
        let mut merger = PointMerger::new(MAX_POINTS);
        rules.ends_of_all_images(&mut capture, &Silent, |ends, _| merger.add(&ends))?;
        black_box(merger.finish());
        Ok(())
    })?;
    println!("reading and merging: {:.2} times reading alone ({read:.2} s)", merged / read);
    Ok(())
}

/// Measures all stages with all images of a dataset, relative to every second image.
fn simplify_half(dataset: &str) -> Result<()> {
    let mut capture = Capture::open(Path::new(dataset), Some(0))?;
    let images = 0..capture.images.len();
    let rays: Vec<Vec<_>> = images.map(|image| Ok(capture.rays(image)?.iter().collect())).collect::<Result<_>>()?;
    let budgets = Budgets { triangles: 20_000.0, ..Settings::default().budgets };
    let settings = Settings { budgets, atlas: 2048, effort: Effort::Fast, inside: Inside::Drop, ..Settings::default() };
    let [half, all] = [2, 1].map(|step| {
        median(|| {
            let images = capture.images.iter().cloned().zip(rays.iter().cloned()).step_by(step);
            black_box(simplify(&mut Capture::of_rays(images), &settings, &Silent)?);
            Ok(())
        })
    });
    let (half, all) = (half?, all?);
    println!("twice the samples: {:.2} times the {half:.2} s of half of the images\n", all / half);
    Ok(())
}

/// Returns the median seconds of `TURNS` runs.
fn median(mut work: impl FnMut() -> Result<()>) -> Result<f64> {
    let mut seconds = Vec::new();
    for _ in 0..TURNS {
        let start = Clock::start();
        work()?;
        seconds.push(start.seconds());
    }
    seconds.sort_by(f64::total_cmp);
    Ok(seconds[TURNS / 2])
}

fn plainly(scene: &QuadMesh, camera: &Camera, size: u32) -> Result<u64> {
    Ok(draw_plainly(scene, camera, [size; 2]).fragments)
}

fn print(label: &str, speed: f64, marching: f64, overdraw: Option<f64>) {
    let overdraw = overdraw.map_or(String::new(), |overdraw| format!("{overdraw:.2}"));
    println!("{label:<28}  {speed:>9.3}  {:>10.1}  {overdraw:>8}", speed / marching);
}

/// Returns a point between the probes.
fn eye(field: &LightField) -> DVec3 {
    let positions = field.views.iter().map(|view| view.position);
    positions.sum::<DVec3>() / field.views.len() as f64 + DVec3::new(0.03, 0.02, -0.01)
}

/// Returns millions of pixels per second, and fragments per pixel.
fn drawn(field: &LightField, size: u32, mut draw: impl FnMut(&Camera) -> Result<u64>) -> Result<(f64, f64)> {
    let (eye, pixels) = (eye(field), 6.0 * f64::from(size).powi(2));
    let mut fragments = 0;
    let seconds = median(|| {
        fragments = 0;
        for face in Face::CUBE {
            let [forward, _, down] = face.axes();
            let camera = Camera::look_at(eye, eye + forward, -down, Lens::new(90.0))?;
            fragments += black_box(draw(&camera)?);
        }
        Ok(())
    })?;
    Ok((pixels / seconds / 1e6, fragments as f64 / pixels))
}

/// Returns the speed of marching with the settings of `render`, in millions of pixels per second.
fn marched(field: &LightField, size: u32) -> Result<f64> {
    let all: Vec<usize> = (0..field.views.len()).collect();
    let views = ActiveViews::new(field, &all, eye(field));
    let options = PictureOptions { size: [size; 2], specular: SpecularMode::None, ..PictureOptions::default() };
    let settings = options.settings(&views);
    Ok(drawn(field, size, |camera| Ok(render(&views, camera, &settings, &Silent)?.counters.primary_rays))?.0)
}
