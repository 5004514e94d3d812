//! Converts decoded pixels into slices of the caller: codes, metres, 8-bit or floating-point colour, material weights, alpha.

use std::sync::OnceLock;

use half::f16;
use half::slice::HalfFloatSliceExt;

use crate::color::HalfKey;
use crate::depth::CodeTable;
use crate::error::{Error, Result};
use crate::image::transfer::DecodeTable;
use crate::streams::{CodecHeader, ColorFormat, ColorHeader, convert};

/// Pixels of a unit in the domain of its codec, row by row.
#[derive(Debug, Clone, Copy)]
pub enum UnitPixels<'u> {
    /// 16-bit log codes.
    Depth(&'u [u16]),
    Material(&'u [[u8; 3]]),
    Color8(&'u [[u8; 3]]),
    /// Half floats as keys (arithmetic.md 4).
    ColorHalf(&'u [[HalfKey; 3]]),
    /// Codes of 0 to 255.
    Alpha(&'u [u16]),
}

/// Slice of the caller for decoded pixels: one element per pixel, row by row from the top left.
#[derive(Debug)]
pub enum PixelsMut<'p> {
    /// Depth as 16-bit log codes: 0 at near, 65534 at far, 65535 background (depth.md 2).
    DepthCodes(&'p mut [u16]),
    /// Depth in metres. Background pixels have the stream's background value, +inf unless the source had another.
    DepthMetres(&'p mut [f32]),
    /// Colour of an 8-bit stream as codes of its transfer function, red first (color.md 2).
    Color8(&'p mut [[u8; 3]]),
    /// Colour as linear RGB in the primaries of [`Decoder::primaries`](crate::decode::Decoder::primaries), from 8-bit and half-float
    /// streams.
    ColorHalf(&'p mut [[f16; 3]]),
    /// As [`PixelsMut::ColorHalf`], in single precision.
    ColorFloat(&'p mut [[f32; 3]]),
    /// Material as bytes: reflection weight, refraction weight, index of refraction (depth.md 5).
    Material8(&'p mut [[u8; 3]]),
    /// Material as weights of 0 to 1 and an index of refraction of 1 to 3.
    Material(&'p mut [[f32; 3]]),
    /// Alpha as bytes: 255 if surfaces cover the whole pixel (depth.md 16).
    Alpha8(&'p mut [u8]),
    /// Alpha of 0 to 1.
    Alpha(&'p mut [f32]),
}

impl<'p> PixelsMut<'p> {
    /// Splits the slice into parts of `length` pixels; the last part may be shorter.
    pub(super) fn bands(self, length: usize) -> Vec<PixelsMut<'p>> {
        fn split<'a, T>(
            pixels: &'a mut [T],
            length: usize,
            part: fn(&'a mut [T]) -> PixelsMut<'a>,
        ) -> Vec<PixelsMut<'a>> {
            pixels.chunks_mut(length).map(part).collect()
        }
        match self {
            PixelsMut::DepthCodes(pixels) => split(pixels, length, PixelsMut::DepthCodes),
            PixelsMut::DepthMetres(pixels) => split(pixels, length, PixelsMut::DepthMetres),
            PixelsMut::Color8(pixels) => split(pixels, length, PixelsMut::Color8),
            PixelsMut::ColorHalf(pixels) => split(pixels, length, PixelsMut::ColorHalf),
            PixelsMut::ColorFloat(pixels) => split(pixels, length, PixelsMut::ColorFloat),
            PixelsMut::Material8(pixels) => split(pixels, length, PixelsMut::Material8),
            PixelsMut::Material(pixels) => split(pixels, length, PixelsMut::Material),
            PixelsMut::Alpha8(pixels) => split(pixels, length, PixelsMut::Alpha8),
            PixelsMut::Alpha(pixels) => split(pixels, length, PixelsMut::Alpha),
        }
    }

    pub(super) fn check_size(&self, [width, height]: [u32; 2]) -> Result<()> {
        let length = match self {
            PixelsMut::DepthCodes(pixels) => pixels.len(),
            PixelsMut::DepthMetres(pixels) | PixelsMut::Alpha(pixels) => pixels.len(),
            PixelsMut::Alpha8(pixels) => pixels.len(),
            PixelsMut::Color8(pixels) | PixelsMut::Material8(pixels) => pixels.len(),
            PixelsMut::ColorHalf(pixels) => pixels.len(),
            PixelsMut::ColorFloat(pixels) | PixelsMut::Material(pixels) => pixels.len(),
        };
        if length as u64 == u64::from(width) * u64::from(height) {
            return Ok(());
        }
        Err(Error::Usage(format!("a slice of {length} pixels for an image of {width}x{height}")))
    }
}

/// Pixel conversion of one stream. Tables are built on first use.
#[derive(Debug)]
pub(super) struct Conversion {
    pub header: CodecHeader,
    metres: OnceLock<CodeTable>,
    light: OnceLock<DecodeTable>,
    single: OnceLock<Box<[f32; 256]>>,
}

impl Conversion {
    pub fn new(header: CodecHeader) -> Conversion {
        Conversion { header, metres: OnceLock::new(), light: OnceLock::new(), single: OnceLock::new() }
    }

    /// Writes a unit's pixels into a rectangle (left, top, width, height) of an image of `stride` columns.
    pub fn write(&self, unit: UnitPixels<'_>, rect: [u32; 4], target: &mut PixelsMut<'_>, stride: u32) -> Result<()> {
        match (unit, target, &self.header) {
            (UnitPixels::Depth(codes), PixelsMut::DepthCodes(out), _) => rows(codes, rect, out, stride, copy),
            (UnitPixels::Depth(codes), PixelsMut::DepthMetres(out), CodecHeader::Depth(header)) => {
                let table = self.metres.get_or_init(|| CodeTable::new(header.range, header.background));
                rows(codes, rect, out, stride, |row, out| each(row, out, |code| table.metres(code)));
            }
            (UnitPixels::Color8(codes), PixelsMut::Color8(out), _) => rows(codes, rect, out, stride, copy),
            (
                UnitPixels::Color8(codes),
                PixelsMut::ColorHalf(out),
                CodecHeader::Color(ColorHeader { format: ColorFormat::EightBit(tone), .. }),
            ) => {
                let table = self.light.get_or_init(|| DecodeTable::new(tone));
                rows(codes, rect, out, stride, |row, out| samples(row, out, |code| table.value(code)));
            }
            (
                UnitPixels::Color8(codes),
                PixelsMut::ColorFloat(out),
                CodecHeader::Color(ColorHeader { format: ColorFormat::EightBit(tone), .. }),
            ) => {
                let light = self.single.get_or_init(|| {
                    let table = DecodeTable::new(tone);
                    Box::new(std::array::from_fn(|code| table.value(code as u8).to_f32()))
                });
                rows(codes, rect, out, stride, |row, out| samples(row, out, |code| light[usize::from(code)]));
            }
            (UnitPixels::ColorHalf(keys), PixelsMut::ColorHalf(out), _) => {
                rows(keys, rect, out, stride, |row, out| samples(row, out, HalfKey::to_half));
            }
            (UnitPixels::ColorHalf(keys), PixelsMut::ColorFloat(out), _) => rows(keys, rect, out, stride, to_single),
            (UnitPixels::Material(codes), PixelsMut::Material8(out), _) => rows(codes, rect, out, stride, copy),
            (UnitPixels::Material(codes), PixelsMut::Material(out), _) => {
                rows(codes, rect, out, stride, |row, out| each(row, out, |code| convert::material_value(&code)));
            }
            (UnitPixels::Alpha(codes), PixelsMut::Alpha8(out), _) => {
                rows(codes, rect, out, stride, |row, out| each(row, out, convert::alpha_byte));
            }
            (UnitPixels::Alpha(codes), PixelsMut::Alpha(out), _) => {
                rows(codes, rect, out, stride, |row, out| each(row, out, convert::alpha_value));
            }
            _ => {
                let message = "pixels of the stream cannot be converted into a slice of this kind";
                return Err(Error::Usage(message.into()));
            }
        }
        Ok(())
    }
}

/// Converts a unit's pixels row by row into their rectangle of the target.
fn rows<S, T>(source: &[S], rect: [u32; 4], target: &mut [T], stride: u32, convert: impl Fn(&[S], &mut [T])) {
    let [left, top, width, _] = rect.map(|value| value as usize);
    for (y, row) in source.chunks_exact(width).enumerate() {
        let start = (top + y) * stride as usize + left;
        convert(row, &mut target[start..start + width]);
    }
}

fn copy<T: Copy>(row: &[T], out: &mut [T]) {
    out.copy_from_slice(row);
}

fn each<S: Copy, T>(row: &[S], out: &mut [T], convert: impl Fn(S) -> T) {
    for (out, &value) in out.iter_mut().zip(row) {
        *out = convert(value);
    }
}

/// Converts all samples as one flat row, which compiles to vector instructions; a loop over pixels does not.
fn samples<S: Copy, T>(row: &[[S; 3]], out: &mut [[T; 3]], convert: impl Fn(S) -> T) {
    each(row.as_flattened(), out.as_flattened_mut(), convert);
}

fn to_single(row: &[[HalfKey; 3]], out: &mut [[f32; 3]]) {
    const PIXELS: usize = 128;
    let mut half = [[f16::ZERO; 3]; PIXELS];
    for (row, out) in row.chunks(PIXELS).zip(out.chunks_mut(PIXELS)) {
        let half = &mut half[..row.len()];
        samples(row, half, HalfKey::to_half);
        half.as_flattened().convert_to_f32_slice(out.as_flattened_mut());
    }
}
