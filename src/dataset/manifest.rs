//! `lightfield.json`: the manifest of a dataset.

use std::collections::BTreeSet;
use std::io::Read;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::dataset::missing::Missing;
use crate::error::{Error, Result};
use crate::image::{ColorSpace, DepthKind, Face, FrameRange, Pattern, Projection, StreamKind};
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
    pub lightfield: u32,
    pub name: String,
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
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub depth: Option<DepthInfo>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub color: Option<ColorInfo>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub material: Option<MaterialInfo>,
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
    /// Unit of the values. Metres when it and `scale` are absent, except in integer files, which need one of them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unit: Option<Unit>,
    /// Metres per unit instead of `unit`; for integer files.
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

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ColorInfo {
    pub space: ColorSpace,
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

impl Default for MaterialChannels {
    fn default() -> Self {
        MaterialChannels { reflection: "reflect".into(), refraction: "refract".into(), ior: "ior".into() }
    }
}

/// File patterns, relative to the manifest: `{probe}` and `{face}` stand for names, `%04d` or `####` for the frame.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Files {
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub color: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub depth: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub material: Option<String>,
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
        }
    }
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Probe {
    /// Name, of letters, digits, `.`, `_` and `-`.
    pub name: String,
    /// Centre in metres.
    pub position: [f64; 3],
    /// First and last frame of this probe; those of the dataset when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frames: Option<[u32; 2]>,
    /// Unit quaternion x, y, z, w that turns the probe's axes into the world's; none when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub orientation: Option<[f64; 4]>,
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

fn file_pattern(text: &str, probe: &str, face: Face) -> Result<Pattern> {
    Pattern::parse(&text.replace("{probe}", probe).replace("{face}", face.name()))
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

    /// Pattern of the files of a stream, below the manifest's folder; `None` where the dataset has no such stream.
    pub fn pattern(&self, kind: StreamKind, probe: &str, face: Face) -> Result<Option<Pattern>> {
        self.files.get(kind).map(|text| file_pattern(text, probe, face)).transpose()
    }

    /// As [`Self::pattern`], of normals.
    pub fn normal_pattern(&self, probe: &str, face: Face) -> Result<Option<Pattern>> {
        self.files.normal.as_deref().map(|text| file_pattern(text, probe, face)).transpose()
    }

    pub fn validate(&self) -> Result<()> {
        let wrong = |message: String| Err(Error::invalid(message));
        if self.lightfield != MANIFEST_VERSION {
            return wrong(format!(
                "\"lightfield\" is {}, this program reads version {MANIFEST_VERSION}",
                self.lightfield
            ));
        }
        if self.name.is_empty() || self.name.contains(char::is_control) {
            return wrong("\"name\" must be a word or more, without control characters".into());
        }
        if !(self.fps.is_finite() && self.fps > 0.0) {
            return wrong(format!("\"fps\" is {}, it must be above 0", self.fps));
        }
        check_frames(self.frames).map_err(|error| error.context("\"frames\""))?;
        let [width, height] = self.size;
        if width == 0 || height == 0 || width > MAX_SIDE || height > MAX_SIDE {
            return wrong(format!("\"size\" is {width}x{height}, each side must be 1 to {MAX_SIDE} pixels"));
        }
        if self.projection != Projection::Cubemap && self.faces.is_some() {
            return wrong("\"faces\" is only for projection \"cubemap\"".into());
        }
        if self.has_face_files() && width != height {
            return wrong(format!("\"size\" is {width}x{height}, but the faces of a cube are square"));
        }
        if let Some(names) = &self.faces_present {
            self.validate_faces(names)?;
        }
        self.validate_depth()?;
        self.validate_files()?;
        self.validate_probes()
    }

    fn validate_faces(&self, names: &[String]) -> Result<()> {
        if self.projection == Projection::Perspective {
            return Err(Error::invalid("\"faces_present\" is not for projection \"perspective\""));
        }
        let known = |name: &&String| Face::CUBE.iter().any(|face| face.name() == name.as_str());
        if let Some(name) = names.iter().find(|name| !known(name)) {
            let message = format!("\"faces_present\" names \"{name}\", the faces are px, nx, py, ny, pz, nz");
            return Err(Error::invalid(message));
        }
        if names.is_empty() || names.iter().collect::<BTreeSet<_>>().len() != names.len() {
            return Err(Error::invalid("\"faces_present\" must name at least one face, and each once"));
        }
        Ok(())
    }

    fn validate_depth(&self) -> Result<()> {
        let Some(depth) = &self.depth else { return Ok(()) };
        let wrong = |message: String| Err(Error::invalid(message));
        match &depth.background {
            Background::Word(word) if word != "inf" => {
                return wrong(format!("depth \"background\" is \"{word}\", it must be a number or \"inf\""));
            }
            Background::Value(value) if !(*value as f32).is_finite() => {
                return wrong(format!("depth \"background\" is {value}, which is no 32-bit float"));
            }
            _ => {}
        }
        let metric = |value: Option<f64>| value.is_none_or(|value| value.is_finite() && value > 0.0);
        if !metric(depth.scale) {
            return wrong("depth \"scale\" must be above 0 metres per unit".into());
        }
        if depth.scale.is_some() && depth.unit.is_some_and(|unit| unit != Unit::M) {
            return wrong("depth has both a \"scale\" and a \"unit\" other than m: leave one out".into());
        }
        if !metric(depth.near) || !metric(depth.far) {
            return wrong("depth \"near\" and \"far\" must be above 0 metres".into());
        }
        if let (Some(near), Some(far)) = (depth.near, depth.far)
            && near > far
        {
            return wrong(format!("depth \"near\" is {near}, it must be below \"far\", {far}"));
        }
        if depth.kind == DepthKind::Planar && self.projection == Projection::Equirect {
            return wrong(
                "depth \"kind\" is \"planar\", but equirectangular images have no plane: use \"distance\"".into(),
            );
        }
        Ok(())
    }

    fn validate_files(&self) -> Result<()> {
        let streams = StreamKind::ALL.map(|kind| (kind.name(), self.files.get(kind)));
        for (name, text) in streams.into_iter().chain([("normal", self.files.normal.as_deref())]) {
            let Some(text) = text else { continue };
            let wrong = |what: String| Err(Error::invalid(format!("files \"{name}\": {what}")));
            if self.probes.len() > 1 && !text.contains("{probe}") {
                return wrong(format!("\"{text}\" has no {{probe}}, so all probes would share files"));
            }
            if self.has_face_files() && self.faces().len() > 1 && !text.contains("{face}") {
                return wrong(format!("\"{text}\" has no {{face}}, so all faces would share files"));
            }
            if !self.has_face_files() && text.contains("{face}") {
                return wrong(format!("\"{text}\" has {{face}}, but one image holds them all"));
            }
            let pattern = file_pattern(text, "0", Face::Px).map_err(|error| Error::invalid(error.to_string()))?;
            if !pattern.has_field() {
                return wrong(format!("\"{text}\" has no place for the frame number, such as %04d"));
            }
        }
        match streams.iter().any(|(_, text)| text.is_some()) {
            true => Ok(()),
            false => Err(Error::invalid("\"files\" names no color, depth or material")),
        }
    }

    fn validate_probes(&self) -> Result<()> {
        if self.probes.is_empty() {
            return Err(Error::invalid("\"probes\" is empty"));
        }
        let mut names = BTreeSet::new();
        for probe in &self.probes {
            let wrong = |what: String| Err(Error::invalid(format!("probe \"{}\": {what}", probe.name)));
            if let Some(fault) = pose_fault(&probe.name, probe.position, probe.orientation, probe.fov_y_deg) {
                return wrong(fault.into());
            }
            if !names.insert(&probe.name) {
                return wrong("there are two probes of this name".into());
            }
            if let Some(frames) = probe.frames {
                check_frames(frames).map_err(|error| error.context(format!("probe \"{}\": \"frames\"", probe.name)))?;
            }
            let has_lens = probe.fov_y_deg.is_some() || probe.intrinsics.is_some();
            if has_lens && self.projection != Projection::Perspective {
                return wrong("\"fov_y_deg\" and \"intrinsics\" are only for projection \"perspective\"".into());
            }
            if probe.fov_y_deg.is_some() && probe.intrinsics.is_some() {
                return wrong("it has both \"fov_y_deg\" and \"intrinsics\": leave one out".into());
            }
            if let Some(intrinsics) = probe.intrinsics
                && let Err(error) = check_intrinsics(intrinsics)
            {
                return wrong(error.to_string());
            }
        }
        Ok(())
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

fn check_frames([first, last]: [u32; 2]) -> Result<()> {
    if first <= last {
        return Ok(());
    }
    Err(Error::invalid(format!("first frame {first} comes after last frame {last}")))
}
