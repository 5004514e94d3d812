//! `lightfold simplify INPUT -o scene.glb`: converts a still scene to textured quads under budgets.

mod args;
mod report;
mod unfinished;

use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use crate::outputs::{self, Output};
use crate::progress::Progress;
use crate::report::simplification;
use crate::{ExitStatus, GlobalArgs, output, refuse};
use codec::error::{Error, Result};
use codec::monitor::Monitor;
use footage::account::Account;
use footage::dataset::manifest::manifest_path;
use footage::files::OutputFile;
use simplify::capture::Capture;
use simplify::export::{self, OutputBytes, Scene};
use simplify::fidelity::compare;
use simplify::memory::check_images;
use simplify::pipeline::{self, Simplified, texture};
use simplify::selected::{SelectedTiles, select};
use simplify::settings::Settings;

pub use args::Args;
use report::{Compared, Report};
use unfinished::UnfinishedScene;

pub fn run(args: &Args, global: &GlobalArgs) -> Result<ExitStatus> {
    args.check()?;
    let begun = Instant::now();
    let capture = Capture::open(&args.input, args.frames)?;
    let account = capture.account()?;
    args.account.notes(&account, global);
    args.account.print_if_failed(simplify(args, capture, account.clone(), begun, global), &account, global)
}

fn simplify(
    args: &Args,
    mut capture: Capture,
    mut account: Account,
    begun: Instant,
    global: &GlobalArgs,
) -> Result<ExitStatus> {
    let settings = args.settings()?;
    let mut held_out = args.held_out.as_deref().map(|path| Capture::open(path, args.frames)).transpose()?;
    let held_out_images = held_out.as_ref().map_or(0, |capture| capture.images.len());
    let evaluated = Some(&capture).filter(|_| args.is_evaluated());
    let compared: Vec<&Capture> = evaluated.into_iter().chain(&held_out).collect();
    check_images(&[&capture], &compared, settings.memory)?;
    let evaluated_images = held_out_images + if args.is_evaluated() { capture.images.len() } else { 0 };
    let steps = pipeline::steps(capture.images.len()) + evaluated_images as u64;
    let progress = Progress::start(global, "simplifying", steps)?;
    let captures: Vec<&Capture> = std::iter::once(&capture).chain(&held_out).collect();
    check_outputs(args, &captures)?;
    let fingerprint = unfinished::fingerprint(args, &settings, &capture);
    let (mut unfinished, words) = UnfinishedScene::open(args, fingerprint, global)?;
    let selected = match words {
        Some(words) => {
            progress.advance(capture.images.len() as u64);
            SelectedTiles::of_words(&words, &mut capture, &settings)?
                .ok_or_else(|| unfinished.cannot("its state is damaged"))?
        }
        None => select(&mut capture, &settings, &progress).map_err(|error| error.in_file(&args.input))?,
    };
    unfinished.keep_tiles(&selected.to_words())?;
    let mut simplified = texture(selected, &mut capture, &settings, &progress)
        .map_err(|error| unfinished.stopped(error.in_file(&args.input)))?;
    let outputs = Outputs { args, settings: &settings, progress };
    let done = outputs.compare_and_write(&mut simplified, &mut capture, held_out.as_mut(), &mut unfinished.file);
    let compared = done.map_err(|error| unfinished.stopped(error))?;
    simplified.notes.iter().for_each(|note| global.note(note));
    let report = Report::new(&simplified, &compared, args, begun.elapsed());
    account.left_out.extend(simplified.notes);
    args.account.report((&account, args.json), &report, || report.text(), global)?;
    if args.stats && !args.json {
        output::print_text(&report.stats()?)?;
    }
    Ok(ExitStatus::Passed)
}

/// Fails if an output is an input or another output, or cannot be created.
fn check_outputs(args: &Args, captures: &[&Capture]) -> Result<()> {
    let mut all: Vec<Output> = args.outputs().all().into_iter().map(|path| (option_of(args, &path), path)).collect();
    for (option, path) in &all {
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
        if let Some(folder) = folder.filter(|folder| !folder.is_dir()) {
            let folder = folder.display();
            return refuse(format!("{option} {}: there is no folder {folder}; create it first", path.display()));
        }
        if path.is_dir() {
            return refuse(format!("{}: this is a folder; a file name was expected", path.display()));
        }
    }
    if let Some(path) = &args.plot {
        if path.exists() && !path.is_dir() {
            return refuse(format!("--plot {}: this is a file; a folder was expected", path.display()));
        }
        all.push(("--plot", path.clone()));
    }
    let of_path = |path: &PathBuf| [path.clone(), manifest_path(path)];
    let named = [&args.input].into_iter().chain(&args.held_out).flat_map(of_path);
    let meshes = args.region.iter().map(PathBuf::from);
    let inputs: Vec<PathBuf> =
        captures.iter().flat_map(|capture| capture.all_files()).chain(named).chain(meshes).collect();
    outputs::check(&all, &inputs.iter().map(PathBuf::as_path).collect::<Vec<_>>())
}

/// Returns the option that names an output.
fn option_of(args: &Args, path: &Path) -> &'static str {
    if args.ktx2.as_deref() == Some(path) { "--ktx2" } else { "-o" }
}

/// Evaluates and writes the outputs of a simplified scene.
struct Outputs<'a> {
    args: &'a Args,
    settings: &'a Settings,
    progress: Progress,
}

impl Outputs<'_> {
    fn compare_and_write(
        self,
        simplified: &mut Simplified,
        capture: &mut Capture,
        held_out: Option<&mut Capture>,
        scene: &mut OutputFile,
    ) -> Result<Compared> {
        let Outputs { args, settings, progress } = self;
        let evaluation = args.is_evaluated().then(|| simplified.evaluate(capture, settings, &progress)).transpose()?;
        simplified.stages.evaluate = evaluation.map_or(Duration::ZERO, |evaluation| evaluation.duration);
        let held_out = held_out.map(|capture| compare(&simplified.scene, capture, settings, &progress)).transpose()?;
        let figures = match &args.plot {
            Some(folder) => simplification::write(folder, simplified, capture, settings.background)?,
            None => Vec::new(),
        };
        drop(progress);
        let writing = Instant::now();
        let files = write(args, settings, simplified, capture.frame(), scene)?;
        simplified.stages.export = writing.elapsed();
        Ok(Compared { evaluation, held_out, files, figures })
    }
}

/// Writes all files, each completely or not at all, and none if one cannot be created. Returns their paths and sizes in
/// bytes.
fn write(
    args: &Args,
    settings: &Settings,
    simplified: &Simplified,
    frame: u32,
    scene_file: &mut OutputFile,
) -> Result<Vec<(PathBuf, u64)>> {
    let scene = Scene {
        quads: &simplified.scene,
        region: &simplified.region,
        budgets: &settings.budgets,
        frame,
        atlas: settings.atlas,
        coordinates: settings.texture_coordinates,
        surfaces: simplified.surfaces.as_ref(),
    };
    let (mut beside, mut written) = (Vec::new(), Vec::new());
    for OutputBytes { path, bytes } in export::files(&scene, &args.outputs())? {
        let named = |error| output::name_output(Error::io(&path, error), &path);
        if path == args.output {
            scene_file.write_all(&bytes).map_err(named)?;
        } else {
            let mut file = OutputFile::create(&path)?;
            file.write_all(&bytes).map_err(named)?;
            beside.push(file);
        }
        written.push((path, bytes.len() as u64));
    }
    beside.iter_mut().chain([scene_file]).try_for_each(OutputFile::commit)?;
    Ok(written)
}
