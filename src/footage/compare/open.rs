//! Opens the two sides of a comparison.

use std::path::{Path, PathBuf};

use crate::compare::manifest_coding::ManifestCoding;
use crate::compare::side::{Coding, Content, Place, Side, SideForm, SideStream, StreamId};
use crate::dataset::manifest::{MANIFEST_NAME, Manifest};
use crate::dataset::{Arrangement, SequenceLayout, Source, SourceOptions};
use crate::image_files::{exr, png};
use codec::container::header::is_container;
use codec::decode::{Decoder, Selection};
use codec::error::{Error, Result};
use codec::image::channels::{find_alpha, find_color, find_depth};
use codec::image::{AlphaPlane, ChannelSelect, DepthKind, Pattern, Projection, ReadLimits, Sequence, StreamKind};
use codec::streams::{CodecHeader, StreamInfo};

#[derive(Debug, Clone, Default)]
pub struct SideOptions {
    /// Options for reading files; decoded datasets need none of them.
    pub source: SourceOptions,
    /// Content of image sequences, and the face of single images if neither side states it.
    pub layout: SequenceLayout,
    pub selection: Selection,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Form {
    Container,
    /// Cube faces or perspective views.
    Faces,
    /// Equirectangular images; their cube faces take the size of the other side.
    Panorama,
    /// Image files; kind, probe and face are taken from the other side.
    Sequence,
}

/// Opens both sides. The side that states more is opened first; the other takes face size, probe and kind from it.
pub fn open_both(paths: [&str; 2], options: &SideOptions) -> Result<[Side; 2]> {
    if paths == ["-", "-"] {
        return Err(Error::Usage("standard input can be only one of the two sides".into()));
    }
    let forms = [form_of(paths[0])?, form_of(paths[1])?];
    let first = usize::from(forms[1] < forms[0]);
    let other_path = paths[1 - first];
    let one = open(paths[first], forms[first], options, &Other { path: other_path, streams: &[] })?;
    let other = open(other_path, forms[1 - first], options, &Other { path: "", streams: &one.streams })?;
    let mut sides = if first == 0 { [one, other] } else { [other, one] };
    if sides.iter().flat_map(|side| &side.streams).any(|stream| stream.depth_kind == DepthKind::Planar) {
        sides.iter_mut().for_each(keep_kind_of_views);
    }
    check_selection(&sides, &options.selection)?;
    let mut selection = options.selection.clone();
    if let Some(sequence) = sides.iter().find(|side| side.form == SideForm::Sequence) {
        // If a side is an image sequence, only streams of its kind are compared.
        selection.kinds = sequence.streams.iter().take(1).map(|stream| stream.id.kind).collect();
    }
    for side in &mut sides {
        select(side, &selection)?;
    }
    Ok(sides)
}

/// Keeps the depth kind of views as files store it.
fn keep_kind_of_views(side: &mut Side) {
    if let Content::Files(source) = &mut side.content {
        source.keep_kind_of_views();
        side.streams.iter_mut().for_each(|stream| stream.depth_kind = source.depth_stored);
    }
}

fn form_of(path: &str) -> Result<Form> {
    let file = Path::new(path);
    let has = |extension: &str| file.extension().is_some_and(|found| found.eq_ignore_ascii_case(extension));
    if has("json") || file.join(MANIFEST_NAME).is_file() {
        let panorama = Manifest::read(file)?.projection == Projection::Equirect;
        return Ok(if panorama { Form::Panorama } else { Form::Faces });
    }
    if path == "-" || is_container(file)? {
        return Ok(Form::Container);
    }
    if !file.exists() && !Pattern::parse(path)?.has_field() {
        return Err(Error::not_found(path, "there is no such file or folder"));
    }
    Ok(Form::Sequence)
}

/// The other side: its path, or its streams if it is open.
struct Other<'a> {
    path: &'a str,
    streams: &'a [SideStream],
}

fn open(path: &str, form: Form, options: &SideOptions, other: &Other<'_>) -> Result<Side> {
    match form {
        Form::Container => open_container(path),
        Form::Faces | Form::Panorama => open_dataset(path, form, options, other),
        Form::Sequence => open_sequence(path, options, other),
    }
}

fn select(side: &mut Side, selection: &Selection) -> Result<()> {
    // Probe and face of an image sequence are defaults, so they are not filtered.
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
    let stream = |(at, stream): (usize, &StreamInfo)| {
        let (coding, depth_kind) = match &stream.header {
            CodecHeader::Depth(header) => (Coding::Depth(header.range), header.kind),
            CodecHeader::Color(header) => (Coding::Color(header.format, stream.entry.unit_width), DepthKind::default()),
            CodecHeader::Material(_) | CodecHeader::Alpha(_) => (Coding::Bytes, DepthKind::default()),
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
    };
    let streams = decoder.streams().iter().enumerate().map(stream).collect();
    let primaries = decoder.primaries();
    let clipped_pixels = decoder.footage().clipped_pixels;
    let content = Content::Container(Box::new(decoder));
    Ok(Side { path: path.to_owned(), form: SideForm::Container, streams, primaries, clipped_pixels, content })
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
    // Panoramas of different sizes become faces of different sizes, as in encodes.
    let has_own_sizes = manifest.probes.iter().any(|probe| manifest.size_of(probe) != manifest.size);
    let mut sides = other.streams.iter().map(|stream| stream.size[0]);
    source.face_size = match form {
        Form::Panorama if has_own_sizes => options.source.face_size.or(only_one(sides)),
        Form::Panorama => options.source.face_size.or(sides.next()),
        _ => None,
    };
    let mut source = Source::open(Path::new(path), &source)?;
    // The range of codes applies to the depth kind that the container stored.
    if coding.is_some() {
        source.keep_kind_of_views();
    }
    let form = if coding.is_some() { SideForm::Decoded } else { SideForm::Dataset };
    from_source(path, form, source, &coding.unwrap_or_default())
}

fn open_sequence(path: &str, options: &SideOptions, other: &Other<'_>) -> Result<Side> {
    let kind = sequence_kind(path, options, other)?;
    let selection = &options.selection;
    let known: Vec<&SideStream> =
        other.streams.iter().filter(|stream| stream.id.kind == kind && is_selected(&stream.id, selection)).collect();
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

/// Returns the kind of an image sequence, from the options, its name, the other side, or the channels of its first file.
fn sequence_kind(path: &str, options: &SideOptions, other: &Other<'_>) -> Result<StreamKind> {
    if let [kind] = options.selection.kinds.as_slice() {
        return Ok(*kind);
    }
    let of_streams = || only_one(other.streams.iter().map(|stream| stream.id.kind));
    let in_file = || kind_in_file(path, &options.source.limits).filter(|_| options.selection.kinds.is_empty());
    kind_in_name(path).or_else(|| kind_in_name(other.path)).or_else(of_streams).or_else(in_file).ok_or_else(|| {
        Error::Usage(format!("{path}: the kind of images is unknown: set `stream` to depth, color, material or alpha"))
    })
}

/// Returns colour for a first file with red, green and blue, depth for an EXR file with a depth channel. Gray files may be either;
/// files with both, or with alpha, hold more than one kind. Reading reports errors of the file.
fn kind_in_file(path: &str, limits: &ReadLimits) -> Option<StreamKind> {
    let sequence = Sequence::find_with_gaps(path, None).ok()?;
    let file = sequence.path(sequence.frames.first);
    let is_opaque = |alpha: Result<AlphaPlane>| alpha.is_ok_and(|alpha| alpha.data().iter().all(|alpha| *alpha == 1.0));
    if png::has_codes(&file) {
        let is_color = png::has_color(&file, limits).ok()?;
        let is_alone = !png::has_alpha(&file, limits).ok()? || is_opaque(png::read_alpha(&file, limits));
        return (is_color && is_alone).then_some(StreamKind::Color);
    }
    let (channels, auto) = (exr::read_header(&file, limits).ok()?.channels, ChannelSelect::Auto);
    match (find_color(&channels, &auto), find_depth(&channels, &auto)) {
        (Ok([red, green, _]), Err(_)) if red != green => {
            let is_alone =
                find_alpha(&channels, red).is_none() || is_opaque(exr::read_alpha(&file, &auto, &auto, limits));
            is_alone.then_some(StreamKind::Color)
        }
        (Err(_), Ok(_)) => Some(StreamKind::Depth),
        _ => None,
    }
}

fn only_one<T: PartialEq>(mut values: impl Iterator<Item = T>) -> Option<T> {
    let first = values.next()?;
    values.all(|other| other == first).then_some(first)
}

/// Returns the kind that a file name contains, else the kind that its folder name contains.
fn kind_in_name(path: &str) -> Option<StreamKind> {
    let lower = path.to_lowercase();
    let words = ["depth", "material", "alpha", "color", "colour"];
    let kinds = [StreamKind::Depth, StreamKind::Material, StreamKind::Alpha, StreamKind::Color, StreamKind::Color];
    let mut parts = lower.rsplit(['/', std::path::MAIN_SEPARATOR]).take(2);
    parts.find_map(|part| {
        only_one(words.iter().zip(kinds).filter(|(word, _)| part.contains(**word)).map(|(_, kind)| kind))
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
                depth_kind: source.depth_stored,
                place: Place::Plane { group: at, plane },
            });
        }
    }
    let primaries = source.primaries();
    let content = Content::Files(Box::new(source));
    Ok(Side { path: path.to_owned(), form, streams, primaries, clipped_pixels: None, content })
}
