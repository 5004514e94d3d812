//! Decoding and encoding speed of block-compressed formats on one thread, and the quality of their encoders.
//!
//! `cargo bench --bench blocks` decodes an image of 1024x1024 pixels twice, from blocks that the encoder chose for a test image
//! and from random blocks, and encodes 256x256 pixels at each effort. The times are medians over `TURNS` runs.

use std::hint::black_box;
use std::time::Instant;

use codec::block::{Bc1, Bc4, Bc5, Bc6h, Bc7, BlockEncoder, BlockFormat, decode_image};
use codec::effort::Effort;

/// Width and height in pixels of the decoded image and of the encoded image.
const DECODED: usize = 1024;
const ENCODED: usize = 256;
/// Number of runs of each measurement.
const TURNS: usize = 15;

fn main() {
    println!("{:<5} {:>16} {:>16}   encode at fast, normal, exhaustive", "", "chosen Mpixel/s", "random Mpixel/s");
    let bytes = |value: f64| (value * 255.0).round() as u8;
    run("BC1", Bc1, |pixel| pixel.map(bytes), |a, b| distance(a, b, f64::from), 255.0);
    run("BC4", Bc4, |pixel| bytes(pixel[0]), |a, b| distance(&[*a], &[*b], f64::from), 255.0);
    run("BC5", Bc5, |pixel| [bytes(pixel[0]), bytes(pixel[1])], |a, b| distance(a, b, f64::from), 255.0);
    let halves = |pixel: [f64; 3]| pixel.map(|value| half::f16::from_f64(8.0 * value * value).to_bits());
    run("BC6H", Bc6h, halves, |a, b| distance(a, b, f64::from), f64::from(0x4800u16));
    run("BC7", Bc7, |pixel| pixel.map(bytes), |a, b| distance(a, b, f64::from), 255.0);
}

/// Returns the mean squared difference of two pixels' channels.
fn distance<T: Copy>(a: &[T], b: &[T], number: impl Fn(T) -> f64) -> f64 {
    a.iter().zip(b).map(|(&a, &b)| (number(a) - number(b)).powi(2)).sum::<f64>() / a.len() as f64
}

fn run<F>(
    name: &str,
    format: F,
    convert: impl Fn([f64; 3]) -> <F as BlockFormat>::Texel,
    distance: impl Fn(&<F as BlockFormat>::Texel, &<F as BlockFormat>::Texel) -> f64,
    peak: f64,
) where
    F: BlockFormat + BlockEncoder<Texel = <F as BlockFormat>::Texel>,
{
    let source: Vec<_> = picture(DECODED).into_iter().map(&convert).collect();
    let chosen = format.encode(&source, DECODED, DECODED, Effort::Normal);
    let mut seed = 1u64;
    let random: Vec<u8> = (0..chosen.len())
        .map(|at| {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            // The first byte of a BC7 block selects its mode: all eight modes are equally likely, which uniformly random bits
            // would not give.
            if at % 16 == 0 && name == "BC7" { 1 << (seed >> 61) } else { (seed >> 56) as u8 }
        })
        .collect();
    let mut pixels = vec![<F as BlockFormat>::Texel::default(); DECODED * DECODED];
    let speed = [&random, &chosen].map(|blocks| {
        let seconds = median(|| decode_image::<F>(black_box(blocks), DECODED, DECODED, black_box(&mut pixels)));
        (DECODED * DECODED) as f64 / seconds / 1e6
    });
    print!("{name:<5} {:>16.0} {:>16.0}  ", speed[1], speed[0]);
    let source: Vec<_> = picture(ENCODED).into_iter().map(&convert).collect();
    let mut pixels = vec![<F as BlockFormat>::Texel::default(); ENCODED * ENCODED];
    for effort in [Effort::Fast, Effort::Normal, Effort::Exhaustive] {
        let mut blocks = Vec::new();
        let seconds = median(|| blocks = format.encode(black_box(&source), ENCODED, ENCODED, effort));
        decode_image::<F>(&blocks, ENCODED, ENCODED, &mut pixels);
        let square = source.iter().zip(&pixels).map(|(a, b)| distance(a, b)).sum::<f64>() / source.len() as f64;
        let psnr = 10.0 * (peak * peak / square).log10();
        print!("  {:.2} Mpixel/s {psnr:.2} dB", (ENCODED * ENCODED) as f64 / seconds / 1e6);
    }
    println!();
}

fn median(mut work: impl FnMut()) -> f64 {
    let mut seconds: Vec<f64> = (0..TURNS)
        .map(|_| {
            let start = Instant::now();
            work();
            start.elapsed().as_secs_f64()
        })
        .collect();
    seconds.sort_by(f64::total_cmp);
    seconds[TURNS / 2]
}

/// Returns a test image of gradients, sine waves and edges, 0 to 1, with a little noise.
fn picture(side: usize) -> Vec<[f64; 3]> {
    let mut seed = 7u32;
    let mut noise = || {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (f64::from(seed >> 16) / 65536.0 - 0.5) * 0.03
    };
    (0..side * side)
        .map(|at| {
            let (x, y) = ((at % side) as f64, (at / side) as f64);
            let edge = if (x + 0.7 * y) % 90.0 > 45.0 { 0.3 } else { 0.0 };
            [
                0.2 + 0.0004 * x + edge + noise(),
                0.5 + 0.3 * (0.11 * x + 0.07 * y).sin() + noise(),
                0.15 + 0.0004 * y + 0.5 * edge + noise(),
            ]
            .map(|value: f64| value.clamp(0.0, 1.0))
        })
        .collect()
}
