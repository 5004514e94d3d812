//! Memory that simplification takes at most.

use super::capture::Capture;
use super::fidelity::MOST_AT_ONCE;
use super::selected::MAX_POINTS;
use super::settings::Settings;

/// Bytes by pixel of an image: its rays, samples, constraints and pictures.
const PIXEL_BYTES: u64 = 640;
/// Bytes by pixel of each further image that is compared at the same time.
const COMPARED_PIXEL_BYTES: u64 = 320;
/// Bytes by merged point: its voxel, the point, its copies in the candidates' order, and the candidates it may lead to.
const POINT_BYTES: u64 = 400;
/// Bytes by texel of all tiles: sums of light, constraints, light and alpha, and the atlas.
const TEXEL_BYTES: u64 = 96;
/// Area in the planes of cube faces over that on the sphere, at most: 24 over 4 π.
const PLANE_SHARE: f64 = 1.91;
/// Texels by which the side of a tile grows: it is dilated on both sides, and rounded up.
const SIDE_GROWTH: f64 = 9.0;
/// Bytes by pixel of a picture of alpha, and by triangle that it is drawn of; each thread has one.
const ALPHA_PIXEL_BYTES: u64 = 8;
const TRIANGLE_BYTES: u64 = 400;
/// Tables of candidates and of the shares of views.
const FIXED_BYTES: u64 = 128 << 20;

/// An upper bound, for a budget that is checked before the work.
pub fn bytes(capture: &Capture, settings: &Settings) -> u64 {
    let pixels = capture.images.iter().map(|image| image.size.map(u64::from).iter().product()).max().unwrap_or(0);
    let samples = pixels.saturating_mul(capture.images.len() as u64);
    let points = samples.min(MAX_POINTS as u64);
    let texels_per_unit = settings.texels_per_unit(capture);
    let sphere = 4.0 * std::f64::consts::PI * texels_per_unit * texels_per_unit;
    let (area, tiles) = (PLANE_SHARE * settings.budgets.area * sphere, 0.5 * settings.budgets.triangles);
    // The sum of (side + growth)², of tiles that have this area together, is largest where all are alike.
    let texels = (area + 2.0 * SIDE_GROWTH * (tiles * area).sqrt() + SIDE_GROWTH.powi(2) * tiles) as u64;
    let compared = (rayon::current_num_threads().min(MOST_AT_ONCE) as u64).saturating_mul(COMPARED_PIXEL_BYTES);
    let pictures = (pixels.saturating_mul(ALPHA_PIXEL_BYTES))
        .saturating_add((settings.budgets.triangles as u64).saturating_mul(TRIANGLE_BYTES))
        .saturating_mul(rayon::current_num_threads() as u64);
    pixels
        .saturating_mul(PIXEL_BYTES + compared)
        .saturating_add(pictures)
        .saturating_add(points * POINT_BYTES)
        .saturating_add(texels.saturating_mul(TEXEL_BYTES))
        .saturating_add(FIXED_BYTES)
}
