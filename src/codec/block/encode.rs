//! Block encoders: external libraries behind one trait.
//!
//! `intel_tex_2` encodes BC1, BC6H and BC7. `dds` encodes BC4 and BC5; at exhaustive effort it also encodes BC1, and the
//! better of the two blocks is kept. Errors are measured with our decoders.

use dds::{ColorFormat, CompressionQuality, EncodeOptions, Format, ImageView, Size};
use intel_tex_2::{RgbaSurface, bc1, bc6h, bc7};

use super::{Bc1, Bc4, Bc5, Bc6h, Bc7, Bc7Rgba, BlockFormat, SIDE, TEXELS, grid};
use crate::effort::Effort;

/// Encoder of a block format. A block depends only on its own pixels and the effort. `intel_tex_2` selects kernels by the
/// instruction set of the processor, so that the bytes are the same only within one family of processors.
pub trait BlockEncoder: Sync {
    type Texel: Copy;
    /// Encodes the blocks of `grid``(width, height)`, row by row. The last column and row are repeated past the right and
    /// the bottom edge; missing `pixels` repeat the last pixel. Without pixels there are no blocks.
    fn encode(&self, pixels: &[Self::Texel], width: usize, height: usize, effort: Effort) -> Vec<u8>;
}

impl BlockEncoder for Bc1 {
    type Texel = [u8; 3];
    /// Fast and normal effort give the same blocks; exhaustive effort takes the better of two libraries for each block.
    fn encode(&self, pixels: &[[u8; 3]], width: usize, height: usize, effort: Effort) -> Vec<u8> {
        let mut blocks = rgba_bands(pixels, width, height, |surface| bc1::compress_blocks(&surface));
        if effort == Effort::Exhaustive {
            let others = in_bands(pixels, width, height, |band| {
                channels(band, band.pixels.as_flattened(), ColorFormat::RGB_U8, Format::BC1_UNORM, effort)
            });
            keep_better(&mut blocks, &others, pixels, width);
        }
        blocks
    }
}

/// Replaces each BC1 block by the other one if that has a smaller sum of squared errors.
fn keep_better(blocks: &mut [u8], others: &[u8], pixels: &[[u8; 3]], width: usize) {
    let columns = grid(width, 1)[0];
    for (at, (block, other)) in blocks.chunks_exact_mut(8).zip(others.chunks_exact(8)).enumerate() {
        let [left, top] = [at % columns * SIDE, at / columns * SIDE];
        let error = |block: &[u8]| {
            let mut texels = [[0; 3]; TEXELS];
            Bc1::decode_block(block, &mut texels);
            let inside = (0..TEXELS).filter(|texel| left + texel % SIDE < width);
            let differences = inside.filter_map(|texel| {
                let pixel = pixels.get((top + texel / SIDE) * width + left + texel % SIDE)?;
                Some(pixel.iter().zip(&texels[texel]).map(|(a, b)| u32::from(a.abs_diff(*b)).pow(2)).sum::<u32>())
            });
            differences.sum::<u32>()
        };
        if error(other) < error(block) {
            block.copy_from_slice(other);
        }
    }
}

impl BlockEncoder for Bc7 {
    type Texel = [u8; 3];
    fn encode(&self, pixels: &[[u8; 3]], width: usize, height: usize, effort: Effort) -> Vec<u8> {
        let settings = match effort {
            Effort::Fast => bc7::opaque_ultra_fast_settings(),
            Effort::Normal => bc7::opaque_fast_settings(),
            Effort::Exhaustive => bc7::opaque_slow_settings(),
        };
        rgba_bands(pixels, width, height, |surface| bc7::compress_blocks(&settings, &surface))
    }
}

impl BlockEncoder for Bc7Rgba {
    type Texel = [u8; 4];
    fn encode(&self, pixels: &[[u8; 4]], width: usize, height: usize, effort: Effort) -> Vec<u8> {
        let settings = match effort {
            Effort::Fast => bc7::alpha_ultra_fast_settings(),
            Effort::Normal => bc7::alpha_fast_settings(),
            Effort::Exhaustive => bc7::alpha_slow_settings(),
        };
        in_bands(pixels, width, height, |band| {
            bc7::compress_blocks(&settings, &band.surface(band.pixels.as_flattened(), 4))
        })
    }
}

impl BlockEncoder for Bc6h {
    type Texel = [u16; 3];
    fn encode(&self, pixels: &[[u16; 3]], width: usize, height: usize, effort: Effort) -> Vec<u8> {
        let settings = match effort {
            Effort::Fast => bc6h::very_fast_settings(),
            Effort::Normal => bc6h::basic_settings(),
            Effort::Exhaustive => bc6h::very_slow_settings(),
        };
        in_bands(pixels, width, height, |band| {
            let bytes: Vec<u8> = band
                .pixels
                .iter()
                .flat_map(|&[r, g, b]| [r, g, b, 0].map(unsigned_half))
                .flat_map(u16::to_le_bytes)
                .collect();
            bc6h::compress_blocks(&settings, &band.surface(&bytes, 8))
        })
    }
}

impl BlockEncoder for Bc4 {
    type Texel = u8;
    fn encode(&self, pixels: &[u8], width: usize, height: usize, effort: Effort) -> Vec<u8> {
        in_bands(pixels, width, height, |band| {
            let bytes = &band.pixels;
            channels(band, bytes, ColorFormat::GRAYSCALE_U8, Format::BC4_UNORM, effort)
        })
    }
}

impl BlockEncoder for Bc5 {
    type Texel = [u8; 2];
    fn encode(&self, pixels: &[[u8; 2]], width: usize, height: usize, effort: Effort) -> Vec<u8> {
        in_bands(pixels, width, height, |band| {
            let bytes: Vec<u8> = band.pixels.iter().flat_map(|&[r, g]| [r, g, 0]).collect();
            channels(band, &bytes, ColorFormat::RGB_U8, Format::BC5_UNORM, effort)
        })
    }
}

/// Clamps a half float to those of BC6H UF16: NaN and negative values become 0, infinity becomes the largest finite value.
fn unsigned_half(bits: u16) -> u16 {
    match bits {
        0..0x7C00 => bits,
        0x7C00 => 0x7BFF,
        _ => 0,
    }
}

struct Band<T> {
    pixels: Vec<T>,
    width: usize,
}

/// Rows of blocks that are encoded at a time, which limits the memory for a large image.
const BAND_ROWS: usize = 64;

impl<T> Band<T> {
    fn height(&self) -> usize {
        self.pixels.len() / self.width
    }

    fn surface<'a>(&self, data: &'a [u8], pixel_bytes: usize) -> RgbaSurface<'a> {
        let [width, height, stride] = [self.width, self.height(), self.width * pixel_bytes].map(|size| size as u32);
        RgbaSurface { data, width, height, stride }
    }
}

fn in_bands<T: Copy>(pixels: &[T], width: usize, height: usize, encode: impl Fn(&Band<T>) -> Vec<u8>) -> Vec<u8> {
    let [columns, rows] = grid(width, height);
    let (Some(&last), true) = (pixels.last(), columns > 0) else { return Vec::new() };
    let mut blocks = Vec::new();
    for first in (0..rows).step_by(BAND_ROWS) {
        let count = BAND_ROWS.min(rows - first);
        let mut band = Band { pixels: Vec::with_capacity(count * columns * TEXELS), width: columns * SIDE };
        for y in first * SIDE..(first + count) * SIDE {
            let row = y.min(height - 1) * width;
            band.pixels.extend((0..band.width).map(|x| *pixels.get(row + x.min(width - 1)).unwrap_or(&last)));
        }
        blocks.extend(encode(&band));
    }
    blocks
}

/// As [`in_bands`], for kernels that read 8-bit RGBA.
fn rgba_bands(pixels: &[[u8; 3]], width: usize, height: usize, encode: impl Fn(RgbaSurface<'_>) -> Vec<u8>) -> Vec<u8> {
    in_bands(pixels, width, height, |band| {
        let bytes: Vec<u8> = band.pixels.iter().flat_map(|&[r, g, b]| [r, g, b, 255]).collect();
        encode(band.surface(&bytes, 4))
    })
}

fn channels<T>(band: &Band<T>, bytes: &[u8], color: ColorFormat, format: Format, effort: Effort) -> Vec<u8> {
    let mut options = EncodeOptions::default();
    options.parallel = false;
    options.quality = match effort {
        Effort::Fast => CompressionQuality::Fast,
        Effort::Normal => CompressionQuality::Normal,
        Effort::Exhaustive => CompressionQuality::High,
    };
    let size = Size::new(band.width as u32, band.height() as u32);
    let mut blocks = Vec::new();
    if let Some(image) = ImageView::new(bytes, size, color) {
        // Writing to memory does not fail, and the library supports these formats.
        let _ = dds::encode(&mut blocks, image, format, None, &options);
    }
    blocks
}
