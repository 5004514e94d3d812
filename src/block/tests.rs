//! Images of blocks, and encoders.

use super::*;
use crate::effort::Effort;

const EFFORTS: [Effort; 3] = [Effort::Fast, Effort::Normal, Effort::Exhaustive];

/// Numbers that are the same in each run (xorshift of Marsaglia).
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }

    /// A block of 16 bytes: any bits, or, in one of four, only zeros or only ones from some bit on.
    fn block(&mut self) -> u128 {
        let any = u128::from(self.next()) << 64 | u128::from(self.next());
        let (shift, ones) = (self.next() % 128, u128::MAX * u128::from(self.next() % 2));
        match self.next() % 4 {
            0 => any & ((1 << shift) - 1) | ones << shift,
            _ => any,
        }
    }
}

/// Blocks compared with another decoder, for each mode.
const BLOCKS: usize = 20_000;

/// `low` put in place of the lowest `count` bits of random blocks.
fn blocks_of(low: u128, count: u32) -> impl Iterator<Item = [u8; 16]> {
    let mut random = Random(0x9E37_79B9_7F4A_7C15 ^ u64::from(count) << 32 ^ low as u64);
    (0..BLOCKS).map(move |_| (random.block() >> count << count | low).to_le_bytes())
}

#[test]
fn all_modes_of_bc7_are_decoded_as_another_decoder_does() {
    for mode in 0..=8 {
        let (low, count) = if mode < 8 { (1 << mode, mode + 1) } else { (0, 8) };
        for block in blocks_of(low, count) {
            let mut expected = [0; 64];
            bcdec_rs::bc7(&block, &mut expected, 16);
            assert_eq!(bc7::decode(&block).as_flattened(), expected, "mode {mode}, block {block:02x?}");
            let mut shown = [[1; 3]; TEXELS];
            Bc7::decode_block(&block, &mut shown);
            assert!(shown.iter().zip(expected.chunks(4)).all(|(a, b)| a == &b[..3]), "mode {mode}, block {block:02x?}");
        }
    }
}

#[test]
fn all_modes_of_bc6h_are_decoded_as_another_decoder_does() {
    let codes = (0..2).map(|code| (code, 2)).chain((0..32).filter(|code| code & 2 == 2).map(|code| (code, 5)));
    for (code, count) in codes {
        for block in blocks_of(code, count) {
            let mut expected = [1; 48];
            bcdec_rs::bc6h_half(&block, &mut expected, 12, false);
            assert_eq!(bc6h::decode(&block).as_flattened(), expected, "code {code}, block {block:02x?}");
            assert!(expected.iter().all(|&half| half <= 0x7BFF));
            assert!(![19, 23, 27, 31].contains(&code) || expected == [0; 48], "reserved code {code}");
        }
    }
}

#[test]
fn bc1_bc4_and_bc5_are_within_one_step_of_another_decoder() {
    let near = |a: u8, b: u8| a.abs_diff(b) <= 1;
    let mut differ = [0; 3];
    for block in blocks_of(0, 0) {
        let half = block.first_chunk().unwrap();
        let mut expected = [0; 64];
        bcdec_rs::bc1(half, &mut expected, 16);
        let shown = bc1::decode(half);
        let pairs = shown.iter().zip(expected.chunks(4));
        assert!(pairs.clone().all(|(a, b)| a.iter().zip(b).all(|(&a, &b)| near(a, b))), "BC1 {half:02x?}");
        differ[0] += usize::from(pairs.clone().any(|(a, b)| a != &b[..3]));
        let mut expected = [0; 16];
        bcdec_rs::bc4(half, &mut expected, 4, false);
        let shown = bc4::decode(half);
        assert!(shown.iter().zip(&expected).all(|(&a, &b)| near(a, b)), "BC4 {half:02x?}");
        differ[1] += usize::from(shown != expected);
        let mut expected = [0; 32];
        bcdec_rs::bc5(&block, &mut expected, 8, false);
        let shown = bc5::decode(&block);
        assert!(shown.as_flattened().iter().zip(&expected).all(|(&a, &b)| near(a, b)), "BC5 {block:02x?}");
        differ[2] += usize::from(shown.as_flattened() != expected);
    }
    println!("of {BLOCKS} blocks of BC1, BC4, BC5 differ: {differ:?}");
}

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
