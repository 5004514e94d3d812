//! Writes a decoded image, or colour with its alpha, to an EXR or PNG file.

use std::io::BufWriter;
use std::path::Path;
use std::sync::OnceLock;

use half::f16;

use crate::export::manifest::{FileCoding, FileFormat};
use crate::files::{DiskFile, create_folders};
use crate::image_files::exr;
use crate::image_files::picture_stream::CodePicture;
use codec::decode::Picture;
use codec::depth::CodeTable;
use codec::error::{Error, Result};
use codec::image::transfer::{DecodeTable, EncodeTable, ToneMap};
use codec::image::{ColorPlane, LightMatrix, Plane, Primaries};
use codec::streams::{CodecHeader, ColorFormat, ColorHeader, StreamInfo, convert};

const MATERIAL_CHANNELS: [&str; 3] = ["reflect", "refract", "ior"];

pub(super) struct WrittenFile {
    pub bytes: u64,
    pub clipped_pixels: u64,
}

/// Conversion table from the domain of a codec to that of a file.
enum Table {
    Metres(CodeTable),
    /// Linear values of 8-bit codes.
    Light(Box<DecodeTable>),
    None,
}

pub(super) struct ImageWriter {
    format: FileFormat,
    table: Table,
    /// Tone mapping of the codes in PNG files.
    tone: ToneMap,
    codes: OnceLock<EncodeTable>,
    /// Primaries of linear RGB in the files.
    primaries: Primaries,
    /// Conversion from the container's primaries to `primaries`; `None` if they are the same.
    matrix: Option<LightMatrix>,
}

impl ImageWriter {
    pub fn new(stream: &StreamInfo, coding: FileCoding, own: Primaries) -> ImageWriter {
        let (format, primaries) = (coding.format, coding.primaries(own));
        let usual = ToneMap::default();
        let (table, tone) = match &stream.header {
            CodecHeader::Depth(header) => (Table::Metres(CodeTable::new(header.range, header.background)), usual),
            CodecHeader::Color(ColorHeader { format: ColorFormat::EightBit(tone), .. }) => {
                (Table::Light(Box::new(DecodeTable::new(tone))), *tone)
            }
            CodecHeader::Color(_) | CodecHeader::Material(_) | CodecHeader::Alpha(_) => (Table::None, usual),
        };
        ImageWriter { format, table, tone, codes: OnceLock::new(), primaries, matrix: own.conversion_to(primaries) }
    }

    fn code_table(&self) -> &EncodeTable {
        self.codes.get_or_init(|| EncodeTable::new(&self.tone))
    }

    /// Writes a file; creates its folder if necessary.
    pub fn write_new(&self, path: &Path, picture: Picture, alpha: Option<&Plane<u8>>) -> Result<WrittenFile> {
        if let Some(parent) = path.parent() {
            create_folders(parent).map_err(|error| Error::io(parent, error))?;
        }
        let clipped_pixels = self.write(path, picture, alpha).map_err(|error| error.in_file(path))?;
        let bytes = std::fs::metadata(path).map_err(|error| Error::io(path, error))?.len();
        Ok(WrittenFile { bytes, clipped_pixels })
    }

    /// Writes a file; returns the number of clipped pixels.
    fn write(&self, path: &Path, picture: Picture, alpha: Option<&Plane<u8>>) -> Result<u64> {
        if self.format == FileFormat::Png {
            let (codes, clipped) = match alpha {
                Some(alpha) => self.codes_and_alpha(picture, alpha)?,
                None => self.codes(picture)?,
            };
            let file = DiskFile::create(path).map_err(|error| Error::io(path, error))?;
            return codes.encode_png(&mut BufWriter::new(file)).map(|()| clipped);
        }
        let half = |code: u8| f16::from_f32(convert::alpha_value(code.into()));
        match (picture, &self.table) {
            (Picture::Depth(codes), Table::Metres(table)) => {
                exr::write_depth(path, &codes.map(|&code| table.metres(code)))
            }
            (Picture::Material(codes), _) => {
                exr::write_material(path, &convert::material_values(&codes), MATERIAL_CHANNELS)
            }
            (Picture::Alpha(codes), _) => exr::write_alpha(path, &codes.map(|&code| half(code))),
            (picture, _) => {
                let light = self.light(picture)?;
                match alpha {
                    Some(alpha) => {
                        let rgba = light.zip(alpha, |[r, g, b], code| [r, g, b, half(code)])?;
                        exr::write_rgba_and(path, &rgba, std::iter::empty(), self.primaries)
                    }
                    None => exr::write_color_of(path, &light, self.primaries),
                }
            }
        }
        .map(|()| 0)
    }

    /// Converts a colour picture to linear RGB in the primaries of the files.
    fn light(&self, picture: Picture) -> Result<ColorPlane> {
        let light = match (picture, &self.table) {
            (Picture::Color8(codes), Table::Light(table)) => convert::color_light(&codes, table),
            (Picture::ColorHalf(light), _) => light,
            // Cannot happen: the pictures of a stream are of the kind of its table.
            _ => return Err(Error::invalid("a picture of another kind than its stream")),
        };
        Ok(match self.matrix {
            Some(matrix) => matrix.convert_plane(&light),
            None => light,
        })
    }

    /// Converts a picture to codes; returns them with the number of clipped pixels.
    pub fn codes(&self, picture: Picture) -> Result<(CodePicture, u64)> {
        match picture {
            Picture::Depth(codes) => Ok((CodePicture::Gray16(codes), 0)),
            Picture::Material(codes) => Ok((CodePicture::Rgb8(codes), 0)),
            Picture::Color8(codes) if self.matrix.is_none() => Ok((CodePicture::Rgb8(codes), 0)),
            Picture::Alpha(codes) => Ok((CodePicture::Gray16(codes.map(|&code| 257 * u16::from(code))), 0)),
            picture => {
                let (codes, clipped) = convert::color_codes(&self.light(picture)?, self.code_table());
                Ok((CodePicture::Rgb8(codes), clipped))
            }
        }
    }

    /// Divides colour by alpha; returns RGBA codes and the number of clipped pixels. A pixel counts as clipped if its colour
    /// exceeds the largest code even after division by an alpha that is half a code larger. This includes pixels of alpha 0,
    /// whose colour is lost.
    fn codes_and_alpha(&self, picture: Picture, alpha: &Plane<u8>) -> Result<(CodePicture, u64)> {
        let (light, table) = (self.light(picture)?, self.code_table());
        let is_lost = |(light, code): &(&[f16; 3], &u8)| {
            let most = 255.0 / (f32::from(**code) + 0.5);
            light.iter().any(|value| table.is_clipped(f16::from_f32(value.to_f32() * most)))
        };
        let clipped = light.data().iter().zip(alpha.data()).filter(is_lost).count() as u64;
        let straight = light.zip(alpha, |light, code| {
            let scale = if code == 0 { 0.0 } else { convert::alpha_value(code.into()).recip() };
            let [r, g, b] = light.map(|value| table.code(f16::from_f32(value.to_f32() * scale)));
            [r, g, b, code]
        })?;
        Ok((CodePicture::Rgba8(straight), clipped))
    }
}
