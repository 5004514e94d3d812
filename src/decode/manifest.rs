//! The manifest of a decoded dataset.

use std::path::Path;

use serde_json::json;

use crate::dataset::manifest::{self, Manifest};
use crate::decode::decoder::Decoder;
use crate::decode::selection::StreamFrames;
use crate::image::sequence::FrameRange;
use crate::image::transfer::ToneMap;
use crate::image::{ColorSpace, Face, Primaries};
use crate::streams::{CodecHeader, ColorFormat, FramePose, Projection, StreamKind};

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum FileFormat {
    /// OpenEXR: linear light, metres, weights.
    #[default]
    Exr,
    /// PNG: 8-bit colour codes, 16-bit depth codes, 8-bit weights.
    Png,
}

impl FileFormat {
    /// The format that a file name's extension tells.
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

/// How images become files.
#[derive(Debug, Clone, Copy, Default)]
pub struct FileCoding {
    pub format: FileFormat,
    /// Space of linear light in EXR files; `None` keeps the container's. PNG files have the primaries of Rec. 709.
    pub space: Option<ColorSpace>,
}

impl FileCoding {
    /// Primaries of files, of a container with its `own`.
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

/// Whether a dataset was decoded from a container.
pub fn has_decoded(manifest: &Manifest) -> bool {
    manifest.extra.as_ref().is_some_and(|extra| extra.get("lightfold").is_some())
}

/// Its `extra` holds the streams' coding, so that a later comparison can use the same codes. An error says why there is
/// none: PNG files hold codes that a manifest cannot describe, streams differ in size, or cube faces are not square.
pub(super) fn manifest_of(
    decoder: &Decoder,
    streams: &[StreamFrames<'_>],
    files_coding: FileCoding,
) -> Result<Manifest, &'static str> {
    const NO_STREAM: &str = "no stream was decoded";
    let format = files_coding.format;
    let index = decoder.reader().index();
    let size = streams.first().ok_or(NO_STREAM)?.stream.size();
    let cube = index.projection == 0;
    if streams.iter().any(|part| part.stream.size() != size) {
        return Err("the streams differ in size");
    }
    if cube && size[0] != size[1] {
        return Err("the cube faces are not square");
    }
    let mut files = manifest::Files::default();
    let (mut depth, mut color, mut material) = (None, None, None);
    let mut coding = serde_json::Map::new();
    let mut ranges = serde_json::Map::new();
    for part in streams {
        let stream = part.stream;
        let pattern = Some(file_pattern(decoder, stream.kind, format));
        match (&stream.header, format) {
            (CodecHeader::Depth(header), _) => {
                let (near, far) = (header.range.near_m(), header.range.far_m());
                let name = format!("{}/{}", decoder.probe(stream).name, stream.face.name());
                ranges.insert(name, json!({ "near_m": near, "far_m": far }));
                if format == FileFormat::Exr {
                    files.depth = pattern;
                    let background = match header.background {
                        f32::INFINITY => manifest::Background::default(),
                        value => manifest::Background::Value(f64::from(value)),
                    };
                    depth = Some(manifest::DepthInfo { kind: header.kind, background, ..Default::default() });
                }
            }
            (CodecHeader::Color(header), _) => {
                // PNG files of half floats hold sRGB codes as well.
                let srgb = match header.format {
                    ColorFormat::EightBit(tone) => tone == ToneMap::default(),
                    ColorFormat::Half { .. } => true,
                };
                coding.insert("color".into(), color_coding(&header.format, stream.entry.unit_width));
                let space = match format {
                    // Where it has no name, the files' chromaticities tell.
                    FileFormat::Exr => ColorSpace::of_light(files_coding.primaries(decoder.primaries())),
                    FileFormat::Png if srgb => Some(ColorSpace::Srgb),
                    FileFormat::Png => continue,
                };
                files.color = pattern;
                color = space.map(|space| manifest::ColorInfo { space: Some(space), layer: None });
            }
            (CodecHeader::Material(_), FileFormat::Exr) => {
                files.material = pattern;
                material = Some(manifest::MaterialInfo { channels: manifest::MaterialChannels::default() });
            }
            (CodecHeader::Material(_), FileFormat::Png) => {}
            (CodecHeader::Alpha(_), _) => {
                let is_beside = streams.iter().any(|color| color.has_alpha(part));
                let kind = if is_beside { StreamKind::Color } else { StreamKind::Alpha };
                let own = file_pattern(decoder, kind, format);
                if files.alpha.replace(own.clone()).is_some_and(|other| other != own) {
                    return Err("alpha of some faces has no colour of the same frames");
                }
            }
        }
    }
    if files == manifest::Files::default() {
        return Err(
            "a manifest cannot describe what these PNG files hold: depth codes, weights, or colour with another \
                    transfer function or exposure than sRGB",
        );
    }
    if !ranges.is_empty() {
        coding.insert("depth".into(), ranges.into());
    }
    let all = streams.iter().map(|part| part.frames).reduce(FrameRange::hull).ok_or(NO_STREAM)?;
    let present: Vec<Face> =
        Face::CUBE.into_iter().filter(|face| streams.iter().any(|part| part.stream.face == *face)).collect();
    let mut probes = Vec::new();
    let mut frames_of: Vec<Option<FrameRange>> = vec![None; index.probes.len()];
    for &StreamFrames { stream, frames } in streams {
        let known = &mut frames_of[stream.probe];
        *known = Some(known.map_or(frames, |known| known.hull(frames)));
    }
    for (probe, frames) in index.probes.iter().zip(frames_of) {
        let Some(frames) = frames else { continue };
        let known = probe.intrinsics.iter().any(|&value| value != 0.0);
        let poses =
            decoder.footage().poses.iter().filter(|pose| pose.probe == probe.name && frames.contains(pose.frame));
        let poses: Vec<manifest::Pose> = poses
            .map(|&FramePose { frame, position, orientation, .. }| manifest::Pose { frame, position, orientation })
            .collect();
        let stands = poses.is_empty();
        let is_turned = probe.orientation != [0.0, 0.0, 0.0, 1.0];
        probes.push(manifest::Probe {
            name: probe.name.clone(),
            position: stands.then_some(probe.position),
            frames: (frames != all).then_some([frames.first, frames.last]),
            orientation: (stands && is_turned).then_some(probe.orientation),
            poses,
            intrinsics: known.then_some(probe.intrinsics),
            ..manifest::Probe::default()
        });
    }
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
        probes,
        extra: Some(json!({ "lightfold": coding })),
    })
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
