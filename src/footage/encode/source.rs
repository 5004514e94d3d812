//! Sources of frames to encode: the files of a dataset, or memory.

use std::path::PathBuf;

use crate::dataset::{ProbeInfo, Source, SourceGroup};
use crate::encode::EncodeSettings;
use crate::encode::scan::Scans;
use codec::container::Attributes;
use codec::error::Result;
use codec::image::{
    AlphaPlane, ColorPlane, DepthKind, DepthPlane, Face, MaterialPlane, Primaries, Projection, StreamKind,
};
use codec::streams::{MissingFrame, StartView};

/// Source of frames: probes, groups of streams that are read together, and their pixels. Frames are read in parallel.
pub trait FrameSource: Sync {
    fn name(&self) -> &str;

    /// Frames per second, above 0.
    fn fps(&self) -> f64;

    fn projection(&self) -> Projection;

    fn probes(&self) -> &[ProbeInfo];

    fn groups(&self) -> &[SourceGroup];

    /// Value that marks the background in the source files, in their unit; +inf always does.
    fn background(&self) -> f32 {
        f32::INFINITY
    }

    /// Quantity that [`Self::read_depth`] returns: distance or planar depth.
    fn depth_kind(&self) -> DepthKind {
        DepthKind::Distance
    }

    /// Near and far in metres, if the source states them.
    fn stated_range(&self) -> [Option<f32>; 2] {
        [None; 2]
    }

    /// Upper bound in bytes of the memory for reading a frame of a group, including the planes that are returned.
    fn reading_bytes(&self, group: &SourceGroup) -> u64 {
        let value = match group.kind {
            StreamKind::Depth | StreamKind::Alpha => 4,
            StreamKind::Color => 6,
            StreamKind::Material => 12,
        };
        u64::from(group.width) * u64::from(group.height) * group.faces.len() as u64 * value
    }

    /// Size in bytes of the tables needed to read frames of these groups, in addition to [`Self::reading_bytes`]. They are built
    /// once and kept.
    fn table_bytes(&self, _groups: &[&SourceGroup]) -> u64 {
        0
    }

    /// Reads the depth of a frame in metres, one plane per face: +inf for the background, 0 for an invalid depth that becomes
    /// near.
    ///
    /// # Errors
    /// Fails if a file cannot be read or has invalid values; the error names the file.
    fn read_depth(&self, group: &SourceGroup, frame: u32) -> Result<Vec<DepthPlane>>;

    /// Primaries of the colour that [`Self::read_color`] returns.
    fn primaries(&self) -> Primaries {
        Primaries::REC709
    }

    /// Camera with which players open the film, if the source states one.
    fn view(&self) -> Option<StartView> {
        None
    }

    /// Frames of a group whose file is missing, each with the frame that replaces it; `None` for black and background.
    fn missing_frames(&self, _group: &SourceGroup) -> Vec<(u32, Option<u32>)> {
        Vec::new()
    }

    /// Reads the linear colour of a frame in [`Self::primaries`], one plane per face.
    ///
    /// # Errors
    /// As for [`Self::read_depth`].
    fn read_color(&self, group: &SourceGroup, frame: u32) -> Result<Vec<ColorPlane>>;

    /// Reads reflection weight, refraction weight and index of refraction of a frame, one plane per face.
    ///
    /// # Errors
    /// As for [`Self::read_depth`].
    fn read_material(&self, group: &SourceGroup, frame: u32) -> Result<Vec<MaterialPlane>>;

    /// Reads the alpha of a frame, 0 to 1, one plane per face.
    ///
    /// # Errors
    /// As for [`Self::read_depth`].
    fn read_alpha(&self, group: &SourceGroup, frame: u32) -> Result<Vec<AlphaPlane>>;

    /// Files that the pixels of a frame, or of the frame that replaces it, are read from: its own file, and for colour in a PNG
    /// file the file of its alpha. Empty for frames in memory and for black frames.
    ///
    /// # Errors
    /// Fails if the group has no such frame.
    fn files(&self, _group: &SourceGroup, _frame: u32) -> Result<Vec<PathBuf>> {
        Ok(Vec::new())
    }

    /// Digest of all data that the pixels of a frame depend on, if the source has one. Shards of an encode can only be joined if
    /// the digests of all frames are equal. If `None`, the digest is computed from the bytes of [`Self::files`], or from the
    /// pixels if there are no files.
    ///
    /// # Errors
    /// As for [`Self::files`].
    fn digest(&self, _group: &SourceGroup, _frame: u32) -> Result<Option<[u8; 16]>> {
        Ok(None)
    }

    /// Scans of the depth images from an earlier run; `None` if the encoder has to scan.
    fn scans(&self) -> Option<&Scans> {
        None
    }

    /// Attributes of the container (container.md 6.3).
    fn attributes(&self) -> Attributes {
        Attributes::default()
    }

    /// Names and values of the settings that pixels depend on. An interrupted encode can only be resumed if they are equal.
    fn configuration(&self) -> Vec<(&'static str, String)> {
        Vec::new()
    }
}

impl FrameSource for Source {
    fn name(&self) -> &str {
        self.name()
    }

    fn fps(&self) -> f64 {
        self.fps()
    }

    fn projection(&self) -> Projection {
        self.projection()
    }

    fn probes(&self) -> &[ProbeInfo] {
        self.probes()
    }

    fn groups(&self) -> &[SourceGroup] {
        self.groups()
    }

    fn background(&self) -> f32 {
        self.rules.background
    }

    fn depth_kind(&self) -> DepthKind {
        self.depth_stored
    }

    fn stated_range(&self) -> [Option<f32>; 2] {
        let depth = self.manifest.as_ref().and_then(|manifest| manifest.depth.as_ref());
        depth.map_or([None; 2], |depth| depth.stated_range().map(|bound| bound.map(|metres| metres as f32)))
    }

    fn reading_bytes(&self, group: &SourceGroup) -> u64 {
        self.reading_bytes(group)
    }

    fn table_bytes(&self, groups: &[&SourceGroup]) -> u64 {
        self.table_bytes(groups)
    }

    fn primaries(&self) -> Primaries {
        self.primaries()
    }

    fn view(&self) -> Option<StartView> {
        self.manifest.as_ref().and_then(|manifest| manifest.view)
    }

    fn missing_frames(&self, group: &SourceGroup) -> Vec<(u32, Option<u32>)> {
        self.missing_frames(group)
    }

    fn read_depth(&self, group: &SourceGroup, frame: u32) -> Result<Vec<DepthPlane>> {
        self.read_depth(group, frame)
    }

    fn read_color(&self, group: &SourceGroup, frame: u32) -> Result<Vec<ColorPlane>> {
        self.read_color(group, frame)
    }

    fn read_material(&self, group: &SourceGroup, frame: u32) -> Result<Vec<MaterialPlane>> {
        self.read_material(group, frame)
    }

    fn read_alpha(&self, group: &SourceGroup, frame: u32) -> Result<Vec<AlphaPlane>> {
        self.read_alpha(group, frame)
    }

    fn files(&self, group: &SourceGroup, frame: u32) -> Result<Vec<PathBuf>> {
        self.files_of(group, frame)
    }

    fn configuration(&self) -> Vec<(&'static str, String)> {
        self.reading_rules()
    }
}

/// Groups whose kind the settings select.
pub fn selected_groups<'a>(source: &'a dyn FrameSource, settings: &EncodeSettings) -> Vec<&'a SourceGroup> {
    source.groups().iter().filter(|group| settings.kinds.contains(&group.kind)).collect()
}

/// Missing frames of a group, in the form that a container stores.
pub(super) fn missing_frames(source: &dyn FrameSource, group: &SourceGroup) -> Vec<MissingFrame> {
    let probe = &source.probes()[group.probe].name;
    let of_frame = |(frame, held)| {
        let of_face = move |&face: &Face| MissingFrame { probe: probe.clone(), kind: group.kind, face, frame, held };
        group.faces.iter().map(of_face)
    };
    source.missing_frames(group).into_iter().flat_map(of_frame).collect()
}

pub(super) fn name_frame(source: &dyn FrameSource, group: &SourceGroup, frame: u32) -> String {
    let probe = &source.probes()[group.probe].name;
    let faces: Vec<_> = group.faces.iter().map(|face| face.name()).collect();
    format!("{} of probe {probe}, face {}, frame {frame}", group.kind.name(), faces.join("/"))
}
