//! `lightfold simplify INPUT -o scene.glb`: a still scene as textured quads under budgets.

mod args;
mod plot;
mod report;

use std::io::Write;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use crate::cli::output;
use crate::cli::progress::Progress;
use crate::cli::{ExitStatus, GlobalArgs};
use crate::error::{Error, Result};
use crate::files::OutputFile;
use crate::memory::Need;
use crate::simplify::capture::Capture;
use crate::simplify::export::{self, OutputBytes, Scene};
use crate::simplify::fidelity::compare;
use crate::simplify::memory::bytes;
use crate::simplify::pipeline::{self, Settings, Simplified};

pub use args::Args;
use report::Report;

pub fn run(args: &Args, global: &GlobalArgs) -> Result<ExitStatus> {
    args.check()?;
    let begun = Instant::now();
    let settings = args.settings()?;
    let mut capture = Capture::open(&args.input, args.frames)?;
    capture.notes.iter().for_each(|note| global.note(note));
    let mut held_out = args.held_out.as_deref().map(|path| Capture::open(path, args.frames)).transpose()?;
    let held_out_images = held_out.as_ref().map_or(0, |capture| capture.images.len());
    let all = std::iter::once(&capture).chain(&held_out);
    let need = Need {
        what: "simplifying",
        fixed: all.map(|capture| bytes(capture, &settings)).max().unwrap_or(0),
        each: 0,
        instead: "fewer `pixels_per_degree`",
    };
    args.memory.get().at_once(&need, 1)?;
    let is_evaluated = args.is_evaluated();
    let evaluated_images = held_out_images + if is_evaluated { capture.images.len() } else { 0 };
    let steps = pipeline::steps(capture.images.len()) + evaluated_images as u64;
    let progress = Progress::start(global, "simplifying", steps)?;
    let mut simplified =
        pipeline::simplify(&mut capture, &settings, &progress).map_err(|error| error.in_file(&args.input))?;
    let mut evaluate = || simplified.evaluate(&mut capture, settings.background, &progress);
    let evaluation = is_evaluated.then(&mut evaluate).transpose()?;
    let mut compare = |capture: &mut Capture| compare(&simplified.scene, capture, settings.background, &progress);
    let held_out = held_out.as_mut().map(&mut compare).transpose()?;
    simplified.stages.evaluate = evaluation.map_or(Duration::ZERO, |evaluation| evaluation.duration);
    let figures = match &args.plot {
        Some(folder) => plot::write(folder, &simplified, &mut capture, settings.background)?,
        None => Vec::new(),
    };
    drop(progress);
    simplified.notes.iter().for_each(|note| global.note(note));
    let writing = Instant::now();
    let files = write(args, &settings, (&simplified, capture.frame()))?;
    simplified.stages.export = writing.elapsed();
    let scenes = (&simplified, evaluation.as_ref(), held_out.as_ref());
    let report = Report::new(scenes, args, (files, figures), begun.elapsed());
    global.report(args.json, &report, || report.text())?;
    if args.stats && !args.json {
        output::print_text(&report.stats()?)?;
    }
    Ok(ExitStatus::Passed)
}

/// Writes all files, each whole or not at all, and none where one cannot be made. Answers their bytes.
fn write(args: &Args, settings: &Settings, (simplified, frame): (&Simplified, u32)) -> Result<Vec<(PathBuf, u64)>> {
    let scene = Scene {
        quads: &simplified.scene,
        region: &simplified.region,
        budgets: &settings.budgets,
        frame,
        atlas: settings.atlas,
        coordinates: settings.texture_coordinates,
        surfaces: simplified.surfaces.as_ref(),
    };
    let mut written = Vec::new();
    for OutputBytes { path, bytes } in export::files(&scene, &args.outputs())? {
        let mut file = OutputFile::create(&path)?;
        let result = file.write_all(&bytes);
        result.map_err(|error| output::name_output(Error::io(&path, error), &path))?;
        written.push((file, path, bytes.len() as u64));
    }
    let commit = |(mut file, path, bytes): (OutputFile, PathBuf, u64)| file.commit().map(|()| (path, bytes));
    written.into_iter().map(commit).collect()
}
