//! `lightfold interpolate SCENE`: many views side by side from few source views.

mod args;
mod quality;
mod report;

use std::path::Path;
use std::time::{Duration, Instant};

use crate::cli::progress::Progress;
use crate::cli::{ExitStatus, GlobalArgs, output, refuse};
use crate::decode::FileFormat;
use crate::epipolar::brute_force;
use crate::epipolar::memory;
use crate::epipolar::pipeline::{self, Picture, Summary, interpolate};
use crate::epipolar::views::OutputViews;
use crate::error::{Error, Result};
use crate::evaluate::RenderedImage;
use crate::evaluate::rendered_image::HoleFill;
use crate::files::OutputFolder;
use crate::image::{Pattern, Plane, ToneMap, exr, png};
use crate::memory::Need;
use crate::monitor::Monitor;
use crate::scene::capture::SamplePattern;
use crate::scene::{Play, Scene, SceneAtTime};

pub use args::Args;
use quality::Quality;
use report::{Measured, Report};

/// Views that are interpolated together, where memory allows.
const VIEWS_AT_ONCE: usize = 32;

pub fn run(args: &Args, global: &GlobalArgs) -> Result<ExitStatus> {
    let views = args.output_views()?;
    let range = args.range()?;
    let outputs = args.output.as_deref().map(|path| Outputs::open(path, range.len())).transpose()?;
    let [sources, each] = memory::bytes(&views, args.acquire, args.max_sources as usize);
    let need = Need { what: "interpolating", fixed: sources, each, instead: "smaller views" };
    let views_at_once = args.memory.get().at_once(&need, VIEWS_AT_ONCE.min(range.len()))?;
    let settings = args.settings(views_at_once)?;
    let loading = Instant::now();
    let (scene, notes) = Scene::open(&args.input, Play::First)?;
    notes.iter().for_each(|note| global.note(note));
    let scene = scene.at(f64::from(args.frame) / args.fps);
    let mut measured =
        Measured { load: loading.elapsed(), memory_model_bytes: need.bytes(views_at_once), ..Measured::default() };
    let casts = args.brute_force || args.compare;
    let steps = if args.brute_force { 0 } else { pipeline::steps(&views, &settings) };
    let steps = steps + if casts { range.len() as u64 } else { 0 };
    let progress = Progress::start(global, "interpolating", steps)?;
    let mut run = Run {
        args,
        scene: &scene,
        views: &views,
        samples: &settings.acquire.samples,
        outputs,
        measured: &mut measured,
    };
    let summary = if args.brute_force {
        for view in range.clone() {
            let picture = run.cast(view, &progress)?;
            run.put(view, &opaque(&picture))?;
        }
        Summary::default()
    } else {
        interpolate(&scene, (&views, range.clone()), &settings, &progress, |view, picture| {
            run.take(view, &picture, &progress)
        })?
    };
    run.commit()?;
    drop(progress);
    let report = Report::new(args, &views, range.len(), &summary, &measured);
    global.report(args.json, &report, || report.text())?;
    if args.stats && !args.json {
        output::print_text(&report.stats()?)?;
    }
    if let Some(path) = &args.csv {
        measured.quality.write_csv(path)?;
    }
    Ok(ExitStatus::Passed)
}

/// Takes the pictures of a run.
struct Run<'a> {
    args: &'a Args,
    scene: &'a SceneAtTime,
    views: &'a OutputViews,
    samples: &'a SamplePattern,
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
        let color = brute_force::render(self.scene, place, self.samples, progress)?;
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

    fn commit(&mut self) -> Result<()> {
        self.outputs.take().map_or(Ok(()), |outputs| outputs.folder.commit())
    }
}

fn opaque(color: &Plane<[half::f16; 3]>) -> RenderedImage {
    RenderedImage {
        color: color.map(|light| light.map(half::f16::to_f32)),
        alpha: Plane::filled(color.width(), color.height(), 1.0),
    }
}

/// Files of the pictures.
struct Outputs {
    pattern: Pattern,
    format: FileFormat,
    folder: OutputFolder,
}

impl Outputs {
    fn open(path: &Path, count: usize) -> Result<Outputs> {
        let Some(format) = FileFormat::of(path) else {
            return refuse(format!("{}: file names ending in .png or .exr were expected", path.display()));
        };
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let pattern = Pattern::parse(&name).map_err(|error| error.in_file(path))?;
        if !pattern.has_field() && count != 1 {
            return refuse(format!(
                "{}: one file, and {count} views; name a pattern such as views/%04d.png",
                path.display()
            ));
        }
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        Ok(Outputs { pattern, format, folder: OutputFolder::create(folder)? })
    }

    fn put(&mut self, view: usize, picture: &RenderedImage) -> Result<()> {
        let path = self.folder.work_path().join(self.pattern.path(view as u32));
        let written = match self.format {
            FileFormat::Png => png::write_rgba8(&path, &picture.rgba_codes(ToneMap::default())),
            FileFormat::Exr => exr::write_rgba(&path, &picture.rgba_light(HoleFill::Blank)),
        };
        written.map_err(|error: Error| self.folder.present(error))
    }
}

impl Default for Measured {
    fn default() -> Self {
        Measured {
            load: Duration::ZERO,
            write: Duration::ZERO,
            brute_force: Duration::ZERO,
            memory_model_bytes: 0,
            quality: Quality::default(),
        }
    }
}
