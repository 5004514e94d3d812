//! 8-bit codes of pictures, for a canvas. Mirrors viewer/src/gpu/present.wgsl.

use std::sync::OnceLock;

use crate::numbers::Numbers;
use codec::error::{Error, Result};
use codec::image::{ToneCurve, Transfer};

/// Number of intervals of the table of the sRGB curve.
const CURVE_PARTS: usize = 4096;
/// Bytes of a pixel of linear RGB and alpha.
const PIXEL_BYTES: usize = 16;

/// How pictures are shown.
#[derive(Debug, Clone, Copy)]
pub struct Presentation {
    pub tone: ToneCurve,
    /// Shows magenta behind pixels with an alpha below 1, instead of black.
    pub marks_holes: bool,
    /// Shows red of the first picture, and green and blue of the second.
    pub is_anaglyph: bool,
}

/// Returns red, green, blue and alpha of the shown pictures, each row by row. `input` has the exposure in stops, the fraction
/// of the overlay that is shown, and the number of pixels of a picture; then one picture or two, and an overlay unless the
/// fraction is 0, as linear RGB and alpha in single precision.
pub fn present(input: &[u8], how: Presentation) -> Result<Vec<u8>> {
    let mut numbers = Numbers::new(input);
    let [exposure_ev, share] = numbers.take()?;
    let bytes = (numbers.take_u32()? as usize).max(1) * PIXEL_BYTES;
    let mut pictures: Vec<&[u8]> = numbers.rest().chunks_exact(bytes).collect();
    let overlay = if share > 0.0 { pictures.pop() } else { None };
    let gain = exposure_ev.exp2() as f32;
    let mut eyes: Vec<Vec<u8>> = pictures.into_iter().map(|picture| codes(picture, gain, how)).collect();
    if how.is_anaglyph && eyes.len() == 2 {
        let right = eyes.pop().unwrap_or_default();
        for (left, right) in eyes[0].chunks_exact_mut(4).zip(right.chunks_exact(4)) {
            left[1..3].copy_from_slice(&right[1..3]);
        }
    }
    if let Some(overlay) = overlay {
        eyes.iter_mut().for_each(|eye| mix(eye, overlay, share as f32));
    }
    match eyes.is_empty() {
        true => Err(Error::Usage("there is no picture to present".into())),
        false => Ok(eyes.concat()),
    }
}

/// Returns the pixels of a picture: linear RGB and alpha.
fn pixels(picture: &[u8]) -> impl Iterator<Item = [f32; 4]> {
    let number = |bytes: &[u8]| bytes.try_into().map_or(0.0, f32::from_le_bytes);
    picture.chunks_exact(PIXEL_BYTES).map(move |pixel| [0, 4, 8, 12].map(|at| number(&pixel[at..at + 4])))
}

fn codes(picture: &[u8], gain: f32, how: Presentation) -> Vec<u8> {
    let behind = if how.marks_holes { [1.0, 0.0, 1.0] } else { [0.0; 3] };
    let code = |[r, g, b, alpha]: [f32; 4]| {
        let alpha = alpha.clamp(0.0, 1.0);
        let over = |light: f32, behind: f32| code(toned(how.tone, behind + alpha * (gain * light - behind)));
        [over(r, behind[0]), over(g, behind[1]), over(b, behind[2]), 255]
    };
    pixels(picture).flat_map(code).collect()
}

/// Mixes an overlay into codes.
fn mix(codes: &mut [u8], overlay: &[u8], share: f32) {
    for (codes, overlay) in codes.chunks_exact_mut(4).zip(pixels(overlay)) {
        for (shown, light) in codes.iter_mut().zip(overlay).take(3) {
            let before = f32::from(*shown);
            *shown = (before + share * (f32::from(code(light)) - before)).round() as u8;
        }
    }
}

fn toned(curve: ToneCurve, light: f32) -> f32 {
    curve.apply(f64::from(light)) as f32
}

/// Returns the sRGB code of linear light; 0 for NaN.
fn code(light: f32) -> u8 {
    static CODES: OnceLock<Vec<u8>> = OnceLock::new();
    let codes = CODES.get_or_init(|| {
        let code = |at: usize| 255.0 * Transfer::Srgb.encode(at as f64 / CURVE_PARTS as f64);
        (0..=CURVE_PARTS).map(|at| code(at).round() as u8).collect()
    });
    // The cast converts NaN to 0.
    codes[(CURVE_PARTS as f32 * light.clamp(0.0, 1.0)).round() as usize]
}
