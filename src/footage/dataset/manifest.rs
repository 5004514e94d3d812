//! `lightfield.json`: the manifest of a dataset (formats/manifest.md 2).

mod probe;
mod validate;

use std::collections::BTreeMap;
use std::io::Read;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Deserializer, Serialize};

use crate::dataset::missing::Missing;
use crate::dataset::pixels::Disparity;
use crate::dataset::timed::TIME;
use crate::image_files::ColorSpace;
use crate::{json, text};
use codec::error::{Error, Result};
use codec::image::layout::eye_size;
use codec::image::{DepthKind, Face, FrameRange, Pattern, Projection, StereoLayout, StreamKind};
use codec::math::camera::rotation;
use codec::streams::StartView;

pub use probe::{Pose, Probe, UpAxis, intrinsics_of};

pub const MANIFEST_NAME: &str = "lightfield.json";
/// Version of the schema that this program reads and writes.
pub const MANIFEST_VERSION: u32 = 1;
/// Maximum size of a manifest in bytes.
pub const MAX_MANIFEST_BYTES: u64 = 16 << 20;
/// Maximum side in pixels of the images that a manifest may declare.
pub const MAX_SIDE: u32 = 65_536;

/// The manifest. Unknown keys are errors, except inside `extra`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Manifest {
    /// URL of the schema, for editors; preserved, never read.
    #[serde(rename = "$schema", default, skip_serializing_if = "Option::is_none")]
    pub schema: Option<String>,
    pub lightfield: u32,
    pub name: String,
    /// Frames per second. Files may also state a ratio, such as "24000/1001".
    #[serde(deserialize_with = "frame_rate")]
    pub fps: f64,
    /// First and last frame, inclusive.
    pub frames: [u32; 2],
    pub projection: Projection,
    /// Width and height of each image file, in pixels, except those of probes with a `size` of their own.
    pub size: [u32; 2],
    /// Arrangement of the faces of cube maps in files; six files if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub faces: Option<FaceFiles>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub faces_present: Option<Vec<String>>,
    /// Text substituted for `{face}`, by face name; the face name itself if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub face_names: Option<BTreeMap<String, String>>,
    /// Position of the two eyes' pictures in each image; each probe is one eye.
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
    /// Treatment of frames whose file is missing; an error if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub missing: Option<Missing>,
    pub files: Files,
    pub probes: Vec<Probe>,
    /// Camera with which players open the film; chosen by them if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub view: Option<StartView>,
    /// Other data; preserved, never read.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub extra: Option<serde_json::Value>,
}

#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum FaceFiles {
    /// Six files per frame; the pattern contains `{face}`.
    #[default]
    #[serde(rename = "opengl-cube")]
    Six,
    /// One file with an unfolded cube of aspect 4:3 or 3:4 ([`codec::image::layout`]).
    #[serde(rename = "opengl-cube-cross")]
    Cross,
    /// One file with a strip of aspect 6:1 or 1:6 ([`codec::image::layout`]).
    #[serde(rename = "opengl-cube-strip")]
    Strip,
    /// Six files per frame, as six cameras see them (formats/manifest.md 1): not mirrored, unlike the faces of OpenGL.
    #[serde(rename = "camera-cube")]
    Cameras,
}

/// Quantity that depth files store.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum FileDepth {
    /// Euclidean distance from the probe centre.
    #[default]
    Distance,
    /// Distance along the viewing axis (Z buffer).
    Planar,
    /// Inverse of the distance along the viewing axis; for panoramas, of the distance from the centre.
    Disparity,
}

impl From<DepthKind> for FileDepth {
    fn from(kind: DepthKind) -> FileDepth {
        match kind {
            DepthKind::Distance => FileDepth::Distance,
            DepthKind::Planar => FileDepth::Planar,
        }
    }
}

impl FileDepth {
    /// Returns the kind of the metres that these files stand for.
    pub fn metric(self, projection: Projection) -> DepthKind {
        match self {
            FileDepth::Distance => DepthKind::Distance,
            FileDepth::Disparity if projection == Projection::Equirect => DepthKind::Distance,
            FileDepth::Planar | FileDepth::Disparity => DepthKind::Planar,
        }
    }
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
    pub kind: FileDepth,
    /// Channel, layer, part or stereo view of EXR files; if absent, found by common names. May contain `{probe}` and `{face}`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub channel: Option<String>,
    /// Unit of the values. Metres if both this and `scale` are absent, except for integer files, which need one of them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unit: Option<Unit>,
    /// Metres per unit, instead of `unit`; not 0. Negative if values in front of the camera are negative. For disparity, metres
    /// times its unit: baseline in metres times focal length in pixels, for disparity in pixels.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scale: Option<f64>,
    /// Background value of the files, before unit and scale. +inf is always background.
    #[serde(default)]
    pub background: Background,
    /// Nearest depth in metres, above 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub near: Option<f64>,
    /// Farthest depth in metres, at least `near`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub far: Option<f64>,
    /// Width and height of depth files in pixels, if it is not that of the other files: they show the same picture, and are
    /// resampled to the size of the others by nearest neighbour. Not for probes with a `size` of their own.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub size: Option<[u32; 2]>,
}

impl Default for DepthInfo {
    fn default() -> Self {
        DepthInfo {
            kind: FileDepth::Distance,
            channel: None,
            unit: Some(Unit::M),
            scale: None,
            background: Background::default(),
            near: None,
            far: None,
            size: None,
        }
    }
}

impl DepthInfo {
    /// Returns the metres per unit of the files, if stated.
    pub fn stated_scale(&self) -> Option<f64> {
        self.scale.or(self.unit.map(Unit::metres))
    }

    /// Returns the nearest and farthest distance of surfaces in metres, where stated. Those of normalised disparity define its
    /// values and bound nothing.
    pub fn stated_range(&self) -> [Option<f64>; 2] {
        match self.disparity() {
            Some(Disparity::Range(_)) => [None; 2],
            _ => [self.near, self.far],
        }
    }

    /// Returns the range of normalised disparity, if the files store it: `near` is 1, the largest code, and `far` is 0.
    pub fn disparity(&self) -> Option<Disparity> {
        match (self.kind, self.scale, self.near, self.far) {
            (FileDepth::Disparity, Some(scale), ..) => Some(Disparity::Scale(scale)),
            (FileDepth::Disparity, None, Some(near), Some(far)) => Some(Disparity::Range([near, far])),
            _ => None,
        }
    }
}

/// A number, or the word `inf`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Background {
    Value(f64),
    /// The word `inf`; any other word is an error.
    Word(String),
}

impl Default for Background {
    fn default() -> Self {
        Background::Word("inf".into())
    }
}

impl Background {
    /// Returns the value; +inf for the word.
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
    /// Colour space; if absent, linear for EXR files and sRGB for PNG files.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub space: Option<ColorSpace>,
    /// Layer, part, stereo view or three channels of EXR files; if absent, found by common names. May contain `{probe}` and
    /// `{face}`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub layer: Option<String>,
    /// How encoders store values above 1; if absent, footage with such values is refused.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub keep: Option<Keep>,
}

/// How encoders store colour values above 1, unless an option selects it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Keep {
    /// As half floats.
    Hdr,
    /// Clipped to 8 bits.
    Clip,
}

#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AlphaInfo {
    /// Channel of EXR files; if absent, that of the colour layer. May contain `{probe}` and `{face}`.
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

/// File patterns, relative to the manifest. `{probe}` and `{face}` are replaced by names; `%04d`, `####`, `$F4` or `<frame04>` is
/// the frame number, `{time}` a time.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Files {
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub color: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub depth: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub material: Option<String>,
    /// Pattern of the files with alpha, which may be the colour files. Colour in EXR files is premultiplied, colour in PNG files
    /// is not.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub alpha: Option<String>,
    /// Pattern of the normal maps. They are not stored in containers; simplification reads them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub normal: Option<String>,
}

/// Channel names of normal maps.
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

fn file_pattern(text: &str, probe: &str, face: &str) -> Result<Pattern> {
    Pattern::parse(&text.replace("{probe}", probe).replace("{face}", face))
}

/// Parses a frame rate: a number, or a ratio such as `24000/1001`. Returns `None` for other text, and if the rate is not
/// positive.
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

/// Returns the path of the manifest, given the file or its folder.
pub fn manifest_path(path: &Path) -> PathBuf {
    if path.is_dir() { path.join(MANIFEST_NAME) } else { path.to_path_buf() }
}

/// Reads the bytes of a manifest of any format, at most [`MAX_MANIFEST_BYTES`].
pub(super) fn read_text(path: &Path) -> Result<Vec<u8>> {
    let file = crate::files::open_regular(path)?;
    let mut text = Vec::new();
    // Read one byte more than allowed rather than trust the reported file size.
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

    pub fn from_json(bytes: &[u8]) -> Result<Manifest> {
        let manifest: Manifest = text::json(bytes, "a lightfield manifest")?;
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

    /// True if each image holds one face or view.
    pub fn has_one_face_per_file(&self) -> bool {
        self.projection == Projection::Perspective || self.has_face_files()
    }

    pub fn has_face_files(&self) -> bool {
        self.projection == Projection::Cubemap && matches!(self.face_files(), FaceFiles::Six | FaceFiles::Cameras)
    }

    /// Returns the text substituted for `{face}`.
    pub fn face_name(&self, face: Face) -> &str {
        let given = self.face_names.as_ref().and_then(|names| names.get(face.name()));
        given.map_or(face.name(), String::as_str)
    }

    /// Returns the width and height of the image files of a probe.
    pub fn size_of(&self, probe: &Probe) -> [u32; 2] {
        probe.size.unwrap_or(self.size)
    }

    /// Returns the width and height of a probe's picture: of its image files, or of one eye's part of them.
    pub fn picture_size_of(&self, probe: &Probe) -> [u32; 2] {
        self.picture_in(self.size_of(probe))
    }

    /// Returns the width and height of the picture in an image file of `size`.
    pub(super) fn picture_in(&self, size: [u32; 2]) -> [u32; 2] {
        self.stereo.and_then(|layout| eye_size(layout, size)).unwrap_or(size)
    }

    /// Returns the frames of a probe.
    pub fn frames_of(&self, probe: &Probe) -> FrameRange {
        probe.frames.map_or(self.frame_range(), |[first, last]| FrameRange { first, last })
    }

    /// Names of the channels or layers of a kind, as given; each may contain `{probe}` and `{face}`.
    fn channels(&self, kind: StreamKind) -> Vec<&str> {
        match kind {
            StreamKind::Color => self.color.iter().filter_map(|color| color.layer.as_deref()).collect(),
            StreamKind::Depth => self.depth.iter().filter_map(|depth| depth.channel.as_deref()).collect(),
            StreamKind::Material => self.material.iter().flat_map(|material| material.channels.names()).collect(),
            StreamKind::Alpha => self.alpha.iter().filter_map(|alpha| alpha.channel.as_deref()).collect(),
        }
    }

    /// Returns the file pattern of a stream, relative to the manifest's folder; `None` if the dataset has no such stream.
    pub fn pattern(&self, kind: StreamKind, probe: &str, face: Face) -> Result<Option<Pattern>> {
        self.files.get(kind).map(|text| file_pattern(text, probe, self.face_name(face))).transpose()
    }

    /// Returns the file pattern of a stream whose frames are named by times, which has `{time}` in place of a number; `None` for other streams.
    pub fn timed_pattern(&self, kind: StreamKind, probe: &str, face: Face) -> Option<String> {
        let text = self.files.get(kind).filter(|text| text.contains(TIME))?;
        Some(text.replace("{probe}", probe).replace("{face}", self.face_name(face)))
    }

    /// As [`Self::pattern`], for normal maps.
    pub fn normal_pattern(&self, probe: &str, face: Face) -> Result<Option<Pattern>> {
        self.files.normal.as_deref().map(|text| file_pattern(text, probe, self.face_name(face))).transpose()
    }
}

/// Returns true if a name is valid for a probe. Names are parts of file names.
pub fn is_probe_name(name: &str) -> bool {
    let allowed = |byte: u8| byte.is_ascii_alphanumeric() || matches!(byte, b'.' | b'_' | b'-');
    (1..=100).contains(&name.len()) && name.bytes().all(allowed) && !name.starts_with('.')
}

/// Returns what is wrong with the name or pose of a probe or camera, if anything.
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

/// Checks that fx, fy, cx, cy are finite and the focal lengths positive.
pub(crate) fn check_intrinsics(intrinsics: [f64; 4]) -> Result<()> {
    if intrinsics.iter().all(|value| value.is_finite()) && intrinsics[0] > 0.0 && intrinsics[1] > 0.0 {
        return Ok(());
    }
    Err(Error::invalid("\"intrinsics\" must be finite numbers fx, fy, cx, cy with focal lengths above 0"))
}
