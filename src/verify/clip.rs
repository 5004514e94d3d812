//! Streams of one unit: encoding, and decoding from a container.

use codec::container::{
    ChunkKey, Compression, EncodedChunk, PackedChunk, PayloadKind, ProbeEntry, Reader, StreamEntry, Writer,
};
use codec::decode::{Decoder, Picture};
use codec::depth::block_chunk::encoder::BlockEncoder;
use codec::depth::block_tiles::Layout;
use codec::depth::block_tiles::encode::EncodeTexel;
use codec::depth::domain::Domain;
use codec::depth::mode_decision::Decide;
use codec::depth::node_encoder::{NodeEncoder, NodeSettings};
use codec::depth::nodes::Grid;
use codec::depth::predictive::encoder::PredictiveEncoder;
use codec::depth::predictive::projection::{Projection, Shape};
use codec::depth::predictive::{Levels, PredictiveHeader, Tables, UnitArea};
use codec::depth::tree_chunk::encoder::TreeEncoder;
use codec::depth::{DepthRange, TemporalEncoder, TemporalSettings, Texel};
use codec::effort::Effort;
use codec::error::{Error, Result};
use codec::image::DepthKind;
use codec::math::random::Random;
use codec::streams::{CodecHeader, DepthCoding, DepthHeader, MaterialHeader, NodeHeader};

/// Effort of all searches. Bounds hold at every effort; this one is the fastest.
pub(super) const EFFORT: Effort = Effort::Fast;

/// An encoded stream of one unit.
#[derive(Debug, Clone)]
pub struct Clip {
    pub what: String,
    pub header: CodecHeader,
    pub size: [u32; 2],
    pub frame_count: u32,
    pub(super) chunks: Vec<EncodedChunk>,
}

#[derive(Debug, Clone)]
pub(super) struct Sequence<T> {
    pub size: [u32; 2],
    pub frames: Vec<Vec<T>>,
}

/// Returns a random generator that depends only on frame and position.
pub(super) fn random_at([frame, x, y]: [u32; 3]) -> Random {
    Random::new(u64::from(frame) << 40 | u64::from(x) << 20 | u64::from(y))
}

/// Returns a number below `n` that depends only on frame and position.
pub(super) fn noise(at: [u32; 3], n: u32) -> u32 {
    random_at(at).below(n)
}

/// Depth range of streams for which metres do not matter.
pub(super) fn any_range() -> Result<DepthRange> {
    DepthRange::new(0.5, 900.0)
}

fn depth_header(range: DepthRange, coding: DepthCoding) -> CodecHeader {
    CodecHeader::Depth(DepthHeader { range, background: f32::INFINITY, kind: DepthKind::Distance, coding })
}

fn boxes<T: EncodeTexel>(source: &Sequence<T>, settings: TemporalSettings, of: Layout) -> Result<Vec<EncodedChunk>> {
    settings.check()?;
    match of {
        Layout::Values => held(source, TemporalEncoder::new(source.size[0], settings)),
        Layout::BlockTiles => held(source, TemporalEncoder::in_blocks(source.size, settings, EFFORT)),
    }
}

fn held<T: Texel>(source: &Sequence<T>, mut encoder: TemporalEncoder<T>) -> Result<Vec<EncodedChunk>> {
    source.encode(|frame| match frame {
        Some(frame) => encoder.push(frame),
        None => encoder.finish(),
    })
}

impl Clip {
    pub(super) fn new<T>(
        what: impl Into<String>,
        header: CodecHeader,
        source: &Sequence<T>,
        chunks: Vec<EncodedChunk>,
    ) -> Clip {
        Clip { what: what.into(), header, size: source.size, frame_count: source.frames.len() as u32, chunks }
    }

    /// Encodes packed nodes (`DQPN`) in a domain.
    pub(super) fn nodes(
        source: &Sequence<u16>,
        (range, domain): (DepthRange, &Domain),
        settings: NodeSettings,
    ) -> Result<Clip> {
        settings.check()?;
        let mut encoder = NodeEncoder::new(source.grid(), domain.clone(), settings);
        let chunks = source.encode(|frame| match frame {
            Some(frame) => encoder.push(frame, None),
            None => encoder.finish(),
        })?;
        let header = depth_header(range, DepthCoding::Nodes(node_header(domain, settings)));
        Ok(Clip::new(format!("{} domain, {:?}", domain.kind().name(), settings.decide), header, source, chunks))
    }

    /// Encodes the quadtree itself (`DQTR`), which is lossless.
    pub(super) fn tree(source: &Sequence<u16>, settings: NodeSettings) -> Result<Clip> {
        let settings = NodeSettings { window: 1, epsilon: 0, ..settings };
        let mut encoder = TreeEncoder::new(source.grid(), Domain::log(), settings);
        let chunks = source.encode(|frame| match frame {
            Some(frame) => encoder.push(frame),
            None => encoder.finish(),
        })?;
        let header = depth_header(any_range()?, DepthCoding::Tree(node_header(&Domain::log(), settings)));
        Ok(Clip::new("DQTR", header, source, chunks))
    }

    pub(super) fn blocks(source: &Sequence<u16>, effort: Effort, interval: u32) -> Result<Clip> {
        let mut encoder = BlockEncoder::new(source.grid(), effort, interval);
        let chunks = source.encode(|frame| {
            Ok(match frame {
                Some(frame) => encoder.push(frame),
                None => encoder.finish(),
            })
        })?;
        Ok(Clip::new(format!("{effort:?}"), depth_header(any_range()?, DepthCoding::Blocks), source, chunks))
    }

    /// Encodes predictive depth (`DPRD`) with a projection of the given shape.
    pub(super) fn predictive(
        source: &Sequence<u16>,
        (bound, epsilon, keyframe_interval): (u16, u16, u32),
        shape: Shape,
        decide: Decide,
    ) -> Result<Clip> {
        let projection = Projection::new(shape, any_range()?);
        let (tables, levels) = (Tables::default(), Levels::default());
        let header = PredictiveHeader { bound, epsilon, keyframe_interval, projection, tables, levels };
        Clip::predicted(format!("{shape:?}, {decide:?}"), source, header, decide)
    }

    /// Encodes predictive depth whose codes are the given levels or background.
    pub(super) fn levels(source: &Sequence<u16>, codes: Vec<u16>, decide: Decide) -> Result<Clip> {
        let header = PredictiveHeader {
            bound: 0,
            epsilon: 0,
            keyframe_interval: 64,
            projection: Projection::default(),
            tables: Tables::default(),
            levels: Levels::new(codes)?,
        };
        Clip::predicted(format!("{decide:?}"), source, header, decide)
    }

    fn predicted(what: String, source: &Sequence<u16>, header: PredictiveHeader, decide: Decide) -> Result<Clip> {
        let mut encoder = PredictiveEncoder::new(&header, UnitArea::whole(source.size), decide, EFFORT)?;
        let chunks = source.encode(|frame| match frame {
            Some(frame) => {
                let numbers = header.levels.numbers(frame);
                let numbers =
                    numbers.map_err(|at| Error::invalid(format!("pixel {at} has a code that is no level")))?;
                Ok(encoder.push(&numbers))
            }
            None => Ok(encoder.finish()),
        })?;
        let header = depth_header(any_range()?, DepthCoding::Predictive(header));
        Ok(Clip::new(what, header, source, chunks))
    }

    /// Encodes codes in boxes (`DAAB`, `DAB5`).
    pub(super) fn codes(source: &Sequence<u16>, settings: TemporalSettings, of: Layout) -> Result<Clip> {
        let (what, coding) = match of {
            Layout::Values => ("DAAB", DepthCoding::Boxes(settings)),
            Layout::BlockTiles => ("DAB5", DepthCoding::BoxesInBlocks(settings)),
        };
        Ok(Clip::new(what, depth_header(any_range()?, coding), source, boxes(source, settings, of)?))
    }

    /// Encodes material in boxes (`MAAB`, `MAB1`).
    pub(super) fn material(source: &Sequence<[u8; 3]>, temporal: TemporalSettings, of: Layout) -> Result<Clip> {
        let in_blocks = of == Layout::BlockTiles;
        let header = CodecHeader::Material(MaterialHeader { temporal, in_blocks });
        Ok(Clip::new(if in_blocks { "MAB1" } else { "MAAB" }, header, source, boxes(source, temporal, of)?))
    }

    pub fn pixels(&self) -> u64 {
        u64::from(self.size[0]) * u64::from(self.size[1]) * u64::from(self.frame_count)
    }

    pub(super) fn show(&self, mut see: impl FnMut(usize, &Picture) -> Result<()>) -> Result<()> {
        let decoder = open(std::slice::from_ref(self))?;
        let stream = decoder.streams().first().ok_or_else(|| Error::invalid("a container without its stream"))?;
        let mut face = decoder.face(stream);
        (0..self.frame_count).try_for_each(|frame| see(frame as usize, &face.decode(frame)?))
    }

    /// Maximum number of frames that one decoder step may advance.
    pub(super) fn window(&self) -> u32 {
        match &self.header {
            CodecHeader::Depth(header) => u32::from(header.window()),
            CodecHeader::Material(header) => u32::from(header.temporal.window),
            CodecHeader::Color(_) | CodecHeader::Alpha(_) => 1,
        }
    }
}

impl<T> Sequence<T> {
    pub(super) fn new(size: [u32; 2], frames: u32, pixel: impl Fn(u32, u32, u32) -> T) -> Sequence<T> {
        let [width, height] = size;
        let frame = |frame| (0..width * height).map(|at| pixel(frame, at % width, at / width)).collect();
        Sequence { size, frames: (0..frames).map(frame).collect() }
    }

    /// Returns the chunks that `code` returns for the frames and, after the last frame, for `None`.
    pub(super) fn encode(
        &self,
        mut code: impl FnMut(Option<&Vec<T>>) -> Result<Option<EncodedChunk>>,
    ) -> Result<Vec<EncodedChunk>> {
        self.frames.iter().map(Some).chain([None]).filter_map(|frame| code(frame).transpose()).collect()
    }
}

impl Sequence<u16> {
    pub(super) fn grid(&self) -> Grid {
        Grid { width: self.size[0], height: self.size[1] }
    }
}

fn node_header(domain: &Domain, settings: NodeSettings) -> NodeHeader {
    let NodeSettings { window, epsilon, keyframe_interval, bound, .. } = settings;
    NodeHeader { window, epsilon, keyframe_interval, bound, domain: domain.parts }
}

/// Writes a container with one probe per clip and opens it.
pub(super) fn open(clips: &[Clip]) -> Result<Decoder> {
    let mut writer = Writer::new(Vec::new(), "hard cases", 24.0, 0)?;
    for (at, clip) in clips.iter().enumerate() {
        let probe = writer.add_probe(ProbeEntry {
            name: format!("{at}"),
            position: [0.0; 3],
            orientation: [0.0, 0.0, 0.0, 1.0],
            frames: [0, clip.frame_count - 1],
            intrinsics: [0.0; 4],
        })?;
        let [width, height] = clip.size;
        // Units coded in blocks have sides of whole blocks and are cropped at the edge of the image.
        let unit = |side: u32| if clip.header.in_blocks() { side.next_multiple_of(4) } else { side };
        writer.add_stream(StreamEntry {
            kind: clip.header.kind() as u8,
            face: 0,
            probe,
            codec: clip.header.codec(),
            width,
            height,
            first_frame: 0,
            frame_count: clip.frame_count,
            unit_width: unit(width),
            unit_height: unit(height),
            codec_header: clip.header.write().into(),
        });
    }
    for (stream, clip) in (0u32..).zip(clips) {
        for EncodedChunk { first_frame, frame_count, payload } in &clip.chunks {
            let key = ChunkKey { stream, unit: 0, first_frame: *first_frame, frame_count: *frame_count };
            writer.push(&PackedChunk::new(key, payload.clone(), (Compression::None, PayloadKind::Mixed))?)?;
        }
    }
    Decoder::new(Reader::from_memory(writer.finish()?.0)?)
}
