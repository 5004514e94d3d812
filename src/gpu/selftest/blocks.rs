//! Inputs of the block-decoding kernels: random bits in every mode, and blocks from the encoders.

use crate::harness::Case;
use codec::block::{Bc1, Bc4, Bc5, Bc6h, Bc7, BlockEncoder, bc6h, bc7, decode_bc1, decode_bc4, decode_bc5};
use codec::effort::Effort;
use codec::math::random::Random;
use kernels::pictures::{pack_bytes, pack_halves};
use kernels::prepare::words_from;

/// Number of random blocks per mode.
const EACH: usize = 2000;
/// Width and height of the picture that is encoded.
const SIDE: usize = 128;
/// Number of blocks in the timed case: those of 2048x2048 pixels.
const MANY: usize = 1 << 18;

/// BC1, with both orders of the endpoints.
pub(super) fn bc1(seed: u64) -> Vec<Case> {
    let chosen = Bc1.encode(&picture(seed), SIDE, SIDE, Effort::Normal);
    cases(seed, &["any"], &chosen, |_, _: &mut [u8; 8]| {}, |block| decode_bc1(block).map(pack_bytes).to_vec())
}

/// BC4, with both orders of the endpoints.
pub(super) fn bc4(seed: u64) -> Vec<Case> {
    let pixels: Vec<u8> = picture(seed).iter().map(|pixel| pixel[0]).collect();
    let chosen = Bc4.encode(&pixels, SIDE, SIDE, Effort::Normal);
    cases(seed, &["any"], &chosen, |_, _: &mut [u8; 8]| {}, |block| decode_bc4(block).map(u32::from).to_vec())
}

pub(super) fn bc5(seed: u64) -> Vec<Case> {
    let pixels: Vec<[u8; 2]> = picture(seed).iter().map(|&[r, g, _]| [r, g]).collect();
    let chosen = Bc5.encode(&pixels, SIDE, SIDE, Effort::Normal);
    let words = |block: &[u8; 16]| decode_bc5(block).map(|[r, g]| pack_bytes([r, g, 0])).to_vec();
    cases(seed, &["any"], &chosen, |_, _| {}, words)
}

/// BC6H in its fourteen modes and the reserved ones.
pub(super) fn bc6h(seed: u64) -> Vec<Case> {
    const CODES: [&str; 18] =
        ["0", "1", "2", "3", "6", "7", "10", "11", "14", "15", "18", "19", "22", "23", "26", "27", "30", "31"];
    let pixels: Vec<[u16; 3]> =
        picture(seed).iter().map(|pixel| pixel.map(|value| 0x3000 + 32 * u16::from(value))).collect();
    let chosen = Bc6h.encode(&pixels, SIDE, SIDE, Effort::Fast);
    let force = |mode: usize, block: &mut [u8; 16]| {
        let code: u8 = CODES[mode].parse().unwrap_or_default();
        let mask = if code < 2 { 3 } else { 31 };
        block[0] = block[0] & !mask | code;
    };
    cases(seed, &CODES, &chosen, force, |block| bc6h::decode(block).into_iter().flat_map(pack_halves).collect())
}

/// BC7 in its eight modes and the reserved one.
pub(super) fn bc7(seed: u64) -> Vec<Case> {
    const MODES: [&str; 9] = ["0", "1", "2", "3", "4", "5", "6", "7", "reserved"];
    let chosen = Bc7.encode(&picture(seed), SIDE, SIDE, Effort::Normal);
    let force = |mode: usize, block: &mut [u8; 16]| {
        let bit = (1u16 << mode) as u8;
        block[0] = if mode < 8 { block[0] & !(bit | (bit - 1)) | bit } else { 0 };
    };
    cases(seed, &MODES, &chosen, force, |block| bc7::decode(block).map(u32::from_le_bytes).to_vec())
}

/// Returns a picture of gradients and edges with noise.
fn picture(seed: u64) -> Vec<[u8; 3]> {
    let mut random = Random::new(seed ^ 0xb10c);
    let pixel = |at: usize| {
        let (x, y) = ((at % SIDE) as u32, (at / SIDE) as u32);
        let edge = if (x + y / 2) % 50 > 25 { 60 } else { 0 };
        [x + edge, y + edge / 2, (2 * x + y) / 3].map(|value| (value + random.below(6)).min(255) as u8)
    };
    (0..SIDE * SIDE).map(pixel).collect()
}

/// Returns the cases of a format: random blocks of each mode, which `force` sets; `chosen` blocks; and many blocks of all
/// modes.
fn cases<const BYTES: usize>(
    seed: u64,
    modes: &[&str],
    chosen: &[u8],
    force: impl Fn(usize, &mut [u8; BYTES]),
    decode: impl Fn(&[u8; BYTES]) -> Vec<u32>,
) -> Vec<Case> {
    let mut random = Random::new(seed);
    let mut block = |mode: usize| {
        let mut block = [0; BYTES];
        random.fill(&mut block);
        // Extreme values: all bytes from a random position on are equal.
        if random.one_in(4) {
            let same = [0, 255, random.word() as u8][random.below(3) as usize];
            block[random.below(BYTES as u32) as usize..].fill(same);
        }
        force(mode, &mut block);
        block
    };
    let mut cases = Vec::new();
    for (mode, name) in modes.iter().enumerate() {
        let blocks: Vec<_> = (0..EACH).map(|_| block(mode)).collect();
        cases.push(case(&format!("mode {name}"), &blocks, &decode));
    }
    cases.push(case("chosen by the encoder", chosen.as_chunks().0, &decode));
    let many: Vec<_> = (0..MANY).map(|at| block(at % modes.len())).collect();
    cases.push(case("blocks of 2048x2048 pixels", &many, &decode));
    cases
}

fn case<const BYTES: usize>(label: &str, blocks: &[[u8; BYTES]], decode: impl Fn(&[u8; BYTES]) -> Vec<u32>) -> Case {
    let expected: Vec<u32> = blocks.iter().flat_map(decode).collect();
    let words = words_from(blocks.as_flattened());
    Case {
        label: label.to_owned(),
        buffers: [("blocks", words), ("texels", vec![0xdead_beef; expected.len()])].into(),
        invocations: blocks.len() as u32,
        passes: 0,
        inputs: blocks.len() as u64,
        pixels: 16 * blocks.len() as u64,
        expected: vec![("texels", expected)],
    }
}
