//! Captures built-in scenes as datasets. The bytes depend only on the plan.

use std::path::Path;

use glam::DVec3;

use super::animated::Scene;
use super::capture::{COLOR_SAMPLES, CapturePlan, Pass};
use super::procedural::{DemoKind, DemoScene};
use codec::error::{Error, Result};
use codec::image::{DepthKind, FrameRange, Projection};
use codec::monitor::Monitor;
use footage::dataset::cameras::{CameraSet, PlacedCamera};
use footage::dataset::manifest::Manifest;

pub const FPS: f64 = 24.0;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FootagePlan {
    pub kind: DemoKind,
    /// At least 1.
    pub frames: u32,
    /// Width and height in pixels, 1 to [`super::capture::MAX_FACE_SIZE`].
    pub face_size: u32,
    /// At least 1.
    pub probes: u32,
}

impl FootagePlan {
    /// Returns probe positions evenly spaced along the diagonal of the scene's probe region; its centre for a single probe.
    pub fn positions(&self) -> Vec<DVec3> {
        let (middle, reach) = DemoScene::new(self.kind).probe_region();
        let last = f64::from(self.probes.saturating_sub(1));
        let along = |probe: u32| if last == 0.0 { 0.0 } else { 2.0 * f64::from(probe) / last - 1.0 };
        (0..self.probes).map(|probe| middle + along(probe) * reach).collect()
    }

    /// Returns the capture plan: distances, and colour with [`COLOR_SAMPLES`] samples per pixel. Fails without frames or
    /// probes.
    pub fn capture(&self) -> Result<CapturePlan> {
        let FootagePlan { kind, frames, face_size, probes } = *self;
        if frames == 0 || probes == 0 {
            return Err(Error::Usage(format!(
                "footage of {frames} frames and {probes} probes: at least one frame and probe were expected"
            )));
        }
        let camera = |(at, position): (usize, DVec3)| PlacedCamera {
            name: Some(format!("{at:02}")),
            ..PlacedCamera::at(position.to_array())
        };
        Ok(CapturePlan {
            name: kind.name().to_owned(),
            fps: FPS,
            frames: FrameRange { first: 0, last: frames - 1 },
            projection: Projection::Cubemap,
            size: [face_size; 2],
            cameras: CameraSet::new(self.positions().into_iter().enumerate().map(camera).collect()),
            fov_y_deg: None,
            passes: vec![Pass::Color, Pass::Depth],
            samples: COLOR_SAMPLES,
            depth: DepthKind::Distance,
            far_m: f64::INFINITY,
            part: None,
        })
    }

    /// Captures everything into `folder`. The monitor advances by one per image.
    pub fn write(&self, folder: &Path, monitor: &dyn Monitor) -> Result<Manifest> {
        let plan = self.capture()?;
        let summary = plan.write(&Scene::Procedural(DemoScene::new(self.kind)), folder, monitor)?;
        plan.manifest_keeping(summary.keep)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::capture::MAX_FACE_SIZE;
    use crate::capture_face;
    use codec::image::StreamKind;
    use codec::monitor::Silent;
    use footage::dataset::source::{Source, SourceOptions};

    const PLAN: FootagePlan = FootagePlan { kind: DemoKind::Courtyard, frames: 2, face_size: 8, probes: 2 };

    #[test]
    fn what_is_written_is_what_was_captured() {
        // Most of the street's second frame is copied from its first.
        for plan in [PLAN, FootagePlan { kind: DemoKind::Street, face_size: 40, ..PLAN }] {
            let folder = tempfile::tempdir().unwrap();
            let manifest = plan.write(folder.path(), &Silent).unwrap();
            assert_eq!(Manifest::read(folder.path()).unwrap(), manifest);
            let source = Source::open(folder.path(), &SourceOptions::default()).unwrap();
            assert_eq!(source.groups().len(), 2 * 2 * 6);
            let scene = DemoScene::new(plan.kind).at(1.0 / FPS);
            for group in source.groups() {
                let position = plan.positions()[group.probe];
                let (color, depth) = capture_face(&scene, position, group.faces[0], plan.face_size).unwrap();
                match group.kind {
                    StreamKind::Color => assert_eq!(source.read_color(group, 1).unwrap(), [color]),
                    _ => assert_eq!(source.read_depth(group, 1).unwrap(), [depth]),
                }
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
            assert!(plan.capture().and_then(|plan| plan.manifest()).is_err(), "{plan:?}");
        }
    }
}
