//! Maximum memory of the stages of simplification. The need of images and points is known before the work begins, that of
//! textures after the tiles are selected.

use super::capture::Capture;
use super::cracks::eye_side;
use super::points::MAX_POINTS;
use super::points::{VOXEL_BYTES, WAITING};
use super::quad_mesh::AtlasLight;
use super::samples::Sample;
use super::settings::{Settings, SurfaceAtlases};
use super::textures::SAMPLES_AT_ONCE;
use codec::error::Result;
use codec::memory::{Budget, Need};

/// Maximum number of images that are compared at once.
const MAX_COMPARED: usize = 8;
/// Bytes per pixel of an image while it is read: depth, colour and material as stored in files, and its rays.
const READING_PIXEL_BYTES: u64 = 56;
/// Bytes of the end point of a sample's ray.
const END_BYTES: u64 = 24;
/// Bytes per pixel of a compared image: its rays, those of the image that is read in parallel, pictures and their errors.
const COMPARED_PIXEL_BYTES: u64 = 240;
/// Bytes per merged point while candidates are fitted: the point, its sorted copies, and the tile that it belongs to.
const POINT_BYTES: u64 = 96;
/// Bytes of the constraints of a sample that lies along eight tiles, as found and sorted by tile.
const CONSTRAINED_BYTES: u64 = 8 * 2 * 24;
/// Bytes per texel while samples are added: a sum of colour, and the bits of 4x4 places of constraints.
const TEXEL_BYTES: u64 = 16 + 4;
/// Bytes per texel of the tile that a thread finishes: distances of 4x4 places to both kinds of constraints, coverage, and
/// colour.
const FINISHED_BYTES: u64 = 2 * 4 * 16 + 4 + 28;
/// Bytes per texel of the atlas while textures are copied to it: codes and half floats.
const MESH_ATLAS_BYTES: u64 = 4 + 6;
/// Bytes per texel of the atlas while files are written; with half floats; with surface atlases.
const ATLAS_BYTES: u64 = 16;
const FLOAT_ATLAS_BYTES: u64 = 40;
const SURFACE_ATLAS_BYTES: u64 = 80;
/// Bytes per pixel of an alpha picture, and per triangle that it is drawn from. Each thread has one picture.
const ALPHA_PIXEL_BYTES: u64 = 8;
const TRIANGLE_BYTES: u64 = 400;
/// Bytes of the tables of candidates and of view shares, and of view shares alone.
const SELECTION_BYTES: u64 = 112 << 20;
const SHARES_BYTES: u64 = 48 << 20;
/// Maximum number of pictures from eyes in the region: six sides of 35 eyes.
const EYE_PICTURES: u64 = 35 * 6;
/// Bytes of tiles, of their lookup tables, and of the directions with surfaces.
const TILES_BYTES: u64 = 16 << 20;

/// Returns the number of pixels of the largest image.
fn max_pixels(capture: &Capture) -> u64 {
    capture.images.iter().map(|image| image.pixels() as u64).max().unwrap_or(0)
}

/// Returns the number of images in memory while samples are processed: the next image is read in parallel.
fn held_images(capture: &Capture) -> u64 {
    rayon::current_num_threads().min(capture.images.len()).min(2) as u64
}

/// Returns the bytes of merging and selection.
fn selecting_bytes(capture: &Capture) -> u64 {
    let pixels = max_pixels(capture);
    let samples = pixels.saturating_mul(capture.images.len() as u64);
    let points = samples.min(MAX_POINTS as u64);
    let waiting = samples.min(2 * WAITING as u64);
    // Voxels, those waiting to be merged, and both during the merge.
    let merging = VOXEL_BYTES * (2 * (points + waiting) + waiting / 2);
    let images = pixels.saturating_mul(READING_PIXEL_BYTES + END_BYTES * held_images(capture));
    images.saturating_add(merging).max(points * POINT_BYTES + SELECTION_BYTES)
}

/// Returns the bytes of texturing tiles whose textures have the given sides.
fn texturing_bytes(capture: &Capture, sides: &[usize], settings: &Settings) -> u64 {
    let threads = rayon::current_num_threads();
    let pixels = max_pixels(capture);
    let of_side = |side: usize| (side as u64).pow(2);
    let texels: u64 = sides.iter().copied().map(of_side).sum();
    let mut largest = sides.to_vec();
    largest.sort_unstable_by_key(|&side| std::cmp::Reverse(side));
    let finished = largest.into_iter().take(threads).map(of_side).sum::<u64>() * FINISHED_BYTES;
    let samples = pixels.saturating_mul(READING_PIXEL_BYTES + size_of::<Sample>() as u64 * held_images(capture));
    let constraints = pixels.min(SAMPLES_AT_ONCE as u64) * CONSTRAINED_BYTES;
    let from_eyes = EYE_PICTURES * u64::from(eye_side(capture)).pow(2);
    let in_atlas = atlas_texels(texels, settings) * MESH_ATLAS_BYTES;
    let textures = texels
        .saturating_mul(TEXEL_BYTES)
        .saturating_add(finished.max(samples + constraints).max(in_atlas).max(from_eyes));
    let atlas_bytes = match (settings.surfaces, settings.light) {
        (SurfaceAtlases::GBuffer, _) => SURFACE_ATLAS_BYTES,
        (_, AtlasLight::HalfFloats) => FLOAT_ATLAS_BYTES,
        _ => ATLAS_BYTES,
    };
    let with_files = atlas_texels(texels, settings) * atlas_bytes + samples;
    // View shares are still in memory while pictures are drawn from textures of half the size.
    let pictures = pixels.saturating_mul(ALPHA_PIXEL_BYTES * threads.min(capture.images.len()) as u64)
        + (2 * sides.len() as u64).saturating_mul(TRIANGLE_BYTES * threads as u64);
    let coarse = SHARES_BYTES + texels / 4 * TEXEL_BYTES + (samples + constraints).max(pictures).max(from_eyes);
    textures.max(with_files).max(coarse).saturating_add(TILES_BYTES)
}

/// Returns the number of texels of the atlas for a total number of tile texels; some texels between tiles stay empty.
fn atlas_texels(texels: u64, settings: &Settings) -> u64 {
    (texels + texels / 2).min(u64::from(settings.atlas).pow(2))
}

/// Returns the bytes of a picture of a scene and the image that it is compared with.
fn compared_bytes(capture: &Capture) -> u64 {
    max_pixels(capture).saturating_mul(COMPARED_PIXEL_BYTES)
}

fn need(fixed: u64, each: u64, instead: &str) -> Need<'_> {
    Need { what: "simplifying", fixed, each, instead }
}

/// Fails if captures do not fit into a budget, whatever their tiles. `compared` are the captures that are compared with the
/// scene.
pub fn check_images(captures: &[&Capture], compared: &[&Capture], budget: Budget) -> Result<()> {
    let selecting = captures.iter().map(|capture| {
        let images = max_pixels(capture).saturating_mul(READING_PIXEL_BYTES + size_of::<Sample>() as u64);
        selecting_bytes(capture).max(images)
    });
    let comparing = compared.iter().map(|capture| compared_bytes(capture) + TILES_BYTES);
    let bytes = selecting.chain(comparing).max().unwrap_or(0);
    budget.at_once(&need(bytes, 0, "smaller images"), 1).map(|_| ())
}

/// Fails if textures of the given sides do not fit into the budget.
pub fn check_textures(capture: &Capture, sides: &[usize], settings: &Settings) -> Result<()> {
    let bytes = texturing_bytes(capture, sides, settings);
    let instead = "fewer `pixels_per_degree`, a smaller `area` or a smaller `atlas`";
    settings.memory.at_once(&need(bytes, 0, instead), 1).map(|_| ())
}

/// Returns the number of images that are compared at once with a scene whose atlas has `texels` texels.
pub fn compared_at_once(capture: &Capture, texels: u64, budget: Budget) -> Result<usize> {
    let most = rayon::current_num_threads().min(MAX_COMPARED).min(capture.images.len());
    let fixed = texels * ATLAS_BYTES + TILES_BYTES;
    budget.at_once(&need(fixed, compared_bytes(capture), "smaller images"), most)
}
