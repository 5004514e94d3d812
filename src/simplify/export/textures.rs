//! Texture files of a scene: KTX2 with compressed blocks, and EXR with half floats.
//!
//! ASTC is not supported: `intel_tex_2` 0.5 ranks its block modes, and panics where it would encode them.

use half::f16;
use rayon::prelude::*;

use std::path::PathBuf;

use crate::quad_mesh::QuadMesh;
use codec::block::{Bc6h, Bc7, Bc7Rgba, BlockEncoder, SIDE};
use codec::effort::Effort;
use codec::error::Result;
use codec::image::{Plane, Primaries};
use footage::image_files::exr;
use footage::image_files::ktx2::{self, BlockFormat};
use scene::mesh::ImageTexture;

/// KTX2 file of BC7, or of BC6H for half floats.
#[derive(Debug)]
pub struct Ktx2Output {
    pub path: PathBuf,
    pub effort: Effort,
}

/// Number of rows of blocks that one job encodes.
const ROWS_A_JOB: usize = 16;

/// Encodes half floats as BC6H, which has no alpha, or codes as BC7, with alpha if any texel is not opaque.
pub fn ktx2(quads: &QuadMesh, output: &Ktx2Output) -> Result<Vec<u8>> {
    let ImageTexture { width, height, pixels, .. } = &*quads.texture;
    let (across, effort) = (*width as usize, output.effort);
    let (format, blocks) = match &quads.light {
        Some(light) => {
            let bits: Vec<[u16; 3]> = light.iter().map(|light| light.map(f16::to_bits)).collect();
            (BlockFormat::Bc6hUnsigned, encode(&Bc6h, &bits, across, effort))
        }
        None if pixels.iter().all(|pixel| pixel[3] == u8::MAX) => {
            let opaque: Vec<[u8; 3]> = pixels.iter().map(|&[r, g, b, _]| [r, g, b]).collect();
            (BlockFormat::Bc7Srgb, encode(&Bc7, &opaque, across, effort))
        }
        None => (BlockFormat::Bc7Srgb, encode(&Bc7Rgba, pixels, across, effort)),
    };
    ktx2::bytes(format, [*width, *height], &blocks)
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
