//! Tests of images of blocks and of the encoders.

use super::*;
use crate::effort::Effort;
use crate::math::random::Random;

const EFFORTS: [Effort; 3] = [Effort::Fast, Effort::Normal, Effort::Exhaustive];

/// A block of 16 bytes with random bits; one in four has only zeros or only ones from a random bit on.
fn random_block(random: &mut Random) -> u128 {
    let any = u128::from(random.bits()) << 64 | u128::from(random.bits());
    let (shift, ones) = (random.below(128), u128::MAX * u128::from(random.below(2)));
    if random.one_in(4) { any & ((1 << shift) - 1) | ones << shift } else { any }
}

/// Number of blocks per mode that are compared with another decoder.
const BLOCKS: usize = 20_000;

/// Random blocks whose lowest `count` bits are `low`.
fn blocks_of(low: u128, count: u32) -> impl Iterator<Item = [u8; 16]> {
    let mut random = Random::new(0x9E37_79B9_7F4A_7C15 ^ u64::from(count) << 32 ^ low as u64);
    (0..BLOCKS).map(move |_| (random_block(&mut random) >> count << count | low).to_le_bytes())
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
            let mut shown = [[1; 3]; TEXELS];
            Bc6h::decode_block(&block, &mut shown);
            assert_eq!(shown.as_flattened(), expected, "code {code}, block {block:02x?}");
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
        let shown = decode_bc1(half);
        let pairs = shown.iter().zip(expected.chunks(4));
        assert!(pairs.clone().all(|(a, b)| a.iter().zip(b).all(|(&a, &b)| near(a, b))), "BC1 {half:02x?}");
        differ[0] += usize::from(pairs.clone().any(|(a, b)| a != &b[..3]));
        let mut expected = [0; 16];
        bcdec_rs::bc4(half, &mut expected, 4, false);
        let shown = decode_bc4(half);
        assert!(shown.iter().zip(&expected).all(|(&a, &b)| near(a, b)), "BC4 {half:02x?}");
        differ[1] += usize::from(shown != expected);
        let mut expected = [0; 32];
        bcdec_rs::bc5(&block, &mut expected, 8, false);
        let shown = decode_bc5(&block);
        assert!(shown.as_flattened().iter().zip(&expected).all(|(&a, &b)| near(a, b)), "BC5 {block:02x?}");
        differ[2] += usize::from(shown.as_flattened() != expected);
    }
    println!("of {BLOCKS} blocks of BC1, BC4, BC5 differ: {differ:?}");
}

/// A test image of gradients, waves, an edge and a little noise, 0 to 1 in each channel.
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

/// Encodes and decodes an image; checks the number of blocks, and that a second encode returns the same blocks.
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

/// Minimum PSNR in dB, a little below the measured values: rows are efforts, columns BC1, BC4, BC5, BC6H and BC7.
const FLOORS: [[f64; 5]; 3] =
    [[38.8, 51.9, 48.9, 41.3, 42.3], [38.8, 52.0, 49.3, 43.3, 44.8], [39.3, 52.3, 49.5, 43.7, 44.9]];

#[test]
fn encoders_reach_their_decibels() {
    let size = [64, 64];
    let source: Vec<[u8; 3]> = picture(64, 64).into_iter().map(|pixel| pixel.map(to_byte)).collect();
    let red: Vec<u8> = source.iter().map(|pixel| pixel[0]).collect();
    let two: Vec<[u8; 2]> = source.iter().map(|&[r, g, _]| [r, g]).collect();
    let light = |pixel: [f64; 3]| pixel.map(|value| half::f16::from_f64(8.0 * value * value).to_bits());
    let halves: Vec<[u16; 3]> = picture(64, 64).into_iter().map(light).collect();
    let values = |texels: &[[u16; 3]]| -> Vec<f64> {
        texels.as_flattened().iter().map(|&bits| half::f16::from_bits(bits).to_f64().sqrt()).collect()
    };
    for (effort, floors) in EFFORTS.into_iter().zip(FLOORS) {
        let bc1 = there_and_back(Bc1, &source, size, effort);
        let bc4 = there_and_back(Bc4, &red, size, effort);
        let bc5 = there_and_back(Bc5, &two, size, effort);
        let bc6h = there_and_back(Bc6h, &halves, size, effort);
        let bc7 = there_and_back(Bc7, &source, size, effort);
        let measured = [
            psnr(255.0, bytes(&bc1).zip(bytes(&source)).map(|(a, b)| a - b)),
            psnr(255.0, bc4.iter().zip(&red).map(|(&a, &b)| f64::from(a) - f64::from(b))),
            psnr(255.0, bytes(&bc5).zip(bytes(&two)).map(|(a, b)| a - b)),
            psnr(8f64.sqrt(), values(&bc6h).into_iter().zip(values(&halves)).map(|(a, b)| a - b)),
            psnr(255.0, bytes(&bc7).zip(bytes(&source)).map(|(a, b)| a - b)),
        ];
        println!("{effort:?}: {measured:.2?}");
        for (format, (measured, floor)) in measured.into_iter().zip(floors).enumerate() {
            assert!(measured >= floor, "format {format} at {effort:?}: {measured:.2} dB, at least {floor} dB expected");
        }
    }
}

/// Tests images whose sides are not multiples of a block: each block must equal the block that its pixels alone give, with
/// the last column and row repeated.
fn check_sizes<F>(format: F, convert: impl Fn([f64; 3]) -> <F as BlockFormat>::Texel)
where
    F: Copy + BlockFormat + BlockEncoder<Texel = <F as BlockFormat>::Texel>,
{
    for [width, height] in [[1, 1], [3, 5], [5, 4], [4, 5], [64, 64], [130, 9]] {
        let pixels: Vec<_> = picture(width, height).into_iter().map(&convert).collect();
        for effort in EFFORTS {
            let shown = there_and_back(format, &pixels, [width, height], effort);
            let blocks = format.encode(&pixels, width, height, effort);
            let columns = grid(width, height)[0];
            for (at, block) in blocks.chunks(F::BYTES).enumerate() {
                let [left, top] = [at % columns * SIDE, at / columns * SIDE];
                let places = (0..TEXELS).map(|t| (left + t % SIDE, top + t / SIDE));
                let alone: Vec<_> =
                    places.clone().map(|(x, y)| pixels[y.min(height - 1) * width + x.min(width - 1)]).collect();
                assert_eq!(
                    format.encode(&alone, SIDE, SIDE, effort),
                    block,
                    "block {at} of {width}x{height}, {effort:?}"
                );
                let mut texels = [<F as BlockFormat>::Texel::default(); TEXELS];
                F::decode_block(block, &mut texels);
                for ((x, y), texel) in places.zip(texels).filter(|&((x, y), _)| x < width && y < height) {
                    assert_eq!(shown[y * width + x], texel, "pixel {x}, {y} of {width}x{height}");
                }
            }
        }
    }
    for size in [[0, 0], [0, 4], [4, 0]] {
        assert!(format.encode(&[], size[0], size[1], Effort::Normal).is_empty());
        decode_image::<F>(&[], size[0], size[1], &mut []);
    }
}

#[test]
fn blocks_depend_on_their_pixels_alone_at_all_sizes() {
    check_sizes(Bc1, |pixel| pixel.map(to_byte));
    check_sizes(Bc4, |pixel| to_byte(pixel[0]));
    check_sizes(Bc5, |pixel| [to_byte(pixel[0]), to_byte(pixel[2])]);
    check_sizes(Bc6h, |pixel| pixel.map(|value| half::f16::from_f64(5.0 * value).to_bits()));
    check_sizes(Bc7, |pixel| pixel.map(to_byte));
}

#[test]
fn bc6h_takes_any_half_float() {
    // NaN, −infinity, a negative value, −0; infinity; the largest value; 0.
    for (bits, held) in [(0x7E01, 0), (0xFC00, 0), (0xBC00, 0), (0x8000, 0), (0x7C00, 0x7BFF), (0x7BFF, 0x7BFF), (0, 0)]
    {
        for effort in EFFORTS {
            let blocks = Bc6h.encode(&[[bits; 3]; TEXELS], SIDE, SIDE, effort);
            let mut shown = [[1; 3]; TEXELS];
            Bc6h::decode_block(&blocks, &mut shown);
            assert!(shown.as_flattened().iter().all(|&shown| shown.abs_diff(held) <= 32), "{bits:04x}: {shown:04x?}");
        }
    }
    let wild: Vec<[u16; 3]> = (0..=u16::MAX).map(|bits| [bits, bits.swap_bytes(), bits.reverse_bits()]).collect();
    for effort in [Effort::Fast, Effort::Normal] {
        assert_eq!(there_and_back(Bc6h, &wild, [256, 256], effort).len(), wild.len());
    }
}

#[test]
fn what_is_missing_of_an_image_stays_as_it_is() {
    let block = [0xFF; 8];
    let mut pixels = vec![[7u8; 3]; 8 * 5];
    decode_image::<Bc1>(&block, 8, 5, &mut pixels);
    for (at, pixel) in pixels.iter().enumerate() {
        let inside = at % 8 < 4 && at / 8 < 4;
        assert_eq!(*pixel, [if inside { 0 } else { 7 }; 3], "pixel {at}");
    }
    // Pixels for one row and blocks for more: nothing is written past the end.
    decode_image::<Bc1>(&[0; 64], 8, 5, &mut pixels[..8]);
    assert_eq!(pixels[7], [0; 3]);
    let mut texels = [[9; 3]; TEXELS];
    Bc7::decode_block(&[1; 15], &mut texels);
    Bc6h::decode_block(&[], &mut [[9; 3]; TEXELS]);
    assert_eq!(texels, [[9; 3]; TEXELS]);
}

/// The format document of these decoders.
const DOCUMENT: &str = include_str!(concat!(env!("LIGHTFOLD_FORMATS"), "/blocks.md"));

/// Cells of a table's rows; the table follows a comment such as `<!-- table: two -->`.
fn rows(comment: &str) -> Vec<Vec<&'static str>> {
    let table = DOCUMENT.split(&format!("<!-- {comment} -->\n")).nth(1).expect(comment).trim_start();
    let lines = table.lines().take_while(|line| line.starts_with('|')).skip(2);
    let rows: Vec<Vec<_>> = lines.map(|line| line.trim_matches('|').split('|').map(str::trim).collect()).collect();
    assert!(!rows.is_empty(), "{comment}");
    rows
}

/// Numbers of a table, without its first column.
fn numbers(comment: &str, radix: u32) -> Vec<u32> {
    let cells = rows(comment).into_iter().flat_map(|row| row[1..].to_vec());
    cells.flat_map(|cell| cell.split(", ").map(|cell| u32::from_str_radix(cell, radix).unwrap())).collect()
}

fn hex_bytes(cell: &str) -> Vec<u8> {
    cell.trim_matches('`').split(' ').map(|byte| u8::from_str_radix(byte, 16).unwrap()).collect()
}

#[test]
fn the_tables_of_the_document_are_those_of_the_code() {
    assert_eq!(numbers("table: two", 16), bptc::TWO.map(u32::from));
    assert_eq!(numbers("table: three", 16), bptc::THREE);
    assert_eq!(numbers("table: anchor of two", 10), bptc::ANCHOR_OF_TWO.map(u32::from));
    assert_eq!(
        numbers("table: anchors of three", 10),
        (0..128).map(|at| u32::from(bptc::ANCHORS_OF_THREE[at % 2][at / 2])).collect::<Vec<_>>()
    );
    for mode in &bc6h::MODES {
        let delta = mode.delta.map_or("—".to_owned(), |delta| delta.map(|bits| bits.to_string()).join(", "));
        let code_bits = if mode.code < 2 { 2 } else { 5 };
        let row = format!(
            "| {} | {code_bits} | {} | {} | {delta} | `{}` |",
            mode.code, mode.subsets, mode.precision, mode.layout
        );
        assert!(DOCUMENT.contains(&row), "blocks.md has no row {row}");
    }
    for (number, mode) in bc7::MODES.iter().enumerate() {
        let low = match mode.low_bits {
            bc7::LowBits::None => "none",
            bc7::LowBits::PerEndpoint => "endpoint",
            bc7::LowBits::PerSubset => "subset",
        };
        let counts = [mode.partition_bits, mode.rotation_bits, mode.selection_bits, mode.color_bits, mode.alpha_bits];
        let counts = counts.map(|count| count.to_string()).join(" | ");
        let [first, second] = [mode.index_bits, mode.second_index_bits];
        let row = format!("| {number} | {} | {counts} | {low} | {first} | {second} |", mode.subsets);
        assert!(DOCUMENT.contains(&row), "blocks.md has no row {row}");
    }
}

#[test]
fn the_examples_of_the_document_hold() {
    let join = |values: &[u8]| values.iter().map(u8::to_string).collect::<Vec<_>>().join(" ");
    for row in rows("examples: bc1") {
        let pixels = decode_bc1(hex_bytes(row[0]).first_chunk().unwrap());
        assert_eq!(row[1..], [0, 1, 2, 3].map(|t| join(&pixels[t])), "{}", row[0]);
    }
    for row in rows("examples: bc4") {
        let pixels = decode_bc4(hex_bytes(row[0]).first_chunk().unwrap());
        assert_eq!(row[1], join(&pixels[..8]), "{}", row[0]);
    }
    for row in rows("examples: bc5") {
        let pixels = decode_bc5(hex_bytes(row[0]).first_chunk().unwrap());
        assert_eq!(row[1], pixels[..8].iter().map(|pixel| join(pixel)).collect::<Vec<_>>().join(", "), "{}", row[0]);
    }
    for row in rows("examples: bc6h") {
        let pixels = bc6h::decode(hex_bytes(row[1]).first_chunk().unwrap());
        let shown = [0, 6, 15].map(|t| pixels[t].map(|half| format!("{half:04x}")).join(" "));
        assert_eq!(row[2..], shown, "{}", row[1]);
    }
    for row in rows("examples: bc7") {
        let pixels = bc7::decode(hex_bytes(row[1]).first_chunk().unwrap());
        assert_eq!(row[2..], [0, 6, 15].map(|t| join(&pixels[t])), "{}", row[1]);
    }
    let examples: Vec<&str> = DOCUMENT.split("**An example.** The block `").skip(1).collect();
    assert_eq!(examples.len(), 2);
    let block = |text: &str| *hex_bytes(text.split('`').next().unwrap()).first_chunk().unwrap();
    let bc6h = bc6h::decode(&block(examples[0]));
    let bc7 = bc7::decode(&block(examples[1]));
    for texel in [0, 1, 15] {
        let shown = format!("({})", bc6h[texel].map(|half| format!("0x{half:04X}")).join(", "));
        assert!(examples[0].contains(&shown), "pixel {texel} {shown}");
        let shown = format!("({})", bc7[texel].map(|value| value.to_string()).join(", "));
        assert!(examples[1].contains(&shown), "pixel {texel} {shown}");
    }
}

#[test]
fn the_tables_of_the_shaders_are_those_of_the_code() {
    let shader = include_str!("../../../shaders/block/bptc.wgsl");
    let table = |name: &str| -> Vec<u32> {
        let body = shader.split(&format!("const {name} = ")).nth(1).unwrap().split(");").next().unwrap();
        let numbers = body.split("0x").skip(1).map(|number| number.split('u').next().unwrap());
        numbers.map(|number| u32::from_str_radix(number, 16).unwrap()).collect()
    };
    let two = bptc::TWO.iter().zip(bptc::ANCHOR_OF_TWO).map(|(&map, anchor)| u32::from(map) | u32::from(anchor) << 16);
    assert_eq!(table("BPTC_TWO"), two.collect::<Vec<_>>());
    assert_eq!(table("BPTC_THREE"), bptc::THREE);
    let [second, third] = bptc::ANCHORS_OF_THREE;
    let anchors: Vec<u8> = second.iter().zip(third).map(|(second, third)| second | third << 4).collect();
    let anchors: Vec<u32> = anchors.as_chunks().0.iter().map(|&bytes| u32::from_le_bytes(bytes)).collect();
    assert_eq!(table("BPTC_ANCHORS_OF_THREE"), anchors);
    // Each case of the shader has its layout in a comment; the code of the cases is compared on a device.
    let shader = include_str!("../../../shaders/block/bc6h.wgsl");
    for mode in &bc6h::MODES {
        let case = format!("case {}u: {{\n            // {}\n", mode.code, mode.layout);
        assert!(shader.contains(&case), "bc6h.wgsl has no {case}");
    }
}

/// RGBA test image whose alpha is a gradient.
fn picture_with_alpha(side: usize) -> Vec<[u8; 4]> {
    let pixels = picture(side, side).into_iter().map(|pixel| pixel.map(to_byte)).enumerate();
    pixels.map(|(at, [r, g, b])| [r, g, b, (at % side * 255 / (side - 1)) as u8]).collect()
}

#[test]
fn blocks_with_alpha_reach_their_decibels() {
    let (side, source) = (64, picture_with_alpha(64));
    for (effort, floor) in EFFORTS.into_iter().zip(ALPHA_FLOORS) {
        let decoded = there_and_back(Bc7Rgba, &source, [side; 2], effort);
        let measured = psnr(255.0, bytes(&decoded).zip(bytes(&source)).map(|(a, b)| a - b));
        println!("{effort:?}: {measured:.2}");
        assert!(measured >= floor, "{effort:?}: {measured:.2} dB, at least {floor} dB expected");
    }
}

/// Minimum PSNR of BC7 with alpha in dB at each effort, a little below the measured values.
const ALPHA_FLOORS: [f64; 3] = [42.3, 42.5, 42.8];
