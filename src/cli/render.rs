//! `lightfold render IN`: renders novel views of a light field, and compares them with reference images.

mod args;
mod options;
mod outputs;
mod pictures;
mod report;
mod truth;

use std::io::Write;
use std::path::PathBuf;
use std::time::Instant;

use crate::cli::options::word_of;
use crate::cli::progress::Progress;
use crate::cli::{ExitStatus, GlobalArgs, device, refuse};
use crate::decode::Decoder;
use crate::error::{Error, Result};
use crate::evaluate::camera_path::TimedCamera;
use crate::evaluate::frame_requests::{self, FrameRequest};
use crate::evaluate::rendered_image::RenderedImage;
use crate::files::OutputFile;
use crate::gpu::Gpu;
use crate::gpu::device::DeviceChoice;
use crate::gpu::render::RenderCost;
use crate::gpu::render::playback::DeviceRenderer;
use crate::image::FrameRange;
use crate::march::active_views::ActiveViews;
use crate::march::memory::{march_bytes, picture_bytes, splat_bytes};
use crate::march::playback::frames::{CpuRenderer, PictureOptions, Playback, PlaybackOptions, Renderer};
use crate::march::playback::methods::{ReprojectRenderer, SplatRenderer};
use crate::march::playback::selection::SelectionSettings;
use crate::march::settings::SpecularMode;
use crate::math::Camera;
use crate::memory::Need;
use crate::report::coding_map::counted;
use crate::views::catalogue::ProbeChoice;
use crate::views::light_field::ColorCoding;

pub use args::Args;
use options::{METHODS, Method};
use pictures::{Job, PictureName, Pictures};
use truth::TruthRun;

const DEFAULT_SIZE: u32 = 512;

const SHEET_BYTES: u64 = 1 << 20;

pub fn run(args: &Args, global: &GlobalArgs) -> Result<ExitStatus> {
    if args.gpu.list_devices {
        return device::list(args.json);
    }
    let Some(input) = &args.input else { return refuse("name a container to render") };
    args.check()?;
    if input.is_dir() || input.extension().is_some_and(|extension| extension == "json") {
        return refuse(format!(
            "{}: a container was expected; encode a dataset first: lightfold encode {0} -o film.lfold",
            input.display()
        ));
    }
    let decoder = Decoder::open(input)?;
    let named = |error: Error| error.in_file(input);
    let mut playback = Playback::new(&decoder, args.playback_options()).map_err(named)?;
    let mut truth = TruthRun::open(&args.truth, args.march.method)?;
    let jobs = match &truth {
        Some(truth) => truth.jobs(args.frames.frames, playback.player.frames(), global)?,
        None => args.jobs(&playback, global)?,
    };
    let march = &args.march;
    if march.method != Method::March && (march.samples != 1 || march.effects == SpecularMode::Force) {
        global.note(format_args!("--method {} ignores --samples and --effects", args.method_name()));
    }
    let beside_bytes = args.bytes_beside_views(&jobs, &decoder)?;
    playback = playback.with_memory(args.memory.get(), beside_bytes);
    let coding = playback.player.field.coding;
    let mut pictures = Pictures::open(args, &jobs, coding.tone())?;
    args.check_outputs(&jobs, &pictures)?;
    let mut trace = args.views.trace.as_deref().map(OutputFile::create).transpose()?;
    let count = jobs.iter().map(|job| job.request.cameras.len() as u64).sum();
    let rows = jobs.iter().map(|job| job.request.cameras.len() as u64 * u64::from(job.size[1])).sum();
    let progress = Progress::start(global, "rendering rows", rows)?;
    let gpu = args.gpu.open(args.device, global)?;
    let start = Instant::now();
    let mut method = args.renderer(gpu.as_ref(), &decoder, coding);
    let mut frames = report::Frames::default();
    jobs.iter().try_for_each(|job| args.check_far(&playback, job))?;
    for job in &jobs {
        let renderer = method.prepare(job, &mut truth)?;
        let shown = playback.show(&job.request, renderer, &progress).map_err(named)?;
        let images: Vec<RenderedImage> = shown.pictures.into_iter().map(|picture| picture.image).collect();
        if let Some(truth) = &mut truth {
            truth.compare(job, &images, coding.tone())?;
        }
        let eyes = images.len() / job.names.len().max(1);
        for (name, pictures_of) in job.names.iter().zip(images.chunks(eyes.max(1))) {
            pictures.put(name, pictures_of)?;
        }
        if let Some(file) = &mut trace {
            let line = serde_json::to_string(&shown.trace).map_err(|error| Error::invalid(format!("JSON: {error}")))?;
            writeln!(file, "{line}").map_err(|error| Error::io(args.views.trace.as_deref().unwrap_or(input), error))?;
        }
        frames.add(&shown.trace);
    }
    let seconds = start.elapsed().as_secs_f64();
    drop(progress);
    let bytes = pictures.bytes;
    pictures.commit()?;
    if let Some(truth) = &mut truth {
        truth.commit()?;
    }
    if let Some(mut file) = trace {
        file.commit()?;
    }
    let cameras = || jobs.iter().flat_map(|job| &job.request.cameras);
    let report = report::Report {
        args,
        summary: playback.summary(),
        pixels: jobs.iter().map(|job| job.request.cameras.len() as u64 * pixels(job.size)).sum(),
        pictures: count,
        frames: &frames,
        is_cut_off: args.march.far.is_some() || cameras().any(Camera::has_range),
        seconds,
        bytes_out: bytes,
        device: gpu.as_ref().map_or_else(|| "cpu".to_owned(), |gpu| gpu.info.name.clone()),
        gpu_cost: method.gpu_cost(),
        decoded_on: method.decoded_on(),
        truth: truth.as_ref(),
    };
    report.print(global)?;
    Ok(ExitStatus::Passed)
}

fn pixels(size: [u32; 2]) -> u64 {
    size.into_iter().map(u64::from).product()
}

enum MethodRenderer<'g> {
    March(CpuRenderer),
    Device(Box<DeviceRenderer<'g>>),
    Splat(SplatRenderer),
    Reproject(ReprojectRenderer),
}

impl MethodRenderer<'_> {
    fn prepare(&mut self, job: &Job, truth: &mut Option<TruthRun>) -> Result<&mut dyn Renderer> {
        let options = match self {
            MethodRenderer::March(renderer) => &mut renderer.options,
            MethodRenderer::Device(renderer) => &mut renderer.options,
            MethodRenderer::Splat(renderer) => &mut renderer.options,
            MethodRenderer::Reproject(renderer) => &mut renderer.options,
        };
        options.size = job.size;
        if let (MethodRenderer::Reproject(renderer), Some(truth)) = (&mut *self, truth) {
            renderer.distances_m = truth.distances(job)?;
        }
        Ok(match self {
            MethodRenderer::March(renderer) => renderer,
            MethodRenderer::Device(renderer) => renderer.as_mut(),
            MethodRenderer::Splat(renderer) => renderer,
            MethodRenderer::Reproject(renderer) => renderer,
        })
    }

    fn decoded_on(&self) -> &'static str {
        match self {
            MethodRenderer::Device(renderer) if renderer.decodes() => "device",
            _ => "cpu",
        }
    }

    fn gpu_cost(&self) -> Option<RenderCost> {
        match self {
            MethodRenderer::Device(renderer) => Some(renderer.cost()),
            _ => None,
        }
    }
}

impl Args {
    fn check(&self) -> Result<()> {
        if let (Some(near), Some(far)) = (self.march.near, self.march.far)
            && near >= far
        {
            return refuse(format!("--near {near} must be below --far {far}"));
        }
        if let (Some(_), Some((_, Some(_)))) = (self.cameras.aspect, self.size) {
            return refuse("--size WxH and --aspect contradict each other: leave out one of them");
        }
        let choice = &self.views;
        if !choice.probe.is_empty() && choice.probe.iter().all(|name| choice.exclude_probe.contains(name)) {
            return refuse("--exclude-probe excludes all probes of --probe");
        }
        let on_device = self.gpu.gpu_index.is_some() || self.device.is_some_and(|device| device != DeviceChoice::Cpu);
        if self.march.method != Method::March && on_device {
            return refuse(format!("--method {} runs on the CPU: leave out --device", self.method_name()));
        }
        if on_device && self.memory.memory.is_some() {
            return refuse("--memory limits the CPU renderer only, not graphics devices: leave out one of them");
        }
        if self.results_to_stdout() + usize::from(self.json) > 1 {
            return refuse("only one result fits standard output: name files for the others");
        }
        Ok(())
    }

    fn bytes_beside_views(&self, jobs: &[Job], decoder: &Decoder) -> Result<u64> {
        let pixels_of = |job: &Job| pixels(job.size).saturating_mul(job.request.cameras.len() as u64);
        let most_pixels = jobs.iter().map(pixels_of).max().unwrap_or(0);
        let sheet = if self.contact_sheet.is_some() { jobs.len() as u64 * SHEET_BYTES } else { 0 };
        let of_method = match self.march.method {
            Method::March => march_bytes(decoder, &self.playback_options(), self.march.effects),
            Method::Splat => splat_bytes(decoder),
            Method::Reproject => 0,
        };
        let of_pictures = picture_bytes(most_pixels, self.truth.reference.is_some()).saturating_add(sheet);
        let fixed = of_pictures.saturating_add(of_method);
        let need = Need { what: "rendering", fixed, each: 0, instead: "a smaller --size" };
        self.memory.get().at_once(&need, 1)?;
        Ok(fixed)
    }

    fn check_outputs(&self, jobs: &[Job], pictures: &Pictures) -> Result<()> {
        let mut outputs: Vec<outputs::Output> = Vec::new();
        let names = || jobs.iter().flat_map(|job| &job.names);
        if let Some(output) = &self.output {
            for name in names() {
                outputs.extend(pictures.files_of(name, output)?.into_iter().map(|file| ("-o", file)));
            }
        }
        if let Some(folder) = &self.truth.error_map {
            outputs.extend(names().map(|name| ("--error-map", folder.join(name.png()))));
        }
        let others = [("--contact-sheet", &self.contact_sheet), ("--trace", &self.views.trace)];
        outputs.extend(others.into_iter().filter_map(|(option, path)| Some((option, path.clone()?))));
        let cameras = self.cameras.camera.iter().chain(&self.input).chain(&self.truth.reference);
        outputs::check(&outputs, &cameras.map(PathBuf::as_path).collect::<Vec<_>>())
    }

    fn method_name(&self) -> &'static str {
        word_of(METHODS, &self.march.method)
    }

    /// Refuses a --far before the default --near.
    fn check_far(&self, playback: &Playback<'_>, job: &Job) -> Result<()> {
        let (Some(far_m), None, Some(camera)) = (self.march.far, self.march.near, job.request.cameras.first()) else {
            return Ok(());
        };
        let field = &playback.player.field;
        let all: Vec<usize> = (0..field.views.len()).collect();
        let near_m = ActiveViews::new(field, &all, camera.eye()).near_m() / 10.0;
        if f64::from(near_m) < far_m {
            return Ok(());
        }
        refuse(format!("--far {far_m} is nearer than the default --near, {near_m}: set --near, or a greater --far"))
    }

    fn playback_options(&self) -> PlaybackOptions {
        let views = &self.views;
        PlaybackOptions {
            probes: ProbeChoice { only: views.probe.clone(), without: views.exclude_probe.clone() },
            selection: SelectionSettings {
                priority: views.view_priority,
                pivot: views.pivot,
                cull_angle_deg: (views.cull_angle > 0.0).then_some(views.cull_angle),
                most: views.views.map(|views| views as usize),
                target_ms: views.target_ms,
            },
            decode: views.decode,
        }
    }

    fn picture_options(&self) -> PictureOptions {
        let march = &self.march;
        PictureOptions {
            size: [1, 1],
            steps: march.steps,
            refine: march.refine,
            near_m: march.near.map(|metres| metres as f32),
            far_m: march.far.map(|metres| metres as f32),
            samples: march.samples,
            holes: march.holes,
            specular: march.effects,
            max_bounces: march.max_bounces,
            acceleration: march.acceleration,
        }
    }

    fn renderer<'g>(&self, gpu: Option<&'g Gpu>, decoder: &'g Decoder, coding: ColorCoding) -> MethodRenderer<'g> {
        let options = self.picture_options();
        match (self.march.method, gpu) {
            (Method::March, Some(gpu)) => {
                MethodRenderer::Device(Box::new(DeviceRenderer::new(gpu, options).decoding(decoder, coding)))
            }
            (Method::March, None) => MethodRenderer::March(CpuRenderer::new(options)),
            (Method::Splat, _) => MethodRenderer::Splat(SplatRenderer { options }),
            (Method::Reproject, _) => {
                MethodRenderer::Reproject(ReprojectRenderer { options, ..ReprojectRenderer::default() })
            }
        }
    }

    fn note_skipped_frames(&self, cameras: &[TimedCamera], available: FrameRange, global: &GlobalArgs) {
        let asked = self.frames.frames;
        if asked.is_none() && available.count() > 1 && cameras.iter().all(|timed| timed.frames.is_none()) {
            global.note(format_args!("rendering frame {} of {available}; --frames selects others", available.first));
        }
        let missing = frame_requests::missing_frames(cameras, asked, available);
        if missing > 0 {
            let frames = counted(missing, "frame");
            global.note(format_args!("skipping {frames} of the cameras; the container has {available}"));
        }
    }

    fn jobs(&self, playback: &Playback<'_>, global: &GlobalArgs) -> Result<Vec<Job>> {
        let cameras = self.cameras.cameras()?;
        let available = playback.player.frames();
        let requests = frame_requests::frame_requests(&cameras, self.frames.frames, available)?;
        self.note_skipped_frames(&cameras, available, global);
        let mut frames: Vec<u32> = requests.iter().map(|request| request.frame).collect();
        frames.sort_unstable();
        frames.dedup();
        // Files are numbered by frame, unless cameras share one.
        let by_frame = frames.len() == requests.len();
        let job = |(at, request): (u32, FrameRequest)| {
            let camera = request.cameras.first().copied();
            let (size, camera) = sized(camera, self.size)?;
            let cameras = match self.stereo {
                None => vec![camera],
                Some(apart) => [-0.5, 0.5].map(|side| camera.moved_right(side * apart)).to_vec(),
            };
            let number = if by_frame { request.frame } else { at };
            let names = vec![PictureName { number, subject: "view".to_owned() }];
            Ok(Job { request: FrameRequest { cameras, ..request }, names, size, references: Vec::new() })
        };
        (0..).zip(requests).map(job).collect()
    }
}

fn sized(camera: Option<Camera>, asked: Option<(u32, Option<u32>)>) -> Result<([u32; 2], Camera)> {
    let camera = camera.ok_or_else(|| Error::Usage("name a camera".into()))?;
    match asked.unwrap_or((DEFAULT_SIZE, None)) {
        (width, Some(height)) => Ok(([width, height], camera.with_aspect(f64::from(width) / f64::from(height)))),
        (height, None) => {
            let width = (f64::from(height) * camera.aspect()).round();
            if !(1.0..=65_536.0).contains(&width) {
                return refuse(format!(
                    "an image of {width}x{height} pixels: up to 65536 were expected; set --size WxH"
                ));
            }
            Ok(([width as u32, height], camera))
        }
    }
}
