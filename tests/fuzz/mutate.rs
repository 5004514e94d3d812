//! Deterministic mutations of byte inputs, biased towards boundary values.

use crate::samples::Random;

/// Integers at and near common limits.
const EXTREME: [u64; 16] = [
    0,
    1,
    2,
    3,
    127,
    255,
    256,
    16_384,
    16_385,
    65_535,
    65_536,
    0x4000_0000,
    0x7fff_ffff,
    0x8000_0000,
    0xffff_ffff,
    u64::MAX,
];

/// Returns a random index into a slice of `length` elements. `length` is not 0.
pub fn place(length: usize, random: &mut Random) -> usize {
    random.below(u32::try_from(length).unwrap_or(u32::MAX)) as usize
}

/// Returns a random element.
pub fn pick<'a, T>(all: &'a [T], random: &mut Random) -> &'a T {
    &all[place(all.len(), random)]
}

/// Returns a random integer of any size, usually a boundary value.
pub fn number(random: &mut Random) -> u64 {
    match random.below(4) {
        0 => u64::from(random.below(300)),
        1 => u64::from(random.below(u32::MAX)) << random.below(33),
        2 => pick(&EXTREME, random).wrapping_sub(u64::from(random.below(3))),
        _ => *pick(&EXTREME, random),
    }
}

/// Applies one to four mutations to `input`; `other` is a source of bytes to splice in.
pub fn bytes(input: &mut Vec<u8>, other: &[u8], random: &mut Random) {
    let count = 1 + random.below(4);
    for _ in 0..count {
        one(input, other, random);
    }
}

fn one(input: &mut Vec<u8>, other: &[u8], random: &mut Random) {
    if input.is_empty() {
        input.extend_from_slice(&other[..other.len().min(16)]);
        return;
    }
    let at = place(input.len(), random);
    match random.below(18) {
        0..=3 => input[at] ^= 1 << random.below(8),
        4 => input[at] = input[at].wrapping_add(1),
        5 => input[at] = input[at].wrapping_sub(1),
        6 => input[at] = *pick(&[0, 1, 2, 0x7f, 0x80, 0xfe, 0xff], random),
        7 => input[at] = random.below(256) as u8,
        8..=10 => {
            let width = *pick(&[2, 4, 4, 8], random);
            let value = number(random).to_le_bytes();
            let end = (at + width).min(input.len());
            input[at..end].copy_from_slice(&value[..end - at]);
        }
        11 => {
            // Changes a 32-bit field by -4 to 4.
            let end = (at + 4).min(input.len());
            let mut word = [0; 4];
            word[..end - at].copy_from_slice(&input[at..end]);
            let moved = u32::from_le_bytes(word).wrapping_add(random.below(9)).wrapping_sub(4).to_le_bytes();
            input[at..end].copy_from_slice(&moved[..end - at]);
        }
        12 => {
            let from = place(input.len(), random);
            let count = (1 + random.below(16) as usize).min(input.len() - from.max(at));
            input.copy_within(from..from + count, at);
        }
        13 => input.truncate(at),
        14 => {
            let count = 1 + random.below(8) as usize;
            let end = (at + count).min(input.len());
            input.drain(at..end);
        }
        15 => {
            let count = 1 + random.below(8) as usize;
            let value = random.below(256) as u8;
            input.splice(at..at, std::iter::repeat_n(value, count));
        }
        16 if !other.is_empty() => {
            let from = place(other.len(), random);
            let count = (1 + random.below(64) as usize).min(other.len() - from);
            let end = (at + count).min(input.len());
            input.splice(at..end, other[from..from + count].iter().copied());
        }
        _ => {
            // Duplicates a part of the input.
            let count = (1 + random.below(40) as usize).min(input.len() - at);
            let part = input[at..at + count].to_vec();
            let to = place(input.len(), random);
            input.splice(to..to, part);
        }
    }
}

/// Like [`bytes`], but most mutations are in the first `front` bytes, which contain the headers.
pub fn header(input: &mut Vec<u8>, front: usize, other: &[u8], random: &mut Random) {
    if random.below(3) == 0 {
        return bytes(input, other, random);
    }
    let mut head: Vec<u8> = input[..front.min(input.len())].to_vec();
    let length = head.len();
    bytes(&mut head, &other[..front.min(other.len())], random);
    input.splice(..length, head);
}
