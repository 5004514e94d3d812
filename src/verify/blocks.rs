//! Hard cases of texture blocks and BC4w (depth.md 8; blocks.md): function markers, endpoints, modes, and comparison
//! with the decoder of the `dds` crate.

use dds::{ColorFormat, DecodeOptions, Format, ImageViewMut, Size};

use crate::case::{Bound, Family, Group, HardCase, Measured};
use crate::clip::{Clip, EFFORT, Sequence, random_at};
use crate::pictures::{HardPicture, PICTURES};
use codec::block::{SIDE, TEXELS, bc6h, bc7, decode_bc1, decode_bc4, decode_bc5};
use codec::depth::bc4w::bipartitions::bipartitions;
use codec::depth::bc4w::{Bc4w, MAX_ENDPOINT, Pair, search};
use codec::depth::block::Block;
use codec::depth::block_tiles::Layout;
use codec::depth::domain::Domain;
use codec::depth::limit::NodeFunction;
use codec::depth::nodes::{Function, function_of};
use codec::depth::platelet::Platelet;
use codec::depth::{BACKGROUND_CODE, TemporalSettings};
use codec::effort::Effort;
use codec::error::{Error, Result};
use codec::math::random::Random;
use half::f16;

/// Number of blocks of each mode that both decoders decode.
const EACH: usize = 4096;
/// BC4w blocks along each side of a picture in which every block has its own code.
const COLUMNS: u32 = 40;
/// Modes of BC6H: number of low bits of a block that select the mode, and the values of those bits.
const BC6H_MODES: [(u32, &[u128]); 2] = [(2, &[0, 1]), (5, &[2, 3, 6, 7, 10, 11, 14, 15, 18, 22, 26, 30])];

pub(super) fn cases() -> Vec<HardCase> {
    let group = |pipeline: &str, unit| Group::new(Family::Blocks, pipeline, unit);
    let mut cases = Vec::new();
    let background = group("DB4W", "background mixed up");
    for picture in PICTURES {
        cases.push(background.none(picture.name, move || background_of(picture)));
    }
    // Endpoints of 13 bits represent codes 8 or 9 apart. The palette divides the distance between adjacent endpoints
    // into sevenths, at most 9/7 apart: a code is within 9/14 of an entry, which itself is rounded by at most 3/7. With
    // background in the block the palette has fifths, at most 9/5 apart: 9/10 and 2/5. Both sums are less than two, so
    // the error is at most one code. The same holds for 65528 to 65534, between the last two endpoints, although the
    // last endpoint is the background code.
    let one = group("DB4W, one code a block", "codes");
    let two = group("DB4W, one code and the background in a block", "codes");
    let most = Bound::AtMost(1.0);
    let spans: [(&str, u16, u16); 4] = [
        ("0 to 1599", 0, 1),
        ("every 40th", 0, 40),
        ("up to the last endpoint of surfaces: 63928 to 65527", 63_928, 1),
        ("beyond it: 65528 to 65534", 65_528, 1),
    ];
    for (name, first, step) in spans {
        let last = if first == 65_528 { 65_534 } else { 65_527 };
        cases.push(one.case(name, most, move || codes_of_blocks([first, step, last], |_, _| false)));
        cases.push(two.case(name, most, move || codes_of_blocks([first, step, last], |x, y| (x + y) % 3 == 0)));
    }
    let palette = group("BC4w palettes against binary64", "codes");
    // Palette entries are sevenths or fifths, rounded to nearest.
    cases.push(palette.case("eight codes, e0 > e1", Bound::AtMost(3.0 / 7.0), || Ok(palette_error(8))));
    cases.push(palette.case("six codes, e0 <= e1", Bound::AtMost(2.0 / 5.0), || Ok(palette_error(6))));
    cases.push(palette.none("equal endpoints, all of them", || Ok(equal_endpoints())));
    // 8 e + e / 1024, rounded down, approximates 65535 / 8191 e: both agree at the ends and differ by less than 1
    // between.
    cases.push(palette.case("endpoints of 13 bits", Bound::AtMost(1.0), || Ok(endpoint_error())));
    let marker = group("blocks and platelets of 8x8 pixels parted by every third line", "taken for another function");
    cases.push(marker.none("codes that fill endpoints with ones", marker_collisions));
    let temporal = |epsilon| TemporalSettings { epsilon, ..TemporalSettings::default() };
    for epsilon in [0, 100] {
        let boxes = group(&format!("DAB5, epsilon = {epsilon}"), "codes");
        for picture in PICTURES {
            cases.push(boxes.case(picture.name, Bound::AtMost(f64::from(epsilon)), move || {
                let source = picture.moving();
                source.compare(Clip::codes(&source, temporal(epsilon), Layout::BlockTiles)?)
            }));
        }
    }
    for epsilon in [0, 8, 60] {
        let boxes = group(&format!("MAB1, epsilon = {epsilon}"), "of 255");
        for (name, pixel) in MATERIALS {
            cases.push(boxes.case(name, Bound::AtMost(f64::from(epsilon)), move || {
                let source = Sequence::new([22, 17], 4, pixel);
                source.compare(Clip::material(&source, temporal(epsilon), Layout::BlockTiles)?)
            }));
        }
    }
    cases.extend(decoders());
    cases
}

/// Inputs that are hard for BC1: its three-colour mode, equal endpoints, uncorrelated channels.
type Material = (&'static str, fn(u32, u32, u32) -> [u8; 3]);

const MATERIALS: [Material; 6] = [
    ("black and two colours: the mode of three", |_, x, y| match (x + 2 * y) % 3 {
        0 => [0; 3],
        1 => [255, 200, 9],
        _ => [40, 250, 255],
    }),
    ("one colour a block: equal endpoints", |frame, x, y| {
        [0, 1, 2].map(|c| (37 * (x / 4) + 91 * (y / 4) + 50 * c + frame) as u8)
    }),
    ("between two steps of 5 and 6 bits", |_, x, y| [4 + (x % 2) as u8, 2 + (y % 2) as u8, 251]),
    ("channels that do not go together", |frame, x, y| [(x * 60) as u8, (y * 60) as u8, ((x + y + frame) * 90) as u8]),
    ("pure colours", |frame, x, y| [[255, 0, 0], [0, 255, 0], [0, 0, 255], [255; 3]][((x + y + frame) % 4) as usize]),
    ("noise", |frame, x, y| {
        let mut random = random_at([frame, x, y]);
        [(); 3].map(|()| random.below(256) as u8)
    }),
];

fn background_of(picture: &HardPicture) -> Result<Measured> {
    let source = picture.still();
    let mut wrong = Measured::count(0);
    let small = picture.size[0] * picture.size[1] <= 64 * 77;
    for effort in [Effort::Fast, Effort::Normal].into_iter().filter(|&effort| small || effort == EFFORT) {
        let measured = source.compare(Clip::blocks(&source, effort, 1)?)?;
        wrong.count_if(measured.figure.is_infinite(), || measured.place.unwrap_or_default());
        wrong.inputs.clips.extend(measured.inputs.clips);
    }
    Ok(wrong)
}

/// Compares pictures of one block of 8x8 pixels per code, from `first` to `last` in steps. Pixels selected by
/// `background` are background.
fn codes_of_blocks([first, step, last]: [u16; 3], background: fn(u32, u32) -> bool) -> Result<Measured> {
    let source = Sequence::new([8 * COLUMNS; 2], 1, |_, x, y| {
        let at = x / 8 + y / 8 * COLUMNS;
        let code = (u32::from(first) + at * u32::from(step)).min(u32::from(last)) as u16;
        if background(x, y) { BACKGROUND_CODE } else { code }
    });
    source.compare(Clip::blocks(&source, EFFORT, 1)?)
}

fn palette_error(codes: usize) -> Measured {
    let mut random = Random::new(8);
    let mut worst = Measured::nothing();
    for e0 in 0..=MAX_ENDPOINT {
        let others = [0, 1, e0.saturating_sub(1), e0, (e0 + 1).min(MAX_ENDPOINT), MAX_ENDPOINT];
        let more = [(); 26].map(|()| random.below(u32::from(MAX_ENDPOINT) + 1) as u16);
        for e1 in others.into_iter().chain(more).filter(|&e1| (e0 > e1) == (codes == 8)) {
            let [a, b] = [e0, e1].map(|endpoint| f64::from(Pair::code(endpoint)));
            let steps = (codes - 1) as f64;
            let palette = Pair { e0, e1 }.palette();
            for (index, &code) in palette.iter().enumerate().take(codes) {
                let place = if index < 2 { index as f64 * steps } else { index as f64 - 1.0 };
                // Exact: all terms are integers.
                let exact = (steps - place) * a + place * b;
                let error = (f64::from(code) * steps - exact).abs() / steps;
                worst.greatest(error, || format!("index {index} of {e0} and {e1}"));
            }
        }
    }
    worst
}

fn equal_endpoints() -> Measured {
    let mut worst = Measured::nothing();
    for endpoint in 0..=MAX_ENDPOINT {
        let palette = Pair { e0: endpoint, e1: endpoint }.palette();
        let code = Pair::code(endpoint);
        let expected = [code, code, code, code, code, code, 0, BACKGROUND_CODE];
        let off = palette.iter().zip(expected).map(|(found, code)| found.abs_diff(code)).max().unwrap_or(u16::MAX);
        worst.greatest(f64::from(off), || format!("endpoint {endpoint}"));
    }
    worst
}

fn endpoint_error() -> Measured {
    let mut worst = Measured::nothing();
    for endpoint in 0..=MAX_ENDPOINT {
        let exact = f64::from(endpoint) * 65535.0 / f64::from(MAX_ENDPOINT);
        worst.greatest((f64::from(Pair::code(endpoint)) - exact).abs(), || format!("endpoint {endpoint}"));
    }
    worst
}

/// Counts blocks and platelets whose last bytes mark another function, or that cannot be parsed back.
fn marker_collisions() -> Result<Measured> {
    let mut wrong = Measured::count(0);
    let codes = [BACKGROUND_CODE, 65_534, 65_527, 0];
    for parted in bipartitions().iter().step_by(3) {
        for (a, b) in codes.into_iter().flat_map(|a| codes.map(|b| (a, b))) {
            let picture: Vec<u16> = (0..64).map(|pixel| if parted.side_b >> pixel & 1 == 0 { a } else { b }).collect();
            let block = Block::of(&picture, 8, 1, [0, 0]);
            let (found, _) = search::encode(&block, EFFORT);
            let is_block =
                function_of(1, found.as_bytes()) == Function::Bc4w && Bc4w::from_bytes(*found.as_bytes()).is_some();
            wrong.count_if(!is_block, || format!("a block of {a} and {b}"));
            let platelet = Platelet::fit(&block, &Domain::log(), 0).map(|(platelet, _)| platelet.to_bytes());
            let is_other = platelet.is_some_and(|bytes| function_of(1, &bytes) != Function::Platelet);
            wrong.count_if(is_other, || format!("a platelet of {a} and {b}"));
        }
    }
    Ok(wrong)
}

fn decoders() -> Vec<HardCase> {
    let mut cases = Vec::new();
    // BC1, BC4 and BC5 leave the rounding of thirds, fifths and sevenths to the decoder: one 8-bit step.
    let near = Group::new(Family::Blocks, "our decoder beside that of dds", "of 255");
    let bytes = |name: &str, most: f64, run: fn() -> Result<Measured>| near.case(name, Bound::AtMost(most), run);
    cases.push(bytes("BC1, both orders of endpoints", 1.0, || {
        let ours = |block: &[u8; 8]| decode_bc1(block).as_flattened().iter().copied().map(Some).collect();
        beside(&any_blocks(3), (Format::BC1_UNORM, ColorFormat::RGB_U8), ours)
    }));
    cases.push(bytes("BC4, both modes", 1.0, || {
        let ours = |block: &[u8; 8]| decode_bc4(block).map(Some).to_vec();
        beside(&any_blocks(5), (Format::BC4_UNORM, ColorFormat::GRAYSCALE_U8), ours)
    }));
    cases.push(bytes("BC5, both modes", 1.0, || {
        let ours = |block: &[u8; 16]| decode_bc5(block).iter().flat_map(|&[r, g]| [Some(r), Some(g), None]).collect();
        beside(&any_blocks(7), (Format::BC5_UNORM, ColorFormat::RGB_U8), ours)
    }));
    // BC7 decoding is bit exact by definition.
    for mode in 0..8u32 {
        cases.push(near.none(format!("BC7, mode {mode}"), move || {
            let ours =
                |block: &[u8; 16]| bc7::decode(block).iter().flat_map(|&[r, g, b, _]| [r, g, b].map(Some)).collect();
            beside(&blocks_of(1 << mode, mode + 1), (Format::BC7_UNORM, ColorFormat::RGB_U8), ours)
        }));
    }
    let exact = Group::new(Family::Blocks, "our decoder beside that of dds", "half floats that differ");
    for (count, codes) in BC6H_MODES {
        for &code in codes {
            let name = format!("BC6H, mode {code} of {count} bits");
            cases.push(exact.none(name, move || halves_beside(&blocks_of(code, count))));
        }
    }
    cases
}

/// Returns random blocks with `low` in their lowest `count` bits. A quarter of them repeat one byte from a random
/// offset on.
fn blocks_of<const BYTES: usize>(low: u128, count: u32) -> Vec<[u8; BYTES]> {
    let mut random = Random::new((low as u64) << 8 | u64::from(count));
    let block = |_| {
        let mut bytes = [0; BYTES];
        random.fill(&mut bytes);
        if random.one_in(4) {
            let same = [0, 255, random.word() as u8][random.below(3) as usize];
            bytes[random.below(BYTES as u32) as usize..].fill(same);
        }
        let mut word = [0; 16];
        word[..BYTES].copy_from_slice(&bytes);
        let word = u128::from_le_bytes(word) >> count << count | low;
        bytes.copy_from_slice(&word.to_le_bytes()[..BYTES]);
        bytes
    };
    (0..EACH).map(block).collect()
}

fn any_blocks<const BYTES: usize>(seed: u128) -> Vec<[u8; BYTES]> {
    let mut blocks = blocks_of(seed, 0);
    // Equal endpoints, of one byte and of two bytes.
    for block in blocks.iter_mut().step_by(16) {
        (block[1], block[2], block[3]) = (block[0], block[0], block[0]);
    }
    blocks
}

fn shown_by_dds(blocks: &[u8], count: usize, (format, color): (Format, ColorFormat)) -> Result<Vec<u8>> {
    let size = Size::new(SIDE as u32, (count * SIDE) as u32);
    let mut shown = vec![0; TEXELS * count * usize::from(color.bytes_per_pixel())];
    let image = ImageViewMut::new(&mut shown, size, color).ok_or_else(|| Error::invalid("an image of another size"))?;
    let refused = |error| Error::invalid(format!("dds does not decode its own format: {error}"));
    dds::decode(&mut &*blocks, image, format, &DecodeOptions::default()).map_err(refused)?;
    Ok(shown)
}

/// Returns the largest difference between the two decoders. Samples that our decoder does not return are skipped.
fn beside<const BYTES: usize>(
    blocks: &[[u8; BYTES]],
    format: (Format, ColorFormat),
    ours: impl Fn(&[u8; BYTES]) -> Vec<Option<u8>>,
) -> Result<Measured> {
    let theirs = shown_by_dds(blocks.as_flattened(), blocks.len(), format)?;
    let mut worst = Measured::nothing();
    for (block, theirs) in blocks.iter().zip(theirs.chunks_exact(theirs.len() / blocks.len())) {
        let samples = ours(block).into_iter().zip(theirs).enumerate();
        for (at, (ours, theirs)) in samples.filter_map(|(at, (ours, theirs))| Some((at, (ours?, *theirs)))) {
            worst.greatest(f64::from(ours.abs_diff(theirs)), || format!("sample {at} of {block:02x?}"));
        }
    }
    Ok(worst)
}

fn halves_beside(blocks: &[[u8; 16]]) -> Result<Measured> {
    let theirs = shown_by_dds(blocks.as_flattened(), blocks.len(), (Format::BC6H_UF16, ColorFormat::RGB_F32))?;
    let mut wrong = Measured::count(0);
    for (block, theirs) in blocks.iter().zip(theirs.chunks_exact(12 * TEXELS)) {
        for (ours, theirs) in bc6h::decode(block).as_flattened().iter().zip(theirs.as_chunks::<4>().0) {
            let differs = f16::from_bits(*ours).to_f32() != f32::from_ne_bytes(*theirs);
            wrong.count_if(differs, || format!("{block:02x?}"));
        }
    }
    Ok(wrong)
}
