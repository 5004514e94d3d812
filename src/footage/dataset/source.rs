//! Reads a dataset or an image sequence as planes of depth in metres and linear RGB.
//!
//! Opening (`open`) checks that all files exist; reading checks their content.

mod account;
mod open;
mod shape;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use half::f16;
use shape::{Content, Shape, Shapes};

use super::manifest::{Manifest, Pose};
use super::missing::{FrameFiles, Missing};
use super::normals::{self, NormalFiles};
use super::pixels::{
    DepthRules, InvalidColor, InvalidDepth, check_alpha, check_color, check_depth, check_material, check_plane,
    from_camera, keep_faces, linear_from_srgb, planar_to_distance, resized,
};
use crate::image_files::{ColorSpace, exr, png};
use codec::error::{Error, Result};
use codec::image::equirect::{FaceMap, resample_alpha, resample_color, resample_nearest};
use codec::image::layout::{cut_eye, cut_faces};
use codec::image::{
    AlphaPlane, ChannelSelect, ColorPlane, DepthKind, DepthPlane, Face, FrameRange, ImageProjection, MaterialPlane,
    NormalPlane, Plane, Primaries, Projection, ReadLimits, StereoLayout, StreamKind,
};

/// Options of the caller. `None` uses the manifest's value, or else the default of the field.
#[derive(Debug, Clone, Default)]
pub struct SourceOptions {
    /// Channel or layer of depth ([`ChannelSelect::Named`]).
    pub depth_channel: Option<String>,
    /// Layer or channels of colour ([`ChannelSelect::Named`]).
    pub color_channel: Option<String>,
    /// Three material channels, separated by commas.
    pub material_channel: Option<String>,
    /// Alpha channel.
    pub alpha_channel: Option<String>,
    /// Metres per unit of depth, not 0; negative if values in front of the camera are negative. Default 1, except for integer
    /// (PNG) depth, which has no default.
    pub depth_scale: Option<f64>,
    /// Background value of the files, before scaling. Default +inf.
    pub background: Option<f32>,
    /// Quantity that depth files store. Default distance.
    pub depth_kind: Option<DepthKind>,
    /// Colour space of the files. Default for EXR: linear with the primaries that the file states, or else Rec. 709; for PNG:
    /// sRGB.
    pub color_space: Option<ColorSpace>,
    pub invalid_depth: InvalidDepth,
    pub invalid_color: InvalidColor,
    /// Treatment of frames whose file is missing. Default an error.
    pub missing: Option<Missing>,
    pub frames: Option<FrameRange>,
    /// Side in pixels of cube faces resampled from equirectangular images, at most half their width. Default the size that
    /// keeps their resolution ([`codec::image::equirect::full_face_size`]).
    pub face_size: Option<u32>,
    pub limits: ReadLimits,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Arrangement {
    /// One face per image: a cube face, or [`Face::View`] for a perspective image.
    Single(Face),
    /// All six faces in a cross ([`codec::image::FaceLayout::Cross`]).
    Cross,
    /// All six faces in a strip ([`codec::image::FaceLayout::Strip`]).
    Strip,
    Equirect,
}

#[derive(Debug, Clone, PartialEq)]
pub struct SequenceLayout {
    pub arrangement: Arrangement,
    /// Name of the probe: letters, digits, `.`, `_` and `-`.
    pub probe: String,
    /// fx, fy, cx, cy in pixels, for a perspective image.
    pub intrinsics: Option<[f64; 4]>,
}

impl Default for SequenceLayout {
    fn default() -> Self {
        SequenceLayout { arrangement: Arrangement::Single(Face::View), probe: "00".into(), intrinsics: None }
    }
}

/// A probe of a source: its pose and frames.
#[derive(Debug, Clone, PartialEq)]
pub struct ProbeInfo {
    /// Unique within the source.
    pub name: String,
    /// Centre in metres; for a moving probe, at its first pose.
    pub position: [f64; 3],
    /// Unit quaternion x, y, z, w that rotates the probe's axes into the world's; for a moving probe, at its first pose.
    pub orientation: [f64; 4],
    /// Poses of a moving probe, one for each of its `frames`, in order; empty for a static probe.
    pub poses: Vec<Pose>,
    /// Frames of the probe within the caller's range. A probe without frames in that range keeps its own frames in this field and
    /// has no groups.
    pub frames: FrameRange,
    /// fx, fy, cx, cy in pixels; perspective only.
    pub intrinsics: Option<[f64; 4]>,
}

impl ProbeInfo {
    /// Returns the pose at a frame. For a static probe, and outside the probe's frames, it is `position` and `orientation`.
    pub fn pose(&self, frame: u32) -> Pose {
        let found = self.poses.binary_search_by_key(&frame, |pose| pose.frame).ok();
        let still = Pose { frame, position: self.position, orientation: self.orientation };
        found.map_or(still, |at| self.poses[at])
    }

    /// Returns the projection of a cube face, or of the perspective image if its camera is known.
    pub fn projection(&self, face: Face, size: [u32; 2]) -> Option<ImageProjection> {
        match face {
            Face::View => Some(ImageProjection::Pinhole { size, intrinsics: self.intrinsics? }),
            face => Some(ImageProjection::CubeFace { face, size }),
        }
    }
}

/// Streams that are read from the same files: one face per file, or six faces in one image.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SourceGroup {
    /// Kind of the streams: colour, depth, material or alpha.
    pub kind: StreamKind,
    /// Index into the probes of the source.
    pub probe: usize,
    /// The faces, in the order of their numbers.
    pub faces: Vec<Face>,
    /// First and last frame, inclusive.
    pub frames: FrameRange,
    /// Width of a face in pixels, after cutting or resampling.
    pub width: u32,
    /// Height of a face in pixels, after cutting or resampling.
    pub height: u32,
}

/// An open dataset. Reading takes `&self`, so that frames can be read in parallel.
#[derive(Debug)]
pub struct Source {
    name: String,
    fps: f64,
    projection: Projection,
    probes: Vec<ProbeInfo>,
    groups: Vec<SourceGroup>,
    /// Files of each group, by kind, probe and first face.
    sequences: BTreeMap<(StreamKind, usize, Face), FrameFiles>,
    normals: NormalFiles,
    /// The manifest, if the source was opened from one.
    pub manifest: Option<Manifest>,
    content: Content,
    stereo: Option<StereoLayout>,
    shapes: Shapes,
    pub rules: DepthRules,
    /// True if the depth scale is stated.
    scale_stated: bool,
    /// Quantity that [`Self::read_depth`] returns: distance, or planar Z if the camera is not known well enough to convert.
    pub depth_stored: DepthKind,
    /// Declared quantity of the depth in files.
    pub depth_in_files: DepthKind,
    pub color_space: Option<ColorSpace>,
    /// Primaries of the colour that is returned.
    primaries: Primaries,
    color_channel: ChannelSelect,
    depth_channel: ChannelSelect,
    material_channels: [String; 3],
    alpha_channel: ChannelSelect,
    invalid_color: InvalidColor,
    missing: Missing,
    limits: ReadLimits,
}

impl Source {
    /// Name of the dataset; for a single sequence, the name of its files.
    pub fn name(&self) -> &str {
        &self.name
    }

    pub fn fps(&self) -> f64 {
        self.fps
    }

    /// Projection of the returned images. Equirectangular images are returned as cube maps.
    pub fn projection(&self) -> Projection {
        self.projection
    }

    pub fn probes(&self) -> &[ProbeInfo] {
        &self.probes
    }

    /// Upper bound in bytes of the memory for reading a frame of a group, including the returned planes: the file, which is
    /// decoded as a whole, and the parts cut from it.
    pub fn reading_bytes(&self, group: &SourceGroup) -> u64 {
        let count = |size: [u32; 2]| size.map(u64::from).iter().product::<u64>();
        let file_pixels = count(self.shape(group).file_size.into());
        let pixels = u64::from(group.width) * u64::from(group.height) * group.faces.len() as u64;
        let value = match group.kind {
            StreamKind::Depth | StreamKind::Alpha => 4,
            StreamKind::Color => 6,
            StreamKind::Material => 12,
        };
        let path = self.path(group.kind, group, group.frames.first).ok().flatten();
        let is_png = path.as_deref().is_some_and(png::has_codes);
        let decoding = match (is_png, group.kind) {
            (false, _) => path.as_deref().map_or(0, |path| exr::reading_bytes(path, 0, &self.limits).unwrap_or(0)),
            // The codes of the file, and 16 bits for each requested channel.
            (true, StreamKind::Depth) => 2 * self.depth_size(group).map_or(file_pixels, count),
            (true, _) => (8 + 8) * file_pixels,
        };
        // Codes or values of alpha, and colour before and after multiplication.
        let is_multiplied = is_png && group.kind == StreamKind::Color && self.group_beside(group).is_some();
        let alpha = if is_multiplied { 16 * file_pixels } else { 0 };
        // Depth of another size, before it is resampled.
        let resized =
            self.depth_size(group).filter(|_| group.kind == StreamKind::Depth).map_or(0, |size| value * count(size));
        let is_cut = self.stereo.is_some() || self.content != Content::Face;
        let cut = if is_cut { pixels * value } else { 0 };
        file_pixels * value + resized + decoding.max(alpha).max(cut)
    }

    /// The groups, sorted by kind (colour, depth, material, alpha), probe and face.
    pub fn groups(&self) -> &[SourceGroup] {
        &self.groups
    }

    /// Primaries of all colour: those of the stated colour space, or else of the first colour file.
    pub fn primaries(&self) -> Primaries {
        self.primaries
    }

    /// Reads the colour of a file: linear, or for an EXR file declared as sRGB, sRGB values.
    fn color_file(&self, path: &Path, group: &SourceGroup) -> Result<ColorPlane> {
        if png::has_codes(path) {
            let plane = png::read_color(path, self.color_space.unwrap_or(ColorSpace::Srgb), &self.limits)?;
            return self.check_primaries(Primaries::REC709).map(|()| plane);
        }
        let select = self.select(&self.color_channel, group);
        if self.color_space.is_some() {
            return exr::read_color(path, &select, &self.limits);
        }
        let (plane, primaries) = exr::read_color_and_primaries(path, &select, &self.limits)?;
        self.check_primaries(primaries).map(|()| plane)
    }

    fn check_primaries(&self, found: Primaries) -> Result<()> {
        if self.color_space.is_some() || found.is_same(self.primaries) {
            return Ok(());
        }
        let [found, others] = [found, self.primaries].map(Primaries::to_array);
        Err(Error::invalid(format!(
            "its chromaticities are {found:?}, those of the first colour file {others:?}: all files must agree; set \
            `color_space` to ignore them"
        )))
    }

    /// Reads the linear colour of a frame in [`Self::primaries`], one plane per face of the group, with finite values. If the
    /// source has alpha, colour is premultiplied: PNG colour is multiplied by this function, EXR colour is stored so.
    pub fn read_color(&self, group: &SourceGroup, frame: u32) -> Result<Vec<ColorPlane>> {
        self.read_color_by(group, frame, resample_color)
    }

    /// As [`Self::read_color`], but faces of panoramas are sampled by nearest neighbour. Building the filter tables for
    /// resampling takes far longer than reading an image.
    pub fn read_color_unfiltered(&self, group: &SourceGroup, frame: u32) -> Result<Vec<ColorPlane>> {
        self.read_color_by(group, frame, resample_nearest)
    }

    fn read_color_by(
        &self,
        group: &SourceGroup,
        frame: u32,
        resample: fn(&ColorPlane, &FaceMap) -> Result<ColorPlane>,
    ) -> Result<Vec<ColorPlane>> {
        self.read(StreamKind::Color, group, frame, [f16::ZERO; 3], |path| {
            let mut plane = self.color_file(path, group)?;
            self.check_size(&plane, group)?;
            check_color(&mut plane, self.invalid_color)?;
            if !png::has_codes(path) && self.color_space == Some(ColorSpace::Srgb) {
                linear_from_srgb(&mut plane);
            }
            if png::has_codes(path)
                && let Some(alpha) = self.alpha_beside(group, frame)?
            {
                plane = plane.zip(&alpha, |light, alpha| light.map(|value| f16::from_f32(value.to_f32() * alpha)))?;
            }
            self.faces_of(plane, group, resample)
        })
    }

    /// Reads the alpha of a colour frame: 0 if its own file is missing and replaced by black; `None` if the source has no alpha.
    fn alpha_beside(&self, color: &SourceGroup, frame: u32) -> Result<Option<AlphaPlane>> {
        let Some(group) = self.group_beside(color) else { return Ok(None) };
        if !group.frames.contains(frame) {
            let message =
                "the alpha of this frame is missing, which premultiplied colour needs: set `missing` to hold or black";
            return Err(Error::invalid(message));
        }
        let (width, height) = self.shape(group).file_size;
        match self.file(group, frame)? {
            Some(path) => self.alpha_file(&path, group).map(Some).map_err(|error| error.in_file(&path)),
            None => Ok(Some(Plane::filled(width, height, 0.0))),
        }
    }

    /// Returns the alpha group with the same probe and faces as a colour group.
    fn group_beside(&self, color: &SourceGroup) -> Option<&SourceGroup> {
        let is_beside = |group: &&SourceGroup| {
            (group.kind, group.probe, &group.faces) == (StreamKind::Alpha, color.probe, &color.faces)
        };
        self.groups.iter().find(is_beside)
    }

    /// Returns the first colour file and its number of pixels with an alpha below 1, if the dataset declares no alpha. `None` if
    /// there are no such pixels.
    pub fn unnamed_alpha(&self) -> Option<(PathBuf, u64)> {
        if self.groups.iter().any(|group| group.kind == StreamKind::Alpha) {
            return None;
        }
        let color = self.groups.iter().find(|group| group.kind == StreamKind::Color)?;
        let path = self.path(StreamKind::Color, color, color.frames.first).ok()??;
        // A gray file holds colour, not an alpha matte.
        if png::has_codes(&path) && !png::has_alpha(&path, &self.limits).ok()? {
            return None;
        }
        let alpha = self.alpha_file(&path, color).ok()?;
        let below = alpha.data().iter().filter(|alpha| **alpha < 1.0).count() as u64;
        (below > 0).then_some((path, below))
    }

    /// Reads the alpha of a frame, 0 to 1, one plane per face of the group.
    pub fn read_alpha(&self, group: &SourceGroup, frame: u32) -> Result<Vec<AlphaPlane>> {
        self.read(StreamKind::Alpha, group, frame, 0.0, |path| {
            self.faces_of(self.alpha_file(path, group)?, group, resample_alpha)
        })
    }

    fn alpha_file(&self, path: &Path, group: &SourceGroup) -> Result<AlphaPlane> {
        let mut plane = if png::has_codes(path) {
            png::read_alpha(path, &self.limits)?
        } else {
            let [own, color] = [&self.alpha_channel, &self.color_channel].map(|channel| self.select(channel, group));
            exr::read_alpha(path, &own, &color, &self.limits)?
        };
        self.check_size(&plane, group)?;
        check_alpha(&mut plane, self.invalid_color)?;
        Ok(plane)
    }

    /// Reads the depth of a frame in metres, one plane per face of the group: +inf exactly for the background, 0.0 where
    /// [`InvalidDepth::Near`] was applied, all other values finite and positive.
    pub fn read_depth(&self, group: &SourceGroup, frame: u32) -> Result<Vec<DepthPlane>> {
        self.read(StreamKind::Depth, group, frame, f32::INFINITY, |path| {
            let mut plane = self.depth_file(path, group)?;
            let rules = self.rules_for(path)?;
            let mut planes = if let Content::Faces(_) = self.content {
                // Pixels outside the faces may have any value, so only the faces are checked.
                let mut planes = self.faces_of(plane, group, resample_nearest)?;
                for (face, plane) in group.faces.iter().zip(&mut planes) {
                    check_depth(plane, &rules).map_err(|error| error.context(format!("face {}", face.name())))?;
                }
                planes
            } else {
                check_depth(&mut plane, &rules)?;
                self.faces_of(plane, group, resample_nearest)?
            };
            if self.depth_in_files != self.depth_stored {
                for (face, plane) in group.faces.iter().zip(&mut planes) {
                    let size = [plane.width(), plane.height()];
                    let known = self.probes.get(group.probe).and_then(|probe| probe.projection(*face, size));
                    let projection = known.unwrap_or(ImageProjection::CubeFace { face: *face, size });
                    planar_to_distance(plane, &projection);
                }
            }
            Ok(planes)
        })
    }

    /// Returns true if planar depth of perspective views is converted to distance.
    pub fn converts_views(&self) -> bool {
        self.projection == Projection::Perspective && self.depth_in_files != self.depth_stored
    }

    /// Disables the conversion of planar depth of perspective views to distance.
    pub fn keep_kind_of_views(&mut self) {
        if self.converts_views() {
            self.depth_stored = self.depth_in_files;
        }
    }

    /// Reads the stored depth of a frame, before background, unit and kind are applied, one plane per face of the group. Values
    /// may be arbitrary, including NaN.
    pub fn read_depth_as_stored(&self, group: &SourceGroup, frame: u32) -> Result<Vec<DepthPlane>> {
        let read = |path: &Path| self.faces_of(self.depth_file(path, group)?, group, resample_nearest);
        self.read(group.kind, group, frame, f32::INFINITY, read)
    }

    /// Reads the material of a frame, one plane per face of the group, with finite values.
    pub fn read_material(&self, group: &SourceGroup, frame: u32) -> Result<Vec<MaterialPlane>> {
        self.read(StreamKind::Material, group, frame, [0.0, 0.0, 1.0], |path| {
            if png::has_codes(path) {
                return Err(Error::unsupported("material must be EXR files"));
            }
            let (probe, face) = self.names(group);
            let names =
                self.material_channels.each_ref().map(|name| name.replace("{probe}", probe).replace("{face}", face));
            let mut plane = exr::read_material(path, names.each_ref().map(String::as_str), &self.limits)?;
            self.check_size(&plane, group)?;
            check_material(&mut plane, self.invalid_color)?;
            // A pixel's weights belong to one surface, so they are not blended.
            self.faces_of(plane, group, resample_nearest)
        })
    }

    /// Reads the normals of a frame, one plane per face of a group of any kind; `None` if the dataset has no normals.
    pub fn read_normal(&self, group: &SourceGroup, frame: u32) -> Result<Option<Vec<NormalPlane>>> {
        let Some(path) = self.normals.path(group.probe, group.faces[0], frame) else { return Ok(None) };
        let read = |path: &Path| {
            let plane = normals::read(path, &self.limits)?;
            self.check_size(&plane, group)?;
            self.faces_of(plane, group, resample_nearest)
        };
        read(&path).map(Some).map_err(|error| error.in_file(&path).context(format!("frame {frame}")))
    }

    /// Reads the planes of a frame; they are filled with `blank` if its file is missing and no frame replaces it.
    fn read<T: Clone>(
        &self,
        kind: StreamKind,
        group: &SourceGroup,
        frame: u32,
        blank: T,
        planes: impl FnOnce(&Path) -> Result<Vec<Plane<T>>>,
    ) -> Result<Vec<Plane<T>>> {
        let Some(path) = self.path(kind, group, frame)? else {
            return Ok(vec![Plane::filled(group.width, group.height, blank); group.faces.len()]);
        };
        planes(&path).map_err(|error| error.in_file(&path).context(format!("frame {frame}")))
    }

    /// The image files of all frames and kinds.
    pub fn files(&self) -> impl Iterator<Item = PathBuf> {
        self.sequences.values().flat_map(FrameFiles::files).chain(self.normals.files())
    }

    /// Returns the file of a frame, or of the frame that replaces it; `None` if the frame is replaced by black.
    pub fn file(&self, group: &SourceGroup, frame: u32) -> Result<Option<PathBuf>> {
        self.path(group.kind, group, frame)
    }

    /// Returns the files that the pixels of a frame are read from: its own file, and for PNG colour the file of the alpha that it
    /// is multiplied by, which may be the same file.
    pub fn files_of(&self, group: &SourceGroup, frame: u32) -> Result<Vec<PathBuf>> {
        let own = self.file(group, frame)?;
        let is_multiplied = group.kind == StreamKind::Color && own.as_deref().is_some_and(png::has_codes);
        let alpha = self.group_beside(group).filter(|alpha| is_multiplied && alpha.frames.contains(frame));
        let beside = match alpha {
            Some(alpha) => self.file(alpha, frame)?,
            None => None,
        };
        Ok(own.into_iter().chain(beside).collect())
    }

    /// Frames of a group whose file is missing, each with the frame that replaces it; `None` for black.
    pub fn missing_frames(&self, group: &SourceGroup) -> Vec<(u32, Option<u32>)> {
        let face = group.faces.first();
        let files = face.and_then(|face| self.sequences.get(&(group.kind, group.probe, *face)));
        files.into_iter().flat_map(FrameFiles::stand_ins).collect()
    }

    fn path(&self, kind: StreamKind, group: &SourceGroup, frame: u32) -> Result<Option<PathBuf>> {
        let found = group.faces.first().and_then(|face| self.sequences.get(&(kind, group.probe, *face)));
        match found {
            Some(files) if group.kind == kind && files.frames().contains(frame) => Ok(files.path(frame)),
            _ => Err(Error::Usage(format!("there is no {} of probe {} at frame {frame}", kind.name(), group.probe))),
        }
    }

    /// Returns the texts substituted for `{probe}` and `{face}`.
    fn names(&self, group: &SourceGroup) -> (&str, &str) {
        let face = group.faces[0];
        let probe = self.probes.get(group.probe).map_or("", |probe| probe.name.as_str());
        (probe, self.manifest.as_ref().map_or(face.name(), |manifest| manifest.face_name(face)))
    }

    fn select(&self, channels: &ChannelSelect, group: &SourceGroup) -> ChannelSelect {
        let (probe, face) = self.names(group);
        channels.of_image(probe, face)
    }

    fn depth_file(&self, path: &Path, group: &SourceGroup) -> Result<DepthPlane> {
        let plane = if png::has_codes(path) {
            if !self.scale_stated {
                return Err(Error::invalid(
                    "this file has integer depth: set metres per unit with `depth_scale` (0.001 for millimetres) or \
                    the manifest's depth.scale",
                ));
            }
            // The scale is applied after background pixels are identified, because the background value is in the unit of the
            // file.
            png::read_depth(path, 1.0, &self.limits)?
        } else {
            exr::read_depth(path, &self.select(&self.depth_channel, group), &self.limits)?
        };
        let Some(size) = self.depth_size(group) else { return self.check_size(&plane, group).map(|()| plane) };
        check_plane(&plane, size.into())?;
        Ok(resized(&plane, self.shape(group).file_size))
    }

    /// Returns the size of depth files, if it is not that of the others. Those of a probe with its own size have that size.
    fn depth_size(&self, group: &SourceGroup) -> Option<[u32; 2]> {
        let manifest = self.manifest.as_ref()?;
        let has_own_size = manifest.probes.get(group.probe).is_some_and(|probe| probe.size.is_some());
        let size = manifest.depth.as_ref()?.size.filter(|_| !has_own_size)?;
        (self.shape(group).file_size != size.into()).then_some(size)
    }

    /// Returns the shape of the files of a group.
    fn shape(&self, group: &SourceGroup) -> &Shape {
        self.shapes.of(group.probe)
    }

    /// Returns the depth rules of the first depth file; for footage without depth, or a file that cannot be opened, those of
    /// floats.
    pub fn depth_rules(&self) -> DepthRules {
        let first = self.groups.iter().find(|group| group.kind == StreamKind::Depth);
        let file = first.and_then(|group| self.file(group, group.frames.first).ok()?);
        file.and_then(|file| self.rules_for(&file).ok()).unwrap_or(self.rules)
    }

    /// Returns the depth rules for the codes of a file.
    fn rules_for(&self, path: &Path) -> Result<DepthRules> {
        let has_codes = self.rules.disparity.is_some() && png::has_codes(path);
        let largest = if has_codes { png::largest_code(path, &self.limits)? } else { 1.0 };
        Ok(DepthRules { largest, ..self.rules })
    }

    fn check_size<T>(&self, plane: &Plane<T>, group: &SourceGroup) -> Result<()> {
        check_plane(plane, self.shape(group).file_size)
    }

    /// Cuts or resamples an image, or one eye's part of it, into the faces of its group.
    fn faces_of<T: Copy>(
        &self,
        plane: Plane<T>,
        group: &SourceGroup,
        resample: fn(&Plane<T>, &FaceMap) -> Result<Plane<T>>,
    ) -> Result<Vec<Plane<T>>> {
        let eye = self.manifest.as_ref().and_then(|manifest| manifest.probes.get(group.probe)?.eye);
        let plane = match (self.stereo, eye) {
            (Some(layout), Some(eye)) => cut_eye(&plane, layout, eye)?,
            _ => plane,
        };
        match self.content {
            Content::Face => Ok(vec![plane]),
            Content::Camera => Ok(group.faces.iter().map(|face| from_camera(&plane, *face)).collect()),
            Content::Faces(layout) => Ok(keep_faces(cut_faces(&plane, layout)?, &group.faces)),
            Content::Equirect => {
                let none = |face: &Face| Error::Usage(format!("an equirectangular image has no face {}", face.name()));
                let maps = &self.shape(group).maps;
                let map = |face: &Face| maps.iter().find(|map| map.face == *face).ok_or_else(|| none(face));
                group.faces.iter().map(|face| resample(&plane, map(face)?)).collect()
            }
        }
    }
}
