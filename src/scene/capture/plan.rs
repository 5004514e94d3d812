//! Plan of a capture: its images, their files, and the manifest that describes them.
//!
//! The manifest does not state near and far: `encode` determines them per probe, which is tighter than one pair for all probes.

use std::ops::Range;
use std::path::PathBuf;

use glam::DVec3;

use super::pixels::Viewpoint;
use super::samples::SamplePattern;
use super::view::{MAX_FACE_SIZE, Pass};
use codec::error::{Error, Result};
use codec::image::{DepthKind, Face, FrameRange, ImageProjection, Pattern, Projection, StreamKind};
use codec::math::camera::rotation;
use footage::dataset::cameras::CameraSet;
use footage::dataset::manifest::{
    ColorInfo, DepthInfo, FaceFiles, Files, Keep, MANIFEST_VERSION, Manifest, MaterialInfo, Probe,
};
use footage::fingerprint::digest;
use footage::image_files::ColorSpace;

#[derive(Debug, Clone, PartialEq)]
pub struct CapturePlan {
    pub name: String,
    /// Frames per second: frame f shows the scene at f / fps seconds.
    pub fps: f64,
    pub frames: FrameRange,
    pub projection: Projection,
    /// Width and height in pixels; faces are square, panoramas twice as wide as high.
    pub size: [u32; 2],
    /// A camera's own frames are intersected with [`Self::frames`].
    pub cameras: CameraSet,
    /// Vertical field of view in degrees, for perspective cameras without their own.
    pub fov_y_deg: Option<f64>,
    /// Without duplicates.
    pub passes: Vec<Pass>,
    /// Colour samples per pixel.
    pub samples: u32,
    pub depth: DepthKind,
    /// Metres or `+inf`. Farther surfaces are background in all passes but colour, so a backdrop is visible but not
    /// reconstructed.
    pub far_m: f64,
    /// Range of requests to capture, out of [`Self::request_count`], ordered by probe, then frame, then face; `None` for all.
    pub part: Option<Range<u64>>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FrameRequest {
    pub probe: usize,
    pub face: Face,
    pub frame: u32,
}

/// Maximum frames if no range is given: a stray key in a file could ask for more.
const MAX_ANIMATION_FRAMES: u32 = 100_000;

/// Returns the frames of an animation: all that begin before its end, at least one. Fails above 100,000 frames.
pub fn frames_of_animation(duration_s: f64, fps: f64) -> Result<FrameRange> {
    // A margin of 1e-6 frames for rounding. The cast saturates and maps NaN to 0.
    let count = (duration_s * fps - 1e-6).ceil() as u32;
    if count > MAX_ANIMATION_FRAMES {
        return Err(Error::Usage(format!(
            "the animation lasts {duration_s} s, more than {MAX_ANIMATION_FRAMES} frames at {fps} fps: select some \
            with `frames`"
        )));
    }
    Ok(FrameRange { first: 0, last: count.max(1) - 1 })
}

impl CapturePlan {
    /// Creates the manifest as it is before the capture: it does not state how colour above 1 is kept. Fails if the plan is
    /// inconsistent.
    pub fn manifest(&self) -> Result<Manifest> {
        self.manifest_keeping(None)
    }

    /// Creates the manifest of captured images, see [`super::CaptureSummary::keep`]. Fails if the plan is inconsistent.
    pub fn manifest_keeping(&self, keep: Option<Keep>) -> Result<Manifest> {
        self.check()?;
        let wants = |pass| self.passes.contains(&pass);
        let files = |pass| wants(pass).then(|| self.file_text(pass));
        let probes = (0..self.cameras.cameras.len()).map(|camera| self.probe(camera)).collect::<Result<_>>()?;
        let manifest = Manifest {
            schema: None,
            lightfield: MANIFEST_VERSION,
            name: self.name.clone(),
            fps: self.fps,
            frames: [self.frames.first, self.frames.last],
            projection: self.projection,
            size: self.size,
            faces: (self.projection == Projection::Cubemap).then_some(FaceFiles::Six),
            faces_present: None,
            face_names: None,
            stereo: None,
            depth: wants(Pass::Depth).then(|| DepthInfo { kind: self.depth.into(), ..DepthInfo::default() }),
            color: wants(Pass::Color).then_some(ColorInfo {
                space: Some(ColorSpace::LinearRec709),
                keep,
                ..ColorInfo::default()
            }),
            material: wants(Pass::Material).then(|| MaterialInfo { channels: Default::default() }),
            alpha: None,
            missing: None,
            files: Files {
                color: files(Pass::Color),
                depth: files(Pass::Depth),
                material: files(Pass::Material),
                alpha: None,
                normal: files(Pass::Normal),
            },
            probes,
            view: None,
            extra: None,
        };
        manifest.validate()?;
        Ok(manifest)
    }

    fn check(&self) -> Result<()> {
        let wrong = |message: String| Err(Error::Usage(message));
        let [width, height] = self.size;
        if self.size.iter().any(|&side| side == 0 || side > MAX_FACE_SIZE) {
            return wrong(format!("images of {width}x{height} pixels: 1 to {MAX_FACE_SIZE} a side were expected"));
        }
        match self.projection {
            Projection::Cubemap if width != height => {
                return wrong(format!("images of {width}x{height} pixels: the faces of a cube map are square"));
            }
            Projection::Equirect if u64::from(width) != 2 * u64::from(height) => {
                return wrong(format!(
                    "images of {width}x{height} pixels: an equirectangular image is twice as wide as it is high"
                ));
            }
            Projection::Equirect if self.depth == DepthKind::Planar && self.passes.contains(&Pass::Depth) => {
                return wrong("equirectangular images have no planar depth: capture distances".into());
            }
            _ => {}
        }
        if self.fov_y_deg.is_some() && self.projection != Projection::Perspective {
            return wrong("a field of view is only for perspective captures".into());
        }
        if self.far_m.is_nan() || self.far_m <= 0.0 {
            return wrong(format!("a far of {} m: a number above 0 was expected", self.far_m));
        }
        if !self.passes.iter().any(|pass| *pass != Pass::Normal) {
            return wrong("no output was selected: capture colour, depth or material".into());
        }
        SamplePattern::new(self.samples).map(|_| ())
    }

    fn probe(&self, camera: usize) -> Result<Probe> {
        let (name, placed) = (self.cameras.name_of(camera), &self.cameras.cameras[camera]);
        let fov_y_deg = match self.projection {
            Projection::Perspective => Some(placed.fov_y_deg.or(self.fov_y_deg).ok_or_else(|| {
                Error::Usage(format!("camera {name} has no field of view: set `fov`, or \"fov_y_deg\" of the camera"))
            })?),
            _ => None,
        };
        let frames = self.frames_of(camera).ok_or_else(|| {
            let [first, last] = placed.frames.unwrap_or_default();
            Error::Usage(format!(
                "camera {name} is defined for frames {first}-{last}, but the capture has {}",
                self.frames
            ))
        })?;
        if placed.shift.is_some() && self.projection != Projection::Perspective {
            return Err(Error::Usage(format!("camera {name} has a \"shift\", which is only for perspective captures")));
        }
        // A manifest has either a field of view or intrinsics.
        let shifted = fov_y_deg.filter(|_| placed.shift.is_some());
        Ok(Probe {
            name,
            position: Some(placed.position),
            frames: (frames != self.frames).then_some([frames.first, frames.last]),
            orientation: placed.orientation,
            fov_y_deg: fov_y_deg.filter(|_| shifted.is_none()),
            intrinsics: shifted.map(|fov_y_deg| placed.intrinsics(fov_y_deg, self.size)),
            ..Probe::default()
        })
    }

    /// Returns the frames of a camera; `None` if it has none in the plan's range.
    fn frames_of(&self, camera: usize) -> Option<FrameRange> {
        let Some([first, last]) = self.cameras.cameras[camera].frames else { return Some(self.frames) };
        self.frames.intersect(FrameRange { first, last })
    }

    /// Returns the file pattern of a pass, as written in a manifest.
    fn file_text(&self, pass: Pass) -> String {
        let face = if self.projection == Projection::Cubemap { "face_{face}/" } else { "" };
        format!("probe_{{probe}}/{face}{}.%04d.exr", pass.name())
    }

    /// Returns the file of an image, relative to the dataset's folder.
    pub fn file(&self, request: &FrameRequest, pass: Pass) -> Result<PathBuf> {
        let text = self.file_text(pass).replace("{probe}", &self.cameras.name_of(request.probe));
        Ok(Pattern::parse(&text.replace("{face}", request.face.name()))?.path(request.frame))
    }

    pub fn faces(&self) -> &'static [Face] {
        if self.projection == Projection::Cubemap { &Face::CUBE } else { &[Face::View] }
    }

    /// Returns the requests of a frame that are captured, ordered by probe and face.
    pub fn requests(&self, frame: u32) -> impl Iterator<Item = FrameRequest> + '_ {
        let faces = self.faces();
        let firsts = (0..self.cameras.cameras.len()).scan(0, move |next, probe| {
            let first = *next;
            *next += self.requests_of(probe);
            Some((probe, first))
        });
        let of_frame = firsts.filter_map(move |(probe, first)| {
            let frames = self.frames_of(probe).filter(|frames| frames.contains(frame))?;
            Some((probe, first + u64::from(frame - frames.first) * faces.len() as u64))
        });
        let numbered = of_frame.flat_map(move |(probe, first)| {
            (first..).zip(faces).map(move |(number, &face)| (number, FrameRequest { probe, face, frame }))
        });
        let is_captured = move |number: &u64| self.part.as_ref().is_none_or(|part| part.contains(number));
        numbered.filter(move |(number, _)| is_captured(number)).map(|(_, request)| request)
    }

    fn requests_of(&self, camera: usize) -> u64 {
        self.frames_of(camera).map_or(0, FrameRange::count) * self.faces().len() as u64
    }

    /// Returns the number of requests of all probes, captured or not.
    pub fn request_count(&self) -> u64 {
        (0..self.cameras.cameras.len()).map(|camera| self.requests_of(camera)).sum()
    }

    /// Returns the number of captured images.
    pub fn image_count(&self) -> u64 {
        let requests = self.part.as_ref().map_or_else(|| self.request_count(), |part| part.end - part.start);
        requests * self.passes.len() as u64
    }

    pub fn viewpoint(&self, request: &FrameRequest) -> Viewpoint {
        let camera = &self.cameras.cameras[request.probe];
        let projection = match self.projection {
            Projection::Cubemap => ImageProjection::cube_face(request.face, self.size[0]),
            Projection::Equirect => ImageProjection::Equirect { size: self.size },
            Projection::Perspective => {
                let fov_y_deg = camera.fov_y_deg.or(self.fov_y_deg).unwrap_or(90.0);
                ImageProjection::Pinhole { size: self.size, intrinsics: camera.intrinsics(fov_y_deg, self.size) }
            }
        };
        Viewpoint {
            position: DVec3::from_array(camera.position),
            orientation: camera.orientation.and_then(rotation),
            projection,
        }
    }

    /// Fails if the folder of an existing dataset would keep images that are not part of this one.
    pub fn check_replaces(&self, old: &Manifest) -> Result<()> {
        let new = self.manifest()?;
        let has_files = |kind| old.files.get(kind).is_none() || old.files.get(kind) == new.files.get(kind);
        let is_within = StreamKind::ALL.into_iter().all(has_files)
            && (old.files.normal.is_none() || old.files.normal == new.files.normal)
            && old.faces().iter().all(|face| new.faces().contains(face))
            && old.probes.iter().all(|probe| {
                let frames = |manifest: &Manifest, probe: &Probe| probe.frames.unwrap_or(manifest.frames);
                let [first, last] = frames(old, probe);
                let mut same = new.probes.iter().filter(|other| other.name == probe.name);
                same.any(|other| {
                    let of_new = frames(&new, other);
                    of_new[0] <= first && last <= of_new[1]
                })
            });
        if is_within {
            return Ok(());
        }
        Err(Error::Usage(format!(
            "the folder has a dataset \"{}\" of other probes, frames or images, which would be mixed with this one: \
            remove it, or use another folder",
            old.name
        )))
    }

    /// Returns the names and values of all settings that the images depend on.
    pub fn options(&self) -> Vec<(&'static str, String)> {
        // Destructured so that adding a field without listing it here does not compile.
        let CapturePlan {
            name,
            fps,
            frames,
            projection,
            size,
            cameras,
            fov_y_deg,
            passes,
            samples,
            depth,
            far_m,
            part,
        } = self;
        let all = 0..self.request_count();
        let [width, height] = size;
        let passes: Vec<&str> = passes.iter().map(|pass| pass.name()).collect();
        vec![
            ("the name", name.clone()),
            ("`fps`", fps.to_string()),
            ("`frames`", frames.to_string()),
            ("`projection`", projection.name().to_owned()),
            ("`size`", format!("{width}x{height}")),
            ("the choice of cameras", cameras_in_words(cameras)),
            ("the list of cameras", digest(format!("{cameras:?}").as_bytes())),
            ("`fov`", fov_y_deg.map_or("none".to_owned(), |fov| fov.to_string())),
            ("what is captured", passes.join(", ")),
            ("`samples`", samples.to_string()),
            ("`depth`", depth.name().to_owned()),
            ("`far`", if far_m.is_finite() { format!("{far_m} m") } else { "none".to_owned() }),
            ("the range of `shard`", format!("{:?}", part.as_ref().unwrap_or(&all))),
        ]
    }
}

/// Describes a set of cameras: their positions if there are at most four, otherwise their number.
fn cameras_in_words(set: &CameraSet) -> String {
    const FEW: usize = 4;
    let place = |position: &[f64; 3]| format!("{},{},{}", position[0], position[1], position[2]);
    match set.cameras.len() {
        count if count > FEW => format!("{count} cameras"),
        _ => set.cameras.iter().map(|camera| place(&camera.position)).collect::<Vec<_>>().join(" and "),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use footage::dataset::cameras::PlacedCamera;

    fn plan() -> CapturePlan {
        CapturePlan {
            name: "a".into(),
            fps: 24.0,
            frames: FrameRange { first: 2, last: 5 },
            projection: Projection::Cubemap,
            size: [8, 8],
            cameras: CameraSet::new(vec![
                PlacedCamera::at([0.0; 3]),
                PlacedCamera { frames: Some([4, 9]), fov_y_deg: Some(40.0), ..PlacedCamera::at([1.0; 3]) },
            ]),
            fov_y_deg: None,
            passes: Pass::ALL.to_vec(),
            samples: 1,
            depth: DepthKind::Distance,
            far_m: f64::INFINITY,
            part: None,
        }
    }

    #[test]
    fn parts_have_the_requests_of_the_whole_by_probe_and_frame() {
        let requests = |part: Option<Range<u64>>| {
            let plan = CapturePlan { part, ..plan() };
            let found: Vec<FrameRequest> = plan.frames.iter().flat_map(|frame| plan.requests(frame)).collect();
            assert_eq!(plan.image_count(), found.len() as u64 * plan.passes.len() as u64);
            found
        };
        let mut whole = requests(None);
        whole.sort_by_key(|request| (request.probe, request.frame, request.face as u8));
        for (at, request) in (0..).zip(&whole) {
            assert_eq!(requests(Some(at..at + 1)), [*request]);
        }
        assert_eq!((whole.len() as u64, requests(Some(3..30)).len()), (plan().request_count(), 27));
    }

    #[test]
    fn frames_are_those_of_the_plan_and_the_camera() {
        let plan = plan();
        let manifest = plan.manifest().unwrap();
        assert_eq!(manifest.frames, [2, 5]);
        assert_eq!([manifest.probes[0].frames, manifest.probes[1].frames], [None, Some([4, 5])]);
        assert_eq!((plan.requests(3).count(), plan.requests(4).count()), (6, 12));
        assert_eq!(plan.image_count(), (4 + 2) * 6 * 4);
        let request = plan.requests(4).nth(7).unwrap();
        assert_eq!(request, FrameRequest { probe: 1, face: Face::Nx, frame: 4 });
        assert_eq!(plan.file(&request, Pass::Normal).unwrap(), PathBuf::from("probe_01/face_nx/normal.0004.exr"));
        let none = CapturePlan { frames: FrameRange { first: 0, last: 3 }, ..plan };
        assert!(none.manifest().unwrap_err().to_string().contains("camera 01 is defined for frames 4-9"));
    }

    #[test]
    fn animations_have_the_frames_before_their_end() {
        let last = |duration_s| frames_of_animation(duration_s, 24.0).unwrap().last;
        assert_eq!([0.0, 0.01, 1.0, 4.0, 1.0 / 24.0 * 7.0, f64::NAN].map(last), [0, 0, 23, 95, 6, 0]);
        assert_eq!(last(100_000.0 / 24.0), 99_999);
        for duration_s in [100_001.0 / 24.0, 1e30, f64::INFINITY] {
            let error = frames_of_animation(duration_s, 24.0).unwrap_err().to_string();
            assert!(error.contains("`frames`"), "{error}");
        }
    }

    #[test]
    fn plans_that_cannot_be_carried_out_say_why() {
        let says = |change: fn(&mut CapturePlan), words: &str| {
            let mut plan = plan();
            change(&mut plan);
            let error = plan.manifest().unwrap_err().to_string();
            assert!(error.contains(words), "{error}");
        };
        says(|plan| plan.size = [0, 0], "0x0");
        says(|plan| plan.size = [MAX_FACE_SIZE + 1; 2], "a side");
        says(|plan| plan.size = [8, 4], "square");
        says(|plan| plan.projection = Projection::Equirect, "twice as wide");
        says(|plan| plan.projection = Projection::Perspective, "camera 00 has no field of view");
        says(|plan| plan.fov_y_deg = Some(50.0), "only for perspective");
        says(|plan| plan.far_m = 0.0, "above 0");
        says(|plan| plan.far_m = f64::NAN, "above 0");
        says(|plan| plan.samples = 0, "samples");
        says(|plan| plan.passes = vec![Pass::Normal], "colour, depth or material");
        says(|plan| plan.fps = 0.0, "fps");
        says(
            |plan| {
                (plan.projection, plan.size, plan.depth) = (Projection::Equirect, [8, 4], DepthKind::Planar);
            },
            "no planar depth",
        );
    }

    #[test]
    fn a_dataset_is_replaced_only_by_one_that_has_all_its_images() {
        let old = plan().manifest().unwrap();
        assert!(plan().check_replaces(&old).is_ok());
        let larger = CapturePlan { size: [16, 16], frames: FrameRange { first: 0, last: 5 }, ..plan() };
        assert!(larger.check_replaces(&old).is_ok());
        let refused = |change: fn(&mut CapturePlan)| {
            let mut plan = plan();
            change(&mut plan);
            assert!(plan.check_replaces(&old).unwrap_err().to_string().contains("mixed"));
        };
        refused(|plan| plan.frames.first = 3);
        refused(|plan| plan.cameras.cameras.truncate(1));
        refused(|plan| plan.passes = vec![Pass::Color, Pass::Depth, Pass::Material]);
        refused(|plan| plan.passes = vec![Pass::Color, Pass::Depth, Pass::Normal]);
        refused(|plan| plan.cameras.cameras[1].name = Some("b".into()));
        refused(|plan| (plan.projection, plan.size) = (Projection::Equirect, [8, 4]));
    }

    #[test]
    fn fields_of_view_become_focal_lengths() {
        let mut plan = plan();
        (plan.projection, plan.size, plan.fov_y_deg) = (Projection::Perspective, [20, 10], Some(90.0));
        let window =
            |plan: &CapturePlan, probe| plan.viewpoint(&FrameRequest { probe, face: Face::View, frame: 4 }).projection;
        let ImageProjection::Pinhole { size, intrinsics: [fx, fy, cx, cy] } = window(&plan, 0) else { panic!() };
        assert_eq!((size, cx, cy, fx), ([20, 10], 10.0, 5.0, fy));
        assert!((fx - 5.0).abs() < 1e-12);
        assert_ne!(window(&plan, 1), window(&plan, 0), "its own comes first");
        assert_eq!(
            plan.file(&plan.requests(2).next().unwrap(), Pass::Color).unwrap().to_str(),
            Some("probe_00/color.0002.exr")
        );
    }
}
