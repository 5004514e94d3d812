//! Cameras and plan of `capture`.

use std::path::Path;

use glam::DVec3;

use super::args::Args;
use crate::refuse;
use codec::error::Result;
use codec::image::{FrameRange, Projection};
use codec::math::{Camera, Lens};
use evaluate::camera_file::CameraFile;
use footage::dataset::cameras::{CameraSet, PlacedCamera};
use scene::capture::frames_of_animation;
use scene::{CapturePlan, Pass, Scene};

/// Default side of a cube face. Panoramas are four times as wide.
const DEFAULT_SIDE: u32 = 512;

/// Kind of the cameras of a file.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Viewers {
    /// Probes.
    No,
    Yes,
}

impl Args {
    pub(super) fn read_cameras(&self) -> Result<(CameraSet, Viewers)> {
        let Some(path) = &self.cameras else {
            let cameras = self.position.iter().map(|position| self.camera_at(*position)).collect::<Result<_>>()?;
            return Ok((CameraSet::new(cameras), Viewers::No));
        };
        let path = if path.is_dir() { path.join(footage::dataset::manifest::MANIFEST_NAME) } else { path.clone() };
        let text = CameraSet::read_text(&path)?;
        let read = || match are_viewers(&text) {
            true => CameraFile::as_probes(&text).map(|set| (set, Viewers::Yes)),
            false => CameraSet::from_json(&text).map(|set| (set, Viewers::No)),
        };
        read().map_err(|error| error.in_file(&path))
    }

    fn camera_at(&self, position: DVec3) -> Result<PlacedCamera> {
        let at = PlacedCamera::at(position.to_array());
        let Some(target) = self.look_at else { return Ok(at) };
        let camera = Camera::look_at(position, target, DVec3::Y, Lens::new(self.fov.unwrap_or(90.0)))?;
        Ok(PlacedCamera { orientation: camera.orientation(), ..at })
    }

    pub(super) fn notes(&self, scene: &Scene, plan: &CapturePlan) -> Vec<String> {
        let mut notes = Vec::new();
        if let Scene::Model(model) = scene
            && model.is_lit_by_default()
        {
            notes.push("the scene has no lights: a sun and a sky are added, see --help".to_owned());
        }
        let (last, length_s) = (plan.frames.last, scene.duration_s());
        if length_s <= 0.0 {
            if plan.frames.count() > 1 {
                notes.push("nothing moves in the scene: all frames are equal".to_owned());
            }
        } else if let Ok(all) = frames_of_animation(length_s, plan.fps)
            && last > all.last
        {
            let then = match scene {
                Scene::Procedural(_) => "it repeats",
                Scene::Model(_) => "its last pose is held",
            };
            notes.push(format!("the animation has frames {}-{}; after the last frame {then}", all.first, all.last));
        }
        if plan.passes.contains(&Pass::Normal) {
            notes.push("encode ignores normals: containers do not store them".to_owned());
        }
        notes
    }

    /// Returns the plan with consistent sizes. [`CapturePlan::manifest`] checks the rest.
    pub(super) fn plan(&self, scene: &Scene, cameras: CameraSet, viewers: Viewers) -> Result<CapturePlan> {
        let usual = match viewers {
            Viewers::Yes => Projection::Perspective,
            Viewers::No => Projection::Cubemap,
        };
        let projection = match self.projection {
            None if self.look_at.is_some() => Projection::Perspective,
            asked => asked.unwrap_or(usual),
        };
        let fps = self.fps;
        let wanted = || wanted_frames(&cameras, || frames_of_animation(scene.duration_s(), fps));
        let frames = self.frames.frames.map_or_else(wanted, Ok)?;
        let plan = CapturePlan {
            name: self.name(),
            fps,
            frames,
            projection,
            size: self.pixels(projection, &cameras)?,
            cameras,
            fov_y_deg: self.fov,
            passes: self.passes()?,
            samples: self.samples,
            depth: self.depth,
            far_m: self.far.unwrap_or(f64::INFINITY),
            part: None,
        };
        let part = self.shard.map(|shard| shard.range(plan.request_count(), "view")).transpose()?;
        Ok(CapturePlan { part, ..plan })
    }

    fn name(&self) -> String {
        let stem = Path::new(&self.scene).file_stem().unwrap_or_default().to_string_lossy();
        let plain: String = stem.chars().filter(|c| !c.is_control()).collect();
        if plain.is_empty() { "scene".into() } else { plain }
    }

    fn passes(&self) -> Result<Vec<Pass>> {
        if self.aov.contains(&None) && self.aov.len() > 1 {
            return refuse("--aov none cannot be combined with other outputs");
        }
        let wants = |pass: &Pass| match pass {
            Pass::Color => !self.no_color,
            other => self.aov.contains(&Some(*other)),
        };
        Ok(Pass::ALL.into_iter().filter(wants).collect())
    }

    fn pixels(&self, projection: Projection, cameras: &CameraSet) -> Result<[u32; 2]> {
        let aspect = if projection == Projection::Perspective { cameras.aspect()? } else { None };
        let size = match (self.size, projection) {
            (Some((width, Some(height))), _) => [width, height],
            (Some((width, None)), Projection::Equirect) if width % 2 == 1 => {
                return refuse(format!("--size {width}: the width of a panorama must be even"));
            }
            (Some((width, None)), Projection::Equirect) => [width, width / 2],
            (None, Projection::Equirect) => [4 * DEFAULT_SIDE, 2 * DEFAULT_SIDE],
            (side, _) => {
                let height = side.map_or(DEFAULT_SIDE, |(side, _)| side);
                [aspect.map_or(height, |aspect| (f64::from(height) * aspect).round().max(1.0) as u32), height]
            }
        };
        let [width, height] = size.map(f64::from);
        match aspect {
            // Rounding may change the width by one pixel.
            Some(aspect) if (width - height * aspect).abs() > 1.0 => refuse(format!(
                "--size {width}x{height}: the cameras have the aspect ratio {aspect}: use --size {height} to apply it"
            )),
            _ => Ok(size),
        }
    }
}

/// Returns the range from the first to the last frame of any camera. Cameras without frames use the whole animation.
fn wanted_frames(cameras: &CameraSet, all: impl Fn() -> Result<FrameRange>) -> Result<FrameRange> {
    let mut hull: Option<FrameRange> = None;
    for camera in &cameras.cameras {
        let own = camera.frames.map_or_else(&all, |[first, last]| Ok(FrameRange { first, last }))?;
        let hull = hull.get_or_insert(own);
        *hull = FrameRange { first: hull.first.min(own.first), last: hull.last.max(own.last) };
    }
    hull.map_or_else(all, Ok)
}

/// True if the cameras of a file have eyes. Invalid JSON is reported later.
fn are_viewers(text: &[u8]) -> bool {
    let value: serde_json::Value = footage::text::json(text, "a file of cameras").unwrap_or_default();
    let cameras = value.get("cameras").and_then(|cameras| cameras.as_array());
    cameras.is_some_and(|cameras| cameras.iter().any(|camera| camera.get("eye").is_some()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_those_that_cameras_ask_for() {
        let all = FrameRange { first: 0, last: 6 };
        let at = |frames| PlacedCamera { frames, ..PlacedCamera::at([0.0; 3]) };
        let wanted = |own: &[Option<[u32; 2]>]| {
            let frames =
                wanted_frames(&CameraSet::new(own.iter().map(|frames| at(*frames)).collect()), || Ok(all)).unwrap();
            [frames.first, frames.last]
        };
        assert_eq!(wanted(&[None, None]), [0, 6]);
        assert_eq!(wanted(&[Some([4, 5]), Some([5, 9])]), [4, 9]);
        assert_eq!(wanted(&[Some([4, 9]), None]), [0, 9]);
        // If every camera states its frames, the animation is not evaluated.
        let said = CameraSet::new(vec![at(Some([4, 5]))]);
        let endless = || refuse("endless");
        assert_eq!(wanted_frames(&said, endless).unwrap().last, 5);
        assert!(wanted_frames(&CameraSet::new(vec![at(None)]), endless).is_err());
    }

    #[test]
    fn viewers_have_eyes() {
        assert!(are_viewers(br#"{"cameras": [{"eye": [0, 0, 0]}]}"#));
        for text in [&b"{"[..], b"[]", br#"{"cameras": 3}"#, br#"{"cameras": [{"position": [0, 0, 0]}]}"#] {
            assert!(!are_viewers(text));
        }
    }
}
