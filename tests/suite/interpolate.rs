//! `lightfold interpolate`: effect of each stage, output files, and refusals.

use std::path::Path;

use codec::image::{Plane, ReadLimits, ToneMap};
use codec::math::{Camera, Lens};
use codec::monitor::Silent;
use epipolar::acquire::{AcquireSettings, Acquisition, Culling, acquire};
use epipolar::backend::Cpu;
use epipolar::brute_force;
use epipolar::coalesce::Coalescing;
use epipolar::counters::Counters;
use epipolar::fill::HoleFilling;
use epipolar::interpolate::{InterpolateSettings, Interpolator};
use epipolar::pipeline::{Request, RowsAtOnce, Settings, Summary, interpolate};
use epipolar::source::in_order;
use epipolar::view_store::Storage;
use epipolar::views::{OutputViews, Spread};
use evaluate::reference::Truth;
use evaluate::similarity::Similarity;
use footage::image_files::{exr, png};
use render::camera_path::TimedCamera;
use render::rendered_image::RenderedImage;
use scene::capture::SamplePattern;
use scene::{Lamp, Light, Material, Object, Phong, Play, Quad, Scene, SceneAtTime, Shape, Sky, Texture, Window};
use serde_json::Value;
use tempfile::TempDir;

use crate::capture::files;
use crate::commands::{fine, refused};

const VIEWS: u32 = 7;

fn scene(name: &str) -> SceneAtTime {
    Scene::open(name, Play::All).unwrap().0.at(0.0)
}

fn views(count: u32, spread: Spread, focus_m: f64) -> OutputViews {
    looking([[0.0, 1.5, 0.2], [2.0, 1.3, 0.0]], count, spread, focus_m)
}

/// Returns output views around a camera at `eye` that looks at `target`.
fn looking([eye, target]: [[f64; 3]; 2], count: u32, spread: Spread, focus_m: f64) -> OutputViews {
    let camera = Camera::look_at(eye.into(), target.into(), [0.0, 1.0, 0.0].into(), Lens::new(60.0)).unwrap();
    OutputViews::new(camera.with_aspect(1.4), [112, 80], count, spread, focus_m).unwrap()
}

/// Eye and target of a view of the courtyard's fence.
const FENCE: [[f64; 3]; 2] = [[-1.5, 1.4, -1.5], [-1.3, 1.2, 4.0]];

fn settings(change: impl FnOnce(&mut Settings)) -> Settings {
    let mut settings = Settings {
        acquire: AcquireSettings::new(SamplePattern::new(4).unwrap()),
        interpolate: InterpolateSettings::default(),
        holes: HoleFilling::Trace,
        at_once: RowsAtOnce { acquired: 16, interpolated: 8 },
        storage: Storage::Memory,
        keeps_unfilled: true,
    };
    change(&mut settings);
    settings
}

struct Run {
    filled: Vec<RenderedImage>,
    unfilled: Vec<RenderedImage>,
    summary: Summary,
}

fn run(scene: &SceneAtTime, views: &OutputViews, settings: &Settings) -> Run {
    let (mut filled, mut unfilled) = (Vec::new(), Vec::new());
    let summary = interpolate(scene, &Request::all(views, settings), &Silent, |view, picture| {
        assert_eq!(view, filled.len());
        filled.push(picture.filled);
        unfilled.push(picture.unfilled.unwrap());
        Ok(())
    });
    Run { filled, unfilled, summary: summary.unwrap() }
}

/// Returns the PSNR in dB over all views, against ray casting.
fn psnr_db(scene: &SceneAtTime, views: &OutputViews, pictures: &[RenderedImage]) -> f64 {
    let samples = SamplePattern::new(4).unwrap();
    let mut sum = Similarity::empty();
    for (picture, &offset_m) in pictures.iter().zip(&views.offsets_m) {
        let color = brute_force::render(scene, (views, offset_m), &samples, &Silent).unwrap();
        let truth = Truth { color, material: None };
        sum.merge(&Similarity::of(picture, &truth, ToneMap::default()).unwrap()).unwrap();
    }
    sum.all.psnr_db()
}

#[test]
fn views_are_close_to_ray_casting_and_every_stage_is_needed() {
    let (scene, views) = (scene("courtyard"), looking(FENCE, VIEWS, Spread::Baseline(1.0), f64::INFINITY));
    let of = |change: fn(&mut Settings)| run(&scene, &views, &settings(change));
    let whole = of(|_| {});
    let whole_db = psnr_db(&scene, &views, &whole.filled);
    assert!(whole_db > 22.0, "{whole_db}");
    // One layer, the nearest surfaces, leaves more holes.
    let nearest: fn(&mut Settings) = |settings| {
        settings.acquire.layers = 1;
        settings.acquire.acquisition = Acquisition::Center;
    };
    let traced = of(nearest);
    let layered = of(|settings| settings.acquire.acquisition = Acquisition::Center);
    let [first, layered] = [&traced, &layered].map(|run| run.summary.counters.hole_pixels);
    assert!(first > 2 * layered.max(20), "{first} {layered}");
    // Filled holes equal ray casting; `HoleFilling::Blank` leaves them transparent.
    let blank = of(|settings| {
        settings.acquire.layers = 1;
        settings.acquire.acquisition = Acquisition::Center;
        settings.holes = HoleFilling::Blank;
    });
    assert_eq!(blank.filled, blank.unfilled);
    assert_eq!((traced.summary.counters.traced_pixels, blank.summary.counters.traced_pixels), (first, 0));
    let samples = SamplePattern::new(4).unwrap();
    let mut filled = 0;
    for (view, &offset_m) in views.offsets_m.iter().enumerate() {
        let truth = brute_force::render(&scene, (&views, offset_m), &samples, &Silent).unwrap();
        let truth: Plane<[f32; 3]> = truth.map(|light| light.map(|light| light.to_f32()));
        assert!(traced.filled[view].alpha.data().iter().all(|alpha| *alpha == 1.0));
        let shown = traced.filled[view].color.data().iter().zip(truth.data());
        for ((shown, truth), alpha) in shown.zip(blank.filled[view].alpha.data()) {
            assert!(*alpha == 1.0 || shown == truth, "view {view}");
            filled += u64::from(*alpha == 0.0);
        }
    }
    assert_eq!(filled, first);
    // With only one source the PSNR is lower, because the outermost views are worse.
    let one = of(|settings| settings.acquire.acquisition = Acquisition::Center);
    let [one, two] = [&one, &whole].map(|run| psnr_db(&scene, &views, &run.unfilled));
    assert!(two > one, "{two} {one}");
}

#[test]
fn source_views_come_out_as_they_went_in() {
    let samples = SamplePattern::new(4).unwrap();
    for name in ["interior", "mirrors", "courtyard"] {
        for focus_m in [f64::INFINITY, 2.5] {
            let (scene, views) = (scene(name), views(VIEWS, Spread::Baseline(0.6), focus_m));
            let pictures = run(&scene, &views, &settings(|_| {})).filled;
            for view in [0, VIEWS as usize - 1] {
                let truth = brute_force::render(&scene, (&views, views.offsets_m[view]), &samples, &Silent).unwrap();
                let light: Plane<[f32; 3]> = truth.map(|light| light.map(|light| light.to_f32()));
                assert_eq!(pictures[view].color, light, "{name}, view {view}");
            }
        }
    }
}

#[test]
fn short_cuts_and_bands_and_threads_do_not_change_the_picture() {
    let (scene, views) = (scene("interior"), views(VIEWS, Spread::Cone(20.0), 2.0));
    let plain = run(&scene, &views, &settings(|_| {}));
    for (acquired, interpolated) in [(1, 1), (7, 3), (16, 1000), (1000, 5)] {
        let at_once = RowsAtOnce { acquired, interpolated };
        let found = run(&scene, &views, &settings(|settings| settings.at_once = at_once));
        assert_eq!(plain.filled, found.filled, "{at_once:?}");
        let expected = Counters { threads: found.summary.counters.threads, ..plain.summary.counters };
        assert_eq!(expected, found.summary.counters);
        assert_eq!(plain.summary.sources, found.summary.sources);
    }
    // Views stored in a file give the same pictures.
    let storage = Storage::File(std::env::temp_dir());
    assert_eq!(plain.filled, run(&scene, &views, &settings(|settings| settings.storage = storage)).filled);
    let counted = plain.summary.counters;
    let plain = plain.filled;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
    assert_eq!(plain, pool.install(|| run(&scene, &views, &settings(|_| {})).filled));
    // Culling may change a few pixels: masks decide per pixel, whereas edges of surfaces lie between pixels.
    let with = |culling: Culling| run(&scene, &views, &settings(|settings| settings.acquire.culling = culling));
    let [offset, all] = [Culling::DepthOffset, Culling::Off].map(with);
    let [by_offset, uncut] = [&offset, &all].map(|run| run.summary.counters);
    assert!(counted.masked_pixels > 0 && counted.source_pixels < by_offset.source_pixels, "{counted:?} {by_offset:?}");
    assert!(by_offset.offset_skipped > 0 && by_offset.source_pixels < uncut.source_pixels, "{by_offset:?} {uncut:?}");
    // Without culling, `offset_skipped` counts only surfaces at equal distance.
    assert!(uncut.offset_skipped < by_offset.offset_skipped, "{uncut:?} {by_offset:?}");
    assert_eq!((by_offset.masked_pixels, uncut.masked_pixels), (0, 0));
    let all = all.filled;
    let pixels = |pictures: &[RenderedImage]| {
        pictures.iter().flat_map(|picture| picture.color.data().to_vec()).collect::<Vec<_>>()
    };
    let (plain, all) = (pixels(&plain), pixels(&all));
    let changed = plain.iter().zip(&all).filter(|(a, b)| a != b).count();
    assert!(changed as f64 <= 1e-3 * plain.len() as f64, "{changed} of {}", plain.len());
}

#[test]
fn coalesced_runs_are_drawn_as_one_primitive_and_stay_close() {
    let (scene, views) = (scene("interior"), views(VIEWS, Spread::Baseline(0.6), f64::INFINITY));
    let with =
        |coalesce: Coalescing| run(&scene, &views, &settings(|settings| settings.interpolate.coalesce = coalesce));
    let plain = with(Coalescing::Off);
    let (counters, plain_db) = (plain.summary.counters, psnr_db(&scene, &views, &plain.filled));
    assert_eq!((counters.coalesced_pixels, counters.lines), (0, counters.source_pixels));
    let mut fewest = counters.lines;
    for pixels in [0.25, 0.5, 1.0] {
        let found = with(Coalescing::Disparity(pixels));
        let of_run = found.summary.counters;
        assert_eq!(of_run.lines + of_run.coalesced_pixels, of_run.source_pixels);
        assert!(of_run.lines < fewest, "{pixels}: {of_run:?}");
        fewest = of_run.lines;
        let found_db = psnr_db(&scene, &views, &found.filled);
        assert!(found_db > plain_db - 0.5, "{pixels}: {found_db} {plain_db}");
    }
    assert!(2 * fewest < counters.lines, "{fewest} {counters:?}");
}

#[test]
fn the_order_of_sources_does_not_matter_and_doubled_ones_are_one() {
    let (scene, views) = (scene("interior"), views(VIEWS, Spread::Baseline(0.4), f64::INFINITY));
    let (sources, _) = acquire(&scene, &views, &settings(|_| {}).acquire, (&Cpu, &Silent)).unwrap();
    let of = |sources: Vec<epipolar::source::SourceView>| {
        let sources = in_order(sources);
        let interpolator = Interpolator::new(&views, &sources, InterpolateSettings::default());
        let found = interpolator.views(0..VIEWS as usize, &Silent).unwrap();
        found.0.iter().map(|view| view.color.clone()).collect::<Vec<_>>()
    };
    let reversed = sources.iter().rev().cloned().collect();
    let doubled = [sources.clone(), sources.clone()].concat();
    let plain = of(sources);
    assert!(plain == of(reversed) && plain == of(doubled));
}

#[test]
fn highlights_are_right_where_they_are_brightest() {
    let (scene, views) = (scene("interior"), views(9, Spread::Baseline(0.8), f64::INFINITY));
    let with = |splits: usize| {
        let run = run(&scene, &views, &settings(|settings| settings.interpolate.splits = splits));
        (psnr_db(&scene, &views, &run.filled), run.summary.counters.splits)
    };
    let (plain_db, plain) = with(0);
    let (few_db, few) = with(8);
    let (many_db, many) = with(64);
    assert!(plain < few && few <= many, "{plain} {few} {many}");
    assert!(few_db > many_db - 0.3 && few_db >= plain_db, "{plain_db} {few_db} {many_db}");
}

#[test]
fn the_brightest_pixel_of_a_highlight_is_right_in_every_view() {
    let floor = Quad { corner: [-6.0, 0.0, -6.0].into(), u: [0.0, 0.0, 12.0].into(), v: [12.0, 0.0, 0.0].into() };
    let mut material = Material::diffuse(Texture::Solid([0.2; 3].into()));
    material.phong = Phong { weight: [0.3; 3].into(), exponent: 60.0 };
    let lamp = Lamp {
        position: [0.2, 2.5, -4.0].into(),
        radiance: [4.0; 3].into(),
        reach: f64::INFINITY,
        window: Window::Smooth,
        cone: None,
    };
    let light = Light { suns: Vec::new(), lamps: vec![lamp], sky: Sky::NONE };
    let scene = SceneAtTime::new(vec![Object::new(Shape::Quad(floor), material)], light);
    let views = looking([[0.0, 1.2, 2.0], [0.0, 0.0, -2.0]], 25, Spread::Baseline(1.5), f64::INFINITY);
    let found = run(&scene, &views, &settings(|_| {}));
    assert!(found.summary.counters.splits > 0);
    let samples = SamplePattern::new(4).unwrap();
    for (view, picture) in found.filled.iter().enumerate() {
        let truth = brute_force::render(&scene, (&views, views.offsets_m[view]), &samples, &Silent).unwrap();
        let lights = truth.data().iter().map(|pixel| pixel[0].to_f32()).zip(picture.color.data());
        let (brightest, made) = lights.max_by(|a, b| a.0.total_cmp(&b.0)).unwrap();
        assert!((made[0] / brightest - 1.0).abs() < 0.02, "view {view}: {} of {brightest}", made[0]);
    }
}

#[test]
fn matt_scenes_and_empty_ones_cost_nothing_more() {
    let empty = SceneAtTime::new(Vec::new(), scene::Light::default());
    let views = views(5, Spread::Baseline(0.5), 2.0);
    let found = run(&empty, &views, &settings(|_| {}));
    let counters = found.summary.counters;
    assert_eq!((counters.source_layers, counters.splits, counters.hole_pixels, counters.traced_pixels), (1, 0, 0, 0));
    assert!(found.filled.iter().all(|picture| picture.alpha.data().iter().all(|alpha| *alpha == 1.0)));
    // Views at one position need only one source.
    let still = views_in_one_place();
    let scene = scene("interior");
    let found = run(&scene, &still, &settings(|_| {}));
    assert_eq!(found.summary.counters.source_views, 1);
    assert!(found.filled.iter().all(|picture| *picture == found.filled[0]));
}

fn views_in_one_place() -> OutputViews {
    views(3, Spread::Baseline(0.0), f64::INFINITY)
}

const LINE: &str = "interpolate interior --eye 0,1.5,0 --look-at 2,1.4,0 --size 24x32 --samples 1";

fn report(line: &str, folder: &Path) -> Value {
    serde_json::from_slice(&fine(line, folder).stdout).unwrap()
}

#[test]
fn parts_have_the_files_of_the_whole_and_quilts_join_them() {
    let folder = TempDir::new().unwrap();
    let at = folder.path();
    let said = report(&format!("{LINE} --views 12 --baseline 0.3 --quilt 4x3 -o q.png --json"), at);
    assert!(said["quilt"].as_str().unwrap().ends_with("q_qs4x3a0.75.png"), "{said}");
    // Parts as rendered by three machines, one of which runs twice.
    for part in ["5-8", "0-4", "9-11", "5-8"] {
        fine(&format!("{LINE} --views 12 --baseline 0.3 --view-range {part} -o v/%04d.png"), at);
    }
    fine(&format!("{LINE} --views 12 --baseline 0.3 -o whole/%04d.png"), at);
    assert!(files(&at.join("v")) == files(&at.join("whole")), "parts have other files than one run");
    fine("quilt v/%04d.png --quilt 4x3 -o joined.png", at);
    let bytes = |name: &str| std::fs::read(at.join(name)).unwrap();
    assert_eq!(bytes("q_qs4x3a0.75.png"), bytes("joined_qs4x3a0.75.png"));
    // The bytes do not depend on the number of threads.
    fine(&format!("{LINE} --views 12 --baseline 0.3 --quilt 4x3 -o one.png --threads 1"), at);
    assert_eq!(bytes("q_qs4x3a0.75.png"), bytes("one_qs4x3a0.75.png"));
    let picture = png::read_rgba8(&at.join("q_qs4x3a0.75.png"), &ReadLimits::default()).unwrap();
    assert_eq!((picture.width(), picture.height()), (96, 96));
    fine(&format!("{LINE} --views 2 --baseline 0.3 -o v/%02d.exr"), at);
    assert!(exr::read_rgba(&at.join("v/01.exr"), &ReadLimits::default()).is_ok());
}

#[test]
fn a_comparison_has_all_figures() {
    let folder = TempDir::new().unwrap();
    let said = report(
        &format!("{LINE} --views 5 --view-cone 20 --focus 2 --null --compare --csv v.csv --json"),
        folder.path(),
    );
    for key in ["psnr_db", "ssim", "psnr_hvs_m_db", "mse"] {
        for group in ["quality", "quality_without_fill"] {
            let figure = &said[group][key];
            assert!(figure["min"].as_f64() <= figure["mean"].as_f64(), "{group} {key}: {said}");
        }
    }
    assert!(said["speedup"].as_f64().unwrap() > 0.0 && said["counters"]["source_views"] == 2, "{said}");
    let table = std::fs::read_to_string(folder.path().join("v.csv")).unwrap();
    assert_eq!(table.lines().count(), 6);
    let cast = report(&format!("{LINE} --views 2 --baseline 0.1 --null --brute-force --json"), folder.path());
    assert_eq!((&cast["brute_force"], cast["counters"]["lines"].as_u64()), (&Value::Bool(true), Some(0)));
}

#[test]
fn stages_add_up_to_the_time_of_a_run() {
    let folder = TempDir::new().unwrap();
    let of = |more: &str| report(&format!("{LINE} --views 5 --baseline 0.3 --null --json {more}"), folder.path());
    let [whole, nearest] = ["--layers 10", "--layers 1"].map(of);
    let seconds = |of: &Value, stage: &str| of["stages"][stage].as_f64().unwrap();
    let sum: f64 = whole["stages"].as_object().unwrap().values().map(|stage| stage.as_f64().unwrap()).sum();
    assert!((sum - whole["seconds"].as_f64().unwrap()).abs() < 1e-6 + 1e-3 * sum, "{whole}");
    for stage in ["acquire", "mask", "filter", "interpolate", "light"] {
        assert!(seconds(&whole, stage) > 0.0, "{stage}: {whole}");
    }
    // With one layer there are no surfaces behind the nearest, so no masks are computed.
    assert!(seconds(&nearest, "mask") == 0.0 && seconds(&nearest, "acquire") > 0.0, "{nearest}");
}

#[test]
fn what_cannot_be_done_is_refused_and_leaves_nothing() {
    let folder = TempDir::new().unwrap();
    let says = |more: &str, words: &str| {
        let said = refused(&format!("{LINE} {more}"), folder.path());
        assert!(said.contains(words), "{more}: {said}");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0, "{more}");
    };
    says("--views 4 --baseline 0.3 --view-range 2-4 --null", "the views are 0 to 3");
    says("--views 4 --baseline 0.3 --view-range 1-2 -o q.png", "lightfold quilt");
    says("--views 4 --baseline 0.3 --quilt 1x2 -o q.png", "4 views");
    says("--views 4 --baseline 0.3 -o q_qs3x3a0.75.png --quilt 2x2", "3x3");
    says("--views 4 --baseline 0.3 -o views", ".png or .exr");
    says("--views 4 --baseline 0.3 --quilt 2x2 -o v.%04d.png", "--quilt");
    says("--views 4 --baseline 0.3 --memory 1k --null", "memory");
    says("--views 4 --baseline 0.3 --up 2,-0.1,0 --null", "up direction");
    says("--views 4 --view-cone 180 --focus 1 --null", "180");
    refused(&format!("{LINE} --views 0 --baseline 0.3 --null"), folder.path());
}

/// The camera that `capture` uses for a view has the same rays as the view.
#[test]
fn cameras_of_views_see_what_views_see() {
    let views = views(3, Spread::Baseline(0.5), 1.5);
    for &offset_m in &views.offsets_m {
        let timed = TimedCamera { camera: views.camera(offset_m).unwrap(), frames: None };
        let from = views.viewpoint(offset_m);
        let direction = from.turned(from.projection.unproject([10.5, 7.5])).normalize();
        let expected = timed.camera.direction([10.5 / 112.0, 7.5 / 80.0]);
        assert!((direction - expected).length() < 1e-12, "{direction} {expected}");
    }
}

#[test]
fn captured_images_are_source_views_and_come_out_as_they_were() {
    let folder = TempDir::new().unwrap();
    let at = folder.path();
    fine(
        "capture interior --position=-0.2,1.5,0 --position=0.2,1.5,0 --position=0.2,1.6,0.3 --size 32 --samples 1 --frames 0 -o room",
        at,
    );
    fine("interpolate room --probe 00,01 --face nz --views 5 --holes blank -o v/%02d.exr", at);
    let view = |number: u32| exr::read_rgba(&at.join(format!("v/{number:02}.exr")), &ReadLimits::default()).unwrap();
    // Looking along -Z, +X is on the right. Cube faces are stored mirrored.
    for (number, probe) in [(0, "00"), (4, "01")] {
        let path = at.join(format!("room/probe_{probe}/face_nz/color.0000.exr"));
        let face = exr::read_rgba(&path, &ReadLimits::default()).unwrap();
        let mirrored = Plane::from_fn(32, 32, |x, y| face.get(31 - x, y));
        assert_eq!(view(number), mirrored, "view {number}");
    }
    // A container of the dataset has the same views, with its decoded values.
    fine("encode room --clip -o room.lfold --max-error 0 -q", at);
    fine("interpolate room.lfold --probe 01,00 --face nz --views 5 -o q.png", at);
    let says = |more: &str, words: &str| {
        let said = refused(&format!("interpolate room --views 5 --null {more}"), at);
        assert!(said.contains(words), "{more}: {said}");
    };
    let said = fine("interpolate room --probe 00 --face nz --views 3 --null", at).stderr;
    assert!(String::from_utf8_lossy(&said).contains("all views are equal"));
    says("--probe 00,02 --face nz", "off the line");
    says("--probe 00,01 --face px", "off the line");
    says("--probe 00,07 --face nz", "the probes are 00, 01, 02");
    says("--probe 00,01 --face nz --holes trace", "needs a scene");
    says("--probe 00,01 --face nz --compare", "--probe");
    says("", "--eye");
}
