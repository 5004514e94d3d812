//! `lightfold capture SCENE -o DIR`: renders a scene as a dataset.

mod args;
mod options;

use std::path::Path;
use std::time::Instant;

use crate::output::human_bytes;
use crate::progress::Progress;
use crate::unfinished_folder::UnfinishedFolder;
use crate::{ExitStatus, GlobalArgs, refuse};
use codec::error::{Error, Result, counted};
use footage::dataset::manifest::{Keep, MANIFEST_NAME, Manifest};
use footage::encode::Shard;
use footage::files::PartialFolder;
use footage::fingerprint::Fingerprint;
use scene::capture::CaptureReport;
use scene::capture::write::UNFINISHED;
use scene::{CapturePlan, CaptureSummary, Pass, Play, Scene};

pub use args::{Args, parse_size};

pub fn run(args: &Args, global: &GlobalArgs) -> Result<ExitStatus> {
    let start = Instant::now();
    if args.output == Path::new("-") {
        return refuse("standard output cannot hold a dataset: specify a folder");
    }
    let manifest = args.output.join(MANIFEST_NAME);
    let cameras = args.cameras.as_ref().and_then(|path| path.canonicalize().ok());
    if cameras.is_some() && manifest.canonicalize().ok() == cameras {
        let path = manifest.display();
        return refuse(format!("{path}: the camera file would be overwritten: specify another folder"));
    }
    let (cameras, viewers) = args.read_cameras()?;
    let play = Play::of(args.animation.as_deref());
    let (scene, account) = Scene::open(&args.scene, play)?;
    args.account.notes(&account, global);
    let done = args.plan(&scene, cameras, viewers).and_then(|plan| capture(args, &scene, &plan, start, global));
    let done = args.account.print_if_failed(done, &account, global)?;
    args.account.report((&account, args.json), done.report, || done.text, global)?;
    Ok(ExitStatus::Passed)
}

/// A complete capture.
struct Captured {
    report: CaptureReport,
    text: String,
}

fn capture(args: &Args, scene: &Scene, plan: &CapturePlan, start: Instant, global: &GlobalArgs) -> Result<Captured> {
    let manifest = args.output.join(MANIFEST_NAME);
    plan.manifest()?;
    if manifest.is_file() {
        let old = Manifest::read(&args.output)?;
        let bytes = std::fs::read(&manifest).map_err(|error| Error::io(&manifest, error))?;
        if args.shard.is_some() && bytes != plan.manifest_keeping(keep_of(&old))?.to_json()?.into_bytes() {
            return refuse(format!(
                "{}: the folder has a different dataset, which shards of this capture would be mixed with: specify a \
                new folder",
                args.output.display()
            ));
        }
        plan.check_replaces(&old).map_err(|error| error.context(args.output.display()))?;
    }
    args.notes(scene, plan).iter().for_each(|note| global.note(note));
    let loaded = start.elapsed();
    let progress = Progress::start(global, "capturing", plan.image_count())?;
    let work = Work { plan, scene, args, global, progress: &progress };
    let part = args.shard.map_or_else(String::new, |Shard { number, count }| format!(".{number}-of-{count}"));
    let summary = work.capture(PartialFolder::open_part(&args.output, UNFINISHED, &part)?)?;
    drop(progress);
    let report = summary.report(plan, loaded.as_secs_f64(), start.elapsed().as_secs_f64());
    let text = text(&args.output, plan, &summary, &report);
    Ok(Captured { report, text })
}

struct Work<'a> {
    plan: &'a CapturePlan,
    scene: &'a Scene,
    args: &'a Args,
    global: &'a GlobalArgs,
    progress: &'a Progress,
}

impl Work<'_> {
    /// Captures into the folder. Resumes if requested, and keeps the images on failure.
    fn capture(&self, folder: PartialFolder) -> Result<CaptureSummary> {
        let mut unfinished = UnfinishedFolder::new(folder, &self.args.output, "capture");
        let all = self.plan.image_count();
        unfinished.begin(&self.fingerprint(), all, (self.args.resume, self.global))?;
        let done = self.plan.write_images(self.scene, &unfinished.folder, self.progress);
        let done = done.and_then(|summary| {
            let keep = summary.keep.or_else(|| self.keep_of_other_shards());
            let manifest = self.plan.manifest_keeping(keep)?.to_json()?;
            unfinished.folder.commit(Some((MANIFEST_NAME, manifest.as_bytes()))).map(|()| summary)
        });
        done.map_err(|error| unfinished.stopped(error, all))
    }

    /// Returns how colour is kept according to the shards that are complete already.
    fn keep_of_other_shards(&self) -> Option<Keep> {
        self.args.shard?;
        Manifest::read(&self.args.output).ok().and_then(|manifest| keep_of(&manifest))
    }

    fn fingerprint(&self) -> Fingerprint {
        let mut fields = Fingerprint::of_program(&[codec::SOURCES, footage::SOURCES, scene::SOURCES]);
        fields.extend(self.plan.options());
        fields.push(("the content of the scene", self.scene.contents().to_owned()));
        fields.push(("`animation`", self.args.animation.clone().unwrap_or_else(|| "all".to_owned())));
        // Sines and square roots are rounded by the system's library.
        fields.push(("the kind of machine", format!("{} {}", std::env::consts::OS, std::env::consts::ARCH)));
        Fingerprint(fields.into_iter().map(|(name, value)| (name.to_owned(), value)).collect())
    }
}

fn keep_of(manifest: &Manifest) -> Option<Keep> {
    manifest.color.as_ref().and_then(|color| color.keep)
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
