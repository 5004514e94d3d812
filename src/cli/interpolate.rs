//! `lightfold interpolate SCENE`: many views side by side from few source views.

mod args;
mod device;
mod outputs;
mod quality;
mod report;

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use crate::cli::progress::Progress;
use crate::cli::{ExitStatus, GlobalArgs, output, refuse};
use crate::epipolar::acquire::Acquisition;
use crate::epipolar::brute_force;
use crate::epipolar::captured::CapturedSources;
use crate::epipolar::fill::Truth;
use crate::epipolar::memory;
use crate::epipolar::pipeline::{Picture, Request, Summary, between, interpolate};
use crate::epipolar::views::OutputViews;
use crate::error::Result;
use crate::evaluate::RenderedImage;
use crate::evaluate::reference::Reference;
use crate::image::Plane;
use crate::memory::Need;
use crate::monitor::Monitor;
use crate::scene::{Play, Scene, SceneAtTime};

pub use args::Args;
use device::Device;
use outputs::Outputs;
use quality::Quality;
use report::{Measured, Report};

/// Views that are interpolated together, where memory allows.
const VIEWS_AT_ONCE: usize = 32;

pub fn run(args: &Args, global: &GlobalArgs) -> Result<ExitStatus> {
    args.check_device()?;
    let loading = Instant::now();
    let mut notes = Vec::new();
    let input = Input::open(args, &mut notes)?;
    let views = match &input {
        Input::Scene(_) => args.views_of_scene()?,
        Input::Captured(captured) => args.views_between(captured)?,
    };
    let range = args.range()?;
    let outputs = args.output.as_deref().map(|path| Outputs::open(path, args, &views, &mut notes)).transpose()?;
    notes.iter().for_each(|note| global.note(note));
    let [sources, each] = match &input {
        Input::Scene(_) => memory::bytes(&views, args.acquire, args.max_sources as usize),
        Input::Captured(captured) => memory::bytes(&views, Acquisition::Hierarchical, captured.sources.len()),
    };
    let need = Need { what: "interpolating", fixed: sources, each, instead: "smaller views" };
    let views_at_once = args.memory.get().at_once(&need, VIEWS_AT_ONCE.min(range.len()))?;
    let settings = args.settings(views_at_once)?;
    let mut measured =
        Measured { load: loading.elapsed(), memory_model_bytes: need.bytes(views_at_once), ..Measured::default() };
    let gpu = args.gpu.open(args.device, global)?;
    let device = Device::new(gpu.as_ref(), args.device, global);
    let request = Request { views: &views, range: range.clone(), settings: &settings, backend: &device };
    let casts = args.brute_force || args.compare;
    let steps = if args.brute_force { 0 } else { request.steps() };
    let steps = steps + if casts { range.len() as u64 } else { 0 };
    let progress = Progress::start(global, "interpolating", steps)?;
    let scene = match &input {
        Input::Scene(scene) => Some(Truth { scene, samples: &settings.acquire.samples }),
        Input::Captured(_) => None,
    };
    let mut run = Run { args, scene, views: &views, outputs, measured: &mut measured };
    let summary = match &input {
        Input::Scene(_) if args.brute_force => {
            for view in range {
                let picture = run.cast(view, &progress)?;
                run.put(view, &opaque(&picture))?;
            }
            Summary::default()
        }
        Input::Scene(scene) => {
            let take = |view, picture: Picture| run.take(view, &picture, &progress);
            interpolate(scene, &request, &progress, take)?
        }
        Input::Captured(captured) => {
            let take = |view, picture: Picture| run.take(view, &picture, &progress);
            between((&captured.sources, None), &request, &progress, take)?
        }
    };
    let quilt = run.commit()?;
    drop(progress);
    measured.device = device.name();
    let report = Report::new(args, &views, &summary, &measured).with_quilt(quilt);
    global.report(args.json, &report, || report.text())?;
    if args.stats && !args.json {
        output::print_text(&report.stats()?)?;
    }
    if let Some(path) = &args.csv {
        measured.quality.write_csv(path)?;
    }
    Ok(ExitStatus::Passed)
}

/// What source views come from.
enum Input {
    Scene(SceneAtTime),
    Captured(CapturedSources),
}

impl Input {
    fn open(args: &Args, notes: &mut Vec<String>) -> Result<Input> {
        if !args.probe.is_empty() {
            let path = Path::new(&args.input);
            let mut reference = Reference::open(path)?;
            let captured = CapturedSources::read(&mut reference, &args.probe, args.face, args.frame);
            return captured.map(Input::Captured).map_err(|error| error.in_file(path));
        }
        let (scene, of_scene) = Scene::open(&args.input, Play::First)?;
        notes.extend(of_scene);
        Ok(Input::Scene(scene.at(f64::from(args.frame) / args.fps)))
    }
}

/// Takes the pictures of a run.
struct Run<'a> {
    args: &'a Args,
    /// None of captured images.
    scene: Option<Truth<'a>>,
    views: &'a OutputViews,
    outputs: Option<Outputs>,
    measured: &'a mut Measured,
}

impl Run<'_> {
    fn take(&mut self, view: usize, picture: &Picture, progress: &Progress) -> Result<()> {
        if self.args.compare {
            let truth = self.cast(view, progress)?;
            self.measured.quality.add(view, picture, truth)?;
        }
        self.put(view, &picture.filled)
    }

    /// Ray casts a view.
    fn cast(&mut self, view: usize, progress: &Progress) -> Result<Plane<[half::f16; 3]>> {
        let begun = Instant::now();
        let place = (self.views, self.views.offsets_m[view]);
        let Some(Truth { scene, samples }) = self.scene else { return refuse("captured images cannot be ray cast") };
        let color = brute_force::render(scene, place, samples, progress)?;
        self.measured.brute_force += begun.elapsed();
        progress.advance(1);
        Ok(color)
    }

    fn put(&mut self, view: usize, picture: &RenderedImage) -> Result<()> {
        let begun = Instant::now();
        if let Some(outputs) = &mut self.outputs {
            outputs.put(view, picture)?;
        }
        self.measured.write += begun.elapsed();
        Ok(())
    }

    /// Answers the file of a quilt.
    fn commit(&mut self) -> Result<Option<PathBuf>> {
        self.outputs.take().map_or(Ok(None), Outputs::commit)
    }
}

fn opaque(color: &Plane<[half::f16; 3]>) -> RenderedImage {
    RenderedImage {
        color: color.map(|light| light.map(half::f16::to_f32)),
        alpha: Plane::filled(color.width(), color.height(), 1.0),
    }
}

impl Default for Measured {
    fn default() -> Self {
        Measured {
            load: Duration::ZERO,
            write: Duration::ZERO,
            brute_force: Duration::ZERO,
            memory_model_bytes: 0,
            device: String::new(),
            quality: Quality::default(),
        }
    }
}
