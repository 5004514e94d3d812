//! Images of integer codes: PNG files of 8- and 16-bit colour and integer depth, and JPEG files, which are only read.

use std::io::{BufReader, BufWriter, Write};
use std::path::Path;

use ::image::codecs::jpeg::JpegDecoder;
use ::image::codecs::png::{PngDecoder, PngEncoder};
use ::image::metadata::Orientation;
use ::image::{ColorType, DynamicImage, ExtendedColorType, ImageDecoder, ImageEncoder, ImageError, Limits};
use half::f16;

use super::color_space::ColorSpace;
use crate::files::DiskFile;
use codec::error::{Error, Result};
use codec::image::ReadLimits;
use codec::image::plane::{AlphaPlane, ColorPlane, DepthPlane, Plane};
use codec::image::transfer::{DecodeTable, ToneMap, Transfer, srgb16};

/// Bytes of decoded pixels that are allowed for a file of any size; see [`ReadLimits`].
const PIXEL_FLOOR: u64 = 16 << 20;

/// Reads colour as linear RGB in the primaries of `space`. Gray is repeated in all three components; alpha is ignored.
pub fn read_color(path: &Path, space: ColorSpace, limits: &ReadLimits) -> Result<ColorPlane> {
    let transfer = space.transfer();
    let image = decode(path, limits)?;
    let (width, height) = (image.width(), image.height());
    let deep = image.color().bytes_per_pixel() > image.color().channel_count();
    let data = if deep {
        let srgb = srgb16();
        let value = |code: u16| match transfer {
            Transfer::Srgb => srgb[code as usize],
            Transfer::Linear => f16::from_f64(f64::from(code) / 65535.0),
        };
        image.into_rgb16().pixels().map(|pixel| pixel.0.map(value)).collect()
    } else {
        let table = DecodeTable::new(&ToneMap { transfer, exposure_ev: 0.0 });
        image.into_rgb8().pixels().map(|pixel| pixel.0.map(|code| table.value(code))).collect()
    };
    Plane::new(width, height, data)
}

/// Reads alpha, 0 to 1; for gray images without alpha, reads gray as alpha.
///
/// # Errors
/// Fails if the file has colour and no alpha.
pub fn read_alpha(path: &Path, limits: &ReadLimits) -> Result<AlphaPlane> {
    let image = decode(path, limits)?;
    let (width, height) = (image.width(), image.height());
    let value = |code: u16| f32::from(code) / 65535.0;
    let data = match image.color() {
        color if color.has_alpha() => image.into_rgba16().pixels().map(|pixel| value(pixel.0[3])).collect(),
        color if !color.has_color() => image.into_luma16().pixels().map(|pixel| value(pixel.0[0])).collect(),
        _ => return Err(Error::invalid("this image has no alpha").in_file(path)),
    };
    Plane::new(width, height, data)
}

/// Returns true if the file has an alpha channel.
pub fn has_alpha(path: &Path, limits: &ReadLimits) -> Result<bool> {
    Ok(decode(path, limits)?.color().has_alpha())
}

/// Returns true if the file extension is `png`, ignoring case.
pub fn is_png(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("png"))
}

/// Returns true for the file extensions of images with integer codes: `png`, `jpg` and `jpeg`, ignoring case.
pub fn has_codes(path: &Path) -> bool {
    is_png(path) || is_jpeg(path)
}

/// Returns true if the file extension is `jpg` or `jpeg`, ignoring case.
pub fn is_jpeg(path: &Path) -> bool {
    path.extension().is_some_and(|extension| ["jpg", "jpeg"].iter().any(|jpeg| extension.eq_ignore_ascii_case(jpeg)))
}

/// Reads red, green, blue and alpha as 16-bit codes; 8-bit codes are multiplied by 257. Gray is repeated in all three components;
/// alpha is 65535 for files without alpha.
pub fn read_rgba16(path: &Path, limits: &ReadLimits) -> Result<Plane<[u16; 4]>> {
    let image = decode(path, limits)?;
    let (width, height) = (image.width(), image.height());
    Plane::new(width, height, image.into_rgba16().pixels().map(|pixel| pixel.0).collect())
}

/// Reads red, green, blue and alpha as 8-bit codes; 16-bit codes are rounded to nearest. Gray is repeated in all three
/// components; alpha is 255 for files without alpha.
pub fn read_rgba8(path: &Path, limits: &ReadLimits) -> Result<Plane<[u8; 4]>> {
    let image = decode(path, limits)?;
    let (width, height) = (image.width(), image.height());
    Plane::new(width, height, image.into_rgba8().pixels().map(|pixel| pixel.0).collect())
}

/// Reads depth from an image of 8 or 16 bits, in gray or with three equal channels: code × `scale`, where `scale` is metres per
/// code. Code 0 becomes 0.0; the caller decides whether that is background.
///
/// # Errors
/// Fails if the three channels differ, and for JPEG files, whose compression invents depth between surfaces.
pub fn read_depth(path: &Path, scale: f64, limits: &ReadLimits) -> Result<DepthPlane> {
    if is_jpeg(path) {
        return Err(Error::unsupported("JPEG changes depth: use PNG or EXR files").in_file(path));
    }
    let image = decode(path, limits)?;
    let (width, height) = (image.width(), image.height());
    let metres = |code: u16| (f64::from(code) * scale) as f32;
    let wide = |codes: Vec<u8>| codes.into_iter().map(u16::from).collect::<Vec<u16>>();
    let (codes, channels): (Vec<u16>, usize) = match image {
        DynamicImage::ImageLuma8(codes) => (wide(codes.into_raw()), 1),
        DynamicImage::ImageLuma16(codes) => (codes.into_raw(), 1),
        DynamicImage::ImageRgb8(codes) => (wide(codes.into_raw()), 3),
        DynamicImage::ImageRgb16(codes) => (codes.into_raw(), 3),
        other => {
            let message = format!("depth must be one gray channel of 8 or 16 bits, this image is {:?}", other.color());
            return Err(Error::unsupported(message).in_file(path));
        }
    };
    if let Some(at) = codes.chunks_exact(channels).position(|pixel| pixel.iter().any(|code| *code != pixel[0])) {
        let (x, y) = (at % width as usize, at / width as usize);
        let message = format!("depth must be gray, the channels of this image differ at pixel ({x}, {y})");
        return Err(Error::unsupported(message).in_file(path));
    }
    Plane::new(width, height, codes.into_iter().step_by(channels).map(metres).collect())
}

pub fn read_size(path: &Path, limits: &ReadLimits) -> Result<(u32, u32)> {
    Ok(open(path, limits)?.dimensions())
}

/// Returns true if the file has red, green and blue.
pub fn has_color(path: &Path, limits: &ReadLimits) -> Result<bool> {
    Ok(open(path, limits)?.color_type().has_color())
}

/// Returns the largest code of a channel: 255 or 65535.
pub fn largest_code(path: &Path, limits: &ReadLimits) -> Result<f64> {
    let color = open(path, limits)?.color_type();
    Ok(if color.bytes_per_pixel() > color.channel_count() { 65535.0 } else { 255.0 })
}

/// Returns true if the file has one 16-bit gray channel.
pub fn is_gray16(path: &Path, limits: &ReadLimits) -> Result<bool> {
    Ok(open(path, limits)?.color_type() == ColorType::L16)
}

/// Writes 8-bit R, G, B. The bytes of the file depend only on the pixels.
pub fn write_color8(path: &Path, plane: &Plane<[u8; 3]>) -> Result<()> {
    write(path, plane, plane.data().as_flattened(), ExtendedColorType::Rgb8)
}

pub fn encode_color8(writer: &mut dyn Write, plane: &Plane<[u8; 3]>) -> Result<()> {
    encode(writer, [plane.width(), plane.height()], plane.data().as_flattened(), ExtendedColorType::Rgb8)
}

/// Writes a PNG file of 8-bit R, G, B and alpha to `writer`; colour is not premultiplied by alpha.
pub fn encode_rgba8(writer: &mut dyn Write, plane: &Plane<[u8; 4]>) -> Result<()> {
    encode(writer, [plane.width(), plane.height()], plane.data().as_flattened(), ExtendedColorType::Rgba8)
}

/// Writes 8-bit R, G, B and alpha; colour is not premultiplied by alpha. The bytes of the file depend only on the pixels.
pub fn write_rgba8(path: &Path, plane: &Plane<[u8; 4]>) -> Result<()> {
    write(path, plane, plane.data().as_flattened(), ExtendedColorType::Rgba8)
}

/// Writes codes as 16-bit gray, unchanged. The bytes of the file depend only on the pixels.
pub fn write_depth16(path: &Path, plane: &Plane<u16>) -> Result<()> {
    write(path, plane, &native_bytes(plane), ExtendedColorType::L16)
}

/// Writes a PNG file of 16-bit gray to `writer`.
pub fn encode_depth16(writer: &mut dyn Write, plane: &Plane<u16>) -> Result<()> {
    encode(writer, [plane.width(), plane.height()], &native_bytes(plane), ExtendedColorType::L16)
}

/// Returns the samples in native byte order; the encoder converts them to big-endian.
fn native_bytes(plane: &Plane<u16>) -> Vec<u8> {
    plane.data().iter().flat_map(|code| code.to_ne_bytes()).collect()
}

fn write<T>(path: &Path, plane: &Plane<T>, bytes: &[u8], color: ExtendedColorType) -> Result<()> {
    let size = [plane.width(), plane.height()];
    check_size(size).map_err(|error| error.in_file(path))?;
    let file = DiskFile::create(path).map_err(|error| Error::io(path, error))?;
    encode(&mut BufWriter::new(file), size, bytes, color).map_err(|error| error.in_file(path))
}

fn check_size(size: [u32; 2]) -> Result<()> {
    if size.contains(&0) { Err(Error::invalid("an image without pixels cannot be written")) } else { Ok(()) }
}

fn encode(writer: &mut dyn Write, size: [u32; 2], bytes: &[u8], color: ExtendedColorType) -> Result<()> {
    check_size(size)?;
    let mut out = Watched { writer, failed: None };
    let encoded = PngEncoder::new(&mut out).write_image(bytes, size[0], size[1], color);
    match (out.failed, encoded) {
        (Some(system), _) => Err(Error::io("", system)),
        (None, Err(error)) => Err(translate(error, Path::new(""))),
        (None, Ok(())) => writer.flush().map_err(|error| Error::io("", error)),
    }
}

/// Writer that keeps the error of the operating system. The encoder converts it to another kind, and drops errors of the final
/// bytes.
struct Watched<'a> {
    writer: &'a mut dyn Write,
    failed: Option<std::io::Error>,
}

impl Watched<'_> {
    fn watch<T>(&mut self, done: std::io::Result<T>) -> std::io::Result<T> {
        if let Err(error) = &done
            && error.kind() != std::io::ErrorKind::Interrupted
        {
            self.failed = Some(error.raw_os_error().map_or(error.kind().into(), std::io::Error::from_raw_os_error));
        }
        done
    }
}

impl Write for Watched<'_> {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        let done = self.writer.write(bytes);
        self.watch(done)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        let done = self.writer.flush();
        self.watch(done)
    }
}

fn open(path: &Path, limits: &ReadLimits) -> Result<Box<dyn ImageDecoder>> {
    let file = crate::files::open_regular(path)?;
    let meta = file.metadata().map_err(|error| Error::io(path, error))?;
    if meta.len() == 0 {
        return Err(Error::invalid("this file is empty, where an image was expected").in_file(path));
    }
    let cap = limits.believable(meta.len(), PIXEL_FLOOR);
    let mut decoder_limits = Limits::default();
    decoder_limits.max_alloc = Some(cap);
    let file = BufReader::new(file);
    let mut decoder: Box<dyn ImageDecoder> = if is_jpeg(path) {
        let mut decoder = JpegDecoder::new(file).map_err(|error| translate(error, path))?;
        decoder.set_limits(decoder_limits).map_err(|error| translate(error, path))?;
        Box::new(decoder)
    } else {
        Box::new(PngDecoder::with_limits(file, decoder_limits).map_err(|error| translate(error, path))?)
    };
    if is_jpeg(path) && !matches!(decoder.orientation(), Ok(Orientation::NoTransforms)) {
        let message = "the image is turned by its EXIF orientation: turn its pixels, as with \
                       `mogrify -auto-orient FILE`";
        return Err(Error::unsupported(message).in_file(path));
    }
    if decoder.total_bytes() > cap {
        let message = format!(
            "the header claims {} bytes of pixels, more than a file of {} bytes may ({cap} bytes)",
            decoder.total_bytes(),
            meta.len()
        );
        return Err(Error::invalid(message).in_file(path));
    }
    Ok(decoder)
}

fn decode(path: &Path, limits: &ReadLimits) -> Result<DynamicImage> {
    DynamicImage::from_decoder(open(path, limits)?).map_err(|error| translate(error, path))
}

fn translate(error: ImageError, path: &Path) -> Error {
    match error {
        ImageError::IoError(source) if source.kind() != std::io::ErrorKind::UnexpectedEof => Error::io(path, source),
        ImageError::Unsupported(what) => Error::unsupported(format!("the image cannot be read: {what}")).in_file(path),
        other => Error::invalid(format!("the image is damaged: {other}")).in_file(path),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A writer that fails with `StorageFull` after this number of bytes.
    struct Disk(usize);

    impl Write for Disk {
        fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
            self.0 = self.0.checked_sub(bytes.len()).ok_or(std::io::ErrorKind::StorageFull)?;
            Ok(bytes.len())
        }

        fn flush(&mut self) -> std::io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn a_full_disk_is_the_error_of_the_system() {
        let plane =
            Plane::new(64, 64, (0..64 * 64).map(|at: u32| [at, at * at, at * 31].map(|value| value as u8)).collect());
        let plane = plane.unwrap();
        let mut whole = Vec::new();
        encode_color8(&mut whole, &plane).unwrap();
        for room in (0..whole.len()).step_by(97) {
            match encode_color8(&mut Disk(room), &plane) {
                Err(Error::Io { source, .. }) if source.kind() == std::io::ErrorKind::StorageFull => {}
                other => panic!("with room for {room} of {} bytes: {other:?}", whole.len()),
            }
        }
    }

    #[test]
    fn colour_and_depth_come_back() {
        let folder = tempfile::tempdir().unwrap();
        let limits = ReadLimits::default();
        for (width, height) in [(1, 1), (3, 2), (17, 5)] {
            let path = folder.path().join("c.png");
            let codes = Plane::from_fn(width, height, |x, y| [(x * 50) as u8, (y * 60) as u8, 255]);
            write_color8(&path, &codes).unwrap();
            for (space, transfer) in [(ColorSpace::Srgb, Transfer::Srgb), (ColorSpace::LinearRec709, Transfer::Linear)]
            {
                let read = read_color(&path, space, &limits).unwrap();
                let table = DecodeTable::new(&ToneMap { transfer, exposure_ev: 0.0 });
                assert_eq!(read, codes.map(|pixel| pixel.map(|code| table.value(code))));
            }
            assert_eq!(read_size(&path, &limits).unwrap(), (width, height));
            assert_eq!(read_rgba8(&path, &limits).unwrap(), codes.map(|&[r, g, b]| [r, g, b, 255]));
            assert!(read_depth(&path, 1.0, &limits).is_err(), "colour is not depth");

            let path = folder.path().join("d.png");
            let codes = Plane::from_fn(width, height, |x, y| (x * 3001 + y * 257) as u16);
            write_depth16(&path, &codes).unwrap();
            let read = read_depth(&path, 0.001, &limits).unwrap();
            assert_eq!(read, codes.map(|&code| (f64::from(code) * 0.001) as f32));
            let gray = read_color(&path, ColorSpace::LinearRec709, &limits).unwrap();
            assert_eq!(gray.get(0, 0), [f16::ZERO; 3]);
            let rounded = codes.map(|&code| ((u32::from(code) + 128) / 257) as u8);
            assert_eq!(read_rgba8(&path, &limits).unwrap(), rounded.map(|&code| [code, code, code, 255]));
        }
    }

    #[test]
    fn damage_is_an_error() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("d.png");
        write_depth16(&path, &Plane::from_fn(9, 7, |x, y| (x * y) as u16)).unwrap();
        let good = std::fs::read(&path).unwrap();
        for at in 0..good.len() {
            let mut bad = good.clone();
            bad[at] ^= 0xff;
            std::fs::write(&path, &bad).unwrap();
            // Every chunk has a checksum; only a change after the last byte that is read can pass unnoticed.
            let _ = read_depth(&path, 1.0, &ReadLimits::default());
        }
        std::fs::write(&path, &good[..40]).unwrap();
        let message = read_depth(&path, 1.0, &ReadLimits::default()).unwrap_err().to_string();
        assert!(message.contains("d.png"), "{message}");
        std::fs::write(&path, b"").unwrap();
        let message = read_depth(&path, 1.0, &ReadLimits::default()).unwrap_err().to_string();
        assert!(message.contains("d.png") && message.contains("empty"), "{message}");
        std::fs::write(&path, &good).unwrap();
        assert!(read_depth(&path, 1.0, &ReadLimits { max_image_bytes: 125 }).is_err());
        assert!(write_depth16(&path, &Plane::filled(0, 0, 0)).is_err());
    }
}
