//! Time to interpolate views, compared with ray casting each of them, on all threads.
//!
//! `cargo bench --bench interpolate [-- SCENE..]` renders views of each scene, by default of two built-in ones. For 10, 100 and
//! 500 views it prints the speedup over ray casting; then the cost of an additional view relative to a ray-cast view, and the
//! exponent of time over the number of pixels. If there is a GPU, the same views are interpolated on it, the triangles of one
//! source are drawn and read back whole, compacted and by size, and the erosion between two sources is measured. Times are
//! medians over `TURNS` runs, each printed with a PSNR.

use std::hint::black_box;
use std::time::Instant;

use codec::error::{Error, Result};
use codec::image::ToneMap;
use codec::math::{Camera, Lens};
use codec::monitor::Silent;
use epipolar::acquire::{AcquireSettings, acquire};
use epipolar::backend::{Backend, Cpu};
use epipolar::brute_force;
use epipolar::drawing::{MAX_DRAWN, PixelWindow, TriangleDrawing};
use epipolar::erosion::Moves;
use epipolar::fill::HoleFilling;
use epipolar::interpolate::InterpolateSettings;
use epipolar::pipeline::{Request, RowsAtOnce, Settings, interpolate};
use epipolar::view_store::Storage;
use epipolar::views::{OutputViews, Spread};
use evaluate::reference::Truth;
use evaluate::similarity::Similarity;
use gpu::Gpu;
use gpu::device::Pick;
use gpu::epipolar::GpuInterpolator;
use gpu::triangles::{GpuTriangles, Readback};
use scene::capture::SamplePattern;
use scene::{Play, Scene, SceneAtTime};

/// Number of runs of each measurement.
const TURNS: usize = 3;
const SIZE: [u32; 2] = [480, 270];
const COUNTS: [u32; 3] = [10, 100, 500];

fn main() -> Result<()> {
    let mut scenes: Vec<String> = std::env::args().skip(1).filter(|word| !word.starts_with("--")).collect();
    if scenes.is_empty() {
        scenes = ["interior", "courtyard"].map(str::to_owned).into();
    }
    let gpu = Gpu::open(&Pick::Best).ok();
    match &gpu {
        Some(gpu) => println!("the device is {}, {}", gpu.info.name, gpu.info.kind),
        None => println!("there is no graphics device"),
    }
    println!("{:<18}  {:>5}  {:>9}  {:>9}  {:>8}  {:>8}", "", "views", "seconds", "ray cast", "x faster", "PSNR dB");
    for name in scenes {
        let scene = Scene::open(&name, Play::All)?.0.at(0.0);
        measure(&name, &scene, gpu.as_ref())?;
        if let Some(gpu) = &gpu {
            stages(&scene, gpu)?;
        }
    }
    Ok(())
}

/// Prints the milliseconds of stages of the acquisition: erosion on the CPU and on the GPU, and triangles drawn on the GPU.
fn stages(scene: &SceneAtTime, gpu: &Gpu) -> Result<()> {
    let (views, on_device) = (views(2, SIZE)?, GpuInterpolator::new(gpu));
    let (sources, _) = acquire(scene, &views, &AcquireSettings::new(samples()?), (&Cpu, &Silent))?;
    let moves = Moves::between(&views, [&sources[0], &sources[1]]);
    let [on_cpu, on_device] =
        [&Cpu as &dyn Backend, &on_device].map(|backend| seconds(|| backend.eroded(&moves).map(drop)));
    println!("erosion of two sources: {:.2} ms, on the device {:.2} ms", 1e3 * on_cpu?, 1e3 * on_device?);
    if scene.meshes.is_empty() {
        println!();
        return Ok(());
    }
    let (from, window) = (views.viewpoint(0.0), PixelWindow { columns: 0..SIZE[0] as i32, rows: 0..SIZE[1] });
    let draw = |readback: Readback| -> Result<f64> {
        let triangles = GpuTriangles::new(gpu, scene)?.with_readback(readback);
        seconds(|| triangles.draw(&from, &window, [0.5; 2], MAX_DRAWN).map(|layers| drop(black_box(layers))))
    };
    let [whole, compacted, by_size] = [Readback::Whole, Readback::Compacted, Readback::BySize].map(draw);
    println!(
        "layers of triangles: read back whole {:.1} ms, compacted {:.1} ms, by size {:.1} ms\n",
        1e3 * whole?,
        1e3 * compacted?,
        1e3 * by_size?
    );
    Ok(())
}

fn measure(name: &str, scene: &SceneAtTime, gpu: Option<&Gpu>) -> Result<()> {
    let cast = seconds(|| {
        let views = views(1, SIZE)?;
        black_box(brute_force::render(scene, (&views, 0.0), &samples()?, &Silent)?);
        Ok(())
    })?;
    let mut of_count = Vec::new();
    let row = |label: &str, count: u32, backend: &dyn Backend| -> Result<f64> {
        let seconds = interpolated((scene, backend), &views(count, SIZE)?)?;
        let all = cast * f64::from(count);
        let psnr_db = psnr_db((scene, backend), &views(count, SIZE)?)?;
        println!("{label:<18}  {count:>5}  {seconds:>9.3}  {all:>9.3}  {:>8.1}  {psnr_db:>8.2}", all / seconds);
        Ok(seconds)
    };
    for count in COUNTS {
        of_count.push(row(name, count, &Cpu)?);
    }
    if let Some(gpu) = gpu {
        for count in COUNTS {
            row(&format!("{name}, device"), count, &GpuInterpolator::new(gpu))?;
        }
    }
    let slope = (of_count[2] - of_count[1]) / f64::from(COUNTS[2] - COUNTS[1]);
    let small = interpolated((scene, &Cpu), &views(100, SIZE.map(|side| side / 2))?)?;
    println!(
        "a further view costs {:.3} of one that is ray cast; time grows with the {:.2}th power of pixels\n",
        slope / cast,
        (of_count[1] / small).ln() / 4f64.ln()
    );
    Ok(())
}

fn samples() -> Result<SamplePattern> {
    SamplePattern::new(4)
}

fn views(count: u32, size: [u32; 2]) -> Result<OutputViews> {
    let camera =
        Camera::look_at([-0.6, 1.7, -0.4].into(), [3.0, 1.5, 0.0].into(), [0.0, 1.0, 0.0].into(), Lens::new(60.0))?;
    let camera = camera.with_aspect(f64::from(size[0]) / f64::from(size[1]));
    OutputViews::new(camera, size, count, Spread::Baseline(0.5), f64::INFINITY)
}

fn settings() -> Result<Settings> {
    Ok(Settings {
        acquire: AcquireSettings::new(samples()?),
        interpolate: InterpolateSettings::default(),
        holes: HoleFilling::Trace,
        at_once: RowsAtOnce { acquired: 64, interpolated: 32 },
        storage: Storage::Memory,
        keeps_unfilled: true,
    })
}

fn interpolated((scene, backend): (&SceneAtTime, &dyn Backend), views: &OutputViews) -> Result<f64> {
    let settings = settings()?;
    seconds(|| {
        interpolate(scene, &Request { backend, ..Request::all(views, &settings) }, &Silent, |_, picture| {
            black_box(picture);
            Ok(())
        })
        .map(drop)
    })
}

/// Returns the PSNR over ten of the views.
fn psnr_db((scene, backend): (&SceneAtTime, &dyn Backend), views: &OutputViews) -> Result<f64> {
    let (settings, mut sum) = (settings()?, Similarity::empty());
    let step = views.count() as usize / 10;
    interpolate(scene, &Request { backend, ..Request::all(views, &settings) }, &Silent, |view, picture| {
        if view % step != step / 2 {
            return Ok(());
        }
        let color = brute_force::render(scene, (views, views.offsets_m[view]), &settings.acquire.samples, &Silent)?;
        sum.merge(&Similarity::of(&picture.filled, &Truth { color, material: None }, ToneMap::default())?)
    })?;
    Ok(sum.all.psnr_db())
}

/// Returns the median seconds of `TURNS` runs.
fn seconds(mut work: impl FnMut() -> Result<()>) -> Result<f64> {
    let mut turns = Vec::new();
    for _ in 0..TURNS {
        let start = Instant::now();
        work()?;
        turns.push(start.elapsed().as_secs_f64());
    }
    turns.sort_by(f64::total_cmp);
    turns.get(TURNS / 2).copied().ok_or_else(|| Error::invalid("a measurement without turns"))
}
