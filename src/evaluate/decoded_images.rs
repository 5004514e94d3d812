//! Decoded images of a container, in metres and linear RGB.

use codec::container::ProbeEntry;
use codec::decode::{Decoder, Picture};
use codec::depth::CodeTable;
use codec::error::{Error, Result};
use codec::image::{ColorPlane, DecodeTable, DepthKind, DepthPlane, FrameRange, MaterialPlane, Primaries};
use codec::streams::convert::{color_light, material_values};
use codec::streams::{CodecHeader, ColorFormat, FootageInfo, FramePose, StreamInfo};
use footage::dataset::{Pose, ProbeInfo, planar_to_distance};

#[derive(Debug)]
pub struct DecodedImages {
    decoder: Decoder,
    pub probes: Vec<ProbeInfo>,
}

fn probe_info(entry: &ProbeEntry, footage: &FootageInfo) -> ProbeInfo {
    let poses = footage.poses_of(&entry.name).iter().map(pose).collect();
    ProbeInfo { poses, ..still_probe(entry) }
}

pub(super) fn pose(&FramePose { frame, position, orientation, .. }: &FramePose) -> Pose {
    Pose { frame, position, orientation }
}

/// Returns a probe without its per-frame poses.
pub(super) fn still_probe(entry: &ProbeEntry) -> ProbeInfo {
    ProbeInfo {
        name: entry.name.clone(),
        position: entry.position,
        orientation: entry.orientation,
        poses: Vec::new(),
        frames: FrameRange { first: entry.frames[0], last: entry.frames[1] },
        intrinsics: (entry.intrinsics != [0.0; 4]).then_some(entry.intrinsics),
    }
}

impl DecodedImages {
    pub fn new(decoder: Decoder) -> DecodedImages {
        let probes = decoder.reader().index().probes.iter().map(|entry| probe_info(entry, decoder.footage())).collect();
        DecodedImages { decoder, probes }
    }

    pub fn streams(&self) -> &[StreamInfo] {
        self.decoder.streams()
    }

    pub fn primaries(&self) -> Primaries {
        self.decoder.primaries()
    }

    /// Decodes colour to linear RGB in [`Self::primaries`].
    pub fn color(&self, stream: usize, frame: u32) -> Result<Vec<ColorPlane>> {
        let header = &self.streams()[stream].header;
        match (self.decoder.face(&self.streams()[stream]).decode(frame)?, header) {
            (Picture::ColorHalf(light), _) => Ok(vec![light]),
            (Picture::Color8(codes), CodecHeader::Color(color)) => match color.format {
                ColorFormat::EightBit(tone) => Ok(vec![color_light(&codes, &DecodeTable::new(&tone))]),
                ColorFormat::Half { .. } => Err(wrong_kind()),
            },
            _ => Err(wrong_kind()),
        }
    }

    /// Decodes depth to distances in metres; `+inf` for the background.
    pub fn distance_m(&self, stream: usize, frame: u32) -> Result<Vec<DepthPlane>> {
        let stream = &self.streams()[stream];
        let (Picture::Depth(codes), CodecHeader::Depth(header)) =
            (self.decoder.face(stream).decode(frame)?, &stream.header)
        else {
            return Err(wrong_kind());
        };
        let table = CodeTable::new(header.range, f32::INFINITY);
        let mut metres = codes.map(|&code| table.metres(code));
        if header.kind == DepthKind::Planar {
            let probe = &self.probes[stream.probe];
            let projection = probe.projection(stream.face, stream.size()).ok_or_else(|| {
                let message = format!("probe {}: its planar depth needs \"intrinsics\" to become distance", probe.name);
                Error::invalid(message)
            })?;
            planar_to_distance(&mut metres, &projection);
        }
        Ok(vec![metres])
    }

    pub fn material(&self, stream: usize, frame: u32) -> Result<Vec<MaterialPlane>> {
        match self.decoder.face(&self.streams()[stream]).decode(frame)? {
            Picture::Material(codes) => Ok(vec![material_values(&codes)]),
            _ => Err(wrong_kind()),
        }
    }

    /// Returns the maximum relative depth error over all depth streams, from the error bounds of their codecs and the
    /// rounding of codes; `None` if a codec has no bound.
    pub fn relative_depth_error(&self) -> Option<f64> {
        let error = |stream: &StreamInfo| {
            let (range, codes) = (stream.depth_range()?, stream.error_bound_codes()?);
            Some(range.relative_error(codes))
        };
        let with_depth = self.streams().iter().filter(|stream| stream.depth_range().is_some());
        with_depth.map(error).try_fold(0.0, |most: f64, error| Some(most.max(error?)))
    }
}

fn wrong_kind() -> Error {
    Error::invalid("a stream decodes to another kind of image than its header states")
}
