//! `cam.json`: cameras, and the frames that they render.

use glam::DVec3;
use serde::{Deserialize, Serialize};

use codec::error::{Error, Result};
use codec::image::FrameRange;
use codec::math::{Camera, Lens};
use footage::dataset::{CameraSet, PlacedCamera};
use footage::text::json;
use render::camera_path::{self, KeyPose, TimedCamera};

/// Maximum size of a file in bytes.
pub const MAX_CAMERA_FILE_BYTES: u64 = 16 << 20;

/// Content of a camera file. Unknown keys are errors.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CameraFile {
    pub cameras: Vec<CameraEntry>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CameraEntry {
    pub eye: [f64; 3],
    /// Target point; either this or `orientation` is required.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub look_at: Option<[f64; 3]>,
    /// Unit quaternion x, y, z, w, which rotates a camera that looks along −Z with +Y up; either this or `look_at` is required.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub orientation: Option<[f64; 4]>,
    /// Up direction, with `look_at`; +Y by default.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub up: Option<[f64; 3]>,
    /// Vertical field of view in degrees, above 0 and below 180.
    pub fov_y_deg: f64,
    /// Width of the image divided by its height; 1 by default.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub aspect: Option<f64>,
    /// Offset of the image centre at distance 1, to the right and down (off-axis frustum); 0, 0 by default.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub off_axis: Option<[f64; 2]>,
    /// Near plane in metres along the viewing axis; 0 by default.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub near_m: Option<f64>,
    /// Far plane in metres along the viewing axis; none by default.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub far_m: Option<f64>,
    /// First and last frame that the camera renders; all by default.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub frames: Option<[u32; 2]>,
    /// Key frame of a moving camera, instead of `frames`. If an entry has one, all must have one, in increasing order. Between
    /// key frames position is interpolated linearly, orientation by slerp.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub frame: Option<u32>,
}

impl CameraFile {
    /// Parses a camera file as perspective probes, for capturing their reference images. Near and far planes are ignored.
    pub fn as_probes(text: &[u8]) -> Result<CameraSet> {
        let (cameras, file) = (Self::parse(text)?, Self::entries(text)?);
        if file.cameras.iter().any(|entry| entry.frame.is_some()) {
            return Err(Error::invalid("key poses (\"frame\") describe a moving camera, but probes must be static"));
        }
        let probe = |(timed, entry): (&TimedCamera, &CameraEntry)| PlacedCamera {
            fov_y_deg: Some(entry.fov_y_deg),
            // The off-axis shift is relative to the image size, so it depends on the aspect ratio.
            aspect: entry.aspect.or_else(|| entry.off_axis.map(|_| timed.camera.aspect())),
            frames: entry.frames,
            ..placed(&timed.camera)
        };
        Ok(CameraSet::new(cameras.iter().zip(&file.cameras).map(probe).collect()))
    }

    fn entries(text: &[u8]) -> Result<CameraFile> {
        json(text, "a camera file").map_err(|error| {
            if CameraSet::from_json(text).is_ok() {
                return Error::invalid(
                    "this is a file of probes to capture, not of cameras with \"eye\" and \"look_at\"",
                );
            }
            error
        })
    }

    /// Parses a camera file; key poses are interpolated to one camera per frame.
    pub fn parse(text: &[u8]) -> Result<Vec<TimedCamera>> {
        let file = Self::entries(text)?;
        if file.cameras.is_empty() {
            return Err(Error::invalid("\"cameras\" is empty: at least one was expected"));
        }
        let named = |(at, entry): (usize, &CameraEntry)| {
            entry.camera().map_err(|error| Error::invalid(format!("camera {at}: {error}")))
        };
        let cameras: Vec<TimedCamera> = file.cameras.iter().enumerate().map(named).collect::<Result<_>>()?;
        if file.cameras.iter().all(|entry| entry.frame.is_none()) {
            return Ok(cameras);
        }
        let pose = |(entry, timed): (&CameraEntry, &TimedCamera)| {
            let frame = entry.frame.filter(|_| entry.frames.is_none()).ok_or_else(|| {
                Error::invalid("some cameras have a \"frame\", so all must have one, and none may have \"frames\"")
            })?;
            Ok(KeyPose { frame, camera: timed.camera, lens: entry.lens() })
        };
        let poses = file.cameras.iter().zip(&cameras).map(pose).collect::<Result<Vec<_>>>()?;
        camera_path::interpolate(&poses)
    }
}

/// Converts a perspective camera to a probe to capture.
pub fn placed(camera: &Camera) -> PlacedCamera {
    let (half, middle) = (camera.half(), camera.middle());
    let shift = [0, 1].map(|axis| 0.5 * middle[axis] / half[axis]);
    PlacedCamera {
        orientation: camera.orientation(),
        fov_y_deg: Some(camera.lens().fov_y_deg),
        aspect: Some(camera.aspect()),
        shift: (shift != [0.0; 2]).then_some(shift),
        ..PlacedCamera::at(camera.eye().to_array())
    }
}

/// Returns the perspective camera of a probe to capture with a field of view.
pub fn camera_of(placed: &PlacedCamera, fov_y_deg: f64) -> Result<Camera> {
    let lens = Lens { aspect: placed.aspect.unwrap_or(1.0), ..Lens::new(fov_y_deg) };
    let orientation = placed.orientation.unwrap_or([0.0, 0.0, 0.0, 1.0]);
    let camera = Camera::oriented(DVec3::from_array(placed.position), orientation, lens)?;
    let (half, shift) = (camera.half(), placed.shift.unwrap_or_default());
    camera.off_axis([0, 1].map(|axis| 2.0 * half[axis] * shift[axis]))
}

impl CameraEntry {
    fn lens(&self) -> Lens {
        Lens {
            fov_y_deg: self.fov_y_deg,
            aspect: self.aspect.unwrap_or(1.0),
            near_m: self.near_m.unwrap_or(0.0),
            far_m: self.far_m.unwrap_or(f64::INFINITY),
        }
    }

    fn camera(&self) -> Result<TimedCamera> {
        let lens = self.lens();
        let eye = DVec3::from_array(self.eye);
        let camera = match (self.look_at, self.orientation, self.up) {
            (Some(target), None, up) => {
                let up = up.map_or(DVec3::Y, DVec3::from_array);
                Camera::look_at(eye, DVec3::from_array(target), up, lens)?
            }
            (None, Some(orientation), None) => Camera::oriented(eye, orientation, lens)?,
            (None, Some(_), Some(_)) => {
                return Err(Error::invalid("\"up\" needs \"look_at\": leave it out beside \"orientation\""));
            }
            _ => return Err(Error::invalid("either \"look_at\" or \"orientation\" was expected")),
        };
        let frames = match self.frames {
            Some([first, last]) if first > last => {
                return Err(Error::invalid(format!(
                    "\"frames\" is [{first}, {last}]: the first frame must not come after the last"
                )));
            }
            frames => frames.map(|[first, last]| FrameRange { first, last }),
        };
        Ok(TimedCamera { camera: camera.off_axis(self.off_axis.unwrap_or_default())?, frames })
    }

    /// Creates the entry of a perspective camera.
    pub fn of(TimedCamera { camera, frames }: &TimedCamera) -> CameraEntry {
        let Lens { fov_y_deg, aspect, near_m, far_m } = camera.lens();
        CameraEntry {
            eye: camera.eye().to_array(),
            look_at: None,
            orientation: Some(camera.orientation().unwrap_or([0.0, 0.0, 0.0, 1.0])),
            up: None,
            fov_y_deg,
            aspect: Some(aspect),
            off_axis: Some(camera.middle()).filter(|middle| *middle != [0.0; 2]),
            near_m: Some(near_m).filter(|metres| *metres > 0.0),
            far_m: Some(far_m).filter(|metres| metres.is_finite()),
            frames: frames.map(|FrameRange { first, last }| [first, last]),
            frame: None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cameras_are_read() {
        let text = br#"{ "cameras": [
            { "eye": [1, 2, 3], "look_at": [1, 2, 0], "up": [0, 1, 0], "fov_y_deg": 90, "aspect": 1.5, "frames": [2, 4] },
            { "eye": [1, 2, 3], "orientation": [0, 0, 0, 1], "fov_y_deg": 90, "aspect": 1.5 },
            { "eye": [1, 2, 3], "look_at": [1, 2, 0], "fov_y_deg": 90, "near_m": 0.1, "far_m": 50 } ] }"#;
        let cameras = CameraFile::parse(text).unwrap();
        assert_eq!(cameras.len(), 3);
        assert_eq!(cameras[0].camera, cameras[1].camera);
        assert_eq!(cameras[0].frames, Some(FrameRange { first: 2, last: 4 }));
        assert_eq!(cameras[1].frames, None);
        assert_ne!(cameras[2].camera, cameras[0].camera);
    }

    #[test]
    fn poses_of_a_camera_that_moves_are_a_camera_for_each_frame() {
        let pose =
            |x: f64, keys: &str| format!(r#"{{ "eye": [{x}, 0, 0], "look_at": [{x}, 0, -1], "fov_y_deg": 60{keys} }}"#);
        let file = |poses: &[String]| format!(r#"{{ "cameras": [{}] }}"#, poses.join(", "));
        let text = file(&[pose(0.0, r#", "frame": 3"#), pose(4.0, r#", "frame": 5"#)]);
        let cameras = CameraFile::parse(text.as_bytes()).unwrap();
        let seen = cameras.iter().map(|timed| (timed.frames.unwrap().first, timed.camera.eye().x));
        assert_eq!(seen.collect::<Vec<_>>(), [(3, 0.0), (4, 2.0), (5, 4.0)]);
        assert!(CameraFile::as_probes(text.as_bytes()).unwrap_err().to_string().contains("must be static"));
        for (second, words) in
            [("", "all must have"), (r#", "frame": 3"#, "increase"), (r#", "frame": 5, "frames": [5, 5]"#, "none may")]
        {
            let text = file(&[pose(0.0, r#", "frame": 3"#), pose(4.0, second)]);
            let said = CameraFile::parse(text.as_bytes()).unwrap_err().to_string();
            assert!(said.contains(words), "{second}: {said}");
        }
    }

    #[test]
    fn viewers_become_probes_that_look_the_same_way() {
        let text = br#"{ "cameras": [
            { "eye": [1, 2, 3], "look_at": [4, 1, -2], "up": [0.2, 1, 0], "fov_y_deg": 50, "aspect": 1.5, "frames": [2, 4] },
            { "eye": [0, 0, 0], "look_at": [0, 0, -2], "fov_y_deg": 40 } ] }"#;
        let set = CameraFile::as_probes(text).unwrap();
        assert_eq!((set.cameras.len(), set.aspect().unwrap()), (2, Some(1.5)));
        assert_eq!((set.cameras[0].frames, set.cameras[0].fov_y_deg), (Some([2, 4]), Some(50.0)));
        assert_eq!(set.cameras[1].orientation, None);
        let [forward, right, down] = CameraFile::parse(text).unwrap()[0].camera.axes();
        let turn = codec::math::camera::rotation(set.cameras[0].orientation.unwrap()).unwrap();
        for (axis, of_probe) in [(forward, DVec3::NEG_Z), (right, DVec3::X), (down, DVec3::NEG_Y)] {
            assert!((turn * of_probe - axis).length() < 1e-12);
        }
        let two = std::str::from_utf8(text).unwrap().replace("\"fov_y_deg\": 40", "\"fov_y_deg\": 40, \"aspect\": 1");
        let two = CameraFile::as_probes(two.as_bytes()).unwrap();
        assert!(two.aspect().unwrap_err().to_string().contains("different"));
    }

    #[test]
    fn files_that_make_no_sense_are_refused_with_a_reason() {
        let camera = |keys: &str| format!(r#"{{ "cameras": [{{ "eye": [0, 0, 0], "fov_y_deg": 60{keys} }}] }}"#);
        let looking = r#", "look_at": [0, 0, -1]"#;
        assert!(CameraFile::parse(camera(looking).as_bytes()).is_ok());
        for (text, words) in [
            ("{}".to_owned(), "cameras"),
            (r#"{ "cameras": [] }"#.to_owned(), "at least one"),
            (r#"{ "cameras": [], "camera": 1 }"#.to_owned(), "`camera`"),
            (camera(&format!(r#"{looking}, "fov": 3"#)), "`fov`"),
            (camera(""), "either"),
            (camera(&format!(r#"{looking}, "orientation": [0, 0, 0, 1]"#)), "either"),
            (camera(r#", "orientation": [0, 0, 0, 1], "up": [0, 1, 0]"#), "\"up\" needs"),
            (camera(r#", "orientation": [0, 0, 0, 2]"#), "camera 0: "),
            (camera(r#", "look_at": [0, 0, 0]"#), "same point or too far"),
            (camera(&format!(r#"{looking}, "aspect": 0"#)), "above 0"),
            (camera(&format!(r#"{looking}, "near_m": 2, "far_m": 1"#)), "near < far"),
            (camera(&format!(r#"{looking}, "frames": [3, 2]"#)), "[3, 2]"),
            (camera(&format!(r#"{looking}, "eye": [0, 0, 0]"#)), "duplicate"),
        ] {
            let said = CameraFile::parse(text.as_bytes()).unwrap_err().to_string();
            assert!(said.contains(words), "{text}: {said}");
        }
    }
}
