//! `lightfold capture SCENE -o DIR`: a scene becomes a dataset.

mod options;

use std::path::{Path, PathBuf};
use std::time::Instant;

use glam::DVec3;
use serde_json::json;

use crate::cli::options::{FrameArgs, parse_point};
use crate::cli::output::{self, human_bytes};
use crate::cli::progress::Progress;
use crate::cli::{ExitStatus, GlobalArgs};
use crate::dataset::manifest::{MANIFEST_NAME, Manifest};
use crate::error::{Error, Result};
use crate::files::PartialFolder;
use crate::fingerprint::Fingerprint;
use crate::scene::capture::write::UNFINISHED;
use crate::scene::{CapturePlan, CaptureSummary, Kept, Pass, Play, Scene};

use options::{AovArg, DepthArg, ProjectionArg, parse_fps, parse_metres};

pub use options::parse_size;

/// Arguments.
#[derive(Debug, clap::Args)]
#[command(
    group(clap::ArgGroup::new("from").required(true).args(["cameras", "position"])),
    after_help = "Examples:\n  lightfold capture sponza.glb --cameras cameras.json --size 256 -o cap\n  \
    lightfold capture mirrors --position 0,1.5,0 --frames 0-23 --samples 4 --aov depth,material -o cap\n  \
    lightfold capture scene.gltf --cameras old/lightfield.json --aov depth,normal,material -o cap\n  \
    lightfold capture scene.obj --position 0,1.5,0 --projection equirect --size 2048 -o pano\n  \
    lightfold capture scene.glb --cameras views.json --size 1280x720 -o truth\n  \
    lightfold capture scene.glb --position 0,1,3 --look-at 0,1,0 --fov 50 -o view\n  \
    lightfold capture scene.glb --cameras cameras.json --resume -o cap --json\n\n\
    SCENE is a file (glTF, GLB, OBJ) or built in: courtyard, interior, object, mirrors, cornell.\n\n\
    --cameras takes what `place` writes: {\"lightfold_cameras\": 1, \"cameras\": [{\"position\": [0, 1.5, 0]}]}, where a \
    camera may have a \"name\", an \"orientation\" (a quaternion x, y, z, w), \"fov_y_deg\" and \"frames\" ([first, last]); \
    the probes of a lightfield.json; or viewers as of `decode --camera`, from which perspective images are captured: the \
    truth to compare with what is made of a light field.\n\n\
    A scene that brings no light is lit by a sun, 51 degrees high towards (0.5, 0.78, 0.38), of radiance 1.75, 1.6, 1.35 (of a \
    white surface that faces it), and by light from everywhere, 0.3, 0.36, 0.46. Behind all scenes from files is a sky of \
    0.5, 0.66, 0.86 at the horizon and 0.16, 0.32, 0.68 straight up.\n\n\
    Colour is the mean of a pixel's samples; all else is what one ray through its centre meets, and is never filtered. \
    The same scene and options write the same bytes on any number of threads.\n\n\
    A capture that is stopped keeps its images beside DIR: the same command with --resume goes on with them and ends in \
    the same bytes. A dataset in DIR is replaced only by one that has all of its images."
)]
pub struct Args {
    /// A file (glTF, GLB, OBJ), or the name of a scene that is built in
    #[arg(value_name = "SCENE")]
    pub scene: String,
    /// Folder to write the dataset into
    #[arg(long, short, value_name = "DIR")]
    pub output: PathBuf,
    /// Where to capture from: a file of cameras, a lightfield.json, or - for standard input
    #[arg(long, value_name = "FILE")]
    pub cameras: Option<PathBuf>,
    /// Capture from here, in metres; may be given more than once
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_point, allow_hyphen_values = true)]
    pub position: Vec<DVec3>,
    /// Take perspective pictures from each --position towards this point in metres, with +Y up; --fov says how wide
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_point, allow_hyphen_values = true, requires = "position")]
    pub look_at: Option<DVec3>,
    /// Which animation of the file is shown, by its name [default: the first]
    #[arg(long, value_name = "NAME")]
    pub animation: Option<String>,
    /// Frames; without them, all of the animation, or frame 0 where nothing moves.
    #[command(flatten)]
    pub frames: FrameArgs,
    /// Frames per second of the scene's time
    #[arg(long, value_name = "FPS", default_value = "24", value_parser = parse_fps)]
    pub fps: f64,
    /// Pixels: the side of a cube face, the width of a panorama, the height of a perspective image; or both sides
    /// [default: 512, for panoramas 2048]
    #[arg(long, value_name = "N|WxH", value_parser = parse_size)]
    pub size: Option<(u32, Option<u32>)>,
    /// What an image shows [default: cube; perspective where the cameras are viewers, and with --look-at]
    #[arg(long, value_enum)]
    pub projection: Option<ProjectionArg>,
    /// Vertical field of view in degrees, for cameras of perspective captures that have none of their own
    #[arg(long, value_name = "DEGREES")]
    pub fov: Option<f64>,
    /// Samples of colour in each pixel: squares lie on a grid, other numbers on Hammersley's points
    #[arg(long, value_name = "N", default_value_t = 16,
        value_parser = clap::value_parser!(u32).range(1..=i64::from(crate::scene::capture::MAX_SAMPLES)))]
    pub samples: u32,
    /// What to capture besides colour: depth, normal, material, or none
    #[arg(long, value_enum, value_name = "KIND", value_delimiter = ',', default_value = "depth")]
    pub aov: Vec<AovArg>,
    /// Leave colour out
    #[arg(long)]
    pub no_color: bool,
    /// What depth measures
    #[arg(long, value_enum, default_value_t = DepthArg::Distance)]
    pub depth: DepthArg,
    /// Metres: surfaces farther away are background, but for their colour [default: none is too far]
    #[arg(long, value_name = "M", value_parser = parse_metres)]
    pub far: Option<f64>,
    /// Go on with a capture into this folder that was stopped; the options must be the same. Where there is none, begin at
    /// the start
    #[arg(long)]
    pub resume: bool,
    /// Report as JSON
    #[arg(long)]
    pub json: bool,
}

/// Captures.
pub fn run(args: &Args, global: &GlobalArgs) -> Result<ExitStatus> {
    let start = Instant::now();
    if args.output == Path::new("-") {
        return Err(Error::Usage("-o -: a dataset is a folder of files, which no pipe takes; name a folder".into()));
    }
    check_cameras_stay(args)?;
    let (cameras, viewers) = args.read_cameras()?;
    let play = args.animation.as_deref().map_or(Play::First, Play::Named);
    let (scene, notes) = Scene::open_to_play(&args.scene, play)?;
    if !global.quiet {
        notes.iter().for_each(output::note);
    }
    let plan = args.plan(&scene, cameras, viewers)?;
    // Before anything is written.
    plan.manifest()?;
    check_output(&plan, &args.output)?;
    if !global.quiet {
        args.notes(&scene, &plan).iter().for_each(output::note);
    }
    let loaded = start.elapsed();
    let progress = Progress::start(global, "capturing", plan.image_count())?;
    let work = Work { plan: &plan, scene: &scene, args, global, progress: &progress };
    let summary = work.capture(PartialFolder::open(&args.output, UNFINISHED)?)?;
    drop(progress);
    let times = [loaded.as_secs_f64(), start.elapsed().as_secs_f64()];
    if args.json {
        let mut report = json_report(&plan, &summary, times);
        output::add_peak_memory(&mut report);
        output::print_json(&report)?;
    } else if !global.quiet {
        output::note(text_report(&args.output, &plan, &summary, times));
    }
    Ok(ExitStatus::Passed)
}

/// Refuses to overwrite the manifest that says where the cameras are.
fn check_cameras_stay(args: &Args) -> Result<()> {
    let manifest = args.output.join(MANIFEST_NAME).canonicalize().ok();
    let cameras = args.cameras.as_ref().and_then(|path| path.canonicalize().ok());
    match manifest {
        Some(path) if cameras.as_ref() == Some(&path) => Err(Error::Usage(format!(
            "{}: the cameras are read from it, and it would be overwritten; name another folder",
            args.output.join(MANIFEST_NAME).display()
        ))),
        _ => Ok(()),
    }
}

/// Refuses a folder with a dataset whose images would be mixed with those of the plan.
fn check_output(plan: &CapturePlan, output: &Path) -> Result<()> {
    if !output.join(MANIFEST_NAME).is_file() {
        return Ok(());
    }
    plan.check_replaces(&Manifest::read(output)?).map_err(|error| error.context(output.display()))
}

struct Work<'a> {
    plan: &'a CapturePlan,
    scene: &'a Scene,
    args: &'a Args,
    global: &'a GlobalArgs,
    progress: &'a Progress,
}

impl Work<'_> {
    /// Goes on with what there is, where that is wanted, and leaves what is done where it cannot be finished.
    fn capture(&self, mut folder: PartialFolder) -> Result<CaptureSummary> {
        if !folder.is_locked() {
            self.say("the file system has no locks, so two captures into this folder would not see each other: start no second one");
        }
        let now = self.fingerprint();
        let kept = self.begin(&mut folder, &now)?;
        let done = self.plan.write(self.scene, folder.work_path(), kept, self.progress);
        let done = done.and_then(|summary| folder.commit().map(|()| summary));
        done.map_err(|error| {
            let (error, images) = (folder.present(error), folder.files());
            if images == 0 {
                return error;
            }
            folder.keep();
            let all = self.plan.image_count();
            let safe = format!(
                "{images} of {all} images are kept in {}; the same command with --resume goes on from there",
                folder.work_path().display()
            );
            Error::Unfinished { cause: Box::new(error), safe }
        })
    }

    /// Decides what becomes of what an earlier capture left.
    fn begin(&self, folder: &mut PartialFolder, now: &Fingerprint) -> Result<Kept> {
        let (left, images) = (folder.state()?, folder.files());
        if self.args.resume && images > 0 {
            let begun: Vec<(String, String)> =
                serde_json::from_str(&left).map_err(|_| self.cannot("its state is damaged"))?;
            if let Some(difference) = Fingerprint::new(begun).difference(now) {
                return Err(self.cannot(&difference));
            }
            self.say(&format!("going on with {images} of {} images", self.plan.image_count()));
            return Ok(Kept::Sound);
        }
        if self.args.resume {
            self.say("there is nothing to resume, so the capture begins at the start");
        } else if images > 0 {
            self.say(&format!("an unfinished capture of {images} images is replaced; --resume goes on with one"));
        }
        let state = serde_json::to_string_pretty(now.fields())
            .map_err(|error| Error::invalid(format!("the state of the capture: {error}")))?;
        folder.start_over(&state)?;
        Ok(Kept::None)
    }

    fn cannot(&self, difference: &str) -> Error {
        Error::Usage(format!(
            "{}: the unfinished capture cannot go on: {difference}; run it as it was begun, or leave out --resume to \
             start anew",
            self.args.output.display()
        ))
    }

    fn say(&self, words: &str) {
        if !self.global.quiet {
            output::note(format_args!("{}: {words}", self.args.output.display()));
        }
    }

    /// What the images follow from.
    fn fingerprint(&self) -> Fingerprint {
        let mut fields = Fingerprint::of_program();
        fields.extend(self.plan.options());
        fields.push(("the contents of the scene", self.scene.contents().to_owned()));
        fields.push(("--animation", format!("{:?}", self.args.animation.as_deref().unwrap_or("the first"))));
        // Sines and roots are rounded by the system's library.
        fields.push(("the kind of machine", format!("{} {}", std::env::consts::OS, std::env::consts::ARCH)));
        Fingerprint::new(fields.into_iter().map(|(name, value)| (name.to_owned(), value)).collect())
    }
}

/// Rays and seconds of the capture proper, without opening the scene.
fn rays_per_second(summary: &CaptureSummary, [loaded, all]: [f64; 2]) -> f64 {
    summary.rays as f64 / (all - loaded).max(1e-9)
}

fn json_report(plan: &CapturePlan, summary: &CaptureSummary, times: [f64; 2]) -> serde_json::Value {
    let [near_m, far_m] = summary.depth_range_m;
    let range = near_m <= far_m;
    json!({
        "seconds": times[1],
        "loading_seconds": times[0],
        "frames": plan.frames.count(),
        "probes": plan.cameras.cameras.len(),
        "images": summary.images,
        "resumed_images": summary.kept_images,
        "rays": summary.rays,
        "rays_per_second": rays_per_second(summary, times),
        "bytes": summary.bytes,
        "near_m": range.then_some(near_m),
        "far_m": range.then_some(far_m),
    })
}

fn text_report(path: &Path, plan: &CapturePlan, summary: &CaptureSummary, times: [f64; 2]) -> String {
    let [near_m, far_m] = summary.depth_range_m;
    let range = if near_m <= far_m {
        format!(", depths of {near_m:.3} to {far_m:.3} m")
    } else if plan.passes.contains(&Pass::Depth) {
        ", no surface in sight".to_owned()
    } else {
        String::new()
    };
    let kept = match summary.kept_images {
        0 => String::new(),
        count => format!(" ({count} from before)"),
    };
    let (probes, frames) = (plan.cameras.cameras.len() as u64, plan.frames.count());
    let of = |count: u64, what: &str| format!("{count} {what}{}", if count == 1 { "" } else { "s" });
    format!(
        "{}: {}, {}, {}{kept}, {}{range}; {:.2} M rays, {:.2} M a second, {:.2} s",
        path.display(),
        of(probes, "probe"),
        of(frames, "frame"),
        of(summary.images, "image"),
        human_bytes(summary.bytes),
        summary.rays as f64 / 1e6,
        rays_per_second(summary, times) / 1e6,
        times[1],
    )
}
