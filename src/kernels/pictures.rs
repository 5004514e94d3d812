//! Layout of pictures in device memory: words of a unit, row by row.
//!
//! Codes: two per word, the left one in the low half; each row starts with a new word and is padded with 0. Bytes: three per
//! word, the first in the lowest bits. Half floats: three per two words, the first two, then the third.

use half::f16;

use codec::decode::Picture;
use codec::depth::BACKGROUND_CODE;
use codec::image::Plane;

pub fn code_stride(width: u32) -> u32 {
    width.div_ceil(2)
}

/// Packs codes, row-major with `width` columns, into words.
pub fn pack_codes(codes: &[u16], width: usize) -> Vec<u32> {
    let pair = |pair: &[u16]| u32::from(pair[0]) | pair.get(1).map_or(0, |&code| u32::from(code) << 16);
    codes.chunks(width.max(1)).flat_map(|row| row.chunks(2).map(pair)).collect()
}

pub fn unpack_codes(words: &[u32], out: &mut [u16]) {
    for (pair, word) in out.chunks_mut(2).zip(words) {
        for (half, code) in pair.iter_mut().enumerate() {
            *code = (word >> (16 * half)) as u16;
        }
    }
}

pub fn pack_bytes([r, g, b]: [u8; 3]) -> u32 {
    u32::from_le_bytes([r, g, b, 0])
}

pub fn unpack_bytes(word: u32) -> [u8; 3] {
    let [r, g, b, _] = word.to_le_bytes();
    [r, g, b]
}

pub fn pack_halves([r, g, b]: [u16; 3]) -> [u32; 2] {
    [u32::from(r) | u32::from(g) << 16, u32::from(b)]
}

pub fn unpack_halves([low, high]: [u32; 2]) -> [u16; 3] {
    [low as u16, (low >> 16) as u16, high as u16]
}

fn words_of(picture: &Picture) -> Vec<u32> {
    match picture {
        Picture::Depth(plane) => pack_codes(plane.data(), plane.width() as usize),
        Picture::Color8(plane) | Picture::Material(plane) => plane.data().iter().map(|&rgb| pack_bytes(rgb)).collect(),
        Picture::Alpha(plane) => plane.data().iter().map(|&alpha| alpha.into()).collect(),
        Picture::ColorHalf(plane) => plane.data().iter().flat_map(|rgb| pack_halves(rgb.map(f16::to_bits))).collect(),
    }
}

/// Returns the number of words in which two pictures differ: 1 if their kinds differ, all words of the first if only their
/// sizes differ.
pub fn mismatched_words(one: &Picture, other: &Picture) -> u64 {
    if std::mem::discriminant(one) != std::mem::discriminant(other) {
        return 1;
    }
    let (one, other) = (words_of(one), words_of(other));
    if one.len() != other.len() {
        return one.len() as u64;
    }
    one.iter().zip(&other).filter(|(one, other)| one != other).count() as u64
}

/// Fills a rectangle (left, top, width, height) with background or 0.
pub fn leave_out(picture: &mut Picture, rect: [u32; 4]) {
    fn fill<T: Copy>(plane: &mut Plane<T>, [left, top, width, height]: [u32; 4], value: T) {
        (top..top + height).for_each(|y| plane.row_mut(y)[left as usize..(left + width) as usize].fill(value));
    }
    match picture {
        Picture::Depth(plane) => fill(plane, rect, BACKGROUND_CODE),
        Picture::Color8(plane) | Picture::Material(plane) => fill(plane, rect, [0; 3]),
        Picture::ColorHalf(plane) => fill(plane, rect, [f16::ZERO; 3]),
        Picture::Alpha(plane) => fill(plane, rect, 0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_that_differ_are_found() {
        let mut plane = Plane::filled(3, 2, 7u16);
        let one = Picture::Depth(plane.clone());
        assert_eq!(mismatched_words(&one, &one), 0);
        plane.row_mut(1)[2] = 8;
        plane.row_mut(0)[0] = 8;
        plane.row_mut(0)[1] = 8;
        assert_eq!(mismatched_words(&one, &Picture::Depth(plane)), 2);
        assert!(mismatched_words(&one, &Picture::Depth(Plane::filled(1, 1, 7))) > 0);
        assert!(mismatched_words(&one, &Picture::Material(Plane::filled(3, 2, [7; 3]))) > 0);
        // Infinities and NaNs are compared by their bits.
        let nan = Picture::ColorHalf(Plane::filled(1, 1, [f16::NAN; 3]));
        assert_eq!(mismatched_words(&nan, &nan), 0);
    }

    #[test]
    fn words_are_packed_and_come_back() {
        assert_eq!(pack_codes(&[1, 2, 3, 4, 5, 0xffff], 3), [0x2_0001, 3, 0x5_0004, 0xffff]);
        let mut codes = [0; 3];
        unpack_codes(&[0x2_0001, 0x7_0003], &mut codes);
        assert_eq!((codes, code_stride(3)), ([1, 2, 3], 2));
        assert_eq!(unpack_bytes(pack_bytes([1, 2, 255])), [1, 2, 255]);
        assert_eq!(pack_bytes([1, 2, 255]), 0xff_0201);
        assert_eq!(unpack_halves(pack_halves([0x7c00, 0xfc00, 3])), [0x7c00, 0xfc00, 3]);
    }
}
