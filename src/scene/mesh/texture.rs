//! Textures: 8-bit sRGB images with alpha, decoded from image files and sampled bilinearly in linear light.

use std::io::Cursor;
use std::sync::LazyLock;

use ::image::codecs::png::PngEncoder;
use ::image::{DynamicImage, ExtendedColorType, ImageDecoder, ImageEncoder, ImageFormat, ImageReader, Limits};
use glam::{DVec2, DVec3, DVec4};

use super::budget::Budget;
use super::ktx2;
use codec::error::{Error, Result};
use codec::image::{ReadLimits, Transfer};

/// Bytes of pixels that an image file of any size may claim; see [`ReadLimits`].
const PIXEL_FLOOR: u64 = 64 << 20;

/// Formats of textures. TGA has no signature: it is recognised by its header.
const FORMATS: [ImageFormat; 5] =
    [ImageFormat::Png, ImageFormat::Jpeg, ImageFormat::Bmp, ImageFormat::Tga, ImageFormat::WebP];

/// True for the header of a TGA image: the kind of its colour map, of its pixels, and their bits.
fn is_tga(bytes: &[u8]) -> bool {
    bytes.len() > 18
        && matches!(bytes[1], 0 | 1)
        && matches!(bytes[2], 1..=3 | 9..=11)
        && matches!(bytes[16], 8 | 15 | 16 | 24 | 32)
}

/// Handling of texture coordinates outside 0..1.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, PartialOrd, Ord)]
pub enum Wrap {
    #[default]
    Repeat,
    Mirror,
    Clamp,
}

/// An image of 8-bit sRGB codes and alpha, of at least one pixel.
#[derive(Debug, Clone)]
pub struct ImageTexture {
    pub width: u32,
    pub height: u32,
    /// Red, green and blue as sRGB codes, and alpha; row by row from the top.
    pub pixels: Vec<[u8; 4]>,
    /// Horizontal and vertical wrap mode.
    pub wrap: [Wrap; 2],
}

/// Linear value of each sRGB code, 0..=1.
static LINEAR: LazyLock<[f64; 256]> =
    LazyLock::new(|| std::array::from_fn(|code| Transfer::Srgb.decode(code as f64 / 255.0)));

impl Wrap {
    /// Returns the two pixels around a coordinate along a side of `size` pixels, and the weight of the second.
    fn neighbours(self, at: f64, size: u32) -> (usize, usize, f64) {
        let side = f64::from(size);
        // Moved near the image first, so that integers cannot overflow.
        let at = if at.is_finite() { at } else { 0.0 };
        let near = match self {
            Wrap::Repeat => at - at.floor(),
            Wrap::Mirror => at.rem_euclid(2.0),
            Wrap::Clamp => at.clamp(0.0, 1.0),
        };
        let place = near * side - 0.5;
        let left = place.floor();
        let pixel = |at: f64| -> usize {
            let at = at as i64;
            let size = i64::from(size);
            let index = match self {
                Wrap::Repeat => at.rem_euclid(size),
                Wrap::Mirror => {
                    let folded = at.rem_euclid(2 * size);
                    folded.min(2 * size - 1 - folded)
                }
                Wrap::Clamp => at.clamp(0, size - 1),
            };
            index as usize
        };
        (pixel(left), pixel(left + 1.0), place - left)
    }
}

impl ImageTexture {
    /// Decodes a PNG, JPEG, BMP, TGA, WebP or KTX2 image. 16-bit samples are reduced to 8 bits; grey becomes three equal channels.
    pub fn decode(bytes: &[u8], wrap: [Wrap; 2], budget: &mut Budget) -> Result<ImageTexture> {
        let cap = ReadLimits::default().believable(bytes.len() as u64, PIXEL_FLOOR);
        if ktx2::is_ktx2(bytes) {
            let ([width, height], pixels) = ktx2::decode(bytes, cap, budget)?;
            return Ok(ImageTexture { width, height, pixels, wrap });
        }
        let format = ::image::guess_format(bytes).ok().filter(|format| FORMATS.contains(format));
        let format = format.or_else(|| is_tga(bytes).then_some(ImageFormat::Tga));
        let format = format.ok_or_else(|| Error::unsupported("this is no PNG, JPEG, BMP, TGA, WebP or KTX2 image"))?;
        let damaged = |error: ::image::ImageError| Error::invalid(format!("the image is damaged: {error}"));
        let mut limits = Limits::default();
        limits.max_alloc = Some(cap);
        let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
        reader.limits(limits);
        let decoder = reader.into_decoder().map_err(damaged)?;
        let (width, height) = decoder.dimensions();
        let pixels = u64::from(width) * u64::from(height);
        if decoder.total_bytes().max(4 * pixels) > cap {
            let claims = format!("the image claims {width}x{height} pixels");
            return Err(Error::invalid(format!("{claims}, more than its {} bytes can hold", bytes.len())));
        }
        if pixels == 0 {
            return Err(Error::invalid("the image has no pixels"));
        }
        // Memory of the pixels as stored in the file, and as decoded.
        budget.take(pixels, 8, "an image")?;
        let image = DynamicImage::from_decoder(decoder).map_err(damaged)?.into_rgba8();
        Ok(ImageTexture { width, height, pixels: image.as_chunks::<4>().0.to_vec(), wrap })
    }

    /// Encodes the image as a PNG file.
    pub fn png(&self) -> Result<Vec<u8>> {
        let ImageTexture { width, height, pixels, .. } = self;
        if pixels.len() as u64 != u64::from(*width) * u64::from(*height) {
            return Err(Error::invalid(format!("{} pixels for an image of {width}x{height}", pixels.len())));
        }
        let mut png = Vec::new();
        PngEncoder::new(&mut png)
            .write_image(pixels.as_flattened(), *width, *height, ExtendedColorType::Rgba8)
            .map_err(|error| Error::invalid(format!("an image cannot be written as PNG: {error}")))?;
        Ok(png)
    }

    /// Returns the bilinear colour and alpha at texture coordinates, with (0, 0) at the top left corner. Coordinates that are not
    /// finite count as 0.
    pub fn sample(&self, uv: DVec2) -> (DVec3, f64) {
        let (left, right, along) = self.wrap[0].neighbours(uv.x, self.width);
        let (top, bottom, down) = self.wrap[1].neighbours(uv.y, self.height);
        let table = &*LINEAR;
        let pixel = |x: usize, y: usize| {
            let [r, g, b, a] = self.pixels[y * self.width as usize + x];
            DVec4::new(table[r as usize], table[g as usize], table[b as usize], f64::from(a) / 255.0)
        };
        let between = |one: DVec4, other: DVec4, at: f64| one + at * (other - one);
        let upper = between(pixel(left, top), pixel(right, top), along);
        let lower = between(pixel(left, bottom), pixel(right, bottom), along);
        let mixed = between(upper, lower, down);
        (mixed.truncate(), mixed.w)
    }

    /// Returns means over all pixels: of the linear colour, and of the codes as 0..=1, for images that hold data instead of
    /// colours.
    pub fn means(&self) -> [DVec3; 2] {
        let mut counts = [[0u64; 256]; 3];
        for pixel in &self.pixels {
            for (counts, &code) in counts.iter_mut().zip(pixel) {
                counts[code as usize] += 1;
            }
        }
        let pixels = self.pixels.len().max(1) as f64;
        let light = |counts: [u64; 256]| counts.iter().zip(&*LINEAR).map(|(&count, light)| count as f64 * light).sum();
        let codes = |counts: [u64; 256]| (0..).zip(counts).map(|(code, count)| code * count).sum::<u64>() as f64;
        [DVec3::from_array(counts.map(light)) / pixels, DVec3::from_array(counts.map(codes)) / (255.0 * pixels)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texture(wrap: Wrap) -> ImageTexture {
        let pixels = vec![[0, 0, 0, 0], [255, 255, 255, 255], [255, 0, 0, 255], [128, 128, 128, 51]];
        ImageTexture { width: 2, height: 2, pixels, wrap: [wrap; 2] }
    }

    #[test]
    fn files_of_all_formats_are_decoded() {
        let pixels = [[200, 0, 0], [0, 200, 0], [0, 0, 200], [10, 20, 30]];
        let image = ::image::RgbImage::from_raw(2, 2, pixels.concat()).unwrap();
        for format in FORMATS.into_iter().filter(|format| *format != ImageFormat::Jpeg) {
            let mut file = Cursor::new(Vec::new());
            DynamicImage::from(image.clone()).write_to(&mut file, format).unwrap();
            let decoded = ImageTexture::decode(file.get_ref(), [Wrap::Clamp; 2], &mut Budget::new(0)).unwrap();
            assert_eq!(decoded.pixels, pixels.map(|[r, g, b]| [r, g, b, 255]), "{format:?}");
        }
    }

    #[test]
    fn pixels_are_met_at_their_centres_and_mixed_as_light_between() {
        let image = texture(Wrap::Clamp);
        assert_eq!(image.sample(DVec2::new(0.25, 0.25)), (DVec3::ZERO, 0.0));
        assert_eq!(image.sample(DVec2::new(0.75, 0.25)), (DVec3::ONE, 1.0));
        assert_eq!(image.sample(DVec2::new(0.25, 0.75)), (DVec3::X, 1.0));
        let (gray, alpha) = image.sample(DVec2::new(0.75, 0.75));
        assert!((gray.x - 0.215_860_5).abs() < 1e-6 && (alpha - 0.2).abs() < 1e-12, "{gray} {alpha}");
        // The mean of the linear values, which is not the mean of the codes.
        assert_eq!(image.sample(DVec2::new(0.5, 0.25)), (DVec3::splat(0.5), 0.5));
        assert_eq!(image.sample(DVec2::new(0.375, 0.25)), (DVec3::splat(0.25), 0.25));
    }

    #[test]
    fn beyond_the_edge_is_what_wrap_says() {
        let at = |wrap: Wrap, x: f64| texture(wrap).sample(DVec2::new(x, 0.25)).0.x;
        assert_eq!(
            [at(Wrap::Clamp, -3.0), at(Wrap::Clamp, 0.0), at(Wrap::Clamp, 1.0), at(Wrap::Clamp, 1e300)],
            [0.0, 0.0, 1.0, 1.0]
        );
        assert_eq!([at(Wrap::Repeat, 0.0), at(Wrap::Repeat, 1.25), at(Wrap::Repeat, -0.25)], [0.5, 0.0, 1.0]);
        assert_eq!(
            [at(Wrap::Mirror, 0.0), at(Wrap::Mirror, 1.25), at(Wrap::Mirror, 1.75), at(Wrap::Mirror, -0.25)],
            [0.0, 1.0, 0.0, 0.0]
        );
        for wrap in [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp] {
            for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300, -1e300, 1e18, -1e-300] {
                let (color, alpha) = texture(wrap).sample(DVec2::splat(bad));
                assert!(color.is_finite() && (0.0..=1.0).contains(&alpha), "{wrap:?} {bad}");
            }
        }
    }

    #[test]
    fn means_are_of_light_and_of_codes() {
        let image = texture(Wrap::Repeat);
        let gray = Transfer::Srgb.decode(128.0 / 255.0);
        let [mean, mean_codes] = image.means();
        assert!((mean - DVec3::new(2.0 + gray, 1.0 + gray, 1.0 + gray) / 4.0).length() < 1e-12);
        let codes = DVec3::new(2.0 + 128.0 / 255.0, 1.0 + 128.0 / 255.0, 1.0 + 128.0 / 255.0) / 4.0;
        assert!((mean_codes - codes).length() < 1e-12);
    }
}
