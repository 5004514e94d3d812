//! Images of blocks, and encoders.

use super::*;
use crate::effort::Effort;

const EFFORTS: [Effort; 3] = [Effort::Fast, Effort::Normal, Effort::Exhaustive];

/// A picture of slopes, waves, an edge and a little noise, 0 to 1 in each channel.
fn picture(width: usize, height: usize) -> Vec<[f64; 3]> {
    let mut seed = 7u32;
    let mut noise = || {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(seed >> 16) / 65536.0 - 0.5
    };
    (0..width * height)
        .map(|at| {
            let (x, y) = ((at % width) as f64, (at / width) as f64);
            let edge = if x + 0.7 * y > 40.0 { 0.35 } else { 0.0 };
            [
                0.2 + 0.006 * x + edge + 0.02 * noise(),
                0.5 + 0.3 * (0.11 * x + 0.07 * y).sin() + 0.02 * noise(),
                0.15 + 0.009 * y + 0.5 * edge + 0.02 * noise(),
            ]
            .map(|value: f64| value.clamp(0.0, 1.0))
        })
        .collect()
}

fn to_byte(value: f64) -> u8 {
    (value * 255.0).round() as u8
}

fn psnr(peak: f64, differences: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = differences.fold((0.0, 0.0), |(sum, count), d| (sum + d * d, count + 1.0));
    10.0 * (peak * peak * count / sum).log10()
}

fn bytes<const N: usize>(texels: &[[u8; N]]) -> impl Iterator<Item = f64> {
    texels.iter().flatten().map(|&value| f64::from(value))
}

/// Encodes and decodes; checks what must hold of any encoder.
fn there_and_back<F>(
    format: F,
    pixels: &[<F as BlockFormat>::Texel],
    size: [usize; 2],
    effort: Effort,
) -> Vec<<F as BlockFormat>::Texel>
where
    F: BlockFormat + BlockEncoder<Texel = <F as BlockFormat>::Texel>,
{
    let [width, height] = size;
    let [columns, rows] = grid(width, height);
    let blocks = format.encode(pixels, width, height, effort);
    assert_eq!(blocks.len(), columns * rows * F::BYTES, "{width}x{height}");
    assert!(blocks == format.encode(pixels, width, height, effort), "another run gives other blocks");
    let mut decoded = vec![<F as BlockFormat>::Texel::default(); width * height];
    decode_image::<F>(&blocks, width, height, &mut decoded);
    decoded
}

#[test]
fn encoders_reach_their_decibels() {
    let (width, height) = (64, 64);
    let source: Vec<[u8; 3]> = picture(width, height).into_iter().map(|pixel| pixel.map(to_byte)).collect();
    let two: Vec<[u8; 2]> = source.iter().map(|&[r, g, _]| [r, g]).collect();
    for effort in EFFORTS {
        let shown = there_and_back(Bc1, &source, [width, height], effort);
        let bc1 = psnr(255.0, bytes(&shown).zip(bytes(&source)).map(|(a, b)| a - b));
        let shown = there_and_back(Bc5, &two, [width, height], effort);
        let bc5 = psnr(255.0, bytes(&shown).zip(bytes(&two)).map(|(a, b)| a - b));
        println!("{effort:?}: BC1 {bc1:.2} BC5 {bc5:.2}");
    }
}
