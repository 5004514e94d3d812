//! One of the two things that a comparison is between: a container, a dataset or a lone sequence.
//!
//! Enters: a path. Leaves: streams with a name each, and their images, coded as a container holds them or as files do.

use std::fmt;
use std::io::Read;
use std::path::{Path, PathBuf};

use serde::ser::SerializeStruct;
use serde::{Deserialize, Serialize, Serializer};

use crate::container::header::MAGIC;
use crate::dataset::manifest::{MANIFEST_NAME, Manifest};
use crate::dataset::source::{Arrangement, SequenceLayout, Source, SourceOptions};
use crate::dataset::stream::{DepthKind, Projection, StreamKind};
use crate::decode::{Decoder, FaceDecoder, Picture, Selection, memory};
use crate::depth::quantise::DepthRange;
use crate::error::{Error, Result};
use crate::image::cube::Face;
use crate::image::plane::{ColorPlane, DepthPlane, MaterialPlane};
use crate::image::sequence::{FrameRange, Pattern};
use crate::image::transfer::{ToneMap, Transfer};
use crate::streams::{CodecHeader, ColorFormat};

/// What a stream is called.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct StreamId {
    /// What its pixels are.
    pub kind: StreamKind,
    /// Name of its probe.
    pub probe: String,
    /// Its face.
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

/// How a stream is coded, or was before it became files.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Coding {
    /// 16-bit log codes.
    Depth(DepthRange),
    /// 8-bit or half-float colour, in cells of so many pixels.
    Color(ColorFormat, u32),
    /// 8-bit material.
    Material,
}

/// A stream of a side.
#[derive(Debug, Clone, PartialEq)]
pub struct SideStream {
    /// Its name.
    pub id: StreamId,
    /// Where its probe stands in the order of the side's probes.
    pub probe_order: usize,
    /// Its frames, as far as they were asked for.
    pub frames: FrameRange,
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// How it is or was coded, where that is known.
    pub coding: Option<Coding>,
    /// What its metres measure, for depth.
    pub depth_kind: DepthKind,
    place: Place,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Place {
    /// Index of a container's stream.
    Stream(usize),
    /// Index of a source's group, and of the plane that reading it delivers.
    Plane { group: usize, plane: usize },
}

impl SideStream {
    /// Whether both are cut from the same files, so that they are best read together.
    pub fn shares_files(&self, other: &SideStream) -> bool {
        match (self.place, other.place) {
            (Place::Plane { group, .. }, Place::Plane { group: other, .. }) => group == other,
            _ => false,
        }
    }
}

/// What a side is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SideForm {
    /// A container.
    Container,
    /// A dataset of files.
    Dataset,
    /// A dataset that lightfold decoded, whose manifest tells how it had been coded.
    Decoded,
    /// A lone sequence.
    Sequence,
}

impl SideForm {
    /// The word for it in reports.
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
enum Content {
    Container(Box<Decoder>),
    Files(Box<Source>),
}

/// One side of a comparison.
#[derive(Debug)]
pub struct Side {
    /// As the user named it.
    pub path: String,
    /// What it is.
    pub form: SideForm,
    /// The streams that were asked for, in the side's own order.
    pub streams: Vec<SideStream>,
    content: Content,
}

/// How sides are opened.
#[derive(Debug, Clone, Default)]
pub struct SideOptions {
    /// How files are read. Applies to datasets and sequences, save to decoded datasets, which need no help.
    pub source: SourceOptions,
    /// What the images of lone sequences show; the face of single images only where nothing else tells it.
    pub layout: SequenceLayout,
    /// Which streams and frames.
    pub selection: Selection,
}

/// An image of a side.
#[derive(Debug, Clone, PartialEq)]
pub enum Image {
    /// As a container codes it.
    Coded(Picture),
    /// Metres from a file.
    Depth(DepthPlane),
    /// Light from a file.
    Color(ColorPlane),
    /// Weights from a file.
    Material(MaterialPlane),
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Form {
    Container,
    /// Cube faces or views, whose size is what it is.
    Faces,
    /// Equirectangular images, whose faces take the size of the other side's.
    Panorama,
    /// Takes kind, probe and face from the other side.
    Sequence,
}

/// Opens both sides, the one that knows more first, so that it can tell the other what it must be like.
///
/// # Errors
/// When one of them is no container, dataset or sequence, or has no stream that was asked for.
pub fn open_both(paths: [&str; 2], options: &SideOptions) -> Result<[Side; 2]> {
    if paths == ["-", "-"] {
        return Err(Error::Usage("standard input can be only one of the two sides".into()));
    }
    let forms = [form_of(paths[0])?, form_of(paths[1])?];
    let first = usize::from(forms[1] < forms[0]);
    let other_path = paths[1 - first];
    let one = open(paths[first], forms[first], options, &Other::Path(other_path))?;
    let other = open(other_path, forms[1 - first], options, &Other::Open(&one))?;
    let mut sides = if first == 0 { [one, other] } else { [other, one] };
    check_selection(&sides, &options.selection)?;
    let mut selection = options.selection.clone();
    if let Some(sequence) = sides.iter().find(|side| side.form == SideForm::Sequence) {
        // Beside a lone sequence only streams of its kind are meant.
        selection.kinds = sequence.streams.iter().take(1).map(|stream| stream.id.kind).collect();
    }
    for side in &mut sides {
        select(side, &selection)?;
    }
    Ok(sides)
}

fn form_of(path: &str) -> Result<Form> {
    let file = Path::new(path);
    let has = |extension: &str| file.extension().is_some_and(|found| found.eq_ignore_ascii_case(extension));
    if has("json") || file.join(MANIFEST_NAME).is_file() {
        let panorama = Manifest::read(file)?.projection == Projection::Equirect;
        return Ok(if panorama { Form::Panorama } else { Form::Faces });
    }
    let container = path == "-" || has("lfold") || (file.is_file() && starts_with_magic(file)?);
    if container {
        return Ok(Form::Container);
    }
    if !file.exists() && !Pattern::parse(path)?.has_field() {
        return Err(Error::invalid("there is no such file or folder").in_file(path));
    }
    Ok(Form::Sequence)
}

fn starts_with_magic(path: &Path) -> Result<bool> {
    let mut head = Vec::new();
    let file = std::fs::File::open(path).map_err(|error| Error::io(path, error))?;
    file.take(MAGIC.len() as u64).read_to_end(&mut head).map_err(|error| Error::io(path, error))?;
    Ok(head == MAGIC)
}

/// What is known about the other side when one is opened.
enum Other<'a> {
    Path(&'a str),
    Open(&'a Side),
}

impl Other<'_> {
    fn streams(&self) -> &[SideStream] {
        match self {
            Other::Path(_) => &[],
            Other::Open(side) => &side.streams,
        }
    }
}

fn open(path: &str, form: Form, options: &SideOptions, other: &Other<'_>) -> Result<Side> {
    match form {
        Form::Container => open_container(path),
        Form::Faces | Form::Panorama => open_dataset(path, form, options, other),
        Form::Sequence => open_sequence(path, options, other),
    }
}

/// Keeps what was asked for.
fn select(side: &mut Side, selection: &Selection) -> Result<()> {
    // The names of a lone sequence are only what we called it.
    let sequence = side.form == SideForm::Sequence;
    side.streams.retain_mut(|stream| {
        let frames = selection.frames.map_or(Some(stream.frames), |frames| stream.frames.intersect(frames));
        stream.frames = frames.unwrap_or(stream.frames);
        frames.is_some() && (sequence || is_selected(&stream.id, selection))
    });
    if side.streams.is_empty() {
        return Err(Error::Usage(format!("{}: there is no stream that matches the options", side.path)));
    }
    Ok(())
}

fn is_selected(id: &StreamId, selection: &Selection) -> bool {
    (selection.kinds.is_empty() || selection.kinds.contains(&id.kind))
        && (selection.probes.is_empty() || selection.probes.contains(&id.probe))
        && (selection.faces.is_empty() || selection.faces.contains(&id.face))
}

/// Refuses names in the selection that neither side knows.
fn check_selection(sides: &[Side; 2], selection: &Selection) -> Result<()> {
    if sides.iter().any(|side| side.form == SideForm::Sequence) {
        return Ok(());
    }
    let has = |test: &dyn Fn(&StreamId) -> bool| sides.iter().flat_map(|side| &side.streams).any(|s| test(&s.id));
    let missing = |what: String| Err(Error::Usage(format!("neither side has {what}")));
    if let Some(probe) = selection.probes.iter().find(|probe| !has(&|id| id.probe == **probe)) {
        return missing(format!("a probe '{probe}'"));
    }
    if let Some(face) = selection.faces.iter().find(|face| !has(&|id| id.face == **face)) {
        return missing(format!("a face {}", face.name()));
    }
    match selection.kinds.iter().find(|kind| !has(&|id| id.kind == **kind)) {
        Some(kind) => missing(format!("a {} stream", kind.name())),
        None => Ok(()),
    }
}

fn open_container(path: &str) -> Result<Side> {
    let decoder = Decoder::open(PathBuf::from(path))?;
    let streams = decoder.streams().iter().enumerate().map(|(at, stream)| {
        let (coding, depth_kind) = match stream.header {
            CodecHeader::Depth(header) => (Coding::Depth(header.range), header.kind),
            CodecHeader::Color(header) => (Coding::Color(header.format, stream.entry.unit_width), DepthKind::default()),
            CodecHeader::Material(_) => (Coding::Material, DepthKind::default()),
        };
        SideStream {
            id: StreamId { kind: stream.kind, probe: decoder.probe(stream).name.clone(), face: stream.face },
            probe_order: stream.probe,
            frames: stream.frames,
            size: [stream.entry.width, stream.entry.height],
            coding: Some(coding),
            depth_kind,
            place: Place::Stream(at),
        }
    });
    let streams = streams.collect();
    Ok(Side {
        path: path.to_owned(),
        form: SideForm::Container,
        streams,
        content: Content::Container(Box::new(decoder)),
    })
}

fn open_dataset(path: &str, form: Form, options: &SideOptions, other: &Other<'_>) -> Result<Side> {
    let manifest = Manifest::read(Path::new(path))?;
    let coding = ManifestCoding::of(&manifest).map_err(|error| error.in_file(path))?;
    let mut source = options.source.clone();
    if coding.is_some() {
        source.depth_scale = None;
        source.background = None;
        source.depth_kind = None;
        source.color_space = None;
    }
    source.frames = options.selection.frames;
    source.face_size = match form {
        Form::Panorama => options.source.face_size.or(other.streams().first().map(|stream| stream.size[0])),
        _ => None,
    };
    let source = Source::open(Path::new(path), &source)?;
    let form = if coding.is_some() { SideForm::Decoded } else { SideForm::Dataset };
    from_source(path, form, source, &coding.unwrap_or_default())
}

fn open_sequence(path: &str, options: &SideOptions, other: &Other<'_>) -> Result<Side> {
    let kind = sequence_kind(path, options, other)?;
    let selection = &options.selection;
    let known: Vec<&SideStream> =
        other.streams().iter().filter(|stream| stream.id.kind == kind && is_selected(&stream.id, selection)).collect();
    let mut source = options.source.clone();
    let mut layout = options.layout.clone();
    source.frames = selection.frames;
    if let Some(first) = known.first() {
        if known.iter().all(|stream| stream.id.probe == first.id.probe) {
            layout.probe.clone_from(&first.id.probe);
        }
        if let (Arrangement::Single(_), 1) = (layout.arrangement, known.len()) {
            layout.arrangement = Arrangement::Single(first.id.face);
        }
        if layout.arrangement == Arrangement::Equirect {
            source.face_size = source.face_size.or(Some(first.size[0]));
        }
        if kind == StreamKind::Depth && first.depth_kind == DepthKind::Planar {
            source.depth_kind = source.depth_kind.or(Some(DepthKind::Planar));
        }
    }
    if let [probe] = selection.probes.as_slice() {
        layout.probe.clone_from(probe);
    }
    if let (Arrangement::Single(_), [face]) = (layout.arrangement, selection.faces.as_slice()) {
        layout.arrangement = Arrangement::Single(*face);
    }
    let source = Source::from_sequence(kind, path, &layout, &source)?;
    from_source(path, SideForm::Sequence, source, &ManifestCoding::default())
}

/// What a lone sequence holds: as the options say, as its name says, or as the other side has it.
fn sequence_kind(path: &str, options: &SideOptions, other: &Other<'_>) -> Result<StreamKind> {
    if let [kind] = options.selection.kinds.as_slice() {
        return Ok(*kind);
    }
    let of_other = || match other {
        Other::Path(path) => kind_in_name(path),
        Other::Open(side) => {
            let mut kinds = side.streams.iter().map(|stream| stream.id.kind);
            let first = kinds.next();
            first.filter(|&kind| kinds.all(|other| other == kind))
        }
    };
    kind_in_name(path).or_else(of_other).ok_or_else(|| {
        Error::Usage(format!("{path}: the kind of images is unknown: set `stream` to depth, color or material"))
    })
}

/// The kind that a path speaks of: its last part, else the folder that this lies in.
fn kind_in_name(path: &str) -> Option<StreamKind> {
    let lower = path.to_lowercase();
    let words = [("depth", StreamKind::Depth), ("material", StreamKind::Material)];
    let colors = [("color", StreamKind::Color), ("colour", StreamKind::Color)];
    lower.rsplit(['/', std::path::MAIN_SEPARATOR]).take(2).find_map(|part| {
        let mut found = words.iter().chain(&colors).filter(|(word, _)| part.contains(word)).map(|(_, kind)| *kind);
        let first = found.next();
        first.filter(|&kind| found.all(|other| other == kind))
    })
}

fn from_source(path: &str, form: SideForm, source: Source, coding: &ManifestCoding) -> Result<Side> {
    let mut streams = Vec::new();
    for (at, group) in source.groups().iter().enumerate() {
        let probe = &source.probes()[group.probe].name;
        let known = coding.stream(group.kind, probe, group.faces[0]).map_err(|error| error.in_file(path))?;
        for (plane, &face) in group.faces.iter().enumerate() {
            streams.push(SideStream {
                id: StreamId { kind: group.kind, probe: probe.clone(), face },
                probe_order: group.probe,
                frames: group.frames,
                size: [group.width, group.height],
                coding: known,
                depth_kind: source.depth_stored(),
                place: Place::Plane { group: at, plane },
            });
        }
    }
    Ok(Side { path: path.to_owned(), form, streams, content: Content::Files(Box::new(source)) })
}

impl Side {
    /// Bytes of memory that reading a stream of this side takes, but for its images.
    pub fn stream_bytes(&self, stream: &SideStream) -> u64 {
        match (&self.content, stream.place) {
            (Content::Container(decoder), Place::Stream(at)) => {
                decoder.streams().get(at).map_or(0, |stream| memory::stream_bytes(decoder, stream))
            }
            // The file that an image is cut from: at most four channels of 4 bytes.
            (Content::Files(source), _) => source.file_pixels() * 16,
            _ => 0,
        }
    }

    /// Bytes of memory that it takes as long as it is open.
    pub fn open_bytes(&self) -> u64 {
        match &self.content {
            Content::Container(decoder) => memory::container_bytes(decoder.reader()),
            Content::Files(_) => 0,
        }
    }
}

/// What `extra.lightfold` of a decoded dataset's manifest tells.
#[derive(Debug, Clone, Default, Deserialize)]
struct ManifestCoding {
    color: Option<ColorCoding>,
    /// By `probe/face`.
    depth: Option<std::collections::BTreeMap<String, DepthCoding>>,
}

#[derive(Debug, Clone, Deserialize)]
struct DepthCoding {
    near_m: f32,
    far_m: f32,
}

#[derive(Debug, Clone, Deserialize)]
#[serde(tag = "format")]
enum ColorCoding {
    #[serde(rename = "8bit")]
    EightBit { transfer: TransferName, exposure_ev: f32, cell: u32 },
    #[serde(rename = "half")]
    Half { white_cd_m2: f64, cell: u32 },
}

#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(rename_all = "lowercase")]
enum TransferName {
    Srgb,
    Linear,
}

impl ManifestCoding {
    fn of(manifest: &Manifest) -> Result<Option<ManifestCoding>> {
        let Some(coding) = manifest.extra.as_ref().and_then(|extra| extra.get("lightfold")) else {
            return Ok(None);
        };
        ManifestCoding::deserialize(coding)
            .map(Some)
            .map_err(|error| Error::invalid(format!("extra.lightfold is not as lightfold writes it: {error}")))
    }

    fn stream(&self, kind: StreamKind, probe: &str, face: Face) -> Result<Option<Coding>> {
        Ok(match kind {
            StreamKind::Depth => {
                match self.depth.as_ref().and_then(|ranges| ranges.get(&format!("{probe}/{}", face.name()))) {
                    Some(range) => Some(Coding::Depth(DepthRange::new(range.near_m, range.far_m)?)),
                    None => None,
                }
            }
            StreamKind::Color => self.color.as_ref().map(|coding| match *coding {
                ColorCoding::EightBit { transfer, exposure_ev, cell } => {
                    let transfer = match transfer {
                        TransferName::Srgb => Transfer::Srgb,
                        TransferName::Linear => Transfer::Linear,
                    };
                    Coding::Color(ColorFormat::EightBit(ToneMap { transfer, exposure_ev }), cell.max(1))
                }
                ColorCoding::Half { white_cd_m2, cell } => {
                    Coding::Color(ColorFormat::Half { white_cd_m2 }, cell.max(1))
                }
            }),
            StreamKind::Material => Some(Coding::Material),
        })
    }
}

/// Reads images of some streams of a side, frame by frame; files that hold several of them are read once.
#[derive(Debug)]
pub struct SideReader<'a> {
    side: &'a Side,
    streams: Vec<&'a SideStream>,
    /// One for each stream of a container.
    decoders: Vec<FaceDecoder<'a>>,
    /// Group, frame, and the planes that nobody has taken yet.
    held: Option<(usize, u32, Vec<Option<Image>>)>,
}

impl<'a> SideReader<'a> {
    /// A reader of those streams.
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

    /// The image of a frame of the stream at position `at` of those that the reader was made for.
    ///
    /// # Errors
    /// Names the file that cannot be read or decoded.
    pub fn image(&mut self, at: usize, frame: u32) -> Result<Image> {
        match (&self.side.content, self.streams[at].place) {
            (Content::Files(source), Place::Plane { group, plane }) => {
                let taken = |held: &Vec<Option<Image>>| held.get(plane).is_none_or(Option::is_none);
                if self.held.as_ref().is_none_or(|(g, f, held)| (*g, *f) != (group, frame) || taken(held)) {
                    self.held = Some((group, frame, read_group(source, group, frame)?));
                }
                let image = self.held.as_mut().and_then(|(_, _, planes)| planes.get_mut(plane)?.take());
                image.ok_or_else(|| Error::invalid(format!("frame {frame} has no image of this face")))
            }
            _ => self.decoders[at].decode(frame).map(Image::Coded),
        }
    }
}

fn read_group(source: &Source, group: usize, frame: u32) -> Result<Vec<Option<Image>>> {
    let group = &source.groups()[group];
    Ok(match group.kind {
        StreamKind::Color => wrap(source.read_color(group, frame)?, Image::Color),
        StreamKind::Depth => wrap(source.read_depth(group, frame)?, Image::Depth),
        StreamKind::Material => wrap(source.read_material(group, frame)?, Image::Material),
    })
}

fn wrap<T>(planes: Vec<T>, image: fn(T) -> Image) -> Vec<Option<Image>> {
    planes.into_iter().map(|plane| Some(image(plane))).collect()
}
