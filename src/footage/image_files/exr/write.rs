//! Writes OpenEXR files with half or float channels, ZIP compressed.

use std::io::{BufWriter, Cursor, Seek, Write};
use std::path::Path;

use exr::math::Vec2;
use exr::meta::attribute::Chromaticities;
use exr::prelude::{
    AnyChannel, AnyChannels, Compression, Encoding, FlatSamples, Image, Layer, LayerAttributes, LineOrder,
    WritableImage,
};
use half::f16;

use super::errors::translate;
use crate::files::DiskFile;
use codec::error::{Error, Result};
use codec::image::plane::{ColorPlane, DepthPlane, MaterialPlane, Plane};
use codec::image::primaries::Primaries;

/// Writes channels R, G, B as halves, ZIP compressed. The bytes of the file depend only on the pixels.
pub fn write_color(path: &Path, plane: &ColorPlane) -> Result<()> {
    write_color_of(path, plane, Primaries::REC709)
}

/// Writes colour as [`write_color`] does, with `chromaticities` unless the primaries are Rec. 709, the default of the format.
pub fn write_color_of(path: &Path, plane: &ColorPlane, primaries: Primaries) -> Result<()> {
    write(path, plane, (halves(plane, ["R", "G", "B"], |value| value), primaries))
}

/// Writes channels R, G, B and A as halves, ZIP compressed; colour is premultiplied by alpha, as OpenEXR defines it.
pub fn write_rgba(path: &Path, plane: &Plane<[f16; 4]>) -> Result<()> {
    write_rgba_and(path, plane, std::iter::empty(), Primaries::REC709)
}

/// Writes colour as [`write_rgba`] does, with additional float channels of the same size, and `chromaticities` as in
/// [`write_color_of`].
pub fn write_rgba_and<'a>(
    path: &Path,
    plane: &Plane<[f16; 4]>,
    others: impl IntoIterator<Item = (&'a str, &'a Plane<f32>)>,
    primaries: Primaries,
) -> Result<()> {
    let mut channels = halves(plane, ["R", "G", "B", "A"], |value| value);
    channels.extend(others.into_iter().map(|(name, other)| (name, FlatSamples::F32(other.data().to_vec()))));
    write(path, plane, (channels, primaries))
}

/// Writes channel A as halves, ZIP compressed.
pub fn write_alpha(path: &Path, plane: &Plane<f16>) -> Result<()> {
    write(path, plane, (vec![("A", FlatSamples::F16(plane.data().to_vec()))], Primaries::REC709))
}

/// Writes channel Z as 32-bit floats, ZIP compressed.
pub fn write_depth(path: &Path, plane: &DepthPlane) -> Result<()> {
    write(path, plane, (vec![("Z", FlatSamples::F32(plane.data().to_vec()))], Primaries::REC709))
}

/// Writes three channels with the given names as halves, rounded to nearest, ZIP compressed.
pub fn write_material(path: &Path, plane: &MaterialPlane, names: [&str; 3]) -> Result<()> {
    let [a, b, c] = names;
    if a == b || a == c || b == c || names.contains(&"") {
        return Err(Error::Usage(format!("material channels need three different names, not {}", names.join(", "))));
    }
    write(path, plane, (halves(plane, names, f16::from_f32), Primaries::REC709))
}

/// Returns the bytes of a file with channels R, G, B and A as halves, ZIP compressed, and `chromaticities` as in
/// [`write_color_of`].
pub fn rgba_bytes(plane: &Plane<[f16; 4]>, primaries: Primaries) -> Result<Vec<u8>> {
    file_bytes(plane, (halves(plane, ["R", "G", "B", "A"], |value| value), primaries))
}

/// Returns the bytes of a file with three channels as halves, rounded to nearest, ZIP compressed.
pub fn triple_bytes(plane: &Plane<[f32; 3]>, names: [&str; 3]) -> Result<Vec<u8>> {
    file_bytes(plane, (halves(plane, names, f16::from_f32), Primaries::REC709))
}

/// Channels by name, and the primaries of the colour channels.
type Channels<'a> = (Vec<(&'a str, FlatSamples)>, Primaries);

fn file_bytes<T>(plane: &Plane<T>, channels: Channels<'_>) -> Result<Vec<u8>> {
    let mut file = Cursor::new(Vec::new());
    encode(&mut file, plane, channels).map_err(|error| match error {
        exr::error::Error::Io(source) => Error::io("the EXR file", source),
        other => translate(other),
    })?;
    Ok(file.into_inner())
}

fn halves<'a, T: Copy, const N: usize>(
    plane: &Plane<[T; N]>,
    names: [&'a str; N],
    half: fn(T) -> f16,
) -> Vec<(&'a str, FlatSamples)> {
    let samples = |at: usize| FlatSamples::F16(plane.data().iter().map(|pixel| half(pixel[at])).collect());
    names.into_iter().enumerate().map(|(at, name)| (name, samples(at))).collect()
}

fn write<T>(path: &Path, plane: &Plane<T>, channels: Channels<'_>) -> Result<()> {
    if [plane.width(), plane.height()].contains(&0) {
        return Err(Error::invalid("an image without pixels cannot be written").in_file(path));
    }
    let file = DiskFile::create(path).map_err(|error| Error::io(path, error))?;
    let mut writer = BufWriter::new(file);
    encode(&mut writer, plane, channels).map_err(|error| match error {
        exr::error::Error::Io(source) => Error::io(path, source),
        other => translate(other).in_file(path),
    })?;
    writer.flush().map_err(|error| Error::io(path, error))
}

fn encode<T>(
    writer: &mut (impl Write + Seek),
    plane: &Plane<T>,
    (channels, primaries): Channels<'_>,
) -> exr::error::UnitResult {
    let size = (plane.width() as usize, plane.height() as usize);
    let list = channels.into_iter().map(|(name, samples)| AnyChannel::new(name, samples)).collect();
    let (blocks, line_order) = (exr::image::Blocks::ScanLines, LineOrder::Increasing);
    let encoding = Encoding { compression: Compression::ZIP16, blocks, line_order };
    let layer = Layer::new(size, LayerAttributes::default(), encoding, AnyChannels::sort(list));
    let mut image = Image::from_layer(layer);
    if !primaries.is_rec709() {
        let [red, green, blue, white] =
            [primaries.red, primaries.green, primaries.blue, primaries.white].map(|[x, y]| Vec2(x, y));
        image.attributes.chromaticities = Some(Chromaticities { red, green, blue, white });
    }
    image.write().non_parallel().to_buffered(writer)
}
