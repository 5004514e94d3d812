//! Probes of a container that can be rendered: their streams, poses and memory, without decoding.

use crate::views::{ColorCoding, FaceStreams, LightField, View};
use codec::decode::memory::{self, stream_pixels};
use codec::decode::{Decoder, StreamInfo};
use codec::depth::DepthRange;
use codec::error::{Error, Result};
use codec::image::StreamKind;
use codec::streams::{CodecHeader, ColorFormat, ColorHeader};

/// Selection of the probes of a container to load, and of their streams; by default all.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct ProbeChoice {
    /// Names of the only probes to load; all probes if empty.
    pub only: Vec<String>,
    /// Names of probes to leave out.
    pub without: Vec<String>,
    /// True if materials are neither decoded nor kept.
    pub no_materials: bool,
}

impl ProbeChoice {
    pub fn takes(&self, name: &str) -> bool {
        let named = |names: &[String]| names.iter().any(|other| other == name);
        !named(&self.without) && (self.only.is_empty() || named(&self.only))
    }

    fn check(&self, decoder: &Decoder) -> Result<()> {
        let probes = &decoder.reader().index().probes;
        match self.only.iter().chain(&self.without).find(|name| probes.iter().all(|probe| probe.name != **name)) {
            None => Ok(()),
            Some(name) => {
                let names: Vec<&str> = probes.iter().take(20).map(|probe| probe.name.as_str()).collect();
                let more = if probes.len() > names.len() { ", ..." } else { "" };
                Err(Error::Usage(format!(
                    "{}: there is no probe '{name}'; its probes are {}{more}",
                    decoder.reader().path().display(),
                    names.join(", ")
                )))
            }
        }
    }
}

#[derive(Debug, Default)]
pub struct ViewStreams<'a> {
    /// Faces of the view with both depth and colour.
    pub faces: Vec<FaceStreams<'a>>,
    /// Maximum bytes of the view when loaded.
    pub bytes: u64,
    /// Maximum bytes of the view when loaded, if decoders keep only pixels from frame to frame.
    pub pixel_bytes: u64,
    /// Maximum bytes of one unit while it is decoded.
    pub unit_bytes: u64,
}

/// Probes that have a face with both depth and colour.
#[derive(Debug)]
pub struct Catalogue<'a> {
    pub field: LightField,
    pub streams: Vec<ViewStreams<'a>>,
}

impl<'a> Catalogue<'a> {
    pub fn new(decoder: &'a Decoder, probes: &ProbeChoice) -> Result<Catalogue<'a>> {
        probes.check(decoder)?;
        let all = decoder.streams();
        let same_face = |like: &StreamInfo, kind| {
            all.iter().find(|other| other.probe == like.probe && other.face == like.face && other.kind == kind)
        };
        let (mut views, mut streams, mut coding) = (Vec::<View>::new(), Vec::<ViewStreams<'_>>::new(), None);
        for depth in all.iter().filter(|stream| stream.kind == StreamKind::Depth) {
            let entry = decoder.probe(depth);
            let chosen = probes.takes(&entry.name);
            let Some(color) = same_face(depth, StreamKind::Color).filter(|_| chosen) else { continue };
            let CodecHeader::Depth(header) = &depth.header else { continue };
            let coded = coding_of(color);
            if *coding.get_or_insert(coded) != coded {
                return Err(Error::unsupported(
                    "the colour streams of the light field have different encodings: encode them with the same \
                    settings",
                ));
            }
            let face = FaceStreams {
                depth,
                header: header.clone(),
                color,
                alpha: same_face(depth, StreamKind::Alpha),
                material: same_face(depth, StreamKind::Material).filter(|_| !probes.no_materials),
            };
            check_sizes(&entry.name, &face)?;
            let at = match views.iter().position(|view| view.probe == depth.probe) {
                Some(at) => at,
                None => {
                    let Some(range) = range_of(all, depth.probe) else { continue };
                    views.push(View::new(depth.probe, entry, range)?);
                    streams.push(ViewStreams::default());
                    views.len() - 1
                }
            };
            let texels = texel_bytes(&face, coded);
            streams[at].bytes += texels.saturating_add(decoder_bytes(decoder, &face));
            streams[at].pixel_bytes += texels.saturating_add(face.all().map(picture_bytes).sum());
            streams[at].unit_bytes = streams[at].unit_bytes.max(unit_bytes(decoder, &face));
            streams[at].faces.push(face);
        }
        let coding = coding.ok_or_else(|| {
            Error::Usage("no probe of this container has both colour and depth, which rendering needs".into())
        })?;
        Ok(Catalogue { field: LightField { views, coding }, streams })
    }
}

fn range_of(streams: &[StreamInfo], probe: usize) -> Option<DepthRange> {
    let ranges = streams.iter().filter(|stream| stream.probe == probe).filter_map(|stream| match &stream.header {
        CodecHeader::Depth(header) => Some([header.range.near_m(), header.range.far_m()]),
        _ => None,
    });
    let [near, far] = ranges.reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])])?;
    DepthRange::new(near, far).ok()
}

fn coding_of(color: &StreamInfo) -> ColorCoding {
    match &color.header {
        CodecHeader::Color(ColorHeader { format: ColorFormat::EightBit(tone), .. }) => ColorCoding::Codes(*tone),
        _ => ColorCoding::Light,
    }
}

fn check_sizes(probe: &str, streams: &FaceStreams<'_>) -> Result<()> {
    let size = |stream: &StreamInfo| [stream.entry.width, stream.entry.height];
    let depth = size(streams.depth);
    match streams.all().find(|stream| size(stream) != depth) {
        None => Ok(()),
        Some(other) => Err(Error::unsupported(format!(
            "probe {probe}, face {}: {} has {}x{} pixels and depth {}x{}: rendering needs images of the same size",
            other.face.name(),
            other.kind.name(),
            other.entry.width,
            other.entry.height,
            depth[0],
            depth[1]
        ))),
    }
}

/// Returns the bytes of the texels of a face.
fn texel_bytes(streams: &FaceStreams<'_>, coding: ColorCoding) -> u64 {
    let color = match coding {
        ColorCoding::Codes(_) => 4,
        ColorCoding::Light => 8,
    };
    // A pyramid has one value per texel, plus levels with a third as many values, slightly more if sides are odd.
    let pyramid = 4 + 2;
    stream_pixels(streams.depth) * (4 + pyramid + color + if streams.material.is_some() { 4 } else { 0 })
}

/// Returns the maximum bytes of the decoders of a face, including their pixels.
fn decoder_bytes(decoder: &Decoder, streams: &FaceStreams<'_>) -> u64 {
    let index = decoder.reader().index();
    streams.all().map(|stream| stream.memory_bytes(index)).fold(0, u64::saturating_add)
}

/// Returns the bytes of the pixels of a stream's units.
fn picture_bytes(stream: &StreamInfo) -> u64 {
    let pixel = match &stream.header {
        CodecHeader::Depth(_) | CodecHeader::Alpha(_) => 2,
        CodecHeader::Color(header) if header.is_half() => 6,
        CodecHeader::Color(_) | CodecHeader::Material(_) => 3,
    };
    stream_pixels(stream) * pixel + u64::from(stream.entry.unit_count()) * CodecHeader::HELD_UNIT_BYTES
}

/// Returns the maximum bytes of a unit of a face while it is decoded.
fn unit_bytes(decoder: &Decoder, streams: &FaceStreams<'_>) -> u64 {
    let of_stream = |stream: &StreamInfo| {
        (0..stream.entry.unit_count()).map(|unit| memory::unit_bytes(decoder, stream, unit)).max().unwrap_or(0)
    };
    streams.all().map(of_stream).max().unwrap_or(0)
}
