//! A demo scene captured to files: EXR sequences and the `lightfield.json` that describes them.
//!
//! Enters: which scene, how many frames and probes, how large. Leaves: a folder that is a dataset, as a renderer would
//! have left it. The bytes depend on nothing but the plan.

use std::path::Path;

use glam::DVec3;
use rayon::prelude::*;

use super::capture::{MAX_FACE_SIZE, capture_face};
use super::procedural::{DemoKind, DemoScene};
use crate::dataset::manifest::{self, MANIFEST_NAME, MANIFEST_VERSION, Manifest};
use crate::dataset::stream::{Projection, StreamKind};
use crate::error::{Error, Result};
use crate::image::{Face, exr};
use crate::monitor::Monitor;

/// Frames per second of captured footage.
pub const FPS: f64 = 24.0;

/// What to capture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FootagePlan {
    /// The scene.
    pub kind: DemoKind,
    /// Number of frames, at least 1; the first is frame 0.
    pub frames: u32,
    /// Width and height of a face in pixels, 1 to [`MAX_FACE_SIZE`].
    pub face_size: u32,
    /// Number of probes, at least 1.
    pub probes: u32,
}

impl FootagePlan {
    /// Faces that [`Self::write`] captures, each with colour and depth.
    pub fn face_count(&self) -> u64 {
        u64::from(self.frames) * u64::from(self.probes) * Face::CUBE.len() as u64
    }

    /// Where the probes stand: evenly along the diagonal of the region that the scene keeps free, or in its middle.
    pub fn positions(&self) -> Vec<DVec3> {
        let (middle, reach) = DemoScene::new(self.kind).probe_region();
        let last = f64::from(self.probes.saturating_sub(1));
        let along = |probe: u32| if last == 0.0 { 0.0 } else { 2.0 * f64::from(probe) / last - 1.0 };
        (0..self.probes).map(|probe| middle + along(probe) * reach).collect()
    }

    /// The manifest of the dataset.
    ///
    /// # Errors
    /// When a number of the plan is out of its range.
    pub fn manifest(&self) -> Result<Manifest> {
        let FootagePlan { frames, face_size, probes, .. } = *self;
        if frames == 0 || probes == 0 || face_size == 0 || face_size > MAX_FACE_SIZE {
            return Err(Error::Usage(format!(
                "footage of {frames} frames and {probes} probes of {face_size} pixels: at least one frame and probe, \
                 and faces of 1 to {MAX_FACE_SIZE} pixels were expected"
            )));
        }
        let files = |kind: StreamKind| Some(format!("probe_{{probe}}/face_{{face}}/{}.%04d.exr", kind.name()));
        let probe = |(at, position): (usize, DVec3)| manifest::Probe {
            name: format!("{at:02}"),
            position: position.to_array(),
            frames: None,
            orientation: None,
            fov_y_deg: None,
            intrinsics: None,
            extra: None,
        };
        Ok(Manifest {
            lightfield: MANIFEST_VERSION,
            name: self.kind.name().to_owned(),
            fps: FPS,
            frames: [0, frames - 1],
            projection: Projection::Cubemap,
            size: [face_size; 2],
            faces: Some(manifest::FaceFiles::Six),
            faces_present: None,
            depth: Some(manifest::DepthInfo::default()),
            color: Some(manifest::ColorInfo { space: manifest::ManifestColorSpace::LinearRec709 }),
            material: None,
            files: manifest::Files { color: files(StreamKind::Color), depth: files(StreamKind::Depth), material: None },
            probes: self.positions().into_iter().enumerate().map(probe).collect(),
            extra: None,
        })
    }

    /// Captures everything into `folder`, which exists, frames in parallel. The monitor advances by one for each face.
    ///
    /// # Errors
    /// When a number of the plan is out of its range, a file cannot be written, or the monitor is interrupted.
    pub fn write(&self, folder: &Path, monitor: &dyn Monitor) -> Result<Manifest> {
        let manifest = self.manifest()?;
        let scene = DemoScene::new(self.kind);
        for probe in &manifest.probes {
            for face in Face::CUBE {
                let file = file(&manifest, StreamKind::Depth, &probe.name, face, 0)?;
                let parent = folder.join(file.parent().unwrap_or(Path::new("")));
                std::fs::create_dir_all(&parent).map_err(|error| Error::io(&parent, error))?;
            }
        }
        (0..self.frames).into_par_iter().try_for_each(|frame| {
            let moment = scene.at(f64::from(frame) / FPS);
            for probe in &manifest.probes {
                for face in Face::CUBE {
                    monitor.check()?;
                    let (color, depth) = capture_face(&moment, probe.position.into(), face, self.face_size)?;
                    let path = |kind| file(&manifest, kind, &probe.name, face, frame).map(|file| folder.join(file));
                    exr::write_color(&path(StreamKind::Color)?, &color)?;
                    exr::write_depth(&path(StreamKind::Depth)?, &depth)?;
                    monitor.advance(1);
                }
            }
            Ok(())
        })?;
        let path = folder.join(MANIFEST_NAME);
        std::fs::write(&path, manifest.to_json()?).map_err(|error| Error::io(&path, error))?;
        Ok(manifest)
    }
}

/// The file of one image, relative to the manifest.
fn file(manifest: &Manifest, kind: StreamKind, probe: &str, face: Face, frame: u32) -> Result<std::path::PathBuf> {
    let pattern = manifest.pattern(kind, probe, face)?;
    let pattern = pattern.ok_or_else(|| Error::invalid(format!("the manifest names no {} files", kind.name())))?;
    Ok(pattern.path(frame))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dataset::source::{Source, SourceOptions};
    use crate::monitor::Silent;

    const PLAN: FootagePlan = FootagePlan { kind: DemoKind::Courtyard, frames: 2, face_size: 8, probes: 2 };

    #[test]
    fn what_is_written_is_what_was_captured() {
        let folder = tempfile::tempdir().unwrap();
        let manifest = PLAN.write(folder.path(), &Silent).unwrap();
        assert_eq!(Manifest::read(folder.path()).unwrap(), manifest);
        let source = Source::open(folder.path(), &SourceOptions::default()).unwrap();
        assert_eq!(source.groups().len(), 2 * 2 * 6);
        let moment = DemoScene::new(PLAN.kind).at(1.0 / FPS);
        for group in source.groups() {
            let position = PLAN.positions()[group.probe];
            let (color, depth) = capture_face(&moment, position, group.faces[0], PLAN.face_size).unwrap();
            match group.kind {
                StreamKind::Color => assert_eq!(source.read_color(group, 1).unwrap(), [color]),
                _ => assert_eq!(source.read_depth(group, 1).unwrap(), [depth]),
            }
        }
    }

    #[test]
    fn probes_stay_inside_the_region() {
        for probes in [1, 2, 3, 9] {
            let (middle, reach) = DemoScene::new(PLAN.kind).probe_region();
            let positions = FootagePlan { probes, ..PLAN }.positions();
            assert_eq!(positions.len(), probes as usize);
            assert!(positions.iter().all(|at| (*at - middle).abs().cmple(reach + 1e-12).all()));
        }
        assert_eq!(FootagePlan { probes: 1, ..PLAN }.positions()[0], DemoScene::new(PLAN.kind).probe_region().0);
    }

    #[test]
    fn plans_that_make_no_sense_are_refused() {
        for plan in [
            FootagePlan { frames: 0, ..PLAN },
            FootagePlan { probes: 0, ..PLAN },
            FootagePlan { face_size: 0, ..PLAN },
            FootagePlan { face_size: MAX_FACE_SIZE + 1, ..PLAN },
        ] {
            assert!(plan.manifest().is_err(), "{plan:?}");
        }
    }
}
