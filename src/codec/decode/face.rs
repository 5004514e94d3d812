//! Decodes whole images of one stream, with its units in parallel.

use half::f16;

use crate::container::Reader;
use crate::decode::chunk_source::DecodeCost;
use crate::decode::damage::DamagedChunk;
use crate::decode::pixels::{Conversion, PixelsMut};
use crate::decode::unit::UnitDecoder;
use crate::depth::BACKGROUND_CODE;
#[cfg(doc)]
use crate::error::Error;
use crate::error::Result;
use crate::image::plane::Plane;
use crate::ordered::try_map_ordered;
use crate::streams::{CodecHeader, ColorFormat, ColorHeader, StreamInfo};

/// One decoded image, in the domain of its codec.
#[derive(Debug, Clone, PartialEq)]
pub enum Picture {
    Depth(Plane<u16>),
    Color8(Plane<[u8; 3]>),
    ColorHalf(Plane<[f16; 3]>),
    Material(Plane<[u8; 3]>),
    /// 0 to 255.
    Alpha(Plane<u8>),
}

/// Selects the tiles and cells to decode, frame by frame (CALF 6.2).
pub trait UnitFilter: Sync {
    fn wants(&self, stream: &StreamInfo, unit: u32, frame: u32) -> bool;
}

#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct AllUnits;

impl UnitFilter for AllUnits {
    fn wants(&self, _stream: &StreamInfo, _unit: u32, _frame: u32) -> bool {
        true
    }
}

/// Decodes whole images of one stream: all tiles or cells of a face, in parallel.
///
/// Frames may be decoded in any order; ascending order is fastest. Memory: one picture and one chunk per unit.
#[derive(Debug)]
pub struct FaceDecoder<'a> {
    stream: &'a StreamInfo,
    units: Vec<UnitDecoder<'a>>,
    conversion: &'a Conversion,
    selected_pixels: u64,
}

impl<'a> FaceDecoder<'a> {
    pub(super) fn new(of @ (_, conversion): (&'a Reader, &'a Conversion), stream: &'a StreamInfo) -> FaceDecoder<'a> {
        let units = (0..stream.entry.unit_count()).map(|unit| UnitDecoder::new(of, stream, unit, Vec::new()));
        FaceDecoder { stream, units: units.collect(), conversion, selected_pixels: 0 }
    }

    /// Decodes a frame into a slice of width × height pixels.
    ///
    /// # Errors
    /// [`Error::Usage`] for a frame that the stream does not have, a slice of the wrong length, or a kind of pixels to which the
    /// stream cannot be converted; [`Error::Invalid`] for a damaged chunk, which the message names. Some pixels may already have
    /// been written.
    pub fn decode_into(&mut self, frame: u32, pixels: PixelsMut<'_>) -> Result<()> {
        let size @ [width, _] = self.stream.size();
        pixels.check_size(size)?;
        let entry = &self.stream.entry;
        let [columns, _] = entry.grid();
        let bands = pixels.bands(width as usize * entry.unit_height as usize);
        let bands: Vec<_> = self.units.chunks_mut(columns as usize).zip(bands).collect();
        // With fewer rows of units than threads, the units of a row are decoded in parallel too.
        let are_few = bands.len() < rayon::current_num_threads();
        try_map_ordered(bands, |(units, mut pixels): (&mut [UnitDecoder<'a>], PixelsMut<'_>)| {
            if are_few {
                try_map_ordered(units.iter_mut().collect(), |unit: &mut UnitDecoder<'a>| unit.decode(frame))?;
            }
            // `decode` does nothing for a unit that already shows the frame. Pixels are converted right after decoding, while
            // they are in the cache.
            units.iter_mut().try_for_each(|unit| {
                unit.decode(frame)?;
                let [left, _, columns, rows] = unit.rect();
                self.conversion.write(unit.pixels(), [left, 0, columns, rows], &mut pixels, width)
            })
        })?;
        Ok(())
    }

    #[doc(hidden)]
    pub fn decode(&mut self, frame: u32) -> Result<Picture> {
        self.decode_filtered(frame, &AllUnits)
    }

    /// Decodes the image of a frame. Units rejected by the filter are background in depth and 0 in other kinds, regardless of the
    /// frames decoded before.
    #[doc(hidden)]
    pub fn decode_filtered(&mut self, frame: u32, filter: &dyn UnitFilter) -> Result<Picture> {
        let stream = self.stream;
        let units = try_map_ordered(select(stream, &mut self.units, frame, filter), |unit| {
            unit.decode(frame)?;
            Ok(&*unit)
        })?;
        self.selected_pixels += units.iter().map(|unit| unit.pixel_count()).sum::<u64>();
        picture(self.conversion, stream, &units)
    }

    /// As [`Self::decode_filtered`], but returns `None` if a selected unit needs a damaged chunk, which [`Self::damaged`] then
    /// lists. All selected units are decoded, also after such a failure.
    ///
    /// # Errors
    /// Fails if the stream does not have the frame.
    #[doc(hidden)]
    pub fn decode_intact(&mut self, frame: u32, filter: &dyn UnitFilter) -> Result<Option<Picture>> {
        let stream = self.stream;
        let units = try_map_ordered(select(stream, &mut self.units, frame, filter), |unit| match unit.decode(frame) {
            Err(error) if unit.damaged().len() == 0 => Err(error),
            Err(_) => Ok(None),
            Ok(_) => Ok(Some(&*unit)),
        })?;
        let Some(units) = units.into_iter().collect::<Option<Vec<_>>>() else { return Ok(None) };
        self.selected_pixels += units.iter().map(|unit| unit.pixel_count()).sum::<u64>();
        picture(self.conversion, stream, &units).map(Some)
    }

    #[doc(hidden)]
    pub fn damaged(&self) -> Vec<DamagedChunk> {
        let mut damaged: Vec<_> = self.units.iter().flat_map(UnitDecoder::damaged).cloned().collect();
        damaged.sort_by_key(|damaged| damaged.chunk.key);
        damaged
    }

    /// Returns the total cost of all calls so far.
    pub fn cost(&self) -> DecodeCost {
        self.units.iter().map(UnitDecoder::cost).fold(DecodeCost::default(), |sum, cost| sum + cost)
    }

    #[doc(hidden)]
    pub fn selected_pixels(&self) -> u64 {
        self.selected_pixels
    }
}

fn select<'d, 'a>(
    stream: &StreamInfo,
    units: &'d mut [UnitDecoder<'a>],
    frame: u32,
    filter: &dyn UnitFilter,
) -> Vec<&'d mut UnitDecoder<'a>> {
    let all = (0..).zip(units);
    all.filter(|(unit, _)| filter.wants(stream, *unit, frame)).map(|(_, unit)| unit).collect()
}

fn picture(conversion: &Conversion, stream: &StreamInfo, units: &[&UnitDecoder<'_>]) -> Result<Picture> {
    let [width, height] = stream.size();
    let fill = |mut target: PixelsMut<'_>| {
        units.iter().try_for_each(|unit| conversion.write(unit.pixels(), unit.rect(), &mut target, width))
    };
    Ok(match &stream.header {
        CodecHeader::Depth(_) => {
            let mut plane = Plane::filled(width, height, BACKGROUND_CODE);
            fill(PixelsMut::DepthCodes(plane.data_mut()))?;
            Picture::Depth(plane)
        }
        CodecHeader::Material(_) => {
            let mut plane = Plane::filled(width, height, [0; 3]);
            fill(PixelsMut::Material8(plane.data_mut()))?;
            Picture::Material(plane)
        }
        CodecHeader::Alpha(_) => {
            let mut plane = Plane::filled(width, height, 0);
            fill(PixelsMut::Alpha8(plane.data_mut()))?;
            Picture::Alpha(plane)
        }
        CodecHeader::Color(ColorHeader { format: ColorFormat::EightBit(_), .. }) => {
            let mut plane = Plane::filled(width, height, [0; 3]);
            fill(PixelsMut::Color8(plane.data_mut()))?;
            Picture::Color8(plane)
        }
        CodecHeader::Color(_) => {
            let mut plane = Plane::filled(width, height, [f16::ZERO; 3]);
            fill(PixelsMut::ColorHalf(plane.data_mut()))?;
            Picture::ColorHalf(plane)
        }
    })
}
