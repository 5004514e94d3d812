//! Times of interpolated views beside ray casting each of them, on all threads.
//!
//! `cargo bench --bench interpolate [-- SCENE..]` renders views of each scene, and without one of built-in ones: for 10, 100 and 500
//! views the times that ray casting takes longer, what a further view costs of one that is ray cast, and the exponent of time over
//! pixels. Medians of the turns; a PSNR stands beside each time.

use std::hint::black_box;
use std::time::Instant;

use lightfold::epipolar::acquire::AcquireSettings;
use lightfold::epipolar::brute_force;
use lightfold::epipolar::fill::HoleFilling;
use lightfold::epipolar::interpolate::InterpolateSettings;
use lightfold::epipolar::pipeline::{Request, RowsAtOnce, Settings, interpolate};
use lightfold::epipolar::view_store::Storage;
use lightfold::epipolar::views::{OutputViews, Spread};
use lightfold::error::{Error, Result};
use lightfold::evaluate::reference::Truth;
use lightfold::evaluate::similarity::Similarity;
use lightfold::image::ToneMap;
use lightfold::math::{Camera, Lens};
use lightfold::monitor::Silent;
use lightfold::scene::capture::SamplePattern;
use lightfold::scene::{Play, Scene, SceneAtTime};

/// Turns of each measurement.
const TURNS: usize = 3;
const SIZE: [u32; 2] = [480, 270];
const COUNTS: [u32; 3] = [10, 100, 500];

fn main() -> Result<()> {
    let mut scenes: Vec<String> = std::env::args().skip(1).filter(|word| !word.starts_with("--")).collect();
    if scenes.is_empty() {
        scenes = ["interior", "courtyard"].map(str::to_owned).into();
    }
    println!("{:<12}  {:>5}  {:>9}  {:>9}  {:>8}  {:>8}", "", "views", "seconds", "ray cast", "x faster", "PSNR dB");
    for name in scenes {
        let scene = Scene::open(&name, Play::First)?.0.at(0.0);
        measure(&name, &scene)?;
    }
    Ok(())
}

fn measure(name: &str, scene: &SceneAtTime) -> Result<()> {
    let cast = seconds(|| {
        let views = views(1, SIZE)?;
        black_box(brute_force::render(scene, (&views, 0.0), &samples()?, &Silent)?);
        Ok(())
    })?;
    let mut of_count = Vec::new();
    for count in COUNTS {
        let seconds = interpolated(scene, &views(count, SIZE)?)?;
        let all = cast * f64::from(count);
        let psnr_db = psnr_db(scene, &views(count, SIZE)?)?;
        println!("{name:<12}  {count:>5}  {seconds:>9.3}  {all:>9.3}  {:>8.1}  {psnr_db:>8.2}", all / seconds);
        of_count.push(seconds);
    }
    let slope = (of_count[2] - of_count[1]) / f64::from(COUNTS[2] - COUNTS[1]);
    let small = interpolated(scene, &views(100, SIZE.map(|side| side / 2))?)?;
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

fn interpolated(scene: &SceneAtTime, views: &OutputViews) -> Result<f64> {
    let settings = settings()?;
    seconds(|| {
        interpolate(scene, &Request::all(views, &settings), &Silent, |_, picture| {
            black_box(picture);
            Ok(())
        })
        .map(drop)
    })
}

/// Over ten of the views.
fn psnr_db(scene: &SceneAtTime, views: &OutputViews) -> Result<f64> {
    let (settings, mut sum) = (settings()?, Similarity::empty());
    let step = views.count() as usize / 10;
    interpolate(scene, &Request::all(views, &settings), &Silent, |view, picture| {
        if view % step != step / 2 {
            return Ok(());
        }
        let color = brute_force::render(scene, (views, views.offsets_m[view]), &settings.acquire.samples, &Silent)?;
        sum.merge(&Similarity::of(&picture.filled, &Truth { color, material: None }, ToneMap::default())?)
    })?;
    Ok(sum.all.psnr_db())
}

/// Seconds of the middle turn.
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
