//! `lightfold interpolate INPUT`: many views side by side from few source views.

mod args;
mod input;
mod light_field;
mod outputs;
mod quality;
mod report;

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use half::f16;

use crate::cli::progress::Progress;
use crate::cli::{ExitStatus, GlobalArgs, output, outputs as output_paths};
use crate::dataset::{CameraSet, PlacedCamera};
use crate::epipolar::acquire::Acquisition;
use crate::epipolar::brute_force;
use crate::epipolar::fill::Truth;
use crate::epipolar::memory;
use crate::epipolar::pipeline::{self, Picture, Settings, Summary, between, interpolate};
use crate::epipolar::views::OutputViews;
use crate::error::Result;
use crate::evaluate::RenderedImage;
use crate::image::Plane;
use crate::memory::Need;
use crate::monitor::Monitor;

pub use args::Args;
use input::{FrameInput, Input};
use outputs::Outputs;
use quality::Quality;
use report::{Measured, Report};

/// Views that are interpolated together, where memory allows.
const VIEWS_AT_ONCE: usize = 32;

pub fn run(args: &Args, global: &GlobalArgs) -> Result<ExitStatus> {
    let loading = Instant::now();
    args.check()?;
    let mut notes = Vec::new();
    let mut input = Input::open(args, &mut notes)?;
    let views = input.views(args)?;
    let rows = args.rows_of(&views)?;
    args.check_outputs()?;
    let outputs = args.output.as_deref().map(|path| Outputs::open(path, args, &views, &mut notes)).transpose()?;
    notes.iter().for_each(|note| global.note(note));
    let (range, frames) = (args.range()?, args.frame_range());
    let [sources, each] = match &input {
        Input::Scene(_) => memory::bytes(&views, args.acquire, args.max_sources as usize),
        Input::Images(_) => memory::bytes(&views, Acquisition::Hierarchical, args.probe.len()),
        Input::Field(_) => memory::bytes(&views, Acquisition::Hierarchical, args.max_sources as usize),
    };
    let need = Need { what: "interpolating", fixed: sources, each, instead: "smaller views" };
    let views_at_once = args.memory.get().at_once(&need, VIEWS_AT_ONCE.min(args.views as usize))?;
    let mut settings = args.settings(views_at_once, matches!(input, Input::Scene(_)))?;
    let mut measured = Measured {
        load: loading.elapsed(),
        memory_model_bytes: need.bytes(views_at_once),
        quality: Quality::new(args.error_map.as_deref())?,
        ..Measured::default()
    };
    let mut steps = 0;
    for (row, _) in rows.iter().enumerate() {
        let count = of_row(&range, row, &views).len();
        let interpolated = if args.brute_force { 0 } else { pipeline::steps(&views, count, &settings) };
        steps += interpolated + if args.brute_force || args.compare { count as u64 } else { 0 };
    }
    let progress = Progress::start(global, "interpolating", frames.count() * steps)?;
    let mut run = Run { args, progress: &progress, outputs, measured: &mut measured, frame: frames.first };
    let mut summary = Summary::default();
    for frame in frames.iter() {
        run.frame = frame;
        let begun = Instant::now();
        let now = input.frame(args, frame)?;
        run.measured.load += begun.elapsed();
        let mut of_frame = Summary::default();
        for (row, views) in rows.iter().enumerate() {
            let range = of_row(&range, row, views);
            let first = row * views.count() as usize;
            of_frame.add(run.row(&now, (views, range), first, &settings)?);
        }
        if let Some(reduction) = args.reduce_layers {
            let pixels = range.len() as u64 * views.size.map(u64::from).iter().product::<u64>();
            let layers = &mut settings.acquire.layers;
            *layers = reduction.next(*layers, args.layers as usize, of_frame.counters.pixels_by_layer, pixels);
        }
        summary.add(of_frame);
    }
    let one_frame = (frames.count() == 1).then_some(frames.first);
    let quilt = run.outputs.take().map_or(Ok(None), |outputs| outputs.commit(one_frame));
    let quilt = quilt.map_err(|error| output::name_output(error, args.output.as_deref().unwrap_or(Path::new("-"))))?;
    measured.quality.commit()?;
    drop(progress);
    if let Some(path) = &args.cameras_out {
        output::write_file(path, &cameras(&rows)?.to_json()?)?;
    }
    if let Some(path) = &args.csv {
        output::write_file(path, &measured.quality.csv())?;
    }
    let report = Report::new(args, &views, &summary, &measured).with_quilt(quilt);
    global.report(args.json, &report, || report.text())?;
    if args.stats && !args.json {
        output::print_text(&report.stats()?)?;
    }
    Ok(ExitStatus::Passed)
}

/// Views of a row among those that are asked for, which are counted row by row.
fn of_row(range: &std::ops::Range<usize>, row: usize, views: &OutputViews) -> std::ops::Range<usize> {
    let count = views.count() as usize;
    let in_row = |at: usize| at.clamp(row * count, (row + 1) * count) - row * count;
    in_row(range.start)..in_row(range.end)
}

/// The cameras of all views, for `capture`.
fn cameras(rows: &[OutputViews]) -> Result<CameraSet> {
    let mut cameras = Vec::new();
    for views in rows {
        for &offset_m in &views.offsets_m {
            let camera = views.camera(offset_m)?;
            let (window, half) = (camera.window(), camera.half());
            let shift = [(window.u, half[0]), (window.v, half[1])].map(|([from, to], half)| 0.25 * (from + to) / half);
            cameras.push(PlacedCamera {
                name: Some(format!("{:04}", cameras.len())),
                orientation: camera.orientation(),
                fov_y_deg: Some(2.0 * half[1].atan().to_degrees()),
                shift: (shift != [0.0; 2]).then_some(shift),
                ..PlacedCamera::at(camera.eye().to_array())
            });
        }
    }
    Ok(CameraSet::new(cameras))
}

/// Takes the pictures of a run.
struct Run<'a> {
    args: &'a Args,
    progress: &'a Progress,
    outputs: Option<Outputs>,
    measured: &'a mut Measured,
    frame: u32,
}

/// Renders a view without interpolation.
type Cast<'a> = dyn Fn(usize) -> Result<RenderedImage> + 'a;

impl Run<'_> {
    /// Some views of a row, whose first one has this number.
    fn row(
        &mut self,
        now: &FrameInput<'_>,
        (views, range): (&OutputViews, std::ops::Range<usize>),
        first: usize,
        settings: &Settings,
    ) -> Result<Summary> {
        let progress = self.progress;
        match now {
            FrameInput::Scene(scene) => {
                let samples = &settings.acquire.samples;
                let cast = |view: usize| {
                    let color = brute_force::render(scene, (views, views.offsets_m[view]), samples, progress)?;
                    Ok(opaque(&color))
                };
                if self.args.brute_force {
                    return self.cast_all(range, first, &cast);
                }
                let take = |view, picture: Picture| self.take((view, first), &picture, Some(&cast));
                interpolate(scene, (views, range), settings, progress, take)
            }
            FrameInput::Images(images) => {
                let take = |view, picture: Picture| self.take((view, first), &picture, None);
                between((&images.sources, None::<Truth<'_>>), (views, range), settings, progress, take)
            }
            FrameInput::Field(field) => {
                if let Some(outputs) = &mut self.outputs {
                    outputs.set_tone(field.tone());
                }
                let cast = |view: usize| field.picture(views, views.offsets_m[view], progress);
                if self.args.brute_force {
                    return self.cast_all(range, first, &cast);
                }
                let begun = Instant::now();
                let (sources, counters) = field.sources(views, self.args, progress)?;
                let acquired = begun.elapsed();
                let take = |view, picture: Picture| self.take((view, first), &picture, Some(&cast));
                let mut summary = between((&sources, None), (views, range), settings, progress, take)?;
                summary.stages.acquire += acquired;
                summary.counters.add(&counters);
                Ok(summary)
            }
        }
    }

    fn cast_all(&mut self, range: std::ops::Range<usize>, first: usize, cast: &Cast<'_>) -> Result<Summary> {
        for view in range {
            let picture = self.cast(view, cast)?;
            self.put(first + view, &picture)?;
        }
        Ok(Summary::default())
    }

    /// A picture by its place in its row, and the number of the first view there.
    fn take(&mut self, (view, first): (usize, usize), picture: &Picture, cast: Option<&Cast<'_>>) -> Result<()> {
        if let Some(cast) = cast.filter(|_| self.args.compare) {
            let truth = self.cast(view, cast)?;
            self.measured.quality.add(
                (self.frame, first + view),
                picture,
                truth.color.map(|light| light.map(f16::from_f32)),
            )?;
        }
        self.put(first + view, &picture.filled)
    }

    fn cast(&mut self, view: usize, cast: &Cast<'_>) -> Result<RenderedImage> {
        let begun = Instant::now();
        let picture = cast(view)?;
        self.measured.brute_force += begun.elapsed();
        self.progress.advance(1);
        Ok(picture)
    }

    fn put(&mut self, view: usize, picture: &RenderedImage) -> Result<()> {
        let begun = Instant::now();
        if let Some(outputs) = &mut self.outputs {
            outputs.put((self.frame, view), picture)?;
        }
        self.measured.write += begun.elapsed();
        Ok(())
    }
}

fn opaque(color: &Plane<[f16; 3]>) -> RenderedImage {
    RenderedImage {
        color: color.map(|light| light.map(f16::to_f32)),
        alpha: Plane::filled(color.width(), color.height(), 1.0),
    }
}

impl Args {
    /// Refuses outputs that are inputs or each other.
    fn check_outputs(&self) -> Result<()> {
        let named = [("-o", &self.output), ("--csv", &self.csv), ("--cameras-out", &self.cameras_out)];
        let outputs: Vec<output_paths::Output> =
            named.into_iter().filter_map(|(option, path)| Some((option, path.clone()?))).collect();
        output_paths::check(&outputs, &[PathBuf::from(&self.input).as_path()])
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
