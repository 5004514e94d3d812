//! `lightfold render IN`: renders novel views of a light field or of a simplified scene, and compares them with
//! reference images.

mod args;
mod light_field;
mod options;
mod pictures;
mod quads;
mod report;
mod subject;
mod truth;

use std::io::Write;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::time::Instant;

use crate::film::is_film;
use crate::options::check_stdout;
use crate::progress::Progress;
use crate::{ExitStatus, GlobalArgs, device, outputs, refuse};
use codec::decode::Decoder;
use codec::error::{Error, Result, counted};
use codec::image::FrameRange;
use codec::math::Camera;
use footage::files::OutputFile;
use render::camera_path::TimedCamera;
use render::frame_requests::{self, FrameRequest};

pub use args::Args;
use light_field::LightFieldSubject;
use options::PictureProjection;
use pictures::{Job, PictureName, Pictures, pixels};
use quads::QuadSubject;
use report::Report;
use subject::Subject;
use truth::TruthRun;

const DEFAULT_SIZE: u32 = 512;

/// Frames of a still scene, which is the same in all frames.
const ALL_FRAMES: FrameRange = FrameRange { first: 0, last: u32::MAX };
/// Maximum number of pictures of a still scene.
const MAX_STILL_FRAMES: u64 = 1_000_000;

pub fn run(args: &Args, global: &GlobalArgs) -> Result<ExitStatus> {
    let start = Instant::now();
    if args.gpu.list_devices {
        return device::list(args.json);
    }
    let Some(input) = &args.input else { return refuse("no container or simplified scene to render was given") };
    args.check()?;
    if input.is_dir() || input.extension().is_some_and(|extension| extension == "json") {
        return refuse(format!(
            "{}: a container was expected: encode a dataset first: lightfold encode {0} -o film.lfold",
            input.display()
        ));
    }
    let decoder;
    let mut subject: Box<dyn Subject> = if quads::is_scene(input) {
        Box::new(QuadSubject::open(args, input)?)
    } else {
        args.check_container()?;
        decoder = Decoder::open(input)?;
        Box::new(LightFieldSubject::open(args, input, &decoder)?)
    };
    let mut truth = TruthRun::open(&args.truth, subject.method())?;
    let all = match &truth {
        Some(truth) => {
            let frames = subject.reference_frames(args.frames.frames);
            truth.jobs(frames, subject.frames().unwrap_or(ALL_FRAMES), global)?
        }
        None => args.jobs(subject.as_ref(), global)?,
    };
    subject.check(&all, global)?;
    let mut pictures = Pictures::open(args, &all, (subject.fps(), args.display.look(subject.tone())?), global.threads)?;
    args.check_outputs(&all, &pictures)?;
    let jobs = args.of_shard(&all)?;
    let mut trace = args.views.trace.as_deref().map(OutputFile::create).transpose()?;
    let count = jobs.iter().map(|job| job.request.cameras.len() as u64).sum();
    let rows = jobs.iter().map(|job| job.request.cameras.len() as u64 * u64::from(job.size[1])).sum();
    let progress = Progress::start(global, "rendering rows", rows)?;
    let gpu = args.gpu.index.open(args.device, global)?;
    let tone = subject.tone();
    let mut renderer = subject.renderer(gpu.as_ref())?;
    for job in jobs {
        let rendered = renderer.render(job, truth.as_mut(), &progress)?;
        if let Some(truth) = &mut truth {
            let pictures = rendered.compared.as_ref().unwrap_or(&rendered.images);
            truth.compare(job, (pictures, &rendered.near_silhouettes), tone)?;
        }
        let parts = rendered.images.len() / job.names.len().max(1);
        for (name, pictures_of) in job.names.iter().zip(rendered.images.chunks(parts.max(1))) {
            pictures.put(name, job, pictures_of)?;
        }
        if let (Some(file), Some(frame)) = (&mut trace, &rendered.trace) {
            let line = serde_json::to_string(frame).map_err(|error| Error::invalid(format!("JSON: {error}")))?;
            writeln!(file, "{line}").map_err(|error| Error::io(args.views.trace.as_deref().unwrap_or(input), error))?;
        }
    }
    let figures = renderer.figures();
    drop(renderer);
    let bytes = pictures.commit(&progress)?;
    drop(progress);
    if let Some(truth) = &mut truth {
        truth.commit()?;
    }
    if let Some(mut file) = trace {
        file.commit()?;
    }
    let report = Report {
        args,
        figures,
        pixels: jobs.iter().map(|job| job.request.cameras.len() as u64 * pixels(job.size)).sum(),
        pictures: count,
        is_cut_off: args.march.far.is_some() || jobs.iter().flat_map(|job| &job.request.cameras).any(Camera::has_range),
        seconds: start.elapsed().as_secs_f64(),
        bytes_out: bytes,
        device: gpu.as_ref().map_or_else(|| "cpu".to_owned(), |gpu| gpu.info.name.clone()),
        truth: truth.as_ref(),
    };
    report.print(global)?;
    Ok(ExitStatus::Passed)
}

impl Args {
    fn check(&self) -> Result<()> {
        if let (Some(_), Some((_, Some(_)))) = (self.cameras.aspect, self.size) {
            return refuse("--size WxH and --aspect both set the aspect ratio: leave out one of them");
        }
        if self.projection.projection == PictureProjection::Cubemap
            && let Some((width, Some(height))) = self.size
            && width != height
        {
            return refuse("--size of a cube map is the side of a face: one number was expected");
        }
        if self.projection.is_panorama() && self.is_on_device() {
            return refuse("equirect and vr180 are rendered on the CPU only: leave out --device");
        }
        if self.is_on_device() && self.memory.memory.is_some() {
            return refuse("--memory limits the CPU renderer only, not graphics devices: leave out one of them");
        }
        if self.results_to_stdout() + usize::from(self.json) > 1 {
            return refuse("only one result can be written to standard output: write the others to files");
        }
        self.display.check(self.output.as_deref(), self.contact_sheet.as_deref())?;
        if self.shard.is_some() && self.output.as_deref().is_some_and(|path| path == Path::new("-") || is_film(path)) {
            return refuse("--shard needs a pattern such as view.%04d.png, or a folder");
        }
        self.output.iter().chain(&self.contact_sheet).try_for_each(|path| check_stdout(path, false))
    }

    /// Returns the jobs of the shard.
    fn of_shard<'j>(&self, all: &'j [Job]) -> Result<&'j [Job]> {
        let Some(shard) = self.shard else { return Ok(all) };
        let Range { start, end } = shard.range(all.len() as u64, "frame")?;
        Ok(&all[start as usize..end as usize])
    }

    fn check_outputs(&self, jobs: &[Job], pictures: &Pictures) -> Result<()> {
        let mut outputs: Vec<outputs::Output> = Vec::new();
        let names = || jobs.iter().flat_map(|job| &job.names);
        outputs.extend(self.output.iter().filter(|path| is_film(path)).map(|path| ("-o", path.clone())));
        for name in names() {
            outputs.extend(pictures.files_of(name)?.into_iter().map(|file| ("-o", file)));
        }
        if let Some(folder) = &self.truth.error_map {
            outputs.extend(names().map(|name| ("--error-map", folder.join(name.png()))));
        }
        let others = [("--contact-sheet", &self.contact_sheet), ("--trace", &self.views.trace)];
        outputs.extend(others.into_iter().filter_map(|(option, path)| Some((option, path.clone()?))));
        let cameras =
            self.cameras.camera.iter().chain(&self.input).chain(&self.truth.reference).chain(&self.display.lut);
        outputs::check(&outputs, &cameras.map(PathBuf::as_path).collect::<Vec<_>>())
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

    /// Returns a job for each frame and camera. A still scene is rendered at all frames of the cameras.
    fn jobs(&self, subject: &dyn Subject, global: &GlobalArgs) -> Result<Vec<Job>> {
        let (frames, mut cameras) = (subject.frames(), self.cameras.cameras(subject.fps())?);
        let available = frames.unwrap_or(ALL_FRAMES);
        if cameras.is_empty() {
            cameras = self.own_cameras(subject, available, global)?;
        }
        if let Some(asked) = self.frames.frames.filter(|asked| frames.is_none() && asked.count() > MAX_STILL_FRAMES) {
            return Err(Error::Usage(format!(
                "--frames {asked}: {} pictures of a still scene, at most {MAX_STILL_FRAMES} are possible",
                asked.count()
            )));
        }
        let requests = frame_requests::frame_requests(&cameras, self.frames.frames, available)?;
        if frames.is_some() {
            self.note_skipped_frames(&cameras, available, global);
        }
        let mut frames: Vec<u32> = requests.iter().map(|request| request.frame).collect();
        frames.sort_unstable();
        frames.dedup();
        // Files are numbered by frame, unless cameras share a frame.
        let by_frame = frames.len() == requests.len();
        let job = |(at, request): (u32, FrameRequest)| {
            let camera = request.cameras.first().copied();
            let (size, camera) = sized(camera, self.size, self.projection.aspect())?;
            let cameras = self.projection.cameras(&camera);
            let number = if by_frame { request.frame } else { at };
            let names = vec![PictureName { number, subject: "view".to_owned() }];
            Ok(Job { request: FrameRequest { cameras, ..request }, names, size, references: Vec::new() })
        };
        (0..).zip(requests).map(job).collect()
    }

    /// Returns the default camera of the subject, in each frame because it may move.
    fn own_cameras(
        &self,
        subject: &dyn Subject,
        available: FrameRange,
        global: &GlobalArgs,
    ) -> Result<Vec<TimedCamera>> {
        let first = FrameRange { first: available.first, last: available.first };
        let asked = self.frames.frames.and_then(|asked| asked.intersect(available)).unwrap_or(first);
        let (camera, words) = subject.own_camera(asked.first)?;
        global.note(format_args!("{words}; use --eye and --look-at, or --camera, for another view"));
        let of = |frame: u32| {
            let (camera, _) = subject.own_camera(frame)?;
            Ok(TimedCamera { camera, frames: Some(FrameRange { first: frame, last: frame }) })
        };
        let all: Vec<TimedCamera> = asked.iter().map(of).collect::<Result<_>>()?;
        let moves = all.iter().any(|timed| timed.camera != camera);
        Ok(if moves { all } else { vec![TimedCamera { camera, frames: None }] })
    }
}

/// Returns the size of a picture, and its camera. `aspect` replaces the aspect of the camera, if given.
fn sized(camera: Option<Camera>, asked: Option<(u32, Option<u32>)>, aspect: Option<f64>) -> Result<([u32; 2], Camera)> {
    let camera = camera.ok_or_else(|| Error::Usage("no camera was given".into()))?;
    if aspect.is_some() && camera.has_range() {
        return refuse(
            "near_m and far_m of a camera apply to perspective pictures only: leave them out, or --projection",
        );
    }
    match asked.unwrap_or((DEFAULT_SIZE, None)) {
        (width, Some(height)) => Ok(([width, height], camera.with_aspect(f64::from(width) / f64::from(height)))),
        (height, None) => {
            let width = (f64::from(height) * aspect.unwrap_or(camera.aspect())).round();
            if !(1.0..=65_536.0).contains(&width) {
                return refuse(format!(
                    "an image of {width}x{height} pixels: a width of 1 to 65536 was expected: set --size WxH"
                ));
            }
            Ok(([width as u32, height], camera))
        }
    }
}
