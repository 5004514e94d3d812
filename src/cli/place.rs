//! `lightfold place SCENE --region BOX -o cameras.json`: places cameras for coverage.

mod args;
mod report;

use std::path::{Path, PathBuf};
use std::time::Instant;

use glam::DVec3;

use crate::options::{EFFORTS, word_of};
use crate::progress::Progress;
use crate::report::placement as figures;
use crate::report::plot::save;
use crate::{ExitStatus, GlobalArgs, output, refuse};
use codec::error::Result;
use footage::dataset::cameras::{CameraSet, PlacedCamera};
use footage::files::OutputFolder;
use scene::placement::report::DecayPlacement;
use scene::placement::search::{self, Extent};
use scene::placement::{Lighting, Placement, Region, Search};
use scene::{Play, Scene};

pub use args::Args;
use args::SPECULAR;
use report::Report;

pub fn run(args: &Args, global: &GlobalArgs) -> Result<ExitStatus> {
    args.check()?;
    let begun = Instant::now();
    let region = Region::parse(&args.region)?;
    let start = args.start.as_deref().map(CameraSet::read).transpose()?;
    let play = Play::of(args.animation.as_deref());
    let (scene, account) = Scene::open(&args.scene, play)?;
    account.left_out.iter().for_each(|note| global.note(note));
    let settings = args.settings();
    let range = args.frames(&scene)?;
    // Static scenes are sampled once.
    let most = if scene.duration_s() > 0.0 { Extent::of(settings.effort).time_samples } else { 1 };
    let frames = search::sample_frames(range, most);
    let times = frames.iter().map(|frame| scene.at(f64::from(*frame) / args.fps())).collect();
    let progress = Progress::start(global, "looking", settings.counts().0 as u64)?;
    let mut search = Search::new(times, &region, &settings, &progress)?;
    drop(progress);
    let mut positions = Vec::new();
    if let Some(set) = &start {
        positions.extend(set.cameras.iter().map(|camera| DVec3::from(camera.position)));
        for name in
            (0..positions.len()).filter(|&at| !search.free_space().admits(positions[at])).map(|at| set.name_of(at))
        {
            global.note(format_args!("camera {name} is outside the free part of the region; it is kept"));
        }
    }
    let started = positions.len();
    if let Some(count) = args.uniform {
        positions.extend(search.free_space().hammersley(count as usize)?);
    }
    let progress = Progress::start(global, "placing", u64::from(args.cameras.unwrap_or(0)))?;
    let place = |search: &Search<'_>, lighting: Lighting| -> Result<Placement> {
        Ok(Placement { started, ..search.place(lighting, &positions, args.stop(), &progress)? })
    };
    let placement = place(&search, args.lighting())?;
    if placement.cameras.is_empty() {
        return refuse("no camera was placed: nothing is visible from the region, or --until is too large");
    }
    let is_compared = args.plot.is_some() || args.csv.is_some();
    let other = if args.lighting == Lighting::Diffuse { SPECULAR } else { Lighting::Diffuse };
    let comparison = is_compared.then(|| place(&search, other)).transpose()?;
    let rate_per_m = search.problem.rate_per_m;
    let mut decays = Vec::new();
    for k in &args.compare_k {
        search.problem.rate_per_m = *k;
        decays.push(DecayPlacement { rate_per_m: *k, placement: place(&search, args.lighting())? });
    }
    search.problem.rate_per_m = rate_per_m;
    drop(progress);
    let seconds = begun.elapsed().as_secs_f64();
    let set = camera_set(args, start, &placement, &search);
    let report =
        Report { args, search: &search, placement: &placement, comparison, decays, set: &set, range, frames, seconds };
    report.notes().iter().for_each(|note| global.note(note));
    let files = write(&report)?;
    if args.json {
        output::print_json(&report.json(&files))?;
    } else if !global.quiet {
        let text = report.text(&files);
        if args.output == Path::new("-") { output::note(text.trim_end()) } else { output::print_text(&text)? }
    }
    Ok(ExitStatus::Passed)
}

fn camera_set(args: &Args, start: Option<CameraSet>, placement: &Placement, search: &Search<'_>) -> CameraSet {
    let mut cameras: Vec<PlacedCamera> = start.as_ref().map_or(Vec::new(), |set| set.cameras.clone());
    let mut taken: Vec<String> =
        start.iter().flat_map(|set| (0..set.cameras.len()).map(|at| set.name_of(at))).collect();
    // Default names depend on the number of cameras; given names are kept.
    let grown = CameraSet::new(vec![PlacedCamera::at([0.0; 3]); placement.cameras.len()]);
    let has_names = (0..taken.len()).any(|at| taken[at] != grown.name_of(at));
    if has_names {
        cameras.iter_mut().zip(&taken).for_each(|(camera, name)| camera.name = Some(name.clone()));
    }
    for (at, placed) in placement.cameras.iter().enumerate().skip(placement.started) {
        let mut camera = PlacedCamera::at(placed.position.to_array());
        camera.gain = Some(placed.gain);
        camera.coverage = Some(placed.figures.coverage);
        if has_names {
            // The next unused number.
            let free = (at..).map(|number| format!("{number:02}")).find(|name| !taken.contains(name));
            taken.extend(free.clone());
            camera.name = free;
        }
        cameras.push(camera);
    }
    let mut set = CameraSet::new(cameras);
    set.extra = Some(serde_json::json!({
        "placed_for": {
            "scene": args.scene,
            "region": args.region,
            "lighting": placement.lighting.name(),
            "theta_deg": placement.lighting.theta_deg(),
            "k_per_m": search.problem.rate_per_m,
            "min_distance_m": search.min_distance_m,
            "effort": word_of(EFFORTS, &args.effort),
            "candidates": search.visible_sets.len(),
            "surface_samples": search.sampled.point_count(),
        }
    }));
    set
}

/// Writes all files, the cameras last, and returns their paths.
fn write(report: &Report<'_>) -> Result<Vec<PathBuf>> {
    let args = report.args;
    let mut files = Vec::new();
    if let Some(folder) = &args.plot {
        let out = OutputFolder::create(folder)?;
        for (name, drawing) in figures::all(&report.curves(), &report.decays()) {
            let written = save(&drawing, out.work_path(), name).map_err(|error| out.present(error))?;
            files.extend(written.iter().filter_map(|path| Some(folder.join(path.file_name()?))));
        }
        out.commit()?;
    }
    if let Some(path) = &args.csv {
        output::write_file(path, &report.csv()?)?;
        files.push(path.clone());
    }
    output::write_file(&args.output, &report.set.to_json()?)?;
    files.push(args.output.clone());
    Ok(files)
}
