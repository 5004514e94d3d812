//! Writes decoded images into EXR or PNG files, and the manifest that makes a folder of them a dataset again; or those of one stream
//! into a pipe.

use std::fs::File;
use std::io::{BufWriter, ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

use serde_json::json;

use crate::dataset::manifest::MANIFEST_NAME;
use crate::decode::damage::{FrameRanges, MissingImages};
use crate::decode::decoder::Decoder;
use crate::decode::face::Picture;
use crate::decode::images::ImageSource;
use crate::decode::manifest::{FileCoding, FileFormat, file_pattern, manifest_of};
use crate::decode::memory;
use crate::decode::selection::{Request, StreamFrames};
use crate::decode::units::{DecodeSummary, Decoded, DecodedPart, jobs_at_once};
use crate::depth::CodeTable;
use crate::error::{Error, Result};
use crate::image::StreamKind;
use crate::image::exr;
use crate::image::picture_stream::{CodePicture, PictureStream, StreamFormat};
use crate::image::sequence::Pattern;
use crate::image::transfer::{DecodeTable, EncodeTable, ToneMap};
use crate::image::{ColorPlane, LightMatrix, Primaries};
use crate::monitor::Monitor;
use crate::ordered::try_map_at_once;
use crate::streams::{CodecHeader, ColorFormat, StreamInfo, convert};

const MATERIAL_CHANNELS: [&str; 3] = ["reflect", "refract", "ior"];

#[derive(Debug, Clone)]
pub enum Destination {
    /// A folder that becomes a dataset: `probe_NAME/face_FACE/KIND.0000.exr` and a manifest.
    Dataset(PathBuf),
    Files(Pattern),
}

impl Destination {
    fn pattern(&self, decoder: &Decoder, stream: &StreamInfo, format: FileFormat) -> Result<Pattern> {
        match self {
            Destination::Files(pattern) => Ok(pattern.clone()),
            Destination::Dataset(folder) => {
                let pattern = file_pattern(decoder, stream.kind, format);
                let probe = &decoder.probe(stream).name;
                let name = pattern.replace("{probe}", probe).replace("{face}", stream.face.name());
                Ok(Pattern::parse(&name)?.below(folder))
            }
        }
    }

    /// Removes older files under the names of missing images; returns their number.
    pub fn remove_missing(&self, decoder: &Decoder, missing: &[MissingImages], format: FileFormat) -> Result<u64> {
        let mut removed = 0;
        for missing in missing {
            let pattern = self.pattern(decoder, &decoder.streams()[missing.stream as usize], format)?;
            // Where there is no folder there are no files; frames may be many.
            if pattern.path(0).parent().is_none_or(|folder| !folder.is_dir()) {
                continue;
            }
            for frame in missing.frames.iter().flat_map(|range| range.iter()) {
                let path = pattern.path(frame);
                match std::fs::remove_file(&path) {
                    Ok(()) => removed += 1,
                    Err(error) if error.kind() == ErrorKind::NotFound => {}
                    Err(error) => return Err(Error::io(&path, error)),
                }
            }
        }
        Ok(removed)
    }
}

/// Decodes into files. Missing images have no file, and the manifest's `extra` lists them.
pub fn decode_to_files(
    source: &dyn ImageSource,
    decoder: &Decoder,
    Request { streams, filter, memory }: Request<'_>,
    destination: &Destination,
    coding: FileCoding,
    monitor: &dyn Monitor,
) -> Result<Decoded> {
    let format = coding.format;
    let written = Written::default();
    let each = |part: &StreamFrames<'_>| memory::stream_bytes(decoder, part.stream) + memory::file_bytes(part.stream);
    let at_once = jobs_at_once(decoder, memory, || streams.iter().map(each).max())?;
    let parts = try_map_at_once(streams.to_vec(), at_once, |StreamFrames { stream, frames }| {
        let writer = ImageWriter::new(stream, coding, decoder.primaries());
        let pattern = destination.pattern(decoder, stream, format)?;
        let mut face = source.open(decoder, stream)?;
        let mut missing = FrameRanges::default();
        for frame in frames.iter() {
            monitor.check()?;
            match face.decode_intact(frame, filter)? {
                Some(picture) => {
                    let file = writer.write_new(&pattern.path(frame), picture)?;
                    written.bytes.fetch_add(file.bytes, Ordering::Relaxed);
                    written.clipped_pixels.fetch_add(file.clipped_pixels, Ordering::Relaxed);
                }
                None => missing.push(frame),
            }
            monitor.advance(1);
        }
        let (pixels, images) = (face.selected_pixels(), frames.count() - missing.count());
        let summary = DecodeSummary { frames: images, pixels, bytes_out: 0, cost: face.cost() };
        Ok(DecodedPart { stream: stream.index, summary, damaged: face.damaged(), missing })
    })?;
    let mut decoded = Decoded::of(parts);
    decoded.summary.bytes_out = written.bytes.into_inner();
    decoded.clipped_pixels = written.clipped_pixels.into_inner();
    if let Destination::Dataset(folder) = destination
        && decoded.summary.frames > 0
    {
        let mut manifest = match manifest_of(decoder, streams, coding) {
            Ok(manifest) => manifest,
            Err(why) => {
                decoded.no_manifest = Some(why);
                return Ok(decoded);
            }
        };
        if !decoded.missing.is_empty() {
            let list: Vec<_> = decoded.missing.iter().map(|missing| missing.report(decoder)).collect();
            manifest.extra.get_or_insert_with(|| json!({}))["missing"] = json!(list);
        }
        let path = folder.join(MANIFEST_NAME);
        std::fs::write(&path, manifest.to_json()?).map_err(|error| Error::io(&path, error))?;
    }
    Ok(decoded)
}

/// Decodes the only stream of a request into a pipe, frame by frame: codes as in PNG files.
///
/// # Errors
/// [`Error::Usage`] where the request has several streams, or one that the format cannot hold.
pub fn decode_to_stream<W: Write>(
    source: &dyn ImageSource,
    decoder: &Decoder,
    Request { streams, filter, memory }: Request<'_>,
    out: &mut PictureStream<W>,
    monitor: &dyn Monitor,
) -> Result<Decoded> {
    let [StreamFrames { stream, frames }] = streams else { return Err(several_streams(decoder, streams)) };
    if out.format() == StreamFormat::Y4m && stream.kind != StreamKind::Color {
        return Err(Error::Usage(format!(
            "Y4M holds colour, and this stream has {}: `stream_format` png or raw keeps its codes",
            stream.kind.name()
        )));
    }
    jobs_at_once(decoder, memory, || Some(memory::stream_bytes(decoder, stream) + memory::file_bytes(stream)))?;
    let coding = FileCoding { format: FileFormat::Png, space: None };
    let writer = ImageWriter::new(stream, coding, decoder.primaries());
    let mut face = source.open(decoder, stream)?;
    let mut clipped_pixels = 0;
    for frame in frames.iter() {
        monitor.check()?;
        let (codes, clipped) = writer.codes(face.decode_filtered(frame, filter)?)?;
        clipped_pixels += clipped;
        out.put(&codes)?;
        monitor.advance(1);
    }
    let summary = DecodeSummary {
        frames: frames.count(),
        pixels: face.selected_pixels(),
        bytes_out: out.bytes,
        cost: face.cost(),
    };
    Ok(Decoded { summary, clipped_pixels, ..Decoded::default() })
}

/// Streams that an error lists at most.
const MOST_LISTED: usize = 24;

fn several_streams(decoder: &Decoder, streams: &[StreamFrames<'_>]) -> Error {
    let name = |StreamFrames { stream, .. }: &StreamFrames<'_>| {
        format!("{} of {} {}", stream.kind.name(), decoder.probe(stream).name, stream.face.name())
    };
    let mut names: Vec<String> = streams.iter().take(MOST_LISTED).map(name).collect();
    if streams.len() > MOST_LISTED {
        names.push(format!("{} more", streams.len() - MOST_LISTED));
    }
    Error::Usage(format!(
        "standard output takes the pictures of one stream, and {} are selected ({}): choose one by `probe`, `face` and `stream`, or name \
         a folder",
        streams.len(),
        names.join(", ")
    ))
}

#[derive(Default)]
struct Written {
    bytes: AtomicU64,
    clipped_pixels: AtomicU64,
}

struct WrittenFile {
    bytes: u64,
    clipped_pixels: u64,
}

/// Between the domain of a codec and that of a file.
enum Table {
    Metres(CodeTable),
    Light(Box<DecodeTable>),
    /// Of half floats in PNG.
    Codes(EncodeTable),
    /// Of 8-bit codes in PNG that are of other primaries.
    Anew(Box<DecodeTable>, EncodeTable),
    None,
}

struct ImageWriter {
    format: FileFormat,
    table: Table,
    /// Of light in files.
    primaries: Primaries,
    /// To them.
    matrix: Option<LightMatrix>,
}

impl ImageWriter {
    fn new(stream: &StreamInfo, coding: FileCoding, own: Primaries) -> ImageWriter {
        let (format, primaries) = (coding.format, coding.primaries(own));
        let matrix = own.conversion_to(primaries);
        let table = match &stream.header {
            CodecHeader::Depth(header) => Table::Metres(CodeTable::new(header.range, header.background)),
            CodecHeader::Color(header) => match header.format {
                ColorFormat::EightBit(tone) if format == FileFormat::Png && matrix.is_some() => {
                    Table::Anew(Box::new(DecodeTable::new(&tone)), EncodeTable::new(&tone))
                }
                ColorFormat::EightBit(tone) => Table::Light(Box::new(DecodeTable::new(&tone))),
                ColorFormat::Half { .. } => Table::Codes(EncodeTable::new(&ToneMap::default())),
            },
            CodecHeader::Material(_) => Table::None,
        };
        ImageWriter { format, table, primaries, matrix }
    }

    /// Writes a file, and its folder where there is none.
    fn write_new(&self, path: &Path, picture: Picture) -> Result<WrittenFile> {
        if let Some(parent) = path.parent() {
            std::fs::create_dir_all(parent).map_err(|error| Error::io(parent, error))?;
        }
        let clipped_pixels = self.write(path, picture).map_err(|error| error.in_file(path))?;
        let bytes = std::fs::metadata(path).map_err(|error| Error::io(path, error))?.len();
        Ok(WrittenFile { bytes, clipped_pixels })
    }

    /// Returns the number of clipped pixels.
    fn write(&self, path: &Path, picture: Picture) -> Result<u64> {
        match (self.format, picture, &self.table) {
            (FileFormat::Png, picture, _) => {
                let (codes, clipped) = self.codes(picture)?;
                let file = File::create(path).map_err(|error| Error::io(path, error))?;
                return codes.encode_png(&mut BufWriter::new(file)).map(|()| clipped);
            }
            (FileFormat::Exr, Picture::Depth(codes), Table::Metres(table)) => {
                exr::write_depth(path, &codes.map(|&code| table.metres(code)))
            }
            (FileFormat::Exr, Picture::Color8(codes), Table::Light(table)) => {
                let light = self.converted(convert::color_light(&codes, table));
                exr::write_color_of(path, &light, self.primaries)
            }
            (FileFormat::Exr, Picture::ColorHalf(light), _) => {
                exr::write_color_of(path, &self.converted(light), self.primaries)
            }
            (FileFormat::Exr, Picture::Material(codes), _) => {
                exr::write_material(path, &convert::material_values(&codes), MATERIAL_CHANNELS)
            }
            // A stream's pictures and its table are of one kind.
            _ => Err(Error::invalid("a picture of another kind than its stream")),
        }
        .map(|()| 0)
    }

    fn converted(&self, light: ColorPlane) -> ColorPlane {
        match self.matrix {
            Some(matrix) => matrix.convert_plane(&light),
            None => light,
        }
    }

    /// A picture in codes, and the number of clipped pixels.
    fn codes(&self, picture: Picture) -> Result<(CodePicture, u64)> {
        let of_light = |light: ColorPlane, table: &EncodeTable| {
            let (codes, clipped) = convert::color_codes(&self.converted(light), table);
            (CodePicture::Rgb8(codes), clipped)
        };
        match (picture, &self.table) {
            (Picture::Color8(codes), Table::Anew(light, table)) => {
                Ok(of_light(convert::color_light(&codes, light), table))
            }
            (Picture::Depth(codes), _) => Ok((CodePicture::Gray16(codes), 0)),
            (Picture::Color8(codes) | Picture::Material(codes), _) => Ok((CodePicture::Rgb8(codes), 0)),
            (Picture::ColorHalf(light), Table::Codes(table)) => Ok(of_light(light, table)),
            _ => Err(Error::invalid("a picture of another kind than its stream")),
        }
    }
}
