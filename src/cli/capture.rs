//! `lightfold capture SCENE -o DIR`: renders a scene as a dataset.

mod args;
mod options;

use std::path::Path;
use std::time::Instant;

use crate::cli::output::human_bytes;
use crate::cli::progress::Progress;
use crate::cli::{ExitStatus, GlobalArgs, refuse};
use crate::dataset::manifest::{MANIFEST_NAME, Manifest};
use crate::error::{Error, Result};
use crate::files::PartialFolder;
use crate::fingerprint::Fingerprint;
use crate::report::coding_map::counted;
use crate::scene::capture::CaptureReport;
use crate::scene::capture::write::UNFINISHED;
use crate::scene::{CapturePlan, CaptureSummary, ExistingImages, Pass, Play, Scene};

pub use args::{Args, parse_size};

pub fn run(args: &Args, global: &GlobalArgs) -> Result<ExitStatus> {
    let start = Instant::now();
    if args.output == Path::new("-") {
        return refuse("standard output cannot hold a dataset: name a folder");
    }
    let manifest = args.output.join(MANIFEST_NAME);
    let cameras = args.cameras.as_ref().and_then(|path| path.canonicalize().ok());
    if cameras.is_some() && manifest.canonicalize().ok() == cameras {
        let path = manifest.display();
        return refuse(format!("{path}: the file of cameras would be overwritten; name another folder"));
    }
    let (cameras, viewers) = args.read_cameras()?;
    let play = args.animation.as_deref().map_or(Play::First, Play::Named);
    let (scene, notes) = Scene::open(&args.scene, play)?;
    notes.iter().for_each(|note| global.note(note));
    let plan = args.plan(&scene, cameras, viewers)?;
    plan.manifest()?;
    if manifest.is_file() {
        let old = Manifest::read(&args.output)?;
        plan.check_replaces(&old).map_err(|error| error.context(args.output.display()))?;
    }
    args.notes(&scene, &plan).iter().for_each(|note| global.note(note));
    let loaded = start.elapsed();
    let progress = Progress::start(global, "capturing", plan.image_count())?;
    let work = Work { plan: &plan, scene: &scene, args, global, progress: &progress };
    let summary = work.capture(PartialFolder::open(&args.output, UNFINISHED)?)?;
    drop(progress);
    let report = summary.report(&plan, loaded.as_secs_f64(), start.elapsed().as_secs_f64());
    global.report(args.json, report, || text(&args.output, &plan, &summary, &report))?;
    Ok(ExitStatus::Passed)
}

struct Work<'a> {
    plan: &'a CapturePlan,
    scene: &'a Scene,
    args: &'a Args,
    global: &'a GlobalArgs,
    progress: &'a Progress,
}

impl Work<'_> {
    /// Resumes if asked, and keeps the images on failure.
    fn capture(&self, mut folder: PartialFolder) -> Result<CaptureSummary> {
        if !folder.is_locked() {
            self.say("the file system has no locks: do not capture into this folder twice at the same time");
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
                "{images} of {all} images are kept in {}; the same command with --resume continues",
                folder.work_path().display()
            );
            Error::Unfinished { cause: Box::new(error), safe }
        })
    }

    /// Keeps or discards the images of an earlier capture.
    fn begin(&self, folder: &mut PartialFolder, now: &Fingerprint) -> Result<ExistingImages> {
        let (left, images) = (folder.state()?, folder.files());
        if self.args.resume && images > 0 {
            let begun: Vec<(String, String)> =
                serde_json::from_str(&left).map_err(|_| self.cannot("its state is damaged"))?;
            if let Some(difference) = Fingerprint(begun).difference(now) {
                return Err(self.cannot(&difference));
            }
            self.say(&format!("resuming with {images} of {} images", self.plan.image_count()));
            return Ok(ExistingImages::Keep);
        }
        if self.args.resume {
            self.say("nothing to resume; starting anew");
        } else if images > 0 {
            self.say(&format!(
                "replacing an unfinished capture of {}; --resume would continue it",
                counted(images, "image")
            ));
        }
        let state = serde_json::to_string_pretty(&now.0)
            .map_err(|error| Error::invalid(format!("the state of the capture: {error}")))?;
        folder.start_over(&state)?;
        Ok(ExistingImages::Overwrite)
    }

    fn cannot(&self, difference: &str) -> Error {
        Error::Usage(format!(
            "{}: cannot resume the unfinished capture: {difference}; repeat its options, or leave out --resume to start \
             anew",
            self.args.output.display()
        ))
    }

    fn say(&self, words: &str) {
        self.global.note(format_args!("{}: {words}", self.args.output.display()));
    }

    fn fingerprint(&self) -> Fingerprint {
        let mut fields = Fingerprint::of_program();
        fields.extend(self.plan.options());
        fields.push(("the contents of the scene", self.scene.contents().to_owned()));
        fields.push(("--animation", self.args.animation.clone().unwrap_or_else(|| "the first".to_owned())));
        // Sines and roots are rounded by the system's library.
        fields.push(("the kind of machine", format!("{} {}", std::env::consts::OS, std::env::consts::ARCH)));
        Fingerprint(fields.into_iter().map(|(name, value)| (name.to_owned(), value)).collect())
    }
}

fn text(path: &Path, plan: &CapturePlan, summary: &CaptureSummary, report: &CaptureReport) -> String {
    let [near_m, far_m] = summary.depth_range_m;
    let range = if near_m <= far_m {
        format!(", depths of {near_m:.3} to {far_m:.3} m")
    } else if plan.passes.contains(&Pass::Depth) {
        ", no surface visible".to_owned()
    } else {
        String::new()
    };
    let kept = match summary.kept_images {
        0 => String::new(),
        count => format!(" ({count} resumed)"),
    };
    let (probes, frames) = (plan.cameras.cameras.len() as u64, plan.frames.count());
    format!(
        "{}: {}, {}, {}{kept}, {}{range}; {:.2} M rays, {:.2} M a second, {:.2} s",
        path.display(),
        counted(probes, "probe"),
        counted(frames, "frame"),
        counted(summary.images, "image"),
        human_bytes(summary.bytes),
        summary.rays as f64 / 1e6,
        report.rays_per_second / 1e6,
        report.seconds,
    )
}
