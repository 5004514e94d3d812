//! Writes decoded images to EXR or PNG files, with a manifest that makes a folder of them a dataset; or writes the images of one
//! stream to a pipe. Colour and alpha of a face share a file: colour is multiplied by alpha in EXR files, but not in PNG files.

use std::collections::{HashMap, HashSet};
use std::io::{ErrorKind, Write};
use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering};

use serde_json::json;

use crate::dataset::manifest::MANIFEST_NAME;
use crate::export::image_writer::ImageWriter;
use crate::export::manifest::{FileCoding, FileFormat, file_pattern, manifest_of};
use crate::export::report::MissingImagesReport;
use crate::files::{self, DiskFile};
use crate::image_files::picture_stream::{PictureStream, StreamFormat};
use codec::decode::{
    DecodeSummary, Decoded, DecodedPart, Decoder, FrameRanges, ImageSource, Images, MissingImages, Picture, Request,
    StreamFrames, jobs_at_once, memory,
};
use codec::error::{Error, Result};
use codec::image::StreamKind;
use codec::image::sequence::{FrameRange, Pattern};
use codec::monitor::Monitor;
use codec::ordered::try_map_at_once;
use codec::streams::StreamInfo;

#[derive(Debug, Clone)]
pub enum Destination {
    /// Folder that becomes a dataset: image files `probe_NAME/face_FACE/KIND.0000.exr` and a manifest.
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

    /// Removes existing files with the names of missing images; returns the number of files removed.
    pub fn remove_missing(&self, decoder: &Decoder, missing: &[MissingImages], format: FileFormat) -> Result<u64> {
        let mut removed = 0;
        for missing in missing {
            let pattern = self.pattern(decoder, &decoder.streams()[missing.stream as usize], format)?;
            // Without the folder there are no files. Trying to remove each of them would be slow for many frames.
            if pattern.path(0).parent().is_none_or(|folder| !folder.is_dir()) {
                continue;
            }
            for frame in missing.frames.iter().flat_map(|range| range.iter()) {
                let path = pattern.path(frame);
                match files::remove_file(&path) {
                    Ok(()) => removed += 1,
                    Err(error) if error.kind() == ErrorKind::NotFound => {}
                    Err(error) => return Err(Error::io(&path, error)),
                }
            }
        }
        Ok(removed)
    }
}

/// Decodes streams into files. Missing images get no file; `extra` of the manifest lists them.
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
    let jobs = file_jobs(streams);
    let at_once = jobs_at_once(decoder, memory, || jobs.iter().map(|job| job.memory_bytes(decoder)).max())?;
    let parts = try_map_at_once(jobs, at_once, |FileJob { of: StreamFrames { stream, frames }, alpha }| {
        let writer = ImageWriter::new(stream, coding, decoder.primaries());
        let pattern = destination.pattern(decoder, stream, format)?;
        let mut face = source.open(decoder, stream)?;
        let mut alpha_face = alpha.map(|alpha| source.open(decoder, alpha)).transpose()?;
        let mut missing = FrameRanges::default();
        for frame in frames.iter() {
            monitor.check()?;
            let picture = face.decode_intact(frame, filter)?;
            let beside = alpha_face.as_mut().map(|face| face.decode_intact(frame, filter)).transpose()?;
            // A file is written only if all of its channels are intact.
            let written_file = match (picture, &beside) {
                (Some(picture), None) => Some(writer.write_new(&pattern.path(frame), picture, None)?),
                (Some(picture), Some(Some(Picture::Alpha(alpha)))) => {
                    Some(writer.write_new(&pattern.path(frame), picture, Some(alpha))?)
                }
                _ => None,
            };
            match written_file {
                Some(file) => {
                    written.bytes.fetch_add(file.bytes, Ordering::Relaxed);
                    written.clipped_pixels.fetch_add(file.clipped_pixels, Ordering::Relaxed);
                }
                None => missing.push(frame),
            }
            monitor.advance(1 + u64::from(beside.is_some()));
        }
        let part = |stream: &StreamInfo, face: &dyn Images| {
            let (pixels, frames) = (face.selected_pixels(), frames.count() - missing.count());
            let summary = DecodeSummary { frames, pixels, bytes_out: 0, cost: face.cost() };
            DecodedPart { stream: stream.index, summary, damaged: face.damaged(), missing: missing.clone() }
        };
        let beside = alpha.zip(alpha_face).map(|(stream, face)| part(stream, &*face));
        Ok(std::iter::once(part(stream, &*face)).chain(beside).collect::<Vec<_>>())
    })?;
    let mut decoded = Decoded::of(parts.into_iter().flatten().collect());
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
            let list: Vec<_> =
                decoded.missing.iter().map(|missing| MissingImagesReport::new(missing, decoder)).collect();
            manifest.extra.get_or_insert_with(|| json!({}))["missing"] = json!(list);
        }
        let path = folder.join(MANIFEST_NAME);
        let text = manifest.to_json()?;
        let written = DiskFile::create(&path).and_then(|mut file| file.write_all(text.as_bytes()));
        written.map_err(|error| Error::io(&path, error))?;
    }
    Ok(decoded)
}

/// Streams that are written to the same files.
struct FileJob<'a> {
    of: StreamFrames<'a>,
    /// Alpha stream that is written to the files of a colour stream.
    alpha: Option<&'a StreamInfo>,
}

impl FileJob<'_> {
    fn memory_bytes(&self, decoder: &Decoder) -> u64 {
        let of = |stream: &StreamInfo| memory::stream_bytes(decoder, stream) + memory::file_bytes(stream);
        // Linear RGB, held while it is combined with alpha: 6 bytes per pixel.
        let beside = |alpha| of(alpha) + 6 * memory::stream_pixels(alpha);
        of(self.of.stream) + self.alpha.map_or(0, beside)
    }
}

/// Returns the frames of each sequence of files that the streams are written to. Colour and alpha of a face share a sequence.
pub fn file_sequences(streams: &[StreamFrames<'_>]) -> Vec<FrameRange> {
    file_jobs(streams).iter().map(|job| job.of.frames).collect()
}

/// Groups streams by file. Colour is combined with the alpha of its face if both have the same frames.
fn file_jobs<'a>(streams: &[StreamFrames<'a>]) -> Vec<FileJob<'a>> {
    let place = |part: &StreamFrames<'_>| (part.stream.probe, part.stream.face, part.frames.first, part.frames.last);
    let of_kind = |kind| streams.iter().filter(move |part| part.stream.kind == kind);
    let colors: HashSet<_> = of_kind(StreamKind::Color).map(place).collect();
    let alphas: HashMap<_, _> = of_kind(StreamKind::Alpha).map(|part| (place(part), part.stream)).collect();
    let job = |of: &StreamFrames<'a>| {
        let alpha = alphas.get(&place(of)).copied();
        match of.stream.kind {
            StreamKind::Color => Some(FileJob { of: *of, alpha }),
            StreamKind::Alpha if colors.contains(&place(of)) => None,
            _ => Some(FileJob { of: *of, alpha: None }),
        }
    };
    streams.iter().filter_map(job).collect()
}

/// Decodes the only stream of a request to a pipe, frame by frame, as the codes that PNG files contain.
///
/// # Errors
/// [`Error::Usage`] if the request has several streams, or one that the format cannot hold.
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
            "Y4M stores colour only, and this stream has {}: use `stream_format` png or raw",
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

/// Maximum number of streams listed in an error.
const MAX_LISTED: usize = 24;

fn several_streams(decoder: &Decoder, streams: &[StreamFrames<'_>]) -> Error {
    let name = |StreamFrames { stream, .. }: &StreamFrames<'_>| {
        format!("{} of {} {}", stream.kind.name(), decoder.probe(stream).name, stream.face.name())
    };
    let mut names: Vec<String> = streams.iter().take(MAX_LISTED).map(name).collect();
    if streams.len() > MAX_LISTED {
        names.push(format!("{} more", streams.len() - MAX_LISTED));
    }
    Error::Usage(format!(
        "standard output takes the pictures of one stream, and {} are selected ({}): select one with `probe`, `face` \
        and `stream`, or specify a folder",
        streams.len(),
        names.join(", ")
    ))
}

#[derive(Default)]
struct Written {
    bytes: AtomicU64,
    clipped_pixels: AtomicU64,
}
