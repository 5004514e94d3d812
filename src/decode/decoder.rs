//! Decodes any (stream, unit, frame) of a container, reading only the chunks that it needs.

use std::collections::BTreeMap;
use std::path::Path;
use std::time::{Duration, Instant};

use half::f16;

use crate::color::blend::{self, HalfKey, Sample};
use crate::color::cells::{CellChunk, CellFormat, LEADS_NOWHERE};
use crate::container::index::ProbeEntry;
use crate::container::{ChunkEntry, ChunkKey, Payload, Reader};
use crate::decode::damage::DamagedChunk;
use crate::decode::unit_filter::{AllUnits, UnitFilter};
use crate::depth::BACKGROUND_CODE;
use crate::error::{Error, Result};
use crate::image::plane::Plane;
use crate::image::sequence::FrameRange;
use crate::ordered::try_map_ordered;
use crate::streams::depth_chunk::DepthChunk;
use crate::streams::header::{CodecHeader, ColorFormat, ColorHeader, DepthHeader, MaterialHeader};
use crate::streams::info;
use crate::streams::material_chunk::MaterialChunk;

pub use crate::streams::info::StreamInfo;

/// An open container whose streams are all understood.
#[derive(Debug)]
pub struct Decoder {
    reader: Reader,
    streams: Vec<StreamInfo>,
}

/// One decoded image, in the domain of its codec.
#[derive(Debug, Clone, PartialEq)]
pub enum Picture {
    /// 16-bit log codes.
    Depth(Plane<u16>),
    /// 8-bit colour.
    Color8(Plane<[u8; 3]>),
    /// Half-float colour.
    ColorHalf(Plane<[f16; 3]>),
    /// 8-bit material.
    Material(Plane<[u8; 3]>),
}

/// What decoding cost.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct DecodeCost {
    /// Pixels that were written.
    pub updated_pixels: u64,
    /// Stored bytes that were read.
    pub bytes_read: u64,
    /// Time for reading chunks, checking CRCs, decompressing and parsing.
    pub fetching: Duration,
    /// Time for writing pixels.
    pub applying: Duration,
}

impl DecodeCost {
    /// The sum of two costs.
    #[must_use]
    pub fn plus(self, other: DecodeCost) -> DecodeCost {
        DecodeCost {
            updated_pixels: self.updated_pixels + other.updated_pixels,
            bytes_read: self.bytes_read + other.bytes_read,
            fetching: self.fetching + other.fetching,
            applying: self.applying + other.applying,
        }
    }
}

impl Decoder {
    /// Opens a container, `-` for standard input.
    pub fn open(path: impl AsRef<Path>) -> Result<Decoder> {
        Self::new(Reader::open(path)?)
    }

    /// Takes an open container; a codec that is not known is an error.
    pub fn new(reader: Reader) -> Result<Decoder> {
        let named = |error: Error| error.in_file(reader.path());
        let streams = info::streams(reader.index()).map_err(named)?;
        info::check_memory(&streams, reader.index(), reader.file_bytes(), reader.limits()).map_err(named)?;
        Ok(Decoder { reader, streams })
    }

    /// All streams.
    pub fn streams(&self) -> &[StreamInfo] {
        &self.streams
    }

    /// The container underneath.
    pub fn reader(&self) -> &Reader {
        &self.reader
    }

    /// As [`Reader::load`].
    pub fn load(&mut self, limit_bytes: u64) -> Result<bool> {
        self.reader.load(limit_bytes)
    }

    /// The probe of a stream.
    pub fn probe(&self, stream: &StreamInfo) -> &ProbeEntry {
        &self.reader.index().probes[stream.probe]
    }

    /// A decoder of one unit (tile or cell).
    pub fn unit<'a>(&'a self, stream: &'a StreamInfo, unit: u32) -> UnitDecoder<'a> {
        self.unit_in(stream, unit, Vec::new())
    }

    /// A decoder of one unit that reads its chunks into `spare`, which [`UnitDecoder::into_spare`] of another gave.
    pub fn unit_in<'a>(&'a self, stream: &'a StreamInfo, unit: u32, spare: Vec<u8>) -> UnitDecoder<'a> {
        let [_, _, width, height] = stream.entry.unit_rect(unit);
        let size = [width, height];
        let state = match stream.header {
            CodecHeader::Depth(header) => State::Depth(TemporalState::new(size, header.window(), header)),
            CodecHeader::Material(header) => State::Material(TemporalState::new(size, header.temporal.window, header)),
            CodecHeader::Color(header @ ColorHeader { format: ColorFormat::EightBit(_), .. }) => {
                State::Color8(CellState::new(header.cell_of_bytes(size)))
            }
            CodecHeader::Color(header) => State::ColorHalf(CellState::new(header.cell_of_halves(size))),
        };
        let chunks = self.reader.index().unit_chunks(stream.index, unit);
        let source =
            ChunkSource { reader: &self.reader, chunks, cost: DecodeCost::default(), spare, damaged: BTreeMap::new() };
        UnitDecoder { source, frames: stream.frames, rect: stream.entry.unit_rect(unit), state }
    }

    /// A decoder of all units of a stream.
    pub fn face<'a>(&'a self, stream: &'a StreamInfo) -> FaceDecoder<'a> {
        let units = (0..stream.entry.unit_count()).map(|unit| self.unit(stream, unit)).collect();
        FaceDecoder { stream, units, wanted_pixels: 0 }
    }
}

/// Fetches the chunks of one unit.
#[derive(Debug)]
struct ChunkSource<'a> {
    reader: &'a Reader,
    chunks: &'a [ChunkEntry],
    cost: DecodeCost,
    /// Memory of a chunk that is no longer needed.
    spare: Vec<u8>,
    /// Chunks that could not be used; they are not read again.
    damaged: BTreeMap<ChunkKey, DamagedChunk>,
}

impl ChunkSource<'_> {
    /// The chunk that holds `frame`, and its index.
    fn find(&self, frame: u32) -> Result<(usize, ChunkEntry)> {
        let at = self.chunks.partition_point(|chunk| chunk.key.first_frame <= frame);
        at.checked_sub(1)
            .map(|at| (at, self.chunks[at]))
            .filter(|(_, chunk)| frame - chunk.key.first_frame < chunk.key.frame_count)
            .ok_or_else(|| Error::invalid(format!("no chunk holds frame {frame}")).in_file(self.reader.path()))
    }

    fn fetch<T>(&mut self, chunk: &ChunkEntry, parse: impl FnOnce(Payload) -> Result<T>) -> Result<T> {
        if let Some(known) = self.damaged.get(&chunk.key) {
            return Err(self.reader.blame(chunk, Error::invalid(known.reason.clone())));
        }
        let start = Instant::now();
        let spare = std::mem::take(&mut self.spare);
        let parsed = match self.reader.load_into(chunk, spare).and_then(parse) {
            Ok(parsed) => parsed,
            Err(error) => return Err(self.condemn(chunk, error)),
        };
        self.cost.fetching += start.elapsed();
        self.cost.bytes_read += u64::from(chunk.stored_bytes);
        Ok(parsed)
    }

    /// Lists a chunk as damaged; answers the error that says so.
    fn condemn(&mut self, chunk: &ChunkEntry, error: Error) -> Error {
        self.damaged.entry(chunk.key).or_insert_with(|| DamagedChunk::new(chunk, &error));
        self.reader.blame(chunk, error)
    }
}

/// Decodes one unit; goes forward cheaply and anywhere at the cost of a seek.
#[derive(Debug)]
pub struct UnitDecoder<'a> {
    source: ChunkSource<'a>,
    frames: FrameRange,
    rect: [u32; 4],
    state: State,
}

#[derive(Debug)]
enum State {
    Depth(TemporalState<DepthChunk>),
    Material(TemporalState<MaterialChunk>),
    Color8(CellState<u8>),
    ColorHalf(CellState<HalfKey>),
}

impl UnitDecoder<'_> {
    /// Shows `frame`; answers how many pixels were written.
    pub fn decode(&mut self, frame: u32) -> Result<u64> {
        if !self.frames.contains(frame) {
            return Err(Error::Usage(format!("frame {frame} is not one of the stream's frames {}", self.frames)));
        }
        let updated = match &mut self.state {
            State::Depth(state) => state.show(&mut self.source, frame)?,
            State::Material(state) => state.show(&mut self.source, frame)?,
            State::Color8(state) => state.show(&mut self.source, frame)?,
            State::ColorHalf(state) => state.show(&mut self.source, frame)?,
        };
        self.source.cost.updated_pixels += updated;
        Ok(updated)
    }

    /// What all calls of [`Self::decode`] cost.
    pub fn cost(&self) -> DecodeCost {
        self.source.cost
    }

    /// The chunks that were needed and could not be used, by frame. What needs none of them is decoded all the same.
    pub fn damaged(&self) -> impl ExactSizeIterator<Item = &DamagedChunk> {
        self.source.damaged.values()
    }

    /// The memory of its last chunk, for another unit.
    pub fn into_spare(self) -> Vec<u8> {
        match self.state {
            State::Depth(state) => state.chunk.map(|(_, chunk)| chunk.into_spare()),
            State::Material(state) => state.chunk.map(|(_, chunk)| chunk.into_spare()),
            State::Color8(state) => state.chunk.map(|(_, chunk)| chunk.into_spare()),
            State::ColorHalf(state) => state.chunk.map(|(_, chunk)| chunk.into_spare()),
        }
        .unwrap_or(self.source.spare)
    }

    /// Its pixels.
    pub fn pixels(&self) -> u64 {
        u64::from(self.rect[2]) * u64::from(self.rect[3])
    }

    /// Left, top, width and height in the face.
    pub fn rect(&self) -> [u32; 4] {
        self.rect
    }

    /// What it shows, row by row; nothing before the first frame was decoded.
    pub fn shown(&self) -> UnitPixels<'_> {
        match &self.state {
            State::Depth(state) => UnitPixels::Depth(&state.picture),
            State::Material(state) => UnitPixels::Material(&state.picture),
            State::Color8(state) => UnitPixels::Color8(state.shown.as_chunks().0),
            State::ColorHalf(state) => UnitPixels::ColorHalf(state.shown.as_chunks().0),
        }
    }

    /// Whether what it shows is known to be right for a frame, without reading or writing anything.
    pub fn shows(&self, frame: u32) -> bool {
        let Ok((index, entry)) = self.source.find(frame) else { return false };
        let target = frame - entry.key.first_frame;
        match &self.state {
            State::Depth(state) => state.shows(index, target),
            State::Material(state) => state.shows(index, target),
            State::Color8(state) => state.shows(index, target),
            State::ColorHalf(state) => state.shows(index, target),
        }
    }

    /// Index and stored bytes of the chunk that holds a frame. What lies between two keyframes of colour may need the next
    /// chunk, too.
    ///
    /// # Errors
    /// When no chunk holds it.
    pub fn chunk_of(&self, frame: u32) -> Result<(usize, u32)> {
        self.source.find(frame).map(|(index, chunk)| (index, chunk.stored_bytes))
    }
}

/// The pixels of a unit, row by row.
#[derive(Debug, Clone, Copy)]
pub enum UnitPixels<'u> {
    /// 16-bit log codes.
    Depth(&'u [u16]),
    /// 8-bit material.
    Material(&'u [[u8; 3]]),
    /// 8-bit colour.
    Color8(&'u [[u8; 3]]),
    /// Half-float colour, as keys.
    ColorHalf(&'u [[HalfKey; 3]]),
}

/// A chunk whose frames are reached by changing a picture.
trait PictureChunk: Sized {
    /// A pixel of the picture.
    type Pixel: Copy + Default;
    /// What parsing needs to know of the stream.
    type Header;

    fn parse(header: &Self::Header, payload: Payload, size: [u32; 2], frames: u32) -> Result<Self>;
    fn advance(&self, picture: &mut [Self::Pixel], at: Option<u32>, target: u32, window: u8) -> u64;
    fn into_spare(self) -> Vec<u8>;
}

impl PictureChunk for DepthChunk {
    type Pixel = u16;
    type Header = DepthHeader;

    fn parse(header: &DepthHeader, payload: Payload, size: [u32; 2], frames: u32) -> Result<Self> {
        DepthChunk::parse(header, payload, size, frames)
    }

    fn advance(&self, picture: &mut [u16], at: Option<u32>, target: u32, window: u8) -> u64 {
        DepthChunk::advance(self, picture, at, target, window)
    }

    fn into_spare(self) -> Vec<u8> {
        DepthChunk::into_spare(self)
    }
}

impl PictureChunk for MaterialChunk {
    type Pixel = [u8; 3];
    type Header = MaterialHeader;

    fn parse(header: &MaterialHeader, payload: Payload, size: [u32; 2], frames: u32) -> Result<Self> {
        MaterialChunk::parse(header, payload, size, frames)
    }

    fn advance(&self, picture: &mut [[u8; 3]], at: Option<u32>, target: u32, window: u8) -> u64 {
        MaterialChunk::advance(self, picture, at, target, window)
    }

    fn into_spare(self) -> Vec<u8> {
        MaterialChunk::into_spare(self)
    }
}

/// A temporally coded unit: the picture shown, and the chunk it came from.
#[derive(Debug)]
struct TemporalState<C: PictureChunk> {
    size: [u32; 2],
    window: u8,
    header: C::Header,
    picture: Vec<C::Pixel>,
    chunk: Option<(usize, C)>,
    /// Frame of the chunk that the picture shows.
    at: Option<u32>,
}

impl<C: PictureChunk> TemporalState<C> {
    fn new(size: [u32; 2], window: u8, header: C::Header) -> Self {
        TemporalState { size, window, header, picture: Vec::new(), chunk: None, at: None }
    }

    fn shows(&self, chunk: usize, target: u32) -> bool {
        self.at == Some(target) && self.chunk.as_ref().is_some_and(|(held, _)| *held == chunk)
    }

    fn show(&mut self, source: &mut ChunkSource<'_>, frame: u32) -> Result<u64> {
        let (index, entry) = source.find(frame)?;
        if self.chunk.as_ref().is_none_or(|(held, _)| *held != index) {
            if let Some((_, old)) = self.chunk.take() {
                source.spare = old.into_spare();
            }
            let (header, size) = (&self.header, self.size);
            let parsed = source.fetch(&entry, |payload| C::parse(header, payload, size, entry.key.frame_count))?;
            self.chunk = Some((index, parsed));
            self.at = None;
        }
        let Some((_, chunk)) = &self.chunk else { return Ok(0) };
        let start = Instant::now();
        if self.picture.is_empty() {
            self.picture.resize(self.size[0] as usize * self.size[1] as usize, C::Pixel::default());
        }
        let target = frame - entry.key.first_frame;
        let updated = chunk.advance(&mut self.picture, self.at, target, self.window);
        self.at = Some(target);
        source.cost.applying += start.elapsed();
        Ok(updated)
    }
}

/// A colour cell: the samples shown, and the two keyframes they lie between.
#[derive(Debug)]
struct CellState<S> {
    format: CellFormat<S>,
    shown: Vec<S>,
    /// Index of the chunk, keyframe in it, weight.
    recipe: Option<(usize, usize, u8)>,
    chunk: Option<(usize, CellChunk<S>)>,
    /// The chunk after it, once its first keyframe was needed.
    next_chunk: Option<(usize, CellChunk<S>)>,
    keyframes: [Keyframe<S>; 2],
}

/// Samples of a keyframe, with the chunk and the index that they are from.
#[derive(Debug, Default)]
struct Keyframe<S> {
    of: Option<(usize, usize)>,
    samples: Vec<S>,
}

impl<S: Sample> CellState<S> {
    fn new(format: CellFormat<S>) -> Self {
        CellState {
            format,
            shown: Vec::new(),
            recipe: None,
            chunk: None,
            next_chunk: None,
            keyframes: Default::default(),
        }
    }

    fn shows(&self, index: usize, target: u32) -> bool {
        self.chunk.as_ref().filter(|(held, _)| *held == index).is_some_and(|(_, chunk)| {
            let made = chunk.blend(target);
            self.recipe == Some((index, made.keyframe, made.weight))
        })
    }

    fn show(&mut self, source: &mut ChunkSource<'_>, frame: u32) -> Result<u64> {
        let (index, entry) = source.find(frame)?;
        self.load(source, index, &entry)?;
        let Some((_, chunk)) = &self.chunk else { return Ok(0) };
        let made = chunk.blend(frame - entry.key.first_frame);
        let recipe = (index, made.keyframe, made.weight);
        if self.recipe == Some(recipe) {
            return Ok(0);
        }
        let next = if chunk.is_last(made.keyframe) { (index + 1, 0) } else { (index, made.keyframe + 1) };
        let start = Instant::now();
        let fetched_before = source.cost.fetching;
        self.hold(source, 0, (index, made.keyframe))?;
        let samples = self.format.pixels() * 3;
        self.shown.resize(samples, S::default());
        if made.weight == 0 {
            self.shown.copy_from_slice(&self.keyframes[0].samples);
        } else {
            self.hold(source, 1, next)?;
            let [a, b] = &self.keyframes;
            blend::lerp_all(&a.samples, &b.samples, made.weight, &mut self.shown);
        }
        self.recipe = Some(recipe);
        source.cost.applying += start.elapsed().saturating_sub(source.cost.fetching - fetched_before);
        Ok(self.format.pixels() as u64)
    }

    fn load(&mut self, source: &mut ChunkSource<'_>, index: usize, entry: &ChunkEntry) -> Result<()> {
        if self.chunk.as_ref().is_none_or(|(held, _)| *held != index) {
            if let Some((_, old)) = self.chunk.take() {
                source.spare = old.into_spare();
            }
            self.chunk = match self.next_chunk.take() {
                Some((held, next)) if held == index => Some((held, next)),
                _ => Some((index, self.parse(source, entry)?)),
            };
        }
        Ok(())
    }

    fn parse(&self, source: &mut ChunkSource<'_>, entry: &ChunkEntry) -> Result<CellChunk<S>> {
        let format = self.format;
        let place = source.reader.index().place(entry);
        source.fetch(entry, |payload| CellChunk::parse_at(payload, format, entry.key.frame_count, place))
    }

    /// Brings a keyframe into a slot, from the other slot where it is there.
    fn hold(&mut self, source: &mut ChunkSource<'_>, slot: usize, of: (usize, usize)) -> Result<()> {
        if self.keyframes[slot].of == Some(of) {
            return Ok(());
        }
        if self.keyframes[1 - slot].of == Some(of) {
            self.keyframes.swap(0, 1);
            return Ok(());
        }
        let (chunk_index, keyframe) = of;
        let holds =
            |chunk: &Option<(usize, CellChunk<S>)>| chunk.as_ref().is_some_and(|(held, _)| *held == chunk_index);
        if !holds(&self.chunk) && !holds(&self.next_chunk) {
            let Some(&entry) = source.chunks.get(chunk_index) else {
                return Err(Error::invalid(LEADS_NOWHERE).in_file(source.reader.path()));
            };
            self.next_chunk = Some((chunk_index, self.parse(source, &entry)?));
        }
        let held = if holds(&self.chunk) { &self.chunk } else { &self.next_chunk };
        let chunk = held.as_ref().map(|(_, chunk)| chunk);
        let target = &mut self.keyframes[slot];
        target.samples.resize(self.format.pixels() * 3, S::default());
        if let Some(chunk) = chunk {
            chunk.read_keyframe(keyframe, &mut target.samples);
        }
        target.of = Some(of);
        Ok(())
    }
}

/// Decodes whole images of one stream, units in parallel.
#[derive(Debug)]
pub struct FaceDecoder<'a> {
    stream: &'a StreamInfo,
    units: Vec<UnitDecoder<'a>>,
    wanted_pixels: u64,
}

impl FaceDecoder<'_> {
    /// The image of a frame.
    pub fn decode(&mut self, frame: u32) -> Result<Picture> {
        self.decode_wanted(frame, &AllUnits)
    }

    /// The image of a frame, in which units that are not wanted are left out: background where it is depth, else 0.
    ///
    /// It does not depend on what was wanted in other frames.
    pub fn decode_wanted(&mut self, frame: u32, filter: &dyn UnitFilter) -> Result<Picture> {
        let stream = self.stream;
        let units = try_map_ordered(wanted(stream, &mut self.units, frame, filter), |unit| {
            unit.decode(frame)?;
            Ok(&*unit)
        })?;
        self.wanted_pixels += units.iter().map(|unit| unit.pixels()).sum::<u64>();
        Ok(picture(stream, &units))
    }

    /// As [`Self::decode_wanted`], but none where a wanted unit needs a damaged chunk, which [`Self::damaged`] then
    /// lists. All units are tried.
    ///
    /// # Errors
    /// The stream does not have the frame.
    pub fn decode_intact(&mut self, frame: u32, filter: &dyn UnitFilter) -> Result<Option<Picture>> {
        let stream = self.stream;
        let units = try_map_ordered(wanted(stream, &mut self.units, frame, filter), |unit| match unit.decode(frame) {
            Err(error) if unit.damaged().len() == 0 => Err(error),
            Err(_) => Ok(None),
            Ok(_) => Ok(Some(&*unit)),
        })?;
        let Some(units) = units.into_iter().collect::<Option<Vec<_>>>() else { return Ok(None) };
        self.wanted_pixels += units.iter().map(|unit| unit.pixels()).sum::<u64>();
        Ok(Some(picture(stream, &units)))
    }

    /// Chunks of all units that could not be used, by unit and frame.
    pub fn damaged(&self) -> Vec<DamagedChunk> {
        let mut damaged: Vec<_> = self.units.iter().flat_map(UnitDecoder::damaged).cloned().collect();
        damaged.sort_by_key(|damaged| damaged.chunk.key);
        damaged
    }

    /// What decoding cost so far.
    pub fn cost(&self) -> DecodeCost {
        self.units.iter().map(UnitDecoder::cost).fold(DecodeCost::default(), DecodeCost::plus)
    }

    /// Pixels of the units that were wanted, over all frames so far.
    pub fn wanted_pixels(&self) -> u64 {
        self.wanted_pixels
    }
}

/// Those of a stream's units that are wanted in a frame.
fn wanted<'d, 'a>(
    stream: &StreamInfo,
    units: &'d mut [UnitDecoder<'a>],
    frame: u32,
    filter: &dyn UnitFilter,
) -> Vec<&'d mut UnitDecoder<'a>> {
    let all = (0..).zip(units);
    all.filter(|(unit, _)| filter.wants(stream, *unit, frame)).map(|(_, unit)| unit).collect()
}

/// The image that units show.
fn picture(stream: &StreamInfo, units: &[&UnitDecoder<'_>]) -> Picture {
    let size = [stream.entry.width, stream.entry.height];
    match stream.header {
        CodecHeader::Depth(_) => Picture::Depth(assemble(size, BACKGROUND_CODE, units, |unit| match unit.shown() {
            UnitPixels::Depth(codes) => codes,
            _ => &[],
        })),
        CodecHeader::Material(_) => Picture::Material(assemble(size, [0; 3], units, |unit| match unit.shown() {
            UnitPixels::Material(codes) => codes,
            _ => &[],
        })),
        CodecHeader::Color(ColorHeader { format: ColorFormat::EightBit(_), .. }) => {
            Picture::Color8(assemble(size, [0; 3], units, |unit| match unit.shown() {
                UnitPixels::Color8(codes) => codes,
                _ => &[],
            }))
        }
        CodecHeader::Color(_) => {
            let black = [HalfKey::from_bits(f16::ZERO.to_bits()); 3];
            let keys = assemble(size, black, units, |unit| match unit.shown() {
                UnitPixels::ColorHalf(keys) => keys,
                _ => &[],
            });
            Picture::ColorHalf(keys.map(|pixel| pixel.map(HalfKey::to_half)))
        }
    }
}

fn assemble<'u, T: Copy + 'u>(
    [width, height]: [u32; 2],
    blank: T,
    units: &[&'u UnitDecoder<'_>],
    pixels: impl Fn(&'u UnitDecoder<'_>) -> &'u [T],
) -> Plane<T> {
    let mut plane = Plane::filled(width, height, blank);
    for unit in units {
        let [left, top, unit_width, _] = unit.rect;
        for (y, row) in pixels(unit).chunks_exact(unit_width as usize).enumerate() {
            plane.row_mut(top + y as u32)[left as usize..(left + unit_width) as usize].copy_from_slice(row);
        }
    }
    plane
}
