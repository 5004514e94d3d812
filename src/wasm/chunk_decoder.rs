//! Decodes the frames of one chunk of any stream, in any order.
//!
//! Like [`codec::decode::UnitDecoder`], which finds the chunks in a container.

use codec::color::blend::{self, HalfKey};
use codec::color::cells::{Blend, CellChunk};
use codec::color::transform::Keyed;
use codec::color::{ChunkFormat, ColorChunk};
use codec::container::Payload;
use codec::depth::TemporalChunk;
use codec::depth::predictive::PredictiveChunk;
use codec::error::Result;
use codec::streams::{CodecHeader, ColorFormat, DepthChunk, PictureChunk};

use crate::stream::{ChunkArea, Stream};

/// Result of showing a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shown {
    Frame,
    /// The frame blends into the unit's next chunk, which [`Frames::set_next`] sets.
    NeedsNext,
}

/// The frames of a chunk, counted from its first.
pub trait Frames {
    /// Decodes a frame into [`Frames::picture`].
    fn show(&mut self, frame: u32) -> Result<Shown>;

    /// Parses the unit's next chunk.
    fn set_next(&mut self, _payload: Payload, _area: ChunkArea) -> Result<()> {
        Ok(())
    }

    /// Address and bytes of the picture of the last frame, row by row: 16-bit codes of depth; bytes of alpha; red, green and
    /// blue of material and colour, as bytes or bit patterns of half floats.
    fn picture(&self) -> (*const u8, usize);
}

/// Returns the decoder of a chunk, whose payload is checked here.
pub fn open(stream: &Stream, payload: Payload, area: ChunkArea) -> Result<Box<dyn Frames>> {
    let unit = stream.unit_area(area.unit);
    let pixels = unit.size().iter().map(|&side| side as usize).product();
    let frames = area.frames;
    Ok(match &stream.header {
        CodecHeader::Depth(header) => {
            Box::new(Updates::new(DepthChunk::parse(header, payload, unit, frames)?, pixels, header.window()))
        }
        CodecHeader::Material(header) => {
            let chunk = <TemporalChunk<[u8; 3]> as PictureChunk>::parse(header, payload, unit, frames)?;
            Box::new(Updates::new(chunk, pixels, header.temporal.window))
        }
        CodecHeader::Alpha(header) => {
            let chunk = <PredictiveChunk as PictureChunk>::parse(header, payload, unit, frames)?;
            Box::new(Alpha { updates: Updates::new(chunk, pixels, 1), bytes: vec![0; pixels] })
        }
        CodecHeader::Color(header) => match header.format {
            ColorFormat::EightBit(_) => {
                Box::new(Color::<u8>::parse(header.chunks_of_bytes(unit.size()), payload, area)?)
            }
            ColorFormat::Half { .. } => {
                let color = Color::<HalfKey>::parse(header.chunks_of_halves(unit.size()), payload, area)?;
                Box::new(Half { bits: vec![0; color.picture.len()], color })
            }
        },
    })
}

fn bytes_of<T>(values: &[T]) -> (*const u8, usize) {
    (values.as_ptr().cast(), size_of_val(values))
}

/// Depth, material or alpha: a picture that is updated in place.
struct Updates<C: PictureChunk> {
    chunk: C,
    window: u8,
    picture: Vec<C::Pixel>,
    at: Option<u32>,
}

impl<C: PictureChunk> Updates<C> {
    fn new(chunk: C, pixels: usize, window: u8) -> Self {
        Updates { chunk, window, picture: vec![C::Pixel::default(); pixels], at: None }
    }
}

impl<C: PictureChunk> Frames for Updates<C> {
    fn show(&mut self, frame: u32) -> Result<Shown> {
        // If `advance` fails, the frame shown by the picture is unknown.
        let at = self.at.take();
        self.chunk.advance(&mut self.picture, at, frame, self.window)?;
        self.at = Some(frame);
        Ok(Shown::Frame)
    }

    fn picture(&self) -> (*const u8, usize) {
        bytes_of(&self.picture)
    }
}

struct Alpha {
    updates: Updates<PredictiveChunk>,
    bytes: Vec<u8>,
}

impl Frames for Alpha {
    fn show(&mut self, frame: u32) -> Result<Shown> {
        let shown = self.updates.show(frame)?;
        for (byte, &code) in self.bytes.iter_mut().zip(&self.updates.picture) {
            // Codes above 255 are legal, and mean 255 (depth.md 16).
            *byte = code.min(255) as u8;
        }
        Ok(shown)
    }

    fn picture(&self) -> (*const u8, usize) {
        bytes_of(&self.bytes)
    }
}

/// Colour in either coding.
struct Color<S> {
    format: ChunkFormat<S>,
    chunk: ColorChunk<S>,
    next: Option<CellChunk<S>>,
    picture: Vec<S>,
    at: Option<u32>,
    /// Keyframes by their index in the chunk; that of the next chunk's first follows the last one.
    keyframes: [(Option<usize>, Vec<S>); 2],
}

impl<S: Keyed> Color<S> {
    fn parse(format: ChunkFormat<S>, payload: Payload, area: ChunkArea) -> Result<Self> {
        let chunk = format.parse(payload, area.frames, area.place)?;
        let picture = vec![S::default(); 3 * format.cell.pixels()];
        Ok(Color { format, chunk, next: None, picture, at: None, keyframes: Default::default() })
    }

    /// Loads a keyframe into a slot, by a swap if the other slot holds it.
    fn hold(&mut self, slot: usize, keyframe: usize) {
        if self.keyframes[slot].0 == Some(keyframe) {
            return;
        }
        if self.keyframes[1 - slot].0 == Some(keyframe) {
            self.keyframes.swap(0, 1);
            return;
        }
        let ColorChunk::Cells(chunk) = &self.chunk else { return };
        let (held, samples) = &mut self.keyframes[slot];
        samples.resize(self.picture.len(), S::default());
        match &self.next {
            Some(next) if keyframe == chunk.keyframes.len() => next.read_keyframe(0, samples),
            _ => chunk.read_keyframe(keyframe, samples),
        }
        *held = Some(keyframe);
    }

    fn blend(&mut self, Blend { keyframe, weight }: Blend) {
        self.hold(0, keyframe);
        if weight == 0 {
            self.picture.copy_from_slice(&self.keyframes[0].1);
        } else {
            self.hold(1, keyframe + 1);
            let [(_, a), (_, b)] = &self.keyframes;
            blend::lerp_all(a, b, weight, &mut self.picture);
        }
    }
}

impl<S: Keyed> Frames for Color<S> {
    fn show(&mut self, frame: u32) -> Result<Shown> {
        match &self.chunk {
            ColorChunk::Transform(chunk) => {
                chunk.show(frame as usize, self.at.map(|at| at as usize), &mut self.picture);
            }
            ColorChunk::Cells(chunk) => {
                let blend = chunk.blend(frame);
                if blend.weight > 0 && chunk.is_last(blend.keyframe) && self.next.is_none() {
                    return Ok(Shown::NeedsNext);
                }
                if self.at.is_none_or(|at| chunk.blend(at) != blend) {
                    self.blend(blend);
                }
            }
        }
        self.at = Some(frame);
        Ok(Shown::Frame)
    }

    fn set_next(&mut self, payload: Payload, area: ChunkArea) -> Result<()> {
        self.next = Some(CellChunk::parse_at(payload, self.format.cell, area.frames, area.place)?);
        Ok(())
    }

    fn picture(&self) -> (*const u8, usize) {
        bytes_of(&self.picture)
    }
}

/// Colour of half floats, whose keys become bit patterns.
struct Half {
    color: Color<HalfKey>,
    bits: Vec<u16>,
}

impl Frames for Half {
    fn show(&mut self, frame: u32) -> Result<Shown> {
        let shown = self.color.show(frame)?;
        for (bits, key) in self.bits.iter_mut().zip(&self.color.picture) {
            *bits = key.to_bits();
        }
        Ok(shown)
    }

    fn set_next(&mut self, payload: Payload, area: ChunkArea) -> Result<()> {
        self.color.set_next(payload, area)
    }

    fn picture(&self) -> (*const u8, usize) {
        bytes_of(&self.bits)
    }
}
