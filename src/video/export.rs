//! Decodes streams into image files, or into nothing to measure the decoding alone.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

use serde_json::json;

use crate::dataset::manifest::{self, Manifest};
use crate::dataset::stream::StreamKind;
use crate::depth::quantise::CodeTable;
use crate::error::{Error, Result};
use crate::image::cube::Face;
use crate::image::sequence::{FrameRange, Pattern};
use crate::image::transfer::{DecodeTable, EncodeTable, ToneMap, Transfer};
use crate::image::{exr, png};
use crate::monitor::Monitor;
use crate::ordered::{try_map_ordered, try_map_ordered_with};
use crate::video::codec::{CodecHeader, ColorFormat};
use crate::video::convert;
use crate::video::decode::{DecodeCost, Decoder, FaceDecoder, Picture, StreamInfo};
use crate::video::unit_filter::{AllUnits, UnitFilter};

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
}

impl<'a> Request<'a> {
    /// All units of streams and frames.
    pub fn all(chosen: &'a [Chosen<'a>]) -> Request<'a> {
        Request { chosen, filter: &AllUnits }
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

/// Decodes what the filter wants of everything chosen, frame by frame, and drops it. The monitor advances by one for
/// every image.
pub fn decode_to_nothing(
    decoder: &Decoder,
    Request { chosen, filter }: Request<'_>,
    monitor: &dyn Monitor,
) -> Result<DecodeSummary> {
    let jobs: Vec<_> = chosen
        .iter()
        .flat_map(|&(stream, frames)| (0..stream.entry.unit_count()).map(move |unit| (stream, frames, unit)))
        .collect();
    let summaries = try_map_ordered_with(jobs, Vec::new, |spare, (stream, frames, unit)| {
        let mut decoder = decoder.unit_in(stream, unit, std::mem::take(spare));
        let mut wanted = 0;
        for frame in frames.iter() {
            monitor.check()?;
            if filter.wants(stream, unit, frame) {
                decoder.decode(frame)?;
                wanted += 1;
            }
        }
        let first = unit == 0;
        if first {
            monitor.advance(frames.count());
        }
        let (cost, unit_pixels) = (decoder.cost(), decoder.pixels());
        *spare = decoder.into_spare();
        Ok(DecodeSummary {
            frames: if first { frames.count() } else { 0 },
            pixels: wanted * unit_pixels,
            bytes_out: cost.updated_pixels * decoded_pixel_bytes(&stream.header),
            cost,
        })
    })?;
    Ok(summaries.into_iter().fold(DecodeSummary::default(), DecodeSummary::plus))
}

/// Decodes the images of one stream.
pub trait Images {
    /// The image of a frame, in which units that are not wanted are left out: background where it is depth, else 0.
    ///
    /// # Errors
    /// The stream does not have the frame, a chunk is damaged, or the device that decodes fails.
    fn decode_wanted(&mut self, frame: u32, filter: &dyn UnitFilter) -> Result<Picture>;

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

/// Where images go.
#[derive(Debug, Clone)]
pub enum Destination {
    /// A folder that becomes a dataset: `probe_NAME/face_FACE/KIND.0000.exr` and a manifest.
    Dataset(PathBuf),
    /// Files of one stream, named by a pattern.
    Files(Pattern),
}

/// Decodes what the filter wants of everything chosen into files; the rest of an image is background where it is
/// depth, else 0. The monitor advances by one for every image.
pub fn decode_to_files(
    source: &dyn ImageSource,
    decoder: &Decoder,
    Request { chosen, filter }: Request<'_>,
    destination: &Destination,
    format: FileFormat,
    monitor: &dyn Monitor,
) -> Result<DecodeSummary> {
    let written = AtomicU64::new(0);
    let summaries = try_map_ordered(chosen.to_vec(), |(stream, frames)| {
        let writer = ImageWriter::new(stream, format);
        let mut face = source.open(decoder, stream)?;
        for frame in frames.iter() {
            monitor.check()?;
            let path = match destination {
                Destination::Files(pattern) => pattern.path(frame),
                Destination::Dataset(folder) => {
                    let pattern = file_pattern(decoder, stream.kind, format);
                    let probe = &decoder.probe(stream).name;
                    let name = pattern.replace("{probe}", probe).replace("{face}", stream.face.name());
                    Pattern::parse(&name)?.below(folder).path(frame)
                }
            };
            if let Some(parent) = path.parent() {
                std::fs::create_dir_all(parent).map_err(|error| Error::io(parent, error))?;
            }
            writer.write(&path, face.decode_wanted(frame, filter)?).map_err(|error| error.in_file(&path))?;
            let bytes = std::fs::metadata(&path).map_err(|error| Error::io(&path, error))?.len();
            written.fetch_add(bytes, Ordering::Relaxed);
            monitor.advance(1);
        }
        let pixels = face.wanted_pixels();
        Ok(DecodeSummary { frames: frames.count(), pixels, bytes_out: 0, cost: face.cost() })
    })?;
    let mut summary = summaries.into_iter().fold(DecodeSummary::default(), DecodeSummary::plus);
    if let Destination::Dataset(folder) = destination
        && let Some(manifest) = manifest_of(decoder, chosen, format)
    {
        let path = folder.join(manifest::MANIFEST_NAME);
        std::fs::write(&path, manifest.to_json()?).map_err(|error| Error::io(&path, error))?;
    }
    summary.bytes_out = written.into_inner();
    Ok(summary)
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

fn file_pattern(decoder: &Decoder, kind: StreamKind, format: FileFormat) -> String {
    let face = if decoder.reader().index().projection == 0 { "/face_{face}" } else { "" };
    format!("probe_{{probe}}{face}/{}.%04d.{}", kind.name(), format.extension())
}

/// The manifest of what was decoded, so that the folder is a dataset again. `extra` tells how the streams were coded,
/// so that a later comparison can use the same codes. None where PNG files hold codes that a manifest cannot explain,
/// where streams differ in size, or where faces of a cube are no squares.
fn manifest_of(decoder: &Decoder, chosen: &[Chosen<'_>], format: FileFormat) -> Option<Manifest> {
    let index = decoder.reader().index();
    let (first, _) = chosen.first()?;
    let size = [first.entry.width, first.entry.height];
    let cube = index.projection == 0;
    if chosen.iter().any(|(stream, _)| [stream.entry.width, stream.entry.height] != size) || cube && size[0] != size[1]
    {
        return None;
    }
    let mut files = manifest::Files::default();
    let (mut depth, mut color, mut material) = (None, None, None);
    let mut coding = serde_json::Map::new();
    let mut ranges = serde_json::Map::new();
    for (stream, _) in chosen {
        let pattern = Some(file_pattern(decoder, stream.kind, format));
        match (stream.header, format) {
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
                let srgb = header.format == ColorFormat::EightBit(ToneMap::default());
                coding.insert("color".into(), color_coding(&header.format, stream.entry.unit_width));
                let space = match format {
                    FileFormat::Exr => manifest::ManifestColorSpace::LinearRec709,
                    FileFormat::Png if srgb => manifest::ManifestColorSpace::Srgb,
                    FileFormat::Png => continue,
                };
                files.color = pattern;
                color = Some(manifest::ColorInfo { space });
            }
            (CodecHeader::Material(_), FileFormat::Exr) => {
                files.material = pattern;
                material = Some(manifest::MaterialInfo { channels: manifest::MaterialChannels::default() });
            }
            (CodecHeader::Material(_), FileFormat::Png) => {}
        }
    }
    if files == manifest::Files::default() {
        return None;
    }
    if !ranges.is_empty() {
        coding.insert("depth".into(), ranges.into());
    }
    let frames = chosen.iter().map(|(_, frames)| *frames);
    let all = frames.reduce(|a, b| FrameRange { first: a.first.min(b.first), last: a.last.max(b.last) })?;
    let present: Vec<Face> =
        Face::CUBE.into_iter().filter(|face| chosen.iter().any(|(s, _)| s.face == *face)).collect();
    let mut probes = Vec::new();
    for (at, probe) in index.probes.iter().enumerate() {
        let of = chosen.iter().filter(|(stream, _)| stream.probe == at).map(|(_, frames)| *frames);
        let Some(frames) = of.reduce(|a, b| FrameRange { first: a.first.min(b.first), last: a.last.max(b.last) })
        else {
            continue;
        };
        let known = probe.intrinsics.iter().any(|&value| value != 0.0);
        probes.push(manifest::Probe {
            name: probe.name.clone(),
            position: probe.position,
            frames: (frames != all).then_some([frames.first, frames.last]),
            orientation: (probe.orientation != [0.0, 0.0, 0.0, 1.0]).then_some(probe.orientation),
            fov_y_deg: None,
            intrinsics: known.then_some(probe.intrinsics),
            extra: None,
        });
    }
    Some(Manifest {
        lightfield: manifest::MANIFEST_VERSION,
        name: if index.name.is_empty() { "unnamed".to_owned() } else { index.name.clone() },
        fps: index.fps,
        frames: [all.first, all.last],
        projection: if cube {
            crate::dataset::stream::Projection::Cubemap
        } else {
            crate::dataset::stream::Projection::Perspective
        },
        size,
        faces: cube.then_some(manifest::FaceFiles::Six),
        faces_present: (cube && present.len() < 6).then(|| present.iter().map(|face| face.name().to_owned()).collect()),
        depth,
        color,
        material,
        files,
        probes,
        extra: Some(json!({ "lightfold": coding })),
    })
}

fn color_coding(format: &ColorFormat, cell: u32) -> serde_json::Value {
    match format {
        ColorFormat::EightBit(tone) => json!({
            "format": "8bit",
            "transfer": if tone.transfer == Transfer::Srgb { "srgb" } else { "linear" },
            "exposure_ev": tone.exposure_ev,
            "cell": cell,
        }),
        ColorFormat::Half { white_cd_m2 } => json!({ "format": "half", "white_cd_m2": white_cd_m2, "cell": cell }),
    }
}
