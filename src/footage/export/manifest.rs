//! Builds the manifest of a decoded dataset.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use serde_json::json;

use crate::dataset::manifest::{self, Manifest};
use crate::image_files::ColorSpace;
use codec::decode::{Decoder, StreamFrames};
use codec::image::sequence::FrameRange;
use codec::image::transfer::ToneMap;
use codec::image::{Face, Primaries};
use codec::streams::{CodecHeader, ColorFormat, ColorHeader, FramePose, Projection, StreamKind};

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum FileFormat {
    /// OpenEXR: linear RGB, metres, weights.
    #[default]
    Exr,
    /// PNG: 8-bit colour codes, 16-bit depth codes, 8-bit weights.
    Png,
}

impl FileFormat {
    /// Returns the format for a file name's extension, `exr` or `png`.
    pub fn of(path: &Path) -> Option<FileFormat> {
        let extension = path.extension()?;
        [FileFormat::Exr, FileFormat::Png].into_iter().find(|format| extension == format.extension())
    }

    fn extension(self) -> &'static str {
        match self {
            FileFormat::Exr => "exr",
            FileFormat::Png => "png",
        }
    }
}

/// Format and colour space of image files.
#[derive(Debug, Clone, Copy, Default)]
pub struct FileCoding {
    pub format: FileFormat,
    /// Colour space of linear RGB in EXR files; `None` keeps that of the container. PNG files always have the primaries of Rec.
    /// 709.
    pub space: Option<ColorSpace>,
}

impl FileCoding {
    /// Returns the primaries of the files; `own` are those of the container.
    pub(super) fn primaries(self, own: Primaries) -> Primaries {
        match (self.format, self.space) {
            (FileFormat::Png, _) => Primaries::REC709,
            (FileFormat::Exr, space) => space.map_or(own, ColorSpace::primaries),
        }
    }
}

pub(super) fn file_pattern(decoder: &Decoder, kind: StreamKind, format: FileFormat) -> String {
    let face = if decoder.reader().index().projection == 0 { "/face_{face}" } else { "" };
    format!("probe_{{probe}}{face}/{}.%04d.{}", kind.name(), format.extension())
}

/// Returns true if a dataset was decoded from a container.
pub fn has_decoded(manifest: &Manifest) -> bool {
    manifest.extra.as_ref().is_some_and(|extra| extra.get("lightfold").is_some())
}

/// Builds the manifest of decoded files. Its `extra` contains the coding of the streams, so that a later comparison can use the
/// same codes. Fails with the reason if there can be no manifest: PNG files hold codes that a manifest cannot describe, streams
/// of a probe differ in size, cube faces are not square, or some faces have kinds or frames that others do not.
pub(super) fn manifest_of(
    decoder: &Decoder,
    streams: &[StreamFrames<'_>],
    files_coding: FileCoding,
) -> Result<Manifest, &'static str> {
    let format = files_coding.format;
    let index = decoder.reader().index();
    let size = streams.first().ok_or("no stream was decoded")?.stream.size();
    let cube = index.projection == 0;
    let mut sizes = BTreeMap::new();
    if streams.iter().any(|part| *sizes.entry(part.stream.probe).or_insert(part.stream.size()) != part.stream.size()) {
        return Err("the streams of a probe differ in size");
    }
    if cube && sizes.values().any(|[width, height]| width != height) {
        return Err("the cube faces are not square");
    }
    let listed = listed(streams, format);
    let Some(all) = listed.iter().map(|part| part.frames).reduce(FrameRange::hull) else {
        return Err(
            "a manifest cannot describe the content of these PNG files: depth codes, weights, or colour with a \
            transfer function or exposure other than sRGB",
        );
    };
    if !is_complete(&listed) {
        return Err("some faces have kinds or frames that others do not");
    }
    let mut files = manifest::Files::default();
    let (mut depth, mut color, mut material) = (None, None, None);
    let has_color = listed.iter().any(|part| part.stream.kind == StreamKind::Color);
    for stream in listed.iter().map(|part| part.stream) {
        let pattern = Some(file_pattern(decoder, stream.kind, format));
        match &stream.header {
            CodecHeader::Depth(header) => {
                files.depth = pattern;
                let background = match header.background {
                    f32::INFINITY => manifest::Background::default(),
                    value => manifest::Background::Value(f64::from(value)),
                };
                depth = Some(manifest::DepthInfo { kind: header.kind.into(), background, ..Default::default() });
            }
            CodecHeader::Color(_) => {
                let space = match format {
                    // Primaries without a name are read from the chromaticities in the files.
                    FileFormat::Exr => ColorSpace::of_light(files_coding.primaries(decoder.primaries())),
                    FileFormat::Png => Some(ColorSpace::Srgb),
                };
                files.color = pattern;
                color = space.map(|space| manifest::ColorInfo { space: Some(space), ..Default::default() });
            }
            CodecHeader::Material(_) => {
                files.material = pattern;
                material = Some(manifest::MaterialInfo { channels: manifest::MaterialChannels::default() });
            }
            CodecHeader::Alpha(_) if has_color => {
                files.alpha = Some(file_pattern(decoder, StreamKind::Color, format));
            }
            CodecHeader::Alpha(_) => files.alpha = pattern,
        }
    }
    let present: Vec<Face> =
        Face::CUBE.into_iter().filter(|face| listed.iter().any(|part| part.stream.face == *face)).collect();
    Ok(Manifest {
        schema: None,
        lightfield: manifest::MANIFEST_VERSION,
        name: if index.name.is_empty() { "unnamed".to_owned() } else { index.name.clone() },
        fps: index.fps,
        frames: [all.first, all.last],
        projection: if cube { Projection::Cubemap } else { Projection::Perspective },
        size,
        faces: cube.then_some(manifest::FaceFiles::Six),
        face_names: None,
        stereo: None,
        faces_present: (cube && present.len() < 6).then(|| present.iter().map(|face| face.name().to_owned()).collect()),
        depth,
        color,
        material,
        alpha: None,
        missing: None,
        files,
        probes: probes_of(decoder, &listed, (all, size)),
        view: decoder.footage().view,
        extra: Some(json!({ "lightfold": coding_of(decoder, streams) })),
    })
}

/// Returns the streams whose files a manifest can describe. In PNG files these are colour in sRGB codes, as which half-float
/// colour is also written, and its alpha.
fn listed<'a>(streams: &[StreamFrames<'a>], format: FileFormat) -> Vec<StreamFrames<'a>> {
    let is_other = |header: &CodecHeader| match header {
        CodecHeader::Color(ColorHeader { format: ColorFormat::EightBit(tone), .. }) => *tone != ToneMap::default(),
        _ => false,
    };
    let has_other_color = streams.iter().any(|part| is_other(&part.stream.header));
    let is_listed = |part: &&StreamFrames<'_>| match (format, part.stream.kind) {
        (FileFormat::Exr, _) => true,
        (FileFormat::Png, StreamKind::Color | StreamKind::Alpha) => !has_other_color,
        (FileFormat::Png, StreamKind::Depth | StreamKind::Material) => false,
    };
    streams.iter().filter(is_listed).copied().collect()
}

/// Returns true if all faces of all probes have the same kinds, and all streams of a probe the same frames, as a manifest
/// requires.
fn is_complete(listed: &[StreamFrames<'_>]) -> bool {
    let kinds: BTreeSet<_> = listed.iter().map(|part| part.stream.kind).collect();
    let faces: BTreeSet<_> = listed.iter().map(|part| part.stream.face).collect();
    let mut of_probes: BTreeMap<usize, (FrameRange, BTreeSet<_>)> = BTreeMap::new();
    for &StreamFrames { stream, frames } in listed {
        let (of_probe, places) = of_probes.entry(stream.probe).or_insert((frames, BTreeSet::new()));
        if *of_probe != frames {
            return false;
        }
        places.insert((stream.kind, stream.face));
    }
    of_probes.values().all(|(_, places)| places.len() == kinds.len() * faces.len())
}

/// Returns the probes of the streams. A probe states its frames and its size only if they differ from those of `all`.
fn probes_of(
    decoder: &Decoder,
    listed: &[StreamFrames<'_>],
    (all, usual): (FrameRange, [u32; 2]),
) -> Vec<manifest::Probe> {
    let of_probes: BTreeMap<usize, (FrameRange, [u32; 2])> =
        listed.iter().map(|part| (part.stream.probe, (part.frames, part.stream.size()))).collect();
    let probe_of = |(at, (frames, size)): (usize, (FrameRange, [u32; 2]))| {
        let probe = &decoder.reader().index().probes[at];
        let known = probe.intrinsics.iter().any(|&value| value != 0.0);
        let poses = decoder.footage().poses_of(&probe.name).iter().filter(|pose| frames.contains(pose.frame));
        let poses: Vec<manifest::Pose> = poses
            .map(|&FramePose { frame, position, orientation, .. }| manifest::Pose { frame, position, orientation })
            .collect();
        let stands = poses.is_empty();
        let is_turned = probe.orientation != [0.0, 0.0, 0.0, 1.0];
        manifest::Probe {
            name: probe.name.clone(),
            position: stands.then_some(probe.position),
            frames: (frames != all).then_some([frames.first, frames.last]),
            size: (size != usual).then_some(size),
            orientation: (stands && is_turned).then_some(probe.orientation),
            poses,
            intrinsics: known.then_some(probe.intrinsics),
            ..manifest::Probe::default()
        }
    };
    of_probes.into_iter().map(probe_of).collect()
}

/// Returns the colour format, and near and far of each depth stream.
fn coding_of(decoder: &Decoder, streams: &[StreamFrames<'_>]) -> serde_json::Map<String, serde_json::Value> {
    let mut coding = serde_json::Map::new();
    let mut ranges = serde_json::Map::new();
    for stream in streams.iter().map(|part| part.stream) {
        match &stream.header {
            CodecHeader::Depth(header) => {
                let (near, far) = (header.range.near_m(), header.range.far_m());
                let name = format!("{}/{}", decoder.probe(stream).name, stream.face.name());
                ranges.insert(name, json!({ "near_m": near, "far_m": far }));
            }
            CodecHeader::Color(header) => {
                coding.insert("color".into(), color_coding(&header.format, stream.entry.unit_width));
            }
            CodecHeader::Material(_) | CodecHeader::Alpha(_) => {}
        }
    }
    if !ranges.is_empty() {
        coding.insert("depth".into(), ranges.into());
    }
    coding
}

fn color_coding(format: &ColorFormat, cell: u32) -> serde_json::Value {
    match format {
        ColorFormat::EightBit(tone) => json!({
            "format": "8bit",
            "transfer": tone.transfer.name(),
            "exposure_ev": tone.exposure_ev,
            "cell": cell,
        }),
        ColorFormat::Half { white_cd_m2 } => json!({ "format": "half", "white_cd_m2": white_cd_m2, "cell": cell }),
    }
}
