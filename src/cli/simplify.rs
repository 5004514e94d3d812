//! `lightfold simplify INPUT -o scene.glb`: a still scene as textured quads under budgets.

mod args;
mod report;

use std::time::Instant;

use serde_json::json;

use crate::cli::output;
use crate::cli::progress::Progress;
use crate::cli::{ExitStatus, GlobalArgs};
use crate::error::{Error, Result};
use crate::evaluate::reference::Reference;
use crate::files::OutputFile;
use crate::simplify::pipeline::{self, Simplified};
use crate::simplify::quad_mesh::write_glb;
use crate::simplify::samples::Capture;

pub use args::Args;
use report::Report;

pub fn run(args: &Args, global: &GlobalArgs) -> Result<ExitStatus> {
    args.check()?;
    let begun = Instant::now();
    let settings = args.settings()?;
    let mut reference = Reference::open(&args.input)?;
    let mut capture = Capture::new(&mut reference, settings.frame).map_err(|error| error.in_file(&args.input))?;
    let progress = Progress::start(global, "simplifying", pipeline::steps(capture.images.len()))?;
    let simplified =
        pipeline::simplify(&mut capture, &settings, &progress).map_err(|error| error.in_file(&args.input))?;
    drop(progress);
    simplified.notes.iter().for_each(|note| global.note(note));
    let bytes = write(args, &simplified)?;
    let report = Report::new(&simplified, args, bytes, begun.elapsed());
    global.report(args.json, &report, || report.text())?;
    Ok(ExitStatus::Passed)
}

/// Writes the mesh whole or not at all, and answers its bytes.
fn write(args: &Args, simplified: &Simplified) -> Result<u64> {
    let region = &simplified.region;
    let corners = [region.middle - region.half, region.middle + region.half];
    let extras = json!({ "lightfold": {
        "frame": args.frame,
        "viewing_region_m": corners.map(|corner| corner.to_array()),
        "triangles": args.triangles,
        "projected_area": args.area,
        "peak_overdraw": args.peak_overdraw,
        "atlas": args.atlas,
        "drawing_order": "back to front, as stored; blend without depth test, without culling, and without sorting",
    } });
    let mut bytes = Vec::new();
    write_glb(&simplified.scene, extras, &mut bytes)?;
    let mut file = OutputFile::create(&args.output)?;
    let written = std::io::Write::write_all(&mut file, &bytes);
    written.map_err(|error| output::name_output(Error::io(&args.output, error), &args.output))?;
    file.commit()?;
    Ok(bytes.len() as u64)
}
