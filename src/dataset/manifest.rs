//! `lightfield.json`: the manifest of a dataset (formats/manifest.md 2).

mod validate;

use std::collections::BTreeMap;
use std::io::Read;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Deserializer, Serialize};

use crate::dataset::missing::Missing;
use crate::error::{Error, Result};
use crate::image::layout::eye_size;
use crate::image::{ColorSpace, DepthKind, Eye, Face, FrameRange, Pattern, Projection, StereoLayout, StreamKind};
use crate::json;
use crate::math::camera::rotation;

pub const MANIFEST_NAME: &str = "lightfield.json";
/// Version of the schema that this program reads and writes.
pub const MANIFEST_VERSION: u32 = 1;
/// Larger manifests are refused.
pub const MAX_MANIFEST_BYTES: u64 = 16 << 20;
/// Longest side, in pixels, of the images that a manifest may declare.
pub const MAX_SIDE: u32 = 65_536;

/// The whole file. Unknown keys are errors, except inside `extra`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Manifest {
    /// Address of the schema, for editors; kept, never read.
    #[serde(rename = "$schema", default, skip_serializing_if = "Option::is_none")]
    pub schema: Option<String>,
    pub lightfield: u32,
    pub name: String,
    /// Frames per second. In files also a ratio, such as "24000/1001".
    #[serde(deserialize_with = "frame_rate")]
    pub fps: f64,
    /// First and last frame, inclusive.
    pub frames: [u32; 2],
    pub projection: Projection,
    /// Width and height of each image file, in pixels.
    pub size: [u32; 2],
    /// File layout of cube maps; six files when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub faces: Option<FaceFiles>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub faces_present: Option<Vec<String>>,
    /// What `{face}` stands for, by the name of the face; the name itself where it is absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub face_names: Option<BTreeMap<String, String>>,
    /// Place of the two eyes' pictures in each image; each probe is one eye.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stereo: Option<StereoLayout>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub depth: Option<DepthInfo>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub color: Option<ColorInfo>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub material: Option<MaterialInfo>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub alpha: Option<AlphaInfo>,
    /// Treatment of frames whose file is missing; an error when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub missing: Option<Missing>,
    pub files: Files,
    pub probes: Vec<Probe>,
    /// Other data; kept, never read.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub extra: Option<serde_json::Value>,
}

#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum FaceFiles {
    /// Six files; the pattern holds `{face}`.
    #[default]
    #[serde(rename = "opengl-cube")]
    Six,
    /// One file, an unfolded cube of 4:3 or 3:4 ([`crate::image::layout`]).
    #[serde(rename = "opengl-cube-cross")]
    Cross,
    /// One file, a strip of 6:1 or 1:6 ([`crate::image::layout`]).
    #[serde(rename = "opengl-cube-strip")]
    Strip,
}

#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Unit {
    #[default]
    M,
    Cm,
    Mm,
}

impl Unit {
    pub fn metres(self) -> f64 {
        match self {
            Unit::M => 1.0,
            Unit::Cm => 0.01,
            Unit::Mm => 0.001,
        }
    }
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DepthInfo {
    #[serde(default)]
    pub kind: DepthKind,
    /// Channel, layer, part or stereo view of EXR files; found by its usual names when absent. `{probe}` and `{face}` stand
    /// for names.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub channel: Option<String>,
    /// Unit of the values. Metres when it and `scale` are absent, except in integer files, which need one of them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unit: Option<Unit>,
    /// Metres per unit instead of `unit`, not 0. Below 0 where values in front of the camera are negative.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scale: Option<f64>,
    /// The value of the background in the files, before unit and scale. So is +inf.
    #[serde(default)]
    pub background: Background,
    /// Nearest depth in metres, above 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub near: Option<f64>,
    /// Farthest depth in metres, above `near`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub far: Option<f64>,
}

impl Default for DepthInfo {
    fn default() -> Self {
        DepthInfo {
            kind: DepthKind::Distance,
            channel: None,
            unit: Some(Unit::M),
            scale: None,
            background: Background::default(),
            near: None,
            far: None,
        }
    }
}

impl DepthInfo {
    /// Metres per unit of the files, if stated.
    pub fn stated_scale(&self) -> Option<f64> {
        self.scale.or(self.unit.map(Unit::metres))
    }
}

/// A number, or the word `inf`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Background {
    Value(f64),
    /// `inf`; any other word is refused.
    Word(String),
}

impl Default for Background {
    fn default() -> Self {
        Background::Word("inf".into())
    }
}

impl Background {
    /// The value, +inf for the word.
    pub fn value(&self) -> f32 {
        match self {
            Background::Value(value) => *value as f32,
            Background::Word(_) => f32::INFINITY,
        }
    }
}

#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ColorInfo {
    /// When absent, linear light for EXR files and sRGB for PNG files.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub space: Option<ColorSpace>,
    /// Layer, part, stereo view or three channels of EXR files; found by its usual names when absent. `{probe}` and
    /// `{face}` stand for names.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub layer: Option<String>,
}

#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AlphaInfo {
    /// Channel of EXR files; that of the layer of colour when absent. `{probe}` and `{face}` stand for names.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub channel: Option<String>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MaterialInfo {
    pub channels: MaterialChannels,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MaterialChannels {
    pub reflection: String,
    pub refraction: String,
    pub ior: String,
}

impl MaterialChannels {
    pub fn names(&self) -> [&str; 3] {
        [&self.reflection, &self.refraction, &self.ior]
    }
}

impl Default for MaterialChannels {
    fn default() -> Self {
        MaterialChannels { reflection: "reflect".into(), refraction: "refract".into(), ior: "ior".into() }
    }
}

/// File patterns, relative to the manifest: `{probe}` and `{face}` stand for names, `%04d`, `####`, `$F4` or `<frame04>` for
/// the frame.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Files {
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub color: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub depth: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub material: Option<String>,
    /// The files of colour, where these have alpha. Colour of EXR files is multiplied by it, that of PNG files is not.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub alpha: Option<String>,
    /// Normals are no stream of a container: simplification reads them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub normal: Option<String>,
}

/// Channels of files of normals.
pub const NORMAL_CHANNELS: [&str; 3] = ["X", "Y", "Z"];

impl Files {
    pub fn get(&self, kind: StreamKind) -> Option<&str> {
        match kind {
            StreamKind::Color => self.color.as_deref(),
            StreamKind::Depth => self.depth.as_deref(),
            StreamKind::Material => self.material.as_deref(),
            StreamKind::Alpha => self.alpha.as_deref(),
        }
    }
}

/// Pose of a moving probe in one frame.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Pose {
    /// Number of the frame.
    pub frame: u32,
    /// Centre in metres.
    pub position: [f64; 3],
    /// Unit quaternion x, y, z, w that turns the probe's axes into the world's; none when absent.
    #[serde(default = "no_turn")]
    pub orientation: [f64; 4],
}

fn no_turn() -> [f64; 4] {
    [0.0, 0.0, 0.0, 1.0]
}

/// A point of capture: a still one has a position, a moving one a pose in each of its frames.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Probe {
    /// Name, of letters, digits, `.`, `_` and `-`.
    pub name: String,
    /// Centre in metres. A moving probe needs none; if it has one, it is that of its first pose.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub position: Option<[f64; 3]>,
    /// First and last frame of this probe; those of the dataset when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frames: Option<[u32; 2]>,
    /// Unit quaternion x, y, z, w that turns the probe's axes into the world's; none when absent. Still probes only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub orientation: Option<[f64; 4]>,
    /// Poses of a moving probe, in any order: each of its frames once. Those of other frames are not used.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub poses: Vec<Pose>,
    /// The eye whose picture is read, where `stereo` puts two into each image.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub eye: Option<Eye>,
    /// Vertical field of view in degrees, 0..180 exclusive; perspective only. Without it and without `intrinsics` the
    /// camera is unknown, and planar depth stays planar.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fov_y_deg: Option<f64>,
    /// fx, fy, cx, cy in pixels; perspective only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub intrinsics: Option<[f64; 4]>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub extra: Option<serde_json::Value>,
}

impl Probe {
    /// Poses of a moving probe in the frames of a range, in order; none of a still one.
    pub fn poses_in(&self, frames: FrameRange) -> Vec<Pose> {
        let mut poses: Vec<Pose> = self.poses.iter().copied().filter(|pose| frames.contains(pose.frame)).collect();
        poses.sort_unstable_by_key(|pose| pose.frame);
        poses
    }

    /// Pose in the first frame of a range; that of all frames for a still probe.
    pub fn first_pose(&self, frames: FrameRange) -> Pose {
        let still = Pose {
            frame: frames.first,
            position: self.position.unwrap_or_default(),
            orientation: self.orientation.unwrap_or_else(no_turn),
        };
        self.poses_in(frames).first().copied().unwrap_or(still)
    }

    /// fx, fy, cx, cy for images of a size, from either key.
    pub fn intrinsics_for(&self, size: [u32; 2]) -> Option<[f64; 4]> {
        self.intrinsics.or_else(|| Some(intrinsics_of(self.fov_y_deg?, size)))
    }
}

/// fx, fy, cx, cy in pixels of an image with this vertical field of view in degrees.
pub fn intrinsics_of(fov_y_deg: f64, size: [u32; 2]) -> [f64; 4] {
    let [width, height] = size.map(f64::from);
    let focal = height / 2.0 / (fov_y_deg.to_radians() / 2.0).tan();
    [focal, focal, width / 2.0, height / 2.0]
}

fn file_pattern(text: &str, probe: &str, face: &str) -> Result<Pattern> {
    Pattern::parse(&text.replace("{probe}", probe).replace("{face}", face))
}

/// A frame rate: a number, or a ratio such as `24000/1001`. `None` for anything else, and where it is not above 0.
pub fn parse_frame_rate(text: &str) -> Option<f64> {
    let number = |text: &str| text.trim().parse::<f64>().ok();
    let rate = match text.split_once('/') {
        Some((frames, seconds)) => number(frames)? / number(seconds)?,
        None => number(text)?,
    };
    (rate.is_finite() && rate > 0.0).then_some(rate)
}

fn frame_rate<'de, D: Deserializer<'de>>(deserializer: D) -> std::result::Result<f64, D::Error> {
    #[derive(Deserialize)]
    #[serde(untagged, expecting = "\"fps\" must be a number, or a ratio such as \"24000/1001\"")]
    enum Rate {
        Number(f64),
        Ratio(String),
    }
    match Rate::deserialize(deserializer)? {
        Rate::Number(rate) => Ok(rate),
        Rate::Ratio(text) => parse_frame_rate(&text).ok_or_else(|| {
            let message = format!("\"fps\" is \"{text}\", it must be above 0, or a ratio such as \"24000/1001\"");
            serde::de::Error::custom(message)
        }),
    }
}

pub fn is_dataset(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension == "json") || path.join(MANIFEST_NAME).is_file()
}

/// The manifest's file, given itself or its folder.
pub fn manifest_path(path: &Path) -> PathBuf {
    if path.is_dir() { path.join(MANIFEST_NAME) } else { path.to_path_buf() }
}

/// The bytes of a manifest of any kind, at most [`MAX_MANIFEST_BYTES`].
pub(super) fn read_text(path: &Path) -> Result<Vec<u8>> {
    let file = crate::files::open_regular(path)?;
    let mut text = Vec::new();
    // Reads one byte more than allowed instead of trusting the file's stated length.
    file.take(MAX_MANIFEST_BYTES + 1).read_to_end(&mut text).map_err(|error| Error::io(path, error))?;
    if text.len() as u64 > MAX_MANIFEST_BYTES {
        return Err(Error::invalid("the manifest is larger than 16 MiB").in_file(path));
    }
    Ok(text)
}

impl Manifest {
    pub fn read(path: &Path) -> Result<Manifest> {
        let path = manifest_path(path);
        Manifest::from_json(&read_text(&path)?).map_err(|error| error.in_file(&path))
    }

    pub fn from_json(text: &[u8]) -> Result<Manifest> {
        let manifest: Manifest = serde_json::from_slice(text)
            .map_err(|error| Error::invalid(format!("this is not a lightfield manifest: {error}")))?;
        manifest.validate()?;
        Ok(manifest)
    }

    pub fn to_json(&self) -> Result<String> {
        self.validate()?;
        json::pretty(self)
    }

    pub fn frame_range(&self) -> FrameRange {
        FrameRange { first: self.frames[0], last: self.frames[1] }
    }

    pub fn face_files(&self) -> FaceFiles {
        self.faces.unwrap_or_default()
    }

    pub fn faces(&self) -> Vec<Face> {
        if self.projection == Projection::Perspective {
            return vec![Face::View];
        }
        let named = |face: &Face| match &self.faces_present {
            Some(names) => names.iter().any(|name| name == face.name()),
            None => true,
        };
        Face::CUBE.into_iter().filter(named).collect()
    }

    pub fn has_face_files(&self) -> bool {
        self.projection == Projection::Cubemap && self.face_files() == FaceFiles::Six
    }

    /// What `{face}` stands for.
    pub fn face_name(&self, face: Face) -> &str {
        let given = self.face_names.as_ref().and_then(|names| names.get(face.name()));
        given.map_or(face.name(), String::as_str)
    }

    /// Width and height of a picture: of each image file, or of one eye's part of it.
    pub fn picture_size(&self) -> [u32; 2] {
        self.stereo.and_then(|layout| eye_size(layout, self.size)).unwrap_or(self.size)
    }

    /// Frames of a probe.
    pub fn frames_of(&self, probe: &Probe) -> FrameRange {
        probe.frames.map_or(self.frame_range(), |[first, last]| FrameRange { first, last })
    }

    /// Names of channels or layers of a kind, as given; each may hold `{probe}` and `{face}`.
    fn channels(&self, kind: StreamKind) -> Vec<&str> {
        match kind {
            StreamKind::Color => self.color.iter().filter_map(|color| color.layer.as_deref()).collect(),
            StreamKind::Depth => self.depth.iter().filter_map(|depth| depth.channel.as_deref()).collect(),
            StreamKind::Material => self.material.iter().flat_map(|material| material.channels.names()).collect(),
            StreamKind::Alpha => self.alpha.iter().filter_map(|alpha| alpha.channel.as_deref()).collect(),
        }
    }

    /// Pattern of the files of a stream, below the manifest's folder; `None` where the dataset has no such stream.
    pub fn pattern(&self, kind: StreamKind, probe: &str, face: Face) -> Result<Option<Pattern>> {
        self.files.get(kind).map(|text| file_pattern(text, probe, self.face_name(face))).transpose()
    }

    /// As [`Self::pattern`], of normals.
    pub fn normal_pattern(&self, probe: &str, face: Face) -> Result<Option<Pattern>> {
        self.files.normal.as_deref().map(|text| file_pattern(text, probe, self.face_name(face))).transpose()
    }
}

/// Whether a name is valid for a probe: file names contain it.
pub fn is_probe_name(name: &str) -> bool {
    let allowed = |byte: u8| byte.is_ascii_alphanumeric() || matches!(byte, b'.' | b'_' | b'-');
    (1..=100).contains(&name.len()) && name.bytes().all(allowed) && !name.starts_with('.')
}

/// What is wrong with the name or pose of a probe or camera.
pub(super) fn pose_fault(
    name: &str,
    position: [f64; 3],
    orientation: Option<[f64; 4]>,
    fov_y_deg: Option<f64>,
) -> Option<&'static str> {
    let faults = [
        (!is_probe_name(name), "a name is 1 to 100 letters, digits, '.', '_' or '-', and does not begin with '.'"),
        (position.iter().any(|value| !value.is_finite()), "\"position\" must be three finite numbers"),
        (orientation.is_some_and(|of| rotation(of).is_none()), "\"orientation\" must be a quaternion of length 1"),
        (fov_y_deg.is_some_and(|fov| !(fov > 0.0 && fov < 180.0)), "\"fov_y_deg\" must lie between 0 and 180"),
    ];
    faults.into_iter().find(|(is_so, _)| *is_so).map(|(_, fault)| fault)
}

/// Checks fx, fy, cx, cy: all finite, focal lengths above 0.
pub(crate) fn check_intrinsics(intrinsics: [f64; 4]) -> Result<()> {
    if intrinsics.iter().all(|value| value.is_finite()) && intrinsics[0] > 0.0 && intrinsics[1] > 0.0 {
        return Ok(());
    }
    Err(Error::invalid("\"intrinsics\" must be finite numbers fx, fy, cx, cy with focal lengths above 0"))
}
