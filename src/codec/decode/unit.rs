//! Decodes one tile or cell, with frames in any order.
//!
//! A tile that shows an earlier frame of the chunk applies only the records in between, in steps of up to W frames; otherwise it
//! starts at the chunk's keyframe (depth.md 4). Cells are decoded by [`crate::decode::cell`] or [`crate::decode::transform`].

use std::time::Instant;

use crate::color::HalfKey;
use crate::container::Reader;
use crate::decode::cell::CellState;
use crate::decode::chunk_source::{ChunkSource, DecodeCost};
use crate::decode::damage::DamagedChunk;
use crate::decode::pixels::{Conversion, PixelsMut, UnitPixels};
use crate::decode::transform::TransformState;
use crate::depth::TemporalChunk;
use crate::depth::predictive::{PredictiveChunk, UnitArea};
use crate::error::{Error, Result};
use crate::image::sequence::FrameRange;
use crate::streams::{CodecHeader, ColorCoding, ColorFormat, DepthChunk, PictureChunk, StreamInfo};

/// Decodes one unit: a tile of depth, material or alpha, or a cell of colour.
///
/// Decoding a later frame of the current chunk processes only the changes up to it. For any other frame the chunk is read if
/// necessary and decoded from its keyframe.
#[derive(Debug)]
pub struct UnitDecoder<'a> {
    source: ChunkSource<'a>,
    frames: FrameRange,
    rect: [u32; 4],
    state: State,
    conversion: &'a Conversion,
}

#[derive(Debug)]
enum State {
    Depth(TemporalState<DepthChunk>),
    Material(TemporalState<TemporalChunk<[u8; 3]>>),
    Alpha(TemporalState<PredictiveChunk>),
    Color8(CellState<u8>),
    ColorHalf(CellState<HalfKey>),
    Transform8(TransformState<u8>),
    TransformHalf(TransformState<HalfKey>),
}

macro_rules! with_state {
    ($state:expr, $bound:ident => $body:expr) => {
        match $state {
            State::Depth($bound) => $body,
            State::Material($bound) => $body,
            State::Alpha($bound) => $body,
            State::Color8($bound) => $body,
            State::ColorHalf($bound) => $body,
            State::Transform8($bound) => $body,
            State::TransformHalf($bound) => $body,
        }
    };
}

impl<'a> UnitDecoder<'a> {
    pub(super) fn new(
        (reader, conversion): (&'a Reader, &'a Conversion),
        stream: &StreamInfo,
        unit: u32,
        buffer: Vec<u8>,
    ) -> UnitDecoder<'a> {
        let rect @ [_, _, width, height] = stream.entry.unit_rect(unit);
        let (size, area) = ([width, height], stream.unit_area(unit));
        let state = match &stream.header {
            CodecHeader::Depth(header) => State::Depth(TemporalState::new(area, header.window(), header.clone())),
            CodecHeader::Material(header) => State::Material(TemporalState::new(area, header.temporal.window, *header)),
            CodecHeader::Alpha(header) => State::Alpha(TemporalState::new(area, 1, *header)),
            CodecHeader::Color(header) => match (header.format, &header.coding) {
                (ColorFormat::EightBit(_), ColorCoding::Cells(_)) => {
                    State::Color8(CellState::new(header.cell_of_bytes(size)))
                }
                (ColorFormat::Half { .. }, ColorCoding::Cells(_)) => {
                    State::ColorHalf(CellState::new(header.cell_of_halves(size)))
                }
                (ColorFormat::EightBit(_), ColorCoding::Transform(_)) => {
                    State::Transform8(TransformState::new(header.chunks_of_bytes(size)))
                }
                (ColorFormat::Half { .. }, ColorCoding::Transform(_)) => {
                    State::TransformHalf(TransformState::new(header.chunks_of_halves(size)))
                }
            },
        };
        let source = ChunkSource::new(reader, reader.index().unit_chunks(stream.index, unit), buffer);
        UnitDecoder { source, frames: stream.frames, rect, state, conversion }
    }

    /// Decodes `frame` into [`Self::pixels`]; returns the number of pixels written.
    ///
    /// # Errors
    /// [`Error::Usage`] for a frame that the stream does not have; [`Error::Invalid`] for a damaged chunk.
    pub fn decode(&mut self, frame: u32) -> Result<u64> {
        if !self.frames.contains(frame) {
            return Err(Error::Usage(format!("frame {frame} is not one of the stream's frames {}", self.frames)));
        }
        let updated = with_state!(&mut self.state, state => state.show(&mut self.source, frame)?);
        self.source.cost.updated_pixels += updated;
        Ok(updated)
    }

    /// Decodes `frame` into a slice of width × height pixels of the unit.
    ///
    /// # Errors
    /// As for [`Self::decode`]; [`Error::Usage`] for a slice of the wrong length, or of a kind to which the stream cannot be
    /// converted.
    pub fn decode_into(&mut self, frame: u32, mut pixels: PixelsMut<'_>) -> Result<()> {
        let [_, _, width, height] = self.rect;
        pixels.check_size([width, height])?;
        self.decode(frame)?;
        self.conversion.write(self.pixels(), [0, 0, width, height], &mut pixels, width)
    }

    /// Returns the total cost of all calls so far.
    pub fn cost(&self) -> DecodeCost {
        self.source.cost
    }

    /// Returns the damaged chunks found so far, in the order of their frames. Frames that need none of them can still be decoded.
    #[doc(hidden)]
    pub fn damaged(&self) -> impl ExactSizeIterator<Item = &DamagedChunk> {
        self.source.damaged.values()
    }

    #[doc(hidden)]
    pub fn into_buffer(self) -> Vec<u8> {
        with_state!(self.state, state => state.chunk.map(|(_, chunk)| chunk.into_spare())).unwrap_or(self.source.buffer)
    }

    /// Drops the decoding state but keeps the pixels. The next frame is decoded from the keyframe of its chunk.
    #[doc(hidden)]
    pub fn forget(&mut self) {
        with_state!(&mut self.state, state => state.forget());
        self.source.buffer = Vec::new();
    }

    #[doc(hidden)]
    pub fn pixel_count(&self) -> u64 {
        u64::from(self.rect[2]) * u64::from(self.rect[3])
    }

    /// Returns left, top, width and height of the unit in the image, in pixels.
    pub fn rect(&self) -> [u32; 4] {
        self.rect
    }

    /// Returns the pixels of the last decoded frame, row by row; empty before the first.
    #[doc(hidden)]
    pub fn pixels(&self) -> UnitPixels<'_> {
        match &self.state {
            State::Depth(state) => UnitPixels::Depth(&state.picture),
            State::Material(state) => UnitPixels::Material(&state.picture),
            State::Alpha(state) => UnitPixels::Alpha(&state.picture),
            State::Color8(state) => UnitPixels::Color8(state.shown.as_chunks().0),
            State::ColorHalf(state) => UnitPixels::ColorHalf(state.shown.as_chunks().0),
            State::Transform8(state) => UnitPixels::Color8(state.picture.as_chunks().0),
            State::TransformHalf(state) => UnitPixels::ColorHalf(state.picture.as_chunks().0),
        }
    }

    /// Returns true if [`Self::pixels`] are known to show `frame`; reads no chunk.
    #[doc(hidden)]
    pub fn shows(&self, frame: u32) -> bool {
        let Ok((index, entry)) = self.source.find(frame) else { return false };
        let target = frame - entry.key.first_frame;
        with_state!(&self.state, state => state.shows(index, target))
    }

    /// Returns index and stored bytes of the chunk that holds a frame. A colour frame between two keyframes may need the next
    /// chunk too.
    #[doc(hidden)]
    pub fn chunk_of(&self, frame: u32) -> Result<(usize, u32)> {
        self.source.find(frame).map(|(index, chunk)| (index, chunk.stored_bytes))
    }
}

#[derive(Debug)]
struct TemporalState<C: PictureChunk> {
    area: UnitArea,
    window: u8,
    header: C::Header,
    picture: Vec<C::Pixel>,
    chunk: Option<(usize, C)>,
    /// Frame shown by `picture`, counted from the chunk's first; `None` if unknown.
    at: Option<u32>,
}

impl<C: PictureChunk> TemporalState<C> {
    fn new(area: UnitArea, window: u8, header: C::Header) -> Self {
        TemporalState { area, window, header, picture: Vec::new(), chunk: None, at: None }
    }

    fn forget(&mut self) {
        (self.chunk, self.at) = (None, None);
    }

    fn shows(&self, chunk: usize, target: u32) -> bool {
        self.at == Some(target) && self.chunk.as_ref().is_some_and(|(held, _)| *held == chunk)
    }

    fn show(&mut self, source: &mut ChunkSource<'_>, frame: u32) -> Result<u64> {
        let (index, entry) = source.find(frame)?;
        if self.chunk.as_ref().is_none_or(|(held, _)| *held != index) {
            if let Some((_, old)) = self.chunk.take() {
                source.buffer = old.into_spare();
            }
            let (header, area) = (&self.header, self.area);
            let parsed = source.fetch(&entry, |payload| C::parse(header, payload, area, entry.key.frame_count))?;
            self.chunk = Some((index, parsed));
            self.at = None;
        }
        let Some((_, chunk)) = &mut self.chunk else { return Ok(0) };
        let start = Instant::now();
        if self.picture.is_empty() {
            let [width, height] = self.area.size();
            self.picture.resize(width as usize * height as usize, C::Pixel::default());
        }
        let target = frame - entry.key.first_frame;
        // If `advance` fails, the frame shown by the picture is unknown.
        let at = self.at.take();
        let updated = chunk.advance(&mut self.picture, at, target, self.window);
        let updated = updated.map_err(|error| source.damage(&entry, error))?;
        self.at = Some(target);
        source.cost.applying += start.elapsed();
        Ok(updated)
    }
}
