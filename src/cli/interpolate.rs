//! `lightfold interpolate INPUT`: interpolates many views on a line or grid from few source views.

mod args;
mod device;
mod input;
mod outputs;
mod report;

use std::ops::Range;
use std::path::{Path, PathBuf};
use std::time::Instant;

use half::f16;

use crate::output::{self, TextFile};
use crate::progress::Progress;
use crate::report::interpolation::Quality;
use crate::report::machine;
use crate::{ExitStatus, GlobalArgs, outputs as output_paths, refuse};
use codec::error::Result;
use codec::image::{FrameRange, Pattern};
use codec::monitor::Monitor;
use epipolar::brute_force;
use epipolar::drawing::{DrawnScene, TriangleDrawing};
use epipolar::fill::Truth;
use epipolar::grid::{self, GridViews, interpolate_grid};
use epipolar::memory::{self, Limits};
use epipolar::pipeline::{Picture, Request, Settings, Summary, between, interpolate};
use epipolar::views::OutputViews;
use evaluate::camera_file::placed;
use footage::dataset::{CameraSet, PlacedCamera};
use footage::fingerprint::{Fingerprint, digest};
use render::rendered_image::RenderedImage;
use scene::capture::SamplePattern;

pub use args::Args;
use device::Device;
use input::{FrameInput, Input};
use outputs::Outputs;
use report::{Measured, Report};

pub fn run(args: &Args, global: &GlobalArgs) -> Result<ExitStatus> {
    let loading = Instant::now();
    args.check()?;
    args.check_device()?;
    let mut notes = Vec::new();
    let mut input = Input::open(args, &mut notes)?;
    let frames = input.frames(args, &mut notes)?;
    let views = input.views(args, frames.first)?;
    if matches!(input, Input::Images(_)) && views.baseline_m() == 0.0 && args.views > 1 {
        notes.push(
            "the source views have the same position, so all views are equal: choose probes side by side, or set \
            --baseline"
                .into(),
        );
    }
    notes.extend(input.views_beyond_probes(&views, frames.first));
    let range = args.range()?;
    input.check_frames(args, frames)?;
    args.check_outputs(&input)?;
    // From this point a stop is handled, and leaves no unfinished files.
    let progress = Progress::start(global, "interpolating", 0)?;
    let texts = TextOutputs::create(args)?;
    let outputs = args.output.as_deref().map(|path| Outputs::open(path, args, &views, &mut notes)).transpose()?;
    notes.iter().for_each(|note| global.note(note));
    if args.rasterize && !matches!(input, Input::Scene(_)) {
        return refuse("--rasterize needs a scene: leave it out for containers and captured images");
    }
    let by_columns = args.by_columns() && matches!(input, Input::Scene(_));
    let (loaded, need) = input.need(args, &views, &args.acquire_settings()?, &progress)?;
    let grid = args.grid_of(views);
    // Number of views that are interpolated together.
    let count = match by_columns {
        _ if args.brute_force => 1,
        true => args.rows as usize,
        false => (0..grid.ups_m.len()).map(|row| grid.in_row(&range, row).len()).max().unwrap_or(0),
    };
    let folder = folder_of_views(args.output.as_deref());
    let held = loaded.bytes + pictures_bytes(args, &grid.row, outputs.as_ref());
    let (budget, threads) = (args.memory.whole(), rayon::current_num_threads());
    let limits = Limits { budget, held, freed: loaded.freed, threads, folder: &folder };
    let plan = memory::plan(&grid.row, count, need, &limits)?;
    let mut measured = Measured {
        load: loading.elapsed(),
        // Loading may have used more memory.
        memory_model_bytes: plan.bytes.max(machine::peak_memory_bytes().unwrap_or(0)),
        quality: Quality::new(args.error_map.as_deref())?,
        ..Measured::default()
    };
    let settings = args.settings(plan, matches!(input, Input::Scene(_)))?;
    let gpu = args.gpu.open(args.device, global)?;
    progress.check()?;
    let device = Device::new(gpu.as_ref(), args, global);
    let steps_of = |row: usize| {
        let wanted = runs(grid.in_row(&range, row));
        Request { views: &grid.row, wanted, settings: &settings, backend: &device }.steps()
    };
    let interpolated = match by_columns {
        _ if args.brute_force => 0,
        true => grid::steps(&grid),
        false => (0..grid.ups_m.len()).map(steps_of).sum(),
    };
    let steps = interpolated + if args.brute_force || args.compare { range.len() as u64 } else { 0 };
    progress.set_steps(frames.count() * steps);
    let all = (frames.count(), range.len() as u64);
    let mut run =
        Run { args, progress: &progress, device: &device, outputs, measured: &mut measured, frame: frames.first };
    if let Some(outputs) = &mut run.outputs {
        outputs.begin(&fingerprint(args, &input, &grid, (&settings, &device)), all, (args.resume, global))?;
    }
    let summary = run.all_frames(&mut input, (&grid, frames), settings).map_err(|error| match &mut run.outputs {
        Some(outputs) => outputs.stopped(error, all),
        None => error,
    })?;
    let one_frame = (frames.count() == 1).then_some(frames.first);
    let quilt = run.outputs.take().map_or(Ok(None), |outputs| outputs.commit(one_frame));
    let quilt = quilt.map_err(|error| output::name_output(error, args.output.as_deref().unwrap_or(Path::new("-"))))?;
    measured.quality.commit()?;
    drop(progress);
    measured.device = device.name();
    texts.write(&grid, &measured.quality)?;
    let report = Report::new(args, &grid.row, &summary, &measured).with_quilt(quilt);
    global.report(args.json, &report, || report.text())?;
    if args.stats && !args.json {
        output::print_text(&report.stats()?)?;
    }
    Ok(ExitStatus::Passed)
}

/// Text files that are written at the end.
struct TextOutputs<'a> {
    cameras: Option<TextFile<'a>>,
    csv: Option<TextFile<'a>>,
}

impl TextOutputs<'_> {
    fn create(args: &Args) -> Result<TextOutputs<'_>> {
        let [cameras, csv] =
            [&args.cameras_out, &args.csv].map(|path| path.as_deref().map(TextFile::create).transpose());
        Ok(TextOutputs { cameras: cameras?, csv: csv? })
    }

    fn write(self, grid: &GridViews, quality: &Quality) -> Result<()> {
        if let Some(file) = self.cameras {
            file.write(&cameras(grid)?.to_json()?)?;
        }
        self.csv.map_or(Ok(()), |file| file.write(&quality.csv()))
    }
}

/// Returns the range as the only run of views. Empty if the range is empty.
fn runs(range: Range<usize>) -> Vec<Range<usize>> {
    Some(range).filter(|range| !range.is_empty()).into_iter().collect()
}

/// Returns the folder of the outputs, or its nearest existing parent. Without outputs, the folder for temporary files.
fn folder_of_views(output: Option<&Path>) -> PathBuf {
    let folders = output.into_iter().flat_map(|path| path.ancestors().skip(1));
    let named = folders.map(|folder| if folder.as_os_str().is_empty() { Path::new(".") } else { folder });
    named.into_iter().find(|folder| folder.is_dir()).map_or_else(std::env::temp_dir, Path::to_owned)
}

/// Bytes of a quilt, and of pictures that are compared.
fn pictures_bytes(args: &Args, views: &OutputViews, outputs: Option<&Outputs>) -> u64 {
    let pixels = views.size.map(u64::from).iter().product::<u64>();
    let of_quilt = outputs.map_or(0, Outputs::quilt_pixel_bytes) * u64::from(args.views * args.rows);
    // The two pictures and the reference in single precision, and their codes.
    let compared = if args.compare { 3 * 20 } else { 0 };
    pixels * (of_quilt + compared)
}

/// Returns everything that the pictures depend on.
fn fingerprint(
    args: &Args,
    input: &Input,
    grid: &GridViews,
    (settings, device): (&Settings, &Device<'_>),
) -> Fingerprint {
    let (acquire, interpolate, holes) = (&settings.acquire, &settings.interpolate, settings.holes);
    let scene = (args.subdivide, args.ao_rays, args.shadows, args.fps, args.rasterize, args.quilt);
    let mut fields = Fingerprint::of_program(&[
        codec::SOURCES,
        footage::SOURCES,
        scene::SOURCES,
        render::SOURCES,
        evaluate::SOURCES,
        epipolar::SOURCES,
        kernels::SOURCES,
        gpu::SOURCES,
    ]);
    fields.extend(args.options());
    fields.push((
        "the set of options",
        digest(format!("{acquire:?} {interpolate:?} {holes:?} {scene:?} {}", args.brute_force).as_bytes()),
    ));
    fields.push((
        "the list of views",
        digest(format!("{grid:?} {:?} {:?} {:?}", args.grid, args.view_range, args.frames.frames).as_bytes()),
    ));
    // Rasterisers differ at edges.
    fields.push(("the device", device.name()));
    fields.push(("`output`", args.output.as_deref().map_or(String::new(), |path| path.display().to_string())));
    fields.push(("the input", input.contents(args)));
    Fingerprint(fields.into_iter().map(|(name, value)| (name.to_owned(), value)).collect())
}

/// Returns the cameras of all views.
fn cameras(grid: &GridViews) -> Result<CameraSet> {
    let mut cameras = Vec::new();
    for row in 0..grid.ups_m.len() {
        let views = grid.views_of(row)?;
        for &offset_m in &views.offsets_m {
            let name = Some(format!("{:04}", cameras.len()));
            cameras.push(PlacedCamera { name, ..placed(&views.camera(offset_m)?) });
        }
    }
    Ok(CameraSet::new(cameras))
}

/// Receives the pictures of a run.
struct Run<'a, 'd> {
    args: &'a Args,
    progress: &'a Progress,
    device: &'a Device<'d>,
    outputs: Option<Outputs>,
    measured: &'a mut Measured,
    frame: u32,
}

/// Renders a view without interpolation.
type Cast<'a> = dyn Fn(usize) -> Result<RenderedImage> + 'a;

/// Renders a view at its own eye, as the reference of comparisons. It is rasterised if the sources are, so that times
/// are comparable.
fn alone(
    (progress, seen): (&Progress, DrawnScene<'_>),
    place: (&OutputViews, f64),
    samples: &SamplePattern,
) -> Result<RenderedImage> {
    let color = match seen.drawing {
        Some(_) => brute_force::draw(seen, place, samples, progress)?,
        None => brute_force::render(seen.scene, place, samples, progress)?,
    };
    Ok(RenderedImage::opaque(&color))
}

impl Run<'_, '_> {
    /// Interpolates all views that no earlier run has made.
    fn all_frames(
        &mut self,
        input: &mut Input,
        (grid, frames): (&GridViews, FrameRange),
        mut settings: Settings,
    ) -> Result<Summary> {
        let range = self.args.range()?;
        let mut summary = Summary::default();
        for frame in frames.iter() {
            self.frame = frame;
            let begun = Instant::now();
            let now = input.frame(self.args, frame)?;
            self.measured.load += begun.elapsed();
            let drawing = match &now {
                FrameInput::Scene(scene) => self.device.drawing(scene)?,
                FrameInput::Images(_) | FrameInput::Field(_) => None,
            };
            let drawing = drawing.as_ref().map(|drawing| drawing as &dyn TriangleDrawing);
            let mut of_frame = Summary::default();
            if let FrameInput::Scene(scene) = &now
                && self.args.by_columns()
            {
                of_frame = self.columns(DrawnScene { scene, drawing }, grid, &settings)?;
            } else {
                for row in 0..grid.ups_m.len() {
                    let views = grid.views_of(row)?;
                    let first = row * grid.row.offsets_m.len();
                    let missing = self.missing(grid.in_row(&range, row), first)?;
                    if !missing.is_empty() {
                        of_frame.add(self.row((&now, drawing), (&views, missing), first, &settings)?);
                    }
                }
            }
            if let Some(reduction) = self.args.reduce_layers {
                let pixels = range.len() as u64 * grid.row.size.map(u64::from).iter().product::<u64>();
                let layers = &mut settings.acquire.layers;
                *layers = reduction.next(*layers, self.args.layers as usize, of_frame.counters.pixels_by_layer, pixels);
            }
            summary.add(of_frame);
        }
        Ok(summary)
    }

    /// Interpolates the views of a grid, column by column.
    fn columns(&mut self, seen: DrawnScene<'_>, grid: &GridViews, settings: &Settings) -> Result<Summary> {
        let (range, count) = (self.args.range()?, grid.row.offsets_m.len());
        let wanted = self.missing(range, 0)?;
        let (progress, request) = (self.progress, Request { views: grid, wanted, settings, backend: self.device });
        let samples = &settings.acquire.samples;
        interpolate_grid(seen, &request, progress, |row, view, picture| {
            let views = grid.views_of(row)?;
            let cast = |view: usize| alone((progress, seen), (&views, views.offsets_m[view]), samples);
            self.take((view, row * count), &picture, Some(&cast))
        })
    }

    /// Returns runs of adjacent views of a row that have no file yet. `first` is the number of the row's first view.
    fn missing(&self, range: Range<usize>, first: usize) -> Result<Vec<Range<usize>>> {
        let mut runs: Vec<Range<usize>> = Vec::new();
        for view in range {
            let is_made = self.outputs.as_ref().map_or(Ok(false), |outputs| outputs.has(self.frame, first + view))?;
            match runs.last_mut() {
                _ if is_made => {}
                Some(run) if run.end == view => run.end += 1,
                _ => runs.push(view..view + 1),
            }
        }
        Ok(runs)
    }

    /// Interpolates some views of a row. `first` is the number of its first view.
    fn row(
        &mut self,
        (now, drawing): (&FrameInput<'_>, Option<&dyn TriangleDrawing>),
        (views, wanted): (&OutputViews, Vec<Range<usize>>),
        first: usize,
        settings: &Settings,
    ) -> Result<Summary> {
        let (progress, backend) = (self.progress, self.device);
        match now {
            FrameInput::Scene(scene) => {
                let (seen, samples) = (DrawnScene { scene, drawing }, &settings.acquire.samples);
                let cast = |view: usize| alone((progress, seen), (views, views.offsets_m[view]), samples);
                if self.args.brute_force {
                    return self.cast_all(&wanted, first, &cast);
                }
                let take = |view, picture: Picture| self.take((view, first), &picture, Some(&cast));
                interpolate(seen, &Request { views, wanted, settings, backend }, progress, take)
            }
            FrameInput::Images(images) => {
                let take = |view, picture: Picture| self.take((view, first), &picture, None);
                let request = Request { views, wanted, settings, backend };
                between((&images.sources, None::<Truth<'_>>), &request, progress, take)
            }
            FrameInput::Field(field) => {
                if let Some(outputs) = &mut self.outputs {
                    outputs.set_tone(field.tone());
                }
                let cast = |view: usize| field.picture(views, views.offsets_m[view], progress);
                if self.args.brute_force {
                    return self.cast_all(&wanted, first, &cast);
                }
                let begun = Instant::now();
                let (sources, counters) =
                    field.sources(views, self.args.acquire, &self.args.hierarchy(), backend, progress)?;
                let acquired = begun.elapsed();
                let take = |view, picture: Picture| self.take((view, first), &picture, Some(&cast));
                let request = Request { views, wanted, settings, backend };
                let mut summary = between((&sources, None), &request, progress, take)?;
                summary.passed.acquire += acquired;
                summary.counters.add(&counters);
                Ok(summary)
            }
        }
    }

    fn cast_all(&mut self, wanted: &[Range<usize>], first: usize, cast: &Cast<'_>) -> Result<Summary> {
        for view in wanted.iter().cloned().flatten() {
            let picture = self.cast(view, cast)?;
            self.put(first + view, &picture)?;
        }
        Ok(Summary::default())
    }

    /// Receives a picture. `view` is its position in the row, and `first` the number of the row's first view.
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
        self.measured.views += 1;
        let begun = Instant::now();
        if let Some(outputs) = &mut self.outputs {
            outputs.put((self.frame, view), picture)?;
        }
        self.measured.write += begun.elapsed();
        Ok(())
    }
}

impl Args {
    /// Fails if an output is an input or another output.
    fn check_outputs(&self, input: &Input) -> Result<()> {
        let files = input.files(self);
        if let Some(path) = &self.output
            && let Ok(pattern) = Pattern::parse(&path.to_string_lossy())
            && let Some(taken) = files.iter().find(|file| pattern.has_name_of(file))
        {
            return refuse(format!(
                "-o {}: the input {} would be overwritten: use another name",
                path.display(),
                taken.display()
            ));
        }
        let named = [("-o", &self.output), ("--csv", &self.csv), ("--cameras-out", &self.cameras_out)];
        let outputs: Vec<output_paths::Output> =
            named.into_iter().filter_map(|(option, path)| Some((option, path.clone()?))).collect();
        output_paths::check(&outputs, &files.iter().map(PathBuf::as_path).collect::<Vec<_>>())
    }
}
