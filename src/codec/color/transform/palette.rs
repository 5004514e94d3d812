//! Blocks of few colours: a palette and an index for each pixel (color.md 6.8).

use crate::color::transform::blocks::Shape;
use crate::color::transform::coder::Coder;
use crate::color::transform::contexts::{LATER_FRAME, LATER_PIXEL, LATER_ROW, PALETTE_COLOR, PALETTE_SIZE, PIXEL, ROW};

/// Maximum number of colours of a palette.
pub const MAX_COLORS: usize = 16;
/// Capacity of the colour cache.
pub const CACHED: usize = 15;

/// Keys of red, green and blue.
pub type Color = [i32; 3];

/// Colours of earlier palettes of a region, the latest first.
#[derive(Debug, Clone, Default)]
pub struct ColorCache {
    colors: [Color; CACHED],
    held: usize,
}

impl ColorCache {
    /// Returns the initial cache of a region: the payload's colours, at most [`CACHED`].
    pub fn new(colors: &[Color]) -> ColorCache {
        let mut cache = ColorCache { held: colors.len().min(CACHED), ..ColorCache::default() };
        for (slot, &color) in cache.colors.iter_mut().zip(colors) {
            *slot = color;
        }
        cache
    }

    fn place(&self, color: Color) -> Option<usize> {
        self.colors[..self.held].iter().position(|&held| held == color)
    }

    /// Moves a colour to the front. If it is new and the cache is full, the last colour is dropped.
    fn touch(&mut self, color: Color) {
        let place = self.place(color).unwrap_or(self.held.min(CACHED - 1));
        self.held = self.held.max(place + 1);
        self.colors[..=place].rotate_right(1);
        self.colors[0] = color;
    }
}

#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Palette {
    pub colors: Vec<Color>,
    /// Indices by frame, then row by row; empty for one colour.
    pub indices: Vec<u8>,
}

impl Palette {
    /// Codes a palette and its indices; a decoder calls it on an empty palette.
    pub fn code(&mut self, coder: &mut impl Coder, shape: Shape, cache: &mut ColorCache, key_bits: u32) {
        let count = coder.symbol(PALETTE_SIZE.first_context + shape.level, self.colors.len().wrapping_sub(1)) + 1;
        self.colors.reserve_exact(count.saturating_sub(self.colors.len()));
        self.colors.resize(count, [0; 3]);
        for color in &mut self.colors {
            let place = coder.symbol(PALETTE_COLOR.first_context, cache.place(*color).unwrap_or(CACHED));
            *color = match cache.colors.get(place) {
                Some(&color) => color,
                None => color.map(|key| coder.bits(key as u32, key_bits) as i32),
            };
        }
        self.colors.iter().rev().for_each(|&color| cache.touch(color));
        if count > 1 {
            self.code_indices(coder, shape);
        }
    }

    fn code_indices(&mut self, coder: &mut impl Coder, shape: Shape) {
        let (side, pixels) = (shape.side(), shape.pixels());
        self.indices.resize(pixels * shape.frames, 0);
        let index_bits = (self.colors.len() - 1).ilog2() + 1;
        let (first, later) = self.indices.split_at_mut(pixels);
        let mut repeats = false;
        for y in 0..side {
            if y > 0 {
                let (above, row) = first[(y - 1) * side..(y + 1) * side].split_at_mut(side);
                repeats = coder.flag(ROW.first_context + usize::from(repeats), above == row);
                if repeats {
                    row.copy_from_slice(above);
                    continue;
                }
            }
            for x in 0..side {
                let (context, neighbours) = Neighbours::of_first(first, [x, y], side);
                neighbours.code::<3>(coder, context, &mut first[y * side + x], index_bits);
            }
        }
        let mut before = first;
        let mut frame_repeats = false;
        for frame in later.chunks_exact_mut(pixels) {
            frame_repeats = coder.flag(LATER_FRAME.first_context + usize::from(frame_repeats), *frame == *before);
            if frame_repeats {
                frame.copy_from_slice(before);
                before = frame;
                continue;
            }
            let mut repeats = false;
            for y in 0..side {
                let row = y * side..(y + 1) * side;
                let same = frame[row.clone()] == before[row.clone()];
                repeats = coder.flag(LATER_ROW.first_context + usize::from(repeats), same);
                if repeats {
                    frame[row.clone()].copy_from_slice(&before[row]);
                    continue;
                }
                for x in 0..side {
                    let (context, neighbours) = Neighbours::of_later(frame, before, [x, y], side);
                    neighbours.code::<4>(coder, context, &mut frame[y * side + x], index_bits);
                }
            }
            before = frame;
        }
    }

    /// Returns the indices of a frame of the block; `None` for one colour.
    pub fn frame(&self, shape: Shape, frame: usize) -> Option<&[u8]> {
        let pixels = shape.pixels();
        self.indices.get(frame * pixels..(frame + 1) * pixels)
    }
}

/// Distinct indices that a pixel probably has, the most probable first.
struct Neighbours {
    indices: [u8; 3],
    count: usize,
}

impl Neighbours {
    fn distinct(candidates: &[u8]) -> Neighbours {
        let mut distinct = Neighbours { indices: [0; 3], count: 0 };
        for &index in candidates {
            if !distinct.indices[..distinct.count].contains(&index) {
                distinct.indices[distinct.count] = index;
                distinct.count += 1;
            }
        }
        distinct
    }

    fn of_first(frame: &[u8], [x, y]: [usize; 2], side: usize) -> (usize, Neighbours) {
        let at = y * side + x;
        let above = if y > 0 { Some(frame[at - side]) } else { None };
        let left = if x > 0 { Some(frame[at - 1]) } else { above }.unwrap_or(0);
        let above = above.unwrap_or(left);
        let above_left = if x > 0 && y > 0 { frame[at - side - 1] } else { above };
        let above_right = if y > 0 && x + 1 < side { frame[at - side + 1] } else { above };
        let equal = [left == above, above_left == left, above_left == above, above_right == above];
        (PIXEL.first_context + bits(equal), Neighbours::distinct(&[left, above]))
    }

    fn of_later(frame: &[u8], before: &[u8], [x, y]: [usize; 2], side: usize) -> (usize, Neighbours) {
        let at = y * side + x;
        let held = before[at];
        let above = if y > 0 { Some(frame[at - side]) } else { None };
        let left = if x > 0 { Some(frame[at - 1]) } else { above }.unwrap_or(held);
        let above = above.unwrap_or(left);
        let left_changed = x > 0 && frame[at - 1] != before[at - 1];
        let above_changed = y > 0 && frame[at - side] != before[at - side];
        let context = bits([left_changed, above_changed, left == held, above == held]);
        (LATER_PIXEL.first_context + context, Neighbours::distinct(&[held, left, above]))
    }

    /// Codes an index as that of a neighbour, or by the last of `SYMBOLS` symbols and raw bits.
    fn code<const SYMBOLS: usize>(&self, coder: &mut impl Coder, context: usize, index: &mut u8, index_bits: u32) {
        let known = &self.indices[..self.count];
        let place = known.iter().position(|known| known == index).unwrap_or(SYMBOLS - 1);
        *index = match known.get(coder.symbol(context, place)) {
            Some(&known) => known,
            None => coder.bits((*index).into(), index_bits) as u8,
        };
    }
}

fn bits(flags: [bool; 4]) -> usize {
    flags.iter().rev().fold(0, |bits, &flag| bits << 1 | usize::from(flag))
}
