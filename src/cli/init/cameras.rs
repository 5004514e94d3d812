//! Poses and lenses of proposed probes, from a camera file next to the images.
//!
//! Takes a proposal whose images do not state their cameras. Sets the cameras of its probes from the file, by probe
//! name, or by frame if there is only one probe.

use std::path::{Path, PathBuf};

use codec::error::Result;
use codec::image::Projection;
use codec::image::sequence::split_number;
use evaluate::cameras::{self, FileCamera, FileCameras, ReadSettings, picture_stem};
use footage::dataset::Pose;
use footage::dataset::discover::Proposal;
use footage::dataset::manifest::{Manifest, Probe};

/// Names of camera files. Those of USD have any name.
const NAMES: [&str; 3] = ["transforms.json", "images.txt", "images.bin"];
const USD_ENDINGS: [&str; 4] = ["usd", "usda", "usdc", "usdz"];

/// Assigns the cameras of a file in the folder to the probes, if there is exactly one, and notes it. Returns true if they were
/// assigned.
pub fn place(folder: &Path, proposal: &mut Proposal) -> bool {
    let [file] = &files(folder)[..] else { return false };
    let name = file.file_name().unwrap_or_default().to_string_lossy();
    match read(file, &proposal.manifest) {
        Ok((Some(probes), notes)) => {
            proposal.manifest.probes = probes;
            let read = format!("cameras were read from {name}; the lens is that of the first frame");
            let moves = proposal.manifest.probes.iter().any(|probe| !probe.poses.is_empty());
            let still =
                "the images were taken for frames of a moving camera; if they are views of one moment, use --views";
            let still = moves.then(|| still.to_owned());
            proposal.unsure_of_cameras = [read].into_iter().chain(still).chain(notes).collect();
            return true;
        }
        Ok((None, _)) => proposal.unsure_of_cameras.push(format!(
            "{name} was ignored: its cameras neither have the names of the probes, nor are they one for each frame of \
            a single probe"
        )),
        Err(error) => proposal.unsure_of_cameras.push(format!("{name} was ignored: {error}")),
    }
    false
}

fn files(folder: &Path) -> Vec<PathBuf> {
    let is_of_cameras = |path: &PathBuf| {
        let name = path.file_name().unwrap_or_default().to_string_lossy().to_lowercase();
        let is_usd = name.rsplit_once('.').is_some_and(|(_, ending)| USD_ENDINGS.contains(&ending));
        is_usd || NAMES.contains(&name.as_str())
    };
    let all = std::fs::read_dir(folder).into_iter().flatten().filter_map(|entry| Some(entry.ok()?.path()));
    all.filter(is_of_cameras).collect()
}

/// Returns the probes with the cameras of a file, and what of the file was left out. No probes if the cameras do not match them.
fn read(file: &Path, manifest: &Manifest) -> Result<(Option<Vec<Probe>>, Vec<String>)> {
    let FileCameras { cameras, notes } = cameras::read(file, ReadSettings::with_fps(manifest.fps))?;
    Ok((matched(&cameras, manifest), notes))
}

/// Returns the probes with their cameras. `None` if the cameras do not match the probes.
fn matched(cameras: &[FileCamera], manifest: &Manifest) -> Option<Vec<Probe>> {
    let named = |probe: &Probe| {
        let mut of_name = cameras.iter().filter(|camera| picture_stem(&camera.name) == probe.name);
        let camera = of_name.next()?;
        of_name.next().is_none().then(|| still(probe, camera, manifest))
    };
    if let Some(probes) = manifest.probes.iter().map(named).collect() {
        return Some(probes);
    }
    let [probe] = &manifest.probes[..] else { return None };
    let frames = manifest.frame_range();
    let poses: Option<Vec<(Pose, &FileCamera)>> = match cameras {
        [only] if only.timed.frames.is_none_or(|of| of == frames) => {
            return Some(vec![still(probe, only, manifest)]);
        }
        all => frames.iter().map(|frame| Some((frame, of_frame(all, frame)?))).map(|of| of.map(pose)).collect(),
    };
    let poses = poses?;
    let intrinsics = poses.first().and_then(|(_, camera)| lens(camera, probe, manifest)).or(probe.intrinsics);
    let poses = poses.into_iter().map(|(pose, _)| pose).collect();
    Some(vec![Probe { position: None, orientation: None, poses, intrinsics, ..probe.clone() }])
}

/// Returns the only camera of a frame: by its stated frames, else by the number in the name of its picture.
fn of_frame(cameras: &[FileCamera], frame: u32) -> Option<&FileCamera> {
    let is_of = |camera: &&FileCamera| match camera.timed.frames {
        Some(frames) => frames.contains(frame),
        None => split_number(&camera.name).is_some_and(|(_, number, _)| number.parse() == Ok(frame)),
    };
    let mut found = cameras.iter().filter(is_of);
    found.next().filter(|_| found.next().is_none())
}

fn pose((frame, camera): (u32, &FileCamera)) -> (Pose, &FileCamera) {
    let of = &camera.timed.camera;
    let orientation = of.orientation().unwrap_or([0.0, 0.0, 0.0, 1.0]);
    (Pose { frame, position: of.eye().to_array(), orientation }, camera)
}

fn still(probe: &Probe, camera: &FileCamera, manifest: &Manifest) -> Probe {
    let of = &camera.timed.camera;
    let intrinsics = lens(camera, probe, manifest).or(probe.intrinsics);
    Probe {
        position: Some(of.eye().to_array()),
        orientation: of.orientation(),
        intrinsics,
        poses: Vec::new(),
        ..probe.clone()
    }
}

/// Returns fx, fy, cx, cy for perspective images.
fn lens(camera: &FileCamera, probe: &Probe, manifest: &Manifest) -> Option<[f64; 4]> {
    let is_perspective = manifest.projection == Projection::Perspective;
    is_perspective.then(|| camera.timed.camera.intrinsics(manifest.size_of(probe).map(f64::from)))
}
