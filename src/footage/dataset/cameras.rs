//! `cameras.json`: poses of probes to capture. `place` writes it, `capture` reads it.
//!
//! ```json
//! { "lightfold_cameras": 1, "cameras": [ { "name": "00", "position": [0, 1.5, 0] } ] }
//! ```

use std::collections::BTreeSet;
use std::io::Read;
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::manifest::{MAX_MANIFEST_BYTES, Manifest, Probe, intrinsics_of, pose_fault};
use crate::{json, text};
use codec::error::{Error, Result};
use codec::image::Projection;

pub const CAMERAS_VERSION: u32 = 1;

/// A camera set. Unknown keys are errors, except inside `extra`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CameraSet {
    pub lightfold_cameras: u32,
    pub cameras: Vec<PlacedCamera>,
    /// Other data, such as placement settings; preserved, never read.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub extra: Option<serde_json::Value>,
}

#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlacedCamera {
    /// Name of the probe; if absent, its index with at least two digits.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Centre in metres.
    pub position: [f64; 3],
    /// Unit quaternion x, y, z, w that rotates the probe's axes into the world's; identity if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub orientation: Option<[f64; 4]>,
    /// Vertical field of view in degrees, for perspective captures.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fov_y_deg: Option<f64>,
    /// Aspect ratio width / height of the image, for perspective captures; if absent, that of the images to capture, or 1 without
    /// images.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub aspect: Option<f64>,
    /// Offset of the image centre from the viewing axis, in image widths to the right and image heights down, for perspective
    /// captures; zero if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shift: Option<[f64; 2]>,
    /// First and last frame to capture, inclusive; all if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frames: Option<[u32; 2]>,
    /// Gain of the placement objective, as a fraction of the surface area (times frames).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gain: Option<f64>,
    /// Coverage by this camera and all before it, 0..=1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub coverage: Option<f64>,
}

impl PlacedCamera {
    pub fn at(position: [f64; 3]) -> PlacedCamera {
        PlacedCamera { position, ..PlacedCamera::default() }
    }

    /// Returns fx, fy, cx, cy in pixels of an image of `size` with a vertical field of view in degrees.
    pub fn intrinsics(&self, fov_y_deg: f64, size: [u32; 2]) -> [f64; 4] {
        let [fx, fy, cx, cy] = intrinsics_of(fov_y_deg, size);
        let [right, down] = self.shift.unwrap_or_default();
        [fx, fy, cx - right * f64::from(size[0]), cy - down * f64::from(size[1])]
    }
}

impl CameraSet {
    pub fn new(cameras: Vec<PlacedCamera>) -> CameraSet {
        CameraSet { lightfold_cameras: CAMERAS_VERSION, cameras, extra: None }
    }

    /// Reads a camera set; `-` reads standard input. The probes of a `lightfield.json` are accepted as a camera set.
    pub fn read(path: &Path) -> Result<CameraSet> {
        Self::from_json(&Self::read_text(path)?).map_err(|error| error.in_file(path))
    }

    /// Reads the bytes of a camera file of any format; `-` reads standard input.
    pub fn read_text(path: &Path) -> Result<Vec<u8>> {
        let source: Box<dyn Read> = match path == Path::new("-") {
            true => Box::new(std::io::stdin().lock()),
            false => Box::new(crate::files::open_regular(path)?),
        };
        let mut text = Vec::new();
        source.take(MAX_MANIFEST_BYTES + 1).read_to_end(&mut text).map_err(|error| Error::io(path, error))?;
        if text.len() as u64 > MAX_MANIFEST_BYTES {
            return Err(Error::invalid("a camera file can have at most 16 MiB").in_file(path));
        }
        Ok(text)
    }

    /// Parses and validates a camera set or a manifest.
    pub fn from_json(bytes: &[u8]) -> Result<CameraSet> {
        let value: serde_json::Value = text::json(bytes, "a file of cameras")?;
        if !value.is_object() {
            return Err(Error::invalid(
                "this is not a file of cameras: {\"lightfold_cameras\": 1, \"cameras\": [{\"position\": [0, 1.5, 0]}]} is one",
            ));
        }
        if value.get("lightfield").is_some() {
            return Self::of_manifest(&Manifest::from_json(bytes)?);
        }
        let set: CameraSet = serde_json::from_value(value)
            .map_err(|error| Error::invalid(format!("this is not a file of cameras: {error}")))?;
        set.validate()?;
        Ok(set)
    }

    fn of_manifest(manifest: &Manifest) -> Result<CameraSet> {
        // Pictures of one aspect may be captured in any size.
        let aspect_of = |[width, height]: [u32; 2]| f64::from(width) / f64::from(height);
        let aspects = manifest.probes.iter().map(|probe| aspect_of(manifest.picture_size_of(probe)));
        let is_perspective = manifest.projection == Projection::Perspective;
        let has_aspects = is_perspective && aspects.clone().min_by(f64::total_cmp) != aspects.max_by(f64::total_cmp);
        let camera = |probe: &Probe| {
            if !probe.poses.is_empty() {
                let message = format!("probe {} has \"poses\": cameras to capture must be static", probe.name);
                return Err(Error::invalid(message));
            }
            let (fov_y_deg, shift) = match probe.intrinsics {
                None => (probe.fov_y_deg, None),
                Some(intrinsics) => lens_of(intrinsics, manifest.picture_size_of(probe))
                    .map(|(fov_y_deg, shift)| (Some(fov_y_deg), Some(shift)))
                    .map_err(|error| error.context(format!("probe {}", probe.name)))?,
            };
            Ok(PlacedCamera {
                name: Some(probe.name.clone()),
                aspect: has_aspects.then(|| aspect_of(manifest.picture_size_of(probe))),
                orientation: probe.orientation,
                fov_y_deg,
                shift,
                frames: probe.frames,
                ..PlacedCamera::at(probe.position.unwrap_or_default())
            })
        };
        Ok(Self::new(manifest.probes.iter().map(camera).collect::<Result<_>>()?))
    }

    pub fn to_json(&self) -> Result<String> {
        self.validate()?;
        json::pretty(self)
    }

    /// Returns the aspect ratio of the cameras' images, if any states one. Fails if they differ.
    pub fn aspect(&self) -> Result<Option<f64>> {
        let mut aspects = self.cameras.iter().filter_map(|camera| camera.aspect);
        let first = aspects.next();
        match first.is_some_and(|first| aspects.any(|other| other != first)) {
            true => {
                Err(Error::invalid("cameras of different \"aspect\" cannot be captured together: use a file for each"))
            }
            false => Ok(first),
        }
    }

    pub fn name_of(&self, camera: usize) -> String {
        let digits = (self.cameras.len().saturating_sub(1)).to_string().len().max(2);
        let name = self.cameras.get(camera).and_then(|camera| camera.name.clone());
        name.unwrap_or_else(|| format!("{camera:0digits$}"))
    }

    fn validate(&self) -> Result<()> {
        if self.lightfold_cameras != CAMERAS_VERSION {
            return Err(Error::invalid(format!(
                "\"lightfold_cameras\" is {}, this program reads version {CAMERAS_VERSION}",
                self.lightfold_cameras
            )));
        }
        if self.cameras.is_empty() {
            return Err(Error::invalid("\"cameras\" is empty: at least one was expected"));
        }
        let mut names = BTreeSet::new();
        for (at, camera) in self.cameras.iter().enumerate() {
            let wrong = |what: &str| Err(Error::invalid(format!("camera {at}: {what}")));
            let name = self.name_of(at);
            if let Some(fault) = pose_fault(&name, camera.position, camera.orientation, camera.fov_y_deg) {
                return wrong(fault);
            }
            if camera.aspect.is_some_and(|aspect| !(aspect.is_finite() && aspect > 0.0)) {
                return wrong("\"aspect\" must be a finite number above 0");
            }
            if camera.shift.is_some_and(|shift| shift.iter().any(|at| !at.is_finite())) {
                return wrong("\"shift\" must be two finite numbers");
            }
            if !names.insert(name) {
                return wrong("another camera has this name");
            }
            if camera.frames.is_some_and(|[first, last]| first > last) {
                return wrong("the first of its \"frames\" comes after the last");
            }
        }
        Ok(())
    }
}

/// Returns the vertical field of view in degrees and the shift of an image of `size` with fx, fy, cx, cy in pixels.
fn lens_of([fx, fy, cx, cy]: [f64; 4], size: [u32; 2]) -> Result<(f64, [f64; 2])> {
    if (fx - fy).abs() > 1e-6 * fy {
        return Err(Error::invalid("its \"intrinsics\" have non-square pixels, which capture does not support"));
    }
    let [width, height] = size.map(f64::from);
    Ok((2.0 * (0.5 * height / fy).atan().to_degrees(), [0.5 - cx / width, 0.5 - cy / height]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_set_round_trips_and_names_its_cameras() {
        let text = br#"{"lightfold_cameras": 1, "cameras": [{"position": [0, 1.5, 0]},
            {"name": "left", "position": [-1, 1.5, 0], "gain": 0.25, "coverage": 0.5}]}"#;
        let set = CameraSet::from_json(text).unwrap();
        assert_eq!([set.name_of(0), set.name_of(1)], ["00", "left"]);
        assert_eq!(CameraSet::from_json(set.to_json().unwrap().as_bytes()).unwrap(), set);
        let many = CameraSet::new(vec![PlacedCamera::at([0.0; 3]); 1001]);
        assert_eq!([many.name_of(0), many.name_of(1000)], ["0000", "1000"]);
    }

    #[test]
    fn a_manifest_is_the_set_of_its_probes() {
        let text = br#"{"lightfield": 1, "name": "a", "fps": 24, "frames": [0, 0], "projection": "cubemap",
            "size": [8, 8], "files": {"depth": "{probe}/{face}.%04d.exr"},
            "probes": [{"name": "a", "position": [1, 2, 3]}]}"#;
        let set = CameraSet::from_json(text).unwrap();
        assert_eq!((set.name_of(0).as_str(), set.cameras[0].position), ("a", [1.0, 2.0, 3.0]));
    }

    #[test]
    fn shifted_images_of_a_manifest_stay_shifted() {
        let manifest = |intrinsics: &str| {
            format!(
                r#"{{"lightfield": 1, "name": "a", "fps": 24, "frames": [0, 0], "projection": "perspective", "size": [40, 20],
                "files": {{"depth": "{{probe}}.%04d.exr"}},
                "probes": [{{"name": "a", "position": [1, 2, 3], "intrinsics": {intrinsics}}}]}}"#
            )
        };
        let set = CameraSet::from_json(manifest("[30, 30, 24, 9]").as_bytes()).unwrap();
        let camera = &set.cameras[0];
        assert_eq!(camera.shift, Some([0.5 - 24.0 / 40.0, 0.5 - 9.0 / 20.0]));
        let found = camera.intrinsics(camera.fov_y_deg.unwrap(), [80, 40]);
        assert!(found.iter().zip([60.0, 60.0, 48.0, 18.0]).all(|(a, b)| (a - b).abs() < 1e-9), "{found:?}");
        let error = CameraSet::from_json(manifest("[30, 31, 24, 9]").as_bytes()).unwrap_err().to_string();
        assert!(error.contains("probe a") && error.contains("non-square"), "{error}");
    }

    #[test]
    fn probes_of_other_sizes_keep_their_lenses_and_state_their_aspect_if_it_differs() {
        let set = |size: &str| {
            let text = format!(
                r#"{{"lightfield": 1, "name": "a", "fps": 24, "frames": [0, 0], "projection": "perspective", "size": [40, 20],
                "files": {{"depth": "{{probe}}.%04d.exr"}}, "probes": [
                {{"name": "a", "position": [0, 0, 0], "intrinsics": [30, 30, 24, 9]}},
                {{"name": "b", "position": [1, 0, 0], "size": {size}, "intrinsics": [60, 60, 48, 18]}}]}}"#
            );
            CameraSet::from_json(text.as_bytes()).unwrap()
        };
        let same = set("[80, 40]");
        let [a, b] = &same.cameras[..] else { panic!("two probes") };
        assert_eq!((a.shift, a.fov_y_deg, same.aspect().unwrap()), (b.shift, b.fov_y_deg, None));
        assert!(set("[80, 30]").aspect().unwrap_err().to_string().contains("different \"aspect\""));
    }

    #[test]
    fn a_byte_order_mark_is_no_part_of_the_text() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("cameras.json");
        let text = r#"{"lightfold_cameras": 1, "cameras": [{"position": [0, 1.5, 0]}]}"#;
        std::fs::write(&path, format!("\u{feff}{text}")).unwrap();
        assert_eq!(CameraSet::read(&path).unwrap(), CameraSet::from_json(text.as_bytes()).unwrap());
        for text in ["[]", "3", "null", "\"a\""] {
            let error = CameraSet::from_json(text.as_bytes()).unwrap_err().to_string();
            assert!(error.contains("\"lightfold_cameras\": 1"), "{error}");
        }
    }

    #[test]
    fn sets_that_contradict_themselves_are_refused() {
        for (cameras, says) in [
            (r#""#, "empty"),
            (r#"{"position": [0, 0]}"#, "not a file of cameras"),
            (r#"{"position": [0, 0, 1e999]}"#, "JSON"),
            (r#"{"position": [0, 0, 0], "name": "../a"}"#, "letters"),
            (r#"{"position": [0, 0, 0], "name": "01"}, {"position": [0, 0, 0]}"#, "another camera"),
            (r#"{"position": [0, 0, 0], "orientation": [0, 0, 0, 2]}"#, "quaternion"),
            (r#"{"position": [0, 0, 0], "fov_y_deg": 180}"#, "fov_y_deg"),
            (r#"{"position": [0, 0, 0], "aspect": 0}"#, "aspect"),
            (r#"{"position": [0, 0, 0], "shift": [0, 1e999]}"#, "JSON"),
            (r#"{"position": [0, 0, 0], "frames": [2, 1]}"#, "frames"),
            (r#"{"position": [0, 0, 0], "colour": 1}"#, "colour"),
        ] {
            let text = format!(r#"{{"lightfold_cameras": 1, "cameras": [{cameras}]}}"#);
            let error = CameraSet::from_json(text.as_bytes()).unwrap_err().to_string();
            assert!(error.contains(says), "{cameras}: {error}");
        }
    }
}
