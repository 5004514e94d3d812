//! Decodes streams into image files, or into nothing to measure the decoding alone.

mod dataset;

use std::collections::BTreeMap;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

use serde_json::json;

use crate::dataset::manifest;
use crate::dataset::stream::StreamKind;
use crate::decode::damage::{DamagedChunk, FrameRanges, MissingImages};
use crate::decode::decoder::{DecodeCost, Decoder, FaceDecoder, Picture, StreamInfo};
use crate::decode::memory;
use crate::decode::unit_filter::{AllUnits, UnitFilter};
use crate::depth::quantise::CodeTable;
use crate::error::{Error, Result};
use crate::image::cube::Face;
use crate::image::sequence::{FrameRange, Pattern};
use crate::image::transfer::{DecodeTable, EncodeTable, ToneMap};
use crate::image::{exr, png};
use crate::memory::{Budget, Need};
use crate::monitor::Monitor;
use crate::ordered::{try_map_at_once, try_map_at_once_with};
use crate::streams::convert;
use crate::streams::header::{CodecHeader, ColorFormat};
use dataset::{file_pattern, manifest_of};

/// Which streams and frames. Empty lists and `None` mean all.
#[derive(Debug, Clone, Default)]
pub struct Selection {
    /// Names of probes.
    pub probes: Vec<String>,
    /// Faces.
    pub faces: Vec<Face>,
    /// Kinds of streams.
    pub kinds: Vec<StreamKind>,
    /// Frames.
    pub frames: Option<FrameRange>,
}

/// A stream and those of its frames that were asked for.
pub type Chosen<'a> = (&'a StreamInfo, FrameRange);

impl Selection {
    /// The streams that match, with the frames of each that were asked for.
    ///
    /// A probe, face or kind that the container does not have is an error, as is a selection that leaves nothing.
    pub fn choose<'a>(&self, decoder: &'a Decoder) -> Result<Vec<Chosen<'a>>> {
        let name = |stream: &StreamInfo| decoder.probe(stream).name.as_str();
        let has = |test: &dyn Fn(&StreamInfo) -> bool| decoder.streams().iter().any(test);
        let missing =
            |what: String| Err(Error::Usage(format!("{}: there is no {what}", decoder.reader().path().display())));
        if let Some(probe) = self.probes.iter().find(|probe| !has(&|stream| name(stream) == probe.as_str())) {
            return missing(format!("probe '{probe}'"));
        }
        if let Some(face) = self.faces.iter().find(|face| !has(&|stream| stream.face == **face)) {
            return missing(format!("face {}", face.name()));
        }
        if let Some(kind) = self.kinds.iter().find(|kind| !has(&|stream| stream.kind == **kind)) {
            return missing(format!("{} stream", kind.name()));
        }
        if let Some(asked) = self.frames {
            let first = decoder.streams().iter().map(|stream| stream.frames.first).min().unwrap_or(0);
            let last = decoder.streams().iter().map(|stream| stream.frames.last).max().unwrap_or(0);
            if asked.first < first || asked.last > last {
                return missing(format!(
                    "frame {}: its frames are {first}-{last}",
                    if asked.first < first { asked.first } else { asked.last }
                ));
            }
        }
        let wanted = |stream: &&StreamInfo| {
            (self.probes.is_empty() || self.probes.iter().any(|probe| probe == name(stream)))
                && (self.faces.is_empty() || self.faces.contains(&stream.face))
                && (self.kinds.is_empty() || self.kinds.contains(&stream.kind))
        };
        let frames = |stream: &'a StreamInfo| {
            let frames = self.frames.map_or(Some(stream.frames), |frames| stream.frames.intersect(frames));
            frames.map(|frames| (stream, frames))
        };
        let chosen: Vec<_> = decoder.streams().iter().filter(wanted).filter_map(frames).collect();
        if chosen.is_empty() {
            return missing("stream that matches the options".to_owned());
        }
        Ok(chosen)
    }
}

/// What is to be decoded: streams with their frames, and which of their units.
#[derive(Clone, Copy)]
pub struct Request<'a> {
    /// Streams and frames.
    pub chosen: &'a [Chosen<'a>],
    /// Units.
    pub filter: &'a dyn UnitFilter,
    /// Memory that the CPU's decoders may take.
    pub memory: Budget,
}

impl<'a> Request<'a> {
    /// All units of streams and frames.
    pub fn all(chosen: &'a [Chosen<'a>]) -> Request<'a> {
        Request { chosen, filter: &AllUnits, memory: Budget::UNLIMITED }
    }
}

/// What kind of files.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum FileFormat {
    /// OpenEXR: linear light, metres, weights.
    #[default]
    Exr,
    /// PNG: 8-bit colour codes, 16-bit depth codes, 8-bit weights.
    Png,
}

impl FileFormat {
    fn extension(self) -> &'static str {
        match self {
            FileFormat::Exr => "exr",
            FileFormat::Png => "png",
        }
    }
}

/// What decoding did.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct DecodeSummary {
    /// Images decoded.
    pub frames: u64,
    /// Pixels of those of their units that were wanted.
    pub pixels: u64,
    /// Bytes of the pixels that were written, in the codec's domain.
    pub bytes_out: u64,
    /// The rest.
    pub cost: DecodeCost,
}

impl DecodeSummary {
    /// The sum of two.
    #[must_use]
    pub fn plus(self, other: DecodeSummary) -> DecodeSummary {
        DecodeSummary {
            frames: self.frames + other.frames,
            pixels: self.pixels + other.pixels,
            bytes_out: self.bytes_out + other.bytes_out,
            cost: self.cost.plus(other.cost),
        }
    }
}

/// Bytes of a decoded pixel in the codec's domain.
pub fn decoded_pixel_bytes(header: &CodecHeader) -> u64 {
    match header {
        CodecHeader::Depth(_) => 2,
        CodecHeader::Color(header) if matches!(header.format, ColorFormat::Half { .. }) => 6,
        CodecHeader::Color(_) | CodecHeader::Material(_) => 3,
    }
}

/// Stored bytes of all chunks of the frames that were chosen: what decoding all units reads, but for a chunk after the
/// last frame, into which a cell of colour may lead.
pub fn stored_bytes(decoder: &Decoder, chosen: &[Chosen<'_>]) -> u64 {
    let of_stream = |(stream, frames): &Chosen<'_>| {
        let chunks = (0..stream.entry.unit_count())
            .flat_map(|unit| decoder.reader().index().unit_chunks(stream.index, unit))
            .filter(|chunk| {
                let key = &chunk.key;
                let held = FrameRange { first: key.first_frame, last: key.first_frame + (key.frame_count - 1) };
                held.intersect(*frames).is_some()
            });
        chunks.map(|chunk| u64::from(chunk.stored_bytes)).sum::<u64>()
    };
    chosen.iter().map(of_stream).sum()
}

/// What became of images that were asked for.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Decoded {
    /// What was decoded.
    pub summary: DecodeSummary,
    /// Chunks that could not be used, by stream, unit and frame.
    pub damaged: Vec<DamagedChunk>,
    /// Images that these are needed for, by stream.
    pub missing: Vec<MissingImages>,
}

/// What becomes of damaged chunks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum OnDamage {
    /// The first one is an error.
    #[default]
    Stop,
    /// All are listed, and images that need none of them are decoded.
    KeepGoing,
}

/// Decodes what the filter wants of everything chosen, frame by frame, and drops it. The monitor advances by one for
/// every image.
///
/// # Errors
/// Of all damaged chunks, the first.
pub fn decode_to_nothing(decoder: &Decoder, request: Request<'_>, monitor: &dyn Monitor) -> Result<DecodeSummary> {
    Ok(decode_units(decoder, request, OnDamage::Stop, monitor)?.summary)
}

/// As [`decode_to_nothing`], with a choice of what becomes of damaged chunks.
///
/// # Errors
/// The monitor stops the work, or a chunk is damaged and that is to be an error.
pub fn decode_units(
    decoder: &Decoder,
    Request { chosen, filter, memory }: Request<'_>,
    on_damage: OnDamage,
    monitor: &dyn Monitor,
) -> Result<Decoded> {
    let jobs: Vec<_> = chosen
        .iter()
        .flat_map(|&(stream, frames)| (0..stream.entry.unit_count()).map(move |unit| (stream, frames, unit)))
        .collect();
    let each = |(stream, _, unit): &(&StreamInfo, FrameRange, u32)| memory::unit_bytes(decoder, stream, *unit);
    let at_once = at_once(decoder, memory, || jobs.iter().map(each).max())?;
    let units = try_map_at_once_with(jobs, at_once, Vec::new, |spare, (stream, frames, unit)| {
        let mut decoder = decoder.unit_in(stream, unit, std::mem::take(spare));
        let (mut wanted, mut missing) = (0, FrameRanges::default());
        for frame in frames.iter() {
            monitor.check()?;
            if !filter.wants(stream, unit, frame) {
                continue;
            }
            match decoder.decode(frame) {
                Ok(_) => wanted += 1,
                Err(_) if on_damage == OnDamage::KeepGoing && decoder.damaged().len() > 0 => missing.push(frame),
                Err(error) => return Err(error),
            }
        }
        let first = unit == 0;
        if first {
            monitor.advance(frames.count());
        }
        let (cost, unit_pixels, damaged) =
            (decoder.cost(), decoder.pixels(), decoder.damaged().cloned().collect::<Vec<_>>());
        *spare = decoder.into_spare();
        let summary = DecodeSummary {
            frames: if first { frames.count() } else { 0 },
            pixels: wanted * unit_pixels,
            bytes_out: cost.updated_pixels * decoded_pixel_bytes(&stream.header),
            cost,
        };
        Ok((stream.index, summary, damaged, missing))
    })?;
    let mut decoded = Decoded::default();
    let mut frames: BTreeMap<u32, FrameRanges> = BTreeMap::new();
    for (stream, summary, damaged, missing) in units {
        decoded.summary = decoded.summary.plus(summary);
        decoded.damaged.extend(damaged);
        frames.entry(stream).or_default().join(missing);
    }
    decoded.finish(frames);
    // Streams were counted whole.
    decoded.summary.frames -= decoded.missing_images();
    Ok(decoded)
}

/// How many jobs of the size of the largest may run at once.
fn at_once(decoder: &Decoder, memory: Budget, largest: impl FnOnce() -> Option<u64>) -> Result<usize> {
    if memory.bytes().is_none() {
        return Ok(usize::MAX);
    }
    let fixed = memory::container_bytes(decoder.reader());
    let each = largest().unwrap_or(0);
    memory.at_once(&Need { what: "decoding", fixed, each, instead: "" }, rayon::current_num_threads())
}

impl Decoded {
    /// How many images are not there.
    pub fn missing_images(&self) -> u64 {
        self.missing.iter().map(MissingImages::count).sum()
    }

    /// Puts what is damaged in order, and lists the frames of each stream that are missing for it.
    fn finish(&mut self, frames: BTreeMap<u32, FrameRanges>) {
        self.damaged.sort_by_key(|damaged| damaged.chunk.key);
        self.missing = frames.into_iter().filter_map(|(stream, frames)| MissingImages::new(stream, frames)).collect();
    }
}

/// Decodes the images of one stream.
pub trait Images {
    /// The image of a frame, in which units that are not wanted are left out: background where it is depth, else 0.
    ///
    /// # Errors
    /// The stream does not have the frame, a chunk is damaged, or the device that decodes fails.
    fn decode_wanted(&mut self, frame: u32, filter: &dyn UnitFilter) -> Result<Picture>;

    /// As [`Self::decode_wanted`]; none where the image needs a chunk that [`Self::damaged`] lists.
    ///
    /// # Errors
    /// Where this does not list damaged chunks, they are errors.
    fn decode_intact(&mut self, frame: u32, filter: &dyn UnitFilter) -> Result<Option<Picture>> {
        self.decode_wanted(frame, filter).map(Some)
    }

    /// Chunks that could not be used so far.
    fn damaged(&self) -> Vec<DamagedChunk> {
        Vec::new()
    }

    /// Pixels of the units that were wanted, over all frames so far.
    fn wanted_pixels(&self) -> u64;

    /// What decoding cost so far.
    fn cost(&self) -> DecodeCost;
}

/// Where images are decoded.
pub trait ImageSource: Sync {
    /// A decoder of all units of a stream.
    ///
    /// # Errors
    /// The device that decodes has no room for it.
    fn open<'a>(&'a self, decoder: &'a Decoder, stream: &'a StreamInfo) -> Result<Box<dyn Images + 'a>>;
}

/// Images are decoded on the CPU.
#[derive(Debug, Clone, Copy)]
pub struct OnCpu;

impl ImageSource for OnCpu {
    fn open<'a>(&'a self, decoder: &'a Decoder, stream: &'a StreamInfo) -> Result<Box<dyn Images + 'a>> {
        Ok(Box::new(decoder.face(stream)))
    }
}

impl Images for FaceDecoder<'_> {
    fn decode_wanted(&mut self, frame: u32, filter: &dyn UnitFilter) -> Result<Picture> {
        FaceDecoder::decode_wanted(self, frame, filter)
    }

    fn wanted_pixels(&self) -> u64 {
        FaceDecoder::wanted_pixels(self)
    }

    fn cost(&self) -> DecodeCost {
        FaceDecoder::cost(self)
    }
}

/// Images are decoded on the CPU, those that need no damaged chunk.
#[derive(Debug, Clone, Copy)]
pub struct IntactOnCpu;

struct IntactImages<'a>(FaceDecoder<'a>);

impl ImageSource for IntactOnCpu {
    fn open<'a>(&'a self, decoder: &'a Decoder, stream: &'a StreamInfo) -> Result<Box<dyn Images + 'a>> {
        Ok(Box::new(IntactImages(decoder.face(stream))))
    }
}

impl Images for IntactImages<'_> {
    fn decode_wanted(&mut self, frame: u32, filter: &dyn UnitFilter) -> Result<Picture> {
        self.0.decode_wanted(frame, filter)
    }

    fn decode_intact(&mut self, frame: u32, filter: &dyn UnitFilter) -> Result<Option<Picture>> {
        self.0.decode_intact(frame, filter)
    }

    fn damaged(&self) -> Vec<DamagedChunk> {
        self.0.damaged()
    }

    fn wanted_pixels(&self) -> u64 {
        self.0.wanted_pixels()
    }

    fn cost(&self) -> DecodeCost {
        self.0.cost()
    }
}

/// Where images go.
#[derive(Debug, Clone)]
pub enum Destination {
    /// A folder that becomes a dataset: `probe_NAME/face_FACE/KIND.0000.exr` and a manifest.
    Dataset(PathBuf),
    /// Files of one stream, named by a pattern.
    Files(Pattern),
}

impl Destination {
    /// The pattern of a stream's files.
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

    /// Removes files of images that are missing, which something earlier left there under the names that they would have.
    /// Answers how many there were.
    ///
    /// # Errors
    /// Such a file cannot be removed.
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

/// Decodes what the filter wants of everything chosen into files; the rest of an image is background where it is
/// depth, else 0. The monitor advances by one for every image. Of images that are missing there is no file, and the
/// manifest's `extra` tells which those are.
///
/// # Errors
/// A chunk is damaged and `source` does not list it, a file cannot be written, or the monitor stops the work.
pub fn decode_to_files(
    source: &dyn ImageSource,
    decoder: &Decoder,
    Request { chosen, filter, memory }: Request<'_>,
    destination: &Destination,
    format: FileFormat,
    monitor: &dyn Monitor,
) -> Result<Decoded> {
    let written = AtomicU64::new(0);
    let each = |(stream, _): &Chosen<'_>| memory::stream_bytes(decoder, stream) + memory::file_bytes(stream);
    let at_once = at_once(decoder, memory, || chosen.iter().map(each).max())?;
    let streams = try_map_at_once(chosen.to_vec(), at_once, |(stream, frames)| {
        let writer = ImageWriter::new(stream, format);
        let mut face = source.open(decoder, stream)?;
        let mut missing = FrameRanges::default();
        for frame in frames.iter() {
            monitor.check()?;
            let Some(picture) = face.decode_intact(frame, filter)? else {
                missing.push(frame);
                monitor.advance(1);
                continue;
            };
            let path = destination.pattern(decoder, stream, format)?.path(frame);
            if let Some(parent) = path.parent() {
                std::fs::create_dir_all(parent).map_err(|error| Error::io(parent, error))?;
            }
            writer.write(&path, picture).map_err(|error| error.in_file(&path))?;
            let bytes = std::fs::metadata(&path).map_err(|error| Error::io(&path, error))?.len();
            written.fetch_add(bytes, Ordering::Relaxed);
            monitor.advance(1);
        }
        let (pixels, images) = (face.wanted_pixels(), frames.count() - missing.count());
        let summary = DecodeSummary { frames: images, pixels, bytes_out: 0, cost: face.cost() };
        Ok((stream.index, summary, face.damaged(), missing))
    })?;
    let mut decoded = Decoded::default();
    let mut frames: BTreeMap<u32, FrameRanges> = BTreeMap::new();
    for (stream, summary, damaged, missing) in streams {
        decoded.summary = decoded.summary.plus(summary);
        decoded.damaged.extend(damaged);
        frames.insert(stream, missing);
    }
    decoded.finish(frames);
    decoded.summary.bytes_out = written.into_inner();
    if let Destination::Dataset(folder) = destination
        && decoded.summary.frames > 0
        && let Some(mut manifest) = manifest_of(decoder, chosen, format)
    {
        if !decoded.missing.is_empty() {
            let list = decoded.missing.iter().map(|missing| missing_json(decoder, missing)).collect();
            manifest.extra.get_or_insert_with(|| json!({}))["missing"] = serde_json::Value::Array(list);
        }
        let path = folder.join(manifest::MANIFEST_NAME);
        std::fs::write(&path, manifest.to_json()?).map_err(|error| Error::io(&path, error))?;
    }
    Ok(decoded)
}

/// Images that are not there, as a manifest's `extra` and reports tell it.
pub fn missing_json(decoder: &Decoder, missing: &MissingImages) -> serde_json::Value {
    let stream = &decoder.streams()[missing.stream as usize];
    json!({
        "kind": stream.kind.name(),
        "probe": decoder.probe(stream).name,
        "face": stream.face.name(),
        "frames": missing.frames.iter().map(|range| [range.first, range.last]).collect::<Vec<_>>(),
    })
}

/// Turns pictures into files.
struct ImageWriter {
    format: FileFormat,
    depth: Option<CodeTable>,
    light: Option<DecodeTable>,
    /// For half-float colour in PNG.
    codes: Option<EncodeTable>,
}

impl ImageWriter {
    fn new(stream: &StreamInfo, format: FileFormat) -> ImageWriter {
        let (mut depth, mut light, mut codes) = (None, None, None);
        match stream.header {
            CodecHeader::Depth(header) => depth = Some(CodeTable::new(header.range, header.background)),
            CodecHeader::Color(header) => match header.format {
                ColorFormat::EightBit(tone) => light = Some(DecodeTable::new(&tone)),
                ColorFormat::Half { .. } => codes = Some(EncodeTable::new(&ToneMap::default())),
            },
            CodecHeader::Material(_) => {}
        }
        ImageWriter { format, depth, light, codes }
    }

    fn write(&self, path: &Path, picture: Picture) -> Result<()> {
        match (self.format, picture) {
            (FileFormat::Png, Picture::Depth(codes)) => png::write_depth16(path, &codes),
            (FileFormat::Png, Picture::Color8(codes) | Picture::Material(codes)) => png::write_color8(path, &codes),
            (FileFormat::Png, Picture::ColorHalf(light)) => match &self.codes {
                Some(table) => png::write_color8(path, &convert::color_codes(&light, table).0),
                None => Ok(()),
            },
            (FileFormat::Exr, Picture::Depth(codes)) => match &self.depth {
                Some(table) => exr::write_depth(path, &codes.map(|&code| table.metres(code))),
                None => Ok(()),
            },
            (FileFormat::Exr, Picture::Color8(codes)) => match &self.light {
                Some(table) => exr::write_color(path, &convert::color_light(&codes, table)),
                None => Ok(()),
            },
            (FileFormat::Exr, Picture::ColorHalf(light)) => exr::write_color(path, &light),
            (FileFormat::Exr, Picture::Material(codes)) => {
                exr::write_material(path, &convert::material_values(&codes), MATERIAL_CHANNELS)
            }
        }
    }
}

/// Channels of the material files that are written.
const MATERIAL_CHANNELS: [&str; 3] = ["reflect", "refract", "ior"];
