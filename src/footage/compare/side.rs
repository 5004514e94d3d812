//! One side of a comparison: a container, a dataset or an image sequence, as named streams and their images.

use std::fmt;

use serde::ser::SerializeStruct;
use serde::{Serialize, Serializer};

use crate::dataset::{InvalidDepth, Source};
use codec::decode::{Decoder, FaceDecoder, Picture, memory};
use codec::depth::DepthRange;
use codec::error::{Error, Result};
use codec::image::{
    AlphaPlane, ColorPlane, DepthKind, DepthPlane, Face, FrameRange, MaterialPlane, Primaries, StreamKind,
};
use codec::streams::ColorFormat;

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct StreamId {
    pub kind: StreamKind,
    pub probe: String,
    pub face: Face,
}

impl Serialize for StreamId {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut fields = serializer.serialize_struct("StreamId", 4)?;
        fields.serialize_field("stream", &self.to_string())?;
        fields.serialize_field("kind", self.kind.name())?;
        fields.serialize_field("probe", &self.probe)?;
        fields.serialize_field("face", self.face.name())?;
        fields.end()
    }
}

impl fmt::Display for StreamId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {}/{}", self.kind.name(), self.probe, self.face.name())
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Coding {
    Depth(DepthRange),
    /// 8-bit or half-float colour, and the cell side in pixels.
    Color(ColorFormat, u32),
    /// 8-bit codes of material and alpha.
    Bytes,
}

#[derive(Debug, Clone, PartialEq)]
pub struct SideStream {
    pub id: StreamId,
    pub probe_order: usize,
    pub frames: FrameRange,
    pub size: [u32; 2],
    /// Coding of the stream, or the coding it had before it was decoded to files; `None` if unknown.
    pub coding: Option<Coding>,
    pub depth_kind: DepthKind,
    pub(super) place: Place,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Place {
    Stream(usize),
    /// Index of a group of the source, and of a plane that reading the group returns.
    Plane {
        group: usize,
        plane: usize,
    },
}

impl SideStream {
    /// Returns true if both are cut from the same files, which should be read only once.
    pub fn shares_files(&self, other: &SideStream) -> bool {
        match (self.place, other.place) {
            (Place::Plane { group, .. }, Place::Plane { group: other, .. }) => group == other,
            _ => false,
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum SideForm {
    Container,
    Dataset,
    /// A dataset that lightfold decoded; its manifest states the coding.
    #[serde(rename = "decoded dataset")]
    Decoded,
    Sequence,
}

impl SideForm {
    pub fn name(self) -> &'static str {
        match self {
            SideForm::Container => "container",
            SideForm::Dataset => "dataset",
            SideForm::Decoded => "decoded dataset",
            SideForm::Sequence => "sequence",
        }
    }
}

#[derive(Debug)]
pub(super) enum Content {
    Container(Box<Decoder>),
    Files(Box<Source>),
}

#[derive(Debug, Serialize)]
pub struct Side {
    pub path: String,
    pub form: SideForm,
    #[serde(skip)]
    pub streams: Vec<SideStream>,
    /// Primaries of the colour values.
    #[serde(skip)]
    pub primaries: Primaries,
    /// Number of colour pixels that encoding clipped, if the side is a container that states it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub clipped_pixels: Option<u64>,
    #[serde(skip)]
    pub(super) content: Content,
}

#[derive(Debug, Clone, PartialEq)]
pub enum Image {
    /// Codes of a container.
    Coded(Picture),
    File(Values),
}

#[derive(Debug, Clone, PartialEq)]
pub enum Values {
    /// Metres, +inf for background.
    Metres(DepthPlane),
    Light(ColorPlane),
    Weights(MaterialPlane),
    Alpha(AlphaPlane),
}

impl Side {
    /// Returns the bytes of memory for reading a stream; for files this includes the images of all faces of the group.
    pub fn stream_bytes(&self, stream: &SideStream) -> u64 {
        match (&self.content, stream.place) {
            (Content::Container(decoder), Place::Stream(at)) => {
                decoder.streams().get(at).map_or(0, |stream| memory::stream_bytes(decoder, stream))
            }
            // Images of the other faces of the group are held until they are requested.
            (Content::Files(source), Place::Plane { group, .. }) => {
                source.groups().get(group).map_or(0, |group| source.reading_bytes(group))
            }
            _ => 0,
        }
    }

    /// Returns the treatment of invalid depth with which files are read.
    pub fn invalid_depth(&self) -> InvalidDepth {
        match &self.content {
            Content::Files(source) => source.rules.invalid,
            Content::Container(_) => InvalidDepth::Refuse,
        }
    }

    pub fn open_bytes(&self) -> u64 {
        match &self.content {
            Content::Container(decoder) => memory::container_bytes(decoder.reader()),
            Content::Files(source) => source.table_bytes(&source.groups().iter().collect::<Vec<_>>()),
        }
    }
}

/// Reader of the images of some streams of a side, frame by frame; files that hold several of them are read once.
pub struct SideReader<'a> {
    side: &'a Side,
    streams: Vec<&'a SideStream>,
    decoders: Vec<FaceDecoder<'a>>,
    held: Option<ReadGroup>,
}

struct ReadGroup {
    group: usize,
    frame: u32,
    planes: Vec<Option<Image>>,
}

impl<'a> SideReader<'a> {
    pub fn new(side: &'a Side, streams: Vec<&'a SideStream>) -> SideReader<'a> {
        let decoders = match &side.content {
            Content::Container(decoder) => streams
                .iter()
                .filter_map(|stream| match stream.place {
                    Place::Stream(at) => decoder.streams().get(at).map(|stream| decoder.face(stream)),
                    Place::Plane { .. } => None,
                })
                .collect(),
            Content::Files(_) => Vec::new(),
        };
        SideReader { side, streams, decoders, held: None }
    }

    pub fn image(&mut self, at: usize, frame: u32) -> Result<Image> {
        match (&self.side.content, self.streams[at].place) {
            (Content::Files(source), Place::Plane { group, plane }) => {
                let is_held = |held: &ReadGroup| {
                    (held.group, held.frame) == (group, frame) && held.planes.get(plane).is_some_and(Option::is_some)
                };
                if !self.held.as_ref().is_some_and(is_held) {
                    self.held = Some(ReadGroup { group, frame, planes: read_group(source, group, frame)? });
                }
                let image = self.held.as_mut().and_then(|held| held.planes.get_mut(plane)?.take());
                image.ok_or_else(|| Error::invalid(format!("frame {frame} has no image of this face")))
            }
            _ => self.decoders[at].decode(frame).map(Image::Coded),
        }
    }
}

fn read_group(source: &Source, group: usize, frame: u32) -> Result<Vec<Option<Image>>> {
    let group = &source.groups()[group];
    Ok(match group.kind {
        StreamKind::Color => wrap(source.read_color(group, frame)?, Values::Light),
        StreamKind::Depth => wrap(source.read_depth(group, frame)?, Values::Metres),
        StreamKind::Material => wrap(source.read_material(group, frame)?, Values::Weights),
        StreamKind::Alpha => wrap(source.read_alpha(group, frame)?, Values::Alpha),
    })
}

fn wrap<T>(planes: Vec<T>, values: fn(T) -> Values) -> Vec<Option<Image>> {
    planes.into_iter().map(|plane| Some(Image::File(values(plane)))).collect()
}
