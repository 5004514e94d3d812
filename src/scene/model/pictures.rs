//! PNG and JPEG files as textures.
//!
//! Enters: the bytes of a file. Leaves: 8-bit pixels with alpha.

use std::io::Cursor;

use ::image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader, Limits};

use super::budget::Budget;
use crate::error::{Error, Result};
use crate::image::ReadLimits;
use crate::scene::texture::{ImageTexture, Wrap};

/// Any picture may claim this many bytes of pixels; see [`ReadLimits`].
const PIXEL_FLOOR: u64 = 64 << 20;

/// Decodes a picture. 16-bit samples lose their lower half; grey is repeated in all three colours.
///
/// # Errors
/// When it is neither PNG nor JPEG, is damaged, or claims more pixels than a file of its size may.
pub fn decode(bytes: &[u8], wrap: [Wrap; 2], budget: &mut Budget) -> Result<ImageTexture> {
    let format = ::image::guess_format(bytes).ok();
    let Some(format @ (ImageFormat::Png | ImageFormat::Jpeg)) = format else {
        return Err(Error::unsupported("neither a PNG nor a JPEG picture"));
    };
    let damaged = |error: ::image::ImageError| Error::invalid(format!("the picture is damaged: {error}"));
    let cap = ReadLimits::default().believable(bytes.len() as u64, PIXEL_FLOOR);
    let mut limits = Limits::default();
    limits.max_alloc = Some(cap);
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
    reader.limits(limits);
    let decoder = reader.into_decoder().map_err(damaged)?;
    let (width, height) = decoder.dimensions();
    let pixels = u64::from(width) * u64::from(height);
    if decoder.total_bytes().max(4 * pixels) > cap {
        return Err(Error::invalid(format!(
            "the picture claims {width}x{height} pixels, more than its {} bytes may",
            bytes.len()
        )));
    }
    if pixels == 0 {
        return Err(Error::invalid("the picture has no pixels"));
    }
    // As the file has them, and as they leave.
    budget.take(pixels, 8, "a picture")?;
    let image = DynamicImage::from_decoder(decoder).map_err(damaged)?.into_rgba8();
    Ok(ImageTexture { width, height, pixels: image.as_chunks::<4>().0.to_vec(), wrap })
}
