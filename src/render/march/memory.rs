//! Upper bounds on the memory of rendering, besides that of the views.

use std::collections::BTreeMap;

use crate::march::SpecularMode;
use crate::march::playback::frames::PlaybackOptions;
use crate::march::render::RAYS_AT_ONCE;
use crate::march::specular::sphere_fit::{MAX_PROXIES, MAX_TEXELS, MIN_TEXELS};
use codec::decode::{Decoder, StreamInfo};
use codec::image::StreamKind;

/// Bytes per ray that a thread holds: its direction, its layers, and the sum of its pixel.
const RAY_BYTES: u64 = 400;
/// Bytes per texel of material while spheres are fitted: its index in a growing list and on the stack of the flood fill, and a
/// visited flag.
const FIT_BYTES: u64 = 8 + 8 + 1;
/// Bytes per texel of an environment map.
const MAP_BYTES: u64 = 18;
/// Bytes per texel of an environment map while it is made: samples of the views, sums, weights, and coarser levels.
const MAKING_BYTES: u64 = 96;
/// Bytes per texel that is splatted.
const POINT_BYTES: u64 = 64;
/// Bytes per pixel from its rays until it is written: linear RGB and alpha, and codes or channels of a file. Rays are held by the
/// thread that traces them.
const PICTURE_BYTES: u64 = 72;
/// Bytes per pixel while the images of two eyes are joined.
pub const JOINED_BYTES: u64 = 24;
/// Bytes per pixel of auxiliary planes: six values, joined for two eyes, and channels of a file.
const AOV_BYTES: u64 = 120;
/// Bytes per pixel of a reference image: faces of colour, depth and material in one file, and errors.
const REFERENCE_BYTES: u64 = 320;

fn pixels(stream: &StreamInfo) -> u64 {
    u64::from(stream.entry.width) * u64::from(stream.entry.height)
}

/// Returns an upper bound on the bytes that ray marching takes: rays that threads hold and, with secondary rays, refractive
/// proxies.
pub fn march_bytes(decoder: &Decoder, options: &PlaybackOptions, specular: SpecularMode) -> u64 {
    let held = (rayon::current_num_threads() * RAYS_AT_ONCE) as u64 * RAY_BYTES;
    if specular == SpecularMode::None {
        return held;
    }
    let mut of_probes = BTreeMap::<usize, u64>::new();
    for stream in decoder.streams().iter().filter(|stream| stream.kind == StreamKind::Material) {
        if options.probes.takes(&decoder.probe(stream).name) {
            *of_probes.entry(stream.probe).or_default() += pixels(stream);
        }
    }
    let mut of_probes: Vec<u64> = of_probes.into_values().collect();
    of_probes.sort_unstable_by_key(|&texels| std::cmp::Reverse(texels));
    let texels: u64 = of_probes.into_iter().take(options.selection.most.unwrap_or(usize::MAX)).sum();
    let proxies = (texels / MIN_TEXELS as u64).min(MAX_PROXIES as u64);
    let in_work = proxies.min(rayon::current_num_threads() as u64);
    let maps = 6 * u64::from(MAX_TEXELS).pow(2) * (proxies * MAP_BYTES + in_work * MAKING_BYTES);
    texels.saturating_mul(FIT_BYTES).saturating_add(maps + held)
}

/// Returns an upper bound on the bytes of images with this number of pixels, of their auxiliary planes, and of their reference
/// images.
pub fn picture_bytes(pixels: u64, has_aovs: bool, has_reference: bool) -> u64 {
    let aovs = if has_aovs { AOV_BYTES } else { 0 };
    let reference = if has_reference { REFERENCE_BYTES } else { 0 };
    pixels.saturating_mul(PICTURE_BYTES + aovs + reference)
}

pub fn splat_bytes(decoder: &Decoder) -> u64 {
    decoder.streams().iter().map(pixels).max().unwrap_or(0) * POINT_BYTES
}
