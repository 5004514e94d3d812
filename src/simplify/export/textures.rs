//! Texture files of a scene: KTX2 with compressed blocks, and EXR with half floats.

use ctt_astcenc::bindings::{astcenc_image, astcenc_type_ASTCENC_TYPE_U8};
use ctt_astcenc::{Context, Flags, Preset, Profile, Swizzle, config_init};
use half::f16;
use rayon::prelude::*;

use std::ffi::c_void;
use std::path::PathBuf;

use crate::quad_mesh::QuadMesh;
use codec::block::{Bc6h, Bc7, Bc7Rgba, BlockEncoder, SIDE};
use codec::effort::Effort;
use codec::error::{Error, Result};
use codec::image::{Plane, Primaries};
use footage::image_files::exr;
use footage::image_files::ktx2::{self, AstcBlock, BlockFormat};
use scene::mesh::ImageTexture;

/// Blocks of a KTX2 file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ktx2Blocks {
    /// BC7, or BC6H for half floats.
    Bc,
    /// 8 bits only.
    Astc(AstcBlock),
}

#[derive(Debug)]
pub struct Ktx2Output {
    pub path: PathBuf,
    pub blocks: Ktx2Blocks,
    pub effort: Effort,
}

/// Number of rows of blocks that one job encodes.
const ROWS_A_JOB: usize = 16;

/// Encodes the texture of a scene. BC6H keeps half floats without alpha; ASTC stores the 8-bit codes also where there are half floats.
pub fn ktx2(quads: &QuadMesh, output: &Ktx2Output) -> Result<Vec<u8>> {
    let ImageTexture { width, height, pixels, .. } = &*quads.texture;
    let (across, effort) = (*width as usize, output.effort);
    let (format, blocks) = match (output.blocks, &quads.light) {
        (Ktx2Blocks::Astc(block), _) => (BlockFormat::AstcSrgb(block), astc(&quads.texture, block, effort)?),
        (Ktx2Blocks::Bc, Some(light)) => {
            let bits: Vec<[u16; 3]> = light.iter().map(|light| light.map(f16::to_bits)).collect();
            (BlockFormat::Bc6hUnsigned, encode(&Bc6h, &bits, across, effort))
        }
        (Ktx2Blocks::Bc, None) if pixels.iter().all(|pixel| pixel[3] == u8::MAX) => {
            let opaque: Vec<[u8; 3]> = pixels.iter().map(|&[r, g, b, _]| [r, g, b]).collect();
            (BlockFormat::Bc7Srgb, encode(&Bc7, &opaque, across, effort))
        }
        (Ktx2Blocks::Bc, None) => (BlockFormat::Bc7Srgb, encode(&Bc7Rgba, pixels, across, effort)),
    };
    ktx2::bytes(format, [*width, *height], &blocks)
}

/// Encodes sRGB codes with straight alpha. The encoder weights errors of colour by alpha.
fn astc(texture: &ImageTexture, block: AstcBlock, effort: Effort) -> Result<Vec<u8>> {
    let preset = match effort {
        Effort::Fast => Preset::Fast,
        Effort::Normal => Preset::Medium,
        Effort::Exhaustive => Preset::Thorough,
    };
    let failed = |error: ctt_astcenc::Error| Error::unsupported(format!("the ASTC encoder failed: {error}"));
    let side = block.side();
    let config = config_init(Profile::LdrSrgb, side, side, 1, preset, Flags::USE_ALPHA_WEIGHT).map_err(failed)?;
    let mut context = Context::new_parallel(&config).map_err(failed)?;
    let (width, height) = (texture.width, texture.height);
    let mut codes = texture.pixels.concat();
    let mut layers = [codes.as_mut_ptr().cast()];
    let mut image = astc_image(&mut layers, [width, height]);
    let mut blocks = vec![0; width.div_ceil(side) as usize * height.div_ceil(side) as usize * ktx2::BLOCK_BYTES];
    context.compress(&mut image, Swizzle::IDENTITY, &mut blocks).map_err(failed)?;
    Ok(blocks)
}

/// Describes 8-bit RGBA codes at a pointer to the library.
fn astc_image(layers: &mut [*mut c_void; 1], [width, height]: [u32; 2]) -> astcenc_image {
    let data = layers.as_mut_ptr();
    astcenc_image { dim_x: width, dim_y: height, dim_z: 1, data_type: astcenc_type_ASTCENC_TYPE_U8, data }
}

fn encode<E: BlockEncoder<Texel: Sync>>(encoder: &E, pixels: &[E::Texel], width: usize, effort: Effort) -> Vec<u8> {
    let bands = pixels.par_chunks((width * SIDE * ROWS_A_JOB).max(1));
    let blocks: Vec<Vec<u8>> = bands.map(|band| encoder.encode(band, width, band.len() / width, effort)).collect();
    blocks.concat()
}

/// Encodes R, G, B and A as half floats. As in the other textures of a scene, and unlike in other EXR files, colour is not
/// multiplied by alpha.
pub fn exr(texture: &ImageTexture, light: &[[f16; 3]]) -> Result<Vec<u8>> {
    let alpha = |pixel: &[u8; 4]| f16::from_f32(f32::from(pixel[3]) / 255.0);
    let texels = light.iter().zip(&texture.pixels).map(|(&[r, g, b], pixel)| [r, g, b, alpha(pixel)]).collect();
    exr::rgba_bytes(&Plane::new(texture.width, texture.height, texels)?, Primaries::REC709)
}

#[cfg(test)]
mod tests {
    use super::*;
    use codec::metrics::SquaredError;
    use scene::mesh::Wrap;

    /// A smooth picture with an opaque and a transparent half.
    fn texture() -> ImageTexture {
        let (width, height) = (50, 34);
        let pixel = |at: u32| {
            let (x, y) = (at % width, at / width);
            [(5 * x) as u8, (7 * y) as u8, (2 * (x + y)) as u8, if x < 25 { 255 } else { 0 }]
        };
        ImageTexture { width, height, pixels: (0..width * height).map(pixel).collect(), wrap: [Wrap::Clamp; 2] }
    }

    #[test]
    fn astc_is_close_to_the_codes_on_any_number_of_threads() {
        let texture = texture();
        let mut least = f64::INFINITY;
        for block in [AstcBlock::Pixels4x4, AstcBlock::Pixels6x6, AstcBlock::Pixels8x8] {
            let on = |threads: usize| {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                pool.install(|| astc(&texture, block, Effort::Normal)).unwrap()
            };
            let blocks = on(1);
            assert!(blocks == on(3), "{block:?}");
            let side = block.side();
            assert_eq!(blocks.len() as u32, 50u32.div_ceil(side) * 34u32.div_ceil(side) * 16);
            let config = config_init(Profile::LdrSrgb, side, side, 1, Preset::Medium, Flags::DECOMPRESS_ONLY).unwrap();
            let mut codes = vec![0u8; 4 * texture.pixels.len()];
            let mut layers = [codes.as_mut_ptr().cast()];
            let mut image = astc_image(&mut layers, [50, 34]);
            Context::new(&config).unwrap().decompress(&blocks, &mut image, Swizzle::IDENTITY).unwrap();
            let opaque = |codes: &[u8]| -> Vec<u8> {
                codes
                    .chunks_exact(4)
                    .enumerate()
                    .filter(|(at, _)| at % 50 < 24)
                    .flat_map(|(_, code)| code.to_vec())
                    .collect()
            };
            let psnr_db =
                SquaredError::of_u8(&opaque(&codes), &opaque(&texture.pixels.concat())).map(|of| of.psnr_db()).unwrap();
            assert!(psnr_db > 30.0 && psnr_db <= least, "{block:?}: {psnr_db}");
            least = psnr_db;
        }
    }
}
